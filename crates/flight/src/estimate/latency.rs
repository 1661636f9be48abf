//! How much later the camera's readings come than their ages say.
//!
//! A vehicle that hovers on readings that are older than it thinks swings: what its
//! law damps is past. The same swing tells the delay. K observers of the horizontal
//! place each believe another one, δ_k = k δ_max/(K - 1):
//!
//! ```text
//! p' = v,  v' = a - b,  b' = 0        a: measured acceleration of the time
//! e  = p_tag(t - age - δ_k) - p
//! p += (1 - θ³) e,  v += 3/2 (1 - θ)² (1 + θ) e/Δ,  b -= (1 - θ)³ e/Δ²,   θ = exp(-Δ/τ)
//! ```
//!
//! the polynomial filter of fading memory τ (Morrison 1969), Δ after the reading before:
//! biases, levelling errors and a deck that surges are slower than τ and are followed,
//! a swing is not. The reading is turned into the world's axes by the attitude of *its*
//! time, that of δ_k as well: above a tag at the height h a wrong one shows as an error
//! of place of the angle times h, mostly the larger part. Squares of e are summed up with
//! a memory of `evidence_s`; the least sum J, refined by the parabola through its
//! neighbours, is the delay.
//!
//! **Evidence.** With n counted readings, `n (J_k/J - 1)` is the logarithm of how much
//! better the best one explains them (both axes, errors normal, of unknown variance).
//! The delay is changed only where that exceeds `least_evidence` against the
//! delay that is believed or against none: a vehicle at rest tells nothing, and what was
//! learnt while it moved stays.
//!
//! Reckoned from the inertial unit, whose own age is taken to be known. What else comes
//! by the same way (a companion computer, a bus) comes as late; what does not, is not seen.
//! Delays below zero are none.

use crate::error::{SettingsError, positive, within};
use crate::estimate::relative::{Reading, RelativeFilter, RelativeState, TagReading};
use crate::kernel::usable_dt;
use crate::real::{Real, r};
use crate::space::Vector;

/// Delays that are compared.
const DELAYS: usize = 9;

/// Observers forget their start within this many of their memories.
const SETTLED: f64 = 5.0;

/// Estimator of an unknown delay; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LatencyEstimator<R> {
    /// Greatest delay that is looked for, s.
    pub greatest_s: R,
    /// Memory τ of the observers, s.
    pub memory_s: R,
    /// Time for which errors count, s.
    pub evidence_s: R,
    /// Logarithm of the odds from which a delay is believed.
    pub least_evidence: R,
}

/// The horizontal place as it is if readings are late by a certain delay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Believer<R> {
    /// Age of the place, s.
    age_s: R,
    place: Vector<R>,
    velocity: Vector<R>,
    bias: Vector<R>,
    /// Sum of squared errors, fading, m².
    squares: R,
}

/// State of a [`LatencyEstimator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatencyState<R> {
    believers: [Believer<R>; DELAYS],
    /// Time since all of them began; none before the first reading.
    followed_s: Option<R>,
    /// Readings whose errors count, fading.
    counted: R,
    delay_s: R,
}

impl<R: Real> LatencyState<R> {
    /// The delay that is believed, s.
    pub fn delay_s(&self) -> R {
        self.delay_s
    }
}

impl<R: Real> Default for LatencyEstimator<R> {
    /// Up to 0.16 s in steps of 20 ms, memory 0.3 s, evidence of 6 s, odds of e²⁰: errors
    /// of readings that follow each other are not independent.
    fn default() -> Self {
        Self {
            greatest_s: r(0.16),
            memory_s: r(0.3),
            evidence_s: r(6.0),
            least_evidence: r(20.0),
        }
    }
}

