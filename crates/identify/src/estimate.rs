//! A fitted number with its standard error and interval, and the card's term that it becomes.

use nalgebra::DVector;
use serde::Serialize;
use sindy::Gram;
use sindy::statistics::regression::{ClusterErrors, Clusters, cluster_errors};
use sindy::trajectory::shooting::Refined;
use touchdown_model::card::Term;
use touchdown_model::unit;

/// A value with its standard error and 95 % confidence interval; both are NaN where they are not known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
}

impl Estimate {
    /// A value whose uncertainty is not known.
    pub(super) fn bare(value: f64) -> Self {
        Self {
            value,
            std_error: f64::NAN,
            ci95: [f64::NAN; 2],
        }
    }

    /// The same with another standard error beside its own; the interval grows in proportion.
    pub(super) fn beside(self, other: f64) -> Self {
        let std_error = self.std_error.hypot(other);
        let half = 0.5 * (self.ci95[1] - self.ci95[0]);
        let half = if self.std_error > 0.0 {
            half * std_error / self.std_error
        } else {
            1.96 * std_error
        };
        Self {
            value: self.value,
            std_error,
            ci95: [self.value - half, self.value + half],
        }
    }

    /// A value whose standard error comes from `clusters`: the interval is Student's t over them.
    pub(super) fn clustered(value: f64, std_error: f64, clusters: Clusters) -> Self {
        Self {
            value,
            std_error,
            ci95: clusters.interval(value, std_error).unwrap_or([f64::NAN; 2]),
        }
    }

    /// The coefficients of a regression on the terms of `support`, in their order; every group with data is a cluster.
    pub(super) fn of_regression(
        grams: &[Gram],
        coefficients: &DVector<f64>,
        support: &[bool],
    ) -> Vec<Self> {
        let errors = cluster_errors(grams, coefficients, support);
        let error = |j: usize| errors.as_ref().map_or(f64::NAN, |e| e[j]);
        let kept: Vec<usize> = (0..support.len()).filter(|&j| support[j]).collect();
        let clusters = Clusters {
            groups: grams.iter().filter(|g| g.rows > 0).count(),
            coefficients: kept.len(),
        };
        let of = |j| Self::clustered(coefficients[j], error(j), clusters);
        kept.into_iter().map(of).collect()
    }

    /// As [`of_regression`](Self::of_regression) for few groups, such as the steady points of a bench table: residuals
    /// are smaller than errors, and each coefficient has its own degrees of freedom.
    pub(super) fn of_few_groups(
        grams: &[Gram],
        coefficients: &DVector<f64>,
        support: &[bool],
    ) -> Vec<Self> {
        let errors = ClusterErrors::new(grams, coefficients, support);
        let of = |j: usize| {
            let value = coefficients[j];
            let errors = errors.as_ref();
            Self {
                value,
                std_error: errors.map_or(f64::NAN, |e| e.std_errors[j]),
                ci95: errors
                    .and_then(|e| e.interval(j, value))
                    .unwrap_or([f64::NAN; 2]),
            }
        };
        (0..support.len()).filter(|&j| support[j]).map(of).collect()
    }

    /// The parameters of a search by shooting.
    pub(super) fn refined(refined: &Refined, clusters: Clusters) -> impl Iterator<Item = Self> {
        let parameters = refined.parameters.iter().zip(&refined.std_errors);
        parameters.map(move |(&value, &error)| Self::clustered(value, error, clusters))
    }

    /// Whether the interval lies on one side of zero.
    #[must_use]
    pub fn differs_from_zero(&self) -> bool {
        self.ci95[0] > 0.0 || self.ci95[1] < 0.0
    }
}

/// A term of a card. An unknown standard error or interval is omitted.
pub(super) fn term(of: &str, expression: &str, estimate: Estimate, unit: &str) -> Term {
    let Estimate {
        value,
        std_error,
        ci95,
    } = estimate;
    Term {
        of: of.to_string(),
        expression: expression.to_string(),
        value,
        std_error: std_error.is_finite().then_some(std_error),
        ci95: ci95.iter().all(|v| v.is_finite()).then_some(ci95),
        unit: unit.to_string(),
        mark: None,
        upper_bound: None,
    }
}

/// The terms of the equation `of`; their units follow from the expressions.
pub(super) fn terms(of: &str, expressions: &[String], estimates: &[Estimate]) -> Vec<Term> {
    let pairs = expressions.iter().zip(estimates);
    pairs
        .map(|(expression, estimate)| {
            let unit = unit::of_coefficient(of, expression);
            term(of, expression, *estimate, &unit)
        })
        .collect()
}

/// The names of the terms in `support`.
pub(super) fn kept(names: &[String], support: &[bool]) -> Vec<String> {
    let pairs = names.iter().zip(support).filter(|(_, kept)| **kept);
    pairs.map(|(name, _)| name.clone()).collect()
}
