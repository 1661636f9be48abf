use super::recognise;
use super::suggest;
use super::tally::{Tally, TimeColumn, View};
use super::time_column::{LikelyUnit, is_ambiguous, is_slow, likely_unit, time_among, time_of};
use crate::{Column, Table};
use serde::Serialize;
use touchdown_trial::{Source, TIME_CHANNEL, Trial, unit_of};

/// Largest share of stamps out of order in a time column. In a column with more than half
/// out of order, the rates that follow from it have no meaning.
const TOLERATED_DISORDER: f64 = 0.5;

/// Rows of a trial that are summarised at once. The value affects only speed.
const PART: usize = 1 << 16;

/// Summary of a table or a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// The file, or the trial's name.
    pub path: String,
    /// SHA-256 of the file, if known.
    pub sha256: Option<String>,
    /// Number of rows.
    pub rows: usize,
    /// The time base, if known.
    pub time: Option<TimeBase>,
    /// Every column in order.
    pub columns: Vec<ColumnSummary>,
    /// Warnings, one sentence each.
    pub warnings: Vec<String>,
    /// The text of a map to start from, for a table without `time_s` or with a column that seems
    /// to be a channel of another name.
    pub suggested_map: Option<String>,
}

/// The time base of the rates. A step leads from a stamp to a later one in the next row that
/// has one. With more than 65,536 steps, median and percentile are those of a random sample of
/// that size.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeBase {
    /// The column.
    pub column: String,
    /// Seconds per unit of the column.
    pub unit_s: f64,
    /// Whether the column's name states its unit; if not, seconds were assumed.
    pub unit_stated: bool,
    /// From the lowest stamp to the highest, in s.
    pub duration_s: f64,
    /// Median step, in s; absent for fewer than two stamps.
    pub period_s: Option<f64>,
    /// Shortest step, in s.
    pub shortest_step_s: Option<f64>,
    /// Longest step, in s.
    pub longest_step_s: Option<f64>,
    /// 95th percentile of the steps' distance from the median step, in s.
    pub jitter_s: Option<f64>,
    /// Rows without a stamp, or whose stamp is not after the previous one.
    pub bad_stamps: usize,
    /// Number of good stamps.
    #[serde(skip)]
    pub(crate) stamps: usize,
    /// Largest stamp, in units of the column.
    #[serde(skip)]
    pub(crate) largest: f64,
    /// The warning, if the column is a guess.
    #[serde(skip)]
    pub(crate) guess: Option<&'static str>,
}

impl TimeBase {
    /// The unit that the stamps suggest, such as ms, if it differs from the assumed one: the
    /// column's name states no unit, or states seconds that are far too long.
    pub(crate) fn likely_unit(&self) -> Option<LikelyUnit> {
        let step = self.period_s? / self.unit_s;
        let is_likely = self.unit_stated && (self.unit_s != 1.0 || !is_slow(step, self.stamps));
        likely_unit(step, self.largest).filter(|_| !is_likely && !self.is_ambiguous())
    }

    /// Whether seconds and milliseconds are both likely: the column's name states no unit.
    pub(crate) fn is_ambiguous(&self) -> bool {
        let step = self.period_s.map(|period_s| period_s / self.unit_s);
        !self.unit_stated && step.is_some_and(|step| is_ambiguous(step, self.largest))
    }
}

/// Summary of one column; figures are absent without values. With more than 65,536 values (fewer
/// if there are more than 64 columns), medians are those of a random sample of that size.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColumnSummary {
    /// The name.
    pub name: String,
    /// The unit that the name of a trial's channel states, or a row of units below the header of a table.
    pub unit: Option<String>,
    /// Number of values that are not gaps.
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

/// Summarises a table. The time base is `time_column`, or else the first column that its name or
/// its date-time stamps identify, or one that increases as time does. It only serves the rates;
/// no values are converted.
#[must_use]
pub fn inspect(table: &Table, time_column: Option<&str>) -> Inspection {
    let mut looking = Inspector::new(time_column);
    looking.part(&table.columns, &table.row_numbers);
    looking.finish(&table.path, Some(table.sha256.clone()))
}

/// Summary of a table that is read in parts.
pub(crate) struct Inspector<'a> {
    time_column: Option<&'a str>,
    tally: Option<Tally>,
}

impl<'a> Inspector<'a> {
    pub(crate) fn new(time_column: Option<&'a str>) -> Self {
        Self {
            time_column,
            tally: None,
        }
    }

