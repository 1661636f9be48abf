//! Learned policies, as `touchdown land --space --policy` flies them.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{
    PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;
use touchdown_campaign::files::write;
use touchdown_campaign::policy::PolicyFile;
use touchdown_sim::landing::space::{LayerSettings, Observation, PolicySettings};

use super::{of_campaign, of_sim};
use crate::error::{self, fault};
use crate::run::{self, Cancel};

/// Multiplications between two looks at a Ctrl-C: some milliseconds of work. A call of fewer runs in place.
const WORK: usize = 10_000_000;

/// Weights, a row for each output; bias; activation.
type Layer<'py> = (
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    String,
);

/// A policy, checked.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct Policy {
    policy: Arc<touchdown_sim::landing::space::Policy>,
}

impl Policy {
    fn of(settings: PolicySettings) -> PyResult<Self> {
        let policy = touchdown_sim::landing::space::Policy::new(settings);
        let policy = Arc::new(policy.map_err(|e| of_sim(&e))?);
        Ok(Self { policy })
    }
}

#[pymethods]
impl Policy {
    /// Of settings in JSON without layers, and the layers.
    #[new]
    fn new(json: &str, layers: Vec<Layer<'_>>) -> PyResult<Self> {
        let mut settings: PolicySettings = error::read("policy", json)?;
        for (k, (weights, bias, activation)) in layers.into_iter().enumerate() {
            let activation = serde_json::from_value(activation.into());
            let key = format!("layers.{k}.activation");
            settings.layers.push(LayerSettings {
                weights: weights
                    .as_array()
                    .outer_iter()
                    .map(|row| row.to_vec())
                    .collect(),
                bias: bias.as_array().to_vec(),
                activation: activation.map_err(|e| error::settings(&key, &e))?,
            });
        }
        Self::of(settings)
    }

    /// The policy of a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = run::short(py, || Ok(PolicyFile::read(&path)))?;
        let policy = Arc::new(read.map_err(|e| of_campaign(&e))?.policy);
        Ok(Self { policy })
    }

    /// The policy of what [`Self::json`] gives.
    #[staticmethod]
    fn from_json(py: Python<'_>, json: &str) -> PyResult<Self> {
        let settings = run::short(py, || Ok(serde_json::from_str(json)))?;
        Self::of(settings.map_err(|e| error::settings("policy", &e))?)
    }

    /// Writes its file, whole or not at all.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let text = self.json(py)?;
        let written = run::short(py, || Ok(write(&path, text.as_bytes())))?;
        written.map_err(|e| of_campaign(&e))
    }

    /// The policy in JSON: the content of its file.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        let text = run::short(py, || Ok(serde_json::to_string(self.policy.settings())))?;
        text.map_err(|e| error::settings("policy", &e))
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
            let expected = format!("rows of {} numbers", Observation::NUMBERS);
            let found = format!("{rows} of {width}");
            let message = format!("observations: expected {expected}, found {found}");
            return Err(fault(message, "observations", &expected, &found));
        }
        let (seen, _) = values.as_chunks();
        let settings = self.policy.settings();
        let work: usize = settings.layers.iter().map(LayerSettings::weights).sum();
        let policy = Arc::clone(&self.policy);
        let actions = |seen: &[[f64; Observation::NUMBERS]], cancel: &Cancel| {
            let mut actions = Vec::with_capacity(seen.len() * settings.action.kind.numbers());
            for rows in seen.chunks((WORK / work).max(1)) {
                cancel.heed();
                let each = rows.iter().flat_map(|row| policy.action(row));
                actions.extend(each.map(|value| value.clamp(-1.0, 1.0)));
            }
            Ok(actions)
        };
        let actions: Vec<f64> = if rows * work <= WORK {
            run::short(py, || actions(seen, &Cancel::default()))?
        } else {
            run::borrowed(py, None, |cancel| actions(seen, cancel))?
        };
        PyArray1::from_vec(py, actions).reshape([rows, settings.action.kind.numbers()])
    }
}
