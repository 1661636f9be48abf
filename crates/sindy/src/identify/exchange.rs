//! Other terms that are about as likely: in place of one or two, or beside them.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::evidence::TermEvidence;
use super::rank::RankedModel;
use super::regress::Statistics;
use super::run::IdentificationRun;
use crate::solve::fit::Fit;
use crate::solve::sign::Sign;
use crate::statistics::criteria::TWENTY_TO_ONE;
use crate::statistics::gram::Gram;
use crate::trajectory::output_error::{Exchange, OutputErrorFit, exchange};

/// Exchanges that a warning names for each equation, the likeliest.
const NAMED: usize = 4;
/// Odds that are as good as certain: larger ones are not written out.
const SURE: f64 = 1000.0;
/// Twice the logarithm of odds of 1.05 to 1, which are written as 1.0 to 1.
const SAME: f64 = 0.0976;
/// Level at which terms that are left out are tested, all of a fit together.
const LEVEL: f64 = 0.05;

/// Odds of all exchanges of candidate `j` against the model.
pub(super) fn odds(exchanges: &[Exchange], j: usize) -> f64 {
    let own = exchanges.iter().filter(|e| e.dropped.contains(&j));
    own.map(|e| (-0.5 * e.cost).exp()).sum()
}

/// The exchanges of an output error fit. Correlated residuals hold the information of fewer independent ones.
pub(super) fn of_output_error(found: &OutputErrorFit) -> Vec<Exchange> {
    let of = |e: &Exchange| Exchange {
        cost: e.cost / found.correlation,
        ..e.clone()
    };
    found.exchanges.iter().map(of).collect()
}

/// The terms that are left out although each is significant among all that are: the data ask for it, and only the penalty is against
/// it. A model that lacks nothing has one in [`LEVEL`] of the fits at most, where residuals are independent and normal.
fn additions(found: &OutputErrorFit, has_sign: &[bool]) -> Vec<Exchange> {
    let absent: Vec<usize> = (0..found.coefficients.len())
        .filter(|&j| found.coefficients[j] == 0.0 && !has_sign[j])
        .collect();
    let Ok(chi) = ChiSquared::new(1.0) else {
        return Vec::new();
    };
    let penalty = found.penalty - found.correlation.ln();
    let of = |&j: &usize| {
        let gain = (found.evidence[j] + found.penalty) / found.correlation;
        (absent.len() as f64 * chi.sf(gain) < LEVEL).then(|| Exchange {
            dropped: Vec::new(),
            added: vec![j],
            cost: penalty - gain,
        })
    };
    absent.iter().filter_map(of).collect()
}

/// Whether the model with other terms is likelier, by more than what odds of one digit show.
pub(super) fn is_likelier(exchange: &Exchange) -> bool {
    exchange.cost < -SAME
}

/// The exchanges of a regression, each over the rows that count for its terms; of two, the fewer.
pub(super) fn of_regression(
    fit: &Fit,
    signs: &[Sign],
    total: &Gram,
    evidence: &[TermEvidence],
) -> Vec<Exchange> {
    let left = fit.residual_sum.max(f64::MIN_POSITIVE);
    let of = |e: Exchange| {
        let rows = e.dropped.iter().map(|&k| evidence[k].rows);
        let rows = rows.fold(f64::INFINITY, f64::min);
        // Where nothing would be left, rounding of dependent terms has taken it.
        (e.cost > -left).then(|| Exchange {
            cost: rows * (e.cost / left).ln_1p(),
            ..e
        })
    };
    let all = exchange::of_regression(total, &fit.coefficients, fit.residual_sum, signs);
    all.into_iter().filter_map(of).collect()
}

