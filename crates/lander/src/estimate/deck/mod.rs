//! The deck's heave as up to three harmonics whose frequencies are estimated.
//!
//! ```text
//! p = o + Σ c_i    c_i' = -ω_i s_i - κ c_i    s_i' = ω_i c_i - κ s_i + w    ω_i' = 3 κ (Ω_i - ω_i) + w_ω
//! ```
//!
//! An extended Kalman filter of the readings' constant o (with a rate, for
//! displacements), place c, quadrature s and angular frequency ω of each harmonic,
//! propagated by the exact rotation. Amplitude and phase are forgotten at the rate κ
//! and driven by a white force that keeps the power; κ = 0 is a pure tone, and a sea
//! of the relative width b has κ of the order of b ω. A tone's frequency is
//! estimated by the filter; the less coherent the motion, the more it is drawn to
//! the frequency Ω of the spectrum's peak, for an extended Kalman filter misjudges
//! the frequency of a broad band (Ljung 1979).
//!
//! Why this and not another: a tone is predicted to the precision of its
//! parameters, which a general linear predictor (autoregressive) reaches only at a
//! high order; frequencies are states, so that their uncertainty, which decides
//! how fast a prediction ages, enters the prediction's standard deviation; and the
//! cost is that of eleven states. Its weakness, a frequency that starts too far off,
//! is met in two ways:
//!
//! * **Start.** Frequencies need not be known. A least-squares fit of a constant and
//!   a harmonic runs at 32 frequencies with a memory of 2.5 periods each, without
//!   storing readings; when the best one has been seen for a period and explains
//!   the velocity, a harmonic starts there. Further ones start where the search has
//!   further peaks that have been seen for two periods and are not the line shape of
//!   larger ones (frequencies a factor 1.5 apart); one whose amplitude is not told
//!   from zero is dropped. A motion that no tones describe gets what is left of the
//!   harmonics above its peak.
//! * **Coherence.** κ is learnt: predictions over `check_horizon_s` are compared with
//!   what became of them, and κ moves until squared errors are as large as the filter
//!   says. A frequency that is wrong, a sea that is broad, a harmonic too few then
//!   show as a larger standard deviation.
//!
//! What it reaches (100 Hz, readings of 5 mm or 0.03 m/s; example `heave_prediction`):
//! the paper's deck is found after one period (2 s); after 6 s it is predicted 1 s
//! ahead to 4 % (10 % from velocities), after 20 s to 1 % (5 %). Two tones 1.7 apart are
//! found within 15 s, mostly sooner. In a JONSWAP sea of 6 s, 0.5 m, predictions 1 s ahead
//! leave 0.5 of the displacement, 0.7 of the velocity and of the acceleration, 2 s
//! ahead 0.8 or more: three harmonics are few for a broad band. The truth lies within
//! 1.96 standard deviations in 94 %, 93 % and 89 % of predictions over 1 s (in the first
//! 30 s 91 %, 89 % and 85 %; in 99 % for tones): what is shorter than half the sea's period
//! is not modelled, and its acceleration not counted. When a deck changes its period, ten
//! periods of the new one pass until it is known as before; the standard deviation is
//! large meanwhile.
//!
//! A step of three harmonics costs 0.5 µs in `f64` on a server core, 1.3 µs with that
//! core shared, and a prediction 0.2 µs (`cargo bench -p touchdown-flight`).
//!
//! Readings are displacement (with any constant, as of
//! [`super::relative::DeckSighting`]) or velocity, all of the same age. The chain
//! goes one way: do not feed the result back into the readings' source.

mod coherence;
mod harmonics;
mod search;
mod spectrum;

use coherence::Learner;
use harmonics::{Coherence, Harmonics, MOST, Row};
use spectrum::Spectrum;
use touchdown_flight::error::{SettingsError, not_negative, ordered, positive, within};
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::{Real, r};

/// What readings show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Observed {
    /// Height of the deck, m, up to a constant that may drift.
    Displacement,
    /// Velocity of the deck, m/s, up to a constant that may drift.
    Velocity,
}

/// Estimator of the deck's heave; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DeckEstimator<R> {
    /// What the readings show.
    pub observed: Observed,
    /// White noise of a reading, standard deviation, m or m/s.
    pub measurement_sd: R,
    /// Age of the readings, s. Predictions are counted from now.
    pub delay_s: R,
    /// Most harmonics, 1 to 3.
    pub harmonics: u8,
    /// Shortest period, s.
    pub shortest_period_s: R,
    /// Longest period, s.
    pub longest_period_s: R,
    /// What the first reading differs by from the readings' mean, standard
    /// deviation, m or m/s.
    pub offset_sd: R,
    /// Its drift, m/√s or m/s/√s.
    pub offset_drift: R,
    /// Displacement only: the rate of that constant at the start, standard deviation,
    /// m/s; the error of the vehicle's velocity.
    pub offset_rate_sd: R,
    /// Displacement only: its drift, m/s/√s; the noise density of the accelerometer.
    pub offset_rate_drift: R,
    /// A reading further than this many standard deviations from what is expected
    /// counts as that far.
    pub gate_sd: R,
    /// Time over which predictions are compared with what becomes of them, s.
    pub check_horizon_s: R,
}

