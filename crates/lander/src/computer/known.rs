//! Checks whether an estimate is precise enough, and the restart of the estimator.

use super::sightings::Sightings;
use super::{Computer, ComputerState};
use crate::estimate::relative::{Health, RelativeEstimate};
use crate::space_controller::Motion;
use crate::state_machine::Phase;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// The estimated motion. The deck counts as at rest horizontally while its velocity
    /// is not known.
    pub(super) fn motion(
        &self,
        estimate: &RelativeEstimate<R>,
        attitude: Attitude<R>,
        deck_normal: Vector<R>,
    ) -> Motion<R> {
        let mut motion = Motion::from_estimate(estimate, attitude, deck_normal);
        let sd = estimate.velocity_sd_mps;
        if !(sd.x <= self.known_sd_mps && sd.y <= self.known_sd_mps) {
            let relative = motion.relative_velocity_mps;
            let own = &mut motion.vehicle_velocity_mps;
            (own.x, own.y) = (relative.x, relative.y);
        }
        motion
    }

    /// Whether the vehicle's own velocity is known.
    pub(super) fn moves_known(&self, estimate: &RelativeEstimate<R>) -> bool {
        let sd = estimate.velocity_sd_mps.to_array();
        sd.iter().all(|&sd| sd <= self.known_sd_mps)
    }

    /// Whether position and velocity relative to the deck are known, as a landing
    /// requires.
    #[must_use]
    pub fn knows(&self, estimate: &RelativeEstimate<R>) -> bool {
        let below = |sd: Vector<R>, most: R| sd.to_array().iter().all(|&sd| sd <= most);
        below(estimate.position_sd_m, self.known_sd_m)
            && below(estimate.relative_velocity_sd_mps, self.known_sd_mps)
    }

    /// Restarts an estimator that stays diverged.
    pub(super) fn restart_diverged(
        &self,
        state: &mut ComputerState<R, G::State>,
        health: &Health<R>,
        phase: Phase,
        dt: R,
    ) {
        state.apart_s = if health.diverged {
            state.apart_s + dt
        } else {
            R::ZERO
        };
        // A restart on the deck has no use.
        let landed = matches!(phase, Phase::Touchdown | Phase::Disarmed);
        if state.apart_s >= self.restart_s && !landed {
            let estimate = self.relative.ahead(&state.relative, R::ZERO);
            state.carried_over = !state.carried_over && self.moves_known(&estimate);
            if state.carried_over {
                let sd_mps = r::<R>(0.5) * self.known_sd_mps;
                self.relative.restart_moving(&mut state.relative, sd_mps);
            } else {
                self.relative.restart(&mut state.relative);
            }
            state.deck = self.deck.initial();
            state.sightings = Sightings::default();
            state.apart_s = R::ZERO;
        }
    }
}