    /// The next rows. The first ones decide which column is the time.
    pub(crate) fn part(&mut self, columns: &[Column], row_numbers: &[usize]) {
        let tally = self.tally.get_or_insert_with(|| {
            let time = match self.time_column {
                None => time_among(columns, row_numbers),
                Some(name) => columns
                    .iter()
                    .find(|column| column.name == name && !column.is_text())
                    .map(|column| {
                        time_of(column).unwrap_or(TimeColumn {
                            name: name.to_owned(),
                            unit_s: 1.0,
                            stated: false,
                            guess: None,
                        })
                    }),
            };
            Tally::new(time)
        });
        let views: Vec<View<'_>> = columns.iter().map(View::of).collect();
        tally.part(&views, row_numbers);
    }

    pub(crate) fn finish(self, path: &str, sha256: Option<String>) -> Inspection {
        let mut warnings = Vec::new();
        let tally = self.tally.unwrap_or_else(|| Tally::new(None));
        let found = tally.time().filter(|(base, _)| {
            let most = TOLERATED_DISORDER * tally.rows as f64;
            self.time_column.is_some() || base.bad_stamps as f64 <= most
        });
        if let (Some(name), None) = (self.time_column, &found) {
            warnings.push(format!(
                "no column of numbers is called {name:?}; rates are unknown"
            ));
        }
        match &found {
            None => warnings.push("no time column was found".to_owned()),
            Some((base, jumps)) => {
                warn_of_time(base, &mut warnings);
                warnings.extend(jumps.iter().cloned());
            }
        }
        let time = found.map(|(base, _)| base);
        let columns = tally.columns(time.is_some());
        let guesses = recognise::channels(&columns);
        warnings.extend(suggest::questions(&columns, &guesses));
        let suggested_map = suggest::map_text(&columns, &guesses, time.as_ref());
        Inspection {
            path: path.to_owned(),
            sha256,
            rows: tally.rows,
            time,
            columns,
            warnings,
            suggested_map,
        }
    }
}

/// Summarises a trial.
#[must_use]
pub fn inspect_trial(trial: &Trial) -> Inspection {
    let mut tally = Tally::new(Some(TimeColumn {
        name: TIME_CHANNEL.to_owned(),
        unit_s: 1.0,
        stated: true,
        guess: None,
    }));
    // Part by part, which does not copy the stamps of a long trial.
    for first in (0..trial.len().max(1)).step_by(PART) {
        let rows: Vec<usize> = (first..trial.len().min(first + PART)).collect();
        let channels = std::iter::once((TIME_CHANNEL, trial.time_s())).chain(trial.channels());
        let views: Vec<View<'_>> = channels
            .map(|(name, values)| View {
                name,
                values: &values[first..first + rows.len()],
                text: None,
                unit: None,
            })
            .collect();
        tally.part(&views, &rows);
    }
    let (path, sha256) = match &trial.provenance().source {
        Source::File { path, sha256 } => (path.clone(), Some(sha256.clone())),
        _ => (trial.name().to_owned(), None),
    };
    let mut columns = tally.columns(true);
    for column in &mut columns {
        column.unit = Some(unit_of(&column.name).symbol().to_owned());
    }
    Inspection {
        path,
        sha256,
        rows: trial.len(),
        time: tally
            .time()
            .filter(|_| !trial.is_empty())
            .map(|(base, _)| base),
        columns,
        warnings: Vec::new(),
        suggested_map: None,
    }
}

fn warn_of_time(base: &TimeBase, warnings: &mut Vec<String>) {
    if let Some(guess) = base.guess {
        warnings.push(format!("{:?} is taken as the time: {guess}", base.column));
    }
    match base.likely_unit() {
        Some(LikelyUnit {
            name: unit, unit_s, ..
        }) => warnings.push(format!(
            "{:?} has a median step of {}, which suggests {unit}; rates assume seconds. In a map: time_s = '{}'",
            base.column,
            base.period_s.unwrap_or_default() / base.unit_s,
            suggest::scaled(&base.column, unit_s)
        )),
        None if base.is_ambiguous() => warnings.push(format!(
            "{:?} does not state its unit, and a median step of {} may be s or ms; rates assume seconds. A map needs your answer",
            base.column,
            base.period_s.unwrap_or_default() / base.unit_s
        )),
        None if !base.unit_stated => warnings.push(format!(
            "{:?} does not state its unit; rates assume seconds",
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
