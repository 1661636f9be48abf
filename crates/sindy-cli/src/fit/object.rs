//! The object of `fit --json`.

use serde::Serialize;
use sindy::Outcome;
use sindy::data::dataset::DataReport;
use sindy::identify::{Candidate, Choice, DiffusionTerm, Equation, Identification, Stability};
use sindy::model::Term;

use super::score::TestObject;
use crate::named::Named;
use crate::numbers::significant;
use crate::trajectories::FileReport;

/// The result of a fit.
#[derive(Serialize)]
pub(super) struct FitObject {
    /// The terms of each state's equation.
    pub(super) equations: Named<Vec<TermObject>>,
    /// The terms of each state's squared diffusion, `var(dx)/dt`, where they were found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) diffusion: Option<Named<Vec<TermObject>>>,
    pub(super) choice: Choice,
    pub(super) outcome: Outcome,
    /// Why all trajectories stay bounded, with --stable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) stability: Option<Stability>,
    pub(super) warnings: Vec<String>,
    /// Terms against error, for each state.
    pub(super) front: Named<Front>,
    /// The models that were compared.
    pub(super) candidates: Vec<Candidate>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) test: Option<TestObject>,
    pub(super) data: DataObject,
    pub(super) version: &'static str,
}

/// A term that was found.
#[derive(Clone, Serialize)]
pub(crate) struct TermObject {
    pub(crate) term: String,
    pub(crate) coefficient: f64,
    pub(crate) std_error: Option<f64>,
    pub(crate) inclusion: Option<f64>,
    /// 95 %, with Student's t where the standard error rests on little.
    pub(crate) interval: Option<[f64; 2]>,
}

impl TermObject {
    fn of(term: &Term, interval: Option<[f64; 2]>) -> Self {
        Self {
            term: term.expression.to_string(),
            coefficient: term.coefficient,
            std_error: term.std_error,
            inclusion: term.inclusion,
            interval,
        }
    }
}

impl From<&DiffusionTerm> for TermObject {
    fn from(term: &DiffusionTerm) -> Self {
        Self {
            term: term.term.clone(),
            coefficient: term.coefficient,
            std_error: Some(term.std_error),
            inclusion: Some(term.inclusion),
            interval: term.interval,
        }
    }
}

/// Terms against error of one state's equation.
#[derive(Serialize)]
pub(crate) struct Front {
    /// Meaning and unit of the error.
    pub(crate) unit: &'static str,
    /// Estimated noise of the state.
    pub(crate) noise: f64,
    /// Root mean square of what the model leaves of the state, where it followed the trajectories.
    pub(crate) residual: Option<f64>,
    /// Standard deviation by which disturbances move the state in a unit of time, where the system is taken to be disturbed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) disturbance: Option<f64>,
    pub(crate) points: Vec<FrontPoint>,
}

/// The best equation of a size.
#[derive(Serialize)]
pub(crate) struct FrontPoint {
    /// The number of terms.
    pub(crate) terms: usize,
    pub(crate) error: f64,
    /// Whether no other terms of this number are better, by proof.
    pub(crate) proven: bool,
    /// Whether these are the model's terms.
    pub(crate) chosen: bool,
    pub(crate) names: Vec<String>,
}

impl FrontPoint {
    pub(crate) fn of(p: &sindy::identify::FrontPoint) -> Self {
        Self {
            terms: p.terms.len(),
            error: p.error,
            proven: p.proven,
            chosen: p.chosen,
            names: p.terms.clone(),
        }
    }
}

impl Front {
    fn of(equation: &Equation) -> Self {
        Self {
            unit: equation.unit,
            noise: equation.noise,
            residual: equation.residual,
            disturbance: equation.disturbance,
            points: equation.front.iter().map(FrontPoint::of).collect(),
        }
    }
}

impl FitObject {
    pub(super) fn new(
        found: &Identification,
        files: Vec<FileReport>,
        test: Option<TestObject>,
        warnings: Vec<String>,
    ) -> Self {
        let states = found.model.states();
        // Past states, which a model may hold beyond those that were asked for, have no uncertainty.
        let terms = found
            .model
            .equations()
            .iter()
            .enumerate()
            .map(|(i, terms)| {
                let of = found.equations.get(i);
                let interval = |k: usize| of.and_then(|e| e.intervals.get(k).copied().flatten());
                let term = |(k, term)| TermObject::of(term, interval(k));
                terms.iter().enumerate().map(term).collect()
            });
        let diffusion = |e: &Equation| e.diffusion.iter().map(TermObject::from).collect();
        let has_diffusion = found.equations.iter().any(|e| !e.diffusion.is_empty());
        let all = || Named::new(states, found.equations.iter().map(diffusion));
        Self {
            equations: Named::new(states, terms),
            diffusion: has_diffusion.then(all),
            choice: found.choice.clone(),
            outcome: found.outcome,
            stability: found.stability.clone(),
            warnings,
            front: Named::new(states, found.equations.iter().map(Front::of)),
            candidates: found.candidates.clone(),
            test,
            data: DataObject {
                report: found.data,
                files,
            },
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// The data of the fit.
#[derive(Serialize)]
pub(crate) struct DataObject {
    #[serde(flatten)]
    pub(crate) report: DataReport,
    pub(crate) files: Vec<FileReport>,
}

impl DataObject {
    /// One line for people.
    pub(crate) fn summary(&self) -> String {
        let r = &self.report;
        let count = |n: usize, one: &str, many: &str| match n {
            1 => format!("1 {one}"),
            n => format!("{n} {many}"),
        };
        let mut parts = vec![
            count(r.rows, "row", "rows"),
            count(r.trajectories, "trajectory", "trajectories"),
        ];
        if r.stretches != r.trajectories {
            parts.push(count(
                r.stretches,
                "stretch without gaps",
                "stretches without gaps",
            ));
        }
        if r.missing_rows > 0 {
            parts.push(format!(
                "{} with empty cells",
                count(r.missing_rows, "row", "rows")
            ));
        }
        if r.short_rows > 0 {
            parts.push(format!(
                "{} in stretches too short to use",
                count(r.short_rows, "row", "rows")
            ));
        }
        parts.push(match r.uniform {
            true => format!("every {}", significant(r.period, 6)),
            false => format!("unevenly spaced, median step {}", significant(r.period, 6)),
        });
        let mut times: Vec<&str> = self
            .files
            .iter()
            .filter_map(|f| f.time.as_deref())
            .collect();
        times.dedup();
        if !times.is_empty() {
            parts.push(format!("time from `{}`", times.join("`, `")));
        }
        parts.join(", ")
    }
}
