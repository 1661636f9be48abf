//! How coherent the motion is, learnt from predictions and what came of them.

use super::harmonics::Coherence;
use touchdown_flight::real::{Real, r};

/// Predictions that are under way.
const UNDER_WAY: usize = 16;
/// Rates of forgetting that are considered, 1/s.
const LEAST_RATE: f64 = 1e-6;
const GREATEST_RATE: f64 = 0.5;
/// The rate before anything is known, 1/s.
const FIRST_RATE: f64 = 0.1;
/// Steps of the logarithm of the rate a check, at the beginning and later, and
/// the time over which they shrink, s.
const FIRST_GAIN: f64 = 0.2;
const LAST_GAIN: f64 = 0.02;
const GAIN_TIME_S: f64 = 4.0;
/// How much faster the rate grows than it falls: in doubt errors are overstated.
const CAUTION: f64 = 2.0;

/// Adapts the rate so that squared errors of predictions are as large as the
/// filter says.
///
/// For a consistent filter what comes of a prediction, as filtered, differs from
/// it by a number of the variance `P_predicted - P_filtered`, whatever the noise
/// of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Learner<R> {
    ln_rate: R,
    /// Value, rate of change and variance predicted, oldest at `next`.
    under_way: [[R; 3]; UNDER_WAY],
    made: usize,
    next: usize,
    /// Time since the last check, s.
    since: R,
    /// Time learnt, s.
    time: R,
}

impl<R: Real> Learner<R> {
    pub(super) fn new() -> Self {
        Self {
            ln_rate: r::<R>(FIRST_RATE).ln(),
            under_way: [[R::ZERO; 3]; UNDER_WAY],
            made: 0,
            next: 0,
            since: R::ZERO,
            time: R::ZERO,
        }
    }

    pub(super) fn rate(&self) -> R {
        self.ln_rate.exp()
    }

    /// Learns as fast as at the beginning: a harmonic has been added.
    pub(super) fn begin_again(&mut self) {
        self.time = R::ZERO;
        self.ln_rate = self.ln_rate.min(r::<R>(FIRST_RATE).ln());
        self.forget_predictions();
    }

    /// Predictions of a filter that has been changed are not compared.
    pub(super) fn forget_predictions(&mut self) {
        self.made = 0;
        self.since = R::ZERO;
    }

    /// After `dt` seconds: is a check due?
    pub(super) fn due(&mut self, dt: R, horizon: R) -> bool {
        self.since += dt;
        self.time += dt;
        self.since >= horizon * r(1.0 / UNDER_WAY as f64)
    }

    /// Compares the oldest prediction with what has become of it and stores a new
    /// one; each is a value, its rate of change and its standard deviation.
    pub(super) fn check(&mut self, horizon: R, now: [R; 3], ahead: [R; 3]) {
        let interval = horizon * r(1.0 / UNDER_WAY as f64);
        // Steps need not divide the interval: what is over stays.
        self.since = (self.since - interval).min(interval);
        if self.made == UNDER_WAY {
            let [value, slope, variance] = self.under_way[self.next];
            // Predictions are for the moment at which their check is due.
            let error = now[0] - value - slope * self.since;
            let expected = variance - now[2] * now[2];
            if expected > R::ZERO {
                let excess = (error * error / expected).min(r(9.0)) - R::ONE;
                let excess = excess.max(excess * r(CAUTION));
                let early = r::<R>(FIRST_GAIN) / (R::ONE + self.time / r(GAIN_TIME_S));
                let gain = early.max(r(LAST_GAIN));
                self.ln_rate = (self.ln_rate + gain * excess)
                    .clamp(r::<R>(LEAST_RATE).ln(), r::<R>(GREATEST_RATE).ln());
            }
        } else {
            self.made += 1;
        }
        let [value, slope, sd] = ahead;
        self.under_way[self.next] = [value - slope * self.since, slope, sd * sd];
        self.next = (self.next + 1) % UNDER_WAY;
    }

    pub(super) fn coherence(&self, drift: [R; 2]) -> Coherence<R> {
        Coherence {
            rate: self.rate(),
            drift,
        }
    }
}
