//! The statistics of rows: accumulated, merged, pickled, solved.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use sindy::model::Time;
use sindy::uncertainty::on_support;
use sindy::{BestSubset, Fit, Outcome, Solver as _};

use crate::error::{self, fault};
use crate::fit::{Task, of_arrays, per_state};
use crate::library::Library;
use crate::model::Model;
use crate::run;

/// Sufficient statistics of every equation: all that a solver needs of any number of rows.
#[pyclass(module = "sindy._native")]
pub(crate) struct Gram {
    states: Vec<String>,
    inputs: Vec<String>,
    libraries: Vec<sindy::Library>,
    grams: Vec<sindy::Gram>,
}

/// What is kept between processes; numbers read back exactly.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    states: Vec<String>,
    inputs: Vec<String>,
    terms: Vec<Vec<String>>,
    sums: Vec<sindy::Gram>,
}

/// The best subset of every size of one equation, and what is proven of it.
#[derive(Serialize)]
struct Subsets {
    outcome: Outcome,
    nodes: u64,
    ridge: f64,
    sizes: Vec<Subset>,
}

#[derive(Serialize)]
struct Subset {
    terms: Vec<String>,
    coefficients: Vec<f64>,
    residual_sum: f64,
    lower_bound: f64,
    gap: f64,
    outcome: Outcome,
}

impl Gram {
    /// Statistics that were made elsewhere.
    pub(crate) fn of(
        states: Vec<String>,
        inputs: Vec<String>,
        libraries: Vec<sindy::Library>,
        grams: Vec<sindy::Gram>,
    ) -> Self {
        Self {
            states,
            inputs,
            libraries,
            grams,
        }
    }
}

/// The terms of a support, and their coefficients.
fn kept(library: &sindy::Library, fit: &Fit) -> (Vec<String>, Vec<f64>) {
    let support = fit.support.iter().enumerate().filter(|(_, kept)| **kept);
    let term = |(j, _): (usize, &bool)| (library.names()[j].clone(), fit.coefficients[j]);
    support.map(term).unzip()
}

#[pymethods]
impl Gram {
    /// Statistics of no rows.
    #[new]
    fn new(
        states: Vec<String>,
        inputs: Vec<String>,
        libraries: Vec<PyRef<'_, Library>>,
    ) -> PyResult<Self> {
        let libraries = per_state(&libraries, states.len())?;
        let empty = |l: &sindy::Library| sindy::Gram::zeros(l.len());
        Ok(Self {
            grams: libraries.iter().map(empty).collect(),
            states,
            inputs,
            libraries,
        })
    }

    /// Adds the rows of arrays: states, inputs, targets and weights side by side, each read where it is.
    fn update(
        &mut self,
        py: Python<'_>,
        groups: Vec<Vec<PyReadonlyArray2<'_, f64>>>,
        weighted: bool,
        jobs: Option<usize>,
    ) -> PyResult<()> {
        let variables = (&self.states[..], &self.inputs[..]);
        let found = of_arrays(py, variables, &self.libraries, &groups, weighted, jobs)?;
        for (own, more) in self.grams.iter_mut().zip(&found) {
            own.merge(more);
        }
        Ok(())
    }

    /// Adds the rows of other statistics of the same terms.
    fn merge(&mut self, other: &Self) -> PyResult<()> {
        let terms = |g: &Self| -> Vec<Vec<String>> {
            g.libraries.iter().map(|l| l.names().to_vec()).collect()
        };
        let same = self.states == other.states
            && self.inputs == other.inputs
            && terms(self) == terms(other);
        if !same {
            let expected = "statistics of the same states, inputs and terms";
            let message = format!("merge: expected {expected}, found others");
            return Err(fault(message, "merge", expected, "others"));
        }
        for (own, more) in self.grams.iter_mut().zip(&other.grams) {
            own.merge(more);
        }
        Ok(())
    }

    /// Fits by a solver.
    #[pyo3(signature = (solver_json, period=None, jobs=None))]
    fn solve(
        &self,
        py: Python<'_>,
        solver_json: &str,
        period: Option<f64>,
        jobs: Option<usize>,
    ) -> PyResult<(Model, String)> {
        let task = Task {
            states: self.states.clone(),
            inputs: self.inputs.clone(),
            libraries: self.libraries.clone(),
            solver: error::read("solver", solver_json)?,
            time: period.map_or(Time::Continuous, |period| Time::Discrete { period }),
        };
        let grams = self.grams.clone();
        let (model, said) = run::owned(py, jobs, move |_| task.solve(&grams))?;
        Ok((Model { model }, said))
    }

