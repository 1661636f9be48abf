//! A scenario in space whose landings are flown one by one.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use touchdown_campaign::policy::POLICY;
use touchdown_campaign::settings_file::to_toml;
use touchdown_campaign::sweep::{self, Sweep, SweepSettings};
use touchdown_campaign::{Error, Result};

use super::land::{
    CardFiles, Files, Given, Heeding, SpaceLandings, in_bytes, put_cards, settings_of,
};
use super::of_campaign;
use crate::error::fault;
use crate::run;

/// Trials that a scenario has: the most that a sweep may have.
const TRIALS: u64 = 100_000_000;

/// A function that makes a scenario again, and its argument.
type Restored<'py> = (Bound<'py, PyAny>, (Bound<'py, PyDict>,));

/// A scenario, checked.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct Space {
    sweep: Arc<Sweep>,
}

#[pymethods]
impl Space {
    #[new]
    #[pyo3(signature = (deck, file, json, cards, controller, policy, seed, deck_acceleration))]
    #[expect(clippy::too_many_arguments, reason = "one for each of Python's")]
    fn new(
        py: Python<'_>,
        deck: Option<String>,
        file: Option<PathBuf>,
        json: Option<&str>,
        cards: CardFiles,
        controller: Option<String>,
        policy: Option<PathBuf>,
        seed: Option<u64>,
        deck_acceleration: bool,
    ) -> PyResult<Self> {
        let given = Given::of(file, json)?;
        let made = run::owned(py, None, move |_| {
            Ok((|| -> Result<Sweep> {
                let (mut settings, folder, name) = settings_of(&given)?;
                if let Some(deck) = deck {
                    // What is given stands over the deck's; the vehicle's scaling heeds only what is given.
                    settings.scenario = given.over_case(&deck, Some("scenario"))?;
                }
                put_cards(&mut settings, cards);
                settings.seed = seed.unwrap_or(settings.seed);
                if !deck_acceleration {
                    settings.scenario.control.deck_acceleration = false;
                }
                // A policy flies alone: a scenario has one controller.
                let controller = controller.or_else(|| policy.is_some().then(|| POLICY.to_owned()));
                settings.set_controllers(controller.into_iter().collect(), policy);
                let one = SweepSettings {
                    trials: 1,
                    ..settings.clone()
                };
                let points = Sweep::new(one, &folder, name.clone())?.points();
                if points > 1 {
                    return Err(Error::Arguments(format!(
                        "key `grid`: expected one point, found {points}; `touchdown.land` flies several"
                    )));
                }
                // With so many trials a sweep of several points is refused as too large.
                settings.trials = TRIALS;
                Sweep::new(settings, &folder, name)
            })())
        })?;
        let sweep = Arc::new(made.map_err(|e| of_campaign(&e))?);
        Ok(Self { sweep })
    }

    /// What [`Self::__reduce__`] gives.
    #[staticmethod]
    fn restored(files: Files) -> PyResult<Self> {
        let (sweep, _) = sweep::unpack(files, 0, 0).map_err(|e| of_campaign(&e))?;
        let sweep = Arc::new(sweep);
        Ok(Self { sweep })
    }

    /// For pickle and copy.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Restored<'py>> {
        let files = sweep::pack(&self.sweep, &[]).map_err(|e| of_campaign(&e))?;
        let restored = py.get_type::<Self>().getattr("restored")?;
        Ok((restored, (in_bytes(py, &files)?,)))
    }

    /// The landing of a trial.
    fn land(&self, py: Python<'_>, trial: u64) -> PyResult<SpaceLandings> {
        if trial >= TRIALS {
            let (expected, found) = (format!("0 to {}", TRIALS - 1), trial.to_string());
            let message = format!("trial: expected {expected}, found {found}");
            return Err(fault(message, "trial", &expected, &found));
        }
        let sweep = Arc::clone(&self.sweep);
        let flown = run::owned(py, None, move |cancel| {
            Ok(sweep::rows(
                &sweep,
                trial..trial + 1,
                &Heeding(cancel.clone()),
            ))
        })?;
        let rows = flown.map_err(|e| of_campaign(&e))?;
        Ok(SpaceLandings::new(Arc::clone(&self.sweep), rows))
    }

    /// The scenario with every key, as TOML.
    fn scenario_toml(&self) -> PyResult<String> {
        let scenario = self
            .sweep
            .scenario(0)
            .and_then(|scenario| to_toml(&scenario));
        scenario.map_err(|e| of_campaign(&e))
    }
}
