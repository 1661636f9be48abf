//! Confidence intervals of a fit by a bootstrap over blocks of rows.
//!
//! The residuals of a dynamical fit are correlated from row to row, and intervals that take the rows one by one
//! come out too narrow, often by several times. [`Bootstrap`] resamples blocks of consecutive rows instead, each
//! longer than the correlation lasts, or whole trajectories. [`block_length`] estimates that length from the residual
//! and from the residual times each kept term. Sums over blocks are made in one pass; a
//! replicate costs no other.
//!
//! With a solver that selects terms, every replicate selects again: inclusion and intervals then state what the
//! choice of terms adds. With [`on_support`] the terms stay.
//!
//! For several equations the r-th replicate resamples the same rows of each, so that [`models`] turns replicates
//! into models, and [`Band`](super::Band) computes how far these differ: [`Band::of_predictions`](super::Band::of_predictions) point by point,
//! [`Band::of_runs`](super::Band::of_runs) along simulations. [`Band::of_covariance`](super::Band::of_covariance) does the former from a covariance alone.
//!
//! ```
//! use sindy::statistics::gram::Accumulate;
//! use sindy::uncertainty::{Bootstrap, on_support};
//! use sindy::{Library, Samples, Solver};
//!
//! let x: Vec<f64> = (0..1000).map(|i| (0.07 * f64::from(i)).sin()).collect();
//! let y = x.iter().enumerate().map(|(i, x)| 2.0 * x + 0.1 * (0.3 * i as f64).cos()).collect();
//! let mut samples = Samples::new(&["x", "y"]);
//! samples.push_group(vec![x, y])?;
//! let library = Library::parse(&["1", "x"])?;
//!
//! let solver = on_support(vec![true, true]);
//! let equation = (Accumulate::new(&library, "y"), &solver as &dyn Solver);
//! let found = Bootstrap::new(300, 1)?.run(&[equation], &samples)?.remove(0);
//! assert!(found.block_rows > 1);
//! assert!(found.ensemble.lower[1] < 2.0 && 2.0 < found.ensemble.upper[1]);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Sources: E. Carlstein, Annals of Statistics 14 (1986); H. R. Künsch, Annals of Statistics 17 (1989); B. Efron,
//! R. Tibshirani, "An Introduction to the Bootstrap" (1993).

use nalgebra::{DMatrix, DVector};

use super::block_length::block_length;

use crate::data::samples::BlockSource;
use crate::error::{SindyError, require, same_size};
use crate::library::Library;
use crate::model::{Model, Term, Time};
use crate::solve::fit::{Fit, Solver};
use crate::solve::outcome::Outcome;
use crate::statistics::gram::{Accumulate, Gram};
use crate::statistics::residual::{residuals, scores};
use crate::uncertainty::ensemble::{Blocks, Ensemble, Ensembled};

/// Blocks that are held at most: each keeps a p x p matrix.
const MOST_BLOCKS: usize = 400;

/// Blocks that are made at least where the data allow it: fewer have no spread to resample.
const FEWEST_BLOCKS: usize = 10;

/// The unit of resampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resampling {
    /// Blocks of consecutive rows, as long as the correlation of the residuals asks for; long enough that there
    /// are at most 400, and short enough that there are at least 10 (then they may be too short for the
    /// correlation, see [`Intervals::correlation_rows`]).
    Automatic,
    /// Blocks of this number of consecutive rows.
    Rows(usize),
    /// Whole groups (trajectories). Intervals need some ten of them, better thirty.
    Groups,
}

/// Settings of a bootstrap over blocks, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bootstrap {
    ensemble: Ensemble,
    resampling: Resampling,
}

/// Confidence intervals of one equation by a bootstrap.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    /// The fit to all data.
    pub fit: Fit,
    /// The replicates: coefficients, inclusion, and the ends of the percentile intervals.
    pub ensemble: Ensembled,
    /// Covariance of the replicates' coefficients, p x p.
    pub covariance: DMatrix<f64>,
    /// Standard errors: the roots of its diagonal.
    pub std_error: DVector<f64>,
    /// Rows of a block; the mean over the groups if these were resampled.
    pub block_rows: usize,
    /// Blocks that were resampled (those with usable rows).
    pub blocks: usize,
    /// The block length that the correlation asks for, where it was asked ([`Resampling::Automatic`]). If it is larger
    /// than `block_rows`, there are too few data, and the intervals are too narrow.
    pub correlation_rows: Option<f64>,
}

impl Bootstrap {
    /// This number of replicates from this seed; block lengths from the correlation, 95 % intervals.
    ///
    /// # Errors
    /// Fewer than two replicates.
    pub fn new(replicates: usize, seed: u64) -> Result<Self, SindyError> {
        require(replicates >= 2, "replicates", "at least 2", replicates)?;
        Ok(Self {
            ensemble: Ensemble::new(replicates, seed)?,
            resampling: Resampling::Automatic,
        })
    }

    /// The same with intervals that cover this share.
    ///
    /// # Errors
    /// Not between 0 and 1.
    pub fn level(self, level: f64) -> Result<Self, SindyError> {
        Ok(Self {
            ensemble: self.ensemble.level(level)?,
            ..self
        })
    }

