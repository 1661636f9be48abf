//! Measured tables, whose equations nobody knows. The score is the error of a free run (simulation from the first row) through
//! rows that no program was given.

mod hudson_bay;
mod thrust;

use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};
use sindy::identify::Settings;
use sindy::model::{Inputs, Interpolation, Limits, Model, Simulation, Term, Time};
use sindy::{Dataset, Identify, Library, SindyError};

use crate::data::write_runs;
use crate::pysindy::answers;
use crate::simulate::Rows;
use crate::{Failure, pysindy};

pub(crate) const CLASS: &str = "real tables";

/// Steps of one free run, at most: ten for each row of the longest table.
const STEPS: usize = 150_000;

/// Thresholds of PySINDy's grid, where no true coefficient tells their size.
const THRESHOLDS: [f64; 9] = [1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0];

/// A table in two parts.
pub(crate) struct Table {
    pub(crate) name: &'static str,
    states: &'static [&'static str],
    inputs: &'static [&'static str],
    /// Candidates are all monomials of states and inputs up to this degree.
    degree: u32,
    /// Rows have no times: a model gives the next row.
    discrete: bool,
    training: Rows,
    /// Its first row is where the free run starts.
    held_out: Rows,
}

/// All tables: those of `TOUCHDOWN_DATA` only where it is set.
pub(crate) fn all() -> Result<Vec<Table>, Failure> {
    let mut all = vec![hudson_bay::table()];
    match std::env::var_os("TOUCHDOWN_DATA") {
        Some(folder) => all.extend(thrust::tables(Path::new(&folder))?),
        None => {
            println!("The logs of thrust stands are skipped: TOUCHDOWN_DATA names no folder.\n");
        }
    }
    Ok(all)
}

/// A model of a table, scored.
struct Scored {
    /// Of the free run through the rows held out; infinite where there is no model, or the run ends early.
    error: f64,
    terms: usize,
    /// What chose or warned.
    remark: String,
    model: String,
}

impl Scored {
    fn new(table: &Table, model: &Model, remark: String) -> Result<Self, SindyError> {
        Ok(Self {
            error: free_run_error(model, &table.held_out)?,
            terms: model.equations().iter().map(Vec::len).sum(),
            remark,
            model: format!("{model:.4}"),
        })
    }

    fn failed(why: String) -> Self {
        Self {
            error: f64::INFINITY,
            terms: 0,
            remark: why,
            model: String::new(),
        }
    }

    fn cells(&self) -> String {
        if self.model.is_empty() {
            return format!(" - | - | {} |", self.remark);
        }
        let error = match self.error.is_finite() {
            true => format!("{:.2}", self.error),
            false => "diverges".into(),
        };
        format!(" {error} | {} | {} |", self.terms, self.remark)
    }

    fn json(&self, program: &str, table: &Table) -> Value {
        json!({
            "program": program,
            "problem": table.name,
            "error": self.error,
            "terms": self.terms,
            "remark": self.remark,
            "model": self.model,
        })
    }
}

/// The rows of the report, and a line of JSON for each model. Without an interpreter PySINDy's cells are empty.
pub(crate) fn report(
    tables: &[Table],
    python: Option<&Path>,
    mut line: impl FnMut(&Value) -> std::io::Result<()>,
) -> Result<String, Failure> {
    let mut out = String::from(
        "| table | rows | held out | ours: error | terms | warned | PySINDy's defaults: error | terms | setting | its best of \
         grid: error | terms | setting |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for table in tables {
        let own = ours(table)?;
        line(&own.json("sindy", table))?;
        let theirs = match python {
            Some(python) => {
                let [default, best] = theirs(table, python)?;
                line(&default.json("PySINDy, default", table))?;
                line(&best.json("PySINDy, best of grid", table))?;
                format!("{}{}", default.cells(), best.cells())
            }
            None => " - | - | - | - | - | - |".into(),
        };
        let (rows, held) = (table.training.time.len(), table.held_out.time.len() - 1);
        out += &format!(
            "| {} | {rows} | {held} |{}{theirs}\n",
            table.name,
            own.cells()
        );
    }
    Ok(out)
}

fn library(table: &Table) -> Result<Library, SindyError> {
    let names = [table.states, table.inputs].concat();
    Library::polynomial(&names, table.degree)
}

