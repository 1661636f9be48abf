//! Broadcast of the deck: its place and velocity by satellite navigation, by radio.

use serde::{Deserialize, Serialize};

use touchdown_lander::estimate::relative::{BeaconReading, Reading};

use super::schedule::{Clock, Schedule, Transit, Wander};
use super::suite::{Message, Truth, vector};
use crate::check;
use crate::error::SimError;
use crate::number::vector::{add, sub};
use crate::random::Stream;

/// The deck's broadcast, less the vehicle's own place by satellite navigation.
///
/// The antenna is at the deck's centre. The vehicle knows when the deck measured, and its own place then.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BeaconSettings {
    /// Rate, latency and losses of the broadcasts.
    pub schedule: Schedule,
    /// Slowly varying error of the difference of both places on each horizontal axis, standard deviation, m.
    pub horizontal_sd_m: f64,
    /// The same of the height, m.
    pub vertical_sd_m: f64,
    /// Correlation time of these errors, s.
    pub place_s: f64,
    /// White noise of the deck's velocity on each axis, standard deviation, m/s.
    pub velocity_sd_mps: f64,
    /// Slowly varying error of that velocity, standard deviation, m/s; its correlation time is that of the vehicle's receiver.
    pub velocity_wander_sd_mps: f64,
}

/// Correlation time of the slowly varying error of velocities, s, as of [`super::GnssSettings`].
const WANDER_S: f64 = 10.0;

impl Default for BeaconSettings {
    /// Two receivers without corrections, by the order of their data sheets: 2 m horizontally, 3 m vertically with a
    /// correlation time of 60 s; velocity as that of the vehicle. A telemetry link: 5 Hz, 0.2 s, 20 ms, 5 % lost.
    fn default() -> Self {
        Self {
            schedule: Schedule {
                loss_share: 0.05,
                ..Schedule::new(5.0, 0.2, 0.02)
            },
            horizontal_sd_m: 2.0,
            vertical_sd_m: 3.0,
            place_s: 60.0,
            velocity_sd_mps: 0.05,
            velocity_wander_sd_mps: 0.03,
        }
    }
}

impl BeaconSettings {
    pub(super) fn validate(&self) -> Result<(), SimError> {
        self.schedule
            .validate()
            .map_err(|e| e.in_section("schedule"))?;
        check::not_negative("horizontal_sd_m", self.horizontal_sd_m)?;
        check::not_negative("vertical_sd_m", self.vertical_sd_m)?;
        check::positive("place_s", self.place_s)?;
        check::not_negative("velocity_sd_mps", self.velocity_sd_mps)?;
        check::not_negative("velocity_wander_sd_mps", self.velocity_wander_sd_mps)
    }
}

/// The broadcast during one landing.
pub(crate) struct Beacon {
    settings: BeaconSettings,
    clock: Clock,
    place: [Wander; 3],
    velocity: [Wander; 3],
}

impl Beacon {
    pub(super) fn new(settings: &BeaconSettings, stream: Stream) -> Self {
        let mut clock = Clock::new(settings.schedule, stream);
        let step_s = 1.0 / settings.schedule.rate_hz;
        let across = settings.horizontal_sd_m;
        let mut wander = |sd, time_s| Wander::new(sd, time_s, step_s, &mut clock.stream);
        Self {
            settings: *settings,
            place: [across, across, settings.vertical_sd_m].map(|sd| wander(sd, settings.place_s)),
            velocity: [settings.velocity_wander_sd_mps; 3].map(|sd| wander(sd, WANDER_S)),
            clock,
        }
    }

    /// The broadcast of a step, if one is due, and its transit.
    pub(super) fn read(&mut self, truth: &Truth<'_>) -> Option<(Message, Transit)> {
        if !self.clock.due(truth.time_s()) {
            return None;
        }
        // Faults delay what comes by the vehicle's own wires.
        let transit = self.clock.transit(0.0, 0.0);
        let stream = &mut self.clock.stream;
        let apart = sub(truth.state.position_m, truth.deck.origin_m);
        let off: [f64; 3] = std::array::from_fn(|k| self.place[k].step(stream));
        let sd = self.settings.velocity_sd_mps;
        let wrong: [f64; 3] =
            std::array::from_fn(|k| self.velocity[k].step(stream) + sd * stream.normal());
        let reading = BeaconReading {
            position_m: vector(add(apart, off)),
            deck_velocity_mps: vector(add(truth.deck.velocity_mps, wrong)),
            age_s: 0.0,
        };
        (!transit.lost).then_some((Message::Reading(Reading::Beacon(reading)), transit))
    }
}
