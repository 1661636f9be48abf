//! Long data: terms are chosen on a part of the rows, and the coefficients of the chosen ones are refined on all rows.

use std::ops::ControlFlow;

use super::Progress;
use super::disturbed::Way;
use super::follow::{FollowedModel, Search};
use super::prepare::{self, Slopes};
use super::run::{CORRELATED, FOLLOWS, IdentificationRun};
use super::screen::Screen;
use crate::trajectory::output_error::{self, OutputErrorFit, Step};

/// What was seen on all rows of terms that were chosen on a part of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum OnAllRows {
    /// Their coefficients are those of all rows.
    Refined,
    /// They leave this many times the noise, more than a model that follows the data: the coefficients are those of the part.
    Leave(f64),
    /// They do not follow all rows at all, or some of them are not needed there: the coefficients are those of the part.
    Lost,
}

impl IdentificationRun<'_> {
    /// Refines the coefficients of a model that follows whole trajectories, where these have more rows than terms were chosen on.
    pub(super) fn on_all_rows(
        &self,
        found: &mut FollowedModel,
        slopes: &Slopes,
        term_rms: &[f64],
        progress: &mut dyn FnMut(Progress),
    ) {
        let rows: usize = self.stretches.iter().map(|s| s.time.len()).sum();
        let whole = matches!(found.way(), Way::Arcs(usize::MAX));
        let follows = self.misfit(&found.fit) <= FOLLOWS || found.is_in_noise();
        if rows <= self.settings.rows || !whole || !follows {
            return;
        }
        let enough = FOLLOWS.max(FOLLOWS * self.misfit(&found.fit));
        let seen = match self.refined(found, slopes, term_rms, progress) {
            None => OnAllRows::Lost,
            Some(fit) if self.misfit(&fit) <= enough => {
                found.fit = fit;
                OnAllRows::Refined
            }
            Some(fit) => OnAllRows::Leave(self.misfit(&fit)),
        };
        found.on_all_rows = Some(seen);
    }

    /// The fit of the same terms to all rows; `None` where they cannot be followed, or where fewer of them are better.
    fn refined(
        &self,
        found: &FollowedModel,
        slopes: &Slopes,
        term_rms: &[f64],
        progress: &mut dyn FnMut(Progress),
    ) -> Option<OutputErrorFit> {
        let before = &found.fit;
        let keep: Vec<bool> = before.coefficients.iter().map(|c| *c != 0.0).collect();
        let screen = Screen::of(self, &keep)?;
        let states = self.data.states().len();
        let between = &self.inputs.between;
        let search = Search {
            system: &screen.system,
            starts: &[],
            pieces: &prepare::parts(&self.stretches, states, slopes, between),
            term_rms: &screen.narrow(term_rms),
            chosen_from: keep.len(),
            signs: &screen.narrow(&self.signs.concat()),
        };
        let mut start = self.start(&screen.narrow(&before.coefficients), &before.sigma, &search);
        start.colour.clone_from(&before.colour);
        let mut limits = self.limits(usize::MAX);
        // The start is near: from shorter arcs the same end takes more steps.
        limits.first_arc = usize::MAX;
        if before.correlation > CORRELATED {
            limits.penalty *= before.correlation;
        }
        let mut report = |step: Step<'_>| {
            progress(Progress::AllRows { step: step.step });
            ControlFlow::Continue(())
        };
        let mut fit =
            output_error::search(search.system, search.pieces, &start, &limits, &mut report)?;
        screen.widen_fit(&mut fit);
        let same = fit
            .coefficients
            .iter()
            .zip(&keep)
            .all(|(c, k)| (*c != 0.0) == *k);
        // Of other terms is known what the part of the rows has shown.
        fit.fronts.clone_from(&before.fronts);
        let more = fit.values as f64 / before.values as f64;
        fit.exchanges.clone_from(&before.exchanges);
        fit.exchanges.iter_mut().for_each(|e| e.cost *= more);
        for (j, kept) in keep.iter().enumerate() {
            if !kept {
                fit.evidence[j] = before.evidence[j] + before.penalty - fit.penalty;
            }
        }
        same.then_some(fit)
    }
}
