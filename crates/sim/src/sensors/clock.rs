//! When a sensor samples, how late its readings are, errors that wander.

use super::settings::Schedule;
use crate::STEP_S;
use crate::random::Stream;

/// Mean of the half-normal distribution over its scale, √(2/π).
const HALF_NORMAL_MEAN: f64 = 0.797_884_560_802_865_4;

/// When a sensor samples, and what it draws from.
#[derive(Clone, Debug)]
pub(crate) struct Clock {
    schedule: Schedule,
    next_s: f64,
    pub(super) stream: Stream,
}

impl Clock {
    pub(super) fn new(schedule: Schedule, mut stream: Stream) -> Self {
        let phase = stream.uniform();
        Self {
            schedule,
            next_s: phase / schedule.rate_hz,
            stream,
        }
    }

    /// Whether it samples at this step.
    pub(super) fn due(&mut self, time_s: f64) -> bool {
        // Half a step early is on time.
        let due = time_s + 0.5 * STEP_S >= self.next_s;
        if due {
            self.next_s += 1.0 / self.schedule.rate_hz;
        }
        due
    }

    /// Delay, loss and known age of the next reading, under a further latency and
    /// what of it is known.
    pub(super) fn journey(&mut self, [extra_s, known_s]: [f64; 2]) -> (f64, bool, f64) {
        let schedule = &self.schedule;
        let delay = schedule.latency_s + schedule.jitter_s * self.stream.normal().abs() + extra_s;
        let lost = self.stream.uniform() < schedule.loss_share;
        let age_s = schedule.latency_s + HALF_NORMAL_MEAN * schedule.jitter_s + known_s;
        (delay, lost, age_s)
    }
}

/// A first-order process that wanders.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wander {
    sd: f64,
    decay: f64,
    value: f64,
}

impl Wander {
    pub(super) fn new(sd: f64, correlation_s: f64, step_s: f64, stream: &mut Stream) -> Self {
        Self {
            sd,
            decay: (-step_s / correlation_s).exp(),
            value: sd * stream.normal(),
        }
    }

    pub(super) fn step(&mut self, stream: &mut Stream) -> f64 {
        let gain = self.sd * (1.0 - self.decay * self.decay).sqrt();
        self.value = self.decay * self.value + gain * stream.normal();
        self.value
    }
}
