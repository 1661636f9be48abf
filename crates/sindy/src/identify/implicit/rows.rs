//! Candidate terms under windows of the weak form, and relations fitted to them.
//!
//! ```text
//! -∫ φ' x = ∫ φ N/D          for the fit of N/D, x as measured, N and D of smoothed states
//! Σ_j ξ_j ∫ φ θ_j = Σ_k η_k ∫ φ x' φ_k      for the choice of terms, x' the slope of the smoothed state
//! ```
//!
//! Windows that are wider than the smoothing take most of the noise out of x', which would bias every coefficient.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use sindy_expr::{Program, Scratch};

use super::relation::{Candidates, Place, Relation};
use crate::data::dataset::Stretch;
use crate::derivative::savgol::Smoothed;
use crate::error::SindyError;
use crate::identify::prepare::Slopes;
use crate::identify::regress::INDEPENDENT_WINDOWS;
use crate::identify::run::IdentificationRun;
use crate::statistics::gram::Gram;
use crate::statistics::regression::pseudo_inverse;
use crate::weak::{choose_half_width, place};

/// Rows at most: they give starts, which trajectories judge.
const MOST_ROWS: usize = 6000;
/// Rows of a part of a longer record.
const PART: usize = 1000;
/// Power of the test function, and the distance of windows in half-widths: those of the weak form.
const POWER: u32 = 8;
const SPACING: f64 = 0.125;
/// Steps of a fit, at most.
const STEPS: usize = 25;
/// A step that lowers the sum of squares by less than this share is the last.
const SETTLED: f64 = 1e-9;
/// Halvings of a step, at most.
const HALVINGS: usize = 12;

/// A window: weights of rows, and the integral of x' under it.
struct RowWindow {
    first: usize,
    weights: Vec<f64>,
    left: f64,
}

/// Terms of an equation on rows.
pub(super) struct Rows {
    /// By term, then row.
    numerator: Vec<Vec<f64>>,
    denominator: Vec<Vec<f64>>,
    slope: Vec<f64>,
    windows: Vec<RowWindow>,
    /// Windows that are independent, with those of rows that were left out.
    pub independent: f64,
}

impl Rows {
    /// Of the equation of state `i`, by smoothed stretches.
    pub(super) fn new(
        run: &IdentificationRun<'_>,
        slopes: &Slopes,
        i: usize,
        candidates: &Candidates,
    ) -> Result<Self, SindyError> {
        let names = run.data.names();
        let programs = [
            candidates.numerator.compile(&names)?,
            candidates.denominator.compile(&names)?,
        ];
        let mut out = Self {
            numerator: vec![Vec::new(); candidates.numerator.len()],
            denominator: vec![Vec::new(); candidates.denominator.len()],
            slope: Vec::new(),
            windows: Vec::new(),
            independent: 0.0,
        };
        let all: usize = run.stretches.iter().map(|s| s.time.len()).sum();
        let stride = all.div_ceil(MOST_ROWS).max(1);
        let part = if stride == 1 { usize::MAX } else { PART };
        let half_width = half_width(run, i);
        let mut number = 0;
        for (stretch, smooth) in run.stretches.iter().zip(&slopes.smoothed) {
            let n = stretch.time.len();
            for first in (0..n).step_by(part.min(n.max(1))) {
                number += 1;
                if !(number - 1_usize).is_multiple_of(stride) {
                    continue;
                }
                let rows = first..n.min(first.saturating_add(part));
                out.add(
                    &stretch.part(rows.clone()),
                    (smooth, rows),
                    (&programs, i, half_width),
                );
            }
        }
        if out.windows.is_empty() {
            let row = |(first, left): (usize, &f64)| RowWindow {
                first,
                weights: vec![1.0],
                left: *left,
            };
            out.windows = out.slope.iter().enumerate().map(row).collect();
            out.independent = out.slope.len() as f64 / slopes.window;
        }
        out.independent *= stride as f64;
        Ok(out)
    }

