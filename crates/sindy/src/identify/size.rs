//! Data whose numbers are too large to be reckoned with.

use crate::dataset::Dataset;
use crate::error::SindyError;

/// Values above it have no finite square sums.
const LARGEST: f64 = 1e150;

/// Refuses values whose squares overflow, by column, trajectory and time.
pub(super) fn check(data: &Dataset) -> Result<(), SindyError> {
    for t in data.trajectories() {
        for (name, column) in data.names().iter().zip(&t.columns) {
            let too_large = |v: &&f64| v.abs() > LARGEST;
            if let Some((value, time)) = column.iter().zip(&t.time).find(|(v, _)| too_large(v)) {
                return Err(SindyError::setting(
                    "size of values",
                    format!("at most {LARGEST:e}"),
                    format!("{value:e} in column `{name}` of {} at time {time}", t.name),
                ));
            }
        }
    }
    Ok(())
}
