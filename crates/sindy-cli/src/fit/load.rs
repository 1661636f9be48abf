//! Training and test data from files.

use std::path::PathBuf;

use sindy::Dataset;

use super::args::FitArgs;
use crate::error::{Error, Result};
use crate::trajectories::{self, FileReport, Trajectory, WantedColumns, past};
use touchdown_terminal::Terminal;

/// Trajectories to fit.
pub(super) struct Train {
    pub(super) data: Dataset,
    /// The inputs, those of --past included.
    pub(super) inputs: Vec<String>,
    pub(super) files: Vec<FileReport>,
}

/// Trajectories to judge by.
pub(super) struct Test {
    pub(super) trajectories: Vec<Trajectory>,
    pub(super) warnings: Vec<String>,
}

impl Train {
    /// The trajectories as they were read, without their weights.
    pub(super) fn trajectories(&self) -> Vec<Trajectory> {
        let all = self.data.trajectories().iter();
        all.map(|t| Trajectory {
            name: t.name.clone(),
            time: t.time.clone(),
            columns: t.columns.clone(),
            weights: None,
            filled: false,
        })
        .collect()
    }
}

pub(super) fn train(terminal: &Terminal, args: &FitArgs) -> Result<Train> {
    let known = [&args.states[..], &args.inputs].concat();
    let delays = past::parse(&args.past, &known)?;
    let (mut trajectories, files) = read(terminal, args, &args.train, args.weights.as_deref())?;
    let mut inputs = args.inputs.clone();
    if !delays.is_empty() {
        let (all, names) = past::add(trajectories, &known, &delays)?;
        trajectories = all;
        inputs = names[args.states.len()..].to_vec();
    }
    let data = dataset(trajectories, &args.states, &inputs, &files)?;
    if args.discrete || !delays.is_empty() || !data.lacks_single_values() {
        check_rows(&data, &files).inspect_err(|_| warn(terminal, &files))?;
    }
    Ok(Train {
        data,
        inputs,
        files,
    })
}

/// Trajectories as a data set; refused where a column has no values.
pub(crate) fn dataset(
    trajectories: Vec<Trajectory>,
    states: &[String],
    inputs: &[String],
    files: &[FileReport],
) -> Result<Dataset> {
    let mut data = Dataset::new(states, inputs).map_err(Error::refused("--states, --inputs"))?;
    for t in trajectories {
        let refused = Error::refused(t.name.clone());
        data.push(t.name, t.time, t.columns, t.weights)
            .map_err(refused)?;
    }
    for (column, name) in data.names().iter().enumerate() {
        let all = data.trajectories().iter().flat_map(|t| &t.columns[column]);
        if all.clone().next().is_some() && all.clone().all(|v| v.is_nan()) {
            let at = names(files);
            let expected = format!("values in column `{name}`");
            return Err(Error::data(at, expected, "empty cells alone".to_owned()));
        }
    }
    Ok(data)
}

/// Refuses data without rows that follow each other.
pub(crate) fn check_rows(data: &Dataset, files: &[FileReport]) -> Result<()> {
    if !data.stretches().is_empty() {
        return Ok(());
    }
    let report = data.report();
    Err(Error::data(
        names(files),
        "at least 3 rows after each other without gaps",
        format!(
            "{} row{}, {} with empty cells",
            report.rows,
            if report.rows == 1 { "" } else { "s" },
            report.missing_rows
        ),
    ))
}

/// Says what was found wrong in the files: rows that could not be read may be why too few are left.
pub(super) fn warn(terminal: &Terminal, files: &[FileReport]) {
    let all = files.iter().flat_map(|f| &f.warnings);
    all.for_each(|warning| terminal.warn(warning));
}

fn names(files: &[FileReport]) -> String {
    let names: Vec<&str> = files.iter().map(|f| f.path.as_str()).collect();
    names.join(", ")
}

pub(super) fn test(terminal: &Terminal, args: &FitArgs) -> Result<Option<Test>> {
    if args.test.is_empty() {
        return Ok(None);
    }
    let (trajectories, files) = read(terminal, args, &args.test, None)?;
    let warnings = files.into_iter().flat_map(|f| f.warnings).collect();
    Ok(Some(Test {
        trajectories,
        warnings,
    }))
}

/// The columns that the arguments ask for.
pub(super) fn wanted<'a>(args: &'a FitArgs, weights: Option<&'a str>) -> WantedColumns<'a> {
    let states = args.states.iter().map(|n| (n.as_str(), "--states"));
    let inputs = args.inputs.iter().map(|n| (n.as_str(), "--inputs"));
    WantedColumns {
        columns: states.chain(inputs).collect(),
        weights,
        table: &args.table,
    }
}

fn read(
    terminal: &Terminal,
    args: &FitArgs,
    paths: &[PathBuf],
    weights: Option<&str>,
) -> Result<(Vec<Trajectory>, Vec<FileReport>)> {
    let wanted = wanted(args, weights);
    let (mut all, mut reports) = (Vec::new(), Vec::new());
    for (k, path) in paths.iter().enumerate() {
        let name = path.display();
        terminal.busy(&format!(
            "reading {name}, file {} of {}",
            k + 1,
            paths.len()
        ));
        let (trajectories, report) = trajectories::read(path, &wanted)?;
        all.extend(trajectories);
        reports.push(report);
    }
    Ok((all, reports))
}
