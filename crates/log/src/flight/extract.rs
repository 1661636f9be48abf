//! The columns of a log that a map names: a second pass.

use super::sink::{Layout, Sink, Wanted};
use super::survey::key;
use std::collections::{BTreeMap, HashMap};

/// Messages of one topic: stamps and the columns wanted, in the order of the file.
#[derive(Debug, Clone, Default)]
pub(super) struct Series {
    pub(super) time_s: Vec<f64>,
    pub(super) columns: Vec<Vec<f64>>,
    /// Messages without a stamp, which are left out.
    pub(super) absent: usize,
}

/// Collects columns.
pub(super) struct Extractor<'a> {
    /// Fields by the topic's key.
    wanted: &'a BTreeMap<String, Vec<String>>,
    series: BTreeMap<String, Series>,
    by_id: HashMap<usize, Plan>,
}

struct Plan {
    key: String,
    /// For each value handed over, its column.
    columns: Vec<usize>,
}

impl<'a> Extractor<'a> {
    pub(super) fn new(wanted: &'a BTreeMap<String, Vec<String>>) -> Self {
        let series = wanted.iter().map(|(key, fields)| {
            let columns = vec![Vec::new(); fields.len()];
            (
                key.clone(),
                Series {
                    columns,
                    ..Series::default()
                },
            )
        });
        Self {
            wanted,
            series: series.collect(),
            by_id: HashMap::new(),
        }
    }

    pub(super) fn finish(self) -> BTreeMap<String, Series> {
        self.series
    }
}

impl Sink for Extractor<'_> {
    fn topic(&mut self, id: usize, layout: &Layout) -> Wanted {
        let key = key(&layout.name, layout.instance);
        let Some(wanted) = self.wanted.get(&key) else {
            return Wanted::Nothing;
        };
        let place = |name: &String| layout.fields.iter().position(|field| field == name);
        let (fields, columns) = wanted
            .iter()
            .enumerate()
            .filter_map(|(column, name)| Some((place(name)?, column)))
            .unzip();
        self.by_id.insert(id, Plan { key, columns });
        Wanted::Fields(fields)
    }

    fn message(&mut self, id: usize, stamp_ns: Option<i64>, values: &[f64]) {
        let Some(plan) = self.by_id.get(&id) else {
            return;
        };
        let Some(series) = self.series.get_mut(&plan.key) else {
            return;
        };
        let Some(stamp_ns) = stamp_ns else {
            series.absent += 1;
            return;
        };
        series.time_s.push(stamp_ns as f64 * 1e-9);
        for (&column, &value) in plan.columns.iter().zip(values) {
            series.columns[column].push(value);
        }
        // Fields that this message lacks are gaps.
        if values.len() < series.columns.len() {
            for column in &mut series.columns {
                column.resize(series.time_s.len(), f64::NAN);
            }
        }
    }

    fn parameter(&mut self, _: &str, _: f64) {}
}
