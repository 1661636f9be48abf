//! A regression with likelier terms: without those that are more likely absent than not, and with others in place of its own.

use super::evidence::{TermEvidence, of_regression};
use super::exchange;
use super::rank::{BETTER, RankedModel};
use super::regress::Statistics;
use super::run::IdentificationRun;
use crate::solve::fit::Fit;
use crate::solve::sign::{self, Sign};
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::Piece;

/// A fit of one equation, and the evidence for its terms.
type Fitted = (Fit, Vec<TermEvidence>);

/// A model, and the evidence for the terms of each equation.
type WithEvidence = (RankedModel, Vec<Vec<TermEvidence>>);

/// What the terms of one equation are chosen from.
struct Rows<'s> {
    parts: &'s [Gram],
    total: Gram,
    signs: &'s [Sign],
    /// Share of the rows that are independent.
    independent: f64,
}

impl Rows<'_> {
    fn with_evidence(&self, fit: Fit) -> Fitted {
        let evidence = of_regression(&fit, self.parts, &self.total, self.independent);
        (fit, evidence)
    }

    fn on(&self, support: Vec<bool>, before: &Fit) -> Fit {
        let fit = Fit::on_support(&self.total, support, before.outcome, before.iterations);
        sign::kept(&self.total, fit, self.signs)
    }

    /// The fit without terms that are more likely absent than not: the one with the least evidence goes first, the others are
    /// fitted again, until the evidence for each is positive.
    fn without_doubtful(&self, mut fit: Fit) -> Fitted {
        loop {
            let (fitted, evidence) = self.with_evidence(fit);
            let Some(least) = least_evident(&fitted.support, &evidence) else {
                return (fitted, evidence);
            };
            let mut support = fitted.support.clone();
            support[least] = false;
            fit = self.on(support, &fitted);
        }
    }

    /// The fit with likelier terms in place of its own: the likeliest exchange, then those terms of it that are not doubtful, until
    /// none is likelier.
    fn exchanged(&self, (mut fit, mut evidence): Fitted) -> Fitted {
        loop {
            let all = exchange::of_regression(&fit, self.signs, &self.total, &evidence);
            let likelier = all.iter().filter(|e| exchange::is_likelier(e));
            let Some(best) = likelier.min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
                return (fit, evidence);
            };
            let mut support = fit.support.clone();
            best.dropped.iter().for_each(|&k| support[k] = false);
            best.added.iter().for_each(|&j| support[j] = true);
            let other = self.without_doubtful(self.on(support, &fit));
            let fewer = other.0.terms() < fit.terms();
            // Rounding and signs must not lead it back.
            if !fewer && other.0.residual_sum >= fit.residual_sum {
                return (fit, evidence);
            }
            (fit, evidence) = other;
        }
    }
}

impl IdentificationRun<'_> {
    /// The model without doubtful terms, and with likelier ones in place of its own. Where no simulation can follow it without the
    /// doubtful terms, they stay; where it predicts worse in free run with the likelier ones, it keeps its own.
    pub(super) fn likelier_regression(
        &self,
        model: &RankedModel,
        from: &Statistics,
        yardstick: &[Piece<'_>],
    ) -> WithEvidence {
        let equations = from.grams.iter().zip(&self.signs);
        let rows: Vec<Rows<'_>> = equations
            .map(|(parts, signs)| Rows {
                parts,
                total: Gram::total(parts),
                signs,
                independent: from.independent,
            })
            .collect();
        let ranked = |fitted: Vec<Fitted>| {
            let mut regression = model.regression.clone();
            let (fits, evidence) = fitted.into_iter().unzip();
            regression.fits = fits;
            let ranked = RankedModel::new(regression, &self.system, yardstick, &self.noise.sigma);
            (ranked, evidence)
        };
        let fits = || model.regression.fits.iter().cloned().zip(&rows);
        let mut fitted: Vec<Fitted> = fits()
            .map(|(fit, rows)| rows.without_doubtful(fit))
            .collect();
        let mut kept = ranked(fitted.clone());
        if !kept.0.free_run.is_finite() && model.free_run.is_finite() {
            fitted = fits().map(|(fit, rows)| rows.with_evidence(fit)).collect();
            kept = ranked(fitted.clone());
        }
        // Under invariants a candidate is no column of the regression.
        if self.conserved.is_none() {
            let fits = fitted.into_iter().zip(&rows);
            let other = ranked(fits.map(|(fitted, rows)| rows.exchanged(fitted)).collect());
            if BETTER * other.0.free_run <= kept.0.free_run {
                kept = other;
            }
        }
        kept
    }
}

