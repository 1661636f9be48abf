//! Trials: logs as named columns over time.

use std::path::{Path, PathBuf};

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchdown_log::Map;
use touchdown_trial::Provenance;

use super::of_log;
use crate::error::{self, fault};
use crate::run;

/// A recorded run: time, named channels with units, gaps as NaN.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct Trial {
    pub(crate) trial: touchdown_trial::Trial,
    pub(crate) of: Origin,
}

/// What is known of a trial beside its numbers.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(crate) struct Origin {
    /// What the map says of the vehicle, for identification.
    pub(crate) vehicle: touchdown_log::Vehicle,
    /// What the map says that it is of.
    pub(crate) description: String,
    warnings: Vec<String>,
    rows_read: usize,
    rows_used: usize,
    lossy: bool,
}

/// Channels as arrays by name.
type Channels<'py> = Vec<(String, Bound<'py, PyArray1<f64>>)>;

/// A function that makes a trial again, and its arguments: name, times, channels, and in JSON what else is known.
type Restored<'py> = (
    Bound<'py, PyAny>,
    (String, Bound<'py, PyArray1<f64>>, Channels<'py>, String),
);

/// A refusal of a trial's own rules.
fn of_trial(error: &touchdown_trial::TrialError) -> PyErr {
    let text = error.to_string();
    fault(
        text.clone(),
        "trial",
        "increasing times and named channels of their length",
        &text,
    )
}

#[pymethods]
impl Trial {
    /// Reads a log, by a map if one is given: a file, or the name of a built-in map.
    #[staticmethod]
    #[pyo3(signature = (path, map=None))]
    fn read(py: Python<'_>, path: PathBuf, map: Option<PathBuf>) -> PyResult<Self> {
        let map = map
            .map(|map| load_map(&map))
            .transpose()
            .map_err(|e| of_log("map", &e))?;
        let vehicle = map.as_ref().map(Map::vehicle).unwrap_or_default();
        let description = map
            .as_ref()
            .map_or_else(String::new, |m| m.description().to_owned());
        let read = run::owned(py, None, move |_| {
            Ok(touchdown_log::read_trial(path, map.as_ref()))
        })?;
        let (trial, findings) = read.map_err(|e| of_log("path", &e))?;
        let of = Origin {
            vehicle,
            description,
            rows_read: findings.rows_read,
            rows_used: findings.rows_used,
            lossy: findings.is_lossy(),
            warnings: findings.warnings,
        };
        Ok(Self { trial, of })
    }

    /// A trial of columns: times, and channels by name.
    #[staticmethod]
    fn from_columns(
        name: &str,
        time_s: PyReadonlyArray1<'_, f64>,
        channels: Vec<(String, PyReadonlyArray1<'_, f64>)>,
    ) -> PyResult<Self> {
        let time = time_s.as_array().to_vec();
        let rows = time.len();
        let mut trial = touchdown_trial::Trial::new(name, time).map_err(|e| of_trial(&e))?;
        for (channel, values) in channels {
            trial = trial
                .with_channel(channel, values.as_array().to_vec())
                .map_err(|e| of_trial(&e))?;
        }
        let of = Origin {
            rows_read: rows,
            rows_used: rows,
            ..Origin::default()
        };
        Ok(Self { trial, of })
    }

    /// What [`Self::__reduce__`] gives.
    #[staticmethod]
    fn restored(
        name: &str,
        time_s: PyReadonlyArray1<'_, f64>,
        channels: Vec<(String, PyReadonlyArray1<'_, f64>)>,
        origin: &str,
    ) -> PyResult<Self> {
        let of_numbers = Self::from_columns(name, time_s, channels)?;
        let (provenance, of): (Provenance, Origin) = error::read("trial", origin)?;
        let trial = of_numbers.trial.with_provenance(provenance);
        Ok(Self { trial, of })
    }

    /// For pickle and copy.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Restored<'py>> {
        let array = |values: &[f64]| PyArray1::from_slice(py, values);
        let channels = self.trial.channels();
        let channels = channels.map(|(name, values)| (name.to_owned(), array(values)));
        let origin = serde_json::to_string(&(self.trial.provenance(), &self.of))
            .map_err(|e| error::settings("trial", &e))?;
        let restored = py.get_type::<Self>().getattr("restored")?;
        let (name, time) = (self.name().to_owned(), array(self.trial.time_s()));
        Ok((restored, (name, time, channels.collect(), origin)))
    }

    /// The name: that of the file.
    #[getter]
    fn name(&self) -> &str {
        self.trial.name()
    }

    /// Names of the channels, without `time_s`.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.trial
            .channels()
            .map(|(name, _)| name.to_owned())
            .collect()
    }

    /// The values of one channel, or of `time_s`.
    fn channel<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        match self.trial.channel(name) {
            Some(values) => Ok(PyArray1::from_slice(py, values)),
            None if name == touchdown_trial::TIME_CHANNEL => {
                Ok(PyArray1::from_slice(py, self.trial.time_s()))
            }
            None => {
                let known = self.channels().join(", ");
                let expected = format!("one of time_s, {known}");
                let message = format!(
                    "trial {:?} has no channel {name:?}: {expected}",
                    self.name()
                );
                Err(fault(message, "channel", &expected, name))
            }
        }
    }

    /// Rows.
    fn __len__(&self) -> usize {
        self.trial.len()
    }

    /// What reading it found.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.of.warnings.clone()
    }

    /// Rows of the file, rows in the trial, and whether input was lost.
    #[getter]
    fn rows(&self) -> (usize, usize, bool) {
        (self.of.rows_read, self.of.rows_used, self.of.lossy)
    }
}

fn load_map(map: &Path) -> Result<Map, touchdown_log::LogError> {
    if !map.exists()
        && let Some(built_in) = map.to_str().and_then(Map::built_in_named)
    {
        return Ok(built_in.clone());
    }
    let map = Map::load(map)?;
    map.check_names()?;
    Ok(map)
}
