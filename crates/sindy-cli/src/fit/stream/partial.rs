//! Partial sums in files: `fit --stream --partial` writes them, `merge` ends the fit.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use serde::{Deserialize, Serialize};
use sindy::Identify;
use sindy::identify::{PartialSums, Progress};
use touchdown_terminal::{Done, Terminal};

use super::super::Fitted;
use super::super::args::FitArgs;
use super::pass;
use crate::error::{Error, Result};
use crate::output;
use crate::trajectories::FileReport;

/// Put the partial sums of `fit --stream --partial` together and end the fit.
#[derive(Args, Debug)]
#[command(after_help = MERGE_EXAMPLES)]
pub(crate) struct MergeArgs {
    /// Files of partial sums, in any order
    ///
    /// All of them must come from the same list of files, with the same columns, terms and settings, and every file of the list
    /// must be in one of them. The result has the bits of one process.
    #[arg(required = true, value_name = "PARTIAL")]
    pub(crate) partials: Vec<PathBuf>,
    /// File for the model, which `sindy simulate` reads
    #[arg(long, value_name = "OUT.json")]
    pub(crate) model: Option<PathBuf>,
    /// Figure of the choice (.svg, .png or .html)
    #[arg(long, value_name = "OUT")]
    pub(crate) figure: Option<PathBuf>,
}

const MERGE_EXAMPLES: &str = "\
Examples:
  sindy fit runs/*.parquet --states x,y --stream --partial 1.json --shard 1/2   on one machine
  sindy fit runs/*.parquet --states x,y --stream --partial 2.json --shard 2/2   on another
  sindy merge 1.json 2.json --model model.json";

/// One of several equal parts of the files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shard {
    number: usize,
    of: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers = text.split_once('/');
        let numbers = numbers.and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) && of < 1 << 32 => {
                Ok(Self { number, of })
            }
            _ => Err("expected K/N with K from 1 to N, such as 2/8".to_owned()),
        }
    }
}

impl Shard {
    /// Its files among `count`: neighbours, whose sums are added at once.
    fn range(self, count: usize) -> std::ops::Range<usize> {
        let at = |k: usize| (k as u128 * count as u128 / self.of as u128) as usize;
        at(self.number - 1)..at(self.number)
    }
}

/// The content of a file of partial sums.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::fit) struct PartialFit {
    sums: PartialSums,
    /// By the number of the file.
    reports: BTreeMap<usize, FileReport>,
}

/// The first line of such a file; the content is the second.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    /// Of the second line.
    crc32: u32,
}

/// What `--partial` prints with `--json`.
#[derive(Serialize)]
struct PartialObject<'a> {
    partial: &'a Path,
    rows: usize,
    files: Vec<&'a FileReport>,
    /// The number of files of the whole fit.
    of: usize,
    warnings: Vec<&'a String>,
    version: &'static str,
}

/// Passes over a part of the files and writes its sums.
pub(in crate::fit) fn write(
    terminal: &Terminal,
    args: &FitArgs,
    identify: &Identify,
    path: &Path,
) -> Result<Done> {
    let whole = Shard { number: 1, of: 1 };
    let shard = args.shard.unwrap_or(whole);
    let count = args.train.len();
    let (sums, reports) = pass(terminal, args, identify, shard.range(count))?;
    let fit = PartialFit { sums, reports };
    let text = serde_json::to_string(&fit).map_err(|e| Error::file(path, e.into()))?;
    let head = Head {
        crc32: crc32fast::hash(text.as_bytes()),
    };
    let head = serde_json::to_string(&head).map_err(|e| Error::file(path, e.into()))?;
    output::write(path, format!("{head}\n{text}").as_bytes())?;
    terminal.finish();
    let files: Vec<&FileReport> = fit.reports.values().collect();
    let object = PartialObject {
        partial: path,
        rows: fit.sums.rows(),
        warnings: files.iter().flat_map(|f| &f.warnings).collect(),
        of: count,
        version: env!("CARGO_PKG_VERSION"),
        files,
    };
    terminal.say(&format!(
        "partial sums of {} of {count} files, {} rows: {}",
        object.files.len(),
        object.rows,
        path.display()
    ));
    object.warnings.iter().for_each(|w| terminal.warn(w));
    if shard.of > count {
        terminal.warn(&format!(
            "--shard: {} shards of {count} files; some are empty. Expected at most as many shards as files",
            shard.of
        ));
    }
    terminal.object(&object);
    Ok(Done::with_loss(object.files.iter().any(|f| f.lossy)))
}

impl PartialFit {
    /// Reads the files and puts them together.
    pub(in crate::fit) fn merged(terminal: &Terminal, paths: &[PathBuf]) -> Result<Self> {
        let mut all: Option<Self> = None;
        for path in paths {
            terminal.busy(&format!("reading {}", path.display()));
            let next = Self::read(path)?;
            match &mut all {
                None => all = Some(next),
                Some(all) => {
                    let merged = all.sums.merge(next.sums);
                    merged.map_err(Error::refused(path.display().to_string()))?;
                    all.reports.extend(next.reports);
                }
            }
        }
        all.ok_or_else(|| Error::Arguments("PARTIAL: expected a file, found none".to_owned()))
    }

    fn read(path: &Path) -> Result<Self> {
        let mut text = String::new();
        let mut file = touchdown_files::open(path).map_err(Error::unread(path))?;
        file.read_to_string(&mut text)
            .map_err(Error::unread(path))?;
        let unlike = |found: String| Error::Settings {
            file: path.display().to_string(),
            message: format!(
                "expected partial sums of `sindy fit --stream --partial`, found {found}"
            ),
        };
        let (head, body) = text.split_once('\n').unwrap_or((&text, ""));
        let head: Head = serde_json::from_str(head).map_err(|e| unlike(e.to_string()))?;
        if head.crc32 != crc32fast::hash(body.as_bytes()) {
            return Err(unlike(
                "one that was changed or cut off: its checksum differs".to_owned(),
            ));
        }
        serde_json::from_str(body).map_err(|e| unlike(e.to_string()))
    }

    /// Ends the fit.
    pub(in crate::fit) fn fit(
        self,
        paths: &[PathBuf],
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Fitted> {
        let paths: Vec<String> = paths.iter().map(|p| p.display().to_string()).collect();
        let found = self.sums.identify(progress);
        Ok(Fitted {
            found: found.map_err(Error::refused(paths.join(", ")))?,
            files: self.reports.into_values().collect(),
            trajectories: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_shards_are_all_files_once_and_alike() {
        for count in 0..20 {
            for of in 1..25 {
                let ranges: Vec<_> = (1..=of)
                    .map(|number| Shard { number, of }.range(count))
                    .collect();
                assert_eq!(
                    ranges.iter().cloned().flatten().collect::<Vec<_>>(),
                    (0..count).collect::<Vec<_>>()
                );
                let sizes = || ranges.iter().map(ExactSizeIterator::len);
                assert!(sizes().max() <= sizes().min().map(|n| n + 1));
            }
        }
        for wrong in ["", "1", "0/3", "4/3", "1/x", "1/2/3", "-1/2"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
