//! A fitted number with its standard error, and the card's term that it becomes.

use sindy::statistics::regression::Clusters;
use touchdown_model::card::Term;

/// A fitted number: its value, and its standard error (NaN where it is not known) with what that rests on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) std_error: f64,
    pub(super) clusters: Clusters,
}

impl Estimate {
    /// A number that nothing is known about but its value.
    pub(super) fn bare(value: f64) -> Self {
        Self {
            value,
            std_error: f64::NAN,
            clusters: Clusters {
                groups: 0,
                coefficients: 0,
            },
        }
    }
}

/// A term; a standard error that is not a number is left out, and so is the interval.
pub(super) fn term(of: &str, expression: &str, estimate: Estimate, unit: &str) -> Term {
    let Estimate {
        value, std_error, ..
    } = estimate;
    Term {
        of: of.to_string(),
        expression: expression.to_string(),
        value,
        std_error: std_error.is_finite().then_some(std_error),
        ci95: estimate.clusters.interval(value, std_error),
        unit: unit.to_string(),
    }
}
