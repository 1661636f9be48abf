//! Campaigns in their folders: begun, flown by ranges of blocks, read.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use pyo3::prelude::*;
use touchdown_campaign::progress::Progress;
use touchdown_campaign::sweep::{
    self, BlockRange, CampaignPart, Simulation, Store, Sweep, summarise,
};
use touchdown_campaign::{Error, Place};

use super::land::{Given, Heeding, SpaceLandings, settings_of};
use super::{of_campaign, of_page};
use crate::error;
use crate::run::{self, Cancel};

/// Where the files of a campaign are. Keys and endpoints of object storage are those of the environment.
pub(super) fn place(out: &Path) -> touchdown_campaign::Result<Place> {
    touchdown_storage::place(out, std::env::vars_os())
}

/// Counts landings, and tells them of a Ctrl-C.
struct Counting {
    heeding: Heeding,
    flown: Arc<AtomicU64>,
}

impl Counting {
    fn new(cancel: &Cancel, flown: Arc<AtomicU64>) -> Self {
        let heeding = Heeding(cancel.clone());
        Self { heeding, flown }
    }
}

impl Progress for Counting {
    fn stage(&self, _: &str, _: u64) {}

    fn step(&self) {
        self.heeding.step();
        self.flown.fetch_add(1, Ordering::Relaxed);
    }
}

/// Begins the folder of a campaign, or goes on with it: SHA-256, landings, landings in a block, and the blocks that are
/// missing.
#[pyfunction]
#[pyo3(signature = (file, json, out, trials, seed, resume, jobs))]
#[expect(clippy::too_many_arguments, reason = "one for each of the command's")]
pub(crate) fn campaign_begin(
    py: Python<'_>,
    file: Option<PathBuf>,
    json: Option<&str>,
    out: PathBuf,
    trials: Option<u64>,
    seed: Option<u64>,
    resume: bool,
    jobs: Option<usize>,
) -> PyResult<(String, u64, u64, Vec<u64>)> {
    let given = Given::of(file, json)?;
    let begun = run::owned(py, jobs, move |cancel| {
        Ok((|| {
            let (mut settings, folder, name) = settings_of(&given)?;
            settings.seed = seed.unwrap_or(settings.seed);
            settings.trials = trials.unwrap_or(settings.trials);
            let sweep = Sweep::new(settings, &folder, name)?;
            cancel.heed();
            let store = Store::open(&place(&out)?, &sweep, CampaignPart::Whole, resume)?;
            let present = store.present()?;
            let missing = (0..sweep.blocks()).filter(|block| present.binary_search(block).is_err());
            let (sha256, block) = (sweep.sha256().to_owned(), sweep.settings().block);
            Ok::<_, Error>((sha256, sweep.landings(), block, missing.collect()))
        })())
    })?;
    begun.map_err(|e| of_campaign(&e))
}

/// Flies the blocks from `first` to before `end` that are not in the folder yet. `look` is called some twenty times a
/// second with the number of landings that this call has flown.
#[pyfunction]
#[pyo3(signature = (folder, sha256, first, end, jobs, look))]
pub(crate) fn campaign_fly(
    py: Python<'_>,
    folder: PathBuf,
    sha256: String,
    first: u64,
    end: u64,
    jobs: Option<usize>,
    look: Option<Bound<'_, PyAny>>,
) -> PyResult<()> {
    let flown = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&flown);
    let told = |_: Python<'_>| match &look {
        Some(look) => look.call1((counted.load(Ordering::Relaxed),)).map(drop),
        None => Ok(()),
    };
    let done = run::watched(py, jobs, told, move |cancel| {
        Ok((|| {
            let place = place(&folder)?;
            let sweep = Sweep::of(&place)?;
            if sweep.sha256() != sha256 {
                return Err(Error::Arguments(format!(
                    "{place}: expected a campaign with SHA-256 {sha256}, found {}",
                    sweep.sha256()
                )));
            }
            let part = CampaignPart::Blocks(BlockRange::new(first..end).map_err(Error::Arguments)?);
            let store = Store::open(&place, &sweep, part, true)?;
            let progress = Counting::new(cancel, flown);
            let missing = sweep::missing(&sweep, &store, part)?;
            sweep::fly(&Simulation, &sweep, &store, &missing, &progress).map(drop)
        })())
    })?;
    done.map_err(|e| of_campaign(&e))
}

/// The blocks that are there, in their order. None is read.
#[pyfunction]
pub(crate) fn campaign_blocks(py: Python<'_>, folder: PathBuf) -> PyResult<Vec<u64>> {
    let present = run::owned(py, Some(1), move |_| {
        Ok(place(&folder).and_then(|place| Store::of(&place).present()))
    })?;
    present.map_err(|e| of_campaign(&e))
}

/// Reads all landings of a complete campaign.
#[pyfunction]
pub(crate) fn campaign_read(
    py: Python<'_>,
    folder: PathBuf,
    jobs: Option<usize>,
) -> PyResult<SpaceLandings> {
    let read = run::owned(py, jobs, move |_| {
        Ok((|| {
            let place = place(&folder)?;
            let sweep = Sweep::of(&place)?;
            let rows = Store::of(&place).read_all(&sweep)?;
            Ok::<_, Error>(SpaceLandings::new(Arc::new(sweep), rows))
        })())
    })?;
    read.map_err(|e| of_campaign(&e))
}

/// Writes `figures/` and `report.html` of a complete campaign into its folder: those of the command.
#[pyfunction]
pub(crate) fn campaign_report(
    py: Python<'_>,
    folder: PathBuf,
    jobs: Option<usize>,
) -> PyResult<()> {
    let written = run::owned(py, jobs, move |_| {
        Ok((|| {
            let place = place(&folder)?;
            let sweep = Sweep::of(&place)?;
            let rows = Store::of(&place).read_all(&sweep)?;
            let results = summarise(&sweep, &rows)?;
            let worst: Vec<u64> = results.worst.iter().map(|worst| worst.landing).collect();
            let traces = sweep::replay(&sweep, &worst)?;
            place.publish(|out| touchdown_pages::campaign(&sweep, &rows, &results, &traces, out))
        })())
    })?;
    written.map_err(|e| of_page(&e))
}

/// What of a campaign is there, as JSON: that of `touchdown campaign status`.
#[pyfunction]
pub(crate) fn campaign_status(
    py: Python<'_>,
    folder: PathBuf,
    jobs: Option<usize>,
) -> PyResult<String> {
    let status = run::owned(py, jobs, move |_| {
        Ok(place(&folder).and_then(|place| sweep::status(&place)))
    })?;
    let status = status.map_err(|e| of_campaign(&e))?;
    serde_json::to_string(&status).map_err(|e| error::settings("status", &e))
}
