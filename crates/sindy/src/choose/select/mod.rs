//! Choosing one fit of a family, by its error on held-out data or by a criterion.
//!
//! A [`Family`] turns statistics into several fits: SR3 over a grid of λ and ν ([`sr3_points`]), STLSQ over
//! thresholds ([`stlsq_thresholds`]), the best subset of every size ([`best_subsets`]), or any closure. Each group of
//! data (a trajectory, say) is left out in turn: the family is fitted again to the total minus that group, so that the
//! choice of terms is judged and not only their coefficients,
//!
//! ```text
//! e_mg = |y_g - Θ_g ξ_m(-g)|² / n_g,      left-out error of member m = √( Σ_g e_mg / groups )
//! ```
//!
//! and, as statistics subtract, no pass over the data is needed. [`Rule::LeftOut`] takes the fewest terms whose
//! error is within one standard error of the smallest, the standard error being that of the *paired* differences
//! `e_mg - e_bg`: groups differ far more among themselves than two fits do on one group.
//!
//! ```
//! use sindy::choose::select::{Rule, best_subsets, select};
//! use sindy::{Gram, Library, Samples};
//!
//! let mut samples = Samples::new(&["x", "y"]);
//! for g in 0..6_usize {
//!     let x: Vec<f64> = (0..50).map(|i| (f64::from(i) + 0.3 * g as f64).sin()).collect();
//!     let y = x.iter().enumerate().map(|(i, x)| 0.5 - 2.0 * x + 0.1 * (7.3 * (i * i + g) as f64).sin()).collect();
//!     samples.push_group(vec![x, y])?;
//! }
//! let library = Library::parse(&["1", "x", "x^2", "x^3"])?;
//! let grams = Gram::accumulate(&library, "y", &samples)?;
//! let selection = select(&grams, &best_subsets(None), Rule::LeftOut)?;
//! assert_eq!(selection.fit().support, [true, true, false, false]);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Source: T. Hastie, R. Tibshirani, J. Friedman, "The Elements of Statistical Learning" (2009), section 7.10.

mod rule;

use std::sync::Arc;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use crate::error::{SindyError, require, same_size};
use crate::solve::exact::BestSubset;
use crate::solve::fit::{Fit, Solver};
use crate::solve::sr3::{Problem, Scaling, Sr3};
use crate::solve::stlsq::Stlsq;
use crate::statistics::criteria::Criterion;
use crate::statistics::gram::{Gram, check};
use crate::statistics::regression::LastEigenspaces;
use rule::best_score;
pub(crate) use rule::{OneError, mean_and_error, within_one_error};

/// A family of fits: as many for any statistics of the same terms, the k-th always of the same kind.
///
/// Any closure of that shape will do.
pub trait Family: Sync {
    /// The fits to `gram`.
    ///
    /// # Errors
    /// As its solver.
    fn fits(&self, gram: &Gram) -> Result<Vec<Fit>, SindyError>;
}

impl<F> Family for F
where
    F: Fn(&Gram) -> Result<Vec<Fit>, SindyError> + Sync,
{
    fn fits(&self, gram: &Gram) -> Result<Vec<Fit>, SindyError> {
        self(gram)
    }
}

/// How a member is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// The fewest terms whose error on data left out is within one standard error of the smallest.
    LeftOut,
    /// The best score of a criterion; of equals the one with fewer terms.
    Criterion {
        /// What scores.
        criterion: Criterion,
        /// The number of independent rows with the information of the correlated ones.
        effective_rows: Option<f64>,
    },
}

/// Error on groups left out.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LeftOut {
    /// Root mean square error, in the target's unit.
    pub rmse: f64,
    /// Standard error of the mean over groups of the *squared* error.
    pub mean_square_error_se: f64,
}

/// One member of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Its fit to all data.
    pub fit: Fit,
    /// Root mean square residual of that fit.
    pub training_rmse: f64,
    /// Its error on groups left out; absent for a single group.
    pub left_out: Option<LeftOut>,
    /// Its score, where the rule is a criterion.
    pub score: Option<f64>,
}

