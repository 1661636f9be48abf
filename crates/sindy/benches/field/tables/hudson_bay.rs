//! Pelts of snowshoe hare and Canadian lynx that trappers brought to the Hudson's Bay Company, in thousands a year.
//!
//! Source: the counts of the company, which are in the public domain, as P. Howard prints them in *Modeling Basics*, lecture notes,
//! Texas A&M University 2009 (www.math.tamu.edu/~phoward/m442/modbasics.pdf).

use super::Table;
use crate::simulate::Rows;

/// Years after 1900 of the last training row, where the free run starts.
const LAST: usize = 14;

/// Hare and lynx, from 1900 on.
const PELTS: [[f64; 2]; 21] = [
    [30.0, 4.0],
    [47.2, 6.1],
    [70.2, 9.8],
    [77.4, 35.2],
    [36.3, 59.4],
    [20.6, 41.7],
    [18.1, 19.0],
    [21.4, 13.0],
    [22.0, 8.3],
    [25.4, 9.1],
    [27.1, 7.4],
    [40.3, 8.0],
    [57.0, 12.3],
    [76.6, 19.5],
    [52.3, 45.7],
    [19.5, 51.1],
    [11.2, 29.7],
    [7.6, 15.8],
    [14.6, 9.7],
    [16.2, 10.1],
    [24.7, 8.6],
];

pub(super) fn table() -> Table {
    let rows = |years: std::ops::Range<usize>| Rows {
        states: (0..2)
            .map(|i| years.clone().map(|k| PELTS[k][i]).collect())
            .collect(),
        time: years.map(|k| k as f64).collect(),
        inputs: Vec::new(),
    };
    Table {
        name: "hare and lynx, 1900 to 1920",
        states: &["hare", "lynx"],
        inputs: &[],
        degree: 2,
        discrete: false,
        training: rows(0..LAST + 1),
        held_out: rows(LAST..PELTS.len()),
    }
}
