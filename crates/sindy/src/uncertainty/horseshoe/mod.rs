//! Sparse Bayesian regression: coefficients under the regularised horseshoe prior, by Markov chains.
//!
//! The model is that of PySINDy's `SBR`, `y ~ N(Θ β, σ²)` with the [`Prior`] of β and σ. The sampler reads the statistics of
//! the rows alone ([`Gram`]), so that 10⁶ rows cost as much as 100: a step is some thirty factorisations of a p x p matrix. It
//! integrates the coefficients out while it draws their scales, so that draws are nearly independent of one another.
//!
//! ```
//! use sindy::uncertainty::Horseshoe;
//! use sindy::{Gram, Library, Samples};
//!
//! let x: Vec<f64> = (0..200).map(|i| (0.37 * f64::from(i)).sin()).collect();
//! let y = x.iter().enumerate().map(|(i, x)| 2.0 * x + 0.1 * (i as f64 * i as f64).sin()).collect();
//! let mut samples = Samples::new(&["x", "y"]);
//! samples.push_group(vec![x, y])?;
//! let gram = Gram::total(&Gram::accumulate(&Library::parse(&["1", "x", "x^2"])?, "y", &samples)?);
//!
//! let posterior = Horseshoe::new(1).sample(&[gram])?;
//! assert_eq!(posterior.warning(), None);
//! let found = &posterior.targets[0];
//! assert_eq!(found.selected, [false, true, false]);
//! assert!(found.marginals[1].lower < 2.0 && 2.0 < found.marginals[1].upper);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Rows count as independent. Residuals of a dynamical fit are correlated from row to row, and intervals are then too narrow, as
//! those of every method that sees the rows one by one: a [`Bootstrap`](super::Bootstrap) over blocks heeds the correlation.
//!
//! Sources: as [`Prior`]; C. M. Carvalho, N. G. Polson, J. G. Scott, "The horseshoe estimator for sparse signals", Biometrika 97
//! (2010), and J. Datta, J. K. Ghosh, "Asymptotic properties of Bayes risk for the horseshoe prior", Bayesian Analysis 8 (2013),
//! for the selection by κ; S. van der Pas, B. Szabó, A. van der Vaart, "Uncertainty quantification for the horseshoe", Bayesian
//! Analysis 12 (2017), for that by intervals.

mod chain;
mod conditional;
mod diagnostics;
mod posterior;
mod prior;
mod slice;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

pub use diagnostics::Diagnostic;
pub use posterior::{Coefficients, Marginal, Posterior};
pub use prior::Prior;

use self::chain::Target;
use self::conditional::Statistics;
use crate::error::{SindyError, require};
use crate::solve::fit::{Fit, Solver};
use crate::solve::sr3::Scaling;
use crate::statistics::gram::{Gram, check};
use crate::uncertainty::resample::generator;

/// Settings of a horseshoe regression, checked when built.
///
/// As a [`Solver`] it gives posterior means of the terms that it selects, and [`Outcome::IterationLimit`](crate::Outcome) where
/// the chains have not converged. A term is selected if both hold:
///
/// - its shrinkage factor κ has a posterior mean below 1/2. This is the rule of Carvalho et al.; under sparsity its risk is that
///   of the best rule but for a constant (Datta, Ghosh), where τ follows the share of terms that are there;
/// - its credible interval excludes 0. With few candidates τ stays so large that noise alone brings κ below 1/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Horseshoe {
    prior: Prior,
    scaling: Scaling,
    chains: usize,
    warm_up: usize,
    draws: usize,
    level: f64,
    seed: u64,
}

impl Horseshoe {
    /// The default prior in scaled units, four chains of 1000 draws after 500 steps of warm-up, 95 % intervals.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            prior: Prior::default(),
            scaling: Scaling::UnitRms,
            chains: 4,
            warm_up: 500,
            draws: 1000,
            level: 0.95,
            seed,
        }
    }

    /// The same with another prior.
    #[must_use]
    pub fn prior(self, prior: Prior) -> Self {
        Self { prior, ..self }
    }

    /// The same with another scaling. With [`Scaling::UnitRms`] the prior is that of coefficients of columns and target divided by
    /// their root mean square, and σ is a share of the target's. With [`Scaling::None`] it is in the units of the data, as
    /// PySINDy's.
    #[must_use]
    pub fn scaling(self, scaling: Scaling) -> Self {
        Self { scaling, ..self }
    }

    /// The same with another number of chains.
    ///
    /// # Errors
    /// No chains.
    pub fn chains(self, chains: usize) -> Result<Self, SindyError> {
        require(chains > 0, "chains", "at least 1", chains)?;
        Ok(Self { chains, ..self })
    }

    /// The same with another number of steps before the draws of each chain.
    #[must_use]
    pub fn warm_up(self, steps: usize) -> Self {
        Self {
            warm_up: steps,
            ..self
        }
    }

    /// The same with another number of draws of each chain.
    ///
    /// # Errors
    /// No draws.
    pub fn draws(self, draws: usize) -> Result<Self, SindyError> {
        require(draws > 0, "draws", "at least 1", draws)?;
        Ok(Self { draws, ..self })
    }

    /// The same with credible intervals of this probability.
    ///
    /// # Errors
    /// Not between 0 and 1.
    pub fn level(self, level: f64) -> Result<Self, SindyError> {
        let inside = level > 0.0 && level < 1.0;
        require(inside, "level", "between 0 and 1", level)?;
        Ok(Self { level, ..self })
    }

    /// The posterior of the coefficients of every target. All targets share τ, c² and σ, as in PySINDy; for a noise of its own,
    /// sample each target by itself. Libraries may differ. Weighted rows have the variance `σ²/w`.
    ///
    /// The draws depend on the seed alone: they are the same for any number of threads.
    ///
    /// # Errors
    /// No targets; statistics that no solver can use.
    pub fn sample(&self, targets: &[Gram]) -> Result<Posterior, SindyError> {
        if targets.is_empty() {
            return Err(SindyError::shape("targets (at least)", 1, 0));
        }
        targets.iter().try_for_each(check)?;
        let statistics: Vec<Statistics> = targets
            .iter()
            .map(|gram| Statistics::new(gram, self.scaling))
            .collect();
        let target = Target {
            statistics: &statistics,
            prior: &self.prior,
        };
        let chains: Vec<_> = (0..self.chains)
            .into_par_iter()
            .map(|c| target.run(self.warm_up, self.draws, &mut generator(self.seed, c)))
            .collect();
        Ok(Posterior::new(&chains, &statistics, self.level))
    }
}

impl Solver for Horseshoe {
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError> {
        self.sample(std::slice::from_ref(gram))?.fit(0, gram)
    }
}
