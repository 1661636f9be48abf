//! The blocks of a table as it is read, part by part.

use std::cell::{Cell, RefCell};
use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, HashSet, VecDeque};
use std::hash::{Hash as _, Hasher as _};
use std::path::PathBuf;

use sindy::{OwnedBlock, SindyError, Stream};

use crate::error::{Error, Result};
use crate::table::{Header, Rows};
use crate::trajectories::{FileReport, TOLERATED, WantedColumns, time_column};
use touchdown_terminal::Terminal;

/// Rows from which a trajectory with too many rows out of order is given up at once.
const SURE: usize = 1000;
/// Names of trajectories that are reported, and labels that are remembered.
const NAMED: usize = 1000;
const REMEMBERED: usize = 1_000_000;

/// The files of a pass, and what comes out of their blocks beside rows.
pub(super) struct Reading<'a> {
    terminal: &'a Terminal,
    wanted: &'a WantedColumns<'a>,
    files: &'a [PathBuf],
    /// Bytes of each file.
    sizes: Vec<u64>,
    /// Bytes of the files that were read, and rows so far.
    bytes: Cell<u64>,
    rows: Cell<usize>,
    error: RefCell<Option<Error>>,
    reports: RefCell<BTreeMap<usize, FileReport>>,
}

/// The blocks of one file.
pub(super) struct Blocks<'a> {
    reading: &'a Reading<'a>,
    file: usize,
    open: Option<Open>,
    /// Whether the file was read to its end, or as far as it is wanted.
    over: bool,
    ready: VecDeque<OwnedBlock>,
    /// Trajectories, and rows, so far.
    groups: usize,
    rows: usize,
    /// Rows from which the rest is not wanted.
    most: usize,
}

impl<'a> Reading<'a> {
    pub(super) fn new(
        terminal: &'a Terminal,
        files: &'a [PathBuf],
        wanted: &'a WantedColumns<'a>,
    ) -> Self {
        let size = |p: &PathBuf| std::fs::metadata(p).map_or(0, |m| m.len());
        Self {
            terminal,
            wanted,
            files,
            sizes: files.iter().map(size).collect(),
            bytes: Cell::new(0),
            rows: Cell::new(0),
            error: RefCell::default(),
            reports: RefCell::default(),
        }
    }

    /// A file as a source of these columns, which ends behind `most` rows. It is opened when it is read.
    pub(super) fn file(&'a self, file: usize, names: &[&str], most: usize) -> Stream<Blocks<'a>> {
        let blocks = Blocks {
            reading: self,
            file,
            open: None,
            over: false,
            ready: VecDeque::new(),
            groups: 0,
            rows: 0,
            most,
        };
        Stream::new(names, usize::MAX, blocks)
    }

    /// The command's own error, if a file caused one: it says more than that of the library.
    pub(super) fn failure(&self) -> Result<()> {
        self.error.take().map_or(Ok(()), Err)
    }

    /// The reports of the files that were read to their ends, by their numbers.
    pub(super) fn reports(self) -> BTreeMap<usize, FileReport> {
        self.reports.take()
    }
}

/// A file that is being read.
struct Open {
    rows: Rows,
    /// The columns that are read.
    names: Vec<String>,
    time: Option<String>,
    weights: bool,
    report: FileReport,
    /// The trajectory that the last row belongs to, its last time and the number of its rows.
    label: Option<String>,
    last: f64,
    count: usize,
    seen: HashSet<u64>,
    /// Rows that were dropped for their time, and the first of them.
    dropped: usize,
    fault: Option<(usize, String)>,
}

impl Iterator for Blocks<'_> {
    type Item = std::result::Result<OwnedBlock, SindyError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(block) = self.ready.pop_front() {
                return Some(Ok(block));
            }
            match self.advance() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(error) => {
                    let reason = error.to_string();
                    self.reading.error.replace(Some(error));
                    return Some(Err(SindyError::Source { reason }));
                }
            }
        }
    }
}

