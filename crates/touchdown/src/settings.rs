//! Settings of whole runs, as they stand in TOML files.

pub mod sea;

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use touchdown_flight::control::{Gains, Imbc, Ssc};
use touchdown_flight::types::Limits;
use touchdown_sim::landing::vertical::LandingScenario;
use touchdown_sim::rig::RigSettings;

use crate::error::{Error, Result};
use crate::identify::IdentificationSettings;
use crate::sweep::SERIES;

/// Rate of the descent at which the reference itself reaches 0.1 m at the published 5.1 s on the ground (1/s): calibrated.
pub const C_GROUND_PER_S: f64 = 0.7073;
/// Rate of the descent at which the reference itself reaches 0.1 m at the published 5.38 s on the deck (1/s): calibrated.
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
    /// Landing at sea, in six degrees of freedom.
    pub sea: sea::SeaSettings,
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
            sea: sea::SeaSettings::default(),
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
    /// Rate C of the descent, eq. (13) (1/s).
    pub c_per_s: f64,
    /// Height that the descent ends at (m).
    pub end_height_m: f64,
    /// Gains of eq. (10).
    pub gains: Gains<f64>,
    /// Poles of the internal model (1/s) (`imbc`, reconstructed).
    pub imbc_poles_per_s: [f64; 3],
    /// Amplitude of the sliding term (N) (`ssc`, reconstructed).
    pub ssc_rho_n: f64,
    /// Width of the sliding term (m/s).
    pub ssc_phi_mps: f64,
    /// Time constant of the smoothing filter (s).
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

    /// The same with the files that they name under the names that they have in a run's folder.
    #[must_use]
    pub fn with_files_here(&self) -> Self {
        let mut here = self.clone();
        if let Some(series) = &mut here.sea.series {
            series.file = SERIES.into();
        }
        here
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
        check_seed(self.seed, file)?;
        self.rig.validate().map_err(|e| bad("rig", e.to_string()))?;
        self.identification.check(file)?;
        for (key, land) in [
            ("ground_landing", self.ground_landing),
            ("deck_landing", self.deck_landing),
        ] {
            crate::pilot::check(&land)
                .map_err(|e| bad(&format!("{key}.control"), e.to_string()))?;
            land.scenario
                .validate()
                .map_err(|e| bad(&format!("{key}.scenario"), e.to_string()))?;
        }
        crate::experiments::sea::cells(self, None, file).map(drop)
    }
}

/// TOML has 64-bit signed numbers.
pub(crate) fn check_seed(seed: u64, file: &str) -> Result<()> {
    check_seed_of("seed", seed, file)
}

/// As [`check_seed`], of a seed by another name.
pub(crate) fn check_seed_of(key: &str, seed: u64, file: &str) -> Result<()> {
    if i64::try_from(seed).is_ok() {
        return Ok(());
    }
    Err(Error::Settings {
        file: file.to_string(),
        message: format!("key `{key}`: expected at most {}, found {seed}", i64::MAX),
    })
}

/// Reads settings from a TOML file. Keys that the file leaves out, at any depth, have the value that they have in
/// `T::default()`.
///
/// # Errors
/// A file that cannot be read, or keys and values that make no sense, with file, line and key.
pub fn read<T: Default + DeserializeOwned + Serialize>(path: &Path) -> Result<T> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::file(path, e))?;
    parse(&text, &path.display().to_string())
}

/// As [`read`], from text; `file` names it in errors.
///
/// # Errors
/// Keys and values that make no sense, with file, line and key.
pub fn parse<T: Default + DeserializeOwned + Serialize>(text: &str, file: &str) -> Result<T> {
    let bad = |e: toml::de::Error| Error::Settings {
        file: file.to_string(),
        message: e.to_string().trim_end().to_string(),
    };
    let given: toml::Table = toml::from_str(text).map_err(bad)?;
    let mut whole: toml::Table = toml::from_str(&to_toml(&T::default())?).map_err(bad)?;
    merge(&mut whole, given);
    whole.try_into().map_err(|merged| {
        // The text as it stands gives the same error with its line, unless it merely leaves keys out.
        match toml::from_str::<T>(text) {
            Err(e) if !e.message().contains("missing field") => bad(e),
            _ => bad(merged),
        }
    })
}

/// Puts `given` over `base`, table by table. A table of another `kind` (or `shape`) replaces the old one whole.
pub(crate) fn merge(base: &mut toml::Table, given: toml::Table) {
    for (key, value) in given {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(old)), toml::Value::Table(new))
                if ["kind", "shape"]
                    .iter()
                    .all(|tag| new.get(*tag).is_none_or(|of| old.get(*tag) == Some(of))) =>
            {
                merge(old, new);
            }
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_keys_left_out_keep_the_default_of_their_own_place() {
        let text = "[deck_landing.control]\nc_per_s = 0.6\n[deck_landing.scenario.plant]\nturbulence = 0.02\n";
        let read: ReproduceSettings = parse(text, "s.toml").unwrap();
        let mut expected = ReproduceSettings::default();
        expected.deck_landing.control.c_per_s = 0.6;
        expected.deck_landing.scenario.plant.turbulence = 0.02;
        assert_eq!(read, expected);
        let still: ReproduceSettings =
            parse("[deck_landing.scenario.deck]\nkind = \"still\"\n", "s.toml").unwrap();
        assert_eq!(
            still.deck_landing.scenario.deck,
            touchdown_sim::deck::DeckMotion::Still
        );
    }

    #[test]
    fn prop_a_table_may_leave_keys_out_at_any_depth() {
        let text = "[deck_landing.control.gains]\nk_p = 5.0\n[deck_landing.scenario.deck]\namplitude_m = 0.06\n";
        let read: ReproduceSettings = parse(text, "s.toml").unwrap();
        assert_eq!(read.deck_landing.control.gains.k_p, 5.0);
        assert_eq!(read.deck_landing.control.gains.gamma, 2.0);
        assert_eq!(read.deck_landing.scenario.deck.highest_m(), 0.06);
    }

    #[test]
    fn prop_unknown_keys_are_named_with_their_line() {
        let error = parse::<ReproduceSettings>("seed = 1\n\ncolour = 3\n", "s.toml")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("s.toml") && error.contains("line 3") && error.contains("colour"),
            "{error}"
        );
    }

    #[test]
    fn prop_settings_are_read_back_as_they_were_written() {
        let settings = ReproduceSettings {
            seed: 77,
            ..ReproduceSettings::quick()
        };
        assert_eq!(
            parse::<ReproduceSettings>(&to_toml(&settings).unwrap(), "s.toml").unwrap(),
            settings
        );
    }
}
