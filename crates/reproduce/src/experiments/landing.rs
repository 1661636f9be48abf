//! IV-C and IV-D: landings on the ground and on the oscillating deck.

use touchdown_sim::landing::vertical::Landing;

use crate::error::Result;
use crate::settings::{LandSettings, ReproduceSettings};
use touchdown_campaign::progress::Progress;
use touchdown_campaign::vertical::controllers::{Cards, controller};
use touchdown_campaign::vertical::landings::{self, LandingFigures};
use touchdown_flight::Method;

/// Landings of each method that keep their time series, for figures.
pub const TRACES: usize = 5;

/// All landings of one method.
#[derive(Clone, Debug)]
pub struct MethodLandings {
    /// The method.
    pub method: Method,
    /// The landings, by trial.
    pub landings: Vec<Landing>,
    /// Their figures.
    pub figures: LandingFigures,
}

/// Both experiments.
#[derive(Clone, Debug)]
pub struct LandingExperiments {
    /// On the ground: `feedback`, `empirical`, `dynamic`.
    pub ground: Vec<MethodLandings>,
    /// On the deck with its acceleration fed forward.
    pub with_acceleration: Vec<MethodLandings>,
    /// On the deck without.
    pub without_acceleration: Vec<MethodLandings>,
}

/// Runs both experiments.
///
/// # Errors
/// Settings that make no sense, or cards that cannot be flown.
pub fn run(
    settings: &ReproduceSettings,
    cards: &Cards,
    progress: &dyn Progress,
) -> Result<LandingExperiments> {
    let on_ground = [Method::Feedback, Method::Empirical, Method::Dynamic];
    let cells = on_ground.len() + 2 * Method::VERTICAL.len() - 1;
    progress.stage("landings", (cells * settings.trials) as u64);
    let all = |land: &LandSettings,
               methods: &[Method],
               acceleration: bool|
     -> Result<Vec<MethodLandings>> {
        methods
            .iter()
            .map(|&method| {
                let controller = controller(method, cards, land, acceleration)?;
                let landings = landings::run(
                    &land.scenario,
                    None,
                    &controller,
                    settings.trials,
                    settings.seed,
                    TRACES,
                    progress,
                )?;
                let figures = LandingFigures::of(&landings, land.scenario.crash_speed_mps);
                Ok(MethodLandings {
                    method,
                    landings,
                    figures,
                })
            })
            .collect()
    };
    let ground = all(&settings.ground_landing, &on_ground, false)?;
    let with_acceleration = all(&settings.deck_landing, &Method::VERTICAL, true)?;
    let others: Vec<Method> = Method::VERTICAL
        .into_iter()
        .filter(|m| *m != Method::Imbc)
        .collect();
    let mut without_acceleration = all(&settings.deck_landing, &others, false)?;
    // The internal model has no deck-acceleration term: the same landings stand in both columns.
    if let Some(imbc) = with_acceleration.iter().find(|m| m.method == Method::Imbc) {
        let place = Method::VERTICAL
            .iter()
            .position(|m| *m == Method::Imbc)
            .unwrap_or(0);
        without_acceleration.insert(place, imbc.clone());
    }
    Ok(LandingExperiments {
        ground,
        with_acceleration,
        without_acceleration,
    })
}
