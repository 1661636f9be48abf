//! Settings of the landings at sea.

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};
use touchdown_sim::body::plant::PlantSettings;
use touchdown_sim::deck::rigid::{RigidMotion, SeaSettings as Sea};
use touchdown_sim::landing::space::{Case, Controller, DescentShape, FlightModels, SpaceScenario};

use super::merge;
use crate::error::{Error, Result};
use crate::sweep::{SeriesSettings, Sweep, SweepSettings};

/// What `reproduce` lands on at sea, in six degrees of freedom.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SeaSettings {
    /// The sea and the ship of the case `sea`.
    pub wave: Sea,
    /// A measured motion of the deck in place of them.
    pub series: Option<SeriesSettings>,
    /// Keys of the scenario that are changed in all cases.
    pub scenario: Table,
}

/// How a landing is flown.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub enum How {
    /// As set: by default `dynamic+observer`, and a planner that waits for a window and plans the descent.
    Planned,
    /// The same controller and reference, but straight down as soon as the vehicle is ready.
    StraightDown,
    /// The paper's own set-up: `dynamic` with the exponential reference.
    Published,
}

impl How {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 3] = [Self::Planned, Self::StraightDown, Self::Published];

    /// The name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Planned => "planned",
            Self::StraightDown => "straight_down",
            Self::Published => "published",
        }
    }
}

/// Landings of one case, flown in one way.
#[derive(Clone, Debug)]
pub struct SeaCell {
    /// The case.
    pub case: Case,
    /// How it is flown.
    pub how: How,
    /// The landings, a campaign of one point.
    pub sweep: Sweep,
}

/// Keys that the cases themselves set.
const OF_CASES: [&str; 3] = ["deck", "faults", "ground_effect_strength"];

impl SeaSettings {
    /// The same with relative paths taken from `folder`.
    #[must_use]
    pub fn from(mut self, folder: &Path) -> Self {
        if let Some(series) = &mut self.series {
            series.file = folder.join(&series.file);
        }
        self
    }

    /// All landings that `reproduce` flies at sea, checked: `trials` of every case, of every fault half as many;
    /// `file` names the settings in errors.
    ///
    /// # Errors
    /// Keys and values that make no sense, with file, key, expected and found.
    pub fn cells(
        &self,
        plant: &PlantSettings,
        models: &FlightModels,
        trials: usize,
        seed: u64,
        file: &str,
    ) -> Result<Vec<SeaCell>> {
        let bad = |key: &str, message: String| Error::Settings {
            file: file.to_string(),
            message: format!("key `sea.{key}`: {message}"),
        };
        if let Some(key) = OF_CASES
            .iter()
            .find(|key| self.scenario.contains_key(**key))
        {
            return Err(bad(
                &format!("scenario.{key}"),
                "is what the cases differ in; `touchdown campaign` sweeps it".into(),
            ));
        }
        let decks = Case::DECKS
            .into_iter()
            .flat_map(|c| How::ALL.map(|h| (c, h, trials)));
        let faults = Case::FAULTS.map(|case| (case, How::Planned, trials.div_ceil(2)));
        decks
            .chain(faults)
            .map(|(case, how, trials)| {
                let mut scenario = SpaceScenario {
                    plant: *plant,
                    models: *models,
                    ..case.scenario()
                };
                let mut series = None;
                if case == Case::Sea {
                    series.clone_from(&self.series);
                    scenario.deck = match series {
                        Some(_) => RigidMotion::Still {},
                        None => RigidMotion::Sea(self.wave),
                    };
                }
                let mut scenario = self
                    .put_into(&scenario)
                    .map_err(|message| bad("scenario", message))?;
                match how {
                    How::Planned => {}
                    How::StraightDown => scenario.control.planner = false,
                    How::Published => {
                        scenario.control.controller = Controller::Dynamic;
                        scenario.control.reference = DescentShape::Exponential;
                    }
                }
                let settings = SweepSettings {
                    seed,
                    trials: trials as u64,
                    series,
                    scenario,
                    ..SweepSettings::default()
                };
                let named = format!("{file}: sea, case `{}`", case.name());
                let sweep = Sweep::new(settings, Path::new(""), named)?;
                Ok(SeaCell { case, how, sweep })
            })
            .collect()
    }

    /// A scenario with the keys that are changed.
    fn put_into(&self, scenario: &SpaceScenario) -> std::result::Result<SpaceScenario, String> {
        let mut whole = Table::try_from(scenario).map_err(|e| e.to_string())?;
        merge(&mut whole, self.scenario.clone());
        Value::Table(whole)
            .try_into()
            .map_err(|e: toml::de::Error| e.message().to_string())
    }
}
