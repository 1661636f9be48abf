//! Counts and samples of columns, part by part in bounded memory.

use super::jumps::Jumps;
use super::sample::{Sample, median};
use super::{ColumnSummary, TimeBase};
use crate::tables::stamps::Restarts;
use crate::{Column, ColumnKind};
use touchdown_trial::TIME_CHANNEL;

/// Largest number of values in the samples of all columns: 32 MB, and as much for steps.
const MOST_VALUES: usize = 1 << 22;
/// Largest number of values in the sample of one column: the standard error of its median is 0.5 %
/// of the spread.
const MOST_OF_ONE: usize = 1 << 16;

/// A column's next values.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) name: &'a str,
    pub(crate) values: &'a [f64],
    /// One of the cells of a column of text.
    pub(crate) text: Option<&'a str>,
    /// The cell in a row of units.
    pub(crate) unit: Option<&'a str>,
}

impl<'a> View<'a> {
    pub(crate) fn of(column: &'a Column) -> Self {
        Self {
            name: &column.name,
            values: &column.values,
            unit: column.unit(),
            text: match &column.kind {
                ColumnKind::Text { example } => Some(example),
                _ => None,
            },
        }
    }
}

/// The column that is the time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TimeColumn {
    pub(crate) name: String,
    pub(crate) unit_s: f64,
    pub(crate) stated: bool,
    /// The warning, if it is a guess.
    pub(crate) guess: Option<&'static str>,
}

pub(crate) struct Tally {
    pub(crate) rows: usize,
    columns: Vec<Counted>,
    time: Option<TimeColumn>,
    clock: Option<Clock>,
}

/// Counts of one column so far.
struct Counted {
    name: String,
    unit: Option<String>,
    text: Option<String>,
    count: usize,
    gaps: usize,
    ends: Option<(f64, f64)>,
    values: Sample,
    steps: Steps,
}

/// Steps between stamps that come after each other.
struct Steps {
    last_s: Option<f64>,
    sample: Sample,
    ends_s: Option<(f64, f64)>,
}

impl Steps {
    /// Whether the stamp comes after the one before it.
    fn push(&mut self, stamp_s: f64) -> bool {
        let Some(last_s) = self.last_s.replace(stamp_s) else {
            return true;
        };
        let step_s = stamp_s - last_s;
        if step_s > 0.0 {
            self.sample.push(step_s);
            widen(&mut self.ends_s, step_s);
        }
        step_s > 0.0
    }
}

/// The time base so far, and its jumps in the assumed unit and in other possible units.
struct Clock {
    steps: Steps,
    ends_s: Option<(f64, f64)>,
    bad: usize,
    jumps: Vec<(f64, Jumps)>,
    restarts: Restarts,
}

fn widen(ends: &mut Option<(f64, f64)>, value: f64) {
    let (least, most) = ends.get_or_insert((value, value));
    (*least, *most) = (least.min(value), most.max(value));
}

impl Tally {
    pub(crate) fn new(time: Option<TimeColumn>) -> Self {
        Self {
            rows: 0,
            columns: Vec::new(),
            time,
            clock: None,
        }
    }

