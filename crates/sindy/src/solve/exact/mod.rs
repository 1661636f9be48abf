//! The best subset of every size, exactly: ℓ0 by branch and bound, with a certificate.
//!
//! For every number of terms `s = 0 … p`
//!
//! ```text
//! R_s = min over S, ξ_S   |y - Θ_S ξ_S|²,   |S| = s
//! ```
//!
//! A node of the search tree fixes some terms and leaves others free; its subsets contain all of the fixed
//! ones. Least squares on fixed and free terms together (the relaxed problem) bounds their residuals
//! from below, and dropping a set `D` of free terms from it costs at least the larger of
//!
//! ```text
//! max over D  c_j     and     Σ over D  c_j / λ,       c_j = ξ_j² / (G⁻¹)_jj,
//! ```
//!
//! where `λ` bounds the largest eigenvalue of the correlation matrix of the estimates of the free terms. A node
//! is pruned when these bounds exclude it for every size at once. The normal equations are carried as a triangular factor
//! of the free terms only, downdated by plane rotations, so that a node costs a few hundred operations
//! and no accuracy is lost on the way down.
//!
//! The certificate: no subset of that size has a residual smaller by more than the rounding of `yᵀ y`
//! (about 4e-15 (p + 1) of it). A library whose scaled `Θ` has a condition above 3e6 is searched with the ridge
//! that [`BestSubsets::ridge`] states; the coefficients have none.
//!
//! With [signs](crate::solve::sign), a subset counts only if its least-squares estimate keeps them. The bounds hold as they are:
//! they bound the subsets without signs.
//!
//! ```
//! use sindy::solve::exact::BestSubset;
//! use sindy::{Gram, Library, Outcome, Samples};
//!
//! let x: Vec<f64> = (0..100).map(|i| 0.02 * f64::from(i) - 1.0).collect();
//! let y = x.iter().map(|x| 0.5 - 2.0 * x * x + 0.01 * (40.0 * x).sin()).collect();
//! let mut samples = Samples::new(&["x", "y"]);
//! samples.push_group(vec![x, y])?;
//! let library = Library::parse(&["1", "x", "x^2", "x^3", "x^4"])?;
//! let gram = Gram::total(&Gram::accumulate(&library, "y", &samples)?);
//!
//! let best = BestSubset::new().solve(&gram)?;
//! assert_eq!(best.outcome, Outcome::Optimal);
//! assert_eq!(best.sizes[2].fit.support, [true, false, true, false, false]);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Sources: G. M. Furnival, R. W. Wilson, "Regressions by leaps and bounds", Technometrics 16 (1974);
//! C. Gatu, E. J. Kontoghiorghes, "Branch-and-bound algorithms for computing the best-subset regression
//! models", Journal of Computational and Graphical Statistics 15 (2006).

mod node;
mod search;

use crate::error::{SindyError, at_least_zero};
use crate::solve::fit::{Fit, Solver};
use crate::solve::outcome::Outcome;
use crate::solve::sign::{self, Sign};
use crate::statistics::criteria::Criterion;
use crate::statistics::gram::Gram;
use crate::statistics::normal::Normal;

/// The largest number of terms, not counting those that are zero throughout.
pub const MAX_TERMS: usize = 128;

/// Settings of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BestSubset {
    max_size: usize,
    node_limit: u64,
    tolerance: f64,
}

/// The best subset of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Subset {
    /// Least squares on it. Its outcome is [`Outcome::Optimal`] where it is proven, and otherwise
    /// the reason why not.
    pub fit: Fit,
    /// No subset of this size has a residual sum of squares below this.
    pub lower_bound: f64,
}

impl Subset {
    /// The relative gap that is left, `1 - lower_bound / residual`; zero where proven.
    #[must_use]
    pub fn gap(&self) -> f64 {
        if self.fit.outcome == Outcome::Optimal {
            return 0.0;
        }
        1.0 - self.lower_bound / self.fit.residual_sum
    }
}

/// The best subset of every size, and what is proven about them.
#[derive(Clone, Debug, PartialEq)]
pub struct BestSubsets {
    /// By size: `sizes[s]` has `s` terms. Shorter than `p + 1` where a size limit was set, or where terms
    /// are zero throughout. With signs, a size lacks if none of its subsets keeps them and is better than all smaller ones.
    pub sizes: Vec<Subset>,
    /// [`Outcome::Optimal`] if every size is proven, or why not.
    pub outcome: Outcome,
    /// Nodes that were visited.
    pub nodes: u64,
    /// Ridge on the unit diagonal of the scaled Gram matrix during the search: zero, but for (nearly) singular
    /// libraries.
    pub ridge: f64,
}

impl BestSubsets {
    /// The size that `criterion` prefers (the smaller one of equals).
    ///
    /// # Errors
    /// As [`Criterion::score`].
    pub fn choose(
        &self,
        gram: &Gram,
        criterion: Criterion,
        effective_rows: Option<f64>,
    ) -> Result<&Subset, SindyError> {
        let mut best = (f64::INFINITY, 0);
        for (s, subset) in self.sizes.iter().enumerate() {
            let score = criterion.score(gram, &subset.fit.support, effective_rows)?;
            if score < best.0 {
                best = (score, s);
            }
        }
        Ok(&self.sizes[best.1])
    }
}

