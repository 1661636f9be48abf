//! Many landings of one method, and their figures.

use rayon::prelude::*;
use serde::Serialize;
use touchdown_flight::touch::TouchClass;
use touchdown_flight::types::Measurement;
use touchdown_flight::vertical_controller::VerticalController;
use touchdown_sim::deck::spline::MotionSpline;
use touchdown_sim::landing::vertical::LandingScenario;
use touchdown_sim::landing::vertical::{Landing, Outcome, land_on};

use crate::error::Result;
use crate::progress::Progress;
use crate::statistics::Summary;

/// Figures of one method over its trials; absent if no trial has one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LandingFigures {
    /// Trials.
    pub trials: usize,
    /// Trials that landed.
    pub landed: usize,
    /// Of these, those that landed hard ([`touchdown_flight::touch`]).
    pub hard: usize,
    /// Trials that came down too fast.
    pub crashed: usize,
    /// Landing time, over landed trials (s).
    pub t_l_s: Option<Summary>,
    /// Relative speed at landing, over landed trials (m/s).
    pub v_l_mps: Option<Summary>,
    /// Total variation of the relative height, over landed trials (m).
    pub s_l_m: Option<Summary>,
    /// Mean height over the last seconds, over trials that timed out in a hover (m).
    pub hover_height_m: Option<Summary>,
}

impl LandingFigures {
    /// The figures of `landings`; `crash_mps` is the scenario's crash speed.
    #[must_use]
    pub fn of(landings: &[Landing], crash_mps: f64) -> Self {
        let landed: Vec<&Landing> = landings
            .iter()
            .filter(|l| l.outcome == Outcome::Landed)
            .collect();
        let over = |pick: fn(&Landing) -> Option<f64>| {
            Summary::of(&landed.iter().filter_map(|l| pick(l)).collect::<Vec<_>>())
        };
        let hover: Vec<f64> = landings
            .iter()
            .filter(|l| l.outcome == Outcome::TimedOut)
            .filter_map(|l| l.hover_height_m)
            .collect();
        Self {
            trials: landings.len(),
            landed: landed.len(),
            hard: landed.iter().filter(|l| is_hard(l, crash_mps)).count(),
            crashed: landings
                .iter()
                .filter(|l| l.outcome == Outcome::Crashed)
                .count(),
            t_l_s: over(|l| l.t_l_s),
            v_l_mps: over(|l| l.v_l_mps),
            s_l_m: over(|l| Some(l.s_l_m)),
            hover_height_m: Summary::of(&hover),
        }
    }
}

/// Whether a landing that has landed did so hard.
fn is_hard(landing: &Landing, crash_mps: f64) -> bool {
    let class = landing.v_l_mps.map(|v| TouchClass::of(v, crash_mps));
    class == Some(TouchClass::Hard)
}

/// Lands `trials` times, on the deck of the scenario or on one that heaves as measured; the first `traces` landings keep their time series. Every landing is a pure
/// function of (scenario, seed, its index), so the result does not depend on the number of threads.
///
/// # Errors
/// A scenario that makes no sense.
pub fn run(
    scenario: &LandingScenario,
    measured: Option<&MotionSpline>,
    pilot: &VerticalController<f64>,
    trials: usize,
    seed: u64,
    traces: usize,
    progress: &dyn Progress,
) -> Result<Vec<Landing>> {
    let start = scenario.nominal_start()?;
    (0..trials)
        .into_par_iter()
        .map(|index| {
            let first = Measurement {
                height_m: start.height_m,
                ..Measurement::default()
            };
            let mut state = pilot.initial(&first, start.throttle);
            let landing = land_on(
                scenario,
                measured,
                index as u64,
                seed,
                &mut |m| pilot.step(&mut state, m, scenario.control_period_s),
                index < traces,
            )?;
            progress.step();
            Ok(landing)
        })
        .collect()
}
