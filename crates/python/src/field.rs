//! Partial differential equations from fields on a grid.

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use serde::Deserialize;
use sindy::SindyError;
use sindy::pde::{Axis, FieldData, FieldIdentification, FieldLibrary, IdentifyField};

use crate::error;
use crate::run;

/// Candidates, and how they are looked for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    degree: u8,
    order: Option<u8>,
    terms: Option<Vec<String>>,
    time_order: u8,
    half_widths: Option<Vec<f64>>,
}

/// An axis by name: its coordinates, or its step and number of points.
#[derive(FromPyObject)]
pub(crate) enum GivenAxis {
    Even(String, f64, usize),
    Coordinates(String, Vec<f64>),
}

/// A measurement: its axes, time first, and its fields in row-major order.
type Given<'py> = (Vec<GivenAxis>, Vec<(String, PyReadonlyArray1<'py, f64>)>);

/// Equations that were found.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct FieldEquations {
    found: FieldIdentification,
}

#[pymethods]
impl FieldEquations {
    /// The equations as text, with this number of digits.
    fn text(&self, digits: usize) -> Vec<String> {
        let equations = self.found.equations.iter();
        equations.map(|e| format!("{e:.digits$}")).collect()
    }

    /// All that is known of them, as JSON.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.found).map_err(|e| error::settings("equations", &e))
    }
}

/// Identifies the equations of fields that were measured on grids.
#[pyfunction]
#[pyo3(signature = (data, settings_json, jobs=None))]
pub(crate) fn identify_fields(
    py: Python<'_>,
    data: Vec<Given<'_>>,
    settings_json: &str,
    jobs: Option<usize>,
) -> PyResult<FieldEquations> {
    let settings: Settings = error::read("settings", settings_json)?;
    let data = data.iter().map(field_data).collect::<Result<Vec<_>, _>>();
    let data = data.map_err(|e| error::of(&e))?;
    let Some(first) = data.first() else {
        let (expected, found) = ("at least one measurement", "none");
        let message = format!("`fields`: expected {expected}, found {found}");
        return Err(error::fault(message, "fields", expected, found));
    };
    let call = call(&settings, first).map_err(|e| error::of(&e))?;
    let found = run::owned(py, jobs, move |_| call.run(&data))?;
    Ok(FieldEquations { found })
}

fn field_data((axes, fields): &Given<'_>) -> Result<FieldData, SindyError> {
    let axis = |axis: &GivenAxis| match axis {
        GivenAxis::Even(name, step, points) => Axis::even(name, *step, *points),
        GivenAxis::Coordinates(name, coordinates) => Axis::new(name, coordinates),
    };
    let axes = axes.iter().map(axis).collect::<Result<_, _>>()?;
    let field = |(name, values): &(String, PyReadonlyArray1<'_, f64>)| {
        (name.clone(), values.as_array().to_vec())
    };
    FieldData::new(axes, fields.iter().map(field).collect())
}

/// The identification with candidates for the fields and axes of the `first` measurement.
fn call(settings: &Settings, first: &FieldData) -> Result<IdentifyField, SindyError> {
    let fields: Vec<&str> = first.names().iter().map(String::as_str).collect();
    let space: Vec<&str> = first.axes()[1..].iter().map(Axis::name).collect();
    let library = match &settings.terms {
        Some(terms) => {
            let terms: Vec<&str> = terms.iter().map(String::as_str).collect();
            FieldLibrary::parse(&fields, &space, &terms)?
        }
        None => {
            let usual = FieldLibrary::usual_order(space.len());
            let order = settings.order.unwrap_or(usual);
            FieldLibrary::polynomial(&fields, settings.degree, &space, order)?
        }
    };
    let call = IdentifyField::new(library).time_order(settings.time_order)?;
    match &settings.half_widths {
        Some(widths) => call.half_widths(widths.clone()),
        None => Ok(call),
    }
}
