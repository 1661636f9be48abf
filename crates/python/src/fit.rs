//! The automatic call, and fits by a given solver.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use serde::Serialize;
use sindy::identify::{Candidate, Choice, Equation, Settings};
use sindy::model::{Interpolation, Term, Time};
use sindy::statistics::gram::Accumulate;
use sindy::{
    BlockSource, Fit, Gram, Identification, Identify, Outcome, Samples, SindyError, Solver,
};

use crate::arrays::{Columns, columns, views};
use crate::error;
use crate::library::Library;
use crate::model::Model;
use crate::run;
use crate::slopes::{Given, WEIGHT, dataset, method, samples, slope};
use crate::solver::Description;

/// What an identification says beside its model.
#[derive(Serialize)]
struct Said<'a> {
    equations: &'a [Equation],
    choice: &'a Choice,
    candidates: &'a [Candidate],
    outcome: Outcome,
    inputs_between: &'a [Interpolation],
    warnings: &'a [String],
    data: sindy::data::dataset::DataReport,
}

/// What a solver says of one equation.
#[derive(Serialize)]
struct Solved {
    coefficients: Vec<f64>,
    residual_sum: f64,
    outcome: Outcome,
    iterations: usize,
    rows: usize,
    skipped: usize,
}

/// The task of a fit by a given solver.
pub(crate) struct Task {
    pub(crate) states: Vec<String>,
    pub(crate) inputs: Vec<String>,
    pub(crate) libraries: Vec<sindy::Library>,
    pub(crate) solver: Description,
    pub(crate) time: Time,
}

