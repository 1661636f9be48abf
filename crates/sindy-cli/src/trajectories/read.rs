//! The trajectories of a file: its columns, its rows without a proper time left out.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::{FileReport, TOLERATED, Trajectory, WantedColumns, past, time_column};
use crate::error::{Error, Result};
use crate::table::Table;

/// Reads the trajectories of one file.
pub(crate) fn read(
    path: &Path,
    wanted: &WantedColumns<'_>,
) -> Result<(Vec<Trajectory>, FileReport)> {
    let table = Table::open(path, &wanted.table.columns)?;
    let time_place = time_column(table.path(), table.names(), wanted)?;
    let here = |name: &str| table.find(name, "").is_ok();
    let mut have: Vec<String> = Vec::new();
    let mut places = Vec::new();
    for &(name, why) in &wanted.columns {
        // A past column that the table does not hold is made from its present.
        let base = past::of_name(name).filter(|d| !here(name) && here(d.column()));
        let name = base.as_ref().map_or(name, |d| d.column());
        if !have.iter().any(|n| n == name) {
            places.push(table.find(name, why)?);
            have.push(name.to_owned());
        }
    }
    let want: Vec<String> = wanted.columns.iter().map(|c| c.0.to_owned()).collect();
    let weights = wanted
        .weights
        .map(|name| table.find(name, "--weights"))
        .transpose()?;
    places.extend(weights);
    places.extend(time_place);
    let mut columns = table.numbers(&places)?;
    for (column, &place) in columns.iter().zip(&places) {
        check_finite(&table, place, column)?;
    }
    let time = time_place.and_then(|_| columns.pop());
    let weights = weights.and_then(|_| columns.pop());
    if let Some(weights) = &weights {
        check_weights(&table, wanted.weights.unwrap_or_default(), weights)?;
    }
    let rows = FileRows {
        time_name: time_place.map(|p| table.names()[p].clone()),
        dt: wanted.table.dt.unwrap_or(1.0),
        time,
        columns,
        weights,
    };
    let mut report = FileReport {
        path: table.path().to_owned(),
        rows_read: table.findings.rows_read,
        rows_used: 0,
        rows_dropped: table.findings.rows_dropped(),
        empty_cells: rows.empty_cells(&table, &places),
        time: rows.time_name.clone(),
        trajectories: Vec::new(),
        warnings: table.findings.warnings.clone(),
        lossy: table.findings.is_lossy(),
    };
    let trajectories = groups(&table, wanted.table.trajectory.as_deref())?
        .into_iter()
        .map(|(label, members)| rows.trajectory(&table, label, &members, &mut report))
        .collect::<Result<Vec<_>>>()?;
    let trajectories = match have == want {
        true => trajectories,
        false => past::select(trajectories, &have, &want)?,
    };
    for (i, warning) in report.warnings.iter_mut().enumerate() {
        // The reader's warnings are about the file alone and do not name it.
        if i < table.findings.warnings.len() {
            *warning = format!("{}: {warning}", table.path());
        }
    }
    Ok((trajectories, report))
}

fn check_finite(table: &Table, place: usize, column: &[f64]) -> Result<()> {
    match column.iter().position(|v| v.is_infinite()) {
        None => Ok(()),
        Some(row) => Err(Error::data(
            table.place(row, &table.names()[place]),
            "a finite number, or an empty cell for a gap",
            column[row].to_string(),
        )),
    }
}

fn check_weights(table: &Table, name: &str, weights: &[f64]) -> Result<()> {
    match weights.iter().position(|w| !(*w >= 0.0)) {
        None => Ok(()),
        Some(row) => {
            let found = match weights[row].is_nan() {
                true => "an empty cell".to_owned(),
                false => weights[row].to_string(),
            };
            let at = table.place(row, name);
            Err(Error::data(at, "a weight that is not negative", found))
        }
    }
}

