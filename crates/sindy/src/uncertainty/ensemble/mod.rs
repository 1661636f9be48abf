//! Ensembles: many fits to resampled data or to parts of the library, and what they agree on.
//!
//! The data come as the statistics of parts: trajectories, blocks of consecutive rows ([`Blocks`] cuts
//! them), or single rows. A bootstrap replicate draws as many parts as there are, with replacement; its
//! statistics are a sum with integer weights, so that a replicate costs no pass over the data. A
//! library replicate leaves out terms at random. Both may be combined.
//!
//! Rows of a time series are correlated, and resampling them one by one makes intervals too narrow: take
//! trajectories, or blocks longer than the correlation lasts. For rows that are independent
//! [`Ensemble::run_rows`] draws them singly, in one pass for all replicates.
//!
//! A replicate's random numbers depend on the seed and its index alone, so that results are the same for
//! any number of threads.
//!
//! ```
//! use sindy::uncertainty::ensemble::{Blocks, Ensemble};
//! use sindy::{Gram, Library, Samples, Stlsq};
//!
//! let x: Vec<f64> = (0..1000).map(|i| (0.37 * f64::from(i)).sin()).collect();
//! let y = x.iter().enumerate().map(|(i, x)| 2.0 * x + 0.1 * (i as f64 * i as f64).sin()).collect();
//! let mut samples = Samples::new(&["x", "y"]);
//! samples.push_group(vec![x, y])?;
//! let library = Library::parse(&["1", "x", "x^3"])?;
//! let parts = Gram::accumulate(&library, "y", &Blocks::new(&samples, 50)?)?;
//!
//! let ensemble = Ensemble::new(200, 1)?.run(&parts, &Stlsq::new(0.1, 0.0)?)?;
//! assert_eq!(ensemble.inclusion[1], 1.0);
//! assert!(ensemble.lower[1] < 2.0 && 2.0 < ensemble.upper[1]);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Sources: B. Efron, R. Tibshirani, "An Introduction to the Bootstrap" (1993); H. R. Künsch, Annals of
//! Statistics 17 (1989); U. Fasel, J. N. Kutz, B. W. Brunton, S. L. Brunton, "Ensemble-SINDy", Proceedings
//! of the Royal Society A 478 (2022).

mod blocks;
mod rows;

pub use blocks::Blocks;

use nalgebra::{DMatrix, DVector};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::error::{SindyError, require, same_size};
use crate::numerics::quantile;
use crate::solve::fit::{Fit, Solver};
use crate::solve::outcome::Outcome;
use crate::statistics::gram::{Gram, check};
use crate::uncertainty::resample::{below, counts, generator};

/// Settings of an ensemble, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ensemble {
    replicates: usize,
    seed: u64,
    resample: bool,
    omit: usize,
    level: f64,
}

/// Statistics over the replicates. Vectors have one entry for each of the p terms; statistics of a term are over
/// the replicates that had it in their library, in which it counts as zero where it was dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct Ensembled {
    /// Coefficients, p x replicates; zero where a term was dropped or left out.
    pub coefficients: DMatrix<f64>,
    /// Replicates that had the term in their library. Where it is zero, so are the statistics.
    pub offered: Vec<usize>,
    /// Share of them that kept it.
    pub inclusion: DVector<f64>,
    /// Mean coefficient.
    pub mean: DVector<f64>,
    /// Median coefficient.
    pub median: DVector<f64>,
    /// Lower end of the percentile interval.
    pub lower: DVector<f64>,
    /// Upper end of the percentile interval.
    pub upper: DVector<f64>,
    /// Why the solver stopped, for each replicate.
    pub outcomes: Vec<Outcome>,
}

impl Ensemble {
    /// Resampled data, the whole library, 95 % intervals.
    ///
    /// # Errors
    /// No replicates.
    pub fn new(replicates: usize, seed: u64) -> Result<Self, SindyError> {
        require(replicates != 0, "replicates", "at least 1", replicates)?;
        Ok(Self {
            replicates,
            seed,
            resample: true,
            omit: 0,
            level: 0.95,
        })
    }

    /// The same with or without resampling of the data.
    #[must_use]
    pub fn resample(self, resample: bool) -> Self {
        Self { resample, ..self }
    }

    /// The ensemble with this number of terms omitted from each replicate's library, at random.
    #[must_use]
    pub fn omit(self, terms: usize) -> Self {
        Self {
            omit: terms,
            ..self
        }
    }

    /// The same with percentile intervals that cover this share.
    ///
    /// # Errors
    /// Not between 0 and 1.
    pub fn level(self, level: f64) -> Result<Self, SindyError> {
        require(
            level > 0.0 && level < 1.0,
            "level",
            "between 0 and 1",
            level,
        )?;
        Ok(Self { level, ..self })
    }