    /// Adds rows that follow each other without a gap.
    fn add(
        &mut self,
        stretch: &Stretch<'_>,
        (smooth, rows): (&[Smoothed], Range<usize>),
        (programs, i, half_width): (&[Program; 2], usize, Option<f64>),
    ) {
        let mut scratch = Scratch::new();
        let mut theta = vec![0.0; programs[0].outputs()];
        let mut phi = vec![0.0; programs[1].outputs()];
        let start = self.slope.len();
        let states = smooth.len();
        for (k, row) in rows.enumerate() {
            let inputs = stretch.columns[states..].iter().map(|c| c[k]);
            let input: Vec<f64> = smooth.iter().map(|s| s.value[row]).chain(inputs).collect();
            programs[0].eval_row(&input, &mut theta, &mut scratch);
            programs[1].eval_row(&input, &mut phi, &mut scratch);
            let pairs = self.numerator.iter_mut().zip(&theta);
            pairs.for_each(|(to, v)| to.push(*v));
            let pairs = self.denominator.iter_mut().zip(&phi);
            pairs.for_each(|(to, v)| to.push(*v));
            self.slope.push(smooth[i].derivative[row]);
        }
        let Some(half_width) = half_width else {
            return;
        };
        let power = POWER.cast_signed();
        for window in place(stretch.time, half_width, SPACING * half_width, power) {
            let measured = &stretch.columns[i][window.rows.clone()];
            let pairs = window.slope.iter().zip(measured);
            let left = -pairs.map(|(w, x)| w * x).sum::<f64>();
            let first = start + window.rows.start;
            let columns = self.numerator.iter().chain(&self.denominator);
            let reach = first..first + window.value.len();
            if columns
                .clone()
                .all(|c| c[reach.clone()].iter().all(|v| v.is_finite()))
            {
                self.independent += INDEPENDENT_WINDOWS;
                self.windows.push(RowWindow {
                    first,
                    weights: window.value,
                    left,
                });
            }
        }
    }

    fn len(&self) -> usize {
        self.slope.len()
    }

    /// Sums over `[θ, x' φ]`: the relation of any left side is a part of them.
    pub(super) fn products(&self) -> DMatrix<f64> {
        let m = self.numerator.len();
        let columns = m + self.denominator.len();
        let mut all = DMatrix::zeros(self.windows.len(), columns);
        for j in 0..columns {
            let values: Vec<f64> = match j.checked_sub(m) {
                None => self.numerator[j].clone(),
                Some(k) => {
                    let pairs = self.denominator[k].iter().zip(&self.slope);
                    pairs.map(|(v, s)| v * s).collect()
                }
            };
            for (w, window) in self.windows.iter().enumerate() {
                // Of the constant the integral is known without slopes.
                all[(w, j)] = if j == m {
                    window.left
                } else {
                    window.of(&values)
                };
            }
        }
        all.tr_mul(&all)
    }

    /// Statistics of the regression of column `left` of [`Self::products`] on all others.
    pub(super) fn gram(&self, products: &DMatrix<f64>, left: usize) -> Gram {
        let others: Vec<usize> = (0..products.nrows()).filter(|j| *j != left).collect();
        Gram {
            xtx: products.select_rows(&others).select_columns(&others),
            xty: DVector::from_fn(others.len(), |a, _| products[(others[a], left)]),
            yty: products[(left, left)],
            rows: self.windows.len(),
            ..Gram::zeros(others.len())
        }
    }

