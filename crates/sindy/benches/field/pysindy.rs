//! PySINDy on the same rows, by `pysindy_fits.py`; its coefficients are scored here, as ours are.

use std::ops::Range;
use std::path::Path;
use std::process::Command;

use serde::Deserialize;
use serde_json::{Map, Value, json};
use sindy::SindyError;
use sindy::model::Term;

use crate::Failure;
use crate::problems::Problem;
use crate::score::{Difference, median, scored};
use crate::simulate::truth;

/// The version that is compared with.
const VERSION: &str = "2.1.0";
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/field/pysindy_fits.py");

/// One setting of PySINDy on all seeds of a problem.
#[derive(Clone)]
pub(crate) struct Setting {
    pub(crate) name: String,
    /// By seed.
    pub(crate) fits: Vec<Difference>,
    /// PySINDy's own words, where it had no model for a seed.
    pub(crate) failure: Option<String>,
}

impl Setting {
    pub(crate) fn exact(&self) -> usize {
        self.fits.iter().filter(|f| f.is_exact()).count()
    }

    pub(crate) fn error(&self) -> f64 {
        median(self.fits.iter().map(|f| f.error).collect())
    }
}

/// PySINDy's fits of a problem.
pub(crate) struct Fits {
    seeds: Range<u64>,
    pub(crate) default: Setting,
    /// Of the grid and the default, the setting with the most exact seeds, and of these the smallest median error.
    pub(crate) best: Setting,
}

impl Fits {
    pub(crate) fn json(&self, problem: &str) -> Vec<Value> {
        let of = |program: &str, setting: &Setting| -> Vec<Value> {
            let seeds = self.seeds.clone().zip(&setting.fits);
            let line = |(seed, fit): (u64, &Difference)| {
                json!({
                    "program": program,
                    "problem": problem,
                    "seed": seed,
                    "exact": fit.is_exact(),
                    "error": fit.error,
                    "setting": setting.name,
                })
            };
            seeds.map(line).collect()
        };
        let default = of("PySINDy, default", &self.default);
        let best = of("PySINDy, best of grid", &self.best);
        [default, best].concat()
    }
}

/// A line of the script's output.
#[derive(Deserialize)]
pub(crate) struct Answer {
    seed: u64,
    pub(crate) setting: String,
    /// Coefficients by term, for each state.
    pub(crate) equations: Option<Vec<Map<String, Value>>>,
    /// Why there are none.
    pub(crate) error: Option<String>,
}

/// Why the interpreter cannot be used, if it cannot.
pub(crate) fn available(python: &Path) -> Result<(), String> {
    let shown = python.display();
    let asked = Command::new(python)
        .args(["-c", "import pysindy; print(pysindy.__version__)"])
        .output()
        .map_err(|e| format!("`{shown}` does not start: {e}"))?;
    let version = String::from_utf8_lossy(&asked.stdout).trim().to_owned();
    let what = match version.as_str() {
        VERSION => return Ok(()),
        "" => "no PySINDy".into(),
        other => format!("PySINDy {other}"),
    };
    Err(format!(
        "expected PySINDy {VERSION}; `{shown}` has {what}. Name an interpreter that has it with --python"
    ))
}

/// What PySINDy makes of the rows in a folder, one thread.
pub(crate) fn answers(python: &Path, folder: &Path, name: &str) -> Result<Vec<Answer>, Failure> {
    let run = Command::new(python)
        .arg(SCRIPT)
        .arg(folder)
        .env("OPENBLAS_NUM_THREADS", "1")
        .env("OMP_NUM_THREADS", "1")
        .output()?;
    if !run.status.success() {
        let words = String::from_utf8_lossy(&run.stderr);
        return Err(format!("PySINDy on {name}: {words}").into());
    }
    let text = String::from_utf8(run.stdout)?;
    let answers = text.lines().map(serde_json::from_str);
    Ok(answers.collect::<Result<_, _>>()?)
}

/// PySINDy's fits of a problem, whose rows are in a folder.
pub(crate) fn fits(
    python: &Path,
    folder: &Path,
    problem: &Problem,
    seeds: Range<u64>,
) -> Result<Fits, Failure> {
    let truth = truth(&problem.system)?;
    let mut settings: Vec<Setting> = Vec::new();
    for answer in answers(python, folder, &problem.name())? {
        let known = settings.iter().position(|s| s.name == answer.setting);
        let at = known.unwrap_or_else(|| {
            settings.push(Setting {
                name: answer.setting,
                fits: vec![Difference::NO_MODEL; seeds.clone().count()],
                failure: None,
            });
            settings.len() - 1
        });
        match answer.equations {
            Some(found) => {
                let found = equations(&found)?;
                let k = usize::try_from(answer.seed - seeds.start)?;
                settings[at].fits[k] = scored(problem, &truth, &found);
            }
            None => settings[at].failure = answer.error,
        }
    }
    let default = settings.first().ok_or("PySINDy printed no fit")?.clone();
    let better = |a: &&Setting, b: &&Setting| {
        let errors = a.error().total_cmp(&b.error());
        b.exact().cmp(&a.exact()).then(errors)
    };
    let best = settings.iter().min_by(better).unwrap_or(&default).clone();
    Ok(Fits {
        seeds,
        default,
        best,
    })
}

/// Of all states.
pub(crate) fn equations(found: &[Map<String, Value>]) -> Result<Vec<Vec<Term>>, SindyError> {
    found.iter().map(terms).collect()
}

fn terms(equation: &Map<String, Value>) -> Result<Vec<Term>, SindyError> {
    let term = |(name, value): (&String, &Value)| {
        // The script prints numbers alone.
        Term::parse(name, value.as_f64().unwrap_or(f64::NAN))
    };
    equation.iter().map(term).collect()
}
