//! Extracts the columns that maps name, in the same pass that surveys the topics.

use super::log::is_alike;
use super::resets::RESET_S;
use super::sink::{Layout, Sink, Wanted};
use super::survey::{Surveyor, key};
use crate::limits::{self, Excess};
use crate::map::Rule;
use sindy_expr::{Program, Scratch};
use std::collections::{BTreeMap, BTreeSet};

/// Values, stored exactly in the smallest possible type.
#[derive(Debug, Clone)]
pub(super) enum Values {
    /// All are numbers of single precision, as most sensor values.
    Narrow(Vec<f32>),
    Wide(Vec<f64>),
}

impl Default for Values {
    fn default() -> Self {
        Self::Narrow(Vec::new())
    }
}

impl Values {
    #[inline]
    pub(super) fn push(&mut self, value: f64) {
        match self {
            Self::Narrow(values) => {
                let narrow = value as f32;
                if f64::from(narrow) == value || value.is_nan() {
                    values.push(narrow);
                } else {
                    let mut wide: Vec<f64> = Vec::with_capacity(values.capacity());
                    wide.extend(values.iter().map(|&value| f64::from(value)));
                    wide.push(value);
                    *self = Self::Wide(wide);
                }
            }
            Self::Wide(values) => values.push(value),
        }
    }

    /// Gaps up to this length.
    fn pad(&mut self, length: usize) {
        match self {
            Self::Narrow(values) => values.resize(length, f32::NAN),
            Self::Wide(values) => values.resize(length, f64::NAN),
        }
    }

    #[inline]
    pub(super) fn get(&self, row: usize) -> f64 {
        match self {
            Self::Narrow(values) => values[row].into(),
            Self::Wide(values) => values[row],
        }
    }

    /// Whether all values are finite.
    pub(super) fn is_finite(&self) -> bool {
        match self {
            Self::Narrow(values) => values.iter().all(|value| value.is_finite()),
            Self::Wide(values) => values.iter().all(|value| value.is_finite()),
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Narrow(values) => values.len(),
            Self::Wide(values) => values.len(),
        }
    }

    /// The values of these rows.
    pub(super) fn pick(&self, rows: &[usize]) -> Self {
        match self {
            Self::Narrow(values) => Self::Narrow(rows.iter().map(|&row| values[row]).collect()),
            Self::Wide(values) => Self::Wide(rows.iter().map(|&row| values[row]).collect()),
        }
    }
}

/// Messages of one topic: stamps and the columns wanted, in the order of the file.
#[derive(Debug, Clone, Default)]
pub(super) struct Series {
    pub(super) time_s: Vec<f64>,
    pub(super) fields: Vec<String>,
    pub(super) columns: Vec<Values>,
    /// Number of messages without a stamp, which are dropped.
    pub(super) absent: usize,
    /// Number of messages at each time when the stamps of any topic went far back. These times are
    /// the same for all topics.
    pub(super) breaks: Vec<usize>,
    /// Number of messages when the stamps were last shifted.
    pub(super) settled: usize,
}

/// Largest number of steps back for which all topics are examined. It bounds the time for a
/// damaged file; a real log has a few restarts.
const MOST_BREAKS: usize = 256;

impl Series {
    /// Drops the messages that a rule of `valid` excludes (0 or NaN) and returns their number. The
    /// rule is the first one whose names are all fields of the topic; `field` returns the field of a
    /// name.
    ///
    /// # Errors
    /// The first rule and its first unknown name, if every rule has an unknown name.
    pub(super) fn keep<'r>(
        &mut self,
        rules: &'r [Rule],
        field: &dyn Fn(&str) -> Option<String>,
    ) -> Result<usize, (&'r Rule, &'r str)> {
        let place = |name: &str| {
            let field = field(name)?;
            self.fields.iter().position(|known| *known == field)
        };
        let lacks = |rule: &'r Rule| {
            let names = rule.expr.variables();
            names.into_iter().find(|name| place(name).is_none())
        };
        let Some(rule) = rules.iter().find(|rule| lacks(rule).is_none()) else {
            let fault = rules.first().and_then(|rule| Some((rule, lacks(rule)?)));
            return fault.map_or(Ok(0), Err);
        };
        let names = rule.expr.variables();
        let places: Vec<usize> = names.iter().filter_map(|name| place(name)).collect();
        let Ok(program) = Program::compile(std::slice::from_ref(&rule.expr), &names) else {
            return Ok(0);
        };
        let (mut input, mut scratch) = (vec![0.0; places.len()], Scratch::new());
        let mut kept = Vec::with_capacity(self.time_s.len());
        for row in 0..self.time_s.len() {
            for (value, &place) in input.iter_mut().zip(&places) {
                *value = self.columns[place].get(row);
            }
            let mut valid = [0.0];
            program.eval_row(&input, &mut valid, &mut scratch);
            if valid[0] != 0.0 && !valid[0].is_nan() {
                kept.push(row);
            }
        }
        let left_out = self.time_s.len() - kept.len();
        if left_out > 0 {
            self.pick(&kept);
        }
        Ok(left_out)
    }

    /// Drops all other messages.
    pub(super) fn pick(&mut self, rows: &[usize]) {
        self.time_s = rows.iter().map(|&row| self.time_s[row]).collect();
        for column in &mut self.columns {
            *column = column.pick(rows);
        }
    }
}

