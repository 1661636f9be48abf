//! Intervals of coefficients and bands of predictions by a bootstrap over blocks of rows.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use sindy::statistics::gram::Accumulate;
use sindy::uncertainty::{Band, Bootstrap, Intervals, Resampling, models, on_support};
use sindy::{BlockSource, Gram, SindyError, Solver};

use crate::arrays::columns;
use crate::error;
use crate::fit::{Task, given_samples};
use crate::library::Library;
use crate::model::{Matrix, Model, early, inputs_of, limits_of, matrix, simulation};
use crate::run::{self, Cancel};
use crate::slopes::{Given, WEIGHT, dataset, method, samples, slope};

/// Settings as the Python side has them.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    replicates: usize,
    seed: u64,
    level: f64,
    omit: usize,
    resampling: Unit,
    keep_terms: bool,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Unit {
    Automatic,
    Groups,
    Rows(usize),
}

/// What the replicates of one equation agree on: a number for each of its terms.
#[derive(Serialize)]
struct Equation {
    terms: Vec<String>,
    coefficients: Vec<f64>,
    offered: Vec<usize>,
    inclusion: Vec<f64>,
    mean: Vec<f64>,
    median: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    std_error: Vec<f64>,
    block_rows: usize,
    blocks: usize,
    correlation_rows: Option<f64>,
}

/// The fit to all data and what the solver says of it, a model for each replicate, in JSON what the replicates agree on, and
/// the covariance of each equation's coefficients.
type Bootstrapped<'py> = (Model, String, Vec<Model>, String, Vec<Matrix<'py>>);

impl Settings {
    fn read(text: &str) -> PyResult<Self> {
        error::read("bootstrap", text)
    }

    fn build(self) -> Result<Bootstrap, SindyError> {
        let resampling = match self.resampling {
            Unit::Automatic => Resampling::Automatic,
            Unit::Groups => Resampling::Groups,
            Unit::Rows(rows) => Resampling::Rows(rows),
        };
        Ok(Bootstrap::new(self.replicates, self.seed)?
            .level(self.level)?
            .omit(self.omit)
            .resampling(resampling))
    }
}

/// All replicates of a task over rows with slopes.
struct Found {
    said: (sindy::Model, String),
    models: Vec<sindy::Model>,
    equations: Vec<Equation>,
    intervals: Vec<Intervals>,
}

fn resample(
    task: &Task,
    settings: Settings,
    source: &dyn BlockSource,
    weights: Option<&str>,
    cancel: &Cancel,
) -> Result<Found, SindyError> {
    let targets: Vec<String> = task.states.iter().map(|s| slope(s)).collect();
    let solver = task.solver.build()?;
    let heeding = |gram: &Gram| {
        cancel.heed();
        solver.fit(gram)
    };
    let of = |library, target| {
        let how = Accumulate::new(library, target);
        match weights {
            Some(column) => how.weights(column),
            None => how,
        }
    };
    let mut totals = Vec::new();
    let mut solvers: Vec<Box<dyn Solver + '_>> = Vec::new();
    for (library, target) in task.libraries.iter().zip(&targets) {
        cancel.heed();
        let total = Gram::total(&of(library, target).over(source)?);
        solvers.push(match settings.keep_terms {
            true => Box::new(on_support(heeding(&total)?.support)),
            false => Box::new(heeding),
        });
        totals.push(total);
    }
    let each = task.libraries.iter().zip(&targets).zip(&solvers);
    let equations: Vec<_> = each
        .map(|((library, target), solver)| (of(library, target), &**solver))
        .collect();
    let intervals = settings.build()?.run(&equations, source)?;
    let of_libraries: Vec<_> = task.libraries.iter().zip(&intervals).collect();
    let models = models(task.time, &task.states, &task.inputs, &of_libraries)?;
    let equations = of_libraries.iter().map(|(l, i)| equation(l, i)).collect();
    Ok(Found {
        said: task.solve(&totals)?,
        models,
        equations,
        intervals,
    })
}