/// The rows of each trajectory with its label, in the order in which the labels first appear.
fn groups(table: &Table, column: Option<&str>) -> Result<Vec<(Option<String>, Vec<usize>)>> {
    let Some(column) = column else {
        return Ok(vec![(None, (0..table.rows()).collect())]);
    };
    let labels = table.labels(table.find(column, "--trajectory")?)?;
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut groups: Vec<(Option<String>, Vec<usize>)> = Vec::new();
    for (row, label) in labels.iter().enumerate() {
        if label.is_empty() {
            return Err(Error::data(
                table.place(row, column),
                "the label of a trajectory",
                "an empty cell",
            ));
        }
        let place = *places.entry(label).or_insert_with(|| {
            groups.push((Some(label.clone()), Vec::new()));
            groups.len() - 1
        });
        groups[place].1.push(row);
    }
    Ok(groups)
}

/// All rows of a file.
struct FileRows {
    time_name: Option<String>,
    dt: f64,
    time: Option<Vec<f64>>,
    columns: Vec<Vec<f64>>,
    weights: Option<Vec<f64>>,
}

impl FileRows {
    fn empty_cells(&self, table: &Table, places: &[usize]) -> BTreeMap<String, usize> {
        let count = |column: &Vec<f64>| column.iter().filter(|v| v.is_nan()).count();
        self.columns
            .iter()
            .zip(places)
            .map(|(column, &place)| (table.names()[place].clone(), count(column)))
            .filter(|&(_, gaps)| gaps > 0)
            .collect()
    }

    /// The trajectory of some rows, those without a proper time left out.
    fn trajectory(
        &self,
        table: &Table,
        label: Option<String>,
        members: &[usize],
        report: &mut FileReport,
    ) -> Result<Trajectory> {
        let name = match label {
            None => table.path().to_owned(),
            Some(label) => format!("{}, {label}", table.path()),
        };
        let kept = match &self.time {
            None => members.to_vec(),
            Some(time) => self.kept(table, &name, members, time, report)?,
        };
        let pick = |column: &Vec<f64>| kept.iter().map(|&row| column[row]).collect::<Vec<f64>>();
        report.rows_used += kept.len();
        report.trajectories.push(name.clone());
        Ok(Trajectory {
            name,
            time: match &self.time {
                Some(time) => pick(time),
                None => (0..kept.len()).map(|i| i as f64 * self.dt).collect(),
            },
            columns: self.columns.iter().map(pick).collect(),
            weights: self.weights.as_ref().map(pick),
            filled: false,
        })
    }

    /// The rows whose time is later than all before.
    fn kept(
        &self,
        table: &Table,
        name: &str,
        members: &[usize],
        time: &[f64],
        report: &mut FileReport,
    ) -> Result<Vec<usize>> {
        let mut kept: Vec<usize> = Vec::with_capacity(members.len());
        let mut first_fault = None;
        for &row in members {
            match kept.last() {
                _ if time[row].is_nan() => {
                    first_fault.get_or_insert((row, "an empty cell".to_owned()));
                }
                Some(&last) if time[row] <= time[last] => {
                    let found = format!("{} after {}", time[row], time[last]);
                    first_fault.get_or_insert((row, found));
                }
                _ => kept.push(row),
            }
        }
        let Some((row, found)) = first_fault else {
            return Ok(kept);
        };
        let dropped = members.len() - kept.len();
        let column = self.time_name.as_deref().unwrap_or_default();
        if dropped as f64 > TOLERATED * members.len() as f64 {
            return Err(Error::data(
                table.place(row, column),
                "time that increases from row to row; where a file holds several runs, name the column that tells them \
                 apart with --trajectory",
                format!(
                    "{found} ({dropped} of {} rows are out of order)",
                    members.len()
                ),
            ));
        }
        report.rows_dropped += dropped;
        report.warnings.push(format!(
            "{name}: {dropped} of {} rows were dropped because their time is absent, repeated or out of order, the \
             first at data row {}",
            members.len(),
            table.row_number(row)
        ));
        Ok(kept)
    }
}
