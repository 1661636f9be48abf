//! How a model does on trajectories that it has not seen: its slopes, and its free run.

use serde::Serialize;
use sindy::Model;
use sindy::derivative::savgol::Smoothed;
use sindy::derivative::{Differentiator, SavgolSearch, SmoothingSpline, choose_savgol};
use sindy::model::{Interpolation, Simulation, Time};

use crate::error::{Error, Result};
use crate::named::Named;
use crate::simulate::object::{RunObject, VALID, deviation, rmse};
use crate::simulate::setup::{Stretch, stretches};
use crate::simulate::{Simulated, simulate};
use crate::trajectories::Trajectory;

/// Part of a stretch at either end whose slopes are not judged, at least, and half a window of the filter if that is
/// more: there they are least certain.
const MARGIN: f64 = 0.05;

/// The scores, and what is behind them.
pub(crate) struct Test {
    pub(crate) object: TestObject,
    pub(crate) runs: Vec<Simulated>,
    /// For each run, the slopes that were judged; none for a stretch that was too short.
    pub(crate) slopes: Vec<Option<Slopes>>,
}

/// Slopes along a stretch; in discrete time, next samples.
pub(crate) struct Slopes {
    pub(crate) time: Vec<f64>,
    /// Of the data, for each state.
    pub(crate) measured: Vec<Vec<f64>>,
    /// Of the model, for each state.
    pub(crate) modelled: Vec<Vec<f64>>,
}

/// The scores on test data in the object of `fit --json`.
#[derive(Clone, Serialize)]
pub(crate) struct TestObject {
    /// Root mean square of the model's slope minus that of the smoothed data, in continuous time; of the model's next
    /// sample minus the measured one, in discrete time.
    pub(crate) derivative: Option<Named<SlopeError>>,
    pub(crate) free_run: Vec<FreeRun>,
}

/// Error of one state's slope.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct SlopeError {
    pub(crate) rmse: f64,
    /// The same over the standard deviation of the measured slope.
    pub(crate) relative: Option<f64>,
}

/// A free run from the start of a stretch.
#[derive(Clone, Serialize)]
pub(crate) struct FreeRun {
    #[serde(flatten)]
    pub(crate) run: RunObject,
    /// Time from the start for which the error of all states together stays below 0.4 standard deviations.
    pub(crate) valid_time: f64,
    /// Length of the stretch.
    pub(crate) length: f64,
}

/// Scores a model.
pub(crate) fn of(
    model: &Model,
    trajectories: &[Trajectory],
    between: &[Interpolation],
    warnings: &mut Vec<String>,
) -> Result<Test> {
    let mut parts = Vec::new();
    for trajectory in trajectories {
        parts.extend(stretches(model, trajectory, warnings)?);
    }
    let (smooth, edge) = smooth(model, &parts, warnings);
    let slopes = parts
        .iter()
        .zip(&smooth)
        .map(|(part, smooth)| match (model.time(), smooth) {
            (Time::Continuous, None) => Ok(None),
            (Time::Continuous, Some(smooth)) => slopes(model, part, smooth, edge).map(Some),
            (Time::Discrete { .. }, _) => next_samples(model, part).map(Some),
        })
        .collect::<Result<Vec<_>>>()?;
    let mut runs = Vec::new();
    for (part, smooth) in parts.iter().zip(&smooth) {
        let mut task = part.task(model, between)?;
        // One noisy sample is no fair start where a smoothed one is known.
        if let (Time::Continuous, Some(smooth)) = (model.time(), smooth) {
            task.start = smooth.iter().map(|s| s.value[0]).collect();
        }
        let run = simulate(model, &task, &Simulation::adaptive())?;
        runs.push(Simulated { task, run });
    }
    let free_run = runs.iter().map(|s| free_run(model, s)).collect();
    Ok(Test {
        object: TestObject {
            derivative: errors(model, &slopes),
            free_run,
        },
        runs,
        slopes,
    })
}

