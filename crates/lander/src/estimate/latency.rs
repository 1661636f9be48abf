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
//!
//! **Reach.** The [`RelativeState`] remembers N - 1 steps (0.31 s at 100 Hz). Delays for
//! which a reading and the one before it are older than that are left out of the
//! comparison: where readings are stamped 0.14 s old and come every 30 ms, the greatest one
//! that is found is 0.14 s. One that was believed beyond them stays until one within
//! them, not the greatest, is the best.

use crate::estimate::relative::{Reading, RelativeFilter, RelativeState, TagReading};
use touchdown_flight::error::{SettingsError, positive, within};
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// Delays that are compared.
const DELAYS: usize = 9;

/// Observers forget their start within this many of their memories.
const SETTLED: f64 = 5.0;

/// Observers whose errors are of the same time are compared: to this share of the count.
const COMMON: f64 = 0.9;

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
    /// Time since it began; none before the first reading.
    followed_s: Option<R>,
    /// Sum of squared errors, fading, m².
    squares: R,
    /// Number of them, fading alike.
    counted: R,
}

/// State of a [`LatencyEstimator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatencyState<R> {
    believers: [Believer<R>; DELAYS],
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
        // Readings come at the same times for all.
        let first = &state.believers[0];
        let step_s = first.age_s - tag.age_s;
        if first.followed_s.is_some() && step_s <= R::ZERO {
            return;
        }
        let gone = R::ONE - (-(step_s / self.memory_s)).exp();
        // A gap as long as the memory leaves nothing to go on from.
        let gap = step_s >= self.memory_s;
        let mut errors = [R::ZERO; DELAYS];
        for (k, believer) in state.believers.iter_mut().enumerate() {
            let age_s = tag.age_s + self.delay(k);
            let attitude = filter.attitude_at(relative, age_s);
            let arm = filter.tag.position_m + filter.tag.attitude.rotate(tag.position_m);
            let place = -attitude.rotate(arm);
            let moved = filter.moved(relative, believer.age_s, age_s);
            let mut next = Believer {
                age_s,
                followed_s: believer.followed_s.map(|so_far| so_far + step_s),
                ..*believer
            };
            *believer = match moved.filter(|_| !gap && next.followed_s.is_some()) {
                Some(moved) => {
                    errors[k] = next.follow(place, moved, step_s, gone);
                    next
                }
                None => believer.begun(place, age_s),
            };
            if !believer.is_finite() {
                *believer = believer.begun(place, age_s);
            }
        }
        // Where less is remembered than will be, the others begin later than the first by
        // their delays, and the time to a reading.
        let wait_s = self.greatest_s + step_s;
        if self.is_settled(&state.believers[0], wait_s) {
            let kept = (-(step_s / self.evidence_s)).exp();
            for (k, error) in errors.into_iter().enumerate() {
                let settled = self.is_settled(&state.believers[k], R::ZERO);
                state.believers[k].count(error, settled, kept);
            }
            self.conclude(state, filter.tag.noise_sd_m);
        }
    }

    /// The start was forgotten `since_s` ago.
    fn is_settled(&self, believer: &Believer<R>, since_s: R) -> bool {
        let least_s = self.memory_s * r(SETTLED) + since_s;
        believer.followed_s.is_some_and(|so_far| so_far >= least_s)
    }

    fn conclude(&self, state: &mut LatencyState<R>, noise_sd_m: R) {
        let counted = state.believers[0].counted;
        let compared = state
            .believers
            .iter()
            .take_while(|one| self.is_settled(one, R::ZERO) && one.counted >= counted * r(COMMON))
            .count();
        // A parabola takes three.
        if compared < 3 {
            return;
        }
        let last = compared - 1;
        let mut squares = [R::ZERO; DELAYS];
        for (mean, one) in squares.iter_mut().zip(&state.believers[..compared]) {
            *mean = one.squares / one.counted;
        }
        let mut best = 0;
        for k in 1..compared {
            if squares[k] < squares[best] {
                best = k;
            }
        }
        let believed = state.delay_s / self.delay(1);
        if best == last && believed > r(last as f64) {
            return;
        }
        // The least one is never in the middle at an end; it may lie beyond.
        let middle = best.clamp(1, last - 1);
        let (before, after) = (squares[middle - 1], squares[middle + 1]);
        let bend = before + after - squares[middle] - squares[middle];
        let offset = (r::<R>(0.5) * (before - after) / bend).finite_or(R::ZERO);
        let place = (r::<R>(middle as f64) + offset).clamp(R::ZERO, r(last as f64));
        // What is left over is at least the detector's own noise.
        let floor = noise_sd_m * noise_sd_m + noise_sd_m * noise_sd_m;
        let unit = squares[best].max(floor) / counted;
        let evidence = |squares_m2: R| (squares_m2 - squares[best]) / unit;
        let lower = (0..last)
            .rfind(|&k| r::<R>(k as f64) <= believed)
            .unwrap_or(0);
        let share = (believed - r(lower as f64)).min(R::ONE);
        let there = squares[lower] + share * (squares[lower + 1] - squares[lower]);
        if evidence(squares[0]).max(evidence(there)) > self.least_evidence {
            state.delay_s = place * self.delay(1);
        }
    }
}

impl<R: Real> Believer<R> {
    /// Anew from a place seen; errors that count stay.
    fn begun(&self, place: Vector<R>, age_s: R) -> Self {
        Self {
            age_s,
            place,
            followed_s: Some(R::ZERO),
            squares: self.squares,
            counted: self.counted,
            ..Self::default()
        }
    }

    /// One reading later, of which `kept` of what was counted is left.
    fn count(&mut self, error: R, counts: bool, kept: R) {
        self.squares *= kept;
        self.counted *= kept;
        if counts {
            self.squares += error;
            self.counted += R::ONE;
        }
    }

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
