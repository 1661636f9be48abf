//! Models: predict, simulate, write.

use numpy::ndarray::{Array2, ShapeBuilder};
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use sindy::model::{Inputs, Integrator, Interpolation, Limits, Run, RunOutcome, Simulation, Time};

use crate::arrays::columns;
use crate::error;
use crate::run;

/// A matrix of NumPy.
pub(crate) type Matrix<'py> = Bound<'py, PyArray2<f64>>;
/// Expression, coefficient, standard error, probability that the term belongs there.
type TermRow = (String, f64, Option<f64>, Option<f64>);
/// Times, states, how the run ended, in a sentence if it ended early.
type RunRow<'py> = (Vec<f64>, Matrix<'py>, Option<String>);

/// A dynamical system as one sparse sum of terms for each state.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct Model {
    pub(crate) model: sindy::Model,
}

/// A matrix of columns that stand one after another.
pub(crate) fn matrix(
    py: Python<'_>,
    rows: usize,
    n: usize,
    data: Vec<f64>,
) -> PyResult<Matrix<'_>> {
    let array =
        Array2::from_shape_vec((rows, n).f(), data).map_err(|e| error::panic(&e.to_string()))?;
    Ok(array.into_pyarray(py))
}

/// What inputs are between their samples.
fn between(how: &str) -> PyResult<Interpolation> {
    match how {
        "hold" | "zero_order_hold" => Ok(Interpolation::ZeroOrderHold),
        "linear" => Ok(Interpolation::Linear),
        "cubic" => Ok(Interpolation::Cubic),
        other => {
            let expected = "hold, linear or cubic";
            let message = format!("setting `between`: expected {expected}, found {other}");
            Err(error::fault(message, "between", expected, other))
        }
    }
}

/// Where a run ends early: where a state exceeds this magnitude.
pub(crate) fn limits_of(blow_up: f64) -> Limits {
    Limits::default().blow_up_above(blow_up)
}

/// How a run in continuous time is integrated: by a pair with relative and absolute tolerance, or with a step.
pub(crate) fn simulation(
    (relative, absolute): (f64, f64),
    step: Option<f64>,
    blow_up: f64,
) -> Simulation {
    let integrator = match step {
        Some(step) => Integrator::RungeKutta4 { step },
        None => Integrator::DormandPrince { relative, absolute },
    };
    Simulation::new(integrator).limits(limits_of(blow_up))
}

/// Inputs of their samples, with what each of them is in between.
pub(crate) fn inputs_of(
    time: &PyReadonlyArray1<'_, f64>,
    samples: Option<PyReadonlyArray2<'_, f64>>,
    between_inputs: &[String],
) -> PyResult<Inputs> {
    let Some(samples) = samples else {
        return Ok(Inputs::none());
    };
    let own = columns(&samples.as_array());
    let seen: Vec<&[f64]> = own.iter().map(Vec::as_slice).collect();
    let each = between_inputs.iter().map(|how| between(how));
    let each = each.collect::<PyResult<Vec<_>>>()?;
    let at = time.as_array().to_vec();
    Inputs::sampled_each(&at, &seen, &each).map_err(|e| error::of(&e))
}

/// How a run ended, if early.
pub(crate) fn early(outcome: &RunOutcome) -> Option<String> {
    match outcome {
        RunOutcome::Finished => None,
        RunOutcome::BlewUp { time } => Some(format!("blew up at t = {time}")),
        RunOutcome::OutOfRange { time, state } => {
            Some(format!("`{state}` left its range at t = {time}"))
        }
        RunOutcome::StepTooSmall { time } => Some(format!(
            "no step is small enough for the tolerance at t = {time}"
        )),
        RunOutcome::StepLimit { time } => Some(format!("used up its steps at t = {time}")),
        other => Some(format!("{other:?}")),
    }
}

