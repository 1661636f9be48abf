//! Settings of whole runs, as they stand in TOML files.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use touchdown_flight::control::{Gains, Imbc, Ssc};
use touchdown_flight::types::Limits;
use touchdown_sim::rig::RigSettings;
use touchdown_sim::scenario::LandingScenario;

use crate::error::{Error, Result};
use crate::identify::IdentificationSettings;

/// Rate of the descent that makes `dynamic` land in the published 5.1 s on the ground [1/s]: calibrated.
pub const C_GROUND_PER_S: f64 = 0.7073;
/// Rate of the descent that makes `dynamic` land in the published 5.38 s on the deck [1/s]: calibrated.
pub const C_DECK_PER_S: f64 = 0.5566;

/// Everything that `reproduce` depends on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReproduceSettings {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Landings of every method in every experiment.
    pub trials: usize,
    /// Fewer rig trials, for a fast look.
    pub quick: bool,
    /// The virtual rig.
    pub rig: RigSettings,
    /// Identification.
    pub identification: IdentificationSettings,
    /// Landing on the ground.
    pub ground_landing: LandSettings,
    /// Landing on the oscillating deck.
    pub deck_landing: LandSettings,
}

impl Default for ReproduceSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            trials: 40,
            quick: false,
            rig: RigSettings::default(),
            identification: IdentificationSettings::default(),
            ground_landing: LandSettings::ground(),
            deck_landing: LandSettings::deck(),
        }
    }
}

/// A landing: what is landed on, and the controllers.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandSettings {
    /// Vehicle, air, deck, sensors and spreads.
    pub scenario: LandingScenario,
    /// The controllers.
    pub control: ControlSettings,
}

impl Default for LandSettings {
    fn default() -> Self {
        Self::ground()
    }
}

impl LandSettings {
    /// The landing on the ground (IV-C).
    #[must_use]
    pub fn ground() -> Self {
        Self {
            scenario: LandingScenario::default(),
            control: ControlSettings::default(),
        }
    }

    /// The landing on the oscillating deck (IV-D).
    #[must_use]
    pub fn deck() -> Self {
        Self {
            scenario: LandingScenario::oscillating_deck(),
            control: ControlSettings {
                c_per_s: C_DECK_PER_S,
                ..ControlSettings::default()
            },
        }
    }
}

/// The controllers' settings.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ControlSettings {
    /// Rate C of the descent, eq. (13) [1/s].
    pub c_per_s: f64,
    /// Height that the descent ends at [m].
    pub end_height_m: f64,
    /// Gains of eq. (10).
    pub gains: Gains<f64>,
    /// Poles of the internal model [1/s] (`imbc`, reconstructed).
    pub imbc_poles_per_s: [f64; 3],
    /// Amplitude of the sliding term [N] (`ssc`, reconstructed).
    pub ssc_rho_n: f64,
    /// Width of the sliding term [m/s].
    pub ssc_phi_mps: f64,
    /// Time constant of the smoothing filter [s].
    pub ssc_filter_s: f64,
    /// Seconds by which the deck's motion is predicted ahead: sensing, command and rotor delays.
    pub deck_lead_s: f64,
    /// Limits of the actuators.
    pub limits: Limits<f64>,
}

impl Default for ControlSettings {
    fn default() -> Self {
        let (imbc, ssc) = (
            Imbc::<f64>::new(std::f64::consts::PI),
            Ssc::<f64>::default(),
        );
        Self {
            c_per_s: C_GROUND_PER_S,
            end_height_m: 0.0,
            gains: Gains::default(),
            imbc_poles_per_s: imbc.poles_per_s,
            ssc_rho_n: ssc.rho_n,
            ssc_phi_mps: ssc.phi_mps,
            ssc_filter_s: ssc.filter_s,
            deck_lead_s: 0.09,
            limits: Limits::default(),
        }
    }
}

impl ReproduceSettings {
    /// The settings of a fast look: fewer rig trials and landings.
    #[must_use]
    pub fn quick() -> Self {
        Self {
            trials: 8,
            quick: true,
            ..Self::default()
        }
    }

    /// Checks all settings; `file` names them in errors.
    ///
    /// # Errors
    /// The first setting out of range.
    pub fn check(&self, file: &str) -> Result<()> {
        let bad = |key: &str, message: String| Error::Settings {
            file: file.to_string(),
            message: format!("key `{key}`: {message}"),
        };
        if !(1..=100_000).contains(&self.trials) {
            return Err(bad(
                "trials",
                format!("expected 1 to 100000, found {}", self.trials),
            ));
        }
        // TOML has 64-bit signed numbers.
        if self.seed > i64::MAX as u64 {
            return Err(bad(
                "seed",
                format!("expected at most {}, found {}", i64::MAX, self.seed),
            ));
        }
        self.rig.validate().map_err(|e| bad("rig", e.to_string()))?;
        self.identification.check(file)?;
        for (key, land) in [
            ("ground_landing", self.ground_landing),
            ("deck_landing", self.deck_landing),
        ] {
            land.scenario
                .validate()
                .map_err(|e| bad(&format!("{key}.scenario"), e.to_string()))?;
        }
        Ok(())
    }
}

/// Reads settings from a TOML file.
///
/// # Errors
/// A file that cannot be read, or keys and values that make no sense, with file, line and key.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::file(path, e))?;
    toml::from_str(&text).map_err(|e| Error::Settings {
        file: path.display().to_string(),
        message: e.to_string().trim_end().to_string(),
    })
}

/// Settings as TOML text.
///
/// # Errors
/// A value that TOML cannot hold.
pub fn to_toml<T: Serialize>(settings: &T) -> Result<String> {
    toml::to_string(settings).map_err(|e| Error::Settings {
        file: "settings".to_string(),
        message: e.to_string(),
    })
}
