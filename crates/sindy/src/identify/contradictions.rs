//! Whether the data contradict signs or invariants: the fit without them from where the one with them has ended.

use super::follow::{FollowedModel, Search};
use super::regress::Statistics;
use super::run::{CORRELATED, IdentificationRun};
use crate::solve::sign::{broken, is_constrained};
use crate::statistics::criteria::TWENTY_TO_ONE;
use crate::trajectory::output_error::{OutputErrorFit, Settings, Start, System, silent};

impl IdentificationRun<'_> {
    /// The coefficients of the fit without signs from where the one with signs ended, if they break a sign and are more likely by
    /// odds of 20 to 1.
    pub(super) fn without_signs(
        &self,
        found: &FollowedModel,
        search: &Search<'_>,
    ) -> Option<Vec<f64>> {
        if !is_constrained(search.signs) {
            return None;
        }
        let mut start = self.start(&found.fit.coefficients, &found.fit.sigma, search);
        start.signs.clear();
        start.colour.clone_from(&found.fit.colour);
        let correlation = found.fit.correlation;
        let mut limits = self.limits(found.longest);
        limits.penalty *= correlation;
        let free =
            found
                .way()
                .search(search.system, search.pieces, (&start, &limits), &mut silent)?;
        let likelier = is_likelier(&free, &found.fit, correlation);
        let breaks = broken(search.signs, &free.coefficients).next().is_some();
        (likelier && breaks).then_some(free.coefficients)
    }

    /// The coefficients of the fit without invariants, of all candidate terms, if it is more likely by odds of 20 to 1: over whole
    /// trajectories, or over the arcs that the model was found with. The residual of the fit with invariants is correlated where
    /// these are false, so that of the fit without them counts.
    pub(super) fn without_invariants(
        &self,
        found: &FollowedModel,
        search: &Search<'_>,
        statistics: &Statistics,
    ) -> Option<Vec<f64>> {
        let conserved = self.conserved.as_ref()?;
        let whole = (found.longest != usize::MAX).then_some(usize::MAX);
        whole
            .into_iter()
            .chain([found.longest])
            .find_map(|longest| {
                let mut limits = self.limits(longest);
                let run = |system: &System, start: &Start, limits: &Settings| {
                    found
                        .way()
                        .search(system, search.pieces, (start, limits), &mut silent)
                };
                let start = self.start(&found.fit.coefficients, &found.fit.sigma, search);
                let kept = match longest == found.longest {
                    true => found.fit.clone(),
                    false => run(search.system, &start, &limits)?,
                };
                let start = conserved.free_start(start, &kept, statistics);
                let mut free = run(&conserved.free, &start, &limits)?;
                if free.correlation > CORRELATED {
                    limits.penalty *= free.correlation;
                    free = run(&conserved.free, &start, &limits)?;
                }
                let likelier = is_likelier(&free, &kept, free.correlation);
                likelier.then_some(free.coefficients)
            })
    }
}

/// Whether a fit is more likely than another one by odds of 20 to 1. Correlated residuals hold the information of fewer
/// independent ones.
fn is_likelier(fit: &OutputErrorFit, than: &OutputErrorFit, correlation: f64) -> bool {
    let score = |fit: &OutputErrorFit| {
        let terms = fit.coefficients.iter().filter(|c| **c != 0.0).count() as f64;
        (fit.score - terms * fit.penalty) / correlation + terms * fit.penalty
    };
    score(than) - score(fit) > TWENTY_TO_ONE
}
