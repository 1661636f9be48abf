use crate::apply::LONG_STEP_S;
use crate::jumps::Jumps;
use crate::stamps::increasing;
use crate::{ColumnKind, Table, suggest};
use serde::Serialize;
use touchdown_trial::{Source, TIME_CHANNEL, Trial, unit_of};

/// Part of the stamps that may be out of order in a column that is taken for the time.
const TOLERATED_DISORDER: f64 = 0.5;

/// What a table or a trial holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// The file, or the trial's name.
    pub path: String,
    /// SHA-256 of the file, where it is known.
    pub sha256: Option<String>,
    /// Number of rows.
    pub rows: usize,
    /// The time base, where one is known.
    pub time: Option<TimeBase>,
    /// Every column in order.
    pub columns: Vec<ColumnSummary>,
    /// What a person should know, one sentence each.
    pub warnings: Vec<String>,
    /// The text of a map to start from, for a table without `time_s` or with a column that seems
    /// to be a channel of another name.
    pub suggested_map: Option<String>,
}

/// The time base that rates refer to. Steps are those between rows with increasing stamps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeBase {
    /// The column.
    pub column: String,
    /// Seconds per unit of the column.
    pub unit_s: f64,
    /// Whether the column's name tells its unit; if not, it was taken as seconds.
    pub unit_stated: bool,
    /// From the first stamp to the last, in s.
    pub duration_s: f64,
    /// Median step, in s; absent for fewer than two stamps.
    pub period_s: Option<f64>,
    /// Shortest step, in s.
    pub shortest_step_s: Option<f64>,
    /// Longest step, in s.
    pub longest_step_s: Option<f64>,
    /// 95th percentile of the steps' distance from the median step, in s.
    pub jitter_s: Option<f64>,
    /// Rows without a stamp, or with one out of order.
    pub bad_stamps: usize,
}

impl TimeBase {
    /// The unit that the steps speak for, such as `ms`, and its seconds, where that is another one
    /// than was taken: one that the column's name does not tell, or seconds that are far too long.
    pub(crate) fn likely_unit(&self) -> Option<(&'static str, f64)> {
        let step = self.period_s? / self.unit_s;
        let is_likely = self.unit_stated && (self.unit_s != 1.0 || step <= LONG_STEP_S);
        suggest::likely_unit(step).filter(|_| !is_likely)
    }
}

/// What one column holds. Figures are absent where there is no value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColumnSummary {
    /// The name.
    pub name: String,
    /// The unit that the name tells, for a trial's channel.
    pub unit: Option<String>,
    /// Values that are no gaps.
    pub count: usize,
    /// Gaps.
    pub gaps: usize,
    /// Smallest value.
    pub min: Option<f64>,
    /// Median value.
    pub median: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
    /// Inverse of the median step between values, in Hz.
    pub rate_hz: Option<f64>,
    /// Whether there are values and all are equal.
    pub constant: bool,
    /// For a column of text, one of its cells.
    pub text: Option<String>,
}

/// Tells what a table holds. The time base is `time_column`, or else the first column that its
/// name or its date-time stamps give away; it serves the rates only, and converts nothing.
#[must_use]
pub fn inspect(table: &Table, time_column: Option<&str>) -> Inspection {
    let mut warnings = Vec::new();
    let guess = match time_column {
        None => suggest::guess_time(table).filter(|guess| {
            let rows: Vec<usize> = (0..table.len()).collect();
            let kept = increasing(&guess.column.values, &rows).rows.len();
            kept as f64 >= (1.0 - TOLERATED_DISORDER) * table.len() as f64
        }),
        Some(name) => {
            let column = table.column(name).filter(|column| !column.is_text());
            if column.is_none() {
                warnings.push(format!(
                    "no column of numbers is called {name:?}; rates are unknown"
                ));
            }
            column.map(|column| {
                suggest::time_of(column).unwrap_or(suggest::TimeGuess {
                    column,
                    scale_s: 1.0,
                    stated: false,
                })
            })
        }
    };
    let stamps_s: Option<Vec<f64>> = guess.as_ref().map(|guess| {
        guess
            .column
            .values
            .iter()
            .map(|t| t * guess.scale_s)
            .collect()
    });
    let clock = stamps_s.as_deref().map(Clock::of);
    let time = guess
        .zip(clock.as_ref())
        .map(|(guess, clock)| clock.base(guess.column.name.clone(), guess.scale_s, guess.stated));
    match &time {
        None => warnings.push("no time column was found".to_owned()),
        Some(base) => warn_of_time(base, &mut warnings),
    }
    if let (Some(base), Some(stamps_s)) = (&time, &stamps_s) {
        let mut jumps = Jumps::default();
        let scale = base
            .likely_unit()
            .map_or(1.0, |(_, unit_s)| unit_s / base.unit_s);
        for (row, stamp_s) in table.row_numbers.iter().zip(stamps_s) {
            jumps.push(*row, stamp_s * scale);
        }
        let median_s = base.period_s.unwrap_or(0.0) * scale;
        warnings.extend(jumps.told(&base.column, median_s));
    }
    let columns: Vec<ColumnSummary> = table
        .columns
        .iter()
        .map(|column| {
            let mut summary = summary(&column.name, &column.values, clock.as_ref());
            if let ColumnKind::Text { example } = &column.kind {
                summary.text = Some(example.clone());
                summary.gaps = 0;
            }
            summary
        })
        .collect();
    let suggested_map = suggest::map_text(&columns, time.as_ref());
    Inspection {
        path: table.path.clone(),
        sha256: Some(table.sha256.clone()),
        rows: table.len(),
        time,
        columns,
        warnings,
        suggested_map,
    }
}

