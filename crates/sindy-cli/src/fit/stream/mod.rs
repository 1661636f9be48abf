//! `sindy fit --stream`: tables that need not fit into memory, in one pass. A part of the files leaves partial sums, which
//! `sindy merge` puts together; without `--partial` one process passes over all of them.

mod blocks;
mod partial;

use std::collections::BTreeMap;
use std::ops::Range;

use sindy::identify::stream::HEAD_ROWS;
use sindy::identify::{Columns, PartialSums, Progress};
use sindy::{BlockSource, Identify};

use super::Fitted;
use super::args::FitArgs;
use super::load::wanted;
use crate::error::{Error, Result};
use crate::trajectories::FileReport;
use blocks::Reading;
pub(crate) use partial::{MergeArgs, Shard};
pub(super) use partial::{PartialFit, write};
use touchdown_terminal::Terminal;

/// The name of the time column in the stream; no column of a table can be both this and a state.
const TIME: &str = "(time)";
/// The name of the column of weights.
const WEIGHTS: &str = "(weights)";

/// Reads the training files once, and fits.
pub(super) fn fit(
    terminal: &Terminal,
    args: &FitArgs,
    identify: &Identify,
    progress: &mut dyn FnMut(Progress),
) -> Result<Fitted> {
    let (sums, reports) = pass(terminal, args, identify, 0..args.train.len())?;
    let found = sums.identify(progress);
    Ok(Fitted {
        found: found.map_err(Error::refused(super::files(args)))?,
        files: reports.into_values().collect(),
        trajectories: None,
    })
}

/// The sums of some of the files, and their reports.
fn pass(
    terminal: &Terminal,
    args: &FitArgs,
    identify: &Identify,
    part: Range<usize>,
) -> Result<(PartialSums, BTreeMap<usize, FileReport>)> {
    let wanted = wanted(args, args.weights.as_deref());
    let mut columns = Columns::new(TIME, &args.states, &args.inputs)
        .map_err(Error::refused("--states, --inputs"))?;
    let mut names = vec![TIME];
    names.extend(args.states.iter().chain(&args.inputs).map(String::as_str));
    if args.weights.is_some() {
        columns = columns.weights(WEIGHTS);
        names.push(WEIGHTS);
    }
    terminal.busy("the first rows");
    let head = Reading::new(terminal, &args.train, &wanted);
    let sources: Vec<_> = (0..args.train.len())
        .map(|file| head.file(file, &names, HEAD_ROWS))
        .collect();
    let sources: Vec<&dyn BlockSource> = sources.iter().map(|s| s as _).collect();
    let paths: Vec<String> = args.train.iter().map(|p| p.display().to_string()).collect();
    let sums = identify.partial_sums(&columns, &paths, &sources);
    head.failure()?;
    let mut sums = sums.map_err(Error::refused(super::files(args)))?;
    let reading = Reading::new(terminal, &args.train, &wanted);
    for file in part {
        let added = sums.add(file, &reading.file(file, &names, usize::MAX));
        reading.failure()?;
        added.map_err(Error::refused(&*paths[file]))?;
    }
    Ok((sums, reading.reports()))
}