/// A family with the member that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// All members, in the family's order.
    pub members: Vec<Member>,
    /// The chosen one.
    pub chosen: usize,
    /// The one with the smallest error on data left out, or the best score.
    pub best: usize,
    /// Why the chosen one.
    pub reason: String,
}

impl Selection {
    /// The chosen member.
    #[must_use]
    pub fn member(&self) -> &Member {
        &self.members[self.chosen]
    }

    /// The chosen fit.
    #[must_use]
    pub fn fit(&self) -> &Fit {
        &self.member().fit
    }
}

/// Fits `family` to all of `groups` and to all but each of them, and chooses by `rule`. Groups without rows are
/// left out.
///
/// # Errors
/// Statistics that no solver can use, a family without members or of changing size, [`Rule::LeftOut`] with fewer than
/// two groups, an error of the family, effective rows that are not positive.
pub fn select(groups: &[Gram], family: &dyn Family, rule: Rule) -> Result<Selection, SindyError> {
    let folds: Vec<&Gram> = groups.iter().filter(|g| g.rows > 0).collect();
    if folds.len() < 2 && rule == Rule::LeftOut {
        return Err(SindyError::shape(
            "groups to cross-validate over",
            2,
            folds.len(),
        ));
    }
    let total = Gram::total(groups);
    check(&total)?;
    let fits = family.fits(&total)?;
    require(!fits.is_empty(), "family", "at least one fit", "none")?;
    let errors = if folds.len() < 2 {
        Vec::new()
    } else {
        left_out(&total, &folds, family, fits.len())?
    };
    let of_member = |m: usize| -> Vec<f64> { errors.iter().map(|fold| fold[m]).collect() };
    let mut members = Vec::with_capacity(fits.len());
    for (m, fit) in fits.into_iter().enumerate() {
        let score = match rule {
            Rule::LeftOut => None,
            Rule::Criterion {
                criterion,
                effective_rows,
            } => Some(criterion.score(&total, &fit.support, effective_rows)?),
        };
        let left_out = (!errors.is_empty()).then(|| {
            let (mean, se) = mean_and_error(&of_member(m));
            LeftOut {
                rmse: mean.sqrt(),
                mean_square_error_se: se,
            }
        });
        members.push(Member {
            training_rmse: (fit.residual_sum / total.weight()).sqrt(),
            fit,
            left_out,
            score,
        });
    }
    let (best, chosen, reason) = match rule {
        Rule::LeftOut => {
            let by_member: Vec<Vec<f64>> = (0..members.len()).map(of_member).collect();
            let terms: Vec<usize> = members.iter().map(|m| m.fit.terms()).collect();
            let OneError {
                best,
                chosen,
                reason,
            } = within_one_error(&by_member, &terms);
            (best, chosen, reason)
        }
        Rule::Criterion { criterion, .. } => best_score(&members, criterion),
    };
    Ok(Selection {
        members,
        chosen,
        best,
        reason,
    })
}

/// `[fold][member]`: mean squares on the groups left out.
fn left_out(
    total: &Gram,
    folds: &[&Gram],
    family: &dyn Family,
    members: usize,
) -> Result<Vec<Vec<f64>>, SindyError> {
    folds
        .par_iter()
        .map(|fold| {
            let mut rest = total.clone();
            rest.downdate(fold);
            let fits = family.fits(&rest)?;
            same_size(
                "fits of a family with a group left out",
                members,
                fits.len(),
            )?;
            let mean_square = |fit: &Fit| fold.residual_sum(&fit.coefficients) / fold.weight();
            Ok(fits.iter().map(mean_square).collect())
        })
        .collect()
}

