//! The last page: how to redo this.

use crate::error::{Error, Result};
use crate::experiments::results::Results;
use crate::experiments::{Run, command};
use crate::settings::to_toml;
use touchdown_pages::page::{Page, how_made};

pub(super) fn write(page: &mut Page, run: &Run, results: &Results) -> Result<()> {
    let settings = to_toml(&run.settings.with_files_here())?;
    how_made(
        &mut page.report,
        &command(&run.settings),
        Some(("settings.toml", settings)),
    )?;
    page.text(format!(
        "Version `{}`, seed {}, SHA-256 of the settings `{}`. The same version gives the same figures with any number of threads.",
        results.version, results.seed, results.settings_sha256
    ));
    let mut files: Vec<String> = [
        "`results.json`: all figures of this report, for programs",
        "`settings.toml`: the settings below, for `--settings`",
        "`landings.csv`: every landing of the paper's experiments in a row; `sea.csv`: every landing at sea",
        "`cards/*.toml`: the model cards, for `touchdown validate`, `touchdown land` and flight",
        "`trials/*/*.csv`: the rig's trials, for `touchdown identify`",
        "`report.html`: this report",
    ]
    .map(String::from)
    .into();
    let names = page.figure_names().into_iter();
    files.extend(names.map(|name| format!("`figures/{name}.svg` and `.png`")));
    page.report.folded("Files beside this report", |inner| {
        inner.list(files);
        Ok::<(), Error>(())
    })?;
    Ok(())
}
