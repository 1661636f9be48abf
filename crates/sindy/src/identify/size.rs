//! Data whose numbers are too large or too small to be reckoned with.

use crate::data::dataset::Dataset;
use crate::error::SindyError;

/// Values above it have no finite square sums.
const LARGEST: f64 = 1e150;
/// The squares of a column that is not zero, but nowhere above it, vanish.
const SMALLEST: f64 = 1e-150;

/// Refuses values whose squares overflow, by column, trajectory and time, and columns whose squares all vanish.
pub(super) fn check(data: &Dataset) -> Result<(), SindyError> {
    for t in data.trajectories() {
        for (name, column) in data.names().iter().zip(&t.columns) {
            let too_large = |v: &&f64| v.abs() > LARGEST;
            if let Some((value, time)) = column.iter().zip(&t.time).find(|(v, _)| too_large(v)) {
                return Err(SindyError::Magnitude {
                    what: format!("column `{name}` of {} at time {time}", t.name),
                    expected: format!("values of at most {LARGEST:e}"),
                    found: *value,
                });
            }
        }
    }
    for (i, name) in data.names().iter().enumerate() {
        let values = data.trajectories().iter().flat_map(|t| &t.columns[i]);
        let largest = values.fold(0.0_f64, |m, v| m.max(v.abs()));
        if largest > 0.0 && largest < SMALLEST {
            return Err(SindyError::Magnitude {
                what: format!("largest value of column `{name}`"),
                expected: format!("at least {SMALLEST:e}, or 0"),
                found: largest,
            });
        }
    }
    Ok(())
}