impl Blocks<'_> {
    /// Reads the next part of the file; `false` at its end.
    fn advance(&mut self) -> Result<bool> {
        let Reading {
            terminal,
            wanted,
            files,
            sizes,
            bytes,
            rows,
            ..
        } = self.reading;
        if self.over || self.rows >= self.most {
            return Ok(false);
        }
        let Some(open) = &mut self.open else {
            self.open = Some(Open::new(&files[self.file], wanted)?);
            return Ok(true);
        };
        let blocks = open.part(wanted, &mut self.groups)?;
        let share = open.rows.share();
        let Some(blocks) = blocks else {
            self.over = true;
            bytes.set(bytes.get() + sizes[self.file]);
            if let Some(done) = self.open.take() {
                let mut reports = self.reading.reports.borrow_mut();
                reports.insert(self.file, done.end()?);
            }
            return Ok(true);
        };
        let count = blocks.iter().map(|b| b.columns[0].len()).sum::<usize>();
        self.rows += count;
        rows.set(rows.get() + count);
        self.ready.extend(blocks);
        let total: u64 = sizes.iter().sum();
        let read = bytes.get() as f64 + share * sizes[self.file] as f64;
        let name = &files[self.file].display().to_string();
        terminal.busy(&stage(read / total.max(1) as f64, rows.get(), name));
        Ok(true)
    }
}

/// The progress of the pass.
fn stage(share: f64, rows: usize, file: &str) -> String {
    let percent = (100.0 * share.clamp(0.0, 1.0)).floor();
    format!("one pass: {percent} % of the data, {rows} rows; {file}")
}

impl Open {
    fn new(path: &std::path::Path, wanted: &WantedColumns<'_>) -> Result<Self> {
        let header = Header::open(path, &wanted.table.columns)?;
        let time = time_column(header.path(), header.names(), wanted)?;
        let mut places = Vec::new();
        for &(name, why) in &wanted.columns {
            places.push(header.find(name, why)?);
        }
        if let Some(name) = wanted.weights {
            places.push(header.find(name, "--weights")?);
        }
        places.extend(time);
        let label = wanted.table.trajectory.as_deref();
        let label = label
            .map(|name| header.find(name, "--trajectory"))
            .transpose()?;
        let names = header.names().to_vec();
        let at = header.path().to_owned();
        Ok(Self {
            rows: header.rows(&places, label)?,
            time: time.map(|place| names[place].clone()),
            names: places.iter().map(|&p| names[p].clone()).collect(),
            weights: wanted.weights.is_some(),
            report: FileReport::new(at),
            label: None,
            last: f64::NEG_INFINITY,
            count: 0,
            seen: HashSet::new(),
            dropped: 0,
            fault: None,
        })
    }

    /// The next rows as blocks of their trajectories; none at the end.
    fn part(
        &mut self,
        wanted: &WantedColumns<'_>,
        groups: &mut usize,
    ) -> Result<Option<Vec<OwnedBlock>>> {
        let Some((columns, labels)) = self.rows.next()? else {
            return Ok(None);
        };
        self.check(&columns)?;
        let n = columns.first().map_or(0, Vec::len);
        let timed = usize::from(self.time.is_some());
        let time = (timed == 1).then(|| &columns[columns.len() - 1]);
        let data = &columns[..columns.len() - timed];
        let mut blocks: Vec<OwnedBlock> = Vec::new();
        let mut start = 0;
        while start < n {
            let label = labels.as_ref().map(|l| l[start].as_str());
            let end = match &labels {
                None => n,
                Some(labels) => {
                    let same = labels[start..].iter().take_while(|l| **l == labels[start]);
                    start + same.count()
                }
            };
            self.turn(label, start, wanted, groups)?;
            let kept: Vec<usize> = (start..end)
                .filter(|&row| time.is_none_or(|time| self.keeps(time[row], row)))
                .collect();
            let times: Vec<f64> = match time {
                Some(time) => kept.iter().map(|&row| time[row]).collect(),
                None => {
                    let step = wanted.table.dt.unwrap_or(1.0);
                    (self.count..self.count + kept.len())
                        .map(|i| i as f64 * step)
                        .collect()
                }
            };
            self.count += kept.len();
            let mut all = vec![times];
            all.extend(
                data.iter()
                    .map(|c| kept.iter().map(|&row| c[row]).collect()),
            );
            blocks.push(OwnedBlock {
                group: *groups - 1,
                columns: all,
            });
            self.report.rows_used += kept.len();
            start = end;
        }
        if self.dropped >= SURE {
            self.judge()?;
        }
        Ok(Some(blocks))
    }

