//! The deck's heave as up to three harmonics whose frequencies are estimated.
//!
//! ```text
//! p = o + Σ c_i    c_i' = -ω_i s_i - κ c_i    s_i' = ω_i c_i - κ s_i + w    ω_i' = 3 κ (Ω_i - ω_i) + w_ω
//! ```
//!
//! An extended Kalman filter estimates an offset o of the readings and, for each
//! harmonic, place c, quadrature s and angular frequency ω. For displacements the
//! offset has a rate. The rotation of (c, s) is propagated exactly.
//!
//! Amplitude and phase decay at the rate κ, and a white force w keeps the power: κ = 0
//! is a pure tone, and a sea of the relative bandwidth b has κ of the order of b ω. The
//! filter estimates the frequency of a tone. The less coherent the motion, the more the
//! frequency is pulled to Ω, the peak of the spectrum: an extended Kalman filter
//! estimates the frequency of a broad band with a bias (Ljung 1979).
//!
//! Why this estimator:
//!
//! * A tone is predicted as precisely as its parameters are known. An autoregressive
//!   predictor reaches this only at a high order.
//! * Frequencies are states. So their uncertainty, which decides how fast predictions
//!   lose their value, enters the standard deviation of a prediction.
//! * It costs no more than eleven states.
//!
//! Its weakness is a start at a wrong frequency. Two parts prevent that:
//!
//! * **Start.** Frequencies need not be known. A recursive least-squares fit of a
//!   constant and a harmonic runs at 32 frequencies, with a memory of 2.5 periods each.
//!   A harmonic starts at the best frequency after one observed period, if it explains
//!   the velocity. Further harmonics start at further peaks after two periods, if they
//!   are not the line shape of larger peaks (a ratio of frequencies of 1.5 suffices). In a
//!   motion that is hardly larger than the noise they start by the noise at its frequency,
//!   after three periods: 5 mm at 1 Hz in readings of 5 mm. A
//!   harmonic whose amplitude is not significant is dropped. If tones do not describe
//!   the motion, the remaining harmonics are placed above its peak.
//! * **Coherence.** κ is learnt. Predictions over `check_horizon_s` are compared with
//!   the later estimates, and κ changes until squared errors equal the predicted
//!   variances. A wrong frequency, a broad sea or too few harmonics then increase the
//!   standard deviation.
//!
//! Accuracy (100 Hz, readings of 5 mm or 0.03 m/s; `cargo run -p touchdown-lander
//! --example heave_prediction`):
//!
//! * The paper's deck is found after one period (2 s). After 6 s, predictions 1 s ahead
//!   have errors of 4 % (15 % from velocities), after 20 s of 1 % (5 %).
//! * Two tones with a frequency ratio of 1.7 are found within 15 s, mostly sooner.
//! * In a JONSWAP sea of 6 s, 0.5 m, errors 1 s ahead are 0.5 of the displacement and 0.7
//!   of velocity and acceleration. Errors 2 s ahead are 0.8 or more: three harmonics are
//!   few for a broad band.
//! * In that sea the truth lies within 1.96 standard deviations in 94 %, 93 % and 87 % of
//!   predictions 1 s ahead (in the first 30 s 92 %, 90 % and 84 %; 99 % for tones). The
//!   model contains no motion faster than half the sea's period, so the acceleration of
//!   that motion is missing.
//! * After a change of the deck's period, the estimator needs ten new periods. Its
//!   standard deviation is large in the meantime.
//!
//! A step of three harmonics costs 0.5 µs in `f64` on a server core, 1.3 µs if that
//! core is shared; a prediction costs 0.2 µs (`cargo bench -p touchdown-lander`).
//!
//! Readings are displacements (with any offset, as from
//! [`super::relative::DeckSighting`]) or velocities, all of the same age. Do not feed
//! the estimate back into the source of the readings.

mod coherence;
mod harmonics;
mod search;
mod spectrum;

use crate::check::{not_negative, positive};
use coherence::Learner;
use harmonics::{Coherence, Harmonics, MOST, Row};
use spectrum::Spectrum;
use touchdown_flight::error::{SettingsError, ordered, within};
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::{Real, r};

/// Quantity that the readings measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Observed {
    /// Height of the deck, m, with an offset that may drift.
    Displacement,
    /// Velocity of the deck, m/s, with an offset that may drift.
    Velocity,
}

