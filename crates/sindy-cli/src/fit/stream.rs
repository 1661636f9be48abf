//! `sindy fit --stream`: tables that need not fit into memory, in one pass.

use std::cell::RefCell;
use std::collections::hash_map::DefaultHasher;
use std::collections::{HashSet, VecDeque};
use std::hash::{Hash as _, Hasher as _};
use std::path::PathBuf;

use sindy::identify::{Columns, Identification};
use sindy::{Identify, OwnedBlock, SindyError, Stream};

use super::args::FitArgs;
use super::load::wanted;
use crate::error::{Error, Result};
use crate::table::{Header, Rows};
use crate::trajectories::{FileReport, TOLERATED, WantedColumns, time_column};
use touchdown_terminal::Terminal;

/// The name of the time column in the stream; no column of a table can be both this and a state.
const TIME: &str = "(time)";
/// The name of the column of weights.
const WEIGHTS: &str = "(weights)";
/// Rows from which a trajectory with too many rows out of order is given up at once.
const SURE: usize = 1000;
/// Names of trajectories that are reported, and labels that are remembered.
const NAMED: usize = 1000;
const REMEMBERED: usize = 1_000_000;

/// Reads the training files once, and fits.
pub(super) fn fit(
    terminal: &Terminal,
    args: &FitArgs,
    identify: &Identify,
    progress: &mut dyn FnMut(sindy::identify::Progress),
) -> Result<(Identification, Vec<FileReport>)> {
    let wanted = wanted(args, args.weights.as_deref());
    let mut columns = Columns::new(TIME, &args.states, &args.inputs)
        .map_err(Error::refused("--states, --inputs"))?;
    let mut names = vec![TIME];
    names.extend(args.states.iter().chain(&args.inputs).map(String::as_str));
    if args.weights.is_some() {
        columns = columns.weights(WEIGHTS);
        names.push(WEIGHTS);
    }
    let sizes = args
        .train
        .iter()
        .map(|p| std::fs::metadata(p).map_or(0, |m| m.len()));
    let shared = Shared::default();
    let blocks = Blocks {
        terminal,
        wanted: &wanted,
        sizes: sizes.collect(),
        files: &args.train,
        next: 0,
        open: None,
        ready: VecDeque::new(),
        groups: 0,
        rows: 0,
        shared: &shared,
    };
    let source = Stream::new(&names, usize::MAX, blocks);
    let found = identify.run_stream(&source, &columns, progress);
    if let Some(error) = shared.error.take() {
        return Err(error);
    }
    let files: Vec<String> = args.train.iter().map(|p| p.display().to_string()).collect();
    let found = found.map_err(Error::refused(files.join(", ")))?;
    Ok((found, shared.reports.take()))
}

/// What comes out of the iterator beside its blocks.
#[derive(Default)]
struct Shared {
    error: RefCell<Option<Error>>,
    reports: RefCell<Vec<FileReport>>,
}

/// The blocks of all files.
struct Blocks<'a> {
    terminal: &'a Terminal,
    wanted: &'a WantedColumns<'a>,
    files: &'a [PathBuf],
    /// Bytes of each file.
    sizes: Vec<u64>,
    next: usize,
    open: Option<Open>,
    ready: VecDeque<OwnedBlock>,
    /// Trajectories, and rows, so far.
    groups: usize,
    rows: usize,
    shared: &'a Shared,
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
                    self.shared.error.replace(Some(error));
                    return Some(Err(SindyError::Source { reason }));
                }
            }
        }
    }
}

impl Blocks<'_> {
    /// Reads the next part of a file; `false` at the end of the last.
    fn advance(&mut self) -> Result<bool> {
        let Some(open) = &mut self.open else {
            let Some(path) = self.files.get(self.next) else {
                return Ok(false);
            };
            self.open = Some(Open::new(path, self.wanted)?);
            self.next += 1;
            return Ok(true);
        };
        let blocks = open.part(self.wanted, &mut self.groups)?;
        let share = open.rows.share();
        match blocks {
            Some(blocks) => {
                self.rows += blocks.iter().map(|b| b.columns[0].len()).sum::<usize>();
                self.ready.extend(blocks);
                let before: u64 = self.sizes[..self.next - 1].iter().sum();
                let total: u64 = self.sizes.iter().sum();
                let read = before as f64 + share * self.sizes[self.next - 1] as f64;
                let name = &self.files[self.next - 1].display().to_string();
                self.terminal
                    .busy(&stage(read / total.max(1) as f64, self.rows, name));
            }
            None => {
                if let Some(done) = self.open.take() {
                    self.shared.reports.borrow_mut().push(done.end()?);
                }
            }
        }
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
