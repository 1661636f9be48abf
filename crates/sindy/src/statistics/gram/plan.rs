//! Which products the statistics of a library and its targets need.
//!
//! The products of two terms are often equal: `x·x³ = x²·x²`. The 1596 products of the 56 monomials of
//! degree 5 in three variables are 286 different ones. Each is summed once, from one pair of columns; the other
//! pairs, which differ by no more than the rounding of a term, get the same sum.

use std::collections::HashMap;

use sindy_expr::{Expr, Program};

use super::kernel::{self, ColumnProducts};
use crate::data::samples::position;
use crate::error::SindyError;
use crate::library::Library;

/// The most rows that are evaluated at a time.
pub(crate) const CHUNK: usize = 256;

/// Values that are evaluated at a time: 128 KiB, some of a second-level cache.
const VALUES: usize = 16_384;

/// The pairs are taken one by one if at most this share of them is different.
const WORTHWHILE: f64 = 0.8;

/// A library and its targets, compiled for the columns of a source.
pub(crate) struct Plan {
    pub(super) program: Program,
    /// Columns of the source that are targets.
    pub(super) targets: Vec<usize>,
    /// Number of terms.
    pub(super) p: usize,
    /// Pairs that are multiplied, in the order of their sums; `None` for all pairs.
    pub(super) runs: Option<Vec<ColumnProducts>>,
    /// The sum that belongs to the columns `i <= j`, terms before targets, at `kernel::place(i, j)`.
    pub(super) sum_of: Vec<u32>,
    /// The columns of each different product, then those of the targets' sums.
    factors: Vec<(usize, Option<usize>)>,
}

impl Plan {
    pub(crate) fn new(
        library: &Library,
        targets: &[&str],
        names: &[String],
    ) -> Result<Self, SindyError> {
        let program = library.compile(names)?;
        let targets = targets
            .iter()
            .map(|target| position(names, target))
            .collect::<Result<Vec<_>, _>>()?;
        let p = library.len();
        let m = p + targets.len();
        let all = m * (m + 1) / 2;
        let mut plan = Self {
            program,
            targets,
            p,
            runs: None,
            sum_of: (0..all as u32).collect(),
            factors: (0..m)
                .flat_map(|j| (0..=j).map(move |i| (i, Some(j))))
                .collect(),
        };
        if let Some(keys) = keys(library.terms()) {
            plan.share(&keys);
        }
        plan.factors.extend((p..m).map(|j| (j, None)));
        Ok(plan)
    }

    /// The columns (terms before targets) whose product each sum is of; of one column alone for the sums of the
    /// targets, which are the last.
    pub(crate) fn factors(&self) -> &[(usize, Option<usize>)] {
        &self.factors
    }

    /// Rows that are evaluated at a time: a power of two, so that it divides [`CHUNK`].
    pub(super) fn chunk(&self) -> usize {
        let rows = VALUES / (self.p + self.targets.len());
        1 << rows.clamp(32, CHUNK).ilog2()
    }

    /// Number of different products.
    pub(super) fn products(&self) -> usize {
        self.factors.len() - self.targets.len()
    }

    /// Finds the pairs whose products are equal, and has one of each summed.
    fn share(&mut self, keys: &[u128]) {
        let (p, m) = (self.p, self.p + self.targets.len());
        let mut known: HashMap<u128, u32> = HashMap::with_capacity(p * (p + 1) / 2);
        let mut sum_of = vec![u32::MAX; m * (m + 1) / 2];
        let mut runs = Vec::new();
        let mut sums = 0;
        // The last terms of a library are usually its largest products: they reach most of the others.
        for j in (0..p).rev() {
            let mut with = Vec::new();
            for i in 0..=j {
                let next = sums + with.len() as u32;
                let sum = *known.entry(keys[i] + keys[j]).or_insert(next);
                if sum == next {
                    with.push(i);
                }
                sum_of[kernel::place(i, j)] = sum;
            }
            sums += with.len() as u32;
            if !with.is_empty() {
                runs.push(ColumnProducts { column: j, with });
            }
        }
        for j in p..m {
            let mut with: Vec<usize> = (0..p).collect();
            with.push(j);
            for (k, &i) in with.iter().enumerate() {
                sum_of[kernel::place(i, j)] = sums + k as u32;
            }
            sums += with.len() as u32;
            runs.push(ColumnProducts { column: j, with });
        }
        if f64::from(sums) <= WORTHWHILE * sum_of.len() as f64 {
            let pairs = |run: &ColumnProducts| -> Vec<(usize, Option<usize>)> {
                run.with.iter().map(|&i| (i, Some(run.column))).collect()
            };
            self.factors = runs.iter().flat_map(pairs).collect();
            (self.runs, self.sum_of) = (Some(runs), sum_of);
        }
    }
}

/// A number for each term such that two products of two terms are equal if the sums of their numbers are:
/// the powers of the factors as digits. `None` if the digits do not fit.
fn keys(terms: &[Expr]) -> Option<Vec<u128>> {
    // What a digit counts: a factor above or below the fraction bar, or a number.
    let factors: Vec<Vec<((Expr, bool), u32)>> = terms
        .iter()
        .map(|term| {
            let (number, factors) = term.factors();
            let number = (number != 1.0).then(|| ((Expr::constant(number), false), 1));
            factors
                .into_iter()
                .flat_map(|f| {
                    [
                        ((f.base.clone(), false), f.above),
                        ((f.base, true), f.below),
                    ]
                })
                .filter(|(_, power)| *power > 0)
                .chain(number)
                .collect()
        })
        .collect();
    let mut place_of: HashMap<&(Expr, bool), u32> = HashMap::new();
    let mut largest = 1;
    for (factor, power) in factors.iter().flatten() {
        let next = place_of.len() as u32;
        place_of.entry(factor).or_insert(next);
        largest = largest.max(*power);
    }
    let base = 2 * u128::from(largest) + 1;
    base.checked_pow(place_of.len() as u32)?;
    let digits = |term: &Vec<((Expr, bool), u32)>| {
        term.iter()
            .map(|(factor, power)| u128::from(*power) * base.pow(place_of[factor]))
            .sum()
    };
    Some(factors.iter().map(digits).collect())
}
