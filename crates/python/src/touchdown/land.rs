//! Landings: of the vertical vehicle, and in space.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::{PyArray1, PyArrayMethods as _};
use pyo3::IntoPyObjectExt as _;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::Value;
use touchdown_campaign::files;
use touchdown_campaign::progress::Progress;
use touchdown_campaign::settings_file;
use touchdown_campaign::sweep::{
    self, CampaignPart, LandingRow, Store, Sweep, SweepSettings, summarise,
};
use touchdown_campaign::{Error, Result};
use touchdown_sim::landing::space::{Case, SpaceScenario};

use super::campaign::place;
use super::{of_campaign, of_page};
use crate::error::{self, fault};
use crate::run::{self, Cancel};

/// Tells landings of a Ctrl-C.
pub(super) struct Heeding(pub(super) Cancel);

impl Progress for Heeding {
    fn stage(&self, _: &str, _: u64) {}

    fn step(&self) {
        self.0.heed();
    }
}

/// Settings from Python: a file, or JSON of keys.
pub(super) enum Given {
    File(PathBuf),
    Keys(String),
    None,
}

impl Given {
    /// Of the two that Python hands over.
    pub(super) fn of(file: Option<PathBuf>, json: Option<&str>) -> PyResult<Self> {
        match (file, json) {
            (Some(file), _) => Ok(Self::File(file)),
            (None, Some(json)) => {
                let table: toml::Table = error::read("scenario", json)?;
                let text = settings_file::to_toml(&table).map_err(|e| of_campaign(&e))?;
                Ok(Self::Keys(text))
            }
            (None, None) => Ok(Self::None),
        }
    }

    /// The scenario of a case with these keys over it, or those of a table in them.
    pub(super) fn over_case(&self, deck: &str, table: Option<&str>) -> Result<SpaceScenario> {
        let case = Case::named(deck).ok_or_else(|| {
            let names = Case::ALL.map(Case::name).join(", ");
            Error::Arguments(format!("key `deck`: expected one of {names}, found {deck}"))
        })?;
        let bad = |e: toml::de::Error| Error::Settings {
            file: "scenario".to_owned(),
            message: e.message().to_owned(),
        };
        let text = match self {
            Self::None => return Ok(case.scenario()),
            Self::Keys(text) => text.clone(),
            Self::File(path) => std::fs::read_to_string(path).map_err(|e| Error::file(path, e))?,
        };
        let mut keys: toml::Table = toml::from_str(&text).map_err(bad)?;
        if let Some(name) = table {
            keys = match keys.remove(name) {
                Some(toml::Value::Table(keys)) => keys,
                _ => return Ok(case.scenario()),
            };
        }
        let mut whole: toml::Table =
            toml::from_str(&settings_file::to_toml(&case.scenario())?).map_err(bad)?;
        settings_file::merge(&mut whole, keys);
        whole.try_into().map_err(bad)
    }
}

/// Files by name, as pickle takes and gives them.
pub(super) type Files = BTreeMap<String, Vec<u8>>;

/// A function that makes landings again, and its arguments: files, the first landing and their number.
type Restored<'py> = (Bound<'py, PyAny>, (Bound<'py, PyDict>, u64, usize));

/// Refuses an address as the folder of a report.
pub(super) fn local(folder: &Path) -> PyResult<()> {
    if folder.as_os_str().is_empty() || touchdown_files::is_address(folder) {
        let (expected, found) = ("a folder", folder.display().to_string());
        let message = format!("folder: expected {expected}, found `{found}`");
        return Err(fault(message, "folder", expected, &found));
    }
    Ok(())
}

/// Files as `bytes` by name.
pub(super) fn in_bytes<'py>(py: Python<'py>, files: &Files) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for (name, bytes) in files {
        out.set_item(name, PyBytes::new(py, bytes))?;
    }
    Ok(out)
}

/// Landings in space that were flown.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct SpaceLandings {
    sweep: Arc<Sweep>,
    rows: Vec<LandingRow>,
}