fn equation(library: &sindy::Library, intervals: &Intervals) -> Equation {
    let ensemble = &intervals.ensemble;
    Equation {
        terms: library.names().to_vec(),
        coefficients: intervals.fit.coefficients.as_slice().to_vec(),
        offered: ensemble.offered.clone(),
        inclusion: ensemble.inclusion.as_slice().to_vec(),
        mean: ensemble.mean.as_slice().to_vec(),
        median: ensemble.median.as_slice().to_vec(),
        lower: ensemble.lower.as_slice().to_vec(),
        upper: ensemble.upper.as_slice().to_vec(),
        std_error: intervals.std_error.as_slice().to_vec(),
        block_rows: intervals.block_rows,
        blocks: intervals.blocks,
        correlation_rows: intervals.correlation_rows,
    }
}

fn converted(py: Python<'_>, found: Found) -> PyResult<Bootstrapped<'_>> {
    let (model, said) = found.said;
    let covariance = |i: &Intervals| {
        let p = i.covariance.nrows();
        matrix(py, p, p, i.covariance.as_slice().to_vec())
    };
    Ok((
        Model { model },
        said,
        found
            .models
            .into_iter()
            .map(|model| Model { model })
            .collect(),
        serde_json::to_string(&found.equations).map_err(|e| error::settings("bootstrap", &e))?,
        found
            .intervals
            .iter()
            .map(covariance)
            .collect::<PyResult<_>>()?,
    ))
}

/// A bootstrap of a solver over slopes that are made from the states.
#[pyfunction]
#[pyo3(signature = (states, inputs, trajectories, libraries, method_json, solver_json, settings_json, jobs=None))]
#[expect(clippy::too_many_arguments, reason = "keywords of one Python function")]
pub(crate) fn bootstrap_slopes<'py>(
    py: Python<'py>,
    states: Vec<String>,
    inputs: Vec<String>,
    trajectories: Vec<Given<'py>>,
    libraries: Vec<PyRef<'py, Library>>,
    method_json: &str,
    solver_json: &str,
    settings_json: &str,
    jobs: Option<usize>,
) -> PyResult<Bootstrapped<'py>> {
    let (how, settings) = (method(method_json)?, Settings::read(settings_json)?);
    let data = dataset(&states, &inputs, &trajectories).map_err(|e| error::of(&e))?;
    let task = Task::new(states, inputs, &libraries, solver_json, None)?;
    let found = run::owned(py, jobs, move |cancel| {
        let samples = samples(how, &data, &|| cancel.heed())?;
        resample(&task, settings, &samples, Some(WEIGHT), cancel)
    })?;
    converted(py, found)
}

/// A bootstrap of a solver over given targets, of arrays as those of `fit_columns`; they are copied.
#[pyfunction]
#[pyo3(signature = (states, inputs, groups, weighted, libraries, solver_json, settings_json, period=None, jobs=None))]
#[expect(clippy::too_many_arguments, reason = "keywords of one Python function")]
pub(crate) fn bootstrap_columns<'py>(
    py: Python<'py>,
    states: Vec<String>,
    inputs: Vec<String>,
    groups: Vec<Vec<PyReadonlyArray2<'py, f64>>>,
    weighted: bool,
    libraries: Vec<PyRef<'py, Library>>,
    solver_json: &str,
    settings_json: &str,
    period: Option<f64>,
    jobs: Option<usize>,
) -> PyResult<Bootstrapped<'py>> {
    let settings = Settings::read(settings_json)?;
    let task = Task::new(states, inputs, &libraries, solver_json, period)?;
    let samples = given_samples(&task, &groups, weighted).map_err(|e| error::of(&e))?;
    let found = run::owned(py, jobs, move |cancel| {
        resample(
            &task,
            settings,
            &samples,
            weighted.then_some(WEIGHT),
            cancel,
        )
    })?;
    converted(py, found)
}