    /// The best subset of every size of each equation, in JSON.
    #[pyo3(signature = (max_size, node_limit, tolerance, jobs=None))]
    fn best_subsets(
        &self,
        py: Python<'_>,
        max_size: Option<usize>,
        node_limit: Option<u64>,
        tolerance: f64,
        jobs: Option<usize>,
    ) -> PyResult<String> {
        let (grams, libraries) = (self.grams.clone(), self.libraries.clone());
        let found = run::owned(py, jobs, move |cancel| {
            let search = BestSubset::new()
                .max_size(max_size.unwrap_or(usize::MAX))
                .node_limit(node_limit.unwrap_or(u64::MAX))
                .tolerance(tolerance)?;
            let mut all = Vec::new();
            for (gram, library) in grams.iter().zip(&libraries) {
                let found = search.solve_while(gram, &mut || {
                    cancel.heed();
                    true
                })?;
                let subset = |subset: &sindy::solve::exact::Subset| {
                    let (terms, coefficients) = kept(library, &subset.fit);
                    Subset {
                        terms,
                        coefficients,
                        residual_sum: subset.fit.residual_sum,
                        lower_bound: subset.lower_bound,
                        gap: subset.gap(),
                        outcome: subset.fit.outcome,
                    }
                };
                all.push(Subsets {
                    sizes: found.sizes.iter().map(subset).collect(),
                    outcome: found.outcome,
                    nodes: found.nodes,
                    ridge: found.ridge,
                });
            }
            Ok(all)
        })?;
        serde_json::to_string(&found).map_err(|e| error::settings("subsets", &e))
    }

    /// Least squares on given terms of one equation: coefficients in the order of its library's kept terms, and the residual
    /// sum of squares.
    fn on_terms(
        &self,
        equation: usize,
        terms: Vec<String>,
    ) -> PyResult<(Vec<String>, Vec<f64>, f64)> {
        let (library, gram) = (&self.libraries[equation], &self.grams[equation]);
        let known = library.names();
        if let Some(other) = terms.iter().find(|term| !known.contains(term)) {
            let expected = format!("one of {}", known.join(", "));
            let message = format!("terms: expected {expected}, found {other}");
            return Err(fault(message, "terms", &expected, other));
        }
        let support = known.iter().map(|name| terms.contains(name)).collect();
        let fit = on_support(support).fit(gram).map_err(|e| error::of(&e))?;
        let (terms, coefficients) = kept(library, &fit);
        Ok((terms, coefficients, fit.residual_sum))
    }

    /// Rows that were used, and those left out because a value is not finite.
    #[getter]
    fn rows(&self) -> (usize, usize) {
        self.grams.first().map_or((0, 0), |g| (g.rows, g.skipped))
    }

    /// The statistics as text, which reads back exactly.
    fn to_json(&self) -> PyResult<String> {
        let kept = Kept {
            states: self.states.clone(),
            inputs: self.inputs.clone(),
            terms: self.libraries.iter().map(|l| l.names().to_vec()).collect(),
            sums: self.grams.clone(),
        };
        serde_json::to_string(&kept).map_err(|e| error::settings("gram", &e))
    }

    /// The statistics of a text.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let kept: Kept = error::read("gram", text)?;
        let libraries: Vec<sindy::Library> = kept
            .terms
            .iter()
            .map(|terms| sindy::Library::parse(terms).map_err(|e| error::of(&e)))
            .collect::<PyResult<_>>()?;
        let mut each = kept.sums.iter().zip(&libraries);
        if kept.sums.len() != kept.states.len()
            || kept.sums.len() != libraries.len()
            || each.any(|(gram, library)| gram.xty.len() != library.len())
        {
            let expected = "sums over the terms of each state";
            return Err(fault(
                format!("gram: expected {expected}"),
                "gram",
                expected,
                "others",
            ));
        }
        Ok(Self {
            states: kept.states,
            inputs: kept.inputs,
            libraries,
            grams: kept.sums,
        })
    }

    /// For pickle and copy.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let read = py.get_type::<Self>().getattr("from_json")?;
        Ok((read, (self.to_json()?,)))
    }
}
