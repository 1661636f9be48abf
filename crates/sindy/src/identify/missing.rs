//! Rows in which a state was not measured.
//!
//! Lost one by one, they leave stretches too short for slopes if each of them ends one.

use crate::data::dataset::Dataset;
use crate::error::SindyError;

/// The data with no weight on rows that lack a state, which are bridged where they are few in succession, and a warning
/// that says how many; `None` where there are none. Rows that lack an input stay missing, for nothing drives the model there.
pub(super) fn without_weight(data: &Dataset) -> Result<Option<(Dataset, String)>, SindyError> {
    let report = data.report();
    if report.missing_rows == 0 {
        return Ok(None);
    }
    let states = data.states().len();
    let mut out = Dataset::new(data.states(), data.inputs())?;
    for t in data.trajectories() {
        let mut weights = t.weights.clone();
        for row in 0..t.time.len() {
            let lacks = |columns: &[Vec<f64>]| columns.iter().any(|c| c[row].is_nan());
            if lacks(&t.columns[..states]) && !lacks(&t.columns[states..]) && !t.time[row].is_nan()
            {
                weights.get_or_insert_with(|| vec![1.0; t.time.len()])[row] = 0.0;
            }
        }
        if weights
            .as_ref()
            .is_some_and(|w| w.iter().all(|w| *w == 0.0))
        {
            weights = t.weights.clone();
        }
        out.push(t.name.clone(), t.time.clone(), t.columns.clone(), weights)?;
    }
    let bridged = report.missing_rows - out.report().missing_rows;
    let warning = format!(
        "{bridged} of {} rows lack values of states and have no weight; straight lines bridge them where slopes are needed",
        report.rows
    );
    Ok((bridged > 0).then_some((out, warning)))
}