/// State of a [`DeckEstimator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckEstimatorState<R> {
    harmonics: Harmonics<R>,
    spectrum: Spectrum<R>,
    learner: Learner<R>,
    /// Peaks at which harmonics were started; further ones only fill a broad band.
    started: usize,
    /// Mean normalised innovation squared over a second: 1 where nothing is missing.
    nis: R,
    /// Time since the harmonics were started, s.
    since_start_s: R,
    /// Time covered by readings, s.
    observed_s: R,
    /// Time since the last reading, s.
    unseen_s: R,
    /// The first reading, from which the others are counted.
    origin: Option<R>,
    /// The last reading, from it.
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

/// A harmonic as estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic<R> {
    /// Amplitude, m.
    pub amplitude_m: R,
    /// Angular frequency, rad/s.
    pub angular_frequency: R,
    /// Its standard deviation, rad/s.
    pub angular_frequency_sd: R,
}

/// Readings further from zero than this (m or m/s) are no deck's.
const FARTHEST: f64 = 1e6;

impl<R: Real> DeckEstimator<R> {
    /// Three harmonics of 0.8 to 16 s; readings of `measurement_sd`, with a constant
    /// of 1 (m or m/s) that drifts by 0.002 in a second and a rate of 0.02 m/s that
    /// does by 0.002 m/s; not delayed; gate at four standard deviations; checks over
    /// 1 s.
    #[must_use]
    pub fn new(observed: Observed, measurement_sd: R) -> Self {
        Self {
            observed,
            measurement_sd,
            delay_s: R::ZERO,
            harmonics: 3,
            shortest_period_s: r(0.8),
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
    /// Names the first that is not usable.
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

    /// Variances of the readings' constant and its rate.
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

    /// Propagates over `dt` seconds and takes in the reading at their end, if there
    /// is one; a reading that is not finite (or beyond 1e6) is counted and left out.
    pub fn step(&self, state: &mut DeckEstimatorState<R>, reading: Option<R>, dt: R) {
        let dt = usable_dt(dt);
        let finite = reading.filter(|y| y.abs() < r(FARTHEST));
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
            self.count(state);
            state.last = y;
            let row = match self.observed {
                Observed::Displacement => Row::Displacement,
                Observed::Velocity => Row::Velocity,
            };
            let noise = self.measurement_sd * self.measurement_sd;
            let (counted, nis) = state.harmonics.correct(row, y, noise, self.gate_sd);
            state.nis += dt.min(R::ONE) * (nis - state.nis);
            if state.harmonics.count() > 0 {
                // The search does not see wild readings either.
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
            // What is compared is what is read, with its rate of change.
            let seen = |time: R| {
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
            let (now, ahead) = (seen(R::ZERO), seen(self.check_horizon_s));
            state.learner.check(self.check_horizon_s, now, ahead);
        }
    }

    /// The time up to a reading, if the deck was seen in it: readings up to half the
    /// shortest period apart miss nothing. What was seen longer than the longest period
    /// ago is over.
    fn count(&self, state: &mut DeckEstimatorState<R>) {
        if state.unseen_s > self.longest_period_s {
            state.observed_s = R::ZERO;
        } else if state.unseen_s <= r::<R>(0.5) * self.shortest_period_s {
            state.observed_s += state.unseen_s;
        }
        state.unseen_s = R::ZERO;
    }

    /// The motion `horizon_s` from now (`delay_s` more after the last reading).
    ///
    /// Before a harmonic is known the motion is zero with the spread, beyond the
    /// noise, that the readings have shown. Before the deck has been seen for the
    /// shortest period nothing is known: standard deviations are infinite.
    #[must_use]
    pub fn predict(&self, state: &DeckEstimatorState<R>, horizon_s: R) -> DeckMotionPrediction<R> {
        let time = (horizon_s + self.delay_s).max(R::ZERO);
        if state.harmonics.count() > 0 {
            return state.harmonics.predict(&self.coherence(state), time);
        }
        let noise = self.measurement_sd * self.measurement_sd;
        let unknown = [r(f64::INFINITY), R::ONE];
        let [variance, w] = if state.observed_s < self.shortest_period_s {
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
    /// Harmonics found.
    #[must_use]
    pub fn count(&self) -> usize {
        self.harmonics.count()
    }

    /// The k-th harmonic found, in no order.
    #[must_use]
    pub fn harmonic(&self, k: usize) -> Option<Harmonic<R>> {
        (k < self.harmonics.count()).then(|| Harmonic {
            amplitude_m: self.harmonics.power(k).sqrt(),
            angular_frequency: self.harmonics.frequency(k),
            angular_frequency_sd: self.harmonics.frequency_sd(k),
        })
    }

    /// Rate κ at which amplitude and phase are forgotten, 1/s.
    #[must_use]
    pub fn forgetting_per_s(&self) -> R {
        self.learner.rate()
    }

    /// Time for which the deck has been seen, s: gaps of more than half the shortest
    /// period do not count, and after one of more than the longest it begins anew.
    #[must_use]
    pub fn observed_s(&self) -> R {
        self.observed_s
    }

    /// Readings that were not finite.
    #[must_use]
    pub fn not_finite(&self) -> u32 {
        self.not_finite
    }
}
