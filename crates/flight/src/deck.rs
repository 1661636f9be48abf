//! Estimate of a deck's heave: one harmonic of known frequency.

use crate::error::{SettingsError, not_negative, positive};
use crate::kernel::{Sum, usable_dt};
use crate::real::{Real, r};

/// Kalman filter of a harmonic heave, `p'' = -ω² p`, from the measured velocity of the
/// deck, `v_q - v`.
///
/// The states are the displacement p about the deck's mean and its velocity, propagated
/// by the exact rotation. The process noise is white in acceleration and, scaled by
/// `1/ω`, in velocity, so that it has no preferred phase. The outputs are predicted ahead
/// by `lead_s` (latency of the sensors, delay of the command, lag of the rotors). They
/// are zero before `enable_after_s`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct HarmonicFilter<R> {
    /// Angular frequency ω of the heave, rad/s.
    pub angular_frequency: R,
    /// Standard deviation of the measured velocity, m/s.
    pub measurement_sd: R,
    /// Process noise: growth of the velocity's standard deviation in a second, m/s/√s.
    pub process_sd: R,
    /// Time before the outputs are used, s.
    pub enable_after_s: R,
    /// Time by which the outputs are predicted ahead, s.
    pub lead_s: R,
}

/// Standard deviation of the deck's velocity before any measurement, m/s.
const INITIAL_SD: f64 = 0.3;

/// State of a [`HarmonicFilter`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HarmonicState<R> {
    /// Displacement p, m.
    pub displacement_m: R,
    /// Velocity, m/s.
    pub velocity_mps: R,
    /// Covariance of (displacement, velocity): variance, covariance, variance.
    covariance: [R; 3],
    elapsed: Sum<R>,
    /// The rotation of the last step, and the one ahead: periods and leads seldom change.
    turn: Turn<R>,
    ahead: Turn<R>,
}

/// The exact rotation of displacement and velocity over a time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn<R> {
    angular_frequency: R,
    time_s: R,
    cosine: R,
    /// `sin(ω t) / ω`.
    sine_over_w: R,
    /// `ω sin(ω t)`.
    w_sine: R,
}

impl<R: Real> Turn<R> {
    fn new(angular_frequency: R, time_s: R) -> Self {
        let (sine, cosine) = (angular_frequency * time_s).sin_cos();
        Self {
            angular_frequency,
            time_s,
            cosine,
            sine_over_w: sine / angular_frequency,
            w_sine: angular_frequency * sine,
        }
    }

    /// The rotation of these numbers: itself if it is.
    fn or_new(self, angular_frequency: R, time_s: R) -> Self {
        if self.angular_frequency == angular_frequency && self.time_s == time_s {
            self
        } else {
            Self::new(angular_frequency, time_s)
        }
    }

    /// Displacement and velocity after the time.
    fn of(&self, p: R, v: R) -> (R, R) {
        (
            self.cosine * p + self.sine_over_w * v,
            self.cosine * v - self.w_sine * p,
        )
    }
}

/// A prediction of the deck's motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeckMotion<R> {
    /// Velocity of the deck, up, m/s.
    pub velocity_mps: R,
    /// Acceleration of the deck, up, m/s².
    pub acceleration_mps2: R,
}

impl<R: Real> HarmonicFilter<R> {
    /// A filter for a heave of `angular_frequency` rad/s with measurement noise
    /// 0.03 m/s, process noise 0.002 m/s/√s, enabled after 0.5 s, leading by
    /// 0.09 s.
    #[must_use]
    pub fn new(angular_frequency: R) -> Self {
        Self {
            angular_frequency,
            measurement_sd: r(0.03),
            process_sd: r(0.002),
            enable_after_s: r(0.5),
            lead_s: r(0.09),
        }
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// Frequency and measurement noise must be positive, the other settings not negative.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("deck.angular_frequency", self.angular_frequency)?;
        positive("deck.measurement_sd", self.measurement_sd)?;
        not_negative("deck.process_sd", self.process_sd)?;
        not_negative("deck.enable_after_s", self.enable_after_s)?;
        not_negative("deck.lead_s", self.lead_s)
    }

    /// The state before any measurement.
    #[must_use]
    pub fn initial(&self) -> HarmonicState<R> {
        let sd = r::<R>(INITIAL_SD);
        let sd_p = sd / self.angular_frequency;
        HarmonicState {
            displacement_m: R::ZERO,
            velocity_mps: R::ZERO,
            covariance: [sd_p * sd_p, R::ZERO, sd * sd],
            elapsed: Sum::default(),
            turn: Turn::new(self.angular_frequency, R::ZERO),
            ahead: Turn::new(self.angular_frequency, self.lead_s),
        }
    }

    /// Propagates over `dt` seconds and corrects by the deck velocity measured at their
    /// end. A measurement that is not finite is ignored.
    pub fn step(&self, state: &mut HarmonicState<R>, deck_velocity_mps: R, dt: R) -> DeckMotion<R> {
        let before = (state.displacement_m, state.velocity_mps, state.covariance);
        let elapsed = state.elapsed;
        self.propagate(state, usable_dt(dt));
        if deck_velocity_mps.is_finite() {
            self.correct(state, deck_velocity_mps);
        }
        if !state.is_finite() {
            (state.displacement_m, state.velocity_mps, state.covariance) = before;
            state.elapsed = elapsed;
        }
        self.predict(state)
    }

    /// The motion `lead_s` after the state; zero before `enable_after_s`.
    pub fn predict(&self, state: &HarmonicState<R>) -> DeckMotion<R> {
        if state.elapsed.value() < self.enable_after_s {
            return DeckMotion::default();
        }
        let w = self.angular_frequency;
        let ahead = state.ahead.or_new(w, self.lead_s);
        let (p, velocity_mps) = ahead.of(state.displacement_m, state.velocity_mps);
        DeckMotion {
            velocity_mps,
            acceleration_mps2: -(w * w) * p,
        }
    }

    fn propagate(&self, state: &mut HarmonicState<R>, dt: R) {
        let w = self.angular_frequency;
        let turn = state.turn.or_new(w, dt);
        state.turn = turn;
        (state.displacement_m, state.velocity_mps) =
            turn.of(state.displacement_m, state.velocity_mps);
        let [pp, pv, vv] = state.covariance;
        // Both columns of P, then both rows of the result: F P Fᵀ.
        let (a, b) = turn.of(pp, pv);
        let (c, d) = turn.of(pv, vv);
        let (pp, pv) = turn.of(a, c);
        let (_, vv) = turn.of(b, d);
        let q = self.process_sd * self.process_sd * dt;
        state.covariance = [pp + q / (w * w), pv, vv + q];
        state.elapsed.add(dt);
    }

    fn correct(&self, state: &mut HarmonicState<R>, velocity_mps: R) {
        let [pp, pv, vv] = state.covariance;
        let variance = self.measurement_sd * self.measurement_sd;
        let total = vv + variance;
        let innovation = velocity_mps - state.velocity_mps;
        state.displacement_m += pv / total * innovation;
        state.velocity_mps += vv / total * innovation;
        state.covariance = [
            (pp - pv * pv / total).max(R::ZERO),
            pv * variance / total,
            vv * variance / total,
        ];
    }
}

impl<R: Real> HarmonicState<R> {
    /// Whether all numbers are finite: zero times any of them is then zero.
    fn is_finite(&self) -> bool {
        let [pp, pv, vv] = self.covariance;
        let all = [self.displacement_m, self.velocity_mps, pp, pv, vv];
        all.iter().fold(R::ZERO, |sum, &c| sum + c * R::ZERO) == R::ZERO
    }
}