/// Estimator of the deck's heave; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DeckEstimator<R> {
    /// Quantity that the readings measure.
    pub observed: Observed,
    /// White noise of a reading, standard deviation, m or m/s.
    pub measurement_sd: R,
    /// Age of the readings, s. Horizons of predictions count from now.
    pub delay_s: R,
    /// Largest number of harmonics, 1 to 3.
    pub harmonics: u8,
    /// Shortest period, s.
    pub shortest_period_s: R,
    /// Longest period, s.
    pub longest_period_s: R,
    /// Offset of the readings' mean from the first reading, standard deviation, m or
    /// m/s.
    pub offset_sd: R,
    /// Random walk of the offset, m/√s or m/s/√s.
    pub offset_drift: R,
    /// Displacement only: rate of the offset at the start, standard deviation, m/s. It
    /// equals the error of the vehicle's velocity.
    pub offset_rate_sd: R,
    /// Displacement only: random walk of that rate, m/s/√s. It equals the noise density
    /// of the accelerometer.
    pub offset_rate_drift: R,
    /// Innovations are limited to this many standard deviations.
    pub gate_sd: R,
    /// Horizon of the predictions that are compared with later estimates, s.
    pub check_horizon_s: R,
}

/// State of a [`DeckEstimator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckEstimatorState<R> {
    harmonics: Harmonics<R>,
    spectrum: Spectrum<R>,
    learner: Learner<R>,
    /// Number of peaks at which harmonics were started. Further harmonics only fill a
    /// broad band.
    started: usize,
    /// Normalised innovation squared, mean over a second: 1 if the model is complete.
    nis: R,
    /// Time since the harmonics were started, s.
    since_start_s: R,
    /// Time covered by readings, s.
    observed_s: R,
    /// Time since the last reading, s.
    unseen_s: R,
    /// The first reading; it is subtracted from all readings.
    origin: Option<R>,
    /// The last reading, less the first one.
    last: R,
    not_finite: u32,
}

/// The deck's motion at a time, with standard deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeckMotionPrediction<R> {
    /// Height about the mean, m.
    pub displacement_m: R,
    /// Velocity, up, m/s.
    pub velocity_mps: R,
    /// Acceleration, up, m/s².
    pub acceleration_mps2: R,
    /// Standard deviation of the height, m.
    pub displacement_sd_m: R,
    /// Standard deviation of the velocity, m/s.
    pub velocity_sd_mps: R,
    /// Standard deviation of the acceleration, m/s².
    pub acceleration_sd_mps2: R,
}

/// An estimated harmonic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic<R> {
    /// Amplitude, m.
    pub amplitude_m: R,
    /// Angular frequency, rad/s.
    pub angular_frequency: R,
    /// Standard deviation of the angular frequency, rad/s.
    pub angular_frequency_sd: R,
}

/// Largest credible reading, m or m/s. It only keeps the sums of squares finite in `f32`,
/// so any value far above a deck's motion serves.
const LARGEST_READING: f64 = 1e6;

/// Shortest periods for which a deck is observed before the spread of its velocities says how fast it moves. After one, rough heights from
/// high up seem to spread by metres a second.
const KNOWN_PERIODS: f64 = 2.0;

impl<R: Real> DeckEstimator<R> {
    /// Three harmonics with periods of 0.4 to 16 s; readings of age zero; a gate of four standard
    /// deviations; checks of predictions over 1 s.
    ///
    /// The offset is 1 m or m/s and drifts by 0.002 in a second. Its rate is 0.02 m/s
    /// and drifts by 0.002 m/s in a second.
    #[must_use]
    pub fn new(observed: Observed, measurement_sd: R) -> Self {
        Self {
            observed,
            measurement_sd,
            delay_s: R::ZERO,
            harmonics: 3,
            shortest_period_s: r(0.4),
            longest_period_s: r(16.0),
            offset_sd: R::ONE,
            offset_drift: r(0.002),
            offset_rate_sd: r(0.02),
            offset_rate_drift: r(0.002),
            gate_sd: r(4.0),
            check_horizon_s: R::ONE,
        }
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("deck_estimator.measurement_sd", self.measurement_sd)?;
        not_negative("deck_estimator.delay_s", self.delay_s)?;
        within(
            "deck_estimator.harmonics",
            r::<R>(f64::from(self.harmonics)),
            (1..=MOST).contains(&usize::from(self.harmonics)),
            "a number from 1 to 3",
        )?;
        positive("deck_estimator.shortest_period_s", self.shortest_period_s)?;
        ordered(
            "deck_estimator.shortest_period_s",
            self.shortest_period_s,
            "deck_estimator.longest_period_s",
            self.longest_period_s,
        )?;
        positive("deck_estimator.offset_sd", self.offset_sd)?;
        not_negative("deck_estimator.offset_drift", self.offset_drift)?;
        not_negative("deck_estimator.offset_rate_sd", self.offset_rate_sd)?;
        not_negative("deck_estimator.offset_rate_drift", self.offset_rate_drift)?;
        positive("deck_estimator.gate_sd", self.gate_sd)?;
        positive("deck_estimator.check_horizon_s", self.check_horizon_s)
    }

