//! The evidence for each term: standard error, degrees of freedom, and the fall of the log-likelihood without it.

use super::exchange;
use crate::solve::fit::Fit;
use crate::statistics::criteria::evidence_for;
use crate::statistics::gram::Gram;
use crate::statistics::regression::{ClusterErrors, pseudo_inverse, student_95};
use crate::trajectory::output_error::OutputErrorFit;

/// The evidence for one coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TermEvidence {
    pub std_error: f64,
    /// Degrees of freedom of the standard error.
    pub degrees: f64,
    /// Independent rows that it rests on.
    pub rows: f64,
    /// The evidence for the term: twice the fall of the log-likelihood without it, less the penalty for it.
    pub evidence: f64,
    /// Odds of models with another term in its place against the model.
    pub exchanged: f64,
}

impl TermEvidence {
    /// That of a term which is not in the model.
    pub(super) const NONE: Self = Self {
        std_error: 0.0,
        degrees: 0.0,
        rows: 0.0,
        evidence: 0.0,
        exchanged: 0.0,
    };

    /// That of candidate `j`. Correlated residuals hold the information of fewer independent ones: standard errors grow by
    /// the root of the factor, and what a term is worth falls by the factor itself.
    pub(super) fn of_output_error(found: &OutputErrorFit, j: usize) -> Self {
        let independent = 1.0 / found.correlation;
        let terms = found.coefficients.iter().filter(|c| **c != 0.0).count() as f64;
        Self {
            std_error: found.std_errors[j] / independent.sqrt(),
            degrees: (found.values as f64 * independent - terms).max(1.0),
            rows: found.values as f64 * independent,
            evidence: (found.evidence[j] + found.penalty) * independent
                - (found.penalty + independent.ln()),
            exchanged: exchange::odds(&exchange::of_output_error(found), j),
        }
    }

    /// The probability that the term is present, beside models without it and with another one in its place: odds are exp(Δ/2) for
    /// twice the log-likelihood that is lost.
    pub(super) fn inclusion(self) -> f64 {
        1.0 / (1.0 + (-0.5 * self.evidence).exp() + self.exchanged)
    }

    pub(super) fn interval(self, value: f64) -> Option<[f64; 2]> {
        let half = student_95(self.degrees) * self.std_error;
        half.is_finite().then_some([value - half, value + half])
    }
}

/// Intervals of the coefficients that are not zero.
pub(super) fn intervals(coefficients: &[f64], evidence: &[TermEvidence]) -> Vec<Option<[f64; 2]>> {
    let all = coefficients.iter().zip(evidence);
    all.filter(|(c, _)| **c != 0.0)
        .map(|(c, evidence)| evidence.interval(*c))
        .collect()
}

/// Of every term of a regression: standard errors over blocks (or widened for neighbouring slopes, where there are no more
/// blocks than terms), and what it is worth by the Bayesian criterion.
///
/// The rows that count for the penalty are those that would give this error if they were independent.
pub(super) fn of_regression(
    fit: &Fit,
    parts: &[Gram],
    total: &Gram,
    independent: f64,
) -> Vec<TermEvidence> {
    let mut out = vec![TermEvidence::NONE; fit.support.len()];
    let index: Vec<usize> = (0..fit.support.len()).filter(|&j| fit.support[j]).collect();
    if index.is_empty() {
        return out;
    }
    let rows = total.rows as f64;
    let variance = fit.residual_sum / rows.max(1.0);
    let scale = |j: usize| total.xtx[(j, j)].sqrt();
    let k = index.len();
    let inverse = pseudo_inverse(&nalgebra::DMatrix::from_fn(k, k, |a, b| {
        total.xtx[(index[a], index[b])] / scale(index[a]) / scale(index[b])
    }));
    let clustered = ClusterErrors::new(parts, &fit.coefficients, &fit.support);
    for (a, &j) in index.iter().enumerate() {
        let plain = (inverse[(a, a)] * variance).sqrt() / scale(j);
        let counted = (rows * independent).max(1.0);
        let (std_error, degrees, counted) = match &clustered {
            Some(c) if c.std_errors[j].is_finite() => {
                let widened = (c.std_errors[j] / plain).powi(2).max(1.0);
                (c.std_errors[j], c.degrees[j], (rows / widened).max(1.0))
            }
            _ => {
                let spare = (counted - k as f64).max(1.0);
                (plain * (rows / spare).sqrt(), spare, counted)
            }
        };
        let square = (fit.coefficients[j] / std_error.max(f64::MIN_POSITIVE)).powi(2);
        out[j] = TermEvidence {
            std_error,
            degrees,
            rows: counted,
            evidence: evidence_for(square, degrees, counted, fit.support.len()),
            exchanged: 0.0,
        };
    }
    out
}

