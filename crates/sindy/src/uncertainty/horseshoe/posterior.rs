//! The posterior of a horseshoe regression, by its draws.

use nalgebra::{DMatrix, DVector};

use super::chain::Chain;
use super::conditional::Statistics;
use super::diagnostics::{Diagnostic, FEWEST_EFFECTIVE_A_CHAIN, MOST_R_HAT};
use crate::error::SindyError;
use crate::library::Library;
use crate::model::Term;
use crate::numerics::quantile;
use crate::solve::fit::Fit;
use crate::solve::outcome::Outcome;
use crate::statistics::gram::Gram;

/// The posterior distribution of one quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marginal {
    /// Posterior mean.
    pub mean: f64,
    /// Posterior standard deviation.
    pub sd: f64,
    /// Posterior median.
    pub median: f64,
    /// Lower end of the credible interval with equal tails.
    pub lower: f64,
    /// Upper end of it.
    pub upper: f64,
    /// R̂ and effective sample size.
    pub diagnostic: Diagnostic,
}

/// The posterior of the coefficients of one target, p each.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// Each coefficient, in units of the target over units of its term.
    pub marginals: Vec<Marginal>,
    /// Posterior means of the shrinkage factors κ_j in [0, 1]. Given the scales, the coefficient's mean is (1 - κ_j) times the
    /// estimate that it would have without a prior of its own: 0 is a term that the data determine, 1 one that the prior
    /// holds at zero. `1 - κ_j` is used as the probability of inclusion (Carvalho et al.).
    pub shrinkage: DVector<f64>,
    /// Which terms are selected: κ_j below 1/2, and zero outside the credible interval.
    pub selected: Vec<bool>,
    /// Draws of the coefficients, p x (chains x draws), chain after chain.
    pub draws: DMatrix<f64>,
    /// Draws of λ, alike.
    pub local_scales: DMatrix<f64>,
}

/// The posterior of a horseshoe regression.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// One for each target.
    pub targets: Vec<Coefficients>,
    /// τ, the global scale, in the unit of the prior (see [`Horseshoe`](super::Horseshoe)); its diagnostic is that of ln τ.
    pub global_scale: Marginal,
    /// c², the slab's variance, in the unit of the prior squared; its diagnostic is that of ln c².
    pub slab_variance: Marginal,
    /// σ, the noise, in the target's unit; with several scaled targets as a share of each one's root mean square.
    pub noise: Marginal,
    /// Draws of τ, c² and σ, chain after chain.
    pub scales: [Vec<f64>; 3],
    /// Chains.
    pub chains: usize,
    /// [`Outcome::Converged`] if every quantity has an R̂ of at most 1.01 and an effective sample size of at least 100 for each
    /// chain; [`Outcome::IterationLimit`] if not, see [`Posterior::warning`].
    pub outcome: Outcome,
}

impl Posterior {
    pub(super) fn new(chains: &[Chain], statistics: &[Statistics], level: f64) -> Self {
        let count = chains.len();
        let summary = |draws: &[f64]| Marginal::of(draws, count, level);
        let scale = |k: usize, power: f64| {
            let logs = chains.iter().flat_map(|c| c.logs[k].iter());
            logs.map(|l| (power * l).exp()).collect::<Vec<f64>>()
        };
        // One scaled target has its noise in its own unit.
        let noise_unit = match statistics {
            [one] => one.noise_unit,
            _ => 1.0,
        };
        let noise = scale(2, 1.0).iter().map(|s| s * noise_unit).collect();
        let scales = [scale(0, 1.0), scale(1, 1.0), noise];
        let targets: Vec<Coefficients> = statistics
            .iter()
            .enumerate()
            .map(|(i, s)| Coefficients::new(chains, i, &s.unit, level))
            .collect();
        let mut out = Self {
            global_scale: summary(&scales[0]),
            slab_variance: summary(&scales[1]),
            noise: summary(&scales[2]),
            targets,
            scales,
            chains: count,
            outcome: Outcome::Converged,
        };
        if !out.diagnostics().all(|(_, d)| d.is_good(count)) {
            out.outcome = Outcome::IterationLimit;
        }
        out
    }

    /// Every quantity and its diagnostic.
    fn diagnostics(&self) -> impl Iterator<Item = (String, Diagnostic)> {
        let scales = [
            ("tau", &self.global_scale),
            ("c^2", &self.slab_variance),
            ("sigma", &self.noise),
        ];
        let scales = scales.map(|(name, m)| (name.to_owned(), m.diagnostic));
        let coefficients = self.targets.iter().enumerate().flat_map(|(i, target)| {
            let each = target.marginals.iter().enumerate();
            each.map(move |(j, m)| (format!("coefficient {j} of target {i}"), m.diagnostic))
        });
        scales.into_iter().chain(coefficients)
    }