/// Tells what a trial holds.
#[must_use]
pub fn inspect_trial(trial: &Trial) -> Inspection {
    let clock = Clock::of(trial.time_s());
    let time = clock.base(TIME_CHANNEL.to_owned(), 1.0, true);
    let (path, sha256) = match &trial.provenance().source {
        Source::File { path, sha256 } => (path.clone(), Some(sha256.clone())),
        _ => (trial.name().to_owned(), None),
    };
    let columns = std::iter::once((TIME_CHANNEL, trial.time_s()))
        .chain(trial.channels())
        .map(|(name, values)| {
            let mut summary = summary(name, values, Some(&clock));
            summary.unit = Some(unit_of(name).symbol().to_owned());
            summary
        })
        .collect();
    Inspection {
        path,
        sha256,
        rows: trial.len(),
        time: (!trial.is_empty()).then_some(time),
        columns,
        warnings: Vec::new(),
        suggested_map: None,
    }
}

struct Clock<'a> {
    time_s: &'a [f64],
    /// Rows with increasing stamps.
    rows: Vec<usize>,
}

impl<'a> Clock<'a> {
    fn of(time_s: &'a [f64]) -> Self {
        let all: Vec<usize> = (0..time_s.len()).collect();
        let rows = increasing(time_s, &all).rows;
        Self { time_s, rows }
    }

    /// Steps between the rows that `take` takes, in order of size.
    fn steps(&self, take: impl Fn(usize) -> bool) -> Vec<f64> {
        let rows: Vec<usize> = self.rows.iter().copied().filter(|&row| take(row)).collect();
        let mut steps: Vec<f64> = rows
            .windows(2)
            .map(|pair| self.time_s[pair[1]] - self.time_s[pair[0]])
            .collect();
        steps.sort_by(f64::total_cmp);
        steps
    }

    fn base(&self, column: String, unit_s: f64, unit_stated: bool) -> TimeBase {
        let steps = self.steps(|_| true);
        let period_s = median(&steps);
        let mut apart: Vec<f64> = steps
            .iter()
            .map(|step| (step - period_s.unwrap_or_default()).abs())
            .collect();
        apart.sort_by(f64::total_cmp);
        TimeBase {
            column,
            unit_s,
            unit_stated,
            duration_s: match (self.rows.first(), self.rows.last()) {
                (Some(&first), Some(&last)) => self.time_s[last] - self.time_s[first],
                _ => 0.0,
            },
            period_s,
            shortest_step_s: steps.first().copied(),
            longest_step_s: steps.last().copied(),
            jitter_s: apart
                .get((apart.len() * 95).div_ceil(100).saturating_sub(1))
                .copied(),
            bad_stamps: self.time_s.len() - self.rows.len(),
        }
    }
}

fn warn_of_time(base: &TimeBase, warnings: &mut Vec<String>) {
    match base.likely_unit() {
        Some((unit, unit_s)) => warnings.push(format!(
            "{:?} has a median step of {}, as if it were in {unit}; rates take it as seconds. In a map: time_s = '{}'",
            base.column,
            base.period_s.unwrap_or_default() / base.unit_s,
            suggest::scaled(&base.column, unit_s)
        )),
        None if !base.unit_stated => warnings.push(format!(
            "{:?} does not tell its unit; rates take it as seconds",
            base.column
        )),
        None => {}
    }
    if base.bad_stamps > 0 {
        warnings.push(format!(
            "{} rows of {:?} have no stamp or one out of order",
            base.bad_stamps, base.column
        ));
    }
}

fn summary(name: &str, values: &[f64], clock: Option<&Clock<'_>>) -> ColumnSummary {
    let mut known: Vec<f64> = values
        .iter()
        .copied()
        .filter(|value| !value.is_nan())
        .collect();
    known.sort_by(f64::total_cmp);
    let finite = |value: f64| value.is_finite().then_some(value);
    let step_s = clock.and_then(|clock| median(&clock.steps(|row| !values[row].is_nan())));
    ColumnSummary {
        name: name.to_owned(),
        unit: None,
        count: known.len(),
        gaps: values.len() - known.len(),
        min: known.first().copied().and_then(finite),
        median: median(&known).and_then(finite),
        max: known.last().copied().and_then(finite),
        rate_hz: step_s.map(f64::recip).and_then(finite),
        constant: known
            .first()
            .is_some_and(|first| known.last() == Some(first)),
        text: None,
    }
}

/// Of values in order.
fn median(sorted: &[f64]) -> Option<f64> {
    let upper = *sorted.get(sorted.len() / 2)?;
    if sorted.len().is_multiple_of(2) {
        let lower = sorted[sorted.len() / 2 - 1];
        return Some(lower / 2.0 + upper / 2.0);
    }
    Some(upper)
}
