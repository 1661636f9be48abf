//! The weak form: statistics of windows in the place of slopes.

use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use sindy::{Dataset, WeakForm};

use crate::error;
use crate::fit::per_state;
use crate::gram::Gram;
use crate::library::Library;
use crate::run;
use crate::slopes::{Given, dataset};

/// Settings as the Python side has them; a half-width that is not given follows from the data.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    half_width: Option<f64>,
    spacing: f64,
    power: u32,
    generalised: bool,
}

/// What was integrated for one state.
#[derive(Serialize)]
struct Windows {
    half_width: f64,
    windows: usize,
    missing_rows: usize,
    holes: usize,
    short: usize,
}

/// The statistics of the weak form, and in JSON what was integrated for each state.
#[pyfunction]
#[pyo3(signature = (states, inputs, trajectories, libraries, settings_json, jobs=None))]
pub(crate) fn weak(
    py: Python<'_>,
    states: Vec<String>,
    inputs: Vec<String>,
    trajectories: Vec<Given<'_>>,
    libraries: Vec<PyRef<'_, Library>>,
    settings_json: &str,
    jobs: Option<usize>,
) -> PyResult<(Gram, String)> {
    let settings: Settings = error::read("weak", settings_json)?;
    let data = dataset(&states, &inputs, &trajectories).map_err(|e| error::of(&e))?;
    let libraries = per_state(&libraries, states.len())?;
    let (own, names) = (libraries.clone(), states.clone());
    let (grams, windows) = run::owned(py, jobs, move |cancel| {
        let mut form = WeakForm::default()
            .spacing(settings.spacing)?
            .power(settings.power)?
            .generalised(settings.generalised);
        if let Some(half_width) = settings.half_width {
            form = form.half_width(half_width)?;
        }
        let samples = data.samples()?;
        let (mut grams, mut windows) = (Vec::new(), Vec::new());
        for (library, state) in own.iter().zip(&names) {
            cancel.heed();
            let system = form.system(library, Dataset::TIME, &[state], &samples)?;
            grams.push(system.total(0));
            windows.push(Windows {
                half_width: system.half_width,
                windows: system.windows,
                missing_rows: system.missing_rows,
                holes: system.holes,
                short: system.short,
            });
        }
        Ok((grams, windows))
    })?;
    let said = serde_json::to_string(&windows).map_err(|e| error::settings("weak", &e))?;
    Ok((Gram::of(states, inputs, libraries, grams), said))
}