/// The term of the support that is most likely absent, if any is more likely absent than not.
fn least_evident(support: &[bool], evidence: &[TermEvidence]) -> Option<usize> {
    (0..support.len())
        .filter(|&j| support[j] && evidence[j].evidence < 0.0)
        .min_by(|&a, &b| evidence[a].evidence.total_cmp(&evidence[b].evidence))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::solve::outcome::Outcome;
    use crate::{Library, Samples};

    /// y = 2 a and noise of 0.29, in groups of 50 rows; b differs from a by up to `apart`.
    fn twins(apart: f64) -> Vec<Gram> {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        let mut samples = Samples::new(&["a", "b", "y"]);
        for _ in 0..8 {
            let a: Vec<f64> = (0..50).map(|_| rng.random_range(-1.0..1.0)).collect();
            let b = a.iter().map(|a| a + apart * rng.random_range(-1.0..1.0));
            let b = b.collect();
            let y = a.iter().map(|a| 2.0 * a + rng.random_range(-0.5..0.5));
            let y = y.collect();
            samples.push_group(vec![a, b, y]).unwrap();
        }
        let library = Library::parse(&["1", "a", "b"]).unwrap();
        Gram::accumulate(&library, "y", &samples).unwrap()
    }

    fn rows(parts: &[Gram]) -> Rows<'_> {
        Rows {
            parts,
            total: Gram::total(parts),
            signs: &[],
            independent: 1.0,
        }
    }

    fn support(fit: &Fit) -> Vec<usize> {
        (0..fit.support.len()).filter(|&j| fit.support[j]).collect()
    }

    #[test]
    fn analytic_of_two_doubtful_twins_one_stays() {
        let parts = twins(0.01);
        let rows = rows(&parts);
        let fit = Fit::on_support(&rows.total, vec![true; 3], Outcome::Converged, 1);
        let (fit, before) = rows.with_evidence(fit);
        assert!(before.iter().all(|e| e.evidence < 0.0), "{before:?}");
        let (kept, after) = rows.without_doubtful(fit);
        let left = support(&kept);
        assert!(left == [1] || left == [2], "{left:?}");
        // Seven degrees of freedom and |z| of about 100: 8 ln(100² / 7) - ln 400 - 2 ln 3 = 50.
        assert!(after[left[0]].evidence > 30.0, "{after:?}");
        // 400 rows with an error of 0.29: four standard errors of 0.025.
        assert!((kept.coefficients[left[0]] - 2.0).abs() < 0.1);
    }

    #[test]
    fn analytic_a_term_that_is_like_the_true_one_gives_its_place_to_it() {
        // b by itself leaves 2 (b - a) more, a variance of 4 x 0.3² / 3 = 0.12 beside the noise's 0.083.
        let parts = twins(0.3);
        let mut rows = rows(&parts);
        let fit = Fit::on_support(&rows.total, vec![false, false, true], Outcome::Converged, 1);
        let before = fit.residual_sum;
        let (kept, evidence) = rows.exchanged(rows.with_evidence(fit.clone()));
        assert_eq!(support(&kept), [1]);
        assert!(kept.residual_sum < before && evidence[1].evidence > 0.0);
        // A sign that only b can have keeps it.
        rows.signs = &[Sign::Any, Sign::Negative, Sign::Any];
        let (kept, _) = rows.exchanged(rows.with_evidence(fit));
        assert_eq!(support(&kept), [2]);
    }
}