impl SpaceLandings {
    pub(super) fn new(sweep: Arc<Sweep>, rows: Vec<LandingRow>) -> Self {
        Self { sweep, rows }
    }
}

/// Files of the cards for thrust, `empirical` and `dynamic`.
pub(super) type CardFiles = [Option<PathBuf>; 3];

/// Cards that are given go before those of the settings.
pub(super) fn put_cards(settings: &mut SweepSettings, [thrust, empirical, dynamic]: CardFiles) {
    let paths = &mut settings.cards;
    paths.thrust = thrust.or(paths.thrust.take());
    paths.empirical = empirical.or(paths.empirical.take());
    paths.dynamic = dynamic.or(paths.dynamic.take());
}

/// Settings with the folder of the files that they name, and what errors call them.
pub(super) fn settings_of(given: &Given) -> Result<(SweepSettings, PathBuf, String)> {
    let here = || PathBuf::from(".");
    let (settings, folder, name) = match given {
        Given::File(path) => {
            let folder = path.parent().map_or_else(here, Path::to_owned);
            (
                SweepSettings::read(path)?,
                folder,
                path.display().to_string(),
            )
        }
        Given::Keys(text) => (
            SweepSettings::parse(text, "scenario")?,
            here(),
            "scenario".into(),
        ),
        Given::None => {
            let settings = SweepSettings {
                trials: 40,
                scenario: Case::Paper.scenario(),
                ..SweepSettings::default()
            };
            (settings, here(), "scenario".into())
        }
    };
    if settings.autopilot.is_some() {
        return Err(Error::Settings {
            file: name,
            message: "key `autopilot`: expected none, found some".to_owned(),
        });
    }
    Ok((settings, folder, name))
}

/// Flies landings in space as `touchdown land --space` does. `cards`: thrust, empirical, dynamic.
#[pyfunction]
#[pyo3(signature = (file, json, cards, controllers, policy, trials, seed, deck_acceleration, jobs))]
#[expect(clippy::too_many_arguments, reason = "one for each of the command's")]
pub(crate) fn land_in_space(
    py: Python<'_>,
    file: Option<PathBuf>,
    json: Option<&str>,
    cards: CardFiles,
    controllers: Vec<String>,
    policy: Option<PathBuf>,
    trials: Option<u64>,
    seed: Option<u64>,
    deck_acceleration: bool,
    jobs: Option<usize>,
) -> PyResult<SpaceLandings> {
    let given = Given::of(file, json)?;
    let flown = run::owned(py, jobs, move |cancel| {
        Ok((|| {
            let (mut settings, folder, name) = settings_of(&given)?;
            settings.seed = seed.unwrap_or(settings.seed);
            settings.trials = trials.unwrap_or(settings.trials);
            put_cards(&mut settings, cards);
            if !deck_acceleration {
                settings.scenario.control.deck_acceleration = false;
            }
            settings.set_controllers(controllers, policy);
            let sweep = Sweep::new(settings, &folder, name)?;
            cancel.heed();
            let progress = Heeding(cancel.clone());
            let rows = sweep::rows(&sweep, 0..sweep.landings(), &progress)?;
            Ok((sweep, rows))
        })())
    })?;
    let (sweep, rows) = flown.map_err(|e| of_campaign(&e))?;
    Ok(SpaceLandings::new(Arc::new(sweep), rows))
}

#[pymethods]
impl SpaceLandings {
    /// Landings.
    fn __len__(&self) -> usize {
        self.rows.len()
    }