impl<R: Real> LatencyEstimator<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Times must be positive, the greatest delay at most 0.25 s.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let greatest_s = self.greatest_s;
        within(
            "latency.greatest_s",
            greatest_s,
            greatest_s > R::ZERO && greatest_s <= r(0.25),
            "a time above 0 and up to 0.25 s",
        )?;
        positive("latency.memory_s", self.memory_s)?;
        positive("latency.evidence_s", self.evidence_s)?;
        positive("latency.least_evidence", self.least_evidence)
    }

    /// The state before any reading: no delay.
    #[must_use]
    pub fn initial(&self) -> LatencyState<R> {
        LatencyState {
            believers: [Believer::default(); DELAYS],
            followed_s: None,
            counted: R::ZERO,
            delay_s: R::ZERO,
        }
    }

    /// `dt` seconds later, with the readings that have arrived, their ages as stamped.
    /// `relative` has been stepped by the same IMU sample.
    pub fn step<const N: usize, const M: usize>(
        &self,
        state: &mut LatencyState<R>,
        filter: &RelativeFilter<R>,
        relative: &RelativeState<R, N, M>,
        readings: &[Reading<R>],
        dt: R,
    ) {
        let dt = usable_dt(dt);
        for believer in &mut state.believers {
            believer.age_s += dt;
        }
        for reading in readings.iter().filter(|reading| reading.is_finite()) {
            if let Reading::Tag(tag) = reading {
                self.take(state, filter, relative, tag);
            }
        }
    }

    fn delay(&self, k: usize) -> R {
        self.greatest_s * r(k as f64 / (DELAYS - 1) as f64)
    }

    fn take<const N: usize, const M: usize>(
        &self,
        state: &mut LatencyState<R>,
        filter: &RelativeFilter<R>,
        relative: &RelativeState<R, N, M>,
        tag: &TagReading<R>,
    ) {
        let seen = |k: usize| {
            let age_s = tag.age_s + self.delay(k);
            let attitude = filter.attitude_at(relative, age_s);
            let arm = filter.tag.position_m + filter.tag.attitude.rotate(tag.position_m);
            (age_s, -attitude.rotate(arm))
        };
        // Readings come at the same times for all.
        let step_s = state.believers[0].age_s - tag.age_s;
        if state.followed_s.is_some() && step_s <= R::ZERO {
            return;
        }
        let mut next = state.believers;
        let (mut errors, mut all) = ([R::ZERO; DELAYS], state.followed_s.is_some());
        let gone = R::ONE - (-(step_s / self.memory_s)).exp();
        // A gap as long as the memory leaves nothing to go on from.
        all &= step_s < self.memory_s;
        for (k, believer) in next.iter_mut().enumerate() {
            let (age_s, place) = seen(k);
            match filter.moved(relative, believer.age_s, age_s) {
                Some(moved) if all => {
                    errors[k] = believer.follow(place, moved, step_s, gone);
                }
                _ => all = false,
            }
            believer.age_s = age_s;
        }
        if !(all && next.iter().all(Believer::is_finite)) {
            for (k, believer) in state.believers.iter_mut().enumerate() {
                let (age_s, place) = seen(k);
                *believer = Believer {
                    age_s,
                    place,
                    squares: believer.squares,
                    ..Believer::default()
                };
            }
            state.followed_s = Some(R::ZERO);
            return;
        }
        state.believers = next;
        let followed_s = state.followed_s.unwrap_or_default() + step_s;
        state.followed_s = Some(followed_s);
        if followed_s >= self.memory_s * r(SETTLED) {
            let kept = (-(step_s / self.evidence_s)).exp();
            state.counted = kept * state.counted + R::ONE;
            for (believer, error) in state.believers.iter_mut().zip(errors) {
                believer.squares = kept * believer.squares + error;
            }
            self.conclude(state, filter.tag.noise_sd_m);
        }
    }

    fn conclude(&self, state: &mut LatencyState<R>, noise_sd_m: R) {
        let squares = state.believers.map(|believer| believer.squares);
        let mut best = 0;
        for k in 1..DELAYS {
            if squares[k] < squares[best] {
                best = k;
            }
        }
        // The least one is never in the middle at an end; it may lie beyond.
        let middle = best.clamp(1, DELAYS - 2);
        let (before, after) = (squares[middle - 1], squares[middle + 1]);
        let bend = before + after - squares[middle] - squares[middle];
        let offset = (r::<R>(0.5) * (before - after) / bend).finite_or(R::ZERO);
        let place = (r::<R>(middle as f64) + offset).clamp(R::ZERO, r((DELAYS - 1) as f64));
        // What is left over is at least the detector's own noise.
        let floor = state.counted * (noise_sd_m * noise_sd_m + noise_sd_m * noise_sd_m);
        let unit = squares[best].max(floor) / state.counted;
        let evidence = |squares_m2: R| (squares_m2 - squares[best]) / unit;
        let believed = state.delay_s / self.delay(1);
        let lower = (0..DELAYS - 1)
            .rfind(|&k| r::<R>(k as f64) <= believed)
            .unwrap_or(0);
        let share = believed - r(lower as f64);
        let there = squares[lower] + share * (squares[lower + 1] - squares[lower]);
        if evidence(squares[0]).max(evidence(there)) > self.least_evidence {
            state.delay_s = place * self.delay(1);
        }
    }
}

impl<R: Real> Believer<R> {
    /// Goes on to where the vehicle has moved to within `step_s`, by which `gone` of the
    /// memory fades, and compares that with the place seen; gives the squared error.
    fn follow(
        &mut self,
        seen: Vector<R>,
        [faster, farther]: [Vector<R>; 2],
        step_s: R,
        gone: R,
    ) -> R {
        let half = r::<R>(0.5);
        self.place += (self.velocity - self.bias * (half * step_s)) * step_s + farther;
        self.velocity += faster - self.bias * step_s;
        let error = (seen - self.place).horizontal();
        let theta = R::ONE - gone;
        self.place += error * (R::ONE - theta * theta * theta);
        self.velocity += error * (r::<R>(1.5) * gone * gone * (R::ONE + theta) / step_s);
        self.bias -= error * (gone * gone * gone / (step_s * step_s));
        error.dot(error)
    }

    fn is_finite(&self) -> bool {
        self.place.is_finite() && self.velocity.is_finite() && self.bias.is_finite()
    }
}
