//! Equations of second order, `x'' = f(x, x', u)`, where only the position x is measured.
//!
//! The velocity becomes a state of its own, `x' = x_dot`, which is known, and `x_dot' = f(x, x_dot, u)`, which is looked
//! for. Velocities are estimated with the model: the output error compares positions alone, and the velocity at the start of
//! each arc is one of its unknowns. For regressions and first guesses the smoothed position is differentiated. Noise of that
//! estimate therefore enters neither the coefficients nor the choice of terms of a model by output error.

use super::prepare;
use crate::data::dataset::Dataset;
use crate::error::SindyError;

/// The name of a position's velocity.
///
/// ```
/// assert_eq!(sindy::identify::velocity("x"), "x_dot");
/// ```
#[must_use]
pub fn velocity(position: &str) -> String {
    format!("{position}_dot")
}

/// The places of `positions` among the states.
pub(super) fn places(data: &Dataset, positions: &[String]) -> Result<Vec<usize>, SindyError> {
    let mut places = Vec::new();
    for name in positions {
        let place = data.states().iter().position(|s| s == name);
        let place = place.filter(|p| !places.contains(p)).ok_or_else(|| {
            let expected = format!("states, each once: {}", data.states().join(", "));
            SindyError::setting("second_order", expected, format!("`{name}`"))
        })?;
        places.push(place);
    }
    Ok(places)
}

/// The data with the velocities of the states `positions` behind the other states: derivatives of the smoothed positions,
/// by the filter whose strength is taken from the data, or on uneven times by a smoothing spline.
///
/// # Errors
/// A position that is no state, or stands twice; a velocity whose name ([`velocity`]) is taken.
pub fn with_velocities(data: &Dataset, positions: &[String]) -> Result<Dataset, SindyError> {
    let places = places(data, positions)?;
    let stretches = data.stretches();
    let n = data.states().len();
    let uniform = prepare::is_uniform(data, &stretches);
    let filters = prepare::filters(&stretches, n, uniform, 1.0)?;
    let slopes = prepare::by(filters.as_deref(), &stretches, n)?;
    let mut all: Vec<Vec<Vec<f64>>> = data
        .trajectories()
        .iter()
        .map(|t| vec![vec![f64::NAN; t.time.len()]; places.len()])
        .collect();
    let mut of_stretch = slopes.smoothed.iter();
    for (t, velocities) in data.trajectories().iter().zip(&mut all) {
        for (range, smoothed) in t.ranges().iter().zip(&mut of_stretch) {
            for (column, &place) in velocities.iter_mut().zip(&places) {
                column[range.clone()].copy_from_slice(&smoothed[place].derivative);
            }
        }
    }
    let names: Vec<String> = positions.iter().map(|p| velocity(p)).collect();
    let states = [data.states(), &names].concat();
    let mut out = Dataset::new(&states, data.inputs())?;
    for (t, velocities) in data.trajectories().iter().zip(all) {
        let (states, inputs) = t.columns.split_at(n);
        let columns = [states, &velocities, inputs].concat();
        let of_velocities = places.iter().filter_map(|&place| t.sampling().get(place));
        let sampling = t.sampling().iter().chain(of_velocities).cloned().collect();
        let all = (t.weights.clone(), sampling);
        out.push_sampled(t.name.clone(), t.time.clone(), columns, all)?;
    }
    Ok(out)
}
