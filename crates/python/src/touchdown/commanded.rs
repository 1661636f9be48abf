//! Landings that Python commands, decision by decision, for environments of learning.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::{
    PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray2, PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;
use serde_json::Value;
use touchdown_sim::landing::space::{
    ActionSettings, Batch, LaneEnd, Observation, SpaceLanding, SpaceScenario,
};

use super::land::Given;
use super::{of_campaign, of_sim};
use crate::error::{self, fault};
use crate::run;

/// Numbers of an end, in this order: V_L (m/s), tilt (rad), distance from the deck's centre (m) and time (s) of the first
/// touch, time of the end (s).
const NUMBERS: usize = 5;
/// Landings between two looks at a Ctrl-C: some tenths of a second of work.
const BLOCK: u64 = 64;

/// Landings side by side.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct Commanded {
    landings: Mutex<touchdown_sim::landing::space::Commanded>,
    batch: Batch,
    scenario: SpaceScenario,
    action: ActionSettings,
}

/// Places of the landings that have ended, names of their outcomes, numbers, states.
type Ends<'py> = (
    Vec<usize>,
    Vec<String>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// The name of an outcome, with its cause.
fn outcome(landing: &SpaceLanding) -> String {
    let value = serde_json::to_value(landing.outcome).unwrap_or_default();
    let text = |key: &str| value.get(key).and_then(Value::as_str);
    match (text("kind"), text("cause")) {
        (Some(kind), Some(cause)) => format!("{kind}: {cause}"),
        (kind, _) => kind.unwrap_or_default().to_owned(),
    }
}

fn numbers(landing: &SpaceLanding) -> [f64; NUMBERS] {
    let touch = landing.touch.as_ref();
    let of = |value: Option<f64>| value.unwrap_or(f64::NAN);
    [
        of(touch.map(|t| t.v_l_mps)),
        of(touch.map(|t| t.tilt_rad)),
        of(touch.map(|t| t.lateral_m)),
        of(touch.map(|t| t.time_s)),
        landing.end_s,
    ]
}

#[pymethods]
impl Commanded {
    #[new]
    #[pyo3(signature = (case, json, action, places, decision_s))]
    fn new(
        case: &str,
        json: Option<&str>,
        action: &str,
        places: usize,
        decision_s: f64,
    ) -> PyResult<Self> {
        let given = Given::of(None::<PathBuf>, json)?;
        let scenario = given.over_case(case, None).map_err(|e| of_campaign(&e))?;
        let batch = Batch::new(&scenario).map_err(|e| of_sim(&e))?;
        let own = batch.clone();
        let action: ActionSettings = error::read("action", action)?;
        action.validate().map_err(|e| of_sim(&e))?;
        let kind = action.kind.command();
        let landings = touchdown_sim::landing::space::Commanded::new(own, kind, places, decision_s);
        Ok(Self {
            batch,
            landings: Mutex::new(landings.map_err(|e| of_sim(&e))?),
            scenario,
            action,
        })
    }

    /// Steps of the integration (1 ms each) between two decisions.
    #[getter]
    fn steps(&self) -> u64 {
        self.hold().steps()
    }

    /// The scenario in JSON.
    fn scenario(&self) -> PyResult<String> {
        serde_json::to_string(&self.scenario).map_err(|e| error::settings("scenario", &e))
    }

    /// Empties all places, so that what begins next is the same as in a new object.
    fn clear(&self) {
        self.hold().clear();
    }

    /// Begins a trial of a seed at each of these places.
    fn begin(
        &self,
        py: Python<'_>,
        places: Vec<usize>,
        trials: Vec<u64>,
        seed: u64,
    ) -> PyResult<()> {
        let begun = run::short(py, || {
            let mut landings = self.hold();
            let mut each = places.iter().zip(&trials);
            Ok(each.try_for_each(|(place, trial)| landings.begin(*place, *trial, seed)))
        })?;
        begun.map_err(|e| of_sim(&e))
    }

    /// Flies up to the next decision with an action for each place.
    fn fly<'py>(
        &self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Ends<'py>> {
        let found = actions.shape().to_vec();
        let width = self.action.kind.numbers();
        let actions = actions.as_slice().unwrap_or_default();
        if found[1] != width || actions.len() != self.hold().places() * width {
            let expected = format!("{} rows of {width} in C order", self.hold().places());
            let found = format!("{} of {}", found[0], found[1]);
            let message = format!("actions: expected {expected}, found {found}");
            return Err(fault(message, "actions", &expected, &found));
        }
        let ends: Vec<LaneEnd> = run::short(py, || {
            let mut landings = self.hold();
            let weight_n = landings.weight_n();
            let numbers = self.action.kind.command().numbers();
            let mut commands = vec![0.0; landings.places() * numbers];
            for (action, command) in actions
                .chunks_exact(width)
                .zip(commands.chunks_exact_mut(numbers))
            {
                self.action.command(weight_n, action, command);
            }
            Ok(landings.fly(&commands))
        })?;
        let table = |rows: Vec<f64>, width: usize| {
            PyArray1::from_vec(py, rows).reshape([ends.len(), width])
        };
        let of_numbers = ends.iter().flat_map(|end| numbers(&end.landing)).collect();
        let states = ends.iter().flat_map(|end| end.state).collect();
        Ok((
            ends.iter().map(|end| end.place).collect(),
            ends.iter().map(|end| outcome(&end.landing)).collect(),
            table(of_numbers, NUMBERS)?,
            table(states, Observation::NUMBERS)?,
        ))
    }

    /// The same trials by the scenario's own controller on the true state: names of the outcomes, numbers of the ends.
    fn by_controller<'py>(
        &self,
        py: Python<'py>,
        trials: u64,
        seed: u64,
    ) -> PyResult<(Vec<String>, Bound<'py, PyArray2<f64>>)> {
        let batch = self.batch.clone();
        let flown = run::owned(py, None, move |cancel| {
            let blocks = (0..trials).step_by(BLOCK as usize).map(|start| {
                cancel.heed();
                batch.land(start..trials.min(start + BLOCK), seed)
            });
            Ok(blocks.collect::<std::result::Result<Vec<_>, _>>())
        })?;
        let landings = flown.map_err(|e| of_sim(&e))?.concat();
        let rows: Vec<f64> = landings.iter().flat_map(numbers).collect();
        let rows = PyArray1::from_vec(py, rows).reshape([landings.len(), NUMBERS])?;
        Ok((landings.iter().map(outcome).collect(), rows))
    }

    /// The true states, a row for each place.
    fn observe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let landings = self.hold();
        let width = Observation::NUMBERS;
        let mut seen = vec![0.0; landings.places() * width];
        landings.observe(&mut seen);
        PyArray1::from_vec(py, seen).reshape([landings.places(), width])
    }
}

impl Commanded {
    /// The landings, for one thread at a time.
    fn hold(&self) -> MutexGuard<'_, touchdown_sim::landing::space::Commanded> {
        self.landings.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
