//! From tables to trajectories: which columns are what, which rows belong together, what is wrong with them.

pub(crate) mod past;
pub(crate) mod rates;
mod read;
pub(crate) mod velocities;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::table::{TableArgs, find, without_unit};
pub(crate) use read::read;

/// Largest part of a trajectory's rows that may be dropped for their time.
pub(crate) const TOLERATED: f64 = 0.01;

/// Names of a time column that are recognised, and those that are recognised where none of the former is there.
pub(crate) const TIME_NAMES: [&[&str]; 2] = [
    &["t", "time", "time_s"],
    &["t_s", "timestamp", "timestamp_s"],
];

/// What asks for a column that is an input.
const INPUTS: [&str; 2] = ["--inputs", "an input of the model"];

/// The columns to read.
pub(crate) struct WantedColumns<'a> {
    /// States, then inputs, each with the argument that asks for it.
    pub(crate) columns: Vec<(&'a str, &'static str)>,
    /// A column of weights.
    pub(crate) weights: Option<&'a str>,
    /// How time and trajectories are found.
    pub(crate) table: &'a TableArgs,
}

/// Rows that belong together, in the order of time.
#[derive(Clone, Debug)]
pub(crate) struct Trajectory {
    pub(crate) name: String,
    pub(crate) time: Vec<f64>,
    /// As wanted; NaN where a cell is empty.
    pub(crate) columns: Vec<Vec<f64>>,
    pub(crate) weights: Option<Vec<f64>>,
    /// Whether values between the samples of a column were filled in: slopes of these say nothing.
    pub(crate) filled: bool,
}

/// Counts of a file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileReport {
    pub(crate) path: String,
    /// Rows in the file.
    pub(crate) rows_read: usize,
    /// Rows in the trajectories.
    pub(crate) rows_used: usize,
    /// Rows that are corrupt or broken off, or whose time is absent, repeated or out of order.
    pub(crate) rows_dropped: usize,
    /// Empty cells of the columns that are used.
    pub(crate) empty_cells: BTreeMap<String, usize>,
    /// The column that time came from.
    pub(crate) time: Option<String>,
    pub(crate) trajectories: Vec<String>,
    pub(crate) warnings: Vec<String>,
    /// Whether input was lost.
    pub(crate) lossy: bool,
}

impl FileReport {
    /// Of a file of which nothing is known yet.
    pub(crate) fn new(path: String) -> Self {
        Self {
            path,
            rows_read: 0,
            rows_used: 0,
            rows_dropped: 0,
            empty_cells: BTreeMap::new(),
            time: None,
            trajectories: Vec::new(),
            warnings: Vec::new(),
            lossy: false,
        }
    }
}

/// Says which names of a column of times are states already.
fn taken_names(names: &[String], wanted: &WantedColumns<'_>) -> String {
    let known = || TIME_NAMES.iter().copied().flatten();
    let is_time = |name: &str| known().any(|t| t.eq_ignore_ascii_case(name));
    let have = |name: &str| names.iter().any(|n| n == name);
    let taken = wanted.columns.iter().find(|(c, _)| is_time(c) && have(c));
    taken.map_or_else(String::new, |(name, why)| {
        format!(", of which {why} takes `{name}`")
    })
}

/// The column of times; `None` where the rows are equally spaced by `--dt`.
pub(crate) fn time_column(
    at: &str,
    names: &[String],
    wanted: &WantedColumns<'_>,
) -> Result<Option<usize>> {
    if let Some(name) = &wanted.table.time {
        return find(at, names, name, "--time").map(Some);
    }
    if wanted.table.dt.is_some() {
        return Ok(None);
    }
    let taken = |name: &str, by_inputs: bool| {
        let by = |why: &str| by_inputs || !INPUTS.contains(&why);
        let mut all = wanted.columns.iter().filter(|(_, why)| by(why));
        all.any(|(c, _)| *c == name || without_unit(name) == Some(*c))
    };
    let among = |known: &[&str], by_inputs: bool| -> Vec<usize> {
        let is_time = |name: &String| {
            let bare = without_unit(name).unwrap_or(name);
            !taken(name, by_inputs) && known.iter().any(|t| bare.eq_ignore_ascii_case(t))
        };
        (0..names.len()).filter(|&p| is_time(&names[p])).collect()
    };
    // A column of times that is an input too is the last that is taken: an input may have the name by chance.
    let free = TIME_NAMES.iter().map(|known| among(known, true));
    let shared = TIME_NAMES.iter().map(|known| among(known, false));
    let found = free.chain(shared).find(|found| !found.is_empty());
    let found = found.unwrap_or_default();
    match found[..] {
        [place] => Ok(Some(place)),
        [] => Err(Error::data(
            at,
            "a column of times called `t` or `time`; name another with --time COLUMN, or give the time between equally \
             spaced rows with --dt",
            format!(
                "the columns {}{}",
                names.join(", "),
                taken_names(names, wanted)
            ),
        )),
        _ => {
            let names: Vec<&str> = found.iter().map(|&p| names[p].as_str()).collect();
            Err(Error::data(
                at,
                "one column of times; choose it with --time COLUMN",
                names.join(" and "),
            ))
        }
    }
}