#[cfg(test)]
pub(super) mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::solve::outcome::Outcome;
    use crate::trajectory::output_error::Trace;
    use crate::{Library, Samples};

    /// A fit of 1000 values. Each coefficient has the standard error 0.25.
    pub(in crate::identify) fn found(
        coefficients: Vec<f64>,
        evidence: Vec<f64>,
        correlation: f64,
    ) -> OutputErrorFit {
        OutputErrorFit {
            std_errors: vec![0.25; coefficients.len()],
            coefficients,
            covariance: nalgebra::DMatrix::zeros(1, 1),
            evidence,
            penalty: 1000_f64.ln() + 1.0,
            sigma: vec![1.0],
            colour: Vec::new(),
            disturbance: None,
            fronts: Vec::new(),
            exchanges: Vec::new(),
            multiples: Vec::new(),
            correlation,
            score: 0.0,
            arcs: 1,
            values: 1000,
            iterations: 1,
            outcome: Outcome::Converged,
            trace: Trace::default(),
        }
    }

    #[test]
    fn analytic_correlated_residuals_count_as_fewer_independent_ones() {
        let found = |correlation: f64| {
            let evidence = vec![-5.0, 64.0 - (1000_f64.ln() + 1.0)];
            found(vec![0.0, 2.0], evidence, correlation)
        };
        let plain = TermEvidence::of_output_error(&found(1.0), 1);
        assert_eq!((plain.std_error, plain.degrees), (0.25, 999.0));
        // z² = 64, as the evidence says without its penalty: the two are one number.
        assert!((plain.evidence - (64.0 - 1000_f64.ln() - 1.0)).abs() < 1e-12);
        let wide = TermEvidence::of_output_error(&found(16.0), 1);
        assert_eq!((wide.std_error, wide.degrees), (1.0, 61.5));
        // 1000 values that count as 62.5, and a z of 2: hardly worth its penalty.
        assert!((wide.evidence - (4.0 - 62.5_f64.ln() - 1.0)).abs() < 1e-12);
        // Student's t with 61.5 degrees of freedom at 97.5 %: 1.99917 (between tables' 1.99962 and 1.99897).
        let [low, high] = wide.interval(2.0).unwrap();
        assert!(((high - low) / 2.0 - 1.9993).abs() < 5e-4);
    }

    /// `y` on `1, a` with noise that wanders (0.95 from row to row) through one record cut into `groups`; `a` is no term.
    fn draw(seed: u64, groups: usize) -> (Vec<Gram>, Fit) {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut samples = Samples::new(&["a", "y"]);
        let (mut noise, phase) = (0.0, rng.random_range(0.0..6.0));
        let mut next = || {
            noise = 0.95 * noise + (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
            noise
        };
        (0..200).for_each(|_| {
            next();
        });
        for g in 0..groups {
            let a = |i: usize| (0.05 * (100 * g + i) as f64 + phase).sin();
            samples
                .push_group(vec![
                    (0..100).map(a).collect(),
                    (0..100).map(|_| 1.0 + next()).collect(),
                ])
                .unwrap();
        }
        let library = Library::parse(&["1", "a"]).unwrap();
        let grams = Gram::accumulate(&library, "y", &samples).unwrap();
        let total = Gram::total(&grams);
        let fit = Fit::on_support(&total, vec![true; 2], Outcome::Converged, 1);
        (grams, fit)
    }

    #[test]
    fn analytic_a_term_that_is_none_is_seldom_worth_its_place() {
        for groups in [2, 5, 10] {
            let (mut kept, mut naive, mut held) = (0, 0, 0);
            for seed in 0..300 {
                let (parts, fit) = draw(seed, groups);
                let total = Gram::total(&parts);
                // Of this noise (1 - 0.95)/(1 + 0.95) of the rows count: one in 39.
                let evidence = of_regression(&fit, &parts, &total, 1.0 / 39.0)[1];
                kept += usize::from(evidence.evidence > 0.0);
                let [low, high] = evidence.interval(fit.coefficients[1]).unwrap();
                held += usize::from(low <= 0.0 && 0.0 <= high);
                let plain = of_regression(&fit, &parts[..1], &total, 1.0)[1];
                naive += usize::from(plain.evidence > 0.0);
            }
            // By the Bayesian criterion over 5 to 26 rows that count a term of nothing is kept in 7 to 20 % of draws; as if
            // all rows counted, far more often.
            assert!(kept < 75 && naive > 2 * kept, "{groups}: {kept} {naive}");
            // 300 draws of a share of 0.95 scatter by 0.013: three of them; the rows that count are known to a factor.
            assert!((273..=300).contains(&held), "{groups}: {held}");
        }
    }
}
