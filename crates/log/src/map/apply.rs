use super::Window;
use super::evaluate::{evaluate, is_known};
use super::median::running_median;
use super::rows::{Rows, TableRows};
use crate::inspection::{SLOW_STEP_S, is_slow};
use crate::tables::stamps::{Restarts, increasing, is_increasing};
use crate::{Findings, LogError, Map, Table, limits};
use std::path::Path;
use touchdown_trial::{Provenance, Source, TIME_CHANNEL, Trial, TrialError};

/// Tolerance of throttles at the limits of `[0, 1]`, for rounding in single precision, in which autopilots reckon: some 1e-7
/// after a few operations (ArduPilot logs -3e-8). It only decides on a warning.
const THROTTLE_SLACK: f64 = 1e-6;

/// Makes the trial that the map describes, and counts the rows that it drops.
///
/// The steps, in this order:
///
/// 1. Every expression is evaluated in every row.
/// 2. The filter removes rows.
/// 3. Rows without a stamp or with a stamp out of order are dropped and counted.
/// 4. Running medians, windows and resampling are applied.
///
/// The trial is named after the file.
///
/// # Errors
/// [`LogError::UnknownColumn`] or [`LogError::TextColumn`] for what an expression names;
/// [`LogError::NoUsableRows`] if no row remains; [`LogError::Trial`].
pub fn apply(table: &Table, map: &Map) -> Result<(Trial, Findings), LogError> {
    let mut rows = TableRows::new(table);
    limits::values(table.len(), 2 * map.channels.len(), table.bytes)
        .map_err(|excess| LogError::excess(&table.path, excess))?;
    let known = |name: &str| is_known(map, name) || rows.place(name).is_some();
    let resolved = map.resolve(&known, &|_| None);
    let (trial, mut findings) = apply_resolved(&mut rows, &resolved.map, &[])?;
    findings.warnings.extend(resolved.warnings());
    Ok((trial, findings))
}

/// As [`apply`] for a map without alternatives and definitions. Channels in `not_empty` are omitted
/// if they have no value.
pub(crate) fn apply_resolved(
    source: &mut dyn Rows,
    map: &Map,
    not_empty: &[String],
) -> Result<(Trial, Findings), LogError> {
    let mut columns = Vec::new();
    evaluate(source, map, &mut columns)?;
    let file = MappedFile {
        path: source.path(),
        sha256: source.sha256(),
        rows: source.len(),
    };
    trial_of(columns, &file, map, not_empty)
}

/// The file that a map was applied to.
pub(super) struct MappedFile<'a> {
    pub(super) path: &'a str,
    pub(super) sha256: &'a str,
    /// Number of rows.
    pub(super) rows: usize,
}

/// The trial of evaluated channels, which are followed by the row filter if there is one.
pub(super) fn trial_of(
    mut columns: Vec<(String, Vec<f64>)>,
    file: &MappedFile<'_>,
    map: &Map,
    not_empty: &[String],
) -> Result<(Trial, Findings), LogError> {
    let mut findings = Findings {
        rows_read: file.rows,
        ..Findings::default()
    };
    gaps_for_infinite(&mut columns, &mut findings);
    let keep = map.keep.as_ref().and_then(|_| columns.pop());
    let time = columns.iter().position(|(name, _)| name == TIME_CHANNEL);
    let time_s = time.map(|at| columns.remove(at).1).unwrap_or_default();
    let taken = rows_to_take(&time_s, keep, &mut findings);

    let path = file.path;
    check_stamps(path, taken.as_deref(), &findings)?;
    let of_trial = |source| LogError::Trial {
        path: path.to_owned(),
        source,
    };
    let take = |values: Vec<f64>| match &taken {
        None => values,
        Some(rows) => rows.iter().map(|&row| values[row]).collect(),
    };
    let mut trial = Trial::new(stem(path), take(time_s)).map_err(of_trial)?;
    for (name, values) in columns {
        let mut values = take(values);
        if not_empty.contains(&name) && values.iter().all(|value| value.is_nan()) {
            let text = format!("{name}: omitted, because it has no value");
            findings.warnings.push(text);
            continue;
        }
        if let Some((_, samples)) = map.medians.iter().find(|(known, _)| *known == name) {
            running_median(&mut values, *samples);
        }
        trial.insert(name, values).map_err(of_trial)?;
    }
    let parts = windows(&trial, map, path, &mut findings).map_err(of_trial)?;
    findings.rows_used = match &parts {
        None => trial.len(),
        Some(parts) => parts.iter().map(Trial::len).sum(),
    };
    findings.rows_outside_windows = trial.len() - findings.rows_used;
    if findings.rows_used == 0 {
        return Err(LogError::NoUsableRows {
            path: path.to_owned(),
            reason: format!(
                "of {} rows {} were removed by the filter, {} have bad stamps, {} lie outside the windows",
                file.rows,
                findings.rows_filtered,
                findings.rows_dropped(),
                findings.rows_outside_windows
            ),
        });
    }
    warn_of_values(&trial, &mut findings);
    let mut provenance = Provenance::new(Source::File {
        path: path.to_owned(),
        sha256: file.sha256.to_owned(),
    });
    provenance.notes = notes(map, &findings);
    let trial = resample_and_join(trial, parts, map).map_err(of_trial)?;
    Ok((trial.with_provenance(provenance), findings))
}

