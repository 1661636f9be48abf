//! The sea: how fast the deck moves, and what estimators, hover, descent and escape make of it.
//!
//! In a calm sea, up to 0.7 m/s of the deck's greatest expected speed, with v the greatest that was estimated of late:
//!
//! | what | by |
//! | --- | --- |
//! | time constant with which a descent counts rising lift | 0.8 s²/m · v, at most 0.4 s; 0.4 s where the feet may touch; 0 in wind |
//! | acceleration of the deck that is fed forward | times `1/(1 + i (Δ/σ)²)`: Δ is the forecast's velocity now less that which the relative estimator measures, `σ² = (0.06 m/s)² + (0.15 v)²`, i is κ/0.1 s, at most 1, with κ of the [deck estimator](crate::estimate::deck) |
//!
//! Above a deck under way the descent ends faster by 0.01 of its speed, at most by 5/12 of the greatest speed of a touchdown (0.05 m/s), and
//! with what the wind adds at most by that speed.
//!
//! In a rough sea, with s the speed beyond 0.7 m/s:
//!
//! | what | by |
//! | --- | --- |
//! | height of the hover | + s · 1 s, and no lower than at the start until the deck has been watched |
//! | climb rate of a go-around | + s, and at least 0.5 m/s away from a deck that rises; its acceleration + s / 1 s |
//! | poles of the horizontal control above the deck | faster by s / 1 m/s, at most by 0.7 |
//! | sink rate at the touch | + 0.15 s, at most + 0.15 m/s; the same again while no tag is in view |
//! | prior of the deck's heave velocity | at least 0.4 of the greatest speed (1 m/s on all axes while the velocity by satellites contradicts a calm deck) |
//! | prior of the deck's horizontal acceleration | s / 1 s (at least 1 m/s² at first), estimated and fed forward |
//! | uncertainty of the deck's normal in ranges | 0.4 of the deck's tilt |
//! | lag of the deck's normal | half |

use super::{Computer, ComputerState, Descent};
use crate::estimate::deck::{DeckEstimatorState, DeckMotionPrediction};
use crate::estimate::relative::{Health, RelativeEstimate, RelativeFilter};
use crate::guidance::Guidance;
use crate::space_controller::{Motion, Target};
use crate::state_machine::CALM_MPS;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::kernel::{lag_by, lag_share, lag_step};
use touchdown_flight::real::{Real, r};

// Effects of halving and doubling below that have no number are expected from single flights, not measured.

/// Greatest rise of the hover, m: a deck in waves of 4 m moves at 2 to 3 m/s. Above 3 m the range finder's
/// beam leaves a deck of 1.5 m at 0.25 rad.
const HIGHEST_M: f64 = 1.5;

/// Height above the hover from which on a vehicle comes no closer to a deck that it has not watched, m: more than gusts move it.
const HIGH_START_M: f64 = 0.3;

/// Time constant with which the deck's greatest speed fades, s: a group of waves. Halved, the hover
/// sinks between two groups; doubled, it stays high for a minute.
const ROUGH_S: f64 = 30.0;

/// Sum of the harmonics' greatest speeds, over the greatest speed that was estimated, above which the harmonics cancel
/// each other and predict nothing. Sums of two or three harmonics that are met one after the other reach twice the greatest speed
/// seen. Doubled, accelerations of 10 m/s² are expected of a boat that has 1 m/s².
const CANCELLING: f64 = 2.0;
/// Speed by which that sum may exceed it, m/s: of harmonics that have just begun, and of the calm sea.
const CANCELLING_MPS: f64 = 1.0;

/// Greatest acceleration over greatest speed of a deck, 1/s: a boat of 10 m in a sea of 6 s has 1.5, and a third is left for what was
/// not seen yet. Not tried at other values.
const STEEPEST_PER_S: f64 = 2.0;

/// Horizontal acceleration of the deck, standard deviation on each axis, per speed beyond a calm sea, 1/s; and at most, m/s².
/// Boats and ships have 0.3 to 0.4 m/s² in seas of 1.25 m and 0.6 to 0.7 in seas of 4 m. With 0.4 of it 6 of 20 vehicles
/// land on a boat in a sea of 4 m instead of 12.
const SWAY_PER_S: f64 = 1.0;
const SWAY_MPS2: f64 = 1.5;

