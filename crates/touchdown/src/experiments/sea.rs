//! The fifth experiment: the whole vehicle in six degrees of freedom, on decks that move and tilt, and with faults.
//!
//! Landings are those of a campaign (`touchdown campaign`): every case is a sweep of one point.

use rayon::prelude::*;
use touchdown_sim::landing::space::{Case, FlightModels, SpaceTrace};

use crate::error::Result;
use crate::pilot::Cards;
use crate::progress::Progress;
use crate::scenario::put_into;
use crate::settings::ReproduceSettings;
use crate::settings::sea::{How, SeaCell};
use crate::sweep::{self, Figures, Row};

/// The landings of one case, flown in one way.
#[derive(Clone, Debug)]
pub struct SeaLandings {
    /// The case.
    pub case: Case,
    /// How it is flown.
    pub how: How,
    /// The landings, by trial.
    pub rows: Vec<Row>,
    /// Their figures.
    pub figures: Figures,
}

/// The experiment.
#[derive(Clone, Debug)]
pub struct SeaExperiment {
    /// All landings: decks, then faults.
    pub landings: Vec<SeaLandings>,
    /// Record of the first planned landing on the heaving deck.
    pub track: SpaceTrace,
    /// The measured motion of the deck, as its file has it.
    pub series: Option<Vec<u8>>,
}

impl SeaExperiment {
    /// The landings of a case.
    #[must_use]
    pub fn of(&self, case: Case, how: How) -> Option<&SeaLandings> {
        self.landings
            .iter()
            .find(|l| l.case == case && l.how == how)
    }
}

/// The landings' settings with the models of `cards`.
pub(crate) fn cells(
    settings: &ReproduceSettings,
    cards: Option<&Cards>,
    file: &str,
) -> Result<Vec<SeaCell>> {
    let mut models = FlightModels::default();
    if let Some(cards) = cards {
        put_into(
            Some(&cards.thrust),
            cards.empirical.as_ref(),
            cards.dynamic.as_ref(),
            &mut models,
        )?;
    }
    settings.sea.cells(
        &settings.rig.plant,
        &models,
        settings.trials,
        settings.seed,
        file,
    )
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
                figures: Figures::of(&rows),
                rows,
            })
        })
        .collect::<Result<_>>()?;
    let heaving = cells
        .iter()
        .find(|cell| cell.case == Case::Heave && cell.how == How::Planned);
    let track = match heaving {
        Some(cell) => sweep::replay(&cell.sweep, &[0])?.pop(),
        None => None,
    };
    let series = cells.iter().find_map(|cell| cell.sweep.measured());
    Ok(SeaExperiment {
        landings,
        track: track.unwrap_or_default(),
        series: series.map(<[u8]>::to_vec),
    })
}