    /// Fits every replicate of `parts` with `solver`. Parts without rows are left out.
    ///
    /// # Errors
    /// Statistics that no solver can use, fewer than two parts to draw from, parts with different
    /// numbers of terms, as many terms to leave out as there are, or an error of the solver.
    pub fn run(&self, parts: &[Gram], solver: &dyn Solver) -> Result<Ensembled, SindyError> {
        let parts: Vec<&Gram> = parts.iter().filter(|g| g.rows > 0).collect();
        let needed = if self.resample { 2 } else { 1 };
        if parts.len() < needed {
            return Err(SindyError::shape(
                "parts of the data with rows (at least)",
                needed,
                parts.len(),
            ));
        }
        let p = parts[0].xty.len();
        for part in &parts {
            check(part)?;
            same_size("terms of a part", p, part.xty.len())?;
        }
        self.check_omit(p)?;
        let whole = sum(&parts, &vec![1; parts.len()]);
        let fits: Vec<(Vec<usize>, Fit)> = (0..self.replicates)
            .into_par_iter()
            .map(|r| self.replicate(r, &parts, &whole, solver))
            .collect::<Result<_, _>>()?;
        Ok(self.summarise(p, &fits))
    }

    fn check_omit(&self, p: usize) -> Result<(), SindyError> {
        if self.omit < p {
            return Ok(());
        }
        Err(SindyError::setting(
            "omit",
            format!("fewer than the {p} terms of the library"),
            self.omit,
        ))
    }

    /// The terms of replicate `r`, and its fit over these.
    fn replicate(
        &self,
        r: usize,
        parts: &[&Gram],
        whole: &Gram,
        solver: &dyn Solver,
    ) -> Result<(Vec<usize>, Fit), SindyError> {
        let mut rng = generator(self.seed, r);
        let p = whole.xty.len();
        let terms = self.terms(p, &mut rng);
        let gram = if self.resample {
            sum(parts, &counts(&mut rng, parts.len()))
        } else {
            whole.clone()
        };
        let fit = self.fit(gram, &terms, solver)?;
        Ok((terms, fit))
    }

    /// The terms of a replicate, of `p`.
    fn terms(&self, p: usize, rng: &mut Pcg64) -> Vec<usize> {
        let mut terms: Vec<usize> = (0..p).collect();
        for _ in 0..self.omit {
            let gone = below(rng, terms.len());
            terms.remove(gone);
        }
        terms
    }

    /// The fit over `terms`, given statistics over all.
    fn fit(&self, mut gram: Gram, terms: &[usize], solver: &dyn Solver) -> Result<Fit, SindyError> {
        if self.omit > 0 {
            gram.xtx = gram.xtx.select_rows(terms).select_columns(terms);
            gram.xty = gram.xty.select_rows(terms);
            // Its columns are those of all terms.
            gram.triangle = None;
        }
        let fit = solver.fit(&gram)?;
        if fit.coefficients.len() != terms.len() || fit.support.len() != terms.len() {
            return Err(SindyError::shape(
                "coefficients of the solver's fit",
                terms.len(),
                fit.coefficients.len(),
            ));
        }
        Ok(fit)
    }

    fn summarise(&self, p: usize, fits: &[(Vec<usize>, Fit)]) -> Ensembled {
        let mut out = Ensembled {
            coefficients: DMatrix::zeros(p, fits.len()),
            offered: vec![0; p],
            inclusion: DVector::zeros(p),
            mean: DVector::zeros(p),
            median: DVector::zeros(p),
            lower: DVector::zeros(p),
            upper: DVector::zeros(p),
            outcomes: fits.iter().map(|(_, fit)| fit.outcome).collect(),
        };
        let mut values = vec![Vec::with_capacity(fits.len()); p];
        for (r, (terms, fit)) in fits.iter().enumerate() {
            for (i, &j) in terms.iter().enumerate() {
                values[j].push(fit.coefficients[i]);
                out.coefficients[(j, r)] = fit.coefficients[i];
                out.offered[j] += 1;
                out.inclusion[j] += f64::from(u8::from(fit.support[i]));
            }
        }
        for (j, values) in values.iter_mut().enumerate().filter(|(_, v)| !v.is_empty()) {
            values.sort_by(f64::total_cmp);
            let n = values.len() as f64;
            out.inclusion[j] /= n;
            out.mean[j] = values.iter().sum::<f64>() / n;
            out.median[j] = quantile(values, 0.5);
            out.lower[j] = quantile(values, 0.5 * (1.0 - self.level));
            out.upper[j] = quantile(values, 0.5 * (1.0 + self.level));
        }
        out
    }
}

impl Ensembled {
    /// Least squares over all data on the terms that at least the share `inclusion` of the replicates
    /// kept.
    ///
    /// # Errors
    /// Statistics of another number of terms, or that no solver can use.
    pub fn refit(&self, gram: &Gram, inclusion: f64) -> Result<Fit, SindyError> {
        check(gram)?;
        same_size(
            "terms of the statistics",
            self.inclusion.len(),
            gram.xty.len(),
        )?;
        let keep = |j: usize| self.offered[j] > 0 && self.inclusion[j] >= inclusion;
        let support: Vec<bool> = (0..self.inclusion.len()).map(keep).collect();
        let outcome = if support.contains(&true) {
            Outcome::Converged
        } else {
            Outcome::Empty
        };
        Ok(Fit::on_support(gram, support, outcome, self.outcomes.len()))
    }
}

/// The sum of statistics with integer weights.
fn sum(parts: &[&Gram], weights: &[u32]) -> Gram {
    let mut out = Gram::zeros(parts[0].xty.len());
    for (part, &count) in parts.iter().zip(weights).filter(|(_, c)| **c > 0) {
        out.merge_copies(part, f64::from(count));
    }
    out
}

#[cfg(test)]
mod tests;
