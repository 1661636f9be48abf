//! What a fit is worth, and the table.

use serde_json::{Value, json};
use sindy::SindyError;
use sindy::identify::Identification;

use crate::problems::Problem;
use crate::simulate::truth;

/// Warnings that call the model into question hold one of these; others are about the data.
const DOUBTS: &[&str] = &[
    "not in the library",
    "more likely absent than not",
    "did not converge",
    "could follow no trajectory",
    "equally likely",
];

pub(crate) const HEADER: &str = "| problem | exact terms | median error | worst coefficient | 95 % intervals that hold | warned | s |\n\
                          | --- | --- | --- | --- | --- | --- | --- |";

/// One fit, scored.
pub(crate) struct Fitted {
    seed: u64,
    exact: bool,
    /// Terms that are not true, and true ones that lack.
    wrong: (usize, usize),
    /// 2-norm of the coefficients' error over that of the true ones.
    error: f64,
    /// Largest relative error of a true coefficient.
    worst: f64,
    /// True coefficients in their intervals, and intervals; of exact fits.
    held: (usize, usize),
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
        found: Result<Identification, SindyError>,
        seconds: f64,
    ) -> Result<Self, SindyError> {
        let found = match found {
            Ok(found) => found,
            Err(error) => return Ok(Self::failed(seed, &error, seconds)),
        };
        let (mut wrong, mut held) = ((0, 0), (0, 0));
        let (mut square, mut norm, mut worst) = (0.0, 0.0, 0.0_f64);
        let truth = truth(&problem.system)?;
        for ((own, answer), equation) in found
            .model
            .equations()
            .iter()
            .zip(truth.equations())
            .zip(&found.equations)
        {
            for t in answer {
                norm += t.coefficient * t.coefficient;
                let at = own.iter().position(|o| o.expression == t.expression);
                let off = at.map_or(0.0, |k| own[k].coefficient) - t.coefficient;
                square += off * off;
                worst = worst.max((off / t.coefficient).abs());
                wrong.1 += usize::from(at.is_none());
                if let Some([low, high]) = at.and_then(|k| equation.intervals[k]) {
                    held.0 += usize::from(low <= t.coefficient && t.coefficient <= high);
                    held.1 += 1;
                }
            }
            for o in own
                .iter()
                .filter(|o| answer.iter().all(|t| t.expression != o.expression))
            {
                square += o.coefficient * o.coefficient;
                wrong.0 += 1;
            }
        }
        let exact = wrong == (0, 0);
        let doubts = |w: &String| DOUBTS.iter().any(|d| w.contains(d));
        Ok(Self {
            seed,
            exact,
            wrong,
            error: (square / norm).sqrt(),
            worst,
            held: if exact { held } else { (0, 0) },
            doubts: found.warnings.iter().any(doubts) || !found.outcome.is_success(),
            warnings: found.warnings,
            model: format!("{:.4}", found.model),
            method: found.choice.method,
            seconds,
        })
    }

    /// An error is a warning, and no model.
    fn failed(seed: u64, error: &SindyError, seconds: f64) -> Self {
        Self {
            seed,
            exact: false,
            wrong: (0, 0),
            error: f64::INFINITY,
            worst: f64::INFINITY,
            held: (0, 0),
            doubts: true,
            warnings: vec![error.to_string()],
            model: String::new(),
            method: "error".into(),
            seconds,
        }
    }

    pub(crate) fn json(&self, problem: &str) -> Value {
        json!({
            "problem": problem,
            "seed": self.seed,
            "exact": self.exact,
            "extra_terms": self.wrong.0,
            "lacking_terms": self.wrong.1,
            "error": self.error,
            "worst_coefficient": self.worst,
            "intervals_held": self.held.0,
            "intervals": self.held.1,
            "doubts": self.doubts,
            "method": self.method,
            "warnings": self.warnings,
            "model": self.model,
            "seconds": self.seconds,
        })
    }
}

/// A line of the table: all seeds of one problem.
pub(crate) fn row(problem: &Problem, fits: &[&Fitted]) -> String {
    let n = fits.len();
    let count = |of: fn(&Fitted) -> bool| fits.iter().filter(|f| of(f)).count();
    let mut errors: Vec<f64> = fits.iter().map(|f| f.error).collect();
    errors.sort_by(f64::total_cmp);
    let worst = fits.iter().map(|f| f.worst).fold(0.0, f64::max);
    let exact = match problem.is_complete() {
        true => format!("{} of {n}", count(|f| f.exact)),
        false => "not in the library".into(),
    };
    let held: usize = fits.iter().map(|f| f.held.0).sum();
    let given: usize = fits.iter().map(|f| f.held.1).sum();
    let seconds: f64 = fits.iter().map(|f| f.seconds).sum();
    format!(
        "| {} | {exact} | {:.1e} | {:.1} % | {held} of {given} | {} of {n} | {seconds:.1} |",
        problem.name(),
        errors[n / 2],
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
    let exact = of(true).filter(|f| f.exact).count();
    let false_alarms = of(true).filter(|f| f.exact && f.doubts).count();
    let confident = of(true).filter(|f| !f.exact && !f.doubts).count();
    let (lacking, warned) = (of(false).count(), of(false).filter(|f| f.doubts).count());
    let held: usize = of(true).map(|f| f.held.0).sum();
    let given: usize = of(true).map(|f| f.held.1).sum();
    format!(
        "\nTruth in the library: {exact} of {complete} fits exact, {false_alarms} of these with a doubt; {confident} wrong \
         without one.\nTruth not in the library: {warned} of {lacking} fits with a doubt.\n95 % intervals that hold, of \
         exact fits: {held} of {given}."
    )
}
