//! The result of a simulation: JSON, text and CSV.

use std::fmt::Write as _;

use serde::Serialize;
use sindy::Model;
use sindy::model::RunOutcome;

use super::Simulated;
use crate::named::Named;
use crate::trajectories::past;

/// Error of all states together, in standard deviations, up to which a free run counts as a prediction: the threshold
/// that is usual for chaotic systems (Pathak et al., Phys. Rev. Lett. 120, 2018).
pub(crate) const VALID: f64 = 0.4;

/// The object of `simulate --json`.
#[derive(Serialize)]
pub(crate) struct SimulateObject {
    pub(crate) runs: Vec<RunObject>,
    pub(crate) warnings: Vec<String>,
}

/// One run.
#[derive(Clone, Serialize)]
pub(crate) struct RunObject {
    pub(crate) name: String,
    pub(crate) outcome: &'static str,
    /// The last time that was reached.
    pub(crate) end: Option<f64>,
    pub(crate) rows: usize,
    /// The states at the end.
    #[serde(rename = "final")]
    pub(crate) last: Named<f64>,
    /// Root mean square of run minus measured, over the rows that were reached.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rmse: Option<Named<f64>>,
    /// The same over the standard deviation of the measured state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) relative: Option<Named<Option<f64>>>,
}

impl RunObject {
    pub(crate) fn of(model: &Model, simulated: &Simulated) -> Self {
        let Simulated { task, run } = simulated;
        let names = model.states();
        let errors = task.measured.as_ref().map(|measured| {
            let errors = run.states.iter().zip(measured);
            errors.map(|(a, b)| rmse(a, b)).collect::<Vec<f64>>()
        });
        let relative = task.measured.as_ref().zip(errors.as_ref());
        let relative = relative.map(|(measured, errors)| {
            let ratio = |(e, m): (&f64, &Vec<f64>)| {
                let deviation = deviation(m);
                (deviation > 0.0).then(|| e / deviation)
            };
            Named::new(names, errors.iter().zip(measured).map(ratio))
        });
        Self {
            name: task.name.clone(),
            outcome: outcome(&run.outcome),
            end: run.time.last().copied(),
            rows: run.time.len(),
            last: Named::new(names, run.states.iter().filter_map(|s| s.last().copied())),
            rmse: errors.map(|e| Named::new(names, e)),
            relative,
        }
    }

    /// The largest error of a state over its standard deviation, root mean square, over all runs with measurements.
    pub(crate) fn worst_error<'a>(runs: impl Iterator<Item = &'a Self>) -> Option<(f64, &'a str)> {
        let states = runs.filter_map(|run| run.relative.as_ref());
        let errors = states.flat_map(Named::iter);
        errors
            .filter_map(|(state, error)| Some(((*error)?, state)))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// The name of an outcome.
pub(crate) fn outcome(outcome: &RunOutcome) -> &'static str {
    match outcome {
        RunOutcome::Finished => "finished",
        RunOutcome::BlewUp { .. } => "blew_up",
        RunOutcome::OutOfRange { .. } => "out_of_range",
        RunOutcome::StepTooSmall { .. } => "step_too_small",
        RunOutcome::StepLimit { .. } => "step_limit",
        _ => "ended_early",
    }
}

/// Root mean square difference over the rows that both have.
pub(crate) fn rmse(a: &[f64], b: &[f64]) -> f64 {
    let rows = a.len().min(b.len()).max(1) as f64;
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (sum / rows).sqrt()
}

/// Standard deviation about the mean.
pub(crate) fn deviation(values: &[f64]) -> f64 {
    let rows = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / rows;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / rows).sqrt()
}

/// The result as text for people.
pub(crate) fn text(model: &Model, runs: &[RunObject]) -> String {
    let mut out = format!("{model:.5}{}", past::words(model));
    for run in runs {
        let outcome = run.outcome.replace('_', " ");
        let _ = write!(out, "\n{}: {outcome}, {} rows", run.name, run.rows);
        if let Some(end) = run.end {
            let _ = write!(out, ", to time {end}");
        }
        for (i, (name, value)) in run.last.iter().enumerate() {
            let size = value.abs();
            let _ = match size == 0.0 || (1e-3..1e7).contains(&size) {
                true => write!(out, "\n  {name} = {value:.6} at the end"),
                false => write!(out, "\n  {name} = {value:.5e} at the end"),
            };
            if let Some(rmse) = &run.rmse {
                let _ = write!(out, ", RMSE {:.4e}", rmse.value(i));
            }
            if let Some(relative) = run.relative.as_ref().and_then(|r| *r.value(i)) {
                let percent = 100.0 * relative;
                let _ = write!(out, " ({percent:.3} % of the measured standard deviation)");
            }
        }
    }
    out
}

/// All runs as a table: trajectory (if there are several), time, states, and measured states where there are any.
pub(crate) fn csv(model: &Model, simulated: &[Simulated]) -> String {
    let several = simulated.len() > 1;
    let measured = simulated.iter().any(|s| s.task.measured.is_some());
    let mut out = String::new();
    let mut header: Vec<String> = Vec::new();
    header.extend(several.then(|| "trajectory".to_owned()));
    header.push("t".to_owned());
    header.extend(model.states().iter().cloned());
    if measured {
        header.extend(model.states().iter().map(|s| format!("{s} measured")));
    }
    out.push_str(&header.iter().map(|h| cell(h)).collect::<Vec<_>>().join(","));
    out.push('\n');
    for Simulated { task, run } in simulated {
        let name = cell(&task.name);
        for (row, time) in run.time.iter().enumerate() {
            if several {
                let _ = write!(out, "{name},");
            }
            let _ = write!(out, "{time}");
            for column in run.states.iter().chain(task.measured.iter().flatten()) {
                let _ = write!(out, ",{}", column[row]);
            }
            out.push('\n');
        }
    }
    out
}

/// A cell, quoted where it must be.
fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r', '#']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text.to_owned()
}