/// Rate of turn of a deck under way, rad/s: times its speed it is the standard deviation of its acceleration, where that of the settings is
/// smaller; and at most, m/s². Of 600 landings without a broadcast on a deck that turns by 0.17 rad/s at 10 m/s (`turns.toml`, seeds 9401
/// and 9402) 585 of the 1.37 kg vehicle and 589 of 4 kg succeed, with half of the rate 571 and 466, with twice 454 and 405, both
/// without the limit. The same deviation at any speed costs landings with an unknown latency on a deck at rest: an acceleration that follows
/// fast swings the hover. Of 800 landings of 4 kg on a car at 15 m/s 794 succeed (seeds 9006 to 9009), without the limit 773. All with a
/// deck estimator for periods from 0.8 s on.
const TURN_RADPS: f64 = 0.4;
const TURN_MPS2: f64 = 4.0;

/// Greatest share by which the horizontal poles are faster: beyond come those of the attitude control. With 0.5, as in a descent
/// over a calm sea, 84 of 100 vehicles land on a boat in a sea of 4 m instead of 95; with 1 94.
const HASTE: f64 = 0.7;

/// Increase of the sink rate at the touch per speed beyond a calm sea; and at most, m/s. Of 2400 landings in seas 6 crash; with both halved
/// 11, with both doubled 31.
const SINK_SHARE: f64 = 0.15;
const SINK_MPS: f64 = 0.15;

/// Increase of the sink rate at the touch per speed of a deck under way; and at most, over the greatest speed of a touchdown, 0.12 m/s.
/// The deck may begin to turn in the second in which no tag is in view. Of 1800 landings of the 1.37 kg vehicle on a deck that turns
/// at 2, 5 and 10 m/s (`turns.toml`, seeds 9101, 41 and 42) 54 touch at over 0.3 m/s across the deck without it, 22 with it, and 3 and 2
/// along its normal; at 2 and 5 m/s 6 and 2 of 1200 crash. With twice the greatest value, whatever the wind adds, 5 touch so
/// across, and 31 along the normal. Of 800 landings of 4 kg on a car at 15 m/s (seeds 9006 to 9009) 7 crash without it, 13 with it, 16 where it is
/// added to that of a strong wind.
const COURSE_SINK_SHARE: f64 = 0.01;
const COURSE_SINK_OF_TOUCHDOWN: f64 = 5.0 / 12.0;

/// Speed to the sides that counts as none, m/s: twice the error of the estimate. A ship that heaves by less than 0.7 m/s sways by up
/// to 0.6 m/s.
const STEADY_MPS: f64 = 0.2;
/// Time without a tag after which a vehicle at the deck comes down faster, s: several images at 30 Hz. The deck moves to the
/// sides by half a metre in the second that follows.
const UNSEEN_S: f64 = 0.2;

/// Time constant with which a descent counts rising lift, per greatest speed of the deck; and at most, s. The faster the deck, the
/// farther is the closing speed from its plan, and the more brake a descent needs. In a sea of 0.4 m touches are 0.0037 m/s harder
/// than with the plain observer when all lift is counted at once, 0.0014 with half of the value, and the same with it. With 0.4 s in
/// every sea they are 0.003 m/s harder in one of 0.2 m. Twice the value was not tried.
const LIFT_RISE_S2_PER_M: f64 = 0.8;
const LIFT_RISE_S: f64 = 0.4;

/// Velocity by which forecast and measurement of the deck differ where half of the forecast acceleration is left, m/s, over a calm
/// deck; and its share of the deck's greatest speed. A forecast that has watched the deck for a few seconds errs by 0.2 m/s and
/// 1 m/s² without knowing it: so did those of the hardest touches of 1500. With this the mean touch in seas of 0.4 and 0.6 m is 5 and 3 %
/// softer. Other values were not tried.
const AGREEING_MPS: f64 = 0.06;
const AGREEING_SHARE: f64 = 0.15;
/// Rate at which the estimated motion loses its coherence, 1/s, from which on all of the difference counts. In a sea it is mostly 0.4 to 0.5, on
/// a deck that moves as sines 0: there the measured velocity lags, and touches at 0.5 and 1 Hz were 0.003 m/s harder when it counted.
const INCOHERENT_PER_S: f64 = 0.1;

