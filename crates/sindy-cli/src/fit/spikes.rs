//! Gross errors in the trajectories that a model is judged on.

use sindy::Model;
use sindy::derivative::spikes;
use sindy::model::Time;

use crate::trajectories::Trajectory;

/// The trajectories with the spikes of the states replaced by the values that their neighbours predict, as in the fit: a
/// model is not judged by a sensor's slips. Nothing is done in discrete time, or where `wanted` is false.
pub(super) fn mended(
    mut trajectories: Vec<Trajectory>,
    model: &Model,
    wanted: bool,
    warnings: &mut Vec<String>,
) -> Vec<Trajectory> {
    if !wanted || model.time() != Time::Continuous {
        return trajectories;
    }
    for trajectory in trajectories.iter_mut().filter(|t| !t.filled) {
        let mut count = 0;
        for column in trajectory.columns.iter_mut().take(model.states().len()) {
            let mut from = 0;
            while from < column.len() {
                let length = column[from..].iter().take_while(|v| v.is_finite()).count();
                let run = from..from + length;
                // Whatever is refused here is refused where it is judged, with its place.
                let found = spikes(&trajectory.time[run.clone()], &column[run]);
                for spike in found.unwrap_or_default() {
                    column[from + spike.row] = spike.value;
                    count += 1;
                }
                from += length + 1;
            }
        }
        if count > 0 {
            warnings.push(format!(
                "{}: {count} values are taken for outliers and are not judged by",
                trajectory.name
            ));
        }
    }
    trajectories
}
