//! What a fit is worth, and the table.

use serde_json::{Value, json};
use sindy::SindyError;
use sindy::identify::Identification;
use sindy::model::{Model, Term};

use crate::diffusion::Diffusion;
use crate::problems::Problem;
use crate::simulate::truth;

/// Warnings that call the model into question hold one of these; others are about the data.
const DOUBTS: &[&str] = &[
    "not in the library",
    "more likely absent than not",
    "did not converge",
    "could follow no trajectory",
    "equally likely",
    "about as likely",
    "other terms fit better",
];

/// Names of the columns, and the line below them.
pub(crate) const HEADER: [&str; 2] = [
    "| problem | exact terms | median error | worst coefficient | 95 % intervals that hold | warned | s |",
    "| --- | --- | --- | --- | --- | --- | --- |",
];

/// How equations differ from the true ones.
#[derive(Clone, Copy)]
pub(crate) struct Difference {
    /// Terms that are not true, and true ones that lack. No model has none.
    wrong: Option<(usize, usize)>,
    /// 2-norm of the coefficients' error over that of the true ones.
    pub(crate) error: f64,
    /// Largest relative error of a true coefficient.
    worst: f64,
}

impl Difference {
    /// Of no model.
    pub(crate) const NO_MODEL: Self = Self {
        wrong: None,
        error: f64::INFINITY,
        worst: f64::INFINITY,
    };

    pub(crate) fn new(truth: &[Vec<Term>], found: &[Vec<Term>]) -> Self {
        let mut wrong = (0, 0);
        let (mut square, mut norm, mut worst) = (0.0, 0.0, 0.0_f64);
        for (own, answer) in found.iter().zip(truth) {
            for t in answer {
                norm += t.coefficient * t.coefficient;
                let at = own.iter().find(|o| o.expression == t.expression);
                let off = at.map_or(0.0, |o| o.coefficient) - t.coefficient;
                square += off * off;
                worst = worst.max((off / t.coefficient).abs());
                wrong.1 += usize::from(at.is_none());
            }
            for o in own
                .iter()
                .filter(|o| answer.iter().all(|t| t.expression != o.expression))
            {
                square += o.coefficient * o.coefficient;
                wrong.0 += 1;
            }
        }
        Self {
            wrong: Some(wrong),
            error: (square / norm).sqrt(),
            worst,
        }
    }

    pub(crate) fn is_exact(&self) -> bool {
        self.wrong == Some((0, 0))
    }
}

/// The difference of the equations that are looked for.
pub(crate) fn scored(problem: &Problem, truth: &Model, found: &[Vec<Term>]) -> Difference {
    let from = problem.system.scored();
    Difference::new(&truth.equations()[from..], &found[from..])
}

/// One fit, scored.
pub(crate) struct Fitted {
    seed: u64,
    pub(crate) difference: Difference,
    /// True coefficients in their intervals, and intervals; of exact fits.
    held: (usize, usize),
    /// Where it is looked for, and there is a fit.
    pub(crate) diffusion: Option<Diffusion>,
    doubts: bool,
    warnings: Vec<String>,
    model: String,
    method: String,
    seconds: f64,
}

impl Fitted {
    pub(crate) fn new(
        problem: &Problem,
        seed: u64,
        found: &Result<Identification, SindyError>,
        seconds: f64,
    ) -> Result<Self, SindyError> {
        let found = match found {
            Ok(found) => found,
            Err(error) => return Ok(Self::failed(seed, error, seconds)),
        };
        let truth = truth(&problem.system)?;
        let difference = scored(problem, &truth, found.model.equations());
        Ok(Self {
            seed,
            held: if difference.is_exact() {
                held(&truth, found)
            } else {
                (0, 0)
            },
            difference,
            doubts: is_doubted(found),
            diffusion: None,
            warnings: found.warnings.clone(),
            model: format!("{:.4}", found.model),
            method: found.choice.method.clone(),
            seconds,
        })
    }

