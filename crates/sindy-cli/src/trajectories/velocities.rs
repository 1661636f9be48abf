//! Velocities of positions, for the trajectories that a model of second order is judged on.

use sindy::Dataset;
use sindy::identify::with_velocities;

use super::Trajectory;
use crate::error::{Error, Result};

/// Adds the velocities of `positions` behind the columns, whose names are `names`, `states` of them states first; gives the
/// names of all.
pub(crate) fn add(
    trajectories: Vec<Trajectory>,
    states: usize,
    names: Vec<String>,
    positions: &[String],
) -> Result<(Vec<Trajectory>, Vec<String>)> {
    if positions.is_empty() {
        return Ok((trajectories, names));
    }
    let refused = || Error::refused("--second-order");
    let mut data = Dataset::new(&names[..states], &names[states..]).map_err(refused())?;
    let filled: Vec<bool> = trajectories.iter().map(|t| t.filled).collect();
    for t in trajectories {
        data.push(t.name, t.time, t.columns, t.weights)
            .map_err(refused())?;
    }
    let data = with_velocities(&data, positions).map_err(refused())?;
    let all = data.trajectories().iter().zip(filled);
    let all = all.map(|(t, filled)| Trajectory {
        name: t.name.clone(),
        time: t.time.clone(),
        columns: t.columns.clone(),
        weights: t.weights.clone(),
        filled,
    });
    Ok((all.collect(), data.names()))
}
