//! The fifth experiment: the whole vehicle in six degrees of freedom, on decks that move and tilt, and with faults.
//!
//! Landings are those of a campaign (`touchdown campaign`): every case is a sweep of one point.

use std::path::Path;

use rayon::prelude::*;
use toml::{Table, Value};
use touchdown_campaign::cards::put_into;
use touchdown_campaign::progress::Progress;
use touchdown_campaign::settings_file::merge;
use touchdown_campaign::sweep::{self, Figures, LandingRow, Sweep, SweepSettings};
use touchdown_campaign::vertical::controllers::Cards;
use touchdown_files::TomlError;
use touchdown_flight::Method;
use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::DescentShape;
use touchdown_sim::deck::rigid::RigidMotion;
use touchdown_sim::landing::space::{Case, SpaceScenario, SpaceTrace};

use crate::error::{Error, Result};
use crate::settings::ReproduceSettings;

/// Keys that the cases themselves set.
const OF_CASES: [&str; 3] = ["deck", "faults", "ground_effect_strength"];

/// How a landing is flown.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub enum SeaMethod {
    /// As set: by default `dynamic+observer`, and a planner that waits for a window and plans the descent.
    Planned,
    /// The same controller and reference, but straight down as soon as the vehicle is ready.
    StraightDown,
    /// The paper's own set-up: `dynamic` with the exponential reference.
    Published,
}

impl SeaMethod {
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
    pub how: SeaMethod,
    /// The landings, a campaign of one point.
    pub sweep: Sweep,
}

/// The landings of one case, flown in one way.
#[derive(Clone, Debug)]
pub struct SeaLandings {
    /// The case.
    pub case: Case,
    /// How it is flown.
    pub how: SeaMethod,
    /// The landings, by trial.
    pub rows: Vec<LandingRow>,
    /// Their figures.
    pub figures: Figures,
}

/// The record of a landing.
#[derive(Clone, Debug)]
pub struct SeaTrack {
    /// How it was flown.
    pub how: SeaMethod,
    /// Where, and by which vehicle.
    pub scenario: SpaceScenario,
    /// The record.
    pub trace: SpaceTrace,
}

/// The experiment.
#[derive(Clone, Debug)]
pub struct SeaExperiment {
    /// All landings: decks, then faults.
    pub landings: Vec<SeaLandings>,
    /// Records of the first landing on the heaving deck: planned, and as published.
    pub tracks: Vec<SeaTrack>,
    /// The measured motion of the deck, as its file has it.
    pub series: Option<Vec<u8>>,
}

impl SeaExperiment {
    /// The landings of a case.
    #[must_use]
    pub fn of(&self, case: Case, how: SeaMethod) -> Option<&SeaLandings> {
        self.landings
            .iter()
            .find(|l| l.case == case && l.how == how)
    }
}

/// The landings of all cases with the models of `cards`, checked: `trials` of every case, half as many of every fault;
/// `file` names the settings in errors.
///
/// # Errors
/// Keys and values that make no sense, with file, key, expected and found.
pub fn cells(
    settings: &ReproduceSettings,
    cards: Option<&Cards>,
    file: &str,
) -> Result<Vec<SeaCell>> {
    let mut models = FlightModels::paper();
    if let Some(cards) = cards {
        put_into(
            Some(&cards.thrust),
            cards.empirical.as_ref(),
            cards.dynamic.as_ref(),
            &mut models,
        )?;
    }
    let sea = &settings.sea;
    let bad = |key: &str, message: String| Error::setting(file, &format!("sea.{key}"), &message);
    if let Some(key) = OF_CASES.iter().find(|key| sea.scenario.contains_key(**key)) {
        return Err(bad(
            &format!("scenario.{key}"),
            "is what the cases differ in; `touchdown campaign` sweeps it".into(),
        ));
    }
    let trials = settings.trials;
    let decks = Case::DECKS
        .into_iter()
        .flat_map(|c| SeaMethod::ALL.map(|h| (c, h, trials)));
    let faults = Case::FAULTS.map(|case| (case, SeaMethod::Planned, trials.div_ceil(2)));
    decks
        .chain(faults)
        .map(|(case, how, trials)| {
            let mut scenario = SpaceScenario {
                plant: settings.rig.plant,
                models,
                ..case.scenario()
            };
            // The models are those of the rig's plant, so no deck weakens its ground effect.
            if case != Case::Strong {
                scenario.ground_effect_strength = 1.0;
            }
            let mut series = None;
            if case == Case::Sea {
                series.clone_from(&sea.series);
                scenario.deck = match series {
                    Some(_) => RigidMotion::Still {},
                    None => RigidMotion::Sea(sea.wave),
                };
            }
            let mut scenario =
                with_keys(&scenario, &sea.scenario).map_err(|message| bad("scenario", message))?;
            match how {
                SeaMethod::Planned => {}
                SeaMethod::StraightDown => scenario.control.planner = false,
                SeaMethod::Published => {
                    scenario.control.method = Method::Dynamic;
                    scenario.control.reference = DescentShape::Exponential;
                }
            }
            let sweep = SweepSettings {
                seed: settings.seed,
                trials: trials as u64,
                series,
                scenario,
                ..SweepSettings::default()
            };
            let named = format!("{file}: sea, case `{}`", case.name());
            let sweep = Sweep::new(sweep, Path::new(""), named)?;
            Ok(SeaCell { case, how, sweep })
        })
        .collect()
}

/// A scenario with the keys that are changed.
fn with_keys(scenario: &SpaceScenario, keys: &Table) -> std::result::Result<SpaceScenario, String> {
    let mut whole = Table::try_from(scenario).map_err(|e| e.to_string())?;
    merge(&mut whole, keys.clone());
    Value::Table(whole)
        .try_into()
        .map_err(|e: toml::de::Error| TomlError::new("", &e).to_string())
}

/// Records of the first landing on the heaving deck: planned, and as published.
///
/// # Errors
/// A lander that cannot be built.
pub fn tracks(cells: &[SeaCell]) -> Result<Vec<SeaTrack>> {
    let mut tracks = Vec::new();
    for how in [SeaMethod::Planned, SeaMethod::Published] {
        let watched = |cell: &&SeaCell| cell.case == Case::Heave && cell.how == how;
        let Some(cell) = cells.iter().find(watched) else {
            continue;
        };
        let flown = sweep::replay(&cell.sweep, &[0])?;
        tracks.extend(flown.into_iter().map(|trace| SeaTrack {
            how,
            scenario: cell.sweep.settings().scenario.clone(),
            trace,
        }));
    }
    Ok(tracks)
}

/// Runs the experiment with the models of `cards`.
///
/// # Errors
/// Settings that make no sense, or cards that cannot be flown.
pub fn run(
    settings: &ReproduceSettings,
    cards: &Cards,
    progress: &dyn Progress,
) -> Result<SeaExperiment> {
    let cells = cells(settings, Some(cards), "settings")?;
    let all = cells.iter().map(|cell| cell.sweep.landings()).sum();
    progress.stage("landings at sea", all);
    let landings = cells
        .par_iter()
        .map(|cell| {
            let rows = sweep::rows(&cell.sweep, 0..cell.sweep.landings(), progress)?;
            Ok(SeaLandings {
                case: cell.case,
                how: cell.how,
                figures: Figures::of(&rows, &cell.sweep.settings().scenario.crash),
                rows,
            })
        })
        .collect::<Result<_>>()?;
    let series = cells.iter().find_map(|cell| cell.sweep.measured());
    Ok(SeaExperiment {
        landings,
        tracks: tracks(&cells)?,
        series: series.map(<[u8]>::to_vec),
    })
}