fn ours(table: &Table) -> Result<Scored, SindyError> {
    let mut data = Dataset::new(table.states, table.inputs)?;
    let rows = &table.training;
    let columns = [rows.states.clone(), rows.inputs.clone()].concat();
    data.push("training", rows.time.clone(), columns, None)?;
    let settings = Settings {
        discrete: table.discrete,
        ..Settings::default()
    };
    let found = Identify::new(library(table)?)
        .settings(settings)?
        .run(&data, &mut |_| ());
    match found {
        Ok(found) => {
            let warned = match crate::score::is_doubted(&found) {
                true => "yes",
                false => "no",
            };
            Scored::new(table, &found.model, warned.into())
        }
        Err(error) => Ok(Scored::failed(error.to_string())),
    }
}

/// PySINDy's default, and of its grid and the default the model with the least error of a free run through the training rows.
fn theirs(table: &Table, python: &Path) -> Result<[Scored; 2], Failure> {
    let about = json!({
        "name": table.name,
        "states": table.states,
        "measured": table.states,
        "inputs": table.inputs,
        "degree": table.degree,
        "library": library(table)?.names(),
        "truth": [],
        "thresholds": THRESHOLDS,
        "rates": false,
        "discrete": table.discrete,
    });
    let folder = tempfile::tempdir()?;
    let names = [&["t"], table.states, table.inputs].concat();
    write_runs(&folder.path().join("0"), &names, &[&table.training], &about)?;
    let mut models = Vec::new();
    for answer in answers(python, folder.path(), table.name)? {
        let equations = answer
            .equations
            .as_deref()
            .map(pysindy::equations)
            .transpose()?;
        models.push((answer.setting, equations, answer.error.unwrap_or_default()));
    }
    let scores = models
        .par_iter()
        .map(|(_, equations, _)| match equations {
            Some(equations) => free_run_error(&model(table, equations.clone())?, &table.training),
            None => Ok(f64::INFINITY),
        })
        .collect::<Result<Vec<f64>, SindyError>>()?;
    let scored = |k: usize| match &models[k] {
        (setting, Some(equations), _) => {
            Scored::new(table, &model(table, equations.clone())?, setting.clone())
        }
        (_, None, why) => Ok(Scored::failed(why.clone())),
    };
    let best = (0..models.len()).min_by(|a, b| scores[*a].total_cmp(&scores[*b]));
    let best = best.ok_or("PySINDy printed no fit")?;
    Ok([scored(0)?, scored(best)?])
}

fn model(table: &Table, equations: Vec<Vec<Term>>) -> Result<Model, SindyError> {
    let time = match table.discrete {
        true => Time::Discrete { period: 1.0 },
        false => Time::Continuous,
    };
    Model::new(time, table.states, table.inputs, equations)
}

/// The root mean square of the free run's error over all rows after the first, each state in units of its standard deviation in
/// these rows. Infinite where the run ends before the rows do.
fn free_run_error(model: &Model, rows: &Rows) -> Result<f64, SindyError> {
    let start: Vec<f64> = rows.states.iter().map(|c| c[0]).collect();
    let columns: Vec<&[f64]> = rows.inputs.iter().map(Vec::as_slice).collect();
    let n = rows.time.len();
    let run = match model.time() {
        Time::Discrete { .. } => model.iterate(&start, n - 1, &columns, &Limits::default())?,
        Time::Continuous => {
            // Commands of a test stand keep their value until the next.
            let inputs = match columns.is_empty() {
                true => Inputs::none(),
                false => Inputs::sampled(&rows.time, &columns, Interpolation::ZeroOrderHold)?,
            };
            let how = Simulation::adaptive().step_limit(STEPS);
            model.simulate(&start, &rows.time, &inputs, &how)?
        }
    };
    if run.time.len() < n {
        return Ok(f64::INFINITY);
    }
    let error = |(of_model, measured): (&Vec<f64>, &Vec<f64>)| {
        let mean = measured.iter().sum::<f64>() / n as f64;
        let variance = measured.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n as f64;
        let squares = of_model.iter().zip(measured).skip(1);
        squares.map(|(m, v)| (m - v).powi(2)).sum::<f64>() / (n - 1) as f64 / variance
    };
    let sum: f64 = run.states.iter().zip(&rows.states).map(error).sum();
    Ok((sum / rows.states.len() as f64).sqrt())
}
