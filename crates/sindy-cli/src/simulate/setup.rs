//! What to run: from arguments or from measured trajectories.

use sindy::Model;
use sindy::data::gaps::{GapSettings, segments};
use sindy::model::{Inputs, Interpolation, Time};

use super::args::{Between, SimulateArgs};
use crate::error::{Error, Result};
use crate::trajectories::{self, Trajectory, WantedColumns, past, rates};

/// Rows that a result may have.
const MOST_ROWS: f64 = 1e8;

/// One run.
pub(crate) struct RunTask {
    pub(crate) name: String,
    pub(crate) start: Vec<f64>,
    /// At least two times, increasing.
    pub(crate) time: Vec<f64>,
    pub(crate) inputs: Inputs,
    /// The states before, where the model asks for them and they are known.
    pub(crate) before: Option<Before>,
    /// The measured states at the times, where there are any.
    pub(crate) measured: Option<Vec<Vec<f64>>>,
}

/// The states up to the start of a run.
pub(crate) struct Before {
    pub(crate) time: Vec<f64>,
    pub(crate) states: Vec<Vec<f64>>,
}

/// All runs, and what was found on the way.
pub(crate) struct Setup {
    pub(crate) tasks: Vec<RunTask>,
    pub(crate) warnings: Vec<String>,
    /// Whether input was lost.
    pub(crate) lossy: bool,
}

pub(crate) fn of(model: &Model, args: &SimulateArgs) -> Result<Setup> {
    match &args.data {
        Some(path) => {
            let wanted = WantedColumns {
                columns: model
                    .states()
                    .iter()
                    .map(|n| (n.as_str(), "a state of the model"))
                    .chain(inputs_wanted(model))
                    .collect(),
                weights: None,
                table: &args.table,
            };
            let (mut trajectories, report) = trajectories::read(path, &wanted)?;
            let mut warnings = report.warnings;
            if model.time() == Time::Continuous && model.past().is_empty() {
                let names = [model.states(), model.inputs()].concat();
                let states = model.states().len();
                trajectories = rates::filled(trajectories, states, &names, &mut warnings)?;
            }
            let mut tasks = Vec::new();
            for trajectory in &trajectories {
                for part in stretches(model, trajectory, &mut warnings)? {
                    tasks.push(part.task(model, &between(model, args))?);
                }
            }
            let lossy = report.lossy;
            Ok(Setup {
                tasks,
                warnings,
                lossy,
            })
        }
        None => own(model, args),
    }
}

fn inputs_wanted(model: &Model) -> impl Iterator<Item = (&str, &'static str)> {
    let inputs = model.inputs().iter();
    inputs.map(|n| (n.as_str(), "an input of the model"))
}

/// A part of a trajectory without gaps.
pub(crate) struct Stretch<'t> {
    pub(crate) name: String,
    pub(crate) time: &'t [f64],
    /// States, then inputs.
    pub(crate) columns: Vec<&'t [f64]>,
    /// As in [`Trajectory`].
    pub(crate) filled: bool,
}

/// The parts of a trajectory between its gaps.
pub(crate) fn stretches<'t>(
    model: &Model,
    trajectory: &'t Trajectory,
    warnings: &mut Vec<String>,
) -> Result<Vec<Stretch<'t>>> {
    let name = &trajectory.name;
    let refused = || Error::refused(name.clone());
    let columns: Vec<&[f64]> = trajectory.columns.iter().map(Vec::as_slice).collect();
    let gaps = GapSettings::usual(&trajectory.time, 2).map_err(refused())?;
    let ranges = segments(&trajectory.time, &columns, gaps)
        .map_err(refused())?
        .ranges;
    if ranges.is_empty() {
        return Err(Error::NoRows {
            at: name.clone(),
            reason: "no two rows after each other have all values".to_owned(),
        });
    }
    let several = ranges.len() > 1;
    if several {
        let count = ranges.len();
        warnings.push(format!(
            "{name}: gaps split the trajectory; each of its {count} stretches is run from its own start"
        ));
    }
    let mut parts = Vec::with_capacity(ranges.len());
    for (i, range) in ranges.into_iter().enumerate() {
        let part = Stretch {
            name: match several {
                true => format!("{name}, stretch {}", i + 1),
                false => name.clone(),
            },
            time: &trajectory.time[range.clone()],
            columns: columns.iter().map(|c| &c[range.clone()]).collect(),
            filled: trajectory.filled,
        };
        check_period(model, &part.name, part.time)?;
        parts.push(part);
    }
    Ok(parts)
}