/// Collects all columns that the names may mean, and surveys the topics.
pub(super) struct Extractor<'a> {
    surveyor: Surveyor,
    /// Names such as `topic.field`, at every dot.
    fields: BTreeSet<(&'a str, &'a str)>,
    /// Topics whose stamps are always collected.
    clocks: BTreeSet<&'a str>,
    keys: Vec<String>,
    series: Vec<Series>,
    /// By the reader's number.
    plans: Vec<Option<Plan>>,
    /// Bytes of the values so far, and how many they may be.
    bytes: u64,
    most_bytes: u64,
}

struct Plan {
    series: usize,
    /// The column of each value that the reader passes on.
    columns: Vec<usize>,
}

impl<'a> Extractor<'a> {
    pub(super) fn new(
        names: impl Iterator<Item = &'a str>,
        clocks: impl Iterator<Item = &'a str>,
        file_bytes: u64,
    ) -> Self {
        let split = |name: &'a str| {
            let dots = name.match_indices('.');
            dots.map(move |(dot, _)| (&name[..dot], &name[dot + 1..]))
        };
        Self {
            surveyor: Surveyor::new(false),
            fields: names.flat_map(split).collect(),
            clocks: clocks.collect(),
            keys: Vec::new(),
            series: Vec::new(),
            plans: Vec::new(),
            bytes: 0,
            most_bytes: limits::memory(file_bytes),
        }
    }

    /// The topics, and the columns by the topic's key.
    pub(super) fn finish(self) -> (Surveyor, BTreeMap<String, Series>) {
        (
            self.surveyor,
            self.keys.into_iter().zip(self.series).collect(),
        )
    }
}

