//! Checks whether an estimate is precise enough, and the restart of the estimator.

use super::step::BLIND_START_S;
use super::{Computer, ComputerState};
use crate::estimate::relative::{Health, RelativeEstimate};
use crate::space_controller::Motion;
use crate::state_machine::Phase;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

/// Factor on the horizontal uncertainty that is allowed below the commit height of a deck under way, and in a rough sea: a second without
/// tag while the deck may accelerate by 3 m/s². Halved, 171 of 600 vehicles without a broadcast do not land on a deck that turns at 10 m/s, in place of
/// 15 (1.37 kg, `turns.toml`, seeds 9401 and 9402): they climb away from a deck on which they stand. Doubled, 14. Both
/// without the sea's `TURN_MPS2`, and all with a deck estimator for periods from 0.8 s on.
const COMMITTED: f64 = 12.0;

/// Factor on the uncertainty of the horizontal velocity in the approach to a deck that may sway: that of a tag seen from 3 m,
/// with the prior of a rough sea. At 1 a vehicle that starts 3.6 m aside hovers where it is.
const SWAYING: f64 = 3.0;

/// Share of `known_sd_mps` and of `known_sd_m` beyond which the barometer counts also near the deck: before the velocity is unknown, or
/// when the height is (an accelerometer with an error may say that the climb rate is known, while the vehicle sinks by 0.25 m/s for 10 s),
/// and when the deck is out of sight. The effects of halving and doubling were not measured.
const UNSURE_CLIMB: f64 = 0.5;
const UNSEEN: f64 = 0.3;
/// Share of the barometer's `trusted_above_m` above which it does: 0.75 m, where the rotors' pressure shifts the simulated barometer by 0.12 m.
const UNSURE_ABOVE: f64 = 0.25;

/// Greatest factor of [`Computer::wider`], reached at four times the safe height. Without a limit an estimate that has seen nothing yet,
/// with a standard deviation of 10 m, counts as known from 100 m on. Half and twice of it were not tried.
const WIDEST: f64 = 4.0;

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

    /// Whether the vertical part of it is known.
    pub(super) fn climb_known(&self, estimate: &RelativeEstimate<R>) -> bool {
        estimate.velocity_sd_mps.z <= self.known_sd_mps
    }

    /// Whether the barometer counts at any height: the vehicle does not see the deck, does not know how fast it climbs, and may be high
    /// enough.
    pub(super) fn needs_barometer(
        &self,
        state: &ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
    ) -> bool {
        let height_sd_m = estimate.position_sd_m.z;
        let least_m = r::<R>(UNSURE_ABOVE) * self.relative.barometer.trusted_above_m;
        let climb_sd_mps = estimate.velocity_sd_mps.z;
        height_sd_m > r::<R>(UNSEEN) * self.known_sd_m
            && (climb_sd_mps > r::<R>(UNSURE_CLIMB) * self.known_sd_mps
                || height_sd_m > self.known_sd_m)
            && state.flown_s > r(BLIND_START_S)
            && estimate.height_m() + height_sd_m >= least_m
    }

    /// Whether position and velocity relative to the deck are known, as a landing
    /// requires.
    #[must_use]
    pub fn knows(&self, estimate: &RelativeEstimate<R>) -> bool {
        self.knows_within(estimate, R::ONE)
    }

    /// As [`Self::knows`], but the limits grow with the height: from higher up there is more way to correct an error.
    pub(super) fn knows_from_above(&self, estimate: &RelativeEstimate<R>) -> bool {
        self.knows_within(estimate, self.higher(estimate))
    }

    /// As [`Self::knows`], with limits that are wider by a factor.
    fn knows_within(&self, estimate: &RelativeEstimate<R>, wider: R) -> bool {
        let below = |sd: Vector<R>, most: R| sd.to_array().iter().all(|&sd| sd <= wider * most);
        below(estimate.position_sd_m, self.known_sd_m)
            && below(estimate.relative_velocity_sd_mps, self.known_sd_mps)
    }

    /// Factor on the limits of the uncertainty and of the tag's age. Above the safe height it grows with the height: there is more way to
    /// correct an error, and more images miss the tag. It is 1 below, where the height is not a number, and without satellites: by late
    /// tags from 15 m a vehicle swings ever farther and flies away. When it grew from the hover on, 22 of 480 vehicles with late
    /// readings and lost frames crashed, in place of 13.
    #[inline(never)]
    pub(super) fn wider(&self, estimate: &RelativeEstimate<R>, health: &Health<R>) -> R {
        if !health.gnss.fresh {
            return R::ONE;
        }
        let share = estimate.height_m() / self.state_machine.safe_height_m;
        share.max(R::ONE).min(r(WIDEST))
    }

    /// The height over that of the hover, at least 1.
    pub(super) fn higher(&self, estimate: &RelativeEstimate<R>) -> R {
        let share = estimate.height_m() / self.state_machine.hold_height_m;
        share.finite_or(R::ONE).max(R::ONE)
    }

    /// As [`Self::knows_from_above`], but above a deck that accelerates the horizontal velocity may be known less well, by as much as its
    /// acceleration may exceed that of the settings: an image or two that miss the tag, or a latency, make it uncertain. Too low to abort
    /// for a lost tag, position and velocity become uncertain within the time of a touchdown.
    pub(super) fn knows_enough(
        &self,
        state: &ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
        wider: R,
    ) -> bool {
        if !self.deck_accelerates(state) {
            return self.knows_within(estimate, wider);
        }
        let low = matches!(state.phase(), Phase::Commit | Phase::Touchdown);
        let (place, velocity) = (estimate.position_sd_m, estimate.relative_velocity_sd_mps);
        let aside = |sd: Vector<R>, most: R| sd.x <= most && sd.y <= most;
        let [place_times, velocity_times] = if low {
            [r(COMMITTED); 2]
        } else if self.under_way {
            let calm_mps2 = self.relative.deck.horizontal_acceleration_sd_mps2;
            let faster = self.sway_mps2(state) / calm_mps2;
            // Settings that expect hardly any acceleration do not take the limit away.
            [R::ONE, faster.finite_or(r(SWAYING)).min(r(SWAYING))]
        } else {
            [R::ONE, r(SWAYING)]
        };
        let higher = self.higher(estimate);
        let (known_m, known_mps) = (higher * self.known_sd_m, higher * self.known_sd_mps);
        place.z <= known_m
            && velocity.z <= known_mps
            && aside(place, place_times * known_m)
            && aside(velocity, velocity_times * known_mps)
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
            let mut relative = self.relative;
            self.roughen(state, &mut relative);
            let estimate = relative.ahead(&state.relative, R::ZERO);
            // Satellites that contradict the velocity say that it is wrong.
            let contradicted = health.gnss.nis > self.relative.gate.nis_limit
                || health.gnss.rejected_in_a_row >= self.relative.gate.rejections;
            state.carried_over =
                !state.carried_over && !contradicted && self.moves_known(&estimate);
            if state.carried_over {
                let sd_mps = r::<R>(0.5) * self.known_sd_mps;
                relative.restart_moving(&mut state.relative, sd_mps);
            } else {
                relative.restart(&mut state.relative);
            }
            self.deck.reset(&mut state.deck);
            state.sightings.reset();
            state.apart_s = R::ZERO;
        }
    }
}
