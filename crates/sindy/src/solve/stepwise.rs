//! Stepwise selection: one term more or less at a time, as long as a criterion improves.
//!
//! Forward starts without terms and adds, backward starts with all and drops, and [`Direction::Both`]
//! starts without terms and looks at every addition and every removal. Each step takes the change with the
//! best score; with no change that improves the score the search ends. It is greedy: for a proof of the
//! best subset see [`exact`](crate::solve::exact).
//!
//! Statistics of a singular or nearly singular library (condition of the scaled `Θ` above 3e6) are treated
//! with a ridge of about 2e-13 of each column's square during the search; the final fit has none.
//!
//! Source: N. R. Draper, H. Smith, "Applied Regression Analysis" (1998), ch. 15.

use crate::error::SindyError;
use crate::solve::fit::{Fit, Solver};
use crate::solve::outcome::Outcome;
use crate::statistics::criteria::{Criterion, rows};
use crate::statistics::gram::Gram;
use crate::statistics::normal::{Additions, Factor, Normal};

/// Which changes are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From no terms, additions only.
    Forward,
    /// From all terms, removals only.
    Backward,
    /// From no terms, additions and removals.
    Both,
}

/// Settings of stepwise selection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepwise {
    direction: Direction,
    criterion: Criterion,
    effective_rows: Option<f64>,
    most: usize,
}

/// One change.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Step {
    /// The term that came or went.
    pub term: usize,
    /// Whether it came.
    pub added: bool,
    /// The criterion's score after the change.
    pub score: f64,
}

impl Stepwise {
    /// Stepwise selection by `criterion`.
    #[must_use]
    pub fn new(direction: Direction, criterion: Criterion) -> Self {
        Self {
            direction,
            criterion,
            effective_rows: None,
            most: usize::MAX,
        }
    }

    /// The same with at most `changes` changes.
    #[must_use]
    pub fn at_most(self, changes: usize) -> Self {
        Self {
            most: changes,
            ..self
        }
    }

    /// The same with the number of independent rows that hold the information of the correlated ones.
    ///
    /// # Errors
    /// `n` not positive.
    pub fn effective_rows(self, n: f64) -> Result<Self, SindyError> {
        let n = rows(&Gram::zeros(0), Some(n))?;
        Ok(Self {
            effective_rows: Some(n),
            ..self
        })
    }

    /// The fit and the changes that led to it.
    ///
    /// # Errors
    /// Statistics that no solver can use ([`check`](crate::statistics::gram::check)).
    pub fn path(&self, gram: &Gram) -> Result<(Fit, Vec<Step>), SindyError> {
        let mut normal = Normal::new(gram)?;
        normal.regularise();
        let rows = rows(gram, self.effective_rows)?;
        let m = normal.terms.len();
        let mut index: Vec<usize> = match self.direction {
            Direction::Backward => (0..m).collect(),
            _ => Vec::new(),
        };
        let mut score = self.criterion.of_subset(&normal, &index, index.len(), rows);
        let mut steps = Vec::new();
        let mut additions = Additions::to(&normal, &index);
        while steps.len() < self.most {
            let mut best: Option<(f64, f64, usize)> = None;
            for (j, share) in self.changes(&normal, &index, &additions) {
                let next_score = self.score(&normal, &index, (j, share), rows);
                if best.is_none_or(|(s, r, _)| (next_score, share) < (s, r)) {
                    best = Some((next_score, share, j));
                }
            }
            // With as many terms as rows a corrected criterion is infinite: drop until it is not.
            let crowded = score == f64::INFINITY && self.direction == Direction::Backward;
            let Some((next_score, _, j)) = best.filter(|b| b.0 < score || crowded) else {
                break;
            };
            let added = !index.contains(&j);
            index = changed(&index, j);
            if added {
                additions.add(j);
            } else if self.direction == Direction::Both {
                additions = Additions::to(&normal, &index);
            }
            score = next_score;
            steps.push(Step {
                term: normal.terms[j],
                added,
                score,
            });
        }
        let support = normal.support(index);
        let fit = Fit::on_support(gram, support, Outcome::Converged, steps.len());
        Ok((fit, steps))
    }

    /// The score after the change of column `j`, which leaves `share` of the target's square.
    fn score(&self, normal: &Normal, index: &[usize], (j, share): (usize, f64), rows: f64) -> f64 {
        let terms = match index.contains(&j) {
            true => index.len() - 1,
            false => index.len() + 1,
        };
        match self.criterion {
            Criterion::Evidence => {
                let next = changed(index, j);
                self.criterion.of_subset(normal, &next, terms, rows)
            }
            _ => self.criterion.of_share(normal, share, terms, rows),
        }
    }