impl Stretch<'_> {
    /// A run beside the stretch, from its first row.
    pub(crate) fn task(&self, model: &Model, between: &[Interpolation]) -> Result<RunTask> {
        let (states, inputs) = self.columns.split_at(model.states().len());
        let given = model.inputs().iter().zip(inputs).zip(between);
        let outside =
            given.filter(|((name, _), _)| !model.past().iter().any(|p| p.input == **name));
        let (outside, between): (Vec<&[f64]>, Vec<Interpolation>) =
            outside.map(|((_, column), how)| (*column, *how)).unzip();
        let inputs = sampled(model, &self.name, self.time, &outside, &between)?;
        Ok(RunTask {
            name: self.name.clone(),
            before: self.before(model)?,
            start: states.iter().map(|c| c[0]).collect(),
            time: self.time.to_vec(),
            inputs,
            measured: Some(states.iter().map(|c| c.to_vec()).collect()),
        })
    }
}

impl Stretch<'_> {
    /// The past states of the first rows are the states before the stretch.
    fn before(&self, model: &Model) -> Result<Option<Before>> {
        let most = model.past().iter().map(|p| p.delay).fold(0.0, f64::max);
        if most == 0.0 {
            return Ok(None);
        }
        let (start, slack) = (self.time[0], 1e-3 * most);
        for p in model.past() {
            let period = past::rows_of(&p.input).map_or(0.0, |rows| p.delay / rows as f64);
            let found = self.time[1] - start;
            if period > 0.0 && (found / period - 1.0).abs() > 1e-2 {
                return Err(Error::data(
                    self.name.clone(),
                    format!(
                        "rows {period} apart, so that `{}` is {} ago",
                        p.input, p.delay
                    ),
                    format!("rows {found} apart"),
                ));
            }
        }
        let rows = self.time.iter().take_while(|t| **t <= start + most + slack);
        let rows = rows.count();
        if self.time[rows - 1] < start + most - slack {
            return Err(Error::data(
                self.name.clone(),
                format!(
                    "a stretch longer than the delay of {most}, after the first row that has a past"
                ),
                format!("one of length {}", self.time[rows - 1] - start),
            ));
        }
        let column = |(i, state): (usize, &String)| {
            let own = model.past().iter().filter(|p| p.state == *state);
            let Some(own) = own.max_by(|a, b| a.delay.total_cmp(&b.delay)) else {
                return vec![self.columns[i][0]; rows];
            };
            let input = model.inputs().iter().position(|n| *n == own.input);
            let was = self.columns[model.states().len() + input.unwrap_or_default()];
            // A shorter delay knows the later part.
            let later = start + most - own.delay - slack;
            let shift = self.time.iter().take_while(|t| **t < later).count();
            (0..rows).map(|k| was[k.saturating_sub(shift)]).collect()
        };
        let mut time: Vec<f64> = self.time[..rows].iter().map(|t| t - most).collect();
        // Rounding aside, the history ends where the run starts.
        time[rows - 1] = start;
        Ok(Some(Before {
            time,
            states: model.states().iter().enumerate().map(column).collect(),
        }))
    }
}

fn sampled(
    model: &Model,
    name: &str,
    time: &[f64],
    columns: &[&[f64]],
    between: &[Interpolation],
) -> Result<Inputs> {
    if columns.is_empty() {
        return Ok(Inputs::none());
    }
    let between = match model.time() {
        // In discrete time an input holds for a period.
        Time::Discrete { .. } => &vec![Interpolation::ZeroOrderHold; columns.len()],
        Time::Continuous => between,
    };
    Inputs::sampled_each(time, columns, between).map_err(Error::refused(name))
}

/// What every input of the model is between samples, by the arguments.
fn between(model: &Model, args: &SimulateArgs) -> Vec<Interpolation> {
    let how = match args.between {
        Between::Hold => Interpolation::ZeroOrderHold,
        Between::Linear => Interpolation::Linear,
        Between::Cubic => Interpolation::Cubic,
    };
    vec![how; model.inputs().len()]
}

/// In discrete time, rows are one period apart.
fn check_period(model: &Model, name: &str, time: &[f64]) -> Result<()> {
    let Time::Discrete { period } = model.time() else {
        return Ok(());
    };
    let step = time.windows(2).map(|w| w[1] - w[0]);
    match step.into_iter().find(|dt| (dt / period - 1.0).abs() > 1e-3) {
        None => Ok(()),
        Some(dt) => Err(Error::data(
            name,
            format!("rows {period} apart, the period of the discrete model"),
            format!("rows {dt} apart"),
        )),
    }
}

