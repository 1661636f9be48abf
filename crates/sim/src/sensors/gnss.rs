//! Satellite navigation: velocity in world axes.

use serde::{Deserialize, Serialize};

use touchdown_lander::estimate::relative::{GnssVelocity, Reading};

use super::schedule::{Clock, Schedule, Transit, Wander};
use super::suite::{Message, Truth, nan_if, vector};
use crate::check;
use crate::error::SimError;
use crate::random::Stream;

/// Velocity by satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GnssSettings {
    /// Rate and latency of the readings.
    pub schedule: Schedule,
    /// Horizontal noise on each axis, standard deviation, m/s.
    pub horizontal_sd_mps: f64,
    /// Vertical noise, standard deviation, m/s.
    pub vertical_sd_mps: f64,
    /// Slowly varying error on each axis, standard deviation, m/s.
    pub wander_sd_mps: f64,
    /// Correlation time of the slowly varying error, s.
    pub wander_s: f64,
}

impl Default for GnssSettings {
    /// A receiver without corrections, by the order of its data sheets: 10 Hz, latency
    /// 100 ms, jitter 5 ms; noise 0.05 m/s and 0.08 m/s; slowly varying error 0.03 m/s with
    /// a correlation time of 10 s.
    fn default() -> Self {
        Self {
            schedule: Schedule::new(10.0, 0.1, 0.005),
            horizontal_sd_mps: 0.05,
            vertical_sd_mps: 0.08,
            wander_sd_mps: 0.03,
            wander_s: 10.0,
        }
    }
}

impl GnssSettings {
    pub(super) fn validate(&self) -> Result<(), SimError> {
        self.schedule
            .validate()
            .map_err(|e| e.in_section("schedule"))?;
        check::not_negative("horizontal_sd_mps", self.horizontal_sd_mps)?;
        check::not_negative("vertical_sd_mps", self.vertical_sd_mps)?;
        check::not_negative("wander_sd_mps", self.wander_sd_mps)?;
        check::positive("wander_s", self.wander_s)
    }
}

/// Satellite navigation during one landing.
pub(crate) struct Gnss {
    settings: GnssSettings,
    clock: Clock,
    wander: [Wander; 3],
}

impl Gnss {
    pub(super) fn new(settings: &GnssSettings, stream: Stream) -> Self {
        let mut clock = Clock::new(settings.schedule, stream);
        let wander = std::array::from_fn(|_| {
            let step_s = 1.0 / settings.schedule.rate_hz;
            let (sd, time_s) = (settings.wander_sd_mps, settings.wander_s);
            Wander::new(sd, time_s, step_s, &mut clock.stream)
        });
        Self {
            settings: *settings,
            clock,
            wander,
        }
    }

    /// The reading of a step, if one is due, and its transit.
    pub(super) fn read(&mut self, truth: &Truth<'_>) -> Option<(Message, Transit)> {
        let transit = self.clock.reading(truth)?;
        let faults = &truth.faults;
        let [across, up] = [
            self.settings.horizontal_sd_mps,
            self.settings.vertical_sd_mps,
        ];
        let sd = [across, across, up];
        let stream = &mut self.clock.stream;
        let velocity: [f64; 3] = std::array::from_fn(|k| {
            let wander = self.wander[k].step(stream);
            truth.state.velocity_mps[k] + wander + sd[k] * stream.normal()
        });
        let reading = GnssVelocity {
            velocity_mps: vector(velocity.map(|v| nan_if(faults.nan.gnss, v))),
            age_s: 0.0,
        };
        (!transit.lost).then_some((Message::Reading(Reading::Gnss(reading)), transit))
    }
}
