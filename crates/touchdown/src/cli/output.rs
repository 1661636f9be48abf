//! What commands write.

use std::path::Path;

use serde::Serialize;
use touchdown::{Error, Result};

use super::context::Context;

use touchdown_campaign::files;
pub(crate) use touchdown_campaign::files::{RESULTS, folder, write};
pub(crate) use touchdown_campaign::sweep::must_not_be_a_campaign;

/// Writes the results into their folder.
pub(crate) fn results<T: Serialize>(folder: &Path, results: &T) -> Result<()> {
    Ok(files::results(folder, results)?)
}

/// Refuses an `--out` that is a file, before any work is done.
pub(crate) fn must_not_be_a_file(out: Option<&Path>) -> Result<()> {
    match out.filter(|out| out.is_file()) {
        None => Ok(()),
        Some(out) => Err(Error::Arguments(format!(
            "--out {}: expected a folder, found a file",
            out.display()
        ))),
    }
}

/// Checks that a file which will be written is not one that the command reads, under whatever name.
pub(crate) fn replaces_not(written: &Path, what: &str, input: &Path) -> Result<()> {
    if same_file::is_same_file(written, input).unwrap_or(false) {
        return Err(Error::Arguments(format!(
            "--out: {} would replace the {what} {}; choose another place",
            written.display(),
            input.display()
        )));
    }
    Ok(())
}

/// Creates a folder for results, without the results of an earlier run. That of a campaign is refused.
pub(crate) fn results_folder(context: &Context, path: &Path) -> Result<()> {
    must_not_be_a_campaign(path)?;
    files::begin_results(path)?;
    announce_results(context, path);
    Ok(())
}

/// Results are written into a folder from now on. An interrupted command reports whether they are complete.
pub(crate) fn announce_results(context: &Context, path: &Path) {
    let results = path.join(RESULTS);
    let folder = path.display().to_string();
    context.if_interrupted(move || match results.exists() {
        true => format!("all files are in {folder}"),
        false => missing(&folder),
    });
}

/// Report of an interrupted command about an incomplete folder.
pub(crate) fn missing(folder: &str) -> String {
    format!(
        "the files in {folder} are complete, but some are missing ({RESULTS} is written last); run the same command again"
    )
}