impl Task {
    pub(crate) fn new(
        states: Vec<String>,
        inputs: Vec<String>,
        libraries: &[PyRef<'_, Library>],
        solver_json: &str,
        period: Option<f64>,
    ) -> PyResult<Self> {
        let solver = error::read("solver", solver_json)?;
        Ok(Self {
            libraries: per_state(libraries, states.len())?,
            states,
            inputs,
            solver,
            time: period.map_or(Time::Continuous, |period| Time::Discrete { period }),
        })
    }

    /// Solves every equation, given its statistics.
    pub(crate) fn solve(&self, grams: &[Gram]) -> Result<(sindy::Model, String), SindyError> {
        let solver: Box<dyn Solver> = self.solver.build()?;
        let mut equations = Vec::new();
        let mut solved = Vec::new();
        for (gram, library) in grams.iter().zip(&self.libraries) {
            let fit: Fit = solver.fit(gram)?;
            let coefficients = fit.coefficients.as_slice().to_vec();
            equations.push(Term::of_library(library, &coefficients)?);
            solved.push(Solved {
                coefficients,
                residual_sum: fit.residual_sum,
                outcome: fit.outcome,
                iterations: fit.iterations,
                rows: gram.rows,
                skipped: gram.skipped,
            });
        }
        let model = sindy::Model::new(self.time, &self.states, &self.inputs, equations)?;
        Ok((model, json(&solved)?))
    }
}

/// The statistics of every equation, in one pass where they share a library.
fn statistics(
    libraries: &[sindy::Library],
    targets: &[String],
    weights: Option<&str>,
    source: &dyn BlockSource,
) -> Result<Vec<Gram>, SindyError> {
    let targets: Vec<&str> = targets.iter().map(String::as_str).collect();
    let of = |library: &sindy::Library, targets: &[&str]| {
        let mut how = Accumulate::new(library, targets[0]);
        if let Some(column) = weights {
            how = how.weights(column);
        }
        let all = how.targets(targets, source)?;
        Ok(all
            .iter()
            .map(|groups| Gram::total(groups))
            .collect::<Vec<_>>())
    };
    let first = &libraries[0];
    if libraries.iter().all(|l| l.names() == first.names()) {
        return of(first, &targets);
    }
    let each = libraries.iter().zip(&targets);
    let grams: Result<Vec<_>, SindyError> = each.map(|(l, t)| of(l, &[*t])).collect();
    Ok(grams?.concat())
}

/// The same of the caller's arrays, read where they are. Each group holds arrays with as many rows; their columns stand
/// for the states, the inputs, the targets (one for each state), and the weights if there are any.
pub(crate) fn of_arrays(
    py: Python<'_>,
    (states, inputs): (&[String], &[String]),
    libraries: &[sindy::Library],
    groups: &[Vec<PyReadonlyArray2<'_, f64>>],
    weighted: bool,
    jobs: Option<usize>,
) -> PyResult<Vec<Gram>> {
    let (names, targets) = columns_of(states, inputs, weighted);
    let seen = views(groups);
    run::borrowed(py, jobs, |cancel| {
        let source = Columns::new(names, seen, cancel)?;
        statistics(libraries, &targets, weighted.then_some(WEIGHT), &source)
    })
}

/// The names of the caller's columns, and of the targets among them.
fn columns_of(states: &[String], inputs: &[String], weighted: bool) -> (Vec<String>, Vec<String>) {
    let targets: Vec<String> = states.iter().map(|s| slope(s)).collect();
    let mut names = [states, inputs, &targets].concat();
    if weighted {
        names.push(WEIGHT.to_owned());
    }
    (names, targets)
}

/// A copy of the caller's arrays, grouped as [`of_arrays`] takes them, for work that passes over them many times.
///
/// # Errors
/// Not one column for each name, or columns of different lengths.
pub(crate) fn given_samples(
    task: &Task,
    groups: &[Vec<PyReadonlyArray2<'_, f64>>],
    weighted: bool,
) -> Result<Samples, SindyError> {
    let (names, _) = columns_of(&task.states, &task.inputs, weighted);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut samples = Samples::new(&names);
    for group in groups {
        let arrays = group.iter();
        samples.push_group(arrays.flat_map(|a| columns(&a.as_array())).collect())?;
    }
    Ok(samples)
}

/// A library for each state.
pub(crate) fn per_state(
    libraries: &[PyRef<'_, Library>],
    states: usize,
) -> PyResult<Vec<sindy::Library>> {
    let all: Vec<_> = libraries.iter().map(|l| l.terms.clone()).collect();
    match all.len() {
        1 => Ok(vec![all[0].clone(); states]),
        n if n == states && n > 0 => Ok(all),
        n => {
            let expected = format!("one, or one for each of {states} states");
            let message = format!("libraries: expected {expected}, found {n}");
            Err(error::fault(message, "library", &expected, &n.to_string()))
        }
    }
}

fn json(value: &impl Serialize) -> Result<String, SindyError> {
    serde_json::to_string(value).map_err(|e| SindyError::Json {
        reason: e.to_string(),
    })
}

/// The model of an identification and, in JSON, all that is said of it.
pub(crate) fn said(found: Identification) -> Result<(sindy::Model, String), SindyError> {
    let said = json(&Said {
        equations: &found.equations,
        choice: &found.choice,
        candidates: &found.candidates,
        outcome: found.outcome,
        inputs_between: &found.inputs_between,
        warnings: &found.warnings,
        data: found.data,
    })?;
    Ok((found.model, said))
}

/// The automatic call: a model and, in JSON, all that the identification says of it.
#[pyfunction]
#[pyo3(signature = (states, inputs, trajectories, libraries, settings_json, jobs=None))]
pub(crate) fn identify(
    py: Python<'_>,
    states: Vec<String>,
    inputs: Vec<String>,
    trajectories: Vec<Given<'_>>,
    libraries: Vec<PyRef<'_, Library>>,
    settings_json: &str,
    jobs: Option<usize>,
) -> PyResult<(Model, String)> {
    let settings: Settings = error::read("settings", settings_json)?;
    let data = dataset(&states, &inputs, &trajectories).map_err(|e| error::of(&e))?;
    let call = Identify::per_equation(per_state(&libraries, states.len())?)
        .settings(settings)
        .map_err(|e| error::of(&e))?;
    let (model, said) = run::owned(py, jobs, move |cancel| {
        said(call.run(&data, &mut |_| cancel.heed())?)
    })?;
    Ok((Model { model }, said))
}

/// A fit by a solver of given targets, of arrays as [`of_arrays`] takes them.
#[pyfunction]
#[pyo3(signature = (states, inputs, groups, weighted, libraries, solver_json, period=None, jobs=None))]
#[expect(clippy::too_many_arguments, reason = "keywords of one Python function")]
pub(crate) fn fit_columns(
    py: Python<'_>,
    states: Vec<String>,
    inputs: Vec<String>,
    groups: Vec<Vec<PyReadonlyArray2<'_, f64>>>,
    weighted: bool,
    libraries: Vec<PyRef<'_, Library>>,
    solver_json: &str,
    period: Option<f64>,
    jobs: Option<usize>,
) -> PyResult<(Model, String)> {
    let task = Task::new(states, inputs, &libraries, solver_json, period)?;
    let variables = (&task.states[..], &task.inputs[..]);
    let grams = of_arrays(py, variables, &task.libraries, &groups, weighted, jobs)?;
    // The solver borrows nothing of the caller's, so a Ctrl-C need not wait for it.
    let (model, said) = run::owned(py, jobs, move |_| task.solve(&grams))?;
    Ok((Model { model }, said))
}

/// A fit by a solver of slopes that are made from the states.
#[pyfunction]
#[pyo3(signature = (states, inputs, trajectories, libraries, method_json, solver_json, jobs=None))]
#[expect(clippy::too_many_arguments, reason = "keywords of one Python function")]
pub(crate) fn fit_slopes(
    py: Python<'_>,
    states: Vec<String>,
    inputs: Vec<String>,
    trajectories: Vec<Given<'_>>,
    libraries: Vec<PyRef<'_, Library>>,
    method_json: &str,
    solver_json: &str,
    jobs: Option<usize>,
) -> PyResult<(Model, String)> {
    let how = method(method_json)?;
    let data = dataset(&states, &inputs, &trajectories).map_err(|e| error::of(&e))?;
    let task = Task::new(states, inputs, &libraries, solver_json, None)?;
    let targets: Vec<String> = task.states.iter().map(|s| slope(s)).collect();
    let (model, said) = run::owned(py, jobs, move |cancel| {
        let samples: Samples = samples(how, &data, &|| cancel.heed())?;
        cancel.heed();
        let grams = statistics(&task.libraries, &targets, Some(WEIGHT), &samples)?;
        task.solve(&grams)
    })?;
    Ok((Model { model }, said))
}
