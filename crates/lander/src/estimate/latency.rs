//! Unknown latency of the camera: the true age of its readings less the stamped age.
//!
//! Old readings make the vehicle oscillate in hover, because its control law damps a
//! past velocity. This oscillation identifies the latency. K observers of the
//! horizontal position each assume a different latency, δ_k = k δ_max/(K - 1):
//!
//! ```text
//! p' = v,  v' = a - b,  b' = 0        a: measured acceleration of the time
//! e  = p_tag(t - age - δ_k) - p
//! p += (1 - θ³) e,  v += 3/2 (1 - θ)² (1 + θ) e/Δ,  b -= (1 - θ)³ e/Δ²,   θ = exp(-Δ/τ)
//! ```
//!
//! This is the polynomial filter of fading memory τ (Morrison 1969); Δ is the time since
//! the previous reading. Biases, levelling errors and the deck's surge are slower than τ,
//! so the filter follows them. It does not follow an oscillation.
//!
//! A deck that sways by A at the angular frequency ω leaves the error (ωτ)³ A in every
//! observer: at a period of 5 s 7 mm per metre with τ = 0.15 s, 5 cm with τ = 0.3 s. If the
//! vehicle follows this deck late, the error resembles that of a latency. It must stay
//! below the noise of the camera, so τ is short. The first estimate takes 5 τ as well.
//!
//! The attitude of the assumed time turns each reading into world axes. At the height h
//! above a tag, a wrong attitude adds a position error of the angle times h. This is
//! usually the larger part of e.
//!
//! Each observer sums the squares of e with a memory of `evidence_s`. The latency is that
//! of the least sum J, refined by the parabola through its neighbours.
//!
//! **Evidence.** With n counted readings, `n (J_k/J - 1)` is the logarithm of the odds of
//! the best latency against δ_k (both axes, normal errors of unknown variance). The
//! estimate changes only if this exceeds `least_evidence`, against the present estimate or
//! against zero. A vehicle at rest gives no evidence, so it keeps the estimate.
//!
//! **Limits.** The latency is relative to the inertial unit, whose own latency is assumed
//! known. All sensors on the camera's path (a companion computer, a bus) are assumed to
//! have this latency; others are not corrected. The latency cannot be negative.
//!
//! **Range.** The [`RelativeState`] remembers N - 1 steps (0.31 s at 100 Hz). A latency is
//! compared only if this covers a reading and its predecessor at that latency. With
//! readings stamped 0.14 s old every 30 ms, the largest identifiable latency is 0.14 s.
//! An estimate beyond this range stays until a latency inside the range fits best.

use crate::estimate::relative::{Reading, RelativeFilter, RelativeState, TagReading};
use touchdown_flight::error::{SettingsError, positive, within};
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// Number of latencies that are compared. With the default range they are 20 ms apart:
/// less than one camera frame of 30 ms, so that the parabola interpolates well.
const HYPOTHESES: usize = 12;

/// Memories τ after which an observer has forgotten its start: exp(-5) is below 1 %.
const SETTLED: f64 = 5.0;

/// Memories τ of a gap between readings after which the observers start again.
const GAP: f64 = 2.0;

/// Least share of the first observer's readings that another observer must have counted.
/// Below it the sums cover different flight times, so they are not comparable.
const LEAST_COMMON_SHARE: f64 = 0.9;

/// Estimator of an unknown latency; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LatencyEstimator<R> {
    /// Largest latency that is considered, s.
    pub greatest_s: R,
    /// Memory τ of the observers, s.
    pub memory_s: R,
    /// Memory of the sums of squared errors, s.
    pub evidence_s: R,
    /// Logarithm of the odds above which the estimate changes.
    pub least_evidence: R,
}

/// Observer of the horizontal position under one assumed latency.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Hypothesis<R> {
    /// Age of the position, s.
    age_s: R,
    place: Vector<R>,
    velocity: Vector<R>,
    bias: Vector<R>,
    /// Time since the observer started, s; none before the first reading.
    followed_s: Option<R>,
    /// Sum of squared errors with fading memory, m².
    squares: R,
    /// Number of these errors, with the same memory.
    counted: R,
}

/// State of a [`LatencyEstimator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatencyState<R> {
    hypotheses: [Hypothesis<R>; HYPOTHESES],
    latency_s: R,
}

