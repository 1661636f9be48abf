//! The sweep file.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use touchdown_sim::deck::series::SeriesFormat;
use touchdown_sim::landing::space::SpaceScenario;

use super::software_in_the_loop::{AutopilotProgram, LoopSettings};
use crate::cards::CardPaths;

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
    /// A measured motion of the deck, in place of `scenario.deck`.
    pub series: Option<SeriesSettings>,
    /// Lists of values by the dotted keys of `scenario`.
    pub grid: toml::Table,
    /// Distributions by the dotted keys of `scenario`.
    pub random: toml::Table,
    /// What is the same for all landings.
    pub scenario: SpaceScenario,
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
            series: None,
            grid: toml::Table::new(),
            random: toml::Table::new(),
            scenario: SpaceScenario::default(),
        }
    }
}

/// A measured motion of the deck: a table with a header.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SeriesSettings {
    /// The table (CSV), relative to the sweep file.
    pub file: PathBuf,
    /// Significant height that the heave is scaled to, m; without it, as measured.
    pub significant_height_m: Option<f64>,
    /// Cutoff below which the motion is kept, Hz, or `"noise"` for the lowest that takes away no more than the noise;
    /// without it, the motion runs through every row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutoff_hz: Option<Cutoff>,
    /// Greatest acceleration of the heave, m/s²; without it, that of gravity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest_acceleration_mps2: Option<f64>,
    /// What its columns mean.
    pub format: SeriesFormat,
}

/// Where a measured motion is smoothed.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cutoff {
    /// A frequency, Hz.
    Hz(f64),
    /// By the noise of the series.
    OfNoise(NoiseWord),
}

/// The word `"noise"`.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseWord {
    /// `"noise"`.
    Noise,
}