/// Normalised innovation squared of the velocity by satellites above which a deck that counts as calm moves: it is 1 for a
/// consistent filter, and 0.2 is a standard deviation of its mean over 20 readings. That of the tag does not count: an unknown
/// latency raises it as well, and swings a hover that follows an estimated acceleration.
const MOVING_NIS: f64 = 2.0;

/// Standard deviation of the velocity of a deck that may move, on each axis, m/s: in seas of 2.5 to 4 m.
const MOVING_MPS: f64 = 1.0;
/// Greatest angular frequency of its heave, rad/s: of waves of 4 s. With 3 rad/s a deck of 1 m/s may accelerate by 3 m/s², so
/// that two readings that disagree by 10 cm at a great tilt make a velocity of 2 m/s.
const MOVING_RADPS: f64 = 1.5;

/// Standard deviation of the heave velocity over the deck's greatest speed: the median of seas is 0.34.
const HEAVE_SHARE: f64 = 0.4;

/// Error of the deck's normal per tilt: a roll of 3 s turns by 2 rad/s times its tilt, and the normal is 0.2 s old.
/// With none, 3 of 20 vehicles land on a boat in a sea of 4 m instead of 12: ranges count as inconsistent.
const NORMAL_PER_TILT: f64 = 0.4;

/// Share of the normal's time constant that is left in a rough sea.
const NORMAL_LAG_SHARE: f64 = 0.5;

/// Greatest addition to the climb rate, m/s: decks in seas of 4 m rise at up to 3 m/s for less than 2 s.
const AWAY_MPS: f64 = 2.0;

/// Increase of the acceleration away from the deck per speed that is added, 1/s: that of decks in seas, of 1 to 2 m/s².
const AWAY_PER_S: f64 = 1.0;

/// How rough the sea is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sea<R> {
    /// Greatest expected speed of the deck of late, which raises the hover, m/s.
    rough_mps: R,
    /// Greatest estimated speed of the deck of late, m/s.
    seen_mps: R,
    /// Sum of the greatest speeds of the deck's harmonics, m/s.
    pub(super) harmonics_mps: R,
    /// Square of the deck's velocity now as forecast, less as measured by the relative estimator, as far as it counts, (m/s)².
    contradiction_m2ps2: R,
    /// For how long the deck still counts as moving, though its heave is not known yet, s.
    moves_s: R,
    /// Greatest estimated speed to the sides of late, of a deck that is not under way, m/s.
    swayed_mps: R,
    /// Estimated speed of a deck under way at the last step, m/s.
    course_mps: R,
    /// How far above its hover the vehicle waits while nobody knows whether the deck moves, m.
    waits_m: R,
    /// How far the descent is ahead of its plan because no tag is in view, m.
    pressed_m: R,
}

impl<R: Real> Sea<R> {
    fn beyond_mps(&self) -> R {
        (self.rough_mps - r(CALM_MPS)).max(R::ZERO)
    }

    /// Whether readings have contradicted a calm deck of late.
    fn moves(&self) -> bool {
        self.moves_s > R::ZERO
    }

    /// Whether the deck moves faster than in a calm sea.
    fn is_rough(&self) -> bool {
        self.beyond_mps() > R::ZERO
    }

    /// Share by which the poles of the horizontal control are faster than over a calm sea: waves that heave the deck also move
    /// it to the sides.
    pub(super) fn haste(&self) -> R {
        self.beyond_mps().min(r(HASTE))
    }

    /// How much faster a descent ends than over a calm sea, m/s: close to the deck no tag is in view, and the deck moves
    /// to the sides meanwhile.
    fn sink_mps(&self) -> R {
        let swayed_mps = self.swayed_mps - r(STEADY_MPS);
        (self.beyond_mps().max(swayed_mps) * r(SINK_SHARE)).min(r(SINK_MPS))
    }

