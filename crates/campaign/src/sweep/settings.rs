//! The sweep file.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use touchdown_sim::landing::space::SpaceScenario;

use super::software_in_the_loop::{AutopilotProgram, LoopSettings};
use super::stated::StatedKeys;
use crate::cards::CardPaths;
use crate::error::Result;
use crate::measured_deck::SeriesSettings;
use crate::settings_file::{parse, read_with_given};
use crate::vehicle::VehicleSettings;

/// What `touchdown campaign` flies.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SweepSettings {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Landings at every point of the grid.
    pub trials: u64,
    /// Landings in a block, which is one file.
    pub block: u64,
    /// The autopilot in the loop; without it, the simulated attitude control flies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub autopilot: Option<AutopilotProgram>,
    /// How that autopilot is run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub software_in_the_loop: Option<LoopSettings>,
    /// Model cards, relative to the sweep file; a model without a card is the built-in one of
    /// `scenario.models`.
    pub cards: CardPaths,
    /// What is known of the vehicle beside its thrust card; it goes into `scenario`.
    #[serde(skip_serializing_if = "VehicleSettings::is_empty")]
    pub vehicle: VehicleSettings,
    /// A measured motion of the deck, in place of `scenario.deck`.
    pub series: Option<SeriesSettings>,
    /// A learned policy (JSON, as `touchdown.Policy` of Python writes it), relative to the sweep file. It flies the descents
    /// where `control.controller` is `"policy"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub policy: Option<PathBuf>,
    /// Lists of values by the dotted keys of `scenario`.
    pub grid: toml::Table,
    /// Distributions by the dotted keys of `scenario`.
    pub random: toml::Table,
    /// What is the same for all landings.
    pub scenario: SpaceScenario,
    /// Keys of `scenario` that the file states: they do not follow the vehicle.
    #[serde(skip)]
    pub stated: StatedKeys,
}

impl Default for SweepSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            trials: 100,
            block: 200,
            autopilot: None,
            software_in_the_loop: None,
            cards: CardPaths::default(),
            vehicle: VehicleSettings::default(),
            series: None,
            policy: None,
            grid: toml::Table::new(),
            random: toml::Table::new(),
            scenario: SpaceScenario::default(),
            stated: StatedKeys::default(),
        }
    }
}

impl SweepSettings {
    /// Reads a sweep's file.
    ///
    /// # Errors
    /// A file that cannot be read, or keys and values that make no sense, with file, line and key.
    pub fn read(path: &Path) -> Result<Self> {
        let (mut settings, given) = read_with_given::<Self>(path)?;
        settings.stated = StatedKeys::of(&given);
        Ok(settings)
    }

    /// As [`Self::read`], from text; `file` names it in errors.
    ///
    /// # Errors
    /// Keys and values that make no sense, with file, line and key.
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        let mut settings: Self = parse(text, file)?;
        // Text that was just parsed.
        settings.stated = StatedKeys::of(&toml::from_str(text).unwrap_or_default());
        Ok(settings)
    }
}
