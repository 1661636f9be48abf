//! Logs from the disk: read, mapped, counted.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_log::{Findings, Map};
use touchdown_model::card::Input;
pub(crate) use touchdown_pages::logs::{label, once, word};
use touchdown_trial::{Source, Trial};

use crate::cli::context::Context;

/// A log that became a trial.
pub(crate) struct Log {
    /// The file, as it was given.
    pub(crate) path: PathBuf,
    /// What it holds.
    pub(crate) trial: Trial,
    /// What was counted on the way.
    pub(crate) findings: Findings,
}

impl Log {
    /// SHA-256 of the file.
    pub(crate) fn sha256(&self) -> &str {
        match &self.trial.provenance().source {
            Source::File { sha256, .. } => sha256,
            _ => "",
        }
    }

    /// What a person should know of the log: warnings and losses.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let mut all = self.findings.warnings.clone();
        all.extend(self.findings.loss());
        all
    }

    /// The same, each with the log's path.
    pub(crate) fn warnings_by_log(&self) -> Vec<(PathBuf, String)> {
        let warnings = self.warnings().into_iter();
        warnings.map(|w| (self.path.clone(), w)).collect()
    }
}

/// Reads a map, if there is one: a file, or the name of a built-in map.
pub(crate) fn map(path: Option<&Path>) -> Result<Option<Map>> {
    let built_in = built_in(path).and_then(Map::built_in_named);
    match (built_in, path) {
        (Some(map), _) => Ok(Some(map.clone())),
        (None, path) => {
            let map = path.map(Map::load).transpose()?;
            map.as_ref().map_or(Ok(()), Map::check_names)?;
            Ok(map)
        }
    }
}

/// The name of a built-in map, unless there is a file of that name.
fn built_in(path: Option<&Path>) -> Option<&str> {
    let name = path.filter(|path| !path.exists())?.to_str()?;
    Map::built_in_text(name).map(|_| name)
}

/// A map as an input of a card.
pub(crate) fn map_input(path: Option<&Path>) -> Result<Option<Input>> {
    let Some(path) = path else { return Ok(None) };
    match built_in(Some(path)).and_then(Map::built_in_text) {
        Some(text) => Ok(Some(Input {
            name: file_name(path),
            sha256: touchdown_log::sha256(text.as_bytes()),
        })),
        None => input(path).map(Some),
    }
}

/// A file as an input of a card.
pub(crate) fn input(path: &Path) -> Result<Input> {
    let bytes = std::fs::read(path).map_err(|e| Error::file(path, e))?;
    Ok(Input {
        name: file_name(path),
        sha256: touchdown_log::sha256(&bytes),
    })
}

/// Reads every log. One that cannot be read, or that holds no usable rows, is an error in its place; a map that
/// does not fit one of them stops everything, for it is wrong.
pub(crate) fn logs(
    context: &Context,
    paths: &[PathBuf],
    map: Option<&Map>,
) -> Result<Vec<Result<Log>>> {
    context.stage("reading", paths.len() as u64);
    let names = names(paths);
    let read: Vec<Result<Log>> = paths
        .par_iter()
        .zip(&names)
        .map(|(path, name)| {
            let read = touchdown_log::read_trial(path, map);
            context.step();
            let (trial, findings) = read?;
            Ok(Log {
                path: path.clone(),
                trial: trial.with_name(name),
                findings,
            })
        })
        .collect();
    let mut out = Vec::with_capacity(read.len());
    for log in read {
        match log {
            Err(e) if e.exit_status() == 2 => return Err(e),
            log => out.push(log),
        }
    }
    different(out.iter().flatten())?;
    let notes = out.iter().flatten().flat_map(|log| {
        let notes = log.findings.notes.iter();
        notes.map(|note| (log.path.clone(), note.clone()))
    });
    for note in once(notes) {
        context.aside(&note);
    }
    Ok(out)
}

/// A log given twice would count as two.
fn different<'a>(logs: impl Iterator<Item = &'a Log>) -> Result<()> {
    let mut seen: BTreeMap<&str, &Path> = BTreeMap::new();
    for log in logs {
        if let Some(first) = seen.insert(log.sha256(), &log.path) {
            return Err(Error::Arguments(format!(
                "expected different logs, because each log counts once; found {} and {} with the same content",
                first.display(),
                log.path.display()
            )));
        }
    }
    Ok(())
}

/// Reads every log; any that cannot be read is an error.
pub(crate) fn all_logs(
    context: &Context,
    paths: &[PathBuf],
    map: Option<&Map>,
) -> Result<Vec<Log>> {
    logs(context, paths, map)?.into_iter().collect()
}

/// The trials of logs.
pub(crate) fn trials(logs: &[Log]) -> Vec<Trial> {
    logs.iter().map(|log| log.trial.clone()).collect()
}

/// Rows that were dropped because something is wrong with them.
pub(crate) fn rows_dropped(logs: &[Log]) -> usize {
    logs.iter().map(|log| log.findings.rows_dropped()).sum()
}

/// Whether a log lost input.
pub(crate) fn lossy(logs: &[Log]) -> bool {
    logs.iter().any(|log| log.findings.is_lossy())
}

/// Names for trials, cards and figures: the files' stems, with a number where two are alike.
pub(crate) fn names(paths: &[PathBuf]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    paths
        .iter()
        .map(|path| {
            let stem = path.file_stem().map_or_else(
                || "log".to_string(),
                |stem| stem.to_string_lossy().into_owned(),
            );
            let mut name = stem.clone();
            let mut number = 2;
            // Files of a folder may differ in case only by name on some systems, and never on others.
            while !taken.insert(name.to_lowercase()) {
                name = format!("{stem}-{number}");
                number += 1;
            }
            name
        })
        .collect()
}

/// The names of files by their paths: the last part, or the path where another file is called so.
pub(crate) fn names_of(paths: BTreeSet<String>) -> impl Fn(&str) -> String {
    move |path| {
        let name = file_name(Path::new(path));
        let alike = paths.iter().filter(|p| file_name(Path::new(p)) == name);
        if alike.count() > 1 {
            path.to_owned()
        } else {
            name
        }
    }
}

/// The last part of a path.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_files_of_one_name_are_told_by_their_paths() {
        let paths = ["a/x.toml", "b/x.toml", "a/y.toml"].map(str::to_owned);
        let name = names_of(paths.into());
        let named = ["a/x.toml", "b/x.toml", "a/y.toml"].map(name);
        assert_eq!(named, ["a/x.toml", "b/x.toml", "y.toml"]);
    }

    #[test]
    fn analytic_names_are_unique() {
        let paths = ["a/x.csv", "b/x.csv", "X.csv", "y"].map(PathBuf::from);
        assert_eq!(names(&paths), ["x", "x-2", "X-3", "y"]);
    }
}