impl<R: Real> LatencyState<R> {
    /// The estimated latency, s.
    pub fn latency_s(&self) -> R {
        self.latency_s
    }
}

impl<R: Real> Default for LatencyEstimator<R> {
    /// Up to 0.22 s in steps of 20 ms, memory 0.15 s, evidence of 6 s, odds of e²⁰. The
    /// odds are this high because errors of successive readings are correlated.
    fn default() -> Self {
        Self {
            greatest_s: r(0.22),
            memory_s: r(0.15),
            evidence_s: r(6.0),
            least_evidence: r(20.0),
        }
    }
}

impl<R: Real> LatencyEstimator<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Times must be positive and the largest latency at most 0.25 s.
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

    /// The state before any reading: zero latency.
    #[must_use]
    pub fn initial(&self) -> LatencyState<R> {
        LatencyState {
            hypotheses: [Hypothesis::default(); HYPOTHESES],
            latency_s: R::ZERO,
        }
    }

    /// Advances by `dt` seconds with the readings that have arrived. Their ages are the
    /// stamped ones. `relative` must have been stepped by the same IMU sample.
    pub fn step<const N: usize, const M: usize>(
        &self,
        state: &mut LatencyState<R>,
        filter: &RelativeFilter<R>,
        relative: &RelativeState<R, N, M>,
        readings: &[Reading<R>],
        dt: R,
    ) {
        let dt = usable_dt(dt);
        for hypothesis in &mut state.hypotheses {
            hypothesis.age_s += dt;
        }
        for reading in readings.iter().filter(|reading| reading.is_finite()) {
            if let Reading::Tag(tag) = reading {
                self.compare(state, filter, relative, tag);
            }
        }
    }

    fn latency(&self, k: usize) -> R {
        self.greatest_s * (R::from_count(k) / R::from_count(HYPOTHESES - 1))
    }

    /// Advances all observers to a tag reading and adds up their errors.
    #[inline(never)]
    fn compare<const N: usize, const M: usize>(
        &self,
        state: &mut LatencyState<R>,
        filter: &RelativeFilter<R>,
        relative: &RelativeState<R, N, M>,
        tag: &TagReading<R>,
    ) {
        // The interval between readings is the same for all observers.
        let first = &state.hypotheses[0];
        let step_s = first.age_s - tag.age_s;
        if first.followed_s.is_some() && step_s <= R::ZERO {
            return;
        }
        let gone = R::ONE - (-(step_s / self.memory_s)).exp();
        let gap = step_s >= self.memory_s * r(GAP);
        // Of the memory's filter: for place, velocity and bias.
        let theta = R::ONE - gone;
        let gains = [
            R::ONE - theta * theta * theta,
            r::<R>(1.5) * gone * gone * (R::ONE + theta) / step_s,
            gone * gone * gone / (step_s * step_s),
        ];
        let arm = filter.tag.position_m + filter.tag.attitude.rotate(tag.position_m);
        let mut errors = [R::ZERO; HYPOTHESES];
        for (k, hypothesis) in state.hypotheses.iter_mut().enumerate() {
            let age_s = tag.age_s + self.latency(k);
            let attitude = filter.attitude_at(relative, age_s);
            let place = -attitude.rotate(arm);
            let moved = filter.moved(relative, hypothesis.age_s, age_s);
            let mut next = Hypothesis {
                age_s,
                followed_s: hypothesis.followed_s.map(|so_far| so_far + step_s),
                ..*hypothesis
            };
            *hypothesis = match moved.filter(|_| !gap && next.followed_s.is_some()) {
                Some(moved) => {
                    errors[k] = next.follow(place, moved, step_s, gains);
                    next
                }
                None => hypothesis.restarted(place, age_s),
            };
            if !hypothesis.is_finite() {
                *hypothesis = hypothesis.restarted(place, age_s);
            }
        }
        // While the filter's memory still fills, the other observers start later than the
        // first: by their latencies plus one interval between readings.
        let wait_s = self.greatest_s + step_s;
        if self.is_settled(&state.hypotheses[0], wait_s) {
            let kept = (-(step_s / self.evidence_s)).exp();
            for (k, error) in errors.into_iter().enumerate() {
                let settled = self.is_settled(&state.hypotheses[k], R::ZERO);
                state.hypotheses[k].count(error, settled, kept);
            }
            self.conclude(state, filter.tag.noise_sd_m);
        }
    }

    /// Whether the observer forgot its start at least `since_s` ago.
    fn is_settled(&self, hypothesis: &Hypothesis<R>, since_s: R) -> bool {
        let least_s = self.memory_s * r(SETTLED) + since_s;
        hypothesis
            .followed_s
            .is_some_and(|so_far| so_far >= least_s)
    }

    #[inline(never)]
    fn conclude(&self, state: &mut LatencyState<R>, noise_sd_m: R) {
        let counted = state.hypotheses[0].counted;
        let compared = state
            .hypotheses
            .iter()
            .take_while(|one| {
                self.is_settled(one, R::ZERO) && one.counted >= counted * r(LEAST_COMMON_SHARE)
            })
            .count();
        // The parabola needs three points.
        if compared < 3 {
            return;
        }
        let last = compared - 1;
        let mut squares = [R::ZERO; HYPOTHESES];
        for (mean, one) in squares.iter_mut().zip(&state.hypotheses).take(compared) {
            *mean = one.squares / one.counted;
        }
        let (mut best, mut least) = (0, squares[0]);
        for (k, &mean) in squares.iter().enumerate().take(compared) {
            if mean < least {
                (best, least) = (k, mean);
            }
        }
        let squares = |k: usize| squares.get(k).copied().unwrap_or(least);
        let believed = state.latency_s / self.latency(1);
        if best == last && believed > R::from_count(last) {
            return;
        }
        // At an end of the range the parabola is centred on the next latency inside.
        let middle = best.max(1).min(last - 1);
        let (before, after) = (squares(middle - 1), squares(middle + 1));
        let bend = before + after - squares(middle) - squares(middle);
        let offset = (r::<R>(0.5) * (before - after) / bend).finite_or(R::ZERO);
        let place = (R::from_count(middle) + offset).clamp(R::ZERO, R::from_count(last));
        // The mean squared error of two axes is at least the detector's own noise.
        let floor = noise_sd_m * noise_sd_m + noise_sd_m * noise_sd_m;
        let unit = least.max(floor) / counted;
        let evidence = |squares_m2: R| (squares_m2 - least) / unit;
        let lower = (0..last)
            .rfind(|&k| R::from_count(k) <= believed)
            .unwrap_or(0);
        let share = (believed - R::from_count(lower)).min(R::ONE);
        let there = squares(lower) + share * (squares(lower + 1) - squares(lower));
        if evidence(squares(0)).max(evidence(there)) > self.least_evidence {
            state.latency_s = place * self.latency(1);
        }
    }
}