    /// Lowest and highest angular frequency, rad/s.
    fn band(&self) -> [R; 2] {
        let turn = r::<R>(core::f64::consts::TAU);
        [turn / self.longest_period_s, turn / self.shortest_period_s]
    }

    /// The state before any reading.
    #[must_use]
    pub fn initial(&self) -> DeckEstimatorState<R> {
        let [lowest, highest] = self.band();
        DeckEstimatorState {
            harmonics: Harmonics::new(R::ZERO, self.offset_variance()),
            spectrum: Spectrum::new(lowest, highest),
            learner: Learner::new(),
            started: 0,
            nis: R::ONE,
            since_start_s: R::ZERO,
            observed_s: R::ZERO,
            unseen_s: r(f64::INFINITY),
            origin: None,
            last: R::ZERO,
            not_finite: 0,
        }
    }

    /// Returns a state to [`Self::initial`] in place.
    #[inline(never)]
    pub fn reset(&self, state: &mut DeckEstimatorState<R>) {
        let [lowest, highest] = self.band();
        state.harmonics.reset(R::ZERO, self.offset_variance());
        state.spectrum.reset(lowest, highest);
        state.learner = Learner::new();
        (state.started, state.not_finite) = (0, 0);
        state.nis = R::ONE;
        (state.since_start_s, state.observed_s) = (R::ZERO, R::ZERO);
        state.unseen_s = r(f64::INFINITY);
        (state.origin, state.last) = (None, R::ZERO);
    }

    /// Variances of the offset and its rate.
    fn offset_variance(&self) -> [R; 2] {
        let rate = match self.observed {
            Observed::Displacement => self.offset_rate_sd,
            Observed::Velocity => R::ZERO,
        };
        [self.offset_sd * self.offset_sd, rate * rate]
    }

    fn coherence(&self, state: &DeckEstimatorState<R>) -> Coherence<R> {
        let rate = match self.observed {
            Observed::Displacement => self.offset_rate_drift,
            Observed::Velocity => R::ZERO,
        };
        let drift = [self.offset_drift * self.offset_drift, rate * rate];
        state.learner.coherence(drift)
    }

    /// Propagates over `dt` seconds and corrects by the reading at their end, if there
    /// is one. A reading that is not finite, or beyond 1e6, is counted and ignored.
    #[inline(never)]
    pub fn step(&self, state: &mut DeckEstimatorState<R>, reading: Option<R>, dt: R) {
        let dt = usable_dt(dt);
        let finite = reading.filter(|y| y.abs() < r(LARGEST_READING));
        let mut usable = finite.map(|y| y - *state.origin.get_or_insert(y));
        if reading.is_some() && finite.is_none() {
            state.not_finite = state.not_finite.saturating_add(1);
        }
        let before = state.harmonics;
        let coherence = self.coherence(state);
        state.harmonics.propagate(&coherence, dt);
        state.unseen_s += dt;
        state.since_start_s += dt;
        if let Some(y) = usable {
            self.count_observed_time(state);
            state.last = y;
            let row = match self.observed {
                Observed::Displacement => Row::Displacement,
                Observed::Velocity => Row::Velocity,
            };
            let noise = self.measurement_sd * self.measurement_sd;
            let (counted, nis) = state.harmonics.correct(row, y, noise, self.gate_sd);
            state.nis += dt.min(R::ONE) * (nis - state.nis);
            if state.harmonics.count() > 0 {
                // The search uses the limited reading, too.
                usable = Some(counted);
            }
        }
        let [lowest, highest] = self.band();
        state.harmonics.limit(lowest, highest);
        if !state.harmonics.is_finite() {
            state.harmonics = before;
            return;
        }
        state.spectrum.step(self.observed, usable, dt);
        if state.spectrum.round_done() {
            self.revise(state);
        }
        if state.harmonics.count() > 0 && state.learner.due(dt, self.check_horizon_s) {
            let coherence = self.coherence(state);
            // The comparison uses the measured quantity and its rate of change.
            let observable = |time: R| {
                let motion = state.harmonics.predict(&coherence, time);
                match self.observed {
                    Observed::Displacement => [
                        motion.displacement_m,
                        motion.velocity_mps,
                        motion.displacement_sd_m,
                    ],
                    Observed::Velocity => [
                        motion.velocity_mps,
                        motion.acceleration_mps2,
                        motion.velocity_sd_mps,
                    ],
                }
            };
            let (now, ahead) = (observable(R::ZERO), observable(self.check_horizon_s));
            state.learner.check(self.check_horizon_s, now, ahead);
        }
    }

