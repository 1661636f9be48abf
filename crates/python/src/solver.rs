//! Sparse solvers from their description.

use serde::Deserialize;
use sindy::solve::exact::BestBy;
use sindy::solve::relaxed::{Penalty, Relaxed};
use sindy::solve::sr3::Scaling;
use sindy::solve::stepwise::Direction;
use sindy::{BestSubset, Criterion, SindyError, Solver, Stepwise, Stlsq};

/// A solver as the Python side describes it.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Description {
    Stlsq {
        threshold: f64,
        alpha: f64,
        scaled: bool,
        max_iter: usize,
        unbias: bool,
    },
    Sr3 {
        lam: f64,
        nu: f64,
        penalty: RelaxedBy,
        scaled: bool,
        max_iter: usize,
    },
    Stepwise {
        direction: Towards,
        criterion: Criterion,
    },
    BestSubset {
        criterion: Criterion,
        max_size: Option<usize>,
        node_limit: Option<u64>,
    },
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum RelaxedBy {
    L0,
    L1,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Towards {
    Forward,
    Backward,
    Both,
}

impl Description {
    /// The solver.
    ///
    /// # Errors
    /// A setting outside its range.
    pub(crate) fn build(&self) -> Result<Box<dyn Solver>, SindyError> {
        let scaling = |scaled| match scaled {
            true => Scaling::UnitRms,
            false => Scaling::None,
        };
        Ok(match *self {
            Self::Stlsq {
                threshold,
                alpha,
                scaled,
                max_iter,
                unbias,
            } => Box::new(
                Stlsq::new(threshold, alpha)?
                    .scaling(scaling(scaled))
                    .max_iterations(max_iter)
                    .refit(unbias),
            ),
            Self::Sr3 {
                lam,
                nu,
                penalty,
                scaled,
                max_iter,
            } => {
                let penalty = match penalty {
                    RelaxedBy::L0 => Penalty::L0,
                    RelaxedBy::L1 => Penalty::L1,
                };
                Box::new(
                    Relaxed::new(penalty, lam, nu)?
                        .scaling(scaling(scaled))
                        .max_iterations(max_iter),
                )
            }
            Self::Stepwise {
                direction,
                criterion,
            } => {
                let direction = match direction {
                    Towards::Forward => Direction::Forward,
                    Towards::Backward => Direction::Backward,
                    Towards::Both => Direction::Both,
                };
                Box::new(Stepwise::new(direction, criterion))
            }
            Self::BestSubset {
                criterion,
                max_size,
                node_limit,
            } => {
                let mut search = BestSubset::new();
                if let Some(terms) = max_size {
                    search = search.max_size(terms);
                }
                if let Some(nodes) = node_limit {
                    search = search.node_limit(nodes);
                }
                Box::new(BestBy { search, criterion })
            }
        })
    }
}
