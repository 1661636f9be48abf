//! The estimators' part of a step: relative motion, latency, deck and its normal.

use crate::computer::{Computer, ComputerState, Sensed};
use crate::estimate::deck::DeckEstimatorState;
use crate::estimate::relative::{DeckPrior, DeckSighting, RangeReading, Reading};
use crate::state_machine::Phase;
use touchdown_flight::ground_effect::GroundEffect;
use touchdown_flight::kernel::{lag_by, lag_share, lag_step};
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// Least change of the estimated latency after which past observations of the deck are
/// dropped, s: 1.5 times the spacing of the compared latencies (20 ms), so that a step to a
/// neighbour keeps them.
const MISTIMED_S: f64 = 0.03;
/// Time after such a change until the vehicle's own motion has been estimated with the new
/// latency, s: three times the memory of the relative estimator.
const RETIMED_S: f64 = 1.0;
/// Greatest standard deviation, over `known_sd_m`, of a height that the estimator of the deck gets from above the safe height. It takes
/// all heights for as precise as those of a hover: an error of some decimetres counts as a wave. Other values were not tried.
const CLEAR: f64 = 1.0 / 3.0;
/// Standard deviations while the [latency of images may be wrong](may_be_late): of their age, s, and
/// of the attitude at their time, rad, which turns by 0.2 to 0.3 rad within 0.2 s. Two images that are 0.2 s late may otherwise tell of a
/// deck that sinks by 2 m/s, with which the vehicle sinks. Of 400 vehicles that get one image in five, 0.2 s late, and no range, 85 crash without
/// both, 38 without that of the attitude, and 24, 13, 9 and 6 with 0.03, 0.06, 0.1 and 0.15 rad. With the age alone, and also where ranges
/// were there, 82, 72 and 70 of 1920 crashed with 0.1, 0.15 and 0.2 s. Then a latency of 0.2 s was not found where frames are lost. Since it is, of
/// other seeds 36 of 400 and 39 of 1920 crash without both, 5 and 25 with them.
const DOUBTED_AGE_S: f64 = 0.15;
const DOUBTED_ATTITUDE_RAD: f64 = 0.1;

/// Time after a divergence for which images may be late by an unknown time, s. With the age alone (0.1 s), and also where ranges were there, 89,
/// 85 and 85 of 1920 crashed with half of it, with it and with three times of it; with both, other values were not tried.
const DOUBT_S: f64 = 10.0;