impl IdentificationRun<'_> {
    /// The exchanges of regressions of all equations, which the evidence for the terms then counts: those that are not likelier.
    pub(super) fn exchanges(
        &self,
        model: &RankedModel,
        from: &Statistics,
        evidence: &mut [TermEvidence],
    ) -> Vec<Exchange> {
        // Under invariants a candidate is no column of the regression.
        if self.conserved.is_some() {
            return Vec::new();
        }
        let mut out = Vec::new();
        let mut first = 0;
        let fits = model.regression.fits.iter().zip(&from.grams);
        for ((fit, parts), signs) in fits.zip(&self.signs) {
            let own = &mut evidence[first..first + fit.support.len()];
            let exchanges = of_regression(fit, signs, &Gram::total(parts), own);
            let alike: Vec<Exchange> = exchanges
                .iter()
                .filter(|e| !is_likelier(e))
                .cloned()
                .collect();
            for (j, evidence) in own.iter_mut().enumerate() {
                evidence.exchanged = odds(&alike, j);
            }
            out.extend(exchanges.into_iter().map(|e| Exchange {
                dropped: e.dropped.iter().map(|k| first + k).collect(),
                added: e.added.iter().map(|k| first + k).collect(),
                ..e
            }));
            first += fit.support.len();
        }
        out
    }

    /// What [`as_likely`](Self::as_likely) says of an output error fit.
    pub(super) fn as_likely_trajectories(&self, fit: &OutputErrorFit) -> Vec<String> {
        let mut all = of_output_error(fit);
        // Under invariants a candidate is no term of one equation.
        if self.conserved.is_none() {
            let mut has_sign = Vec::new();
            for ((library, _), signs) in self.libraries.iter().zip(&self.signs) {
                let sign = |j: usize| signs.get(j).is_some_and(|sign| *sign != Sign::Any);
                has_sign.extend((0..library.len()).map(sign));
            }
            all.extend(additions(fit, &has_sign));
        }
        self.as_likely(&all)
    }

    /// What [`as_likely`](Self::as_likely) says of a regression. With likelier terms it predicts worse in free run, or it would
    /// have them.
    pub(super) fn as_likely_regressions(&self, exchanges: Vec<Exchange>) -> Vec<String> {
        let (better, alike): (Vec<Exchange>, Vec<Exchange>) =
            exchanges.into_iter().partition(is_likelier);
        let mut out = self.named(
            &better,
            "other terms fit better, but predict worse in free run",
        );
        out.extend(self.as_likely(&alike));
        out
    }

    /// A warning for each equation that is about as likely with other terms: within odds of 20 to 1.
    fn as_likely(&self, exchanges: &[Exchange]) -> Vec<String> {
        self.named(exchanges, "other terms are about as likely")
    }

    /// The likeliest exchanges of each equation after some words.
    fn named(&self, exchanges: &[Exchange], words: &str) -> Vec<String> {
        let mut out = Vec::new();
        let mut first = 0;
        for (state, (library, _)) in self.data.states().iter().zip(&self.libraries) {
            let own = first..first + library.len();
            first = own.end;
            let mut likely: Vec<&Exchange> = exchanges
                .iter()
                .filter(|e| own.contains(&e.added[0]) && e.cost < TWENTY_TO_ONE)
                .collect();
            likely.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            likely.truncate(NAMED);
            let names = |terms: &[usize]| -> String {
                let names = terms.iter().map(|j| &library.names()[j - own.start][..]);
                names.collect::<Vec<&str>>().join(" and ")
            };
            let text: Vec<String> = likely
                .iter()
                .map(|e| {
                    let (added, odds) = (names(&e.added), odds_text(e.cost));
                    match &e.dropped[..] {
                        [] => format!("{added} as well (odds {odds})"),
                        dropped => format!("{added} instead of {} (odds {odds})", names(dropped)),
                    }
                })
                .collect();
            if !text.is_empty() {
                out.push(format!("equation of {state}: {words}: {}", text.join(", ")));
            }
        }
        out
    }
}

/// Odds of other terms against the model, as people write them.
fn odds_text(cost: f64) -> String {
    let odds = (0.5 * cost.abs()).exp();
    match cost < 0.0 {
        true if odds > SURE => format!("over {SURE} to 1"),
        true => format!("{odds:.1} to 1"),
        false => format!("1 to {odds:.1}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::evidence::tests::found;
    use super::*;

    #[test]
    fn analytic_terms_that_are_left_out_although_they_are_significant() {
        // The chi-squared of one degree exceeds 9.55 in 0.2 % and 8.81 in 0.3 %: the level among 20 candidates is 0.25 %, 9.14.
        let mut coefficients = vec![0.0; 21];
        coefficients[20] = 2.0;
        let named = |gain: f64, correlation: f64, has_sign: bool| {
            let penalty = 13.0;
            let mut evidence = vec![-penalty; 21];
            evidence[3] = gain - penalty;
            let fit = OutputErrorFit {
                penalty,
                ..found(coefficients.clone(), evidence, correlation)
            };
            let mut signs = vec![false; 21];
            signs[3] = has_sign;
            additions(&fit, &signs)
        };
        let all = named(9.55, 1.0, false);
        assert_eq!(all.len(), 1);
        assert_eq!(
            (&all[0].dropped[..], &all[0].added[..]),
            (&[][..], &[3][..])
        );
        assert!((all[0].cost - (13.0 - 9.55)).abs() < 1e-12);
        assert!(named(8.81, 1.0, false).is_empty());
        assert!(named(9.55, 1.0, true).is_empty());
        // Residuals that hold the information of a quarter as many: the gain and the number of rows in the penalty are less.
        assert!(named(9.55, 4.0, false).is_empty());
        let all = named(4.0 * 9.55, 4.0, false);
        assert!((all[0].cost - (13.0 - 4.0_f64.ln() - 9.55)).abs() < 1e-12);
    }
}
