//! Partial sums of the automatic call: added file by file, merged, pickled, ended.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use sindy::identify::{Columns, PartialSums as Sums, Settings};
use sindy::{BlockSource, Identify, Samples, SindyError};

use crate::arrays::{self, views};
use crate::error;
use crate::fit::{per_state, said};
use crate::library::Library;
use crate::model::Model;
use crate::run;
use crate::slopes::WEIGHT;

/// The name of the column of times; no expression can contain it.
const TIME: &str = "(time)";

/// The trajectories of a file: for each the arrays with its columns, which are times, states, inputs, and weights.
type Arrays<'py> = Vec<Vec<PyReadonlyArray2<'py, f64>>>;

/// What a pass over some of the files leaves.
#[pyclass(module = "sindy._native")]
pub(crate) struct PartialSums {
    sums: Sums,
    columns: Vec<String>,
}

/// What `pickle` takes: a function and its arguments.
type Reduced<'py> = (Bound<'py, PyAny>, (String, Vec<String>));

#[pymethods]
impl PartialSums {
    /// Sums of no file. `heads` holds the first files, of `HEAD_ROWS` rows or all there are.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "keywords of one Python function")]
    fn begin(
        py: Python<'_>,
        states: Vec<String>,
        inputs: Vec<String>,
        weighted: bool,
        libraries: Vec<PyRef<'_, Library>>,
        settings_json: &str,
        names: Vec<String>,
        heads: Vec<Arrays<'_>>,
        jobs: Option<usize>,
    ) -> PyResult<Self> {
        let settings: Settings = error::read("settings", settings_json)?;
        let call = Identify::per_equation(per_state(&libraries, states.len())?)
            .settings(settings)
            .map_err(|e| error::of(&e))?;
        let columns = columns(&states, &inputs, weighted);
        let all: Vec<_> = heads.iter().map(|groups| views(groups)).collect();
        let sums = run::borrowed(py, jobs, |cancel| {
            let mut roles = Columns::new(TIME, &states, &inputs)?;
            if weighted {
                roles = roles.weights(WEIGHT);
            }
            let heads = all
                .into_iter()
                .map(|groups| arrays::Columns::new(columns.clone(), groups, cancel))
                .collect::<Result<Vec<_>, SindyError>>()?;
            // The files behind the heads are not read for the plan.
            let texts: Vec<&str> = columns.iter().map(String::as_str).collect();
            let unread = Samples::new(&texts);
            let mut sources: Vec<&dyn BlockSource> = heads.iter().map(|h| h as _).collect();
            sources.resize(names.len(), &unread);
            call.partial_sums(&roles, &names, &sources)
        })?;
        Ok(Self { sums, columns })
    }

    /// Passes over the file with this number.
    fn add(
        &mut self,
        py: Python<'_>,
        number: usize,
        trajectories: Arrays<'_>,
        jobs: Option<usize>,
    ) -> PyResult<()> {
        let (sums, columns) = (&mut self.sums, &self.columns);
        let groups = views(&trajectories);
        run::borrowed(py, jobs, |cancel| {
            let source = arrays::Columns::new(columns.clone(), groups, cancel)?;
            sums.add(number, &source)
        })
    }

    /// Adds the sums of other files.
    fn merge(&mut self, py: Python<'_>, other: &Self) -> PyResult<()> {
        let sums = &mut self.sums;
        run::short(py, || sums.merge(other.sums.clone()))
    }

    /// Ends the identification: a model and, in JSON, all that is said of it.
    #[pyo3(signature = (jobs=None))]
    fn identify(&self, py: Python<'_>, jobs: Option<usize>) -> PyResult<(Model, String)> {
        let sums = self.sums.clone();
        let (model, said) = run::owned(py, jobs, move |cancel| {
            said(sums.identify(&mut |_| cancel.heed())?)
        })?;
        Ok((Model { model }, said))
    }

    /// The rows in the sums.
    #[getter]
    fn rows(&self) -> usize {
        self.sums.rows()
    }

    /// The files that are not in the sums.
    #[getter]
    fn missing(&self) -> Vec<String> {
        self.sums.missing().into_iter().map(str::to_owned).collect()
    }

    /// The sums as text, which reads back exactly.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        run::short(py, || self.sums.to_json())
    }

    /// The sums of a text, which have these states and inputs.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str, columns: Vec<String>) -> PyResult<Self> {
        let sums = run::short(py, || Sums::from_json(text))?;
        Ok(Self { sums, columns })
    }

    /// For pickle and copy.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let read = py.get_type::<Self>().getattr("from_json")?;
        Ok((read, (self.to_json(py)?, self.columns.clone())))
    }
}

/// Names of the columns of a file's arrays, in their order.
fn columns(states: &[String], inputs: &[String], weighted: bool) -> Vec<String> {
    let mut names = vec![TIME.to_owned()];
    names.extend(states.iter().chain(inputs).cloned());
    names.extend(weighted.then(|| WEIGHT.to_owned()));
    names
}
