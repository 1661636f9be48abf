//! Past columns: `x_ago3` is the column x three rows before.

use std::fmt::Write as _;

use sindy::model::{Past, Term, Time};
use sindy::trajectory::shift::{Delay, chain, past};
use sindy::{Model, Samples, SindyError};

use super::Trajectory;
use crate::error::{Error, Result};
use crate::numbers::significant;

/// Names that no column of a table has.
const TIME: &str = "(time)";
const WEIGHTS: &str = "(weights)";

/// Column and rows of a name such as `x_ago3`.
fn parts(name: &str) -> Option<(&str, usize)> {
    let (column, rows) = name.rsplit_once("_ago")?;
    Some((column, rows.parse().ok()?))
}

/// The rows of a name such as `x_ago3`.
pub(crate) fn rows_of(name: &str) -> Option<usize> {
    parts(name).map(|p| p.1)
}

/// The meaning of a name such as `x_ago3`.
pub(crate) fn of_name(name: &str) -> Option<Delay> {
    let (column, rows) = parts(name)?;
    Delay::samples(column, rows).ok()
}

/// Reads `--past`; the columns are states or inputs.
pub(crate) fn parse(texts: &[String], known: &[String]) -> Result<Vec<Delay>> {
    let mut all = Vec::new();
    for text in texts {
        let delays = Delay::parse(text).map_err(Error::refused("--past"))?;
        if let Some(other) = delays
            .iter()
            .find(|d| !known.iter().any(|k| k == d.column()))
        {
            return Err(Error::Arguments(format!(
                "--past: expected a state or an input before `@`, found `{}`",
                other.column()
            )));
        }
        all.extend(delays);
    }
    Ok(all)
}

/// Adds past columns to trajectories whose columns are called `names`; gives the names of all. Rows without a past
/// are left out, and a gap ends a trajectory.
pub(crate) fn add(
    trajectories: Vec<Trajectory>,
    names: &[String],
    delays: &[Delay],
) -> Result<(Vec<Trajectory>, Vec<String>)> {
    let weighted = trajectories.iter().any(|t| t.weights.is_some());
    let mut columns = vec![TIME];
    columns.extend(names.iter().map(String::as_str));
    columns.extend(weighted.then_some(WEIGHTS));
    let mut samples = Samples::new(&columns);
    let mut labels = Vec::new();
    for t in trajectories {
        let mut all = vec![t.time];
        all.extend(t.columns);
        all.extend(t.weights);
        labels.push(t.name);
        samples.push_group(all).map_err(Error::refused("--past"))?;
    }
    let shifted = past(&samples, delays, Some(TIME)).map_err(Error::refused("--past"))?;
    let back = shifted.origin.iter().enumerate().map(|(group, &origin)| {
        let mut all = shifted.samples.group(group).to_vec();
        let time = all.remove(0);
        let weights = weighted.then(|| all.remove(names.len()));
        Trajectory {
            name: labels[origin].clone(),
            time,
            columns: all,
            weights,
            filled: false,
        }
    });
    let back = back.collect();
    Ok((back, names.iter().chain(&shifted.added).cloned().collect()))
}

/// The columns `want` of trajectories whose columns are called `have`; past ones that are missing are made.
pub(crate) fn select(
    trajectories: Vec<Trajectory>,
    have: &[String],
    want: &[String],
) -> Result<Vec<Trajectory>> {
    let missing: Vec<Delay> = want
        .iter()
        .filter(|name| !have.contains(name))
        .filter_map(|name| of_name(name))
        .collect();
    let (mut all, names) = match missing.is_empty() {
        true => (trajectories, have.to_vec()),
        false => add(trajectories, have, &missing)?,
    };
    for t in &mut all {
        let column = |name: &String| {
            let place = names.iter().position(|n| n == name);
            place.map(|p| t.columns[p].clone()).ok_or_else(|| {
                Error::data(
                    t.name.clone(),
                    format!("a column `{name}`"),
                    names.join(", "),
                )
            })
        };
        t.columns = want.iter().map(column).collect::<Result<_>>()?;
    }
    Ok(all)
}

/// The model that was found with past columns among its inputs, as one that runs by itself: in continuous time they
/// are what states were, in discrete time states of their own. Those that no equation uses are left out.
pub(crate) fn model(found: &Model, inputs: &[String], period: f64) -> Result<Model> {
    of(found, inputs, period).map_err(Error::refused("--past"))
}

fn of(found: &Model, inputs: &[String], period: f64) -> std::result::Result<Model, SindyError> {
    let used = |name: &&String| {
        let mut terms = found.equations().iter().flatten();
        terms.any(|t| t.expression.variables().contains(&name.as_str()))
    };
    let past: Vec<String> = found.inputs()[inputs.len()..]
        .iter()
        .filter(used)
        .cloned()
        .collect();
    let equations: Vec<Vec<Term>> = found.equations().to_vec();
    if let Time::Discrete { .. } = found.time() {
        let delays: Vec<Delay> = past.iter().filter_map(|name| of_name(name)).collect();
        let (older, shifts) = chain(&delays)?;
        let states = [found.states(), &older].concat();
        return Model::new(found.time(), &states, inputs, [equations, shifts].concat());
    }
    let all = [inputs, &past].concat();
    let model = Model::new(found.time(), found.states(), &all, equations)?;
    let mut feedback = Vec::new();
    for name in past {
        if let Some((column, rows)) = parts(&name)
            && found.states().iter().any(|s| s == column)
        {
            feedback.push(Past {
                state: column.to_owned(),
                delay: rows as f64 * period,
                input: name,
            });
        }
    }
    model.with_past(feedback)
}

/// The meaning of past states in a model's equations, a line for each.
pub(crate) fn words(model: &Model) -> String {
    let mut out = String::new();
    for p in model.past() {
        let _ = writeln!(
            out,
            "where {} is {}(t - {})",
            p.input,
            p.state,
            significant(p.delay, 6)
        );
    }
    out
}