    /// What keeps the chains from counting as converged: the worst R̂ and the smallest effective sample size; none if they
    /// converged.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        if self.outcome == Outcome::Converged {
            return None;
        }
        // Too few draws have no diagnostics: NaN counts as worst.
        let r_hat = |d: &Diagnostic| {
            if d.r_hat.is_nan() {
                f64::INFINITY
            } else {
                d.r_hat
            }
        };
        let (name, worst) = self
            .diagnostics()
            .max_by(|a, b| r_hat(&a.1).total_cmp(&r_hat(&b.1)))?;
        let (rarest, fewest) = self
            .diagnostics()
            .min_by(|a, b| a.1.effective_draws.total_cmp(&b.1.effective_draws))?;
        Some(format!(
            "the chains have not converged: the largest R-hat is {:.3}, of {name} (expected at most {MOST_R_HAT}), the smallest \
             effective sample size {:.0}, of {rarest} (expected at least {:.0}). Take more draws; if that does not help, terms \
             of the library depend on each other",
            worst.r_hat,
            fewest.effective_draws,
            FEWEST_EFFECTIVE_A_CHAIN * self.chains as f64,
        ))
    }

    /// The sparse fit of target `i`: posterior means of the selected terms, 0 for the others. They are not refitted.
    ///
    /// # Errors
    /// No such target, or statistics of another number of terms.
    pub fn fit(&self, i: usize, gram: &Gram) -> Result<Fit, SindyError> {
        let target = self.target(i, gram.xty.len())?;
        let coefficients = target.sparse();
        let support = target.selected.clone();
        let outcome = match self.outcome {
            Outcome::Converged if !support.contains(&true) => Outcome::Empty,
            outcome => outcome,
        };
        let draws = self.scales[0].len();
        Ok(Fit::new(gram, coefficients, support, outcome, draws))
    }

    /// The selected terms of target `i`, for a [`Model`](crate::Model): the posterior mean as coefficient, the posterior
    /// standard deviation as standard error, 1 - κ as inclusion.
    ///
    /// # Errors
    /// No such target, or a library of another number of terms.
    pub fn terms(&self, i: usize, library: &Library) -> Result<Vec<Term>, SindyError> {
        let target = self.target(i, library.len())?;
        let kept = (0..library.len()).filter(|&j| target.selected[j]);
        kept.map(|j| {
            let Marginal { mean, sd, .. } = target.marginals[j];
            let inclusion = (1.0 - target.shrinkage[j]).clamp(0.0, 1.0);
            let term = Term::parse(&library.names()[j], mean)?;
            Ok(term.with_std_error(sd).with_inclusion(inclusion))
        })
        .collect()
    }

    fn target(&self, i: usize, terms: usize) -> Result<&Coefficients, SindyError> {
        let target = self.targets.get(i).ok_or_else(|| {
            SindyError::setting("target", format!("below {}", self.targets.len()), i)
        })?;
        crate::error::same_size("terms of the posterior", terms, target.marginals.len())?;
        Ok(target)
    }
}

impl Coefficients {
    fn new(chains: &[Chain], i: usize, unit: &DVector<f64>, level: f64) -> Self {
        let all = |of: fn(&super::chain::TargetChain) -> &DMatrix<f64>| {
            let parts: Vec<&DMatrix<f64>> = chains.iter().map(|c| of(&c.targets[i])).collect();
            let columns: Vec<_> = parts.iter().flat_map(|m| m.column_iter()).collect();
            DMatrix::from_columns(&columns)
        };
        let mut draws = all(|c| &c.beta);
        draws
            .column_iter_mut()
            .for_each(|mut c| c.component_mul_assign(unit));
        let (means, variances) = (all(|c| &c.mean), all(|c| &c.variance));
        // The mean and the variance over the draws' normal distributions have less Monte Carlo error than those of the draws.
        let mean = means.column_mean();
        let variance = variances.column_mean() + means.column_variance();
        let shrinkage = all(|c| &c.shrinkage).column_mean();
        let marginals: Vec<Marginal> = (0..unit.len())
            .map(|j| {
                let own: Vec<f64> = draws.row(j).iter().copied().collect();
                Marginal {
                    mean: mean[j] * unit[j],
                    sd: variance[j].sqrt() * unit[j],
                    ..Marginal::of(&own, chains.len(), level)
                }
            })
            .collect();
        let selected = marginals
            .iter()
            .zip(&shrinkage)
            .map(|(m, kappa)| *kappa < 0.5 && (m.lower > 0.0 || m.upper < 0.0))
            .collect();
        Self {
            marginals,
            shrinkage,
            selected,
            draws,
            local_scales: all(|c| &c.lambda),
        }
    }

    /// Posterior means of the selected terms, 0 for the others.
    #[must_use]
    pub fn sparse(&self) -> DVector<f64> {
        let chosen = self.marginals.iter().zip(&self.selected);
        let means = chosen.map(|(m, selected)| if *selected { m.mean } else { 0.0 });
        DVector::from_iterator(self.selected.len(), means)
    }
}

impl Marginal {
    /// Of draws of `chains` chains, one after the other.
    fn of(draws: &[f64], chains: usize, level: f64) -> Self {
        let mut sorted = draws.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = draws.len() as f64;
        let mean = draws.iter().sum::<f64>() / n;
        let squares: f64 = draws.iter().map(|v| (v - mean).powi(2)).sum();
        let tail = 0.5 * (1.0 - level);
        Self {
            mean,
            sd: (squares / n).sqrt(),
            median: quantile(&sorted, 0.5),
            lower: quantile(&sorted, tail),
            upper: quantile(&sorted, 1.0 - tail),
            diagnostic: Diagnostic::of(draws, chains),
        }
    }
}
