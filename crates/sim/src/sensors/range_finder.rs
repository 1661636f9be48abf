//! The range finder: distance along the body's z axis to the deck.

use serde::{Deserialize, Serialize};

use touchdown_lander::estimate::relative::{RangeReading, Reading};

use super::schedule::{Clock, Schedule, Transit};
use super::suite::{Message, Truth, nan_if};
use crate::check;
use crate::error::SimError;
use crate::number::vector::{add, along, dot, scale, sub, to_world};
use crate::random::Stream;

/// The range finder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RangeSettings {
    /// Rate and latency of the readings.
    pub schedule: Schedule,
    /// Position in body axes, m. The beam points against the body's z axis.
    pub place_m: [f64; 3],
    /// White noise, standard deviation, m.
    pub noise_sd_m: f64,
    /// Resolution, m; 0 for none.
    pub quantum_m: f64,
    /// Smallest measurable distance, m.
    pub least_m: f64,
    /// Largest measurable distance, m.
    pub greatest_m: f64,
}

impl Default for RangeSettings {
    /// A small laser range finder, by the order of its data sheets: 50 Hz, latency 20 ms,
    /// jitter 2 ms; at the reference point; noise 5 mm, whole centimetres, 0.02 to 12 m.
    fn default() -> Self {
        Self {
            schedule: Schedule::new(50.0, 0.02, 0.002),
            place_m: [0.0; 3],
            noise_sd_m: 0.005,
            quantum_m: 0.01,
            least_m: 0.02,
            greatest_m: 12.0,
        }
    }
}

impl RangeSettings {
    pub(super) fn validate(&self) -> Result<(), SimError> {
        self.schedule
            .validate()
            .map_err(|e| e.in_section("schedule"))?;
        for value in self.place_m {
            check::finite("place_m", value)?;
        }
        check::not_negative("noise_sd_m", self.noise_sd_m)?;
        check::not_negative("quantum_m", self.quantum_m)?;
        check::not_negative("least_m", self.least_m)?;
        check::that(
            self.greatest_m.is_finite() && self.greatest_m > self.least_m,
            "greatest_m",
            "a distance above `least_m`",
            self.greatest_m,
        )
    }
}

/// A logged reading of the range finder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RangeRow {
    /// Time of the measurement, s.
    pub time_s: f64,
    /// Distance along the beam, m.
    pub distance_m: f64,
}

/// The range finder during one landing.
pub(crate) struct RangeFinder {
    settings: RangeSettings,
    clock: Clock,
    /// Readings for the log since its last access, if there is a log.
    pub(crate) log: Option<Vec<RangeRow>>,
}

impl RangeFinder {
    pub(super) fn new(settings: &RangeSettings, stream: Stream) -> Self {
        Self {
            settings: *settings,
            clock: Clock::new(settings.schedule, stream),
            log: None,
        }
    }

    /// The reading of a step, if one is due, and its transit.
    pub(super) fn read(&mut self, truth: &Truth<'_>) -> Option<(Message, Transit)> {
        let transit = self.clock.reading(truth)?;
        let faults = &truth.faults;
        let noise = self.clock.stream.normal();
        let missing = self.clock.stream.uniform() < faults.range_missing_share;
        let distance_m = self.distance(truth, noise)?;
        if transit.lost || missing {
            return None;
        }
        let distance_m = nan_if(faults.nan.range, distance_m);
        if let Some(log) = &mut self.log {
            let time_s = truth.time_s();
            log.push(RangeRow { time_s, distance_m });
        }
        let reading = Reading::Range(RangeReading::level(distance_m, 0.0));
        Some((Message::Reading(reading), transit))
    }

    /// The distance along the beam to the deck.
    fn distance(&self, truth: &Truth<'_>, noise: f64) -> Option<f64> {
        let of = &self.settings;
        let axes = truth.state.axes();
        let from = add(truth.state.position_m, to_world(&axes, of.place_m));
        let beam = scale(axes[2], -1.0);
        let from_centre = sub(from, truth.deck.origin_m);
        let above = dot(truth.deck.axes[2], from_centre);
        let closing = -dot(truth.deck.axes[2], beam);
        if !(closing > 0.1 && above > 0.0) {
            return None;
        }
        let distance = above / closing;
        let hit = along(&truth.deck.axes, add(from_centre, scale(beam, distance)));
        let beside = |l: f64| hit[0].abs() > l || hit[1].abs() > l;
        if truth.half_side_m.is_some_and(beside) {
            return None;
        }
        let noisy = distance + of.noise_sd_m * noise;
        let read = if of.quantum_m > 0.0 {
            (noisy / of.quantum_m).round() * of.quantum_m
        } else {
            noisy
        };
        (read >= of.least_m && read <= of.greatest_m).then_some(read)
    }
}