/// Whether images may be late by an unknown time: no range tells the height, and the estimate of the relative motion has diverged of late, and
/// not only before the latency was found. If it sufficed with ranges that it has diverged, 21 of 400 vehicles without satellites whose
/// images are all 0.2 s late would crash, in place of 3.
fn may_be_late<R: Real, S>(state: &ComputerState<R, S>) -> bool {
    let doubted_s = state.latency.doubted_s();
    doubted_s < r(DOUBT_S)
        && doubted_s + r(RETIMED_S) < state.mistimed_s
        && state.latency.is_range_gone()
}

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// Steps the estimators and the filter of the deck's normal. Returns whether the
    /// latency changed, so that all past readings had wrong ages.
    #[inline(never)]
    pub(super) fn estimate(
        &self,
        state: &mut ComputerState<R, G::State>,
        sensed: &Sensed<'_, R>,
        dt: R,
    ) -> bool {
        let latency_s = state.latency.latency_s();
        let normal = state.normal;
        let readings = sensed
            .readings
            .iter()
            .map(|reading| match reading.older_by(latency_s) {
                Reading::Range(range) => Reading::Range(RangeReading {
                    deck_normal: normal,
                    ..range
                }),
                other => other,
            });
        let mut relative = self.relative;
        state.may_be_late = may_be_late(state);
        if state.may_be_late {
            relative.tag.jitter_s += r(DOUBTED_AGE_S);
            relative.imu.attitude_sd_rad += r(DOUBTED_ATTITUDE_RAD);
        }
        if let Some(band) = self.band(&state.deck) {
            relative.deck = band;
        }
        self.roughen(state, &mut relative);
        if state.needs_barometer {
            relative.barometer.trusted_above_m = r(f64::NEG_INFINITY);
        }
        relative.step_with(&mut state.relative, &sensed.imu, readings, dt);
        let mistimed = self.estimate_latency(state, sensed.readings, dt);
        let above = state.wider > R::ONE;
        let clear =
            |sighting: &DeckSighting<R>| !above || sighting.sd_m <= r::<R>(CLEAR) * self.known_sd_m;
        let sighting = self.relative.deck_sighting(&state.relative).filter(clear);
        let (height, elapsed_s) = state.sightings.step(sighting, self.deck.delay_s, dt);
        if elapsed_s > R::ZERO {
            self.deck.step(&mut state.deck, height, elapsed_s);
        }

        state.normal_age_s += dt;
        state.tilt_rad = lag_step(state.tilt_rad, R::ZERO, self.tilt_memory_s, dt);
        if let Some(seen) = sensed.deck_normal {
            let body = self.relative.tag.attitude.rotate(seen.normal);
            let age_s = seen.age_s + latency_s;
            let attitude = self.relative.attitude_at(&state.relative, age_s);
            if let Some(normal) = attitude.rotate(body).direction().filter(|n| n.z > R::ZERO) {
                // After a gap, one reading does not replace all the missing ones.
                let filter_s = state.sea.normal_filter_s(self.normal_filter_s);
                let elapsed_s = state.normal_age_s.min(filter_s);
                state.normal_age_s = R::ZERO;
                let share = lag_share(filter_s, elapsed_s);
                let follow = |now, seen| lag_by(now, seen, share);
                let old = state.normal;
                state.normal = Vector::new(
                    follow(old.x, normal.x),
                    follow(old.y, normal.y),
                    follow(old.z, normal.z),
                );
                let tilt_rad = state.normal.horizontal().norm().atan2(state.normal.z);
                state.tilt_rad = state.tilt_rad.max(tilt_rad);
            }
        }
        mistimed
    }

    /// Estimates the latency, except while the legs may touch. If it changes, the deck was
    /// observed at wrong times, so the deck estimator restarts. Returns that change.
    pub(super) fn estimate_latency(
        &self,
        state: &mut ComputerState<R, G::State>,
        readings: &[Reading<R>],
        dt: R,
    ) -> bool {
        let Some(latency) = &self.latency else {
            return false;
        };
        if matches!(
            state.state_machine.phase(),
            Phase::Commit | Phase::Touchdown | Phase::Disarmed
        ) {
            return false;
        }
        let before_s = state.latency.latency_s();
        latency.step(
            &mut state.latency,
            &self.relative,
            &state.relative,
            readings,
            dt,
        );
        let mistimed = (state.latency.latency_s() - before_s).abs() > r(MISTIMED_S);
        state.mistimed_s = if mistimed {
            R::ZERO
        } else {
            state.mistimed_s + dt
        };
        if state.mistimed_s < r(RETIMED_S) {
            self.deck.reset(&mut state.deck);
            state.sightings.reset();
        }
        mistimed
    }

    /// The prior of the deck's heave that follows from the known harmonics.
    #[inline(never)]
    pub(super) fn band(&self, deck: &DeckEstimatorState<R>) -> Option<DeckPrior<R>> {
        let harmonics = || (0..deck.count()).filter_map(|k| deck.harmonic(k));
        let (mut power, mut sum, mut squares) = (R::ZERO, R::ZERO, R::ZERO);
        for harmonic in harmonics() {
            let w = harmonic.angular_frequency;
            let speed = harmonic.amplitude_m * w;
            let share = speed * speed;
            let sd = harmonic.angular_frequency_sd;
            power += share;
            sum += share * w;
            squares += share * (w * w + sd * sd);
        }
        let mean = sum / power;
        let width = (squares / power - mean * mean).max(R::ZERO).sqrt() + deck.forgetting_per_s();
        let prior = DeckPrior {
            heave_velocity_sd_mps: (power * r(0.5)).sqrt().max(self.deck_known_mps),
            heave_angular_frequency: mean,
            heave_damping_ratio: (width / mean).clamp(
                self.least_damping_ratio,
                self.relative.deck.heave_damping_ratio,
            ),
            ..self.relative.deck
        };
        prior.validate().is_ok().then_some(prior)
    }
}