impl Sink for Extractor<'_> {
    fn topic(&mut self, id: usize, layout: &Layout) -> Wanted {
        let seen = self.surveyor.topic(id, layout);
        let key = key(&layout.name, layout.instance);
        let mut named: BTreeSet<&str> = BTreeSet::new();
        let (mut last, mut alike) = ("", false);
        for &(topic, field) in &self.fields {
            if topic != last {
                (last, alike) = (topic, is_alike(&key, &layout.kind, topic));
            }
            if alike {
                named.insert(field);
            }
        }
        self.plans
            .resize_with(self.plans.len().max(id + 1), || None);
        self.plans[id] = None;
        let fields = layout.fields.iter().enumerate();
        // The first of several fields with one name counts.
        let fields: Vec<(usize, &String)> = fields
            .filter(|(_, field)| named.remove(field.as_str()))
            .collect();
        let is_clock = |clock: &&str| is_alike(&key, &layout.kind, clock);
        if fields.is_empty() && !self.clocks.iter().any(is_clock) {
            return seen;
        }
        let place = self.keys.iter().position(|known| *known == key);
        let series = place.unwrap_or_else(|| {
            let breaks = vec![0; self.series.first().map_or(0, |other| other.breaks.len())];
            self.keys.push(key);
            self.series.push(Series {
                breaks,
                ..Series::default()
            });
            self.keys.len() - 1
        });
        let known = &mut self.series[series];
        let column = |name: &String| {
            let place = known.fields.iter().position(|field| field == name);
            place.unwrap_or_else(|| {
                let mut before = Values::default();
                before.pad(known.time_s.len());
                known.fields.push(name.clone());
                known.columns.push(before);
                known.fields.len() - 1
            })
        };
        let (wanted, names): (Vec<usize>, Vec<&String>) = fields.into_iter().unzip();
        let columns = names.into_iter().map(column).collect();
        self.plans[id] = Some(Plan { series, columns });
        Wanted::Fields(wanted)
    }

    fn message(&mut self, id: usize, stamp_ns: Option<i64>, values: &[f64]) {
        self.surveyor.message(id, stamp_ns, &[]);
        let Some(Some(plan)) = self.plans.get(id) else {
            return;
        };
        let Some(stamp_ns) = stamp_ns else {
            self.series[plan.series].absent += 1;
            return;
        };
        let numbers = 1 + self.series[plan.series].columns.len();
        self.bytes += (numbers * size_of::<f64>()) as u64;
        if self.bytes > self.most_bytes {
            return;
        }
        let stamp_s = stamp_ns as f64 * 1e-9;
        let latest = self.series[plan.series].time_s.last();
        if latest.is_some_and(|&latest_s| stamp_s < latest_s - RESET_S) {
            let all = self.series.iter_mut();
            for any in all.filter(|any| any.breaks.len() < MOST_BREAKS) {
                any.breaks.push(any.time_s.len());
            }
        }
        let series = &mut self.series[plan.series];
        series.time_s.push(stamp_s);
        for (&column, &value) in plan.columns.iter().zip(values) {
            series.columns[column].push(value);
        }
        // Fields that this message lacks are gaps.
        if values.len() < series.columns.len() {
            for column in &mut series.columns {
                column.pad(series.time_s.len());
            }
        }
    }

    fn shift(&mut self, ids: &[usize], by_ns: i64) {
        self.surveyor.shift(ids, by_ns);
        let plans = ids.iter().filter_map(|&id| self.plans.get(id)?.as_ref());
        // Several may be of one topic.
        let series: BTreeSet<usize> = plans.map(|plan| plan.series).collect();
        for place in series {
            let series = &mut self.series[place];
            let time_s = &mut series.time_s[series.settled..];
            time_s.iter_mut().for_each(|t| *t += by_ns as f64 * 1e-9);
            series.settled = series.time_s.len();
        }
    }

    fn parameter(&mut self, name: &str, value: f64) {
        self.surveyor.parameter(name, value);
    }

    fn excess(&self) -> Option<Excess> {
        (self.bytes > self.most_bytes).then(|| limits::too_many_values(self.most_bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_values_stay_exact() {
        let mut values = Values::default();
        for value in [1.5, f64::NAN, -0.0, f64::INFINITY] {
            values.push(value);
        }
        assert!(matches!(values, Values::Narrow(_)));
        values.push(0.1);
        values.pad(6);
        assert!(matches!(values, Values::Wide(_)));
        let all: Vec<f64> = (0..values.len()).map(|row| values.get(row)).collect();
        assert_eq!(format!("{all:?}"), "[1.5, NaN, -0.0, inf, 0.1, NaN]");
        assert_eq!(values.pick(&[4, 0]).get(1), 1.5);
    }

    #[test]
    fn regress_fields_of_one_name_and_sources_of_one_topic() {
        let layout = |fields: &[&str]| Layout {
            name: "t".to_owned(),
            fields: fields.iter().map(|&field| field.to_owned()).collect(),
            ..Layout::default()
        };
        let names = ["t.a", "t.b", "t.c"];
        let mut extractor = Extractor::new(names.into_iter(), std::iter::empty(), 1000);
        let wanted = extractor.topic(0, &layout(&["c", "b", "a"]));
        assert_eq!(wanted, Wanted::Fields(vec![0, 1, 2]));
        extractor.message(0, Some(0), &[3.0, 2.0, 1.0]);
        // As many values as there are columns, if one counted twice.
        let wanted = extractor.topic(1, &layout(&["a", "a", "b"]));
        assert_eq!(wanted, Wanted::Fields(vec![0, 2]));
        extractor.message(1, Some(1_000_000_000), &[1.0, 2.0]);
        let (_, series) = extractor.finish();
        let series = &series["t"];
        let columns: Vec<Vec<f64>> = series
            .columns
            .iter()
            .map(|values| (0..values.len()).map(|row| values.get(row)).collect())
            .collect();
        assert_eq!(series.fields, ["c", "b", "a"]);
        assert_eq!(
            format!("{columns:?}"),
            "[[3.0, NaN], [2.0, 2.0], [1.0, 1.0]]"
        );
    }
}
