//! What a landing starts from: settings of one scenario.

use serde::{Deserialize, Serialize};
use touchdown_flight::touch::CRASH_MPS;

use crate::body::plant::Plant;
use crate::body::plant::{PlantSettings, Surface};
use crate::body::vertical::VerticalVehicle;
use crate::check;
use crate::deck::DeckMotion;
use crate::error::SimError;
use crate::sensors::FlightSensorSettings;

/// How vehicles and starts differ between the trials of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SpreadSettings {
    /// Thrust scale `1 + sd N(0, 1)`: standard deviation.
    pub thrust_scale_sd: f64,
    /// Ground-effect scale, uniform: least.
    pub ground_effect_scale_min: f64,
    /// Ground-effect scale, uniform: greatest.
    pub ground_effect_scale_max: f64,
    /// Whether the deck's phase at the start is uniform over a period.
    pub deck_phase: bool,
}

impl Default for SpreadSettings {
    fn default() -> Self {
        Self {
            thrust_scale_sd: 0.01,
            ground_effect_scale_min: 0.85,
            ground_effect_scale_max: 1.15,
            deck_phase: true,
        }
    }
}

impl SpreadSettings {
    /// Every trial the same.
    #[must_use]
    pub fn none() -> Self {
        Self {
            thrust_scale_sd: 0.0,
            ground_effect_scale_min: 1.0,
            ground_effect_scale_max: 1.0,
            deck_phase: false,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), SimError> {
        check::within("thrust_scale_sd", self.thrust_scale_sd, 0.0, 0.1)?;
        check::not_negative("ground_effect_scale_min", self.ground_effect_scale_min)?;
        check::that(
            self.ground_effect_scale_max >= self.ground_effect_scale_min
                && self.ground_effect_scale_max.is_finite(),
            "ground_effect_scale_max",
            "a number of at least `ground_effect_scale_min`",
            self.ground_effect_scale_max,
        )
    }
}

/// A landing scenario: vehicle and air (`plant`), deck, sensors, delays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandingScenario {
    /// Height above the deck at the start, m.
    pub start_height_m: f64,
    /// Height above the deck at which the vehicle has landed, m.
    pub landed_height_m: f64,
    /// Speed towards the deck at that height above which the vehicle has crashed, m/s; a landing above half of it is hard.
    pub crash_speed_mps: f64,
    /// A trial that has not landed by then is timed out, s.
    pub timeout_s: f64,
    /// Height above the deck beyond which the trial has diverged, m.
    pub ceiling_m: f64,
    /// Time between two calls of the controller, s; a multiple of 1 ms.
    pub control_period_s: f64,
    /// Time from the controller's command to the motors, s.
    pub command_delay_s: f64,
    /// Whether air is turbulent and sensors noisy.
    pub noise: bool,
    /// Sensors of the vehicle.
    pub sensors: FlightSensorSettings,
    /// Motion of the deck.
    pub deck: DeckMotion,
    /// Differences between trials.
    pub spread: SpreadSettings,
    /// Vehicle, rotors and air.
    pub plant: PlantSettings,
}

impl Default for LandingScenario {
    /// A still deck, from 0.8 m.
    fn default() -> Self {
        Self {
            start_height_m: 0.8,
            landed_height_m: 0.1,
            crash_speed_mps: CRASH_MPS,
            timeout_s: 40.0,
            ceiling_m: 5.0,
            control_period_s: 0.01,
            command_delay_s: 0.01,
            noise: true,
            sensors: FlightSensorSettings::default(),
            deck: DeckMotion::Still,
            spread: SpreadSettings::default(),
            plant: PlantSettings::default(),
        }
    }
}

/// What a controller may know before the first measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalStart {
    /// Throttle that holds the nominal vehicle at the start height, with its
    /// ground effect, above a still deck.
    pub throttle: f64,
    /// Height above the deck, m.
    pub height_m: f64,
}

impl LandingScenario {
    /// The paper's oscillating platform: 0.05 m at 0.5 Hz, from 0.5 m.
    #[must_use]
    pub fn oscillating_deck() -> Self {
        Self {
            start_height_m: 0.5,
            deck: DeckMotion::Sine {
                amplitude_m: 0.05,
                frequency_hz: 0.5,
                phase_rad: 0.0,
            },
            ..Self::default()
        }
    }

    /// The same scenario without noise and without differences between trials;
    /// delays stay.
    #[must_use]
    pub fn noise_free(self) -> Self {
        Self {
            noise: false,
            spread: SpreadSettings::none(),
            ..self
        }
    }

    /// Checks the scenario.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number; a
    /// deck that rises above the start height is one of them.
    pub fn validate(&self) -> Result<(), SimError> {
        check::period("control_period_s", self.control_period_s, 1.0)?;
        check::within("command_delay_s", self.command_delay_s, 0.0, 1.0)?;
        check::positive("timeout_s", self.timeout_s)?;
        check::within("timeout_s", self.timeout_s, 0.0, 7_200.0)?;
        check::positive("landed_height_m", self.landed_height_m)?;
        check::positive("crash_speed_mps", self.crash_speed_mps)?;
        check::that(
            self.start_height_m > self.landed_height_m,
            "start_height_m",
            &format!(
                "a height above `landed_height_m` ({} m)",
                self.landed_height_m
            ),
            self.start_height_m,
        )?;
        check::that(
            self.ceiling_m.is_finite() && self.ceiling_m > self.start_height_m,
            "ceiling_m",
            &format!(
                "a height above `start_height_m` ({} m)",
                self.start_height_m
            ),
            self.ceiling_m,
        )?;
        self.sensors
            .validate()
            .map_err(|e| e.in_section("sensors"))?;
        self.deck.validate().map_err(|e| e.in_section("deck"))?;
        check::that(
            self.deck.highest_m() < self.start_height_m,
            "deck.amplitude_m",
            &format!(
                "a deck that stays below the start height ({} m)",
                self.start_height_m
            ),
            self.deck.highest_m(),
        )?;
        self.spread.validate().map_err(|e| e.in_section("spread"))?;
        self.plant.validate().map_err(|e| e.in_section("plant"))?;
        if self.plant.surface == Surface::Absent {
            return Err(check::fail(
                "plant.surface",
                "\"plate\" or \"ground\"",
                &"\"absent\"",
            ));
        }
        Ok(())
    }

    /// The nominal start.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn nominal_start(&self) -> Result<NominalStart, SimError> {
        self.validate()?;
        let plant = Plant::new(&self.plant)?;
        let vehicle = VerticalVehicle::new(plant, self.plant.mass_kg, 0.0);
        let (_, throttle) = vehicle.balanced(self.start_height_m, DeckMotion::Still.at(0.0));
        Ok(NominalStart {
            throttle,
            height_m: self.start_height_m,
        })
    }
}