impl Default for BestSubset {
    fn default() -> Self {
        Self::new()
    }
}

impl BestSubset {
    /// All sizes, to the end, without tolerance.
    #[must_use]
    pub fn new() -> Self {
        Self {
            max_size: usize::MAX,
            node_limit: u64::MAX,
            tolerance: 0.0,
        }
    }

    /// Sizes up to `terms` only: much less work in a large library.
    #[must_use]
    pub fn max_size(self, terms: usize) -> Self {
        Self {
            max_size: terms,
            ..self
        }
    }

    /// Limits the search to this number of nodes.
    #[must_use]
    pub fn node_limit(self, nodes: u64) -> Self {
        Self {
            node_limit: nodes,
            ..self
        }
    }

    /// A subset within this relative distance of the best residual will do.
    ///
    /// # Errors
    /// Negative, not finite, or not below 1.
    pub fn tolerance(self, tolerance: f64) -> Result<Self, SindyError> {
        if tolerance >= 1.0 {
            return Err(SindyError::setting(
                "tolerance",
                "a number of at least 0 and below 1",
                tolerance,
            ));
        }
        Ok(Self {
            tolerance: at_least_zero("tolerance", tolerance)?,
            ..self
        })
    }

    /// Searches to the end, or to the node limit.
    ///
    /// # Errors
    /// Statistics that no solver can use ([`check`](crate::statistics::gram::check)); more than [`MAX_TERMS`] terms;
    /// a Gram matrix that no small ridge makes positive definite.
    pub fn solve(&self, gram: &Gram) -> Result<BestSubsets, SindyError> {
        self.search(gram, &[], &mut || true)
    }

    /// As [`Self::solve`], among subsets whose least-squares estimate keeps these signs: one for each term, or none.
    ///
    /// # Errors
    /// As [`BestSubset::solve`]; another number of signs.
    pub fn solve_signed(&self, gram: &Gram, signs: &[Sign]) -> Result<BestSubsets, SindyError> {
        sign::check(signs, gram.xty.len())?;
        self.search(gram, signs, &mut || true)
    }

    /// Searches as long as `keep_going` returns true; it is called every 1024 nodes, so that a caller may
    /// impose a time limit.
    ///
    /// # Errors
    /// As [`BestSubset::solve`].
    pub fn solve_while(
        &self,
        gram: &Gram,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> Result<BestSubsets, SindyError> {
        self.search(gram, &[], keep_going)
    }

    fn search(
        &self,
        gram: &Gram,
        signs: &[Sign],
        keep_going: &mut dyn FnMut() -> bool,
    ) -> Result<BestSubsets, SindyError> {
        let mut normal = Normal::new(gram)?;
        let m = normal.terms.len();
        if m > MAX_TERMS {
            return Err(SindyError::shape(
                "terms for an exact search (at most)",
                MAX_TERMS,
                m,
            ));
        }
        let ridge = normal.regularise();
        let found = search::run(&normal, signs, self, keep_going).ok_or(SindyError::Singular {
            what: "exact search",
        })?;
        let mut sizes = Vec::with_capacity(found.best.len());
        for s in 0..found.best.len() {
            let (share, mask) = found.best[s];
            if sign::is_constrained(signs) && found.is_beaten(s) {
                continue;
            }
            let bound = found.open[s].min(share);
            let outcome = if bound >= share - normal.floor {
                Outcome::Optimal
            } else if let Some(stopped) = found.stopped {
                stopped
            } else {
                Outcome::WithinTolerance
            };
            let support = normal.support((0..m).filter(|j| mask >> j & 1 == 1));
            // Rounding alone can turn a sign here.
            let fit = sign::kept(gram, Fit::on_support(gram, support, outcome, 0), signs);
            sizes.push(Subset {
                lower_bound: if outcome == Outcome::Optimal {
                    fit.residual_sum
                } else {
                    (bound * normal.unit).clamp(0.0, fit.residual_sum)
                },
                fit,
            });
        }
        // A size that lacks is proven to be empty by a search to the end alone.
        let lacking = found.stopped.filter(|_| sizes.len() < found.best.len());
        let unproven = |s: &&Subset| s.fit.outcome != Outcome::Optimal;
        let first = sizes.iter().find(unproven).map(|s| s.fit.outcome);
        Ok(BestSubsets {
            outcome: first.or(lacking).unwrap_or(Outcome::Optimal),
            sizes,
            nodes: found.nodes,
            ridge,
        })
    }
}

/// The best subset of the size that a criterion prefers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BestBy {
    /// The search.
    pub search: BestSubset,
    /// What sizes are compared by.
    pub criterion: Criterion,
}

impl Solver for BestBy {
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError> {
        let subsets = self.search.solve(gram)?;
        Ok(subsets.choose(gram, self.criterion, None)?.fit.clone())
    }
}

#[cfg(test)]
mod tests;