    /// Statistics of x' under the windows, over all candidates of the numerator over this denominator.
    pub(super) fn gram_over(&self, relation: &Relation) -> Gram {
        let (n, m) = (self.windows.len(), self.numerator.len());
        let below: Vec<f64> = (0..self.len())
            .map(|row| self.sides(relation, row).1)
            .collect();
        let mut all = DMatrix::zeros(n, m);
        for j in 0..m {
            let pairs = self.numerator[j].iter().zip(&below);
            let values: Vec<f64> = pairs.map(|(v, below)| v / below).collect();
            for (w, window) in self.windows.iter().enumerate() {
                all[(w, j)] = window.of(&values);
            }
        }
        let left = DVector::from_iterator(n, self.windows.iter().map(|w| w.left));
        Gram {
            xtx: all.tr_mul(&all),
            xty: all.tr_mul(&left),
            yty: left.norm_squared(),
            rows: n,
            ..Gram::zeros(m)
        }
    }

    /// Root mean square of a denominator's term.
    pub(super) fn size(&self, k: usize) -> f64 {
        let column = &self.denominator[k];
        let square = column.iter().map(|v| v * v).sum::<f64>();
        (square / column.len().max(1) as f64)
            .sqrt()
            .max(f64::MIN_POSITIVE)
    }

    /// N and D of a row.
    fn sides(&self, relation: &Relation, row: usize) -> (f64, f64) {
        let sum = |terms: &[(usize, f64)], values: &[Vec<f64>]| {
            terms.iter().map(|&(j, c)| c * values[j][row]).sum::<f64>()
        };
        (
            sum(&relation.numerator, &self.numerator),
            sum(&relation.denominator, &self.denominator),
        )
    }

    /// Whether the denominator keeps its sign on all rows.
    pub(super) fn is_regular(&self, relation: &Relation) -> bool {
        let mut sign = 0.0;
        (0..self.len()).all(|row| {
            let below = self.sides(relation, row).1;
            if sign == 0.0 {
                sign = below.signum();
            }
            below.is_finite() && below != 0.0 && below.signum() == sign
        })
    }

    /// Root mean square of each linear term of a relation.
    pub(super) fn term_rms(&self, relation: &Relation, places: &[Place]) -> Vec<f64> {
        let mut squares = vec![0.0; places.len()];
        for row in 0..self.len() {
            let (above, below) = self.sides(relation, row);
            for (square, place) in squares.iter_mut().zip(places) {
                *square += self.slope_by(*place, row, (above, below)).powi(2);
            }
        }
        let n = self.len().max(1) as f64;
        squares.iter().map(|s| (s / n).sqrt()).collect()
    }

    /// How N/D changes with the coefficient of a candidate.
    fn slope_by(&self, place: Place, row: usize, (above, below): (f64, f64)) -> f64 {
        match place {
            Place::Numerator(j) => self.numerator[j][row] / below,
            Place::Denominator(k) => -self.denominator[k][row] * above / (below * below),
        }
    }

    /// The relation with the denominator's largest term held at 1.
    pub(super) fn held_at_largest(&self, relation: &Relation) -> Relation {
        let size = |&(k, c): &(usize, f64)| {
            let column = &self.denominator[k];
            c.abs() * column.iter().map(|v| v * v).sum::<f64>().sqrt()
        };
        let all = relation.denominator.iter();
        let largest = all.max_by(|a, b| size(a).total_cmp(&size(b)));
        largest.map_or_else(|| relation.clone(), |t| relation.held_at(t.0))
    }

    /// Sum of squares that N/D leaves of the slopes; infinite where the denominator changes its sign.
    pub(super) fn residual_sum(&self, relation: &Relation) -> f64 {
        if !self.is_regular(relation) {
            return f64::INFINITY;
        }
        let all = self.windows.iter().zip(self.windowed(relation));
        all.map(|(window, right)| (window.left - right).powi(2))
            .sum()
    }

    /// Mean square of [`Self::residual_sum`] for a relation.
    pub(super) fn mean_square(&self, sum: f64) -> f64 {
        sum / self.windows.len().max(1) as f64
    }

