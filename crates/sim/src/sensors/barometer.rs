//! The barometer, which the rotors' pressure disturbs near the deck.

use serde::{Deserialize, Serialize};

use touchdown_lander::estimate::relative::{BarometerReading, Reading};

use super::schedule::{Clock, Schedule, Transit};
use super::suite::{Message, Truth, nan_if};
use crate::check;
use crate::error::SimError;
use crate::random::Stream;

/// Height over which the pressure of the rotors under the vehicle decreases by the factor
/// e, m: 2.5 rotor radii, an assumption. The landing computer ignores the barometer below
/// 3 m by default. A vehicle that sees neither the deck nor its own climb uses it from 0.75 m on.
const PRESSURE_DECAY_M: f64 = 0.3;

/// The barometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BarometerSettings {
    /// Rate and latency of the readings.
    pub schedule: Schedule,
    /// White noise, standard deviation, m.
    pub noise_sd_m: f64,
    /// Random walk of the zero, m/√s.
    pub drift: f64,
    /// Error of the reading on the deck, m: the pressure of the rotors under the vehicle
    /// makes it read lower. It decays with height as exp(-z/0.3 m).
    pub ground_effect_m: f64,
}

impl Default for BarometerSettings {
    /// A MEMS barometer by order of magnitude: 20 Hz, latency 30 ms, jitter 2 ms, noise
    /// 0.12 m, drift 0.02 m/√s. On the deck it reads 1.5 m too low: 18 Pa, a quarter of the
    /// rotors' disc loading of 74 Pa.
    fn default() -> Self {
        Self {
            schedule: Schedule::new(20.0, 0.03, 0.002),
            noise_sd_m: 0.12,
            drift: 0.02,
            ground_effect_m: 1.5,
        }
    }
}

impl BarometerSettings {
    pub(super) fn validate(&self) -> Result<(), SimError> {
        self.schedule
            .validate()
            .map_err(|e| e.in_section("schedule"))?;
        check::not_negative("noise_sd_m", self.noise_sd_m)?;
        check::not_negative("drift", self.drift)?;
        check::finite("ground_effect_m", self.ground_effect_m)
    }
}

/// The barometer during one landing.
pub(crate) struct Barometer {
    settings: BarometerSettings,
    clock: Clock,
    drift_m: f64,
}

impl Barometer {
    pub(super) fn new(settings: &BarometerSettings, stream: Stream) -> Self {
        Self {
            settings: *settings,
            clock: Clock::new(settings.schedule, stream),
            drift_m: 0.0,
        }
    }

    /// The reading of a step, if one is due, and its transit.
    pub(super) fn read(&mut self, truth: &Truth<'_>) -> Option<(Message, Transit)> {
        if !self.clock.due(truth.time_s()) {
            return None;
        }
        let transit = self.clock.transit(0.0, 0.0);
        let of = &self.settings;
        let stream = &mut self.clock.stream;
        self.drift_m += of.drift / of.schedule.rate_hz.sqrt() * stream.normal();
        let pressed_m = of.ground_effect_m * (-truth.height_m().max(0.0) / PRESSURE_DECAY_M).exp();
        let altitude_m =
            truth.state.position_m[2] + self.drift_m - pressed_m + of.noise_sd_m * stream.normal();
        let reading = BarometerReading {
            altitude_m: nan_if(truth.faults.nan.barometer, altitude_m),
            age_s: 0.0,
        };
        (!transit.lost).then_some((Message::Reading(Reading::Barometer(reading)), transit))
    }
}
