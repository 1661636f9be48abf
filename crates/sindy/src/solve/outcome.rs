//! Why a solver stopped: one type for all solvers.

/// Why a solver stopped. A solver that did not converge is an outcome, not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Outcome {
    /// The support and the coefficients no longer change.
    Converged,
    /// The iteration limit was reached first.
    IterationLimit,
    /// The support returned to an earlier one without settling.
    Cycled,
    /// Every term was dropped: the threshold or the penalty is larger than every coefficient.
    Empty,
    /// The terms that are kept cannot meet the constraints.
    Infeasible,
    /// The search is complete: proven to be the best there is.
    Optimal,
    /// The search reached its node limit first; the gap states the unproven part.
    NodeLimit,
    /// The caller ended the search; the gap states the unproven part.
    Stopped,
    /// The search is complete, but only to the relative tolerance that was asked for.
    WithinTolerance,
}

impl Outcome {
    /// Whether the solver ended of itself, with a result that stands.
    #[must_use]
    pub fn is_success(self) -> bool {
        matches!(
            self,
            Self::Converged | Self::Empty | Self::Optimal | Self::WithinTolerance
        )
    }
}