    /// How much faster than by waves and by `windy_mps` a descent ends onto a deck under way, m/s. A vehicle touches down at up to
    /// `touchdown_mps`.
    fn course_sink_mps(&self, windy_mps: R, touchdown_mps: R) -> R {
        let most_mps = touchdown_mps * r(COURSE_SINK_OF_TOUCHDOWN);
        let left_mps = touchdown_mps - windy_mps;
        (self.course_mps * r(COURSE_SINK_SHARE))
            .min(most_mps)
            .min(left_mps)
            .max(R::ZERO)
    }

    /// Time constant of the deck's normal, s.
    pub(super) fn normal_filter_s(&self, calm_s: R) -> R {
        if self.is_rough() {
            calm_s * r(NORMAL_LAG_SHARE)
        } else {
            calm_s
        }
    }

    /// Compares the deck's velocity as forecast for now with the measured one. Of a pure tone the forecast is the better one.
    fn compare(&mut self, forecast_mps: R, measured_mps: R, forgetting_per_s: R) {
        let contradicted_mps = (forecast_mps - measured_mps).finite_or(R::ZERO);
        let incoherent = (forgetting_per_s / r(INCOHERENT_PER_S)).min(R::ONE);
        self.contradiction_m2ps2 = contradicted_mps * contradicted_mps * incoherent;
    }

    /// Time constant with which a descent counts rising lift, s. In a rough sea a descent has to end, softly or not.
    pub(super) fn lift_rise_s(&self, may_touch: bool) -> R {
        let most_s = r(LIFT_RISE_S);
        if self.is_rough() {
            R::ZERO
        } else if may_touch {
            most_s
        } else {
            most_s.min(self.seen_mps * r(LIFT_RISE_S2_PER_M))
        }
    }

    /// A predicted acceleration of the deck as far as it is borne out: in a calm sea by the measured velocity, in a rough one by
    /// what the deck's greatest speed allows.
    pub(super) fn plausible_mps2(&self, acceleration_mps2: R) -> R {
        if self.is_rough() {
            let most_mps2 = self.seen_mps * r(STEEPEST_PER_S);
            acceleration_mps2.clamp(-most_mps2, most_mps2)
        } else {
            let part_mps = self.seen_mps * r(AGREEING_SHARE);
            let agreeing2 = r::<R>(AGREEING_MPS * AGREEING_MPS) + part_mps * part_mps;
            acceleration_mps2 * agreeing2 / (agreeing2 + self.contradiction_m2ps2)
        }
    }
}