    /// The table: numbers as arrays (an absent one is NaN), texts as lists.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = PyDict::new(py);
        let trials = self.sweep.trials();
        let whole = |of: &dyn Fn(&LandingRow) -> u64| {
            PyArray1::from_iter(py, self.rows.iter().map(|row| of(row) as i64))
        };
        table.set_item("landing", whole(&|row| row.landing))?;
        table.set_item("trial", whole(&|row| row.landing % trials))?;
        for (k, (key, values)) in self.sweep.grid().iter().enumerate() {
            let at = |row: &LandingRow| &values[self.sweep.places(row.landing / trials)[k]];
            let values: Vec<_> = self.rows.iter().map(at).collect();
            set_settings(&table, key, &values)?;
        }
        let texts = |of: &dyn Fn(&LandingRow) -> Option<String>| -> Vec<Option<String>> {
            self.rows.iter().map(of).collect()
        };
        table.set_item("outcome", texts(&|row| Some(row.outcome.clone())))?;
        table.set_item("why", texts(&|row| row.why.clone()))?;
        table.set_item("abort_reasons", texts(&|row| row.abort_reasons.clone()))?;
        // After the three texts: counts, then numbers.
        let header = LandingRow::header();
        let counts = self.rows.first().map_or(0, |row| row.counts.len());
        let (counts, numbers) = header[3..].split_at(counts);
        for (k, name) in counts.iter().enumerate() {
            table.set_item(name, whole(&|row| row.counts[k]))?;
        }
        for name in numbers {
            let values = self
                .rows
                .iter()
                .map(|row| row.number(name).unwrap_or(f64::NAN));
            table.set_item(name, PyArray1::from_iter(py, values))?;
        }
        let draws = self
            .rows
            .iter()
            .map(|r| self.sweep.draws(r.landing % trials));
        let draws: Vec<_> = draws.collect();
        for (k, key) in self.sweep.drawn().enumerate() {
            let values: Vec<_> = draws.iter().map(|of| &of[k]).collect();
            set_settings(&table, key, &values)?;
        }
        Ok(table)
    }

    /// Figures of every point, in JSON: those of `results.json`.
    fn results(&self, py: Python<'_>) -> PyResult<String> {
        let results = py
            .detach(|| summarise(&self.sweep, &self.rows))
            .map_err(|e| of_campaign(&e))?;
        serde_json::to_string(&results).map_err(|e| error::settings("results", &e))
    }

    /// What [`Self::__reduce__`] gives.
    #[staticmethod]
    fn restored(files: Files, first: u64, landings: u64) -> PyResult<Self> {
        let (sweep, rows) = sweep::unpack(files, first, landings).map_err(|e| of_campaign(&e))?;
        Ok(Self::new(Arc::new(sweep), rows))
    }

    /// For pickle and copy.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Restored<'py>> {
        let files = sweep::pack(&self.sweep, &self.rows).map_err(|e| of_campaign(&e))?;
        let first = self.rows.first().map_or(0, |row| row.landing);
        let restored = py.get_type::<Self>().getattr("restored")?;
        Ok((restored, (in_bytes(py, &files)?, first, self.rows.len())))
    }

    /// Writes the figures of a campaign into its folder, with the bytes of the command's `summary.csv` and `results.json`.
    fn write_results(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let written = py.detach(|| -> Result<()> {
            let results = summarise(&self.sweep, &self.rows)?;
            let place = place(&folder)?;
            // What killed workers left half-written is taken away.
            Store::open(&place, &self.sweep, CampaignPart::Whole, true)?;
            place.publish(|out| {
                files::write(&out.join("summary.csv"), results.csv()?.as_bytes())?;
                files::results(out, &results)
            })
        });
        written.map_err(|e| of_campaign(&e))
    }

    /// Writes `report.html` and `figures/` into a folder, as the command does, and the sweep with the files that it names.
    fn report(&self, py: Python<'_>, folder: PathBuf, jobs: Option<usize>) -> PyResult<()> {
        local(&folder)?;
        let (sweep, rows) = (Arc::clone(&self.sweep), self.rows.clone());
        let written = run::owned(py, jobs, move |_| {
            Ok((|| -> std::result::Result<(), touchdown_pages::Error> {
                files::folder(&folder)?;
                let settings = settings_file::to_toml(sweep.settings())?;
                let named = [("sweep.toml", settings.as_bytes())].into_iter();
                for (name, bytes) in named.chain(sweep.files()) {
                    files::write(&folder.join(name), bytes)?;
                }
                let results = summarise(&sweep, &rows)?;
                let worst: Vec<u64> = results.worst.iter().map(|worst| worst.landing).collect();
                let traces = sweep::replay(&sweep, &worst)?;
                touchdown_pages::campaign(&sweep, &rows, &results, &traces, &folder)
            })())
        })?;
        written.map_err(|e| of_page(&e))
    }

    /// The sweep that was flown, as TOML.
    fn sweep_toml(&self) -> PyResult<String> {
        settings_file::to_toml(self.sweep.settings()).map_err(|e| of_campaign(&e))
    }

    /// The time series of the landing of a row, which is flown once more for it.
    fn trace<'py>(&self, py: Python<'py>, row: usize) -> PyResult<Bound<'py, PyDict>> {
        let sweep = Arc::clone(&self.sweep);
        let landing = self.rows.get(row).map(|row| row.landing).ok_or_else(|| {
            let expected = format!("a row of the table, from 0 to {}", self.rows.len() - 1);
            let message = format!("landing: expected {expected}, found {row}");
            fault(message, "landing", &expected, &row.to_string())
        })?;
        let flown = run::owned(py, None, move |_| Ok(sweep::replay(&sweep, &[landing])))?;
        let mut traces = flown.map_err(|e| of_campaign(&e))?;
        let rows = traces.pop().map_or_else(Vec::new, |trace| trace.rows);
        let rows: Vec<Value> = rows
            .iter()
            .map(serde_json::to_value)
            .collect::<std::result::Result<_, _>>()
            .map_err(|e| error::settings("trace", &e))?;
        series(py, &rows)
    }
}