/// Every state smoothed, `None` for a stretch that is too short for it, and half of the widest window.
fn smooth(
    model: &Model,
    parts: &[Stretch<'_>],
    warnings: &mut Vec<String>,
) -> (Vec<Option<Vec<Smoothed>>>, usize) {
    let mut edge = 0;
    let methods: Vec<Differentiator> = (0..model.states().len())
        .map(|state| {
            let signals: Vec<(&[f64], &[f64])> = parts
                .iter()
                .filter(|p| !p.filled)
                .map(|p| (p.time, p.columns[state]))
                .collect();
            match choose_savgol(&signals, &SavgolSearch::default()) {
                Ok(choice) => {
                    edge = edge.max(choice.filter.window() / 2);
                    choice.filter.into()
                }
                // On uneven time.
                Err(_) => SmoothingSpline::cross_validated().into(),
            }
        })
        .collect();
    let smooth = parts
        .iter()
        .map(|part| {
            if part.filled {
                return None;
            }
            let smooth = methods.iter().zip(&part.columns);
            let smooth = smooth.map(|(method, y)| method.apply(part.time, y));
            match smooth.collect::<std::result::Result<Vec<_>, _>>() {
                Ok(smooth) => Some(smooth),
                Err(e) => {
                    warnings.push(format!("{}: no slopes to judge by: {e}", part.name));
                    None
                }
            }
        })
        .collect();
    (smooth, edge)
}

fn slopes(model: &Model, part: &Stretch<'_>, smooth: &[Smoothed], edge: usize) -> Result<Slopes> {
    let mut columns: Vec<&[f64]> = smooth.iter().map(|s| s.value.as_slice()).collect();
    columns.extend(&part.columns[smooth.len()..]);
    let modelled = model
        .predict(&columns)
        .map_err(Error::refused(part.name.clone()))?;
    let rows = part.time.len();
    let margin = ((MARGIN * rows as f64).ceil() as usize).max(edge.min(rows / 4));
    let inner = margin..rows.saturating_sub(margin).max(margin);
    Ok(Slopes {
        time: part.time[inner.clone()].to_vec(),
        measured: smooth
            .iter()
            .map(|s| s.derivative[inner.clone()].to_vec())
            .collect(),
        modelled: modelled.iter().map(|m| m[inner.clone()].to_vec()).collect(),
    })
}

fn next_samples(model: &Model, part: &Stretch<'_>) -> Result<Slopes> {
    let last = part.time.len() - 1;
    let columns: Vec<&[f64]> = part.columns.iter().map(|c| &c[..last]).collect();
    let modelled = model
        .predict(&columns)
        .map_err(Error::refused(part.name.clone()))?;
    let measured = part.columns.iter().take(modelled.len());
    Ok(Slopes {
        time: part.time[1..].to_vec(),
        measured: measured.map(|c| c[1..].to_vec()).collect(),
        modelled,
    })
}

fn errors(model: &Model, slopes: &[Option<Slopes>]) -> Option<Named<SlopeError>> {
    let all = |state: usize, which: fn(&Slopes) -> &Vec<Vec<f64>>| -> Vec<f64> {
        let parts = slopes.iter().flatten();
        parts
            .flat_map(|s| which(s)[state].iter().copied())
            .collect()
    };
    if slopes.iter().flatten().all(|s| s.time.is_empty()) {
        return None;
    }
    let error = |state: usize| {
        let (measured, modelled) = (all(state, |s| &s.measured), all(state, |s| &s.modelled));
        let (rmse, deviation) = (rmse(&modelled, &measured), deviation(&measured));
        SlopeError {
            rmse,
            relative: (deviation > 0.0).then(|| rmse / deviation),
        }
    };
    Some(Named::new(
        model.states(),
        (0..model.states().len()).map(error),
    ))
}

fn free_run(model: &Model, simulated: &Simulated) -> FreeRun {
    let Simulated { task, run } = simulated;
    let start = task.time[0];
    let measured = task.measured.as_deref().unwrap_or_default();
    let scales: Vec<f64> = measured.iter().map(|m| deviation(m)).collect();
    let error = |row: usize| {
        let squares = measured.iter().zip(&run.states).zip(&scales);
        let squares = squares
            .filter(|(_, scale)| **scale > 0.0)
            .map(|((m, s), scale)| ((m[row] - s[row]) / scale).powi(2));
        (squares.sum::<f64>() / scales.len().max(1) as f64).sqrt()
    };
    let valid = (0..run.time.len()).take_while(|&row| error(row) <= VALID);
    FreeRun {
        run: RunObject::of(model, simulated),
        valid_time: valid.last().map_or(0.0, |row| run.time[row] - start),
        length: task.time[task.time.len() - 1] - start,
    }
}