    /// Every change that is allowed: the column, and the residual share after it.
    fn changes(
        &self,
        normal: &Normal,
        index: &[usize],
        additions: &Additions<'_>,
    ) -> Vec<(usize, f64)> {
        let mut out = Vec::new();
        if self.direction != Direction::Forward {
            let mut factor = Factor::new(index.len());
            for &j in index {
                factor.push(
                    |c| normal.g[(j, index.get(c).copied().unwrap_or(j))],
                    normal.b[j],
                );
            }
            let rest = 1.0 - factor.explained();
            let costs = index.iter().zip(factor.drop_costs());
            out.extend(costs.map(|(&j, cost)| (j, rest + cost)));
        }
        if self.direction != Direction::Backward {
            let rest = 1.0 - additions.explained();
            out.extend(additions.gains().map(|(j, gain)| (j, rest - gain)));
        }
        out
    }
}

/// The columns after `j` came or went.
fn changed(index: &[usize], j: usize) -> Vec<usize> {
    let others = index.iter().copied().filter(|&i| i != j);
    let own = (!index.contains(&j)).then_some(j);
    others.chain(own).collect()
}

impl Solver for Stepwise {
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError> {
        Ok(self.path(gram)?.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::exact::{BestBy, BestSubset};
    use crate::statistics::normal::tests::{of_rows, random_gram, random_rows};
    use proptest::prelude::*;

    const DIRECTIONS: [Direction; 3] = [Direction::Forward, Direction::Backward, Direction::Both];
    const CRITERIA: [Criterion; 4] = [
        Criterion::Aic,
        Criterion::Aicc,
        Criterion::Bic,
        Criterion::Evidence,
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn prop_no_single_change_improves_and_no_subset_beats_the_exact_one(
            seed in 0u64..1000, mix in -1.0..1.0f64, which in 0usize..12,
        ) {
            let gram = random_gram(seed, 50, &[0.6, 0.0, 0.3, 0.0, 0.1, 0.0], mix, 0.8);
            let (direction, criterion) = (DIRECTIONS[which % 3], CRITERIA[which / 3]);
            let (fit, steps) = Stepwise::new(direction, criterion).path(&gram).unwrap();
            let score = criterion.score(&gram, &fit.support, None).unwrap();
            // The search and the criterion take two routes to the same number: rounding.
            if let Some(last) = steps.last() {
                prop_assert!((last.score - score).abs() < 1e-8);
            }
            for j in 0..6 {
                let mut other = fit.support.clone();
                other[j] = !other[j];
                let allowed = match direction {
                    Direction::Forward => other[j],
                    Direction::Backward => !other[j],
                    Direction::Both => true,
                };
                if allowed {
                    prop_assert!(criterion.score(&gram, &other, None).unwrap() >= score - 1e-8);
                }
            }
            // The exact search minimises the residual of each size, and with it all but the evidence.
            if criterion != Criterion::Evidence {
                let best = BestBy { search: BestSubset::new(), criterion }.fit(&gram).unwrap();
                let best = criterion.score(&gram, &best.support, None).unwrap();
                prop_assert!(best <= score + 1e-8);
            }
        }
    }

    #[test]
    fn analytic_strong_terms_are_found_in_every_direction() {
        let gram = random_gram(8, 400, &[1.0, 0.0, -2.0, 0.0, 0.5], 0.5, 0.1);
        for direction in DIRECTIONS {
            for criterion in [Criterion::Bic, Criterion::Evidence] {
                let fit = Stepwise::new(direction, criterion).fit(&gram).unwrap();
                assert_eq!(
                    fit.support,
                    [true, false, true, false, true],
                    "{direction:?} {criterion:?}"
                );
                assert_eq!(fit.outcome, Outcome::Converged);
            }
        }
    }

    #[test]
    fn prop_more_terms_than_rows_and_repeated_columns() {
        // Eight columns, of which the last four repeat the first; six rows.
        let (theta, y) = random_rows(5, 6, &[2.0, 0.0, 0.0, 0.0], 0.0, 0.01);
        let wide = nalgebra::DMatrix::from_fn(6, 8, |i, j| theta[(i, j % 4)]);
        let gram = of_rows(&wide, &y);
        for direction in DIRECTIONS {
            let (fit, _) = Stepwise::new(direction, Criterion::Aicc)
                .path(&gram)
                .unwrap();
            // AICc is finite up to three terms of six rows; a column and its copy are never both kept.
            assert!((1..=3).contains(&fit.terms()), "{direction:?} {fit:?}");
            assert!(fit.support[0] != fit.support[4], "{direction:?} {fit:?}");
            assert!((1..4).all(|j| !(fit.support[j] && fit.support[j + 4])));
        }
        assert!(
            Stepwise::new(Direction::Both, Criterion::Bic)
                .effective_rows(-1.0)
                .is_err()
        );
        assert!(
            Stepwise::new(Direction::Both, Criterion::Bic)
                .fit(&Gram::zeros(2))
                .is_err()
        );
    }
}