/// Sum of the harmonics' greatest speeds, m/s.
fn harmonics_mps<R: Real>(deck: &DeckEstimatorState<R>) -> R {
    let harmonics = (0..deck.count()).filter_map(|k| deck.harmonic(k));
    harmonics.fold(R::ZERO, |sum, harmonic| {
        sum + harmonic.amplitude_m * harmonic.angular_frequency
    })
}

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// Remembers the deck's greatest estimated speed, and restarts a deck estimator whose harmonics cancel each other.
    pub(super) fn watch_sea(
        &self,
        state: &mut ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
        dt: R,
    ) {
        let now_mps = self.heaves_mps(state, estimate);
        let sea = &mut state.sea;
        let share = lag_share(r(ROUGH_S), dt);
        let fading_mps = lag_by(sea.seen_mps, R::ZERO, share);
        sea.seen_mps = fading_mps.max(now_mps);
        let aside_mps = estimate.deck_velocity_mps.horizontal().norm();
        let aside_mps = aside_mps.finite_or(R::ZERO);
        if self.under_way {
            sea.course_mps = aside_mps;
        } else {
            let fading_mps = lag_by(sea.swayed_mps, R::ZERO, share);
            sea.swayed_mps = fading_mps.max(aside_mps);
        }
        let most_mps = sea.seen_mps * r(CANCELLING) + r(CANCELLING_MPS);
        sea.harmonics_mps = harmonics_mps(&state.deck);
        if sea.harmonics_mps > most_mps {
            sea.harmonics_mps = R::ZERO;
            self.deck.reset(&mut state.deck);
            state.sightings.reset();
        }
    }

    /// How fast the deck heaves for certain, m/s: as estimated, less up to three standard deviations above the safe height. From 10 m
    /// above, errors of the attitude move the heights as a sea does.
    pub(super) fn heaves_mps(
        &self,
        state: &ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
    ) -> R {
        let sds = state.wider - R::ONE;
        let certain_mps =
            estimate.deck_velocity_mps.z.abs() - sds * estimate.deck_velocity_sd_mps.z;
        certain_mps.finite_or(R::ZERO).max(R::ZERO)
    }

    /// The deck's motion now as forecast, which is compared with the measured one.
    pub(super) fn forecast_deck(
        &self,
        state: &mut ComputerState<R, G::State>,
        estimate: &RelativeEstimate<R>,
    ) -> DeckMotionPrediction<R> {
        let now = self.deck_ahead(state, R::ZERO);
        let forgetting_per_s = state.deck.forgetting_per_s();
        let measured_mps = estimate.deck_velocity_mps.z;
        state
            .sea
            .compare(now.velocity_mps, measured_mps, forgetting_per_s);
        now
    }

    /// Notices that a deck that counts as calm moves: all motion relative to it counts as the vehicle's, which the vehicle's
    /// velocity by satellites contradicts.
    pub(super) fn watch_consistency(
        &self,
        state: &mut ComputerState<R, G::State>,
        health: &Health<R>,
        dt: R,
    ) {
        let moves = health.gnss.nis > r(MOVING_NIS);
        state.sea.moves_s = if moves {
            r(ROUGH_S)
        } else {
            (state.sea.moves_s - dt).max(R::ZERO)
        };
    }

    /// How much higher than in a calm sea the vehicle holds, m. A hover lags behind a deck that
    /// accelerates, and a deck that is not known yet may rise: until it has been watched, the vehicle comes no closer.
    pub(super) fn hold_extra_m(
        &self,
        state: &mut ComputerState<R, G::State>,
        deck_mps: R,
        height_m: R,
        dt: R,
    ) -> R {
        let fading_mps = lag_step(state.sea.rough_mps, R::ZERO, r(ROUGH_S), dt);
        state.sea.rough_mps = fading_mps.max(deck_mps.finite_or(R::ZERO));
        let most_m = match &self.descent {
            Descent::Planned(planner) => planner.reach_m() - self.state_machine.hold_height_m,
            Descent::Straight(_) => R::ZERO,
        };
        let above_m = height_m - self.state_machine.hold_height_m;
        if !self.is_unwatched(state) {
            state.sea.waits_m = R::ZERO;
        } else if above_m > r(HIGH_START_M) {
            state.sea.waits_m = state.sea.waits_m.max(above_m);
        }
        let extra_m = state.sea.beyond_mps().max(state.sea.waits_m);
        extra_m.min(r::<R>(HIGHEST_M).min(most_m))
    }

    /// Whether the deck counts as calm whatever is measured: one under way, which has priors of its own, and one that the vehicle
    /// seeks from afar and has not watched yet. Ranges of what is below on the way say nothing about the deck.
    fn counts_as_calm(&self, state: &ComputerState<R, G::State>) -> bool {
        self.under_way || self.comes_from_afar(state)
    }

    fn comes_from_afar(&self, state: &ComputerState<R, G::State>) -> bool {
        self.seek.is_some() && state.deck.observed_s() < self.watch_s
    }

    /// Whether nobody knows yet whether the deck moves.
    fn is_unwatched(&self, state: &ComputerState<R, G::State>) -> bool {
        state.flown_s < self.watch_s && !self.counts_as_calm(state)
    }

    /// Whether the sea is rough.
    fn meets_rough_sea(&self, state: &ComputerState<R, G::State>) -> bool {
        state.sea.is_rough() && !self.comes_from_afar(state)
    }

    /// Horizontal acceleration of the deck, standard deviation on each axis, m/s². The faster a deck under way, the harder it turns.
    /// Waves that heave the deck also move it to the sides; before it has been watched, by at least 1 m/s². A calm deck keeps the
    /// settings': with an acceleration that is estimated, an unknown latency swings the hover.
    pub(super) fn sway_mps2(&self, state: &ComputerState<R, G::State>) -> R {
        let prior_mps2 = self.relative.deck.horizontal_acceleration_sd_mps2;
        if self.under_way {
            let turns_mps2 = (r::<R>(TURN_RADPS) * state.sea.course_mps).min(r(TURN_MPS2));
            return prior_mps2.max(turns_mps2);
        }
        let sways = state.sea.moves() || self.meets_rough_sea(state);
        if self.comes_from_afar(state) || !sways {
            return prior_mps2;
        }
        let sway_mps2 = (state.sea.beyond_mps() * r(SWAY_PER_S)).min(r(SWAY_MPS2));
        if state.deck.observed_s() < self.watch_s {
            sway_mps2.max(R::ONE)
        } else {
            sway_mps2.max(prior_mps2)
        }
    }

    /// Whether the deck's horizontal acceleration is estimated and followed.
    pub(super) fn deck_accelerates(&self, state: &ComputerState<R, G::State>) -> bool {
        self.under_way || self.sway_mps2(state) > R::ZERO
    }

    /// Sets the priors of the relative estimator that follow from the sea.
    pub(super) fn roughen(
        &self,
        state: &ComputerState<R, G::State>,
        relative: &mut RelativeFilter<R>,
    ) {
        let deck = &mut relative.deck;
        deck.horizontal_acceleration_sd_mps2 = self.sway_mps2(state);
        if state.sea.moves() && !self.counts_as_calm(state) {
            let slower = deck.heave_angular_frequency.min(r(MOVING_RADPS));
            deck.heave_angular_frequency = slower;
            for velocity_mps in [
                &mut deck.heave_velocity_sd_mps,
                &mut deck.horizontal_velocity_sd_mps,
            ] {
                *velocity_mps = velocity_mps.max(r(MOVING_MPS));
            }
        }
        if self.meets_rough_sea(state) {
            relative.range.normal_sd_rad = state.tilt_rad * r(NORMAL_PER_TILT);
            let heave_mps = &mut deck.heave_velocity_sd_mps;
            *heave_mps = heave_mps.max(state.sea.rough_mps * r(HEAVE_SHARE));
        }
    }

    /// How much faster a descent ends because of the deck's motion, m/s, in a wind because of which it ends faster by `windy_mps`.
    pub(super) fn moving_sink_mps(&self, state: &ComputerState<R, G::State>, windy_mps: R) -> R {
        let touchdown_mps = self.state_machine.touchdown_speed_mps;
        state.sea.sink_mps() + state.sea.course_sink_mps(windy_mps, touchdown_mps)
    }

    /// Brings a vehicle at the deck down faster while no tag is in view.
    pub(super) fn press_on(
        &self,
        state: &mut ComputerState<R, G::State>,
        committed: bool,
        target: &mut Target<R>,
        dt: R,
    ) {
        let unseen = || self.relative.health(&state.relative).tag.age_s > r(UNSEEN_S);
        let faster_mps = state.sea.sink_mps();
        let sea = &mut state.sea;
        if !committed {
            sea.pressed_m = R::ZERO;
        } else if faster_mps > R::ZERO && sea.pressed_m < self.guidance.press_m && unseen() {
            sea.pressed_m += faster_mps * dt;
            target.vertical.velocity_mps -= faster_mps;
        }
        target.vertical.height_m -= sea.pressed_m;
    }

    /// The guidance of a vehicle that climbs away from a deck that may come after it, up to the safe height.
    pub(super) fn guidance_away(
        &self,
        state: &ComputerState<R, G::State>,
        motion: &Motion<R>,
    ) -> Guidance<R> {
        let low = motion.position_m.z < self.state_machine.safe_height_m;
        let faster_mps = if low {
            let rises_mps = motion.vehicle_velocity_mps.z - motion.relative_velocity_mps.z;
            let faster_mps = state.sea.beyond_mps().max(rises_mps.finite_or(R::ZERO));
            faster_mps.min(r(AWAY_MPS))
        } else {
            R::ZERO
        };
        Guidance {
            climb_mps: self.guidance.climb_mps + faster_mps,
            away_mps2: self.guidance.away_mps2 + faster_mps * r(AWAY_PER_S),
            ..self.guidance
        }
    }
}

#[cfg(test)]
mod tests;
