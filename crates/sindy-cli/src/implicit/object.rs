//! The object of `implicit --json`.

use serde::Serialize;
use sindy::Outcome;
use sindy::implicit::{ComparedRelation, ImplicitIdentification, RationalEquation, RationalTerm};

use crate::fit::object::{DataObject, TermObject};
use crate::named::Named;
use crate::trajectories::FileReport;

/// The result of an identification of implicit equations.
#[derive(Serialize)]
pub(super) struct ImplicitObject {
    /// The equations as text.
    pub(super) text: Vec<String>,
    pub(super) equations: Named<EquationObject>,
    /// How the equations were chosen.
    pub(super) reason: String,
    pub(super) outcome: Outcome,
    pub(super) warnings: Vec<String>,
    pub(super) data: DataObject,
    version: &'static str,
}

/// The equation of a state.
#[derive(Serialize)]
pub(super) struct EquationObject {
    pub(super) numerator: Vec<TermObject>,
    /// The term whose coefficient is held at 1 comes first; it alone, and `1`, where the equation is a plain sum.
    pub(super) denominator: Vec<TermObject>,
    /// Estimated noise of the state, and what the model leaves of it.
    pub(super) noise: f64,
    pub(super) residual: Option<f64>,
    /// Relations that were compared by their trajectories, best first; `against` is twice the logarithm of the odds against one,
    /// null where its trajectories cannot be followed.
    pub(super) compared: Vec<ComparedRelation>,
}

impl ImplicitObject {
    pub(super) fn new(found: &ImplicitIdentification, files: Vec<FileReport>) -> Self {
        let term = |t: &RationalTerm| TermObject {
            term: t.term.clone(),
            coefficient: t.coefficient,
            std_error: t.std_error,
            inclusion: t.inclusion,
            interval: t.interval,
        };
        let equation = |e: &RationalEquation| EquationObject {
            numerator: e.numerator.iter().map(term).collect(),
            denominator: e.denominator.iter().map(term).collect(),
            noise: e.noise,
            residual: e.residual,
            compared: e.compared.clone(),
        };
        let of_files = files.iter().flat_map(|f| &f.warnings);
        Self {
            text: found.equations.iter().map(|e| format!("{e:.5}")).collect(),
            equations: Named::new(found.model.states(), found.equations.iter().map(equation)),
            reason: found.reason.clone(),
            outcome: found.outcome,
            warnings: of_files.chain(&found.warnings).cloned().collect(),
            data: DataObject {
                report: found.data,
                files,
            },
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}
