//! Sampling times, latencies and slowly varying errors of sensors.

use serde::{Deserialize, Serialize};

use super::suite::Truth;
use crate::STEP_S;
use crate::check;
use crate::error::SimError;
use crate::random::Stream;

/// Rate, latency and losses of a sensor's readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Schedule {
    /// Readings per second, Hz.
    pub rate_hz: f64,
    /// Time from measurement to arrival, s.
    pub latency_s: f64,
    /// Scale of the additional half-normal latency, s. The vehicle knows its mean; the
    /// deviation from the mean is an error of the reading's age.
    pub jitter_s: f64,
    /// Share of lost readings.
    pub loss_share: f64,
}

impl Schedule {
    /// A schedule without losses.
    #[must_use]
    pub const fn new(rate_hz: f64, latency_s: f64, jitter_s: f64) -> Self {
        Self {
            rate_hz,
            latency_s,
            jitter_s,
            loss_share: 0.0,
        }
    }

    /// Checks the schedule.
    ///
    /// # Errors
    /// The rate lies in 0.1..1000 Hz, times in 0..0.25 s, the share below 1.
    pub fn validate(&self) -> Result<(), SimError> {
        check::within("rate_hz", self.rate_hz, 0.1, 1.0 / STEP_S)?;
        check::within("latency_s", self.latency_s, 0.0, 0.25)?;
        check::within("jitter_s", self.jitter_s, 0.0, 0.1)?;
        check::within("loss_share", self.loss_share, 0.0, 0.99)
    }
}

/// Mean of the half-normal distribution over its scale, √(2/π).
const HALF_NORMAL_MEAN: f64 = 0.797_884_560_802_865_4;

/// Sampling times and random stream of a sensor.
#[derive(Clone, Debug)]
pub(crate) struct Clock {
    schedule: Schedule,
    next_s: f64,
    pub(crate) stream: Stream,
}

impl Clock {
    pub(crate) fn new(schedule: Schedule, mut stream: Stream) -> Self {
        let phase = stream.uniform();
        Self {
            schedule,
            next_s: phase / schedule.rate_hz,
            stream,
        }
    }

    /// Whether it samples at this step.
    pub(crate) fn due(&mut self, time_s: f64) -> bool {
        // The nearest step is due.
        let due = time_s + 0.5 * STEP_S >= self.next_s;
        if due {
            self.next_s += 1.0 / self.schedule.rate_hz;
        }
        due
    }

    /// Transit of the reading of this step, if one is due, with the additional latency of the faults.
    pub(crate) fn reading(&mut self, truth: &Truth<'_>) -> Option<Transit> {
        let faults = &truth.faults;
        self.due(truth.time_s())
            .then(|| self.transit(faults.extra_latency_s, faults.known_extra_latency_s))
    }

    /// Transit of the next reading, with an additional latency, part of which is known.
    pub(crate) fn transit(&mut self, extra_s: f64, known_s: f64) -> Transit {
        let schedule = &self.schedule;
        let latency_s =
            schedule.latency_s + schedule.jitter_s * self.stream.normal().abs() + extra_s;
        let lost = self.stream.uniform() < schedule.loss_share;
        let age_s = schedule.latency_s + HALF_NORMAL_MEAN * schedule.jitter_s + known_s;
        Transit {
            latency_s,
            age_s,
            lost,
        }
    }
}

/// Transit of a reading from the sensor to the landing computer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transit {
    /// Time from the measurement to the arrival, s.
    pub(crate) latency_s: f64,
    /// The part of that time that the vehicle knows, s.
    pub(crate) age_s: f64,
    /// The reading never arrives.
    pub(crate) lost: bool,
}

/// A slowly varying error: a first-order Gauss–Markov process.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wander {
    sd: f64,
    decay: f64,
    value: f64,
}

impl Wander {
    pub(crate) fn new(sd: f64, correlation_s: f64, step_s: f64, stream: &mut Stream) -> Self {
        Self {
            sd,
            decay: (-step_s / correlation_s).exp(),
            value: sd * stream.normal(),
        }
    }

    pub(crate) fn step(&mut self, stream: &mut Stream) -> f64 {
        let gain = self.sd * (1.0 - self.decay * self.decay).sqrt();
        self.value = self.decay * self.value + gain * stream.normal();
        self.value
    }
}