impl<R: Real> Hypothesis<R> {
    /// Restarts at a measured position and keeps the sums of errors.
    fn restarted(&self, place: Vector<R>, age_s: R) -> Self {
        Self {
            age_s,
            place,
            followed_s: Some(R::ZERO),
            squares: self.squares,
            counted: self.counted,
            ..Self::default()
        }
    }

    /// Adds the squared error of a reading if it `counts`; the sums first fade to the
    /// share `kept`.
    fn count(&mut self, error: R, counts: bool, kept: R) {
        self.squares *= kept;
        self.counted *= kept;
        if counts {
            self.squares += error;
            self.counted += R::ONE;
        }
    }

    /// Advances by `step_s` with the measured motion, corrects by the measured position
    /// and returns the squared error. The gains are those for place, velocity and bias.
    fn follow(
        &mut self,
        measured: Vector<R>,
        [faster, farther]: [Vector<R>; 2],
        step_s: R,
        gains: [R; 3],
    ) -> R {
        let half = r::<R>(0.5);
        self.place += (self.velocity - self.bias * (half * step_s)) * step_s + farther;
        self.velocity += faster - self.bias * step_s;
        let error = (measured - self.place).horizontal();
        let [of_place, of_velocity, of_bias] = gains;
        self.place += error * of_place;
        self.velocity += error * of_velocity;
        self.bias -= error * of_bias;
        error.dot(error)
    }

    fn is_finite(&self) -> bool {
        self.place.is_finite() && self.velocity.is_finite() && self.bias.is_finite()
    }
}