/// A column of swept or drawn settings: numbers if all are, else texts.
fn set_settings(table: &Bound<'_, PyDict>, key: &str, values: &[&toml::Value]) -> PyResult<()> {
    let numbers: Option<Vec<f64>> = values.iter().map(|value| sweep::number(value)).collect();
    match numbers {
        Some(numbers) => table.set_item(key, PyArray1::from_vec(table.py(), numbers)),
        None => {
            let texts: Vec<String> = values.iter().map(|value| sweep::text(value)).collect();
            table.set_item(key, texts)
        }
    }
}

/// Rows of named values as named arrays: a number a row, or several, or texts; what is absent is NaN.
fn series<'py>(py: Python<'py>, rows: &[Value]) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let Some(Value::Object(first)) = rows.first() else {
        return Ok(out);
    };
    for key in first.keys() {
        let of = |row: &Value| row.get(key).cloned().unwrap_or(Value::Null);
        let column: Vec<Value> = rows.iter().map(of).collect();
        let width = column
            .iter()
            .filter_map(Value::as_array)
            .map(Vec::len)
            .max();
        let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
        let values = if let Some(width) = width {
            let row = |value: &Value| -> Vec<f64> {
                let of = value.as_array().map(Vec::as_slice).unwrap_or_default();
                (0..width)
                    .map(|k| of.get(k).map_or(f64::NAN, number))
                    .collect()
            };
            let flat: Vec<f64> = column.iter().flat_map(row).collect();
            PyArray1::from_vec(py, flat)
                .reshape([rows.len(), width])?
                .into_any()
        } else if column
            .iter()
            .any(|value| value.is_string() || value.is_object())
        {
            let text = |value: &Value| match value {
                Value::Null => None,
                Value::String(text) => Some(text.clone()),
                other => Some(other.to_string()),
            };
            column
                .iter()
                .map(text)
                .collect::<Vec<_>>()
                .into_bound_py_any(py)?
        } else {
            PyArray1::from_iter(py, column.iter().map(number)).into_any()
        };
        out.set_item(key, values)?;
    }
    Ok(out)
}
