//! A campaign whose vehicle is flown by a real autopilot program, in place of the simulated attitude control.
//!
//! Here are only its settings. The program that starts autopilots flies the landings, as a
//! [`LandingBackend`](super::LandingBackend).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use toml::{Table, Value};
use touchdown_flight::Method;
use touchdown_model::Card;
use touchdown_sim::landing::space::SpaceScenario;

use super::axes::KeyError;
use super::points::Sweep;
use super::settings::SweepSettings;
use crate::cards::CardPaths;
use crate::error::Result;
use crate::settings_file::merge;
use crate::vehicle::VehicleSettings;

/// An autopilot program.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AutopilotProgram {
    /// PX4.
    Px4,
    /// ArduCopter.
    ArduPilot,
}

impl AutopilotProgram {
    /// Its name in settings and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Px4 => "px4",
            Self::ArduPilot => "ardupilot",
        }
    }

    /// Its name for people.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Px4 => "PX4",
            Self::ArduPilot => "ArduPilot",
        }
    }

    /// The landings of its own landing mode, in the place of a controller's name.
    #[must_use]
    pub fn own_landing(self) -> &'static str {
        match self {
            Self::Px4 => "LAND of PX4",
            Self::ArduPilot => "LAND of ArduPilot",
        }
    }
}

/// How an autopilot is run in the loop.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LoopSettings {
    /// The program, relative to the sweep file.
    pub program: PathBuf,
    /// Simulated seconds in a second; 0 is as fast as the machine can.
    pub speed: f64,
    /// Whether the truth of each landing and the recording of its companion are kept.
    pub record: bool,
    /// Settings of `touchdown fly` for the companion that lands, or their file, relative to the sweep file; without them,
    /// the autopilot's own landing mode lands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub companion: Option<CompanionSource>,
    /// Parameters of the autopilot, beside those that are always set.
    pub parameters: BTreeMap<String, f64>,
}

impl Default for LoopSettings {
    fn default() -> Self {
        Self {
            program: PathBuf::new(),
            speed: 1.0,
            record: false,
            companion: None,
            parameters: BTreeMap::new(),
        }
    }
}

/// Where the companion's settings stand.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(untagged)]
pub enum CompanionSource {
    /// In a file of `touchdown fly`. Its `control`, `models` and `cards` replace those of the scenario.
    File(PathBuf),
    /// Here. The landing computer is that of the scenario.
    Table(Table),
}

/// Checks the settings of an autopilot in the loop. Its program gets an absolute path, and the file of its companion
/// becomes a table; what that file has on the landing computer becomes part of the scenario. Returns the thrust card of that
/// file.
pub(super) fn resolve(
    settings: &mut SweepSettings,
    folder: &Path,
    bad: &KeyError<'_>,
) -> Result<Option<Card>> {
    let vehicle = settings.vehicle;
    let mut thrust = None;
    let scenario = &mut settings.scenario;
    let (Some(_), Some(of_loop)) = (settings.autopilot, &mut settings.software_in_the_loop) else {
        return match (settings.autopilot, &settings.software_in_the_loop) {
            (Some(_), None) => Err(bad(
                "software_in_the_loop.program",
                "expected the path of the autopilot's program, found none",
            )),
            (None, Some(_)) => Err(bad(
                "autopilot",
                "expected \"px4\" or \"ardupilot\" beside `software_in_the_loop`, found none",
            )),
            _ => Ok(None),
        };
    };
    let speed = of_loop.speed;
    if !(0.0..=1000.0).contains(&speed) {
        let found = format!("expected 0 to 1000, found {speed}");
        return Err(bad("software_in_the_loop.speed", &found));
    }
    let program = folder.join(&of_loop.program);
    of_loop.program = std::path::absolute(&program).unwrap_or(program);
    let key = "software_in_the_loop.companion";
    if let Some(CompanionSource::File(file)) = &of_loop.companion {
        let file = folder.join(file);
        let text = std::fs::read_to_string(&file).map_err(|e| crate::Error::file(&file, e))?;
        let mut table = text
            .parse::<Table>()
            .map_err(|e| bad(key, &format!("{}: {e}", file.display())))?;
        thrust = into_scenario(&mut table, scenario, &vehicle, &file, &|message| {
            bad(key, &message)
        })?;
        of_loop.companion = Some(CompanionSource::Table(table));
    }
    if let Some(CompanionSource::Table(table)) = &of_loop.companion {
        for of_scenario in ["control", "models", "cards"] {
            if table.contains_key(of_scenario) {
                let found =
                    format!("`{of_scenario}`: expected in `scenario` or `cards`, found here");
                return Err(bad(key, &found));
            }
        }
    }
    Ok(thrust)
}

