//! Other terms in place of one that are about as likely.

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

/// Odds of all exchanges of candidate `j` against the model.
pub(super) fn odds(exchanges: &[Exchange], j: usize) -> f64 {
    let own = exchanges.iter().filter(|e| e.dropped == j);
    own.map(|e| (-0.5 * e.cost).exp()).sum()
}

/// The exchanges of an output error fit. Correlated residuals hold the information of fewer independent ones.
pub(super) fn of_output_error(found: &OutputErrorFit) -> Vec<Exchange> {
    let of = |e: &Exchange| Exchange {
        cost: e.cost / found.correlation,
        ..*e
    };
    found.exchanges.iter().map(of).collect()
}

/// The exchanges of a regression, each over the rows that count for its term.
fn of_regression(
    fit: &Fit,
    signs: &[Sign],
    total: &Gram,
    evidence: &[TermEvidence],
) -> Vec<Exchange> {
    let left = fit.residual_sum.max(f64::MIN_POSITIVE);
    let of = |e: Exchange| Exchange {
        cost: evidence[e.dropped].rows * (e.cost / left).ln_1p(),
        ..e
    };
    let all = exchange::of_regression(total, &fit.coefficients, fit.residual_sum, signs);
    all.into_iter().map(of).collect()
}

impl IdentificationRun<'_> {
    /// The exchanges of regressions of all equations, which the evidence for the terms then counts.
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
            for (j, evidence) in own.iter_mut().enumerate() {
                evidence.exchanged = odds(&exchanges, j);
            }
            out.extend(exchanges.into_iter().map(|e| Exchange {
                dropped: first + e.dropped,
                added: first + e.added,
                ..e
            }));
            first += fit.support.len();
        }
        out
    }

    /// A warning for each equation that is about as likely with another term in place of one: within odds of 20 to 1.
    pub(super) fn as_likely(&self, exchanges: &[Exchange]) -> Vec<String> {
        let mut out = Vec::new();
        let mut first = 0;
        for (state, (library, _)) in self.data.states().iter().zip(&self.libraries) {
            let own = first..first + library.len();
            first = own.end;
            let mut likely: Vec<&Exchange> = exchanges
                .iter()
                .filter(|e| own.contains(&e.dropped) && e.cost < TWENTY_TO_ONE)
                .collect();
            likely.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            likely.truncate(NAMED);
            let name = |j: usize| &library.names()[j - own.start];
            let text: Vec<String> = likely
                .iter()
                .map(|e| {
                    let odds = (0.5 * e.cost.abs()).exp();
                    let odds = match e.cost < 0.0 {
                        true => format!("{odds:.1} to 1"),
                        false => format!("1 to {odds:.1}"),
                    };
                    format!(
                        "{} instead of {} (odds {odds})",
                        name(e.added),
                        name(e.dropped)
                    )
                })
                .collect();
            if !text.is_empty() {
                out.push(format!(
                    "equation of {state}: other terms are about as likely: {}",
                    text.join(", ")
                ));
            }
        }
        out
    }
}