/// One run from a start that was given.
fn own(model: &Model, args: &SimulateArgs) -> Result<Setup> {
    let start = start(model, &args.start)?;
    let outside = model.outside();
    let mut setup = Setup {
        tasks: Vec::new(),
        warnings: Vec::new(),
        lossy: false,
    };
    let table = match &args.inputs_from {
        None => None,
        Some(path) => {
            let wanted = WantedColumns {
                columns: outside
                    .iter()
                    .map(|n| (n.as_str(), "an input of the model"))
                    .collect(),
                weights: None,
                table: &args.table,
            };
            let (mut trajectories, report) = trajectories::read(path, &wanted)?;
            setup.warnings = report.warnings;
            setup.lossy = report.lossy;
            match (trajectories.pop(), trajectories.is_empty()) {
                (Some(one), true) => Some(one),
                _ => {
                    let at = path.display().to_string();
                    return Err(Error::data(at, "one trajectory of inputs", "several"));
                }
            }
        }
    };
    let from = table.as_ref().map_or(0.0, |t| t.time[0]);
    let until = match (args.until, &table) {
        (Some(until), _) => until,
        (None, Some(table)) => table.time[table.time.len() - 1],
        (None, None) => {
            let needed = "--start needs the end of the run too: --until TIME";
            return Err(Error::Arguments(needed.to_owned()));
        }
    };
    let time = grid(model, from, until, args.step)?;
    let inputs = match &table {
        Some(table) => {
            let columns: Vec<&[f64]> = table.columns.iter().map(Vec::as_slice).collect();
            sampled(
                model,
                &table.name,
                &table.time,
                &columns,
                &between(model, args)[..columns.len()],
            )?
        }
        None => formulas(&outside, &args.inputs)?,
    };
    setup.tasks.push(RunTask {
        name: "run".to_owned(),
        start,
        time,
        inputs,
        before: None,
        measured: None,
    });
    Ok(setup)
}

/// The times of the result.
fn grid(model: &Model, from: f64, until: f64, step: Option<f64>) -> Result<Vec<f64>> {
    let length = until - from;
    if !(length > 0.0) {
        return Err(Error::Arguments(format!(
            "--until: expected a time after the start at {from}, found {until}"
        )));
    }
    let step = match (model.time(), step) {
        (Time::Discrete { period }, None) => period,
        (Time::Discrete { period }, Some(step)) if (step / period - 1.0).abs() > 1e-9 => {
            return Err(Error::Arguments(format!(
                "--step: expected the period {period} of the discrete model, found {step}"
            )));
        }
        (_, Some(step)) => step,
        (Time::Continuous, None) => length / 1000.0,
    };
    // A hair less than a whole number of steps is rounding.
    let count = (length / step + 1e-9).floor();
    if !(1.0..=MOST_ROWS).contains(&count) {
        return Err(Error::Arguments(format!(
            "--step: expected 1 to {MOST_ROWS:e} steps from {from} to {until}, found {count:e} of {step}"
        )));
    }
    Ok((0..=count as usize)
        .map(|i| from + i as f64 * step)
        .collect())
}

fn start(model: &Model, given: &[String]) -> Result<Vec<f64>> {
    let values = assignments("--start", given, model.states())?;
    let number = |(name, text): (&String, String)| {
        text.parse::<f64>()
            .ok()
            .filter(|v| v.is_finite())
            .ok_or_else(|| {
                let expected = "expected a finite number";
                Error::Arguments(format!("--start: {name}: {expected}, found {text:?}"))
            })
    };
    model.states().iter().zip(values).map(number).collect()
}

fn formulas(names: &[String], given: &[String]) -> Result<Inputs> {
    let texts = assignments("--input", given, names)?;
    Inputs::formulas(&texts).map_err(Error::refused("--input"))
}

/// The text of each name in `name=text`.
fn assignments(argument: &str, given: &[String], names: &[String]) -> Result<Vec<String>> {
    let mut values: Vec<Option<String>> = vec![None; names.len()];
    for text in given {
        let (name, value) = text.split_once('=').ok_or_else(|| {
            Error::Arguments(format!("{argument}: expected NAME=VALUE, found {text:?}"))
        })?;
        let name = name.trim();
        let place = names.iter().position(|n| n == name).ok_or_else(|| {
            let known = match names {
                [] => "none".to_owned(),
                _ => names.join(", "),
            };
            Error::Arguments(format!(
                "{argument}: no `{name}` in the model; it has {known}"
            ))
        })?;
        if values[place].replace(value.trim().to_owned()).is_some() {
            return Err(Error::Arguments(format!(
                "{argument}: `{name}` stands twice"
            )));
        }
    }
    let missing = names.iter().zip(&values).find(|(_, v)| v.is_none());
    match missing {
        Some((name, _)) => Err(Error::Arguments(format!(
            "{argument}: expected a value for each of {}, found none for `{name}`",
            names.join(", ")
        ))),
        None => Ok(values.into_iter().flatten().collect()),
    }
}
