//! Coherence of the motion, learnt by comparing predictions with later estimates.
//!
//! Comments on constants give the change of the relative prediction error, measured as in
//! `search.rs`.

use super::harmonics::Coherence;
use touchdown_flight::real::{Real, r};

/// Number of pending predictions, and so of checks within the horizon.
const PENDING: usize = 16;
/// Smallest decay rate, 1/s: a pure tone for the length of any landing. It only keeps
/// the logarithm finite; halved or doubled, it has no effect.
const LEAST_RATE: f64 = 1e-6;
/// Largest decay rate, 1/s. It bounds a broad sea: doubled, the error rises from 0.44 to
/// 0.57; halved, it falls to 0.41, but predictions then claim too much precision.
const GREATEST_RATE: f64 = 0.5;
/// Decay rate at the start, 1/s. Halved or doubled: errors change by at most 0.05.
const FIRST_RATE: f64 = 0.1;
/// Step of the logarithm of the rate at each check, at the start. Doubled: one tone is
/// noisier at first (0.06 to 0.11). Halved: two tones are learnt later (0.31 to 0.37).
const FIRST_GAIN: f64 = 0.2;
/// Step of the logarithm of the rate at each check, in the long run. Halved or doubled:
/// errors change by about 0.01. It sets how fast a changed sea is learnt.
const LAST_GAIN: f64 = 0.02;
/// Time over which the step decreases, s. It acts like [`FIRST_GAIN`].
const GAIN_TIME_S: f64 = 4.0;
/// Ratio of the rate's growth to its fall, so that standard deviations are rather too
/// large than too small. Halved, the truth lies within 1.96 standard deviations less
/// often (0.92 to 0.88 in a sea); doubled, one tone has 0.15 instead of 0.06.
const CAUTION: f64 = 2.0;
/// Largest ratio of a squared error to its variance that counts: three standard
/// deviations, so that one wild prediction does not decide.
const LARGEST_RATIO: f64 = 9.0;

/// Adapts the decay rate κ until squared errors of predictions equal their variances.
///
/// In a consistent filter, a prediction and the later estimate differ with the
/// variance `P_predicted - P_filtered`, whatever the noise of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Learner<R> {
    ln_rate: R,
    /// The rate, 1/s.
    rate: R,
    /// Predicted value, rate of change and variance; `next` is the oldest.
    pending: [[R; 3]; PENDING],
    stored: usize,
    next: usize,
    /// Time since the last check, s.
    since: R,
    /// Time since learning began, s.
    time: R,
}

impl<R: Real> Learner<R> {
    pub(super) fn new() -> Self {
        let ln_rate = r::<R>(FIRST_RATE).ln();
        Self {
            ln_rate,
            rate: ln_rate.exp(),
            pending: [[R::ZERO; 3]; PENDING],
            stored: 0,
            next: 0,
            since: R::ZERO,
            time: R::ZERO,
        }
    }

    pub(super) fn rate(&self) -> R {
        self.rate
    }

    fn set_ln_rate(&mut self, ln_rate: R) {
        (self.ln_rate, self.rate) = (ln_rate, ln_rate.exp());
    }

    /// Learns again as fast as at the beginning, because a harmonic has been added.
    pub(super) fn restart(&mut self) {
        self.time = R::ZERO;
        self.set_ln_rate(self.ln_rate.min(r::<R>(FIRST_RATE).ln()));
        self.forget_predictions();
    }

    /// Drops the pending predictions, because the filter's structure has changed.
    pub(super) fn forget_predictions(&mut self) {
        self.stored = 0;
        self.since = R::ZERO;
    }

    /// Advances by `dt` seconds; whether a check is due.
    pub(super) fn due(&mut self, dt: R, horizon: R) -> bool {
        self.since += dt;
        self.time += dt;
        self.since >= horizon * r(1.0 / PENDING as f64)
    }

    /// Compares the oldest prediction with the estimate `now` and stores the prediction
    /// `ahead`. Each is a value, its rate of change and its standard deviation.
    pub(super) fn check(&mut self, horizon: R, now: [R; 3], ahead: [R; 3]) {
        let interval = horizon * r(1.0 / PENDING as f64);
        // Steps need not divide the interval, so the remainder is carried over.
        self.since = (self.since - interval).min(interval);
        let next = self.next % PENDING;
        if self.stored == PENDING {
            let [value, slope, variance] = self.pending[next];
            // A prediction is for the exact moment of its check, not for this step's end.
            let error = now[0] - value - slope * self.since;
            let expected = variance - now[2] * now[2];
            if expected > R::ZERO {
                let excess = (error * error / expected).min(r(LARGEST_RATIO)) - R::ONE;
                let excess = excess.max(excess * r(CAUTION));
                let early = r::<R>(FIRST_GAIN) / (R::ONE + self.time / r(GAIN_TIME_S));
                let gain = early.max(r(LAST_GAIN));
                let ln_rate = (self.ln_rate + gain * excess)
                    .clamp(r::<R>(LEAST_RATE).ln(), r::<R>(GREATEST_RATE).ln());
                self.set_ln_rate(ln_rate);
            }
        } else {
            self.stored += 1;
        }
        let [value, slope, sd] = ahead;
        self.pending[next] = [value - slope * self.since, slope, sd * sd];
        self.next = (next + 1) % PENDING;
    }

    pub(super) fn coherence(&self, drift: [R; 2]) -> Coherence<R> {
        Coherence {
            rate: self.rate(),
            drift,
        }
    }
}
