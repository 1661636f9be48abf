//! Columns with rates of their own, for the trajectories that a model is judged on.

use sindy::Dataset;
use sindy::identify::{Between, aligned};

use super::Trajectory;
use crate::error::{Error, Result};

/// The trajectories with likely values where a column was not measured; `names` are those of the columns, `states` of them states
/// first.
pub(crate) fn filled(
    trajectories: Vec<Trajectory>,
    states: usize,
    names: &[String],
    warnings: &mut Vec<String>,
) -> Result<Vec<Trajectory>> {
    let refused = |name: &str| Error::refused(name.to_owned());
    let mut out = Vec::with_capacity(trajectories.len());
    for t in trajectories {
        let mut data =
            Dataset::new(&names[..states], &names[states..]).map_err(refused(&t.name))?;
        data.push(t.name.clone(), t.time.clone(), t.columns.clone(), None)
            .map_err(refused(&t.name))?;
        let found = aligned(&data, Between::Automatic).map_err(refused(&t.name))?;
        let Some(found) = found else {
            out.push(t);
            continue;
        };
        warnings.push(format!(
            "{}: values between the samples of a column are interpolated, and the free run is judged by them as well; slopes are not",
            t.name
        ));
        let columns = found.trajectories()[0].columns.clone();
        out.push(Trajectory {
            columns,
            filled: true,
            ..t
        });
    }
    Ok(out)
}
