//! Squared diffusions `g²` of `dx = f dt + g dW`, scored beside the drift. PySINDy has none.

use serde_json::{Value, json};
use sindy::SindyError;
use sindy::identify::Identification;
use sindy::model::{Model, Term};

use crate::problems::Problem;
use crate::score::{Difference, Fitted, median};

/// Candidates of each squared diffusion.
pub(crate) const CANDIDATES: &str = "poly(2)";

/// Names of the columns, and the line below them.
const HEADER: &str = "| problem | exact squared diffusion | median error | 95 % intervals that hold | warned of without the \
     option |\n| --- | --- | --- | --- | --- |\n";

/// The diffusion of one fit, scored.
pub(crate) struct Diffusion {
    difference: Difference,
    /// True coefficients in their intervals, and intervals; of exact diffusions.
    held: (usize, usize),
    /// Whether a fit that takes diffusions for constants warns that they are not.
    warned_without: bool,
}

impl Diffusion {
    pub(crate) fn new(
        truth: &Model,
        found: &Identification,
        without: Result<Identification, SindyError>,
    ) -> Result<Self, SindyError> {
        let mut terms = Vec::new();
        for equation in &found.equations {
            let own = equation.diffusion.iter();
            let own = own.map(|t| Term::parse(&t.term, t.coefficient));
            terms.push(own.collect::<Result<Vec<_>, _>>()?);
        }
        let difference = Difference::new(truth.equations(), &terms);
        let mut held = (0, 0);
        for ((own, terms), answer) in found.equations.iter().zip(&terms).zip(truth.equations()) {
            for t in answer.iter().filter(|_| difference.is_exact()) {
                let at = terms.iter().position(|o| o.expression == t.expression);
                if let Some([low, high]) = at.and_then(|k| own.diffusion[k].interval) {
                    held.0 += usize::from(low <= t.coefficient && t.coefficient <= high);
                    held.1 += 1;
                }
            }
        }
        let names_option = |found: Identification| {
            let warnings = found.warnings.iter();
            warnings.clone().any(|w| w.contains("--diffusion"))
        };
        Ok(Self {
            difference,
            held,
            warned_without: without.is_ok_and(names_option),
        })
    }

    pub(crate) fn json(&self) -> Value {
        json!({
            "exact": self.difference.is_exact(),
            "error": self.difference.error,
            "intervals_held": self.held.0,
            "intervals": self.held.1,
            "warned_without": self.warned_without,
        })
    }
}

/// A table of the problems whose diffusion is looked for; none where there are none.
pub(crate) fn table(chosen: &[&Problem], fits: &[Vec<Fitted>]) -> Option<String> {
    let mut out = String::from(HEADER);
    for (problem, fits) in chosen.iter().zip(fits) {
        let own: Vec<&Diffusion> = fits.iter().filter_map(|f| f.diffusion.as_ref()).collect();
        if own.is_empty() {
            continue;
        }
        let n = fits.len();
        let exact = own.iter().filter(|d| d.difference.is_exact()).count();
        let error = median(own.iter().map(|d| d.difference.error).collect());
        let held: usize = own.iter().map(|d| d.held.0).sum();
        let intervals: usize = own.iter().map(|d| d.held.1).sum();
        let warned = own.iter().filter(|d| d.warned_without).count();
        let name = problem.name();
        out += &format!(
            "| {name} | {exact} of {n} | {error:.1e} | {held} of {intervals} | {warned} of {n} |\n"
        );
    }
    (out.len() > HEADER.len()).then_some(out)
}