/// Replaces infinite values by gaps, and counts them.
fn gaps_for_infinite(columns: &mut [(String, Vec<f64>)], findings: &mut Findings) {
    for (name, values) in columns {
        let infinite = values.iter_mut().filter(|value| value.is_infinite());
        let count = infinite.map(|value| *value = f64::NAN).count();
        findings.infinite_values += count;
        if count > 0 && !name.is_empty() {
            findings
                .warnings
                .push(format!("{name}: {count} infinite values became gaps"));
        }
    }
}

/// The rows that the filter keeps and whose stamps increase; `None` for all of them. Counts the others.
fn rows_to_take(
    time_s: &[f64],
    keep: Option<(String, Vec<f64>)>,
    findings: &mut Findings,
) -> Option<Vec<usize>> {
    if keep.is_none() && is_increasing(time_s) {
        return None;
    }
    let mut rows: Vec<usize> = (0..findings.rows_read).collect();
    if let Some((_, keep)) = keep {
        rows.retain(|&row| keep[row] != 0.0 && !keep[row].is_nan());
        findings.rows_filtered = findings.rows_read - rows.len();
    }
    let kept = increasing(time_s, &rows);
    findings.absent_stamps = kept.absent;
    findings.duplicate_stamps = kept.duplicate;
    findings.backward_stamps = kept.backward;
    warn_of_stamps(findings);
    warn_of_disorder(time_s, &rows, findings);
    Some(kept.rows)
}

/// Refuses times of which only one can be used.
fn check_stamps(path: &str, taken: Option<&[usize]>, findings: &Findings) -> Result<(), LogError> {
    let (equal, before) = (findings.duplicate_stamps, findings.backward_stamps);
    if taken.is_none_or(|rows| rows.len() != 1) || equal + before == 0 {
        return Ok(());
    }
    let advice = match before > equal {
        true => "sort the rows by time",
        false => {
            "if rows follow each other evenly, count them by a map: time_s = 'row * 0.01' for a period of 0.01 s"
        }
    };
    Err(LogError::NoUsableRows {
        path: path.to_owned(),
        reason: format!(
            "time_s: expected times that increase; of {} rows {equal} repeat a stamp and {before} have one before that of an earlier \
             row, so that one row is left: {advice}",
            findings.rows_read
        ),
    })
}

/// The parts of the trial inside the map's windows, in order of time and without overlap; `None` if
/// the whole trial is used.
fn windows(
    trial: &Trial,
    map: &Map,
    path: &str,
    findings: &mut Findings,
) -> Result<Option<Vec<Trial>>, TrialError> {
    let holds = |window: &&Window| window.file.as_ref().is_none_or(|file| path.ends_with(file));
    let mut holding: Vec<&Window> = map.windows.iter().filter(holds).collect();
    if holding.is_empty() {
        if !map.windows.is_empty() {
            findings
                .warnings
                .push("no window of the map names this file; it is used whole".to_owned());
        }
        return Ok(None);
    }
    holding.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    let mut joined: Vec<(f64, f64)> = Vec::new();
    for window in holding {
        match joined.last_mut() {
            Some((_, end_s)) if window.from_s <= *end_s => *end_s = end_s.max(window.to_s),
            _ => joined.push((window.from_s, window.to_s)),
        }
    }
    let mut parts = Vec::new();
    for (from_s, to_s) in joined {
        let part = trial.window(from_s, to_s)?;
        if part.is_empty() {
            findings
                .warnings
                .push(format!("no rows in the window {from_s} s to {to_s} s"));
        }
        parts.push(part);
    }
    Ok(Some(parts))
}