    /// N/D under every window.
    fn windowed(&self, relation: &Relation) -> Vec<f64> {
        let of = |row: usize| {
            let (above, below) = self.sides(relation, row);
            above / below
        };
        let values: Vec<f64> = (0..self.len()).map(of).collect();
        self.windows.iter().map(|w| w.of(&values)).collect()
    }

    /// The relation whose N/D is nearest to the slopes by Gauss and Newton's method, and the sum of squares that it leaves.
    pub(super) fn fitted(&self, start: &Relation) -> (Relation, f64) {
        let mut at = self.held_at_largest(start);
        let mut left = self.residual_sum(&at);
        if at.denominator.len() == 1 && !left.is_finite() {
            return (at, left);
        }
        for _ in 0..STEPS {
            if !left.is_finite() {
                break;
            }
            let to = self.step(&at);
            let mut part = 1.0;
            let mut better = None;
            for _ in 0..HALVINGS {
                let next = at.towards(&to, part);
                let sum = self.residual_sum(&next);
                if sum < left {
                    better = Some((next, sum));
                    break;
                }
                part *= 0.5;
            }
            let Some((next, sum)) = better else { break };
            let gain = 1.0 - sum / left;
            (at, left) = (next, sum);
            if gain < SETTLED {
                break;
            }
        }
        (self.held_at_largest(&at), left)
    }

    /// The solution of the relation to first order.
    fn step(&self, at: &Relation) -> Relation {
        let mut places = at.support();
        places.retain(|p| *p != Place::Denominator(at.denominator[0].0));
        let p = places.len();
        let mut normal = DMatrix::<f64>::zeros(p, p);
        let mut right = DVector::<f64>::zeros(p);
        let mut values = vec![0.0; p];
        let columns: Vec<Vec<f64>> = places
            .iter()
            .map(|place| {
                let of = |row: usize| self.slope_by(*place, row, self.sides(at, row));
                (0..self.len()).map(of).collect()
            })
            .collect();
        for (window, now) in self.windows.iter().zip(self.windowed(at)) {
            for (v, column) in values.iter_mut().zip(&columns) {
                *v = window.of(column);
            }
            let left = window.left - now;
            for a in 0..p {
                right[a] += values[a] * left;
                for b in 0..=a {
                    normal[(a, b)] += values[a] * values[b];
                }
            }
        }
        normal.fill_upper_triangle_with_lower_triangle();
        let scale = normal
            .diagonal()
            .map(|d| if d > 0.0 { d.sqrt() } else { 1.0 });
        let scaled = DMatrix::from_fn(p, p, |a, b| normal[(a, b)] / (scale[a] * scale[b]));
        let change = pseudo_inverse(&scaled) * right.component_div(&scale);
        let before = |place: &Place| {
            let of = |terms: &[(usize, f64)], j: usize| {
                terms.iter().find(|t| t.0 == j).map_or(0.0, |t| t.1)
            };
            match *place {
                Place::Numerator(j) => of(&at.numerator, j),
                Place::Denominator(k) => of(&at.denominator, k),
            }
        };
        let all = places.iter().enumerate();
        let after: Vec<f64> = all.map(|(a, p)| before(p) + change[a] / scale[a]).collect();
        at.with(&places, &after)
    }
}

impl RowWindow {
    /// The weighted sum of a column.
    fn of(&self, column: &[f64]) -> f64 {
        let rows = &column[self.first..self.first + self.weights.len()];
        self.weights.iter().zip(rows).map(|(w, v)| w * v).sum()
    }
}

/// The half-width of windows for state `i`; `None` where all stretches are too short for one.
fn half_width(run: &IdentificationRun<'_>, i: usize) -> Option<f64> {
    let series = run.stretches.iter().map(|s| (s.time, s.columns[i]));
    let long: Vec<(&[f64], &[f64])> = series
        .filter(|s| choose_half_width(&[*s], POWER).is_ok())
        .collect();
    choose_half_width(&long, POWER).ok()
}
