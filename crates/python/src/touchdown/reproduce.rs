//! The paper's experiments, run and written into a folder.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use touchdown_campaign::files;
use touchdown_campaign::progress::Progress;
use touchdown_reproduce::experiments::results::Results;
use touchdown_reproduce::settings::{Overrides, ReproduceSettings, parse};
use touchdown_reproduce::{Error, experiments, folder};

use super::land::Given;
use super::{of_campaign, of_card, of_identify, of_log, of_page, of_sim};
use crate::run::{self, Cancel};

/// Where a run is: the stage, steps that are done, steps of the stage.
#[derive(Clone, Default)]
struct Place {
    stage: String,
    done: u64,
    steps: u64,
}

/// Counts the steps of each stage, and tells the run of a Ctrl-C.
struct Counting {
    cancel: Cancel,
    place: Arc<Mutex<Place>>,
}

impl Counting {
    fn change(&self, change: impl FnOnce(&mut Place)) {
        self.cancel.heed();
        change(&mut self.place.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Progress for Counting {
    fn stage(&self, name: &str, steps: u64) {
        self.change(|place| {
            *place = Place {
                stage: name.to_owned(),
                done: 0,
                steps,
            };
        });
    }

    fn step(&self) {
        self.change(|place| place.done += 1);
    }
}

/// Runs the experiments and writes all files of `touchdown reproduce` into the folder `out`. `look` is called some twenty
/// times a second with the stage, its steps that are done, and its steps.
#[pyfunction]
#[pyo3(signature = (file, json, out, quick, trials, seed, jobs, look))]
#[expect(clippy::too_many_arguments, reason = "one for each of the command's")]
pub(crate) fn reproduce(
    py: Python<'_>,
    file: Option<PathBuf>,
    json: Option<&str>,
    out: PathBuf,
    quick: bool,
    trials: Option<usize>,
    seed: Option<u64>,
    jobs: Option<usize>,
    look: Option<Bound<'_, PyAny>>,
) -> PyResult<()> {
    let given = Given::of(file, json)?;
    let overrides = Overrides {
        quick,
        seed,
        trials,
    };
    let place = Arc::new(Mutex::new(Place::default()));
    let shown = Arc::clone(&place);
    let told = |_: Python<'_>| {
        let Some(look) = &look else {
            return Ok(());
        };
        let at = shown.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match at.stage.is_empty() {
            true => Ok(()),
            false => look.call1((at.stage, at.done, at.steps)).map(drop),
        }
    };
    let done = run::watched(py, jobs, told, move |cancel| {
        let cancel = cancel.clone();
        let progress = Counting { cancel, place };
        Ok(write(&given, overrides, &out, &progress))
    })?;
    done.map_err(of_run)
}

fn write(
    given: &Given,
    overrides: Overrides,
    out: &std::path::Path,
    progress: &dyn Progress,
) -> Result<(), Error> {
    let (given, named) = match given {
        Given::File(path) => {
            let settings = ReproduceSettings::from_file(path)?;
            (Some(settings), path.display().to_string())
        }
        Given::Keys(text) => (Some(parse(text, "settings")?), "settings".to_owned()),
        Given::None => (None, "settings".to_owned()),
    };
    let settings = overrides.of(given);
    experiments::check(&settings, &named)?;
    // A folder that cannot be written to is better known before the work than after it.
    files::folder(out)?;
    let run = experiments::run(&settings, progress)?;
    folder::write(&run, &Results::of(&run)?, out, progress)
}

/// An error of a run: of the disk, or of its settings.
pub(super) fn of_run(error: Error) -> PyErr {
    match error {
        Error::Campaign(touchdown_campaign::Error::File { path, source }) => {
            PyOSError::new_err(format!("{}: {source}", path.display()))
        }
        Error::Campaign(e) => of_campaign(&e),
        Error::Identification(e) => of_identify(&e),
        Error::Simulation(e) => of_sim(&e),
        Error::Card(e) => of_card(&e),
        Error::Trial(e) => of_identify(&touchdown_identify::Error::Trial(e)),
        Error::Log(e) => of_log("trials", &e),
        Error::Page(e) => of_page(&e),
    }
}
