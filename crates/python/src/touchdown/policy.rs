//! Learned policies, as `touchdown land --space --policy` flies them.

use std::path::PathBuf;

use numpy::{
    PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray2, PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;
use touchdown_campaign::files::write;
use touchdown_campaign::policy::PolicyFile;
use touchdown_sim::landing::space::{Observation, PolicySettings};

use super::{of_campaign, of_sim};
use crate::error::{self, fault};
use crate::run;

/// A policy, checked.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct Policy {
    policy: touchdown_sim::landing::space::Policy,
}

#[pymethods]
impl Policy {
    #[new]
    fn new(json: &str) -> PyResult<Self> {
        let settings: PolicySettings = error::read("policy", json)?;
        let policy = touchdown_sim::landing::space::Policy::new(settings);
        let policy = policy.map_err(|e| of_sim(&e))?;
        Ok(Self { policy })
    }

    /// The policy of a file.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let read = PolicyFile::read(&path).map_err(|e| of_campaign(&e))?;
        let policy = read.policy;
        Ok(Self { policy })
    }

    /// Writes its file, whole or not at all.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        write(&path, self.json()?.as_bytes()).map_err(|e| of_campaign(&e))
    }

    /// The policy in JSON: the content of its file.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string(self.policy.settings()).map_err(|e| error::settings("policy", &e))
    }

    /// The actions for observations, a row each, within [-1, 1].
    fn actions<'py>(
        &self,
        py: Python<'py>,
        observations: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (rows, width) = (observations.shape()[0], observations.shape()[1]);
        let values = observations.as_slice().unwrap_or_default();
        if width != Observation::NUMBERS || values.len() != rows * width {
            let expected = format!("rows of {} in C order", Observation::NUMBERS);
            let found = format!("{rows} of {width}");
            let message = format!("observations: expected {expected}, found {found}");
            return Err(fault(message, "observations", &expected, &found));
        }
        let (seen, _) = values.as_chunks();
        let actions: Vec<f64> = run::short(py, || {
            let each = seen.iter().flat_map(|row| self.policy.action(row));
            Ok(each.map(|value| value.clamp(-1.0, 1.0)).collect())
        })?;
        PyArray1::from_vec(py, actions)
            .reshape([rows, self.policy.settings().action.kind.numbers()])
    }
}