    /// An error is a warning, and no model.
    fn failed(seed: u64, error: &SindyError, seconds: f64) -> Self {
        Self {
            seed,
            difference: Difference::NO_MODEL,
            held: (0, 0),
            diffusion: None,
            doubts: true,
            warnings: vec![error.to_string()],
            model: String::new(),
            method: "error".into(),
            seconds,
        }
    }

    pub(crate) fn json(&self, problem: &str) -> Value {
        json!({
            "program": "sindy",
            "problem": problem,
            "seed": self.seed,
            "exact": self.difference.is_exact(),
            "extra_terms": self.difference.wrong.map(|w| w.0),
            "lacking_terms": self.difference.wrong.map(|w| w.1),
            "error": self.difference.error,
            "worst_coefficient": self.difference.worst,
            "intervals_held": self.held.0,
            "intervals": self.held.1,
            "diffusion": self.diffusion.as_ref().map(Diffusion::json),
            "doubts": self.doubts,
            "method": self.method,
            "warnings": self.warnings,
            "model": self.model,
            "seconds": self.seconds,
        })
    }
}

/// Whether a warning calls the model into question, or it did not converge.
pub(crate) fn is_doubted(found: &Identification) -> bool {
    let doubts = |w: &String| DOUBTS.iter().any(|d| w.contains(d));
    found.warnings.iter().any(doubts) || !found.outcome.is_success()
}

/// True coefficients in their intervals, and intervals.
fn held(truth: &Model, found: &Identification) -> (usize, usize) {
    let mut held = (0, 0);
    for ((own, answer), equation) in found
        .model
        .equations()
        .iter()
        .zip(truth.equations())
        .zip(&found.equations)
    {
        for t in answer {
            let at = own.iter().position(|o| o.expression == t.expression);
            if let Some([low, high]) = at.and_then(|k| equation.intervals[k]) {
                held.0 += usize::from(low <= t.coefficient && t.coefficient <= high);
                held.1 += 1;
            }
        }
    }
    held
}

/// The median; of an even number, the larger of the two in the middle.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A line of the table: all seeds of one problem.
pub(crate) fn row(problem: &Problem, fits: &[Fitted]) -> String {
    let n = fits.len();
    let count = |of: fn(&Fitted) -> bool| fits.iter().filter(|f| of(f)).count();
    let errors = fits.iter().map(|f| f.difference.error).collect();
    let worst = fits.iter().map(|f| f.difference.worst).fold(0.0, f64::max);
    let exact = match problem.is_complete() {
        true => format!("{} of {n}", count(|f| f.difference.is_exact())),
        false => "not in the library".into(),
    };
    let held: usize = fits.iter().map(|f| f.held.0).sum();
    let given: usize = fits.iter().map(|f| f.held.1).sum();
    let seconds: f64 = fits.iter().map(|f| f.seconds).sum();
    format!(
        "| {} | {exact} | {:.1e} | {:.1} % | {held} of {given} | {} of {n} | {seconds:.1} |",
        problem.name(),
        median(errors),
        100.0 * worst,
        count(|f| f.doubts),
    )
}

/// Counts over all fits.
pub(crate) fn summary(all: &[(&Problem, &Fitted)]) -> String {
    let of = |complete: bool| {
        all.iter()
            .filter(move |(p, _)| p.is_complete() == complete)
            .map(|(_, f)| *f)
    };
    let complete = of(true).count();
    let exact = of(true).filter(|f| f.difference.is_exact()).count();
    let false_alarms = of(true)
        .filter(|f| f.difference.is_exact() && f.doubts)
        .count();
    let confident = of(true)
        .filter(|f| !f.difference.is_exact() && !f.doubts)
        .count();
    let (lacking, warned) = (of(false).count(), of(false).filter(|f| f.doubts).count());
    let held: usize = of(true).map(|f| f.held.0).sum();
    let given: usize = of(true).map(|f| f.held.1).sum();
    format!(
        "\nTruth in the library: {exact} of {complete} fits exact, {false_alarms} of these with a doubt; {confident} wrong \
         without one.\nTruth not in the library: {warned} of {lacking} fits with a doubt.\n95 % intervals that hold, of \
         exact fits: {held} of {given}."
    )
}
