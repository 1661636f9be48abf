//! Smoothed states and slopes.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use sindy::derivative::savgol::Smoothed;
use sindy::{Dataset, Samples, SindyError};

use crate::derivative::Description;
use crate::error;
use crate::model::{Matrix, matrix};
use crate::run;

/// A trajectory from Python: times, states, inputs, weights.
pub(crate) type Given<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray2<'py, f64>,
    Option<PyReadonlyArray2<'py, f64>>,
    Option<PyReadonlyArray1<'py, f64>>,
);

/// The name of the column of weights; no expression can contain it.
pub(crate) const WEIGHT: &str = "(weight)";

/// The data set of the caller's arrays, copied.
///
/// # Errors
/// As [`Dataset::push`].
pub(crate) fn dataset(
    states: &[String],
    inputs: &[String],
    given: &[Given<'_>],
) -> Result<Dataset, SindyError> {
    let mut data = Dataset::new(states, inputs)?;
    for (k, (time, x, u, weights)) in given.iter().enumerate() {
        let mut columns = crate::arrays::columns(&x.as_array());
        columns.extend(u.iter().flat_map(|u| crate::arrays::columns(&u.as_array())));
        let own = |a: &PyReadonlyArray1<'_, f64>| a.as_array().to_vec();
        data.push(
            format!("trajectory {k}"),
            own(time),
            columns,
            weights.as_ref().map(own),
        )?;
    }
    Ok(data)
}

/// The method of differentiation of a text in JSON.
pub(crate) fn method(text: &str) -> PyResult<Description> {
    error::read("smoothing", text)
}

/// Every state of every stretch, smoothed, in the order of the stretches.
fn smoothed(
    how: Description,
    data: &Dataset,
    heed: &dyn Fn(),
) -> Result<Vec<Vec<Smoothed>>, SindyError> {
    let by = (0..data.states().len())
        .map(|i| {
            heed();
            how.of(data, i)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let of = |s: &sindy::data::dataset::Stretch<'_>| {
        heed();
        by.iter()
            .zip(&s.columns)
            .map(|(by, column)| by.apply(s.time, column))
            .collect()
    };
    data.stretches().iter().map(of).collect()
}

/// Smoothed states, inputs, slopes (named by [`slope`]) and weights ([`WEIGHT`], one where none are given), one group for each stretch.
///
/// # Errors
/// A smoothing that does not suit the times.
pub(crate) fn samples(
    how: Description,
    data: &Dataset,
    heed: &dyn Fn(),
) -> Result<Samples, SindyError> {
    let slopes: Vec<String> = data.states().iter().map(|s| slope(s)).collect();
    let names: Vec<String> = [data.names(), slopes, vec![WEIGHT.to_owned()]].concat();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut samples = Samples::new(&names);
    let n = data.states().len();
    for (stretch, states) in data.stretches().iter().zip(smoothed(how, data, heed)?) {
        let (values, slopes): (Vec<_>, Vec<_>) =
            states.into_iter().map(|s| (s.value, s.derivative)).unzip();
        let mut columns: Vec<Vec<f64>> = values;
        columns.extend(stretch.columns[n..].iter().map(|c| c.to_vec()));
        columns.extend(slopes);
        columns.push(match stretch.weights {
            Some(weights) => weights.to_vec(),
            None => vec![1.0; stretch.time.len()],
        });
        samples.push_group(columns)?;
    }
    Ok(samples)
}

/// The name of a slope's column; no expression can contain it.
pub(crate) fn slope(state: &str) -> String {
    format!("(slope of {state})")
}

/// Smoothed states and their slopes, for each trajectory two arrays as `x`; NaN in gaps.
#[pyfunction]
#[pyo3(signature = (states, trajectories, method_json, jobs=None))]
pub(crate) fn slopes<'py>(
    py: Python<'py>,
    states: Vec<String>,
    trajectories: Vec<Given<'py>>,
    method_json: &str,
    jobs: Option<usize>,
) -> PyResult<Vec<(Matrix<'py>, Matrix<'py>)>> {
    let how = method(method_json)?;
    let data = dataset(&states, &[], &trajectories).map_err(|e| error::of(&e))?;
    let found = run::owned(py, jobs, move |cancel| {
        let stretches = data.stretches();
        let all = smoothed(how, &data, &|| cancel.heed())?;
        let empty = |rows: usize| vec![f64::NAN; rows * data.states().len()];
        let mut out: Vec<(usize, Vec<f64>, Vec<f64>)> = data
            .trajectories()
            .iter()
            .map(|t| (t.time.len(), empty(t.time.len()), empty(t.time.len())))
            .collect();
        for (stretch, states) in stretches.iter().zip(all) {
            let (rows, values, slopes) = &mut out[stretch.trajectory];
            let time = &data.trajectories()[stretch.trajectory].time;
            // Times increase, so the stretch begins where its first time stands.
            let start = time.partition_point(|t| *t < stretch.time[0]);
            for (i, state) in states.into_iter().enumerate() {
                let at = i * *rows + start;
                let to = at + stretch.time.len();
                values[at..to].copy_from_slice(&state.value);
                slopes[at..to].copy_from_slice(&state.derivative);
            }
        }
        Ok(out)
    })?;
    let n = states.len();
    found
        .into_iter()
        .map(|(rows, values, slopes)| {
            Ok((matrix(py, rows, n, values)?, matrix(py, rows, n, slopes)?))
        })
        .collect()
}
