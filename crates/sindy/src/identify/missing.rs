//! Rows in which a state was not measured.
//!
//! Lost one by one, they leave stretches too short for slopes if each of them ends one. Few of them are bridged. Where they are usual,
//! lines through them would be smoother than the noise, so that states are taken at their own times: a row without any value is as
//! good as none. Where a row lacks some states only, as where they are measured at different rates, the others count.

use super::inputs;
use super::settings::Between;
use crate::data::dataset::sampling::{pick, rows};
use crate::data::dataset::{Dataset, Sampling, Stretch, Trajectory};
use crate::error::SindyError;
use crate::model::Interpolation;

/// The data without rows that hold no value, where such rows are usual or cannot be bridged, and a warning that says how many; `None`
/// elsewhere. The rows that remain have uneven times.
pub(super) fn without_empty_rows(data: &Dataset) -> Result<Option<(Dataset, String)>, SindyError> {
    let bridged = data.inputs().is_empty();
    let trajectories = data.trajectories().iter();
    let kept: Vec<Option<Vec<usize>>> = trajectories.map(|t| not_empty(t, bridged)).collect();
    if kept.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut out = Dataset::new(data.states(), data.inputs())?;
    for (t, kept) in data.trajectories().iter().zip(&kept) {
        let of = |values: &Vec<f64>| pick(values, kept.as_deref()).into_owned();
        let columns = t.columns.iter().map(of).collect();
        let weights = t.weights.as_ref().map(of);
        out.push(t.name.clone(), of(&t.time), columns, weights)?;
    }
    let rows = data.report().rows;
    let empty = rows - out.report().rows;
    let warning = format!(
        "{empty} of {rows} rows hold no value and are left out: the others count at their own times"
    );
    Ok(Some((out, warning)))
}

/// The rows that hold any value; `None` where all do, or few do not and these are `bridged`.
fn not_empty(trajectory: &Trajectory, bridged: bool) -> Option<Vec<usize>> {
    let holds = |row: usize| trajectory.columns.iter().any(|c| !c[row].is_nan());
    let all = Sampling::at((0..trajectory.time.len()).map(holds).collect());
    let kept = rows(&all.seen);
    let weights = trajectory.weights.as_ref();
    let count = weights.is_none_or(|w| kept.iter().any(|row| w[*row] > 0.0));
    let few = all.seen.len() - kept.len();
    (count && (all.uneven || (few > 0 && !bridged))).then_some(kept)
}

/// The data with no weight on rows that lack all states, which are bridged where they are few in succession, and a warning
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

/// Values of a state, at least: fewer give no noise and no slopes.
const FEWEST: usize = 10;

/// The data with likely values where a row lacks some of the states or an input, as identification fills them between samples: each
/// column by its own rate, inputs by `between`. `None` where no values are missing one by one ([`Dataset::lacks_single_values`]).
///
/// # Errors
/// A state of fewer than 10 values.
pub fn aligned(data: &Dataset, between: Between) -> Result<Option<Dataset>, SindyError> {
    Ok(match data.lacks_single_values() {
        true => Some(by_state(data, between)?.0),
        false => None,
    })
}

/// Whether states are taken by themselves, each at its own times: where values are missing one by one, and where rows that lack all
/// states are usual.
pub(super) fn is_by_state(data: &Dataset) -> bool {
    let states = data.states().len();
    let mut columns = data
        .trajectories()
        .iter()
        .flat_map(|t| &t.columns[..states]);
    data.lacks_single_values() || columns.any(|c| Sampling::of(c).uneven)
}

/// The data with likely values where a row lacks states or an input, with warnings that say how many values there are of each state,
/// and which inputs are hardly known between theirs. Each state is compared where it was measured.
pub(super) fn by_state(
    data: &Dataset,
    between: Between,
) -> Result<(Dataset, Vec<String>), SindyError> {
    let mut rough = vec![false; data.inputs().len()];
    let n = data.states().len();
    let mut out = Dataset::new(data.states(), data.inputs())?;
    let mut counts = vec![0; n];
    for t in data.trajectories() {
        let mut columns = t.columns.clone();
        let mut sampling: Vec<Sampling> = columns[..n].iter().map(|c| Sampling::of(c)).collect();
        for (own, column) in sampling.iter_mut().zip(&mut columns) {
            // A value without a time is no sample.
            (0..t.time.len()).for_each(|row| own.seen[row] &= !t.time[row].is_nan());
            own.fill(&t.time, column)?;
        }
        for (column, rough) in columns[n..].iter_mut().zip(&mut rough) {
            *rough |= fill_input(t, column, between)?;
        }
        let weight = |row: usize| t.weights.as_ref().map_or(1.0, |w| w[row]);
        for (own, count) in sampling.iter_mut().zip(&mut counts) {
            (0..t.time.len()).for_each(|row| own.seen[row] &= weight(row) > 0.0);
            *count += rows(&own.seen).len();
        }
        let all = (t.weights.clone(), sampling);
        out.push_sampled(t.name.clone(), t.time.clone(), columns, all)?;
    }
    for (name, count) in data.states().iter().zip(&counts) {
        if *count < FEWEST {
            let expected = format!("at least {FEWEST} values of `{name}`");
            return Err(SindyError::setting("states", expected, count));
        }
    }
    let counts: Vec<String> = data
        .states()
        .iter()
        .zip(counts)
        .map(|(name, count)| format!("{name} in {count}"))
        .collect();
    let warning = format!(
        "of {} rows {} hold a value: each state is compared where it was measured, and smoothed between",
        data.report().rows,
        counts.join(", ")
    );
    let unknown = data
        .inputs()
        .iter()
        .zip(&rough)
        .filter(|(_, rough)| **rough);
    let unknown = unknown.map(|(name, _)| {
        format!(
            "samples of the input {name} do not show what it is between them: straight lines are taken. If it is held, \
             `inputs_between = \"hold\"` in the settings says so; else its rate is too low for the model"
        )
    });
    let warnings = std::iter::once(warning).chain(unknown).collect();
    Ok((out, warnings))
}

/// Writes values into the rows that lack an input with a rate of its own, by what it is between its samples; whether these hardly show
/// it.
fn fill_input(
    trajectory: &Trajectory,
    column: &mut [f64],
    between: Between,
) -> Result<bool, SindyError> {
    let sampling = Sampling::of(column);
    if !sampling.slow {
        return Ok(false);
    }
    let own = rows(&sampling.seen);
    let (time, values) = (pick(&trajectory.time, Some(&own)), pick(column, Some(&own)));
    let stretch = Stretch {
        trajectory: 0,
        time: &time,
        columns: vec![&values],
        weights: None,
        seen: Vec::new(),
    };
    let choice = inputs::choose(&[stretch], 0, between);
    let (how, rough) = (choice.between[0], choice.second.is_some());
    if how == Interpolation::Cubic {
        sampling.fill(&trajectory.time, column)?;
        return Ok(rough);
    }
    for pair in own.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let step = trajectory.time[b] - trajectory.time[a];
        for row in a + 1..b {
            let part = match how {
                Interpolation::Linear => (trajectory.time[row] - trajectory.time[a]) / step,
                _ => 0.0,
            };
            column[row] = column[a] + part * (column[b] - column[a]);
        }
    }
    Ok(rough)
}