    /// Adds rows; `numbers` are their row numbers in the file.
    pub(crate) fn part(&mut self, columns: &[View<'_>], numbers: &[usize]) {
        let first = self.columns.is_empty();
        let most = (MOST_VALUES / columns.len().max(1)).clamp(16, MOST_OF_ONE);
        let steps = || Steps {
            last_s: None,
            sample: Sample::new(most),
            ends_s: None,
        };
        let named = |time: &TimeColumn| {
            let column = columns.iter().find(|column| column.name == time.name);
            column.map(|column| (column.values, time.unit_s))
        };
        let stamps_s: Option<Vec<f64>> =
            self.time.as_ref().and_then(named).map(|(values, unit_s)| {
                let clock = self.clock.get_or_insert_with(|| Clock {
                    steps: steps(),
                    ends_s: None,
                    bad: 0,
                    jumps: [1.0, 1e-3, 1e-6, 1e-9]
                        .map(|scale| (scale, Jumps::default()))
                        .into(),
                    restarts: Restarts::default(),
                });
                let stamps = values.iter().zip(numbers);
                stamps
                    .map(|(value, &row)| clock.push(row, value * unit_s))
                    .collect()
            });
        for (at, column) in columns.iter().enumerate() {
            let known = if first {
                None
            } else {
                self.place(at, column.name)
            };
            let place = known.unwrap_or_else(|| {
                self.columns.push(Counted {
                    name: column.name.to_owned(),
                    unit: column.unit.map(str::to_owned),
                    text: None,
                    count: 0,
                    gaps: self.rows,
                    ends: None,
                    values: Sample::new(most),
                    steps: steps(),
                });
                self.columns.len() - 1
            });
            let counted = &mut self.columns[place];
            if let Some(text) = column.text {
                let there = counted.text.as_ref().is_some_and(|known| !known.is_empty());
                if !there {
                    counted.text = Some(text.to_owned());
                }
                counted.gaps = 0;
                continue;
            }
            counted.push(column.values, stamps_s.as_deref());
        }
        self.rows += numbers.len();
    }

    /// The place of a column that is the `at`th of its part. Parts of one table have the same columns, but for
    /// a last one without a name.
    fn place(&self, at: usize, name: &str) -> Option<usize> {
        let is_there = self
            .columns
            .get(at)
            .is_some_and(|column| column.name == name);
        let search = || self.columns.iter().position(|column| column.name == name);
        is_there.then_some(at).or_else(search)
    }

    /// The time base, if there is one, and the warnings of its restarts and jumps.
    pub(crate) fn time(&self) -> Option<(TimeBase, Vec<String>)> {
        let (time, clock) = (self.time.as_ref()?, self.clock.as_ref()?);
        let sorted = clock.steps.sample.sorted();
        let period_s = median(&sorted);
        let mut apart: Vec<f64> = sorted
            .iter()
            .map(|step| (step - period_s.unwrap_or_default()).abs())
            .collect();
        apart.sort_by(f64::total_cmp);
        let base = TimeBase {
            column: time.name.clone(),
            unit_s: time.unit_s,
            unit_stated: time.stated,
            duration_s: clock.ends_s.map_or(0.0, |(first, last)| last - first),
            period_s,
            shortest_step_s: clock.steps.ends_s.map(|(shortest, _)| shortest),
            longest_step_s: clock.steps.ends_s.map(|(_, longest)| longest),
            jitter_s: apart
                .get((apart.len() * 95).div_ceil(100).saturating_sub(1))
                .copied(),
            bad_stamps: clock.bad,
            stamps: self.rows - clock.bad.min(self.rows),
            largest: clock.ends_s.map_or(0.0, |(_, last)| last / time.unit_s),
            guess: time.guess,
        };
        let scale = base
            .likely_unit()
            .map_or(1.0, |likely| likely.unit_s / base.unit_s);
        let jumps = clock.jumps.iter().find(|(of, _)| *of == scale);
        let median_s = period_s.unwrap_or_default() * scale;
        let jumps = jumps.and_then(|(_, jumps)| jumps.warning(&time.name, median_s));
        // Rows of a table with our own time are dropped, and the findings of that have the warning.
        let restarts = clock.restarts.warning(&format!("{:?}", time.name));
        let restarts = restarts.filter(|_| time.name != TIME_CHANNEL);
        Some((base, restarts.into_iter().chain(jumps).collect()))
    }

    /// Every column in order; without a time there are no rates.
    pub(crate) fn columns(&self, has_time: bool) -> Vec<ColumnSummary> {
        let finite = |value: f64| value.is_finite().then_some(value);
        let summary = |counted: &Counted| ColumnSummary {
            name: counted.name.clone(),
            unit: counted.unit.clone(),
            count: counted.count,
            gaps: counted.gaps,
            min: counted.ends.and_then(|(min, _)| finite(min)),
            median: median(&counted.values.sorted()).and_then(finite),
            max: counted.ends.and_then(|(_, max)| finite(max)),
            rate_hz: median(&counted.steps.sample.sorted())
                .filter(|_| has_time)
                .map(f64::recip)
                .and_then(finite),
            constant: counted.ends.is_some_and(|(min, max)| min == max),
            text: counted.text.clone(),
        };
        self.columns.iter().map(summary).collect()
    }
}

impl Counted {
    fn push(&mut self, values: &[f64], stamps_s: Option<&[f64]>) {
        for (row, &value) in values.iter().enumerate() {
            if value.is_nan() {
                self.gaps += 1;
                continue;
            }
            self.count += 1;
            widen(&mut self.ends, value);
            self.values.push(value);
            if let Some(stamp_s) = stamps_s.map(|stamps_s| stamps_s[row])
                && !stamp_s.is_nan()
            {
                self.steps.push(stamp_s);
            }
        }
    }
}

impl Clock {
    /// Adds a stamp. Returns it, or NaN if it is out of order.
    fn push(&mut self, row: usize, stamp_s: f64) -> f64 {
        if !stamp_s.is_finite() {
            self.bad += 1;
            return f64::NAN;
        }
        widen(&mut self.ends_s, stamp_s);
        self.bad += usize::from(!self.steps.push(stamp_s));
        self.restarts.push(row, stamp_s);
        for (scale, jumps) in &mut self.jumps {
            jumps.push(row, stamp_s * *scale);
        }
        stamp_s
    }
}
