//! What of an estimate is known, and what is done where it is not.

use super::sightings::Sightings;
use super::{Computer, ComputerState};
use crate::estimate::relative::{Health, RelativeEstimate};
use crate::space_controller::Motion;
use crate::state_machine::Phase;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// The motion as estimated; over a deck that is at rest horizontally where no more is
    /// known of it.
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

    /// The vehicle's own velocity is known.
    pub(super) fn moves_known(&self, estimate: &RelativeEstimate<R>) -> bool {
        let sd = estimate.velocity_sd_mps.to_array();
        sd.iter().all(|&sd| sd <= self.known_sd_mps)
    }

    /// Place and velocity relative to the deck are known: what it takes to land.
    pub(super) fn is_known(&self, estimate: &RelativeEstimate<R>) -> bool {
        let below = |sd: Vector<R>, most: R| sd.to_array().iter().all(|&sd| sd <= most);
        below(estimate.position_sd_m, self.known_sd_m)
            && below(estimate.relative_velocity_sd_mps, self.known_sd_mps)
    }

    /// An estimator that stays apart from its readings begins anew.
    pub(super) fn begin_anew(
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
        // On the deck nothing is gained by it.
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