fn run_row(py: Python<'_>, run: Run) -> PyResult<RunRow<'_>> {
    let (rows, n) = (run.time.len(), run.states.len());
    let outcome = early(&run.outcome);
    Ok((run.time, matrix(py, rows, n, run.states.concat())?, outcome))
}

#[pymethods]
impl Model {
    /// The model of a text in JSON.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let model = sindy::Model::from_json(text).map_err(|e| error::of(&e))?;
        Ok(Self { model })
    }

    /// The model in JSON, which reads back exactly.
    fn to_json(&self) -> PyResult<String> {
        self.model.to_json().map_err(|e| error::of(&e))
    }

    /// For pickle and copy: the text in JSON reads back exactly.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let read = py.get_type::<Self>().getattr("from_json")?;
        Ok((read, (self.to_json()?,)))
    }

    /// The equations in LaTeX.
    #[pyo3(signature = (digits=None))]
    fn to_latex(&self, digits: Option<usize>) -> String {
        self.model.to_latex(digits)
    }

    /// A function in C.
    fn to_c(&self, name: &str) -> PyResult<String> {
        self.model.to_c(name).map_err(|e| error::of(&e))
    }

    /// A function in Rust.
    fn to_rust(&self, name: &str) -> PyResult<String> {
        self.model.to_rust(name).map_err(|e| error::of(&e))
    }

    /// The equations as text with this number of digits.
    fn text(&self, digits: usize) -> String {
        format!("{:.digits$}", self.model)
    }

    /// Names of the states.
    #[getter]
    fn states(&self) -> Vec<String> {
        self.model.states().to_vec()
    }

    /// Names of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.model.inputs().to_vec()
    }

    /// The period of a model in discrete time.
    #[getter]
    fn period(&self) -> Option<f64> {
        match self.model.time() {
            Time::Continuous => None,
            Time::Discrete { period } => Some(period),
        }
    }

    /// The terms of each equation.
    #[getter]
    fn terms(&self) -> Vec<Vec<TermRow>> {
        let of = |t: &sindy::model::Term| {
            let text = t.expression.to_string();
            (text, t.coefficient, t.std_error, t.inclusion)
        };
        let equations = self.model.equations().iter();
        equations
            .map(|terms| terms.iter().map(of).collect())
            .collect()
    }

    /// The right-hand side for every row of states and inputs.
    #[pyo3(signature = (x, u=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'py, f64>,
        u: Option<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<Matrix<'py>> {
        let (x, u) = (x.as_array(), u.as_ref().map(PyReadonlyArray2::as_array));
        let rows = x.nrows();
        let values = run::short(py, || {
            // Columns in one piece are read where they are.
            let all: Vec<_> = x
                .columns()
                .into_iter()
                .chain(u.iter().flat_map(|u| u.columns()))
                .collect();
            let own: Vec<Option<Vec<f64>>> = all
                .iter()
                .map(|c| c.as_slice().is_none().then(|| c.to_vec()))
                .collect();
            let seen: Vec<&[f64]> = all
                .iter()
                .zip(&own)
                .map(|(c, own)| match own {
                    Some(own) => own.as_slice(),
                    None => c.as_slice().unwrap_or_default(),
                })
                .collect();
            self.model.predict(&seen)
        })?;
        matrix(py, rows, self.model.states().len(), values.concat())
    }

    /// A run in continuous time. Inputs are samples at `input_time`, with `between` for each of them.
    #[pyo3(signature = (start, time, input_time, inputs, between_inputs, rtol, atol, step, blow_up))]
    #[expect(clippy::too_many_arguments, reason = "keywords of one Python method")]
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        start: Vec<f64>,
        time: PyReadonlyArray1<'py, f64>,
        input_time: PyReadonlyArray1<'py, f64>,
        inputs: Option<PyReadonlyArray2<'py, f64>>,
        between_inputs: Vec<String>,
        rtol: f64,
        atol: f64,
        step: Option<f64>,
        blow_up: f64,
    ) -> PyResult<RunRow<'py>> {
        let how = simulation((rtol, atol), step, blow_up);
        let time = time.as_array().to_vec();
        let inputs = inputs_of(&input_time, inputs, &between_inputs)?;
        let model = self.model.clone();
        let run = run::owned(py, None, move |_| {
            model.simulate(&start, &time, &inputs, &how)
        })?;
        run_row(py, run)
    }

    /// A run in discrete time, of one row more than `steps`.
    #[pyo3(signature = (start, steps, inputs, blow_up))]
    fn iterate<'py>(
        &self,
        py: Python<'py>,
        start: Vec<f64>,
        steps: usize,
        inputs: Option<PyReadonlyArray2<'py, f64>>,
        blow_up: f64,
    ) -> PyResult<RunRow<'py>> {
        let own = inputs.map_or_else(Vec::new, |u| columns(&u.as_array()));
        let limits = limits_of(blow_up);
        let model = self.model.clone();
        let run = run::owned(py, None, move |_| {
            let seen: Vec<&[f64]> = own.iter().map(Vec::as_slice).collect();
            model.iterate(&start, steps, &seen, &limits)
        })?;
        run_row(py, run)
    }
}
