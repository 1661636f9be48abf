//! The horizon, predicted time by time: over several control periods, with bounded work in each.

use touchdown_flight::real::Real;

use super::forecast::{DeckForecast, DeckOutlook};
use super::{Planner, STEPS};

/// What the predictions of a horizon say about each touchdown time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scan<R> {
    /// Number of times that have been predicted.
    done: usize,
    /// Severity at each time alone; infinite without a prediction.
    severity: [R; STEPS + 1],
    /// Sink rate at touchdown, m/s.
    sink_rate_mps: [R; STEPS + 1],
    /// Absolute acceleration of the deck, m/s²; infinite without a prediction.
    deck_mps2: [R; STEPS + 1],
}

impl<R: Real> Default for Scan<R> {
    fn default() -> Self {
        Self {
            done: 0,
            severity: [R::ZERO; STEPS + 1],
            sink_rate_mps: [R::ZERO; STEPS + 1],
            deck_mps2: [R::ZERO; STEPS + 1],
        }
    }
}

impl<R: Real> Scan<R> {
    /// Starts again at the beginning of the horizon.
    pub(super) fn restart(&mut self) {
        self.done = 0;
    }

    pub(super) fn is_complete(&self) -> bool {
        self.done > STEPS
    }

    /// The greatest severity within `half` steps around a time.
    pub(super) fn worst_severity(&self, i: usize, half: usize) -> R {
        let from = i.saturating_sub(half);
        let around = self.severity.iter().take(i + half + 1).skip(from);
        around.fold(R::ZERO, |worst, &s| worst.max(s))
    }

    /// Sink rate at touchdown and absolute acceleration of the deck; none without a
    /// prediction.
    pub(super) fn at(&self, i: usize) -> Option<(R, R)> {
        let (sink_rate_mps, deck_mps2) = (self.sink_rate_mps.get(i)?, self.deck_mps2.get(i)?);
        deck_mps2
            .is_finite()
            .then_some((*sink_rate_mps, *deck_mps2))
    }

    /// Predicts up to `most` further times of a horizon that begins `lead_s` from now.
    #[inline(never)]
    pub(super) fn advance(
        &mut self,
        planner: &Planner<R>,
        forecast: &impl DeckForecast<R>,
        lead_s: R,
        most: usize,
    ) {
        for _ in 0..most {
            let i = self.done;
            if i > STEPS {
                return;
            }
            let outlook = forecast.at(lead_s + planner.time_s(i));
            self.enter(planner, i, &outlook);
            self.done += 1;
        }
    }

    fn enter(&mut self, planner: &Planner<R>, i: usize, outlook: &DeckOutlook<R>) {
        let unknown = R::ONE / R::ZERO;
        let (mut severity, mut deck_mps2) = (unknown, unknown);
        if outlook.is_usable() {
            let sink_rate_mps = planner.sink_rate(outlook);
            severity = planner.severity(outlook, sink_rate_mps);
            deck_mps2 = outlook.acceleration_mps2.abs();
            if let Some(place) = self.sink_rate_mps.get_mut(i) {
                *place = sink_rate_mps;
            }
        }
        let places = (self.severity.get_mut(i), self.deck_mps2.get_mut(i));
        if let (Some(of_severity), Some(of_deck)) = places {
            (*of_severity, *of_deck) = (severity, deck_mps2);
        }
    }
}