/// Lower ends, medians, upper ends; members of each row; how members ended that ended early.
type BandRow<'py> = (
    Matrix<'py>,
    Matrix<'py>,
    Matrix<'py>,
    Vec<usize>,
    Vec<String>,
);

fn band_row(py: Python<'_>, band: Band) -> PyResult<BandRow<'_>> {
    let (rows, n) = (band.members.len(), band.middle.len());
    let ended = band.outcomes.iter().filter_map(early).collect();
    let of = |columns: &[Vec<f64>]| matrix(py, rows, n, columns.concat());
    Ok((
        of(&band.lower)?,
        of(&band.middle)?,
        of(&band.upper)?,
        band.members,
        ended,
    ))
}

fn own(members: &[PyRef<'_, Model>]) -> Vec<sindy::Model> {
    members.iter().map(|m| m.model.clone()).collect()
}

/// The band of the right-hand sides that models give over rows of states and inputs.
#[pyfunction]
#[pyo3(signature = (members, x, u, level, jobs=None))]
pub(crate) fn band_of_predictions<'py>(
    py: Python<'py>,
    members: Vec<PyRef<'py, Model>>,
    x: PyReadonlyArray2<'py, f64>,
    u: Option<PyReadonlyArray2<'py, f64>>,
    level: f64,
    jobs: Option<usize>,
) -> PyResult<BandRow<'py>> {
    let models = own(&members);
    let mut all = columns(&x.as_array());
    all.extend(u.iter().flat_map(|u| columns(&u.as_array())));
    let band = run::owned(py, jobs, move |_| {
        let seen: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
        Band::of_predictions(&models, &seen, level)
    })?;
    band_row(py, band)
}

/// The band of runs in continuous time, each as `Model.simulate` makes it.
#[pyfunction]
#[pyo3(signature = (members, start, time, inputs, between_inputs, tolerances, step, blow_up, level, jobs=None))]
#[expect(clippy::too_many_arguments, reason = "keywords of one Python function")]
pub(crate) fn band_of_runs<'py>(
    py: Python<'py>,
    members: Vec<PyRef<'py, Model>>,
    start: Vec<f64>,
    time: PyReadonlyArray1<'py, f64>,
    inputs: Option<PyReadonlyArray2<'py, f64>>,
    between_inputs: Vec<String>,
    tolerances: (f64, f64),
    step: Option<f64>,
    blow_up: f64,
    level: f64,
    jobs: Option<usize>,
) -> PyResult<BandRow<'py>> {
    let models = own(&members);
    let how = simulation(tolerances, step, blow_up);
    let inputs = inputs_of(&time, inputs, &between_inputs)?;
    let time = time.as_array().to_vec();
    let band = run::owned(py, jobs, move |cancel| {
        Band::of_runs(&models, level, |model| {
            cancel.heed();
            model.simulate(&start, &time, &inputs, &how)
        })
    })?;
    band_row(py, band)
}

/// The band of runs in discrete time, each as `Model.iterate` makes it.
#[pyfunction]
#[pyo3(signature = (members, start, steps, inputs, blow_up, level, jobs=None))]
#[expect(clippy::too_many_arguments, reason = "keywords of one Python function")]
pub(crate) fn band_of_iterations<'py>(
    py: Python<'py>,
    members: Vec<PyRef<'py, Model>>,
    start: Vec<f64>,
    steps: usize,
    inputs: Option<PyReadonlyArray2<'py, f64>>,
    blow_up: f64,
    level: f64,
    jobs: Option<usize>,
) -> PyResult<BandRow<'py>> {
    let models = own(&members);
    let given = inputs.map_or_else(Vec::new, |u| columns(&u.as_array()));
    let limits = limits_of(blow_up);
    let band = run::owned(py, jobs, move |cancel| {
        let seen: Vec<&[f64]> = given.iter().map(Vec::as_slice).collect();
        Band::of_runs(&models, level, |model| {
            cancel.heed();
            model.iterate(&start, steps, &seen, &limits)
        })
    })?;
    band_row(py, band)
}