fn resample_and_join(
    whole: Trial,
    parts: Option<Vec<Trial>>,
    map: &Map,
) -> Result<Trial, TrialError> {
    let resample = |part: &Trial| match map.resample {
        None => Ok(part.clone()),
        Some(resample) => match resample.max_gap_s {
            None => part.resample_linear(resample.period_s),
            Some(gap_s) => part.resample_linear_within(resample.period_s, gap_s),
        },
    };
    let parts = match parts {
        None if map.resample.is_none() => return Ok(whole),
        None => vec![resample(&whole)?],
        Some(parts) => parts.iter().map(resample).collect::<Result<_, _>>()?,
    };
    let time_s = parts.iter().flat_map(|part| part.time_s().iter().copied());
    let mut trial = Trial::new(whole.name(), time_s.collect())?;
    for (name, _) in whole.channels() {
        let values = parts
            .iter()
            .flat_map(|part| part.channel(name).unwrap_or_default());
        trial.insert(name, values.copied().collect())?;
    }
    Ok(trial)
}

fn warn_of_stamps(findings: &mut Findings) {
    for (count, what) in [
        (findings.absent_stamps, "have no stamp"),
        (findings.duplicate_stamps, "repeat a stamp"),
        (findings.backward_stamps, "have a stamp out of order"),
    ] {
        if count > 0 {
            findings.warnings.push(format!(
                "{count} of {} rows {what} and were dropped",
                findings.rows_read
            ));
        }
    }
}

/// Longest steps of two seconds in milliseconds and in microseconds.
const MOST_MS: f64 = 2e3;
const MOST_US: f64 = 2e6;

/// Share of rows with equal stamps above which the clock is too coarse for the rows.
const COARSE: f64 = 0.1;

/// Says what to do about stamps of which many are equal or out of order.
fn warn_of_disorder(time_s: &[f64], rows: &[usize], findings: &mut Findings) {
    let restarts = Restarts::of(time_s, rows).warning(TIME_CHANNEL);
    let all = findings.rows_read as f64;
    let is_backward = restarts.is_none() && findings.backward_stamps as f64 > 0.5 * all;
    let is_coarse = restarts.is_none() && findings.duplicate_stamps as f64 > COARSE * all;
    findings.warnings.extend(restarts);
    if is_backward {
        let text = "time_s: most stamps are before those of earlier rows. Sort the rows by time";
        findings.warnings.push(text.to_owned());
    }
    if is_coarse {
        let text = "time_s: its clock is coarser than the rows. If rows follow each other evenly, count them by a map: time_s = \
                    'row * 0.01' for a period of 0.01 s";
        findings.warnings.push(text.to_owned());
    }
}

fn warn_of_values(trial: &Trial, findings: &mut Findings) {
    let stamps = trial.time_s();
    let is_long = |pair: &&[f64]| pair[1] - pair[0] >= SLOW_STEP_S;
    let long = stamps.windows(2).filter(is_long).count();
    // A median takes a copy of all steps: it is computed where it can be long.
    let period_s = (2 * long + 1 >= stamps.len()).then(|| trial.period_s());
    if let Some(period_s) = period_s
        .flatten()
        .filter(|&period_s| is_slow(period_s, stamps.len()))
    {
        let unit = match period_s {
            step if step < MOST_MS => "milliseconds",
            step if step < MOST_US => "microseconds",
            _ => "nanoseconds",
        };
        findings.warnings.push(format!(
            "time_s: the median step is {period_s} s; is it in {unit}?"
        ));
    }
    for (name, values) in trial.channels() {
        if name != "throttle" && !name.starts_with("throttle_") {
            continue;
        }
        let out = |v: &&f64| **v < -THROTTLE_SLACK || **v > 1.0 + THROTTLE_SLACK;
        let count = values.iter().filter(out).count();
        if count > 0 {
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            findings.warnings.push(format!(
                "{name}: {count} values lie outside 0 to 1 (from {low} to {high})"
            ));
        }
    }
}

fn notes(map: &Map, findings: &Findings) -> Vec<String> {
    let mut notes = Vec::new();
    if !map.path.is_empty() {
        notes.push(format!("mapped by {}", map.path));
    }
    if findings.rows_filtered > 0 {
        notes.push(format!(
            "{} rows removed by the filter",
            findings.rows_filtered
        ));
    }
    if findings.rows_dropped() > 0 {
        notes.push(format!(
            "{} rows with bad stamps dropped",
            findings.rows_dropped()
        ));
    }
    for (channel, samples) in &map.medians {
        notes.push(format!("{channel}: running median of {samples} samples"));
    }
    if findings.rows_outside_windows > 0 {
        notes.push(format!(
            "{} rows outside the windows removed",
            findings.rows_outside_windows
        ));
    }
    if let Some(resample) = map.resample {
        notes.push(format!("resampled linearly to {} s", resample.period_s));
    }
    notes
}

fn stem(path: &str) -> String {
    Path::new(path).file_stem().map_or_else(
        || path.to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}