/// Deals groups into `folds` at random, as even in number as can be, and adds up each fold's statistics.
/// The same seed deals alike. Groups without rows go nowhere.
///
/// # Errors
/// Fewer than two folds, or more folds than groups with rows.
pub fn deal(groups: &[Gram], folds: usize, seed: u64) -> Result<Vec<Gram>, SindyError> {
    let mut used: Vec<&Gram> = groups.iter().filter(|g| g.rows > 0).collect();
    if !(2..=used.len()).contains(&folds) {
        return Err(SindyError::setting(
            "folds",
            format!("2 to the number of groups with rows ({})", used.len()),
            folds,
        ));
    }
    let mut rng = Pcg64::seed_from_u64(seed);
    for last in (1..used.len()).rev() {
        // A remainder of 64 bits over a few thousand groups is as good as even.
        let other = (rng.next_u64() % (last as u64 + 1)) as usize;
        used.swap(last, other);
    }
    let p = used[0].xty.len();
    let mut dealt = vec![Gram::zeros(p); folds];
    for (i, group) in used.into_iter().enumerate() {
        dealt[i % folds].merge(group);
    }
    Ok(dealt)
}

/// The statistics of at most `folds` sets of the groups, dealt out in turn; groups without rows go nowhere. No more
/// groups than folds stay as they are.
pub(crate) fn folded(groups: &[Gram], folds: usize) -> Vec<Gram> {
    let mut out: Vec<Gram> = Vec::new();
    for (k, group) in groups.iter().filter(|g| g.rows > 0).enumerate() {
        match out.get_mut(k % folds) {
            Some(sum) => sum.merge(group),
            None => out.push(group.clone()),
        }
    }
    out
}

/// SR3 with ℓ0, scaled, at every pair of λ and ν ([`Grid::points`](crate::Grid::points) lists those of a grid); least
/// squares on the terms that it keeps.
///
/// # Errors
/// No pair, or values out of range.
pub fn sr3_points(points: &[(f64, f64)]) -> Result<impl Family + use<>, SindyError> {
    let solvers = points
        .iter()
        .map(|&(lambda, nu)| Sr3::new(lambda, nu))
        .collect::<Result<Vec<_>, _>>()?;
    require(!solvers.is_empty(), "points", "at least one", "none")?;
    let shared = Arc::<LastEigenspaces>::default();
    Ok(move |gram: &Gram| {
        check(gram)?;
        let mut problem = Problem::sharing(gram, Scaling::UnitRms, shared.clone());
        let fit = |solver: &Sr3| {
            let s = solver.solve_again(&mut problem);
            Fit::new(gram, s.refit, s.support, s.outcome, s.iterations)
        };
        Ok(solvers.iter().map(fit).collect())
    })
}

/// STLSQ, scaled, at every threshold.
///
/// # Errors
/// No threshold, or values out of range.
pub fn stlsq_thresholds(thresholds: &[f64], ridge: f64) -> Result<impl Family + use<>, SindyError> {
    let solvers = thresholds
        .iter()
        .map(|&threshold| Stlsq::new(threshold, ridge))
        .collect::<Result<Vec<_>, _>>()?;
    require(!solvers.is_empty(), "thresholds", "at least one", "none")?;
    Ok(move |gram: &Gram| solvers.iter().map(|s| s.fit(gram)).collect())
}

/// The best subset of every size from none to all terms, proven unless `node_limit` ends the search. A size that
/// the data do not allow (a term that is zero throughout) repeats the largest that they do.
pub fn best_subsets(node_limit: Option<u64>) -> impl Family {
    let search = BestSubset::new().node_limit(node_limit.unwrap_or(u64::MAX));
    move |gram: &Gram| {
        let mut fits: Vec<Fit> = search
            .solve(gram)?
            .sizes
            .into_iter()
            .map(|s| s.fit)
            .collect();
        if let Some(largest) = fits.last().cloned() {
            fits.resize(gram.xty.len() + 1, largest);
        }
        Ok(fits)
    }
}

#[cfg(test)]
mod tests;