    /// Adds the time since the previous reading to the observed time, unless it exceeds
    /// the shortest period. A gap longer than the longest period resets the observed time.
    fn count_observed_time(&self, state: &mut DeckEstimatorState<R>) {
        if state.unseen_s > self.longest_period_s {
            state.observed_s = R::ZERO;
        } else if state.unseen_s <= self.shortest_period_s {
            state.observed_s += state.unseen_s;
        }
        state.unseen_s = R::ZERO;
    }

    /// The motion `horizon_s` from now, which is `horizon_s + delay_s` after the last
    /// reading.
    ///
    /// Before the first harmonic starts, the predicted motion is zero, with the spread of
    /// the readings beyond their noise as its standard deviation. Before the deck has
    /// been observed for two of the shortest periods, standard deviations are infinite.
    #[must_use]
    pub fn predict(&self, state: &DeckEstimatorState<R>, horizon_s: R) -> DeckMotionPrediction<R> {
        let time = self.since_reading_s(horizon_s);
        if state.harmonics.count() > 0 {
            state.harmonics.predict(&self.coherence(state), time)
        } else {
            self.unknown(state)
        }
    }

    /// As [`Self::predict`] without the height, sooner: height and its standard deviation
    /// are zero once there are harmonics.
    #[must_use]
    pub fn predict_motion(
        &self,
        state: &DeckEstimatorState<R>,
        horizon_s: R,
    ) -> DeckMotionPrediction<R> {
        let time = self.since_reading_s(horizon_s);
        if state.harmonics.count() > 0 {
            let coherence = self.coherence(state);
            state.harmonics.predict_motion(&coherence, time)
        } else {
            self.unknown(state)
        }
    }

    /// The acceleration of [`Self::predict`], m/s², sooner.
    #[must_use]
    pub fn predict_acceleration(&self, state: &DeckEstimatorState<R>, horizon_s: R) -> R {
        let time = self.since_reading_s(horizon_s);
        let coherence = self.coherence(state);
        state.harmonics.predict_acceleration(&coherence, time)
    }

    /// Time between the last reading and a horizon.
    fn since_reading_s(&self, horizon_s: R) -> R {
        (horizon_s + self.delay_s).max(R::ZERO)
    }

    /// The motion of a deck without harmonics.
    fn unknown(&self, state: &DeckEstimatorState<R>) -> DeckMotionPrediction<R> {
        let noise = self.measurement_sd * self.measurement_sd;
        let unknown = [r(f64::INFINITY), R::ONE];
        let [variance, w] = if state.observed_s < r::<R>(KNOWN_PERIODS) * self.shortest_period_s {
            unknown
        } else {
            state.spectrum.spread(noise).unwrap_or(unknown)
        };
        let velocity_sd_mps = variance.sqrt();
        DeckMotionPrediction {
            displacement_sd_m: velocity_sd_mps / w,
            velocity_sd_mps,
            acceleration_sd_mps2: velocity_sd_mps * w,
            ..DeckMotionPrediction::default()
        }
    }
}

impl<R: Real> DeckEstimatorState<R> {
    /// Number of harmonics.
    #[must_use]
    pub fn count(&self) -> usize {
        self.harmonics.count()
    }

    /// The k-th harmonic; the order has no meaning.
    #[must_use]
    pub fn harmonic(&self, k: usize) -> Option<Harmonic<R>> {
        (k < self.harmonics.count()).then(|| Harmonic {
            amplitude_m: self.harmonics.power(k).sqrt(),
            angular_frequency: self.harmonics.frequency(k),
            angular_frequency_sd: self.harmonics.frequency_sd(k),
        })
    }

    /// Decay rate κ of amplitude and phase, 1/s.
    #[must_use]
    pub fn forgetting_per_s(&self) -> R {
        self.learner.rate()
    }

    /// Time for which the deck has been observed, s. Gaps longer than the shortest
    /// period do not count; a gap longer than the longest period resets the time.
    #[must_use]
    pub fn observed_s(&self) -> R {
        self.observed_s
    }

    /// Number of readings that were not finite.
    #[must_use]
    pub fn not_finite(&self) -> u32 {
        self.not_finite
    }
}