/// Moves what a companion's file has on the landing computer into the scenario. Its link is not used. Returns its thrust
/// card.
fn into_scenario(
    table: &mut Table,
    scenario: &mut SpaceScenario,
    vehicle: &VehicleSettings,
    file: &Path,
    bad: &dyn Fn(String) -> crate::Error,
) -> Result<Option<Card>> {
    table.remove("link");
    table.remove("signing");
    if let Some(given) = table.remove("control") {
        scenario.control = replaced(given).map_err(|e| bad(format!("`control`: {e}")))?;
    }
    if let Some(given) = table.remove("models") {
        scenario.models = replaced(given).map_err(|e| bad(format!("`models`: {e}")))?;
    }
    if let Some(given) = table.remove("cards") {
        let cards: CardPaths = given.try_into().map_err(|e| bad(format!("`cards`: {e}")))?;
        let folder = file.parent().unwrap_or(Path::new("."));
        let model = |card: &Card| vehicle.thrust(card);
        return cards.from(folder).put_into(&model, &mut scenario.models);
    }
    Ok(None)
}

/// Settings of which some keys are given; the others have their defaults.
fn replaced<T>(given: Value) -> std::result::Result<T, String>
where
    T: Default + Serialize + serde::de::DeserializeOwned,
{
    let mut whole = Table::try_from(T::default()).map_err(|e| e.to_string())?;
    match given {
        Value::Table(given) => merge(&mut whole, given),
        other => return Err(format!("expected a table, found {other}")),
    }
    whole
        .try_into()
        .map_err(|e: toml::de::Error| e.message().to_string())
}

impl SweepSettings {
    /// Who lands: the autopilot's own mode, if there is one in the loop without a companion, or else a controller.
    pub(super) fn lander_name(&self, method: Method) -> &'static str {
        let with_companion = |of_loop: &LoopSettings| of_loop.companion.is_some();
        match (self.autopilot, &self.software_in_the_loop) {
            (Some(autopilot), Some(of_loop)) if !with_companion(of_loop) => autopilot.own_landing(),
            _ => method.name(),
        }
    }

    /// The settings that decide on results: those without the place of the autopilot's program, which differs between
    /// machines that fly shards of one campaign.
    pub(super) fn without_places(&self) -> Self {
        let mut settings = self.clone();
        if let Some(of_loop) = &mut settings.software_in_the_loop {
            of_loop.program = PathBuf::new();
        }
        settings
    }
}

impl Sweep {
    /// Checks that an autopilot in the loop can fly these scenarios.
    ///
    /// # Errors
    /// A deck under way: it would be gone before the autopilot holds above it.
    pub fn check_in_the_loop(&self) -> Result<()> {
        let keys = self.grid.iter().map(|axis| &axis.0);
        let mut keys = keys.chain(self.random.iter().map(|axis| &axis.0));
        let swept = keys.any(|key| key.starts_with("course."));
        if swept || self.scenario(0)?.course.is_under_way() {
            return Err(crate::Error::Settings {
                file: self.file.clone(),
                message: "key `scenario.course`: expected a deck that stays in its place, for it would be gone before the autopilot holds above it; \
                          found one under way, which `touchdown land --space` and campaigns without an autopilot fly"
                    .to_owned(),
            });
        }
        Ok(())
    }
}