    /// Begins a trajectory where the label differs from that of the row before.
    fn turn(
        &mut self,
        label: Option<&str>,
        row: usize,
        wanted: &WantedColumns<'_>,
        groups: &mut usize,
    ) -> Result<()> {
        let first = self.report.trajectories.is_empty();
        if !first && label == self.label.as_deref() {
            return Ok(());
        }
        let column = wanted.table.trajectory.as_deref().unwrap_or_default();
        let name = match label {
            None => self.report.path.clone(),
            Some("") => {
                return Err(Error::data(
                    self.place(row, column),
                    "the label of a trajectory",
                    "an empty cell",
                ));
            }
            Some(label) => {
                let mut hasher = DefaultHasher::new();
                label.hash(&mut hasher);
                if self.seen.len() < REMEMBERED && !self.seen.insert(hasher.finish()) {
                    return Err(Error::data(
                        self.place(row, column),
                        "the rows of a trajectory one after the other, as --stream reads them; sort the table, or leave \
                         out --stream",
                        format!("{label:?} again after other labels"),
                    ));
                }
                format!("{}, {label}", self.report.path)
            }
        };
        match self.report.trajectories.len() {
            NAMED => self.report.trajectories.push("and more".to_owned()),
            n if n < NAMED => self.report.trajectories.push(name),
            _ => {}
        }
        self.label = label.map(str::to_owned);
        self.last = f64::NEG_INFINITY;
        self.count = 0;
        *groups += 1;
        Ok(())
    }

    /// Whether a row's time is later than all before; what is not, is counted.
    fn keeps(&mut self, time: f64, row: usize) -> bool {
        if time > self.last {
            self.last = time;
            return true;
        }
        self.dropped += 1;
        if self.fault.is_none() {
            let found = match time.is_nan() {
                true => "an empty cell".to_owned(),
                false => format!("{time} after {}", self.last),
            };
            self.fault = Some((self.rows.numbers()[row], found));
        }
        false
    }

    /// Infinite values and weights below zero are errors; gaps are counted.
    fn check(&mut self, columns: &[Vec<f64>]) -> Result<()> {
        let weights = self
            .weights
            .then(|| columns.len() - 1 - usize::from(self.time.is_some()));
        for (k, (column, name)) in columns.iter().zip(&self.names).enumerate() {
            if let Some(row) = column.iter().position(|v| v.is_infinite()) {
                return Err(Error::data(
                    self.place(row, name),
                    "a finite number, or an empty cell for a gap",
                    column[row].to_string(),
                ));
            }
            if weights == Some(k)
                && let Some(row) = column.iter().position(|w| !(*w >= 0.0))
            {
                let found = match column[row].is_nan() {
                    true => "an empty cell".to_owned(),
                    false => column[row].to_string(),
                };
                let at = self.place(row, name);
                return Err(Error::data(at, "a weight that is not negative", found));
            }
            let gaps = column.iter().filter(|v| v.is_nan()).count();
            if gaps > 0 {
                *self.report.empty_cells.entry(name.clone()).or_default() += gaps;
            }
        }
        Ok(())
    }

    /// File, row and column, for messages.
    fn place(&self, row: usize, column: &str) -> String {
        let row = self.rows.numbers()[row];
        format!("{}, data row {row}, column `{column}`", self.report.path)
    }

    /// Refuses a file of which more than 1 % of the rows have no proper time.
    fn judge(&self) -> Result<()> {
        let rows = self.dropped + self.report.rows_used;
        match &self.fault {
            Some((row, found)) if self.dropped as f64 > TOLERATED * rows as f64 => {
                let column = self.time.as_deref().unwrap_or_default();
                Err(Error::data(
                    format!("{}, data row {row}, column `{column}`", self.report.path),
                    "time that increases from row to row; where a file holds several runs, name the column that tells \
                     them apart with --trajectory",
                    format!("{found} ({} of {rows} rows are out of order)", self.dropped),
                ))
            }
            _ => Ok(()),
        }
    }

    /// The report of a file that was read to its end.
    fn end(self) -> Result<FileReport> {
        self.judge()?;
        let findings = self.rows.findings();
        let mut report = self.report;
        report.time = self.time;
        report.rows_read = findings.rows_read;
        report.rows_dropped = findings.rows_dropped() + self.dropped;
        report.lossy = findings.is_lossy();
        let at = &report.path;
        report.warnings = findings
            .warnings
            .iter()
            .map(|w| format!("{at}: {w}"))
            .collect();
        if let Some((row, _)) = self.fault {
            report.warnings.push(format!(
                "{at}: {} of {} rows were dropped because their time is absent, repeated or out of order, the first at \
                 data row {row}",
                self.dropped,
                self.dropped + report.rows_used
            ));
        }
        Ok(report)
    }
}

#[cfg(test)]
mod tests {
    use super::stage;

    #[test]
    fn analytic_progress_says_the_share() {
        let said = stage(0.379, 1_200_000, "big.parquet");
        assert_eq!(
            said,
            "one pass: 37 % of the data, 1200000 rows; big.parquet"
        );
        assert!(stage(1.7, 1, "a").contains("100 %"));
    }
}
