//! Model cards.

use std::path::PathBuf;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use touchdown_flight::thrust::ThrustState;
use touchdown_identify::{rig, thrust};
use touchdown_model::Kind;

use super::trial::Trial;
use super::{of_card, of_identify};
use crate::error::fault;
use crate::run;

/// One model: terms with errors and units, validity, scores, provenance.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct Card {
    pub(crate) card: touchdown_model::Card,
}

#[pymethods]
impl Card {
    /// Reads a card from a file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let card = touchdown_model::Card::read(&path).map_err(|e| of_card(&e))?;
        Ok(Self { card })
    }

    /// The card of a text in TOML.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        let card = touchdown_model::Card::parse(text, "the text").map_err(|e| of_card(&e))?;
        Ok(Self { card })
    }

    /// Writes the card, whole or not at all.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.card.write(&path).map_err(|e| of_card(&e))
    }

    /// The card as text, which reads back to the bit.
    fn to_toml(&self) -> PyResult<String> {
        self.card.to_toml().map_err(|e| of_card(&e))
    }

    /// All that it holds, in JSON.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.card).map_err(|e| crate::error::settings("card", &e))
    }

    /// The equations in LaTeX.
    fn to_latex(&self, digits: usize) -> PyResult<String> {
        self.card.to_latex(digits).map_err(|e| of_card(&e))
    }

    /// The thrust at rest for throttles (N), by the model that flies.
    fn at_rest<'py>(
        &self,
        py: Python<'py>,
        throttle: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let model = self.card.thrust_model().map_err(|e| of_card(&e))?;
        let at = |s: &f64| ThrustState { x: model.rest(*s) }.thrust_n();
        Ok(PyArray1::from_iter(py, throttle.as_array().iter().map(at)))
    }

    /// For pickle and copy.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let read = py.get_type::<Self>().getattr("from_toml")?;
        Ok((read, (self.to_toml()?,)))
    }

    /// The thrust, or the ground-effect force, over a trial in free run (N). A ground-effect card needs the card of the
    /// free-air thrust.
    #[pyo3(signature = (trial, thrust_card=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        trial: &Trial,
        thrust_card: Option<&Self>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (card, trial) = (self.card.clone(), trial.trial.clone());
        let free_air = thrust_card.map(|c| c.card.clone());
        if card.kind == Kind::GroundEffect && free_air.is_none() {
            let expected = "the card of the free-air thrust";
            let message = format!("thrust: a ground-effect card needs {expected}");
            return Err(fault(message, "thrust", expected, "none"));
        }
        let found = run::owned(py, None, move |_| {
            Ok(match free_air {
                Some(free_air) if card.kind == Kind::GroundEffect => {
                    rig::prepare(&trial, &free_air).and_then(|trial| rig::predict(&card, &trial))
                }
                _ => thrust::predict(&card, &trial),
            })
        })?;
        let values = found.map_err(|e| of_identify(&e))?;
        Ok(PyArray1::from_vec(py, values))
    }
}