    /// The bootstrap with this number of terms omitted from the library of each replicate, at random; the fit to all data
    /// has all terms.
    #[must_use]
    pub fn omit(self, terms: usize) -> Self {
        Self {
            ensemble: self.ensemble.omit(terms),
            ..self
        }
    }

    /// The same with another choice of what is resampled.
    #[must_use]
    pub fn resampling(self, resampling: Resampling) -> Self {
        Self { resampling, ..self }
    }

    /// The intervals of every equation. All are resampled alike, with the longest block that any of them asks
    /// for. The source is passed over several times.
    ///
    /// # Errors
    /// As [`Accumulate::over`] and [`Ensemble::run`]: fewer than two blocks, a block of no rows; errors of the
    /// solvers.
    pub fn run(
        &self,
        equations: &[(Accumulate<'_>, &dyn Solver)],
        source: &dyn BlockSource,
    ) -> Result<Vec<Intervals>, SindyError> {
        let mut fits = Vec::with_capacity(equations.len());
        let mut rows = 0;
        let mut asked: Option<f64> = None;
        for (accumulate, solver) in equations {
            let total = Gram::total(&accumulate.over(source)?);
            let fit = solver.fit(&total)?;
            rows = total.rows.max(rows);
            if self.resampling == Resampling::Automatic {
                let length = longest(accumulate, &fit, source)?;
                asked = Some(asked.map_or(length, |most| most.max(length)));
            }
            fits.push(fit);
        }
        let length = match (self.resampling, asked) {
            (Resampling::Rows(rows), _) => Some(rows),
            (_, Some(asked)) => {
                let most = (rows / FEWEST_BLOCKS).max(1);
                Some(
                    (asked.ceil() as usize)
                        .max(rows.div_ceil(MOST_BLOCKS))
                        .min(most),
                )
            }
            (_, None) => None,
        };
        let blocks = length.map(|rows| Blocks::new(source, rows)).transpose()?;
        let cut: &dyn BlockSource = match &blocks {
            Some(blocks) => blocks,
            None => source,
        };
        let mut out = Vec::with_capacity(fits.len());
        for ((accumulate, solver), fit) in equations.iter().zip(fits) {
            let parts = accumulate.over(cut)?;
            let ensemble = self.ensemble.run(&parts, *solver)?;
            let covariance = covariance(&ensemble.coefficients);
            let blocks = parts.iter().filter(|g| g.rows > 0).count();
            out.push(Intervals {
                fit,
                std_error: covariance.diagonal().map(|v| v.max(0.0).sqrt()),
                covariance,
                ensemble,
                block_rows: length.unwrap_or(rows / blocks.max(1)),
                blocks,
                correlation_rows: asked,
            });
        }
        Ok(out)
    }
}

/// A solver that keeps these terms and fits them by least squares.
pub fn on_support(support: Vec<bool>) -> impl Solver {
    move |gram: &Gram| {
        if support.len() == gram.xty.len() {
            let outcome = if support.contains(&true) {
                Outcome::Converged
            } else {
                Outcome::Empty
            };
            Ok(Fit::on_support(gram, support.clone(), outcome, 1))
        } else {
            Err(SindyError::shape(
                "terms of the support",
                gram.xty.len(),
                support.len(),
            ))
        }
    }
}

/// The models that the replicates of several equations are, in continuous or discrete time; the equations in the
/// order of the states.
///
/// # Errors
/// As [`Model::new`]; not one library of the right size for each equation; equations with different numbers of
/// replicates.
pub fn models<S: AsRef<str>>(
    time: Time,
    states: &[S],
    inputs: &[S],
    equations: &[(&Library, &Intervals)],
) -> Result<Vec<Model>, SindyError> {
    let replicates = |i: usize| equations[i].1.ensemble.coefficients.ncols();
    let count = if equations.is_empty() {
        0
    } else {
        replicates(0)
    };
    for i in 0..equations.len() {
        same_size("replicates of an equation", count, replicates(i))?;
    }
    (0..count)
        .map(|r| {
            let terms = equations
                .iter()
                .map(|(library, intervals)| {
                    let column = intervals.ensemble.coefficients.column(r).into_owned();
                    Term::of_library(library, column.as_slice())
                })
                .collect::<Result<_, _>>()?;
            Model::new(time, states, inputs, terms)
        })
        .collect()
}

/// The longest block that the residual, or it times a kept term, asks for.
fn longest(
    accumulate: &Accumulate<'_>,
    fit: &Fit,
    source: &dyn BlockSource,
) -> Result<f64, SindyError> {
    let (library, target) = accumulate.names();
    let mut most = block_length(&residuals(library, target, &fit.coefficients, source)?);
    for j in (0..library.len()).filter(|&j| fit.support[j]) {
        let series = scores(library, target, &fit.coefficients, j, source)?;
        most = most.max(block_length(&series));
    }
    Ok(most)
}

/// Covariance of the columns' distribution.
fn covariance(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mean = columns.column_mean();
    let mut centred = columns.clone();
    centred.column_iter_mut().for_each(|mut c| c -= &mean);
    &centred * centred.transpose() / (columns.ncols() as f64 - 1.0)
}
