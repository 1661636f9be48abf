//! A map, estimated from rows some of which are none of it.
//!
//! Least squares over all candidates on the rows that it leaves least of (least trimmed squares, by concentration steps), from a
//! first guess that has no candidates: the median of what follows the nearest points. A wrong row spoils two errors of the next
//! sample, its own and that of the row after it, which is predicted from it. So a step from row to row counts by the largest of its
//! errors and those of the step before.
//!
//! Source: P. J. Rousseeuw, K. Van Driessen, "Computing LTS regression for large data sets", Data Mining and Knowledge Discovery 12
//! (2006).

use nalgebra::{DMatrix, DVector, Matrix};
use sindy_expr::Scratch;

use crate::data::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::identify::known::KnownPart;
use crate::identify::neighbours::{deviations, distance};
use crate::library::Library;
use crate::numerics::upper_median;
use crate::statistics::regression::pseudo_inverse;

/// Steps that the map is estimated from, about: time grows with the square of their number.
const STEPS: usize = 2000;
/// Nearest points whose next values give the first guess: the median of seven stands three wrong ones.
const NEAREST: usize = 7;
/// Share of the steps that count: a half stands the most wrong ones, and more of it loses less of the others.
const COUNTED: f64 = 0.6;
/// Concentration steps, at most; they end by themselves after a few.
const ROUNDS: usize = 30;
/// Median of the absolute value of a standard normal variable, inverted.
pub(super) const MEDIAN: f64 = 1.482_602_218_505_602;
/// The least scale, as a share of a state's spread: the rounding of six printed digits.
const FLOOR: f64 = 1e-6;
/// Share of a point that steps which span it may leave of it: normal equations hold seven of sixteen digits.
const SPANNED: f64 = 1e-7;

/// A map at all steps, for one state.
#[derive(Default)]
pub(super) struct Prediction {
    pub errors: Vec<f64>,
    /// Whether the step begins where those that count do.
    pub inside: Vec<bool>,
}

/// A map of one state by least squares on the steps that count, over candidates of unit length.
struct LeastSquares {
    lengths: DVector<f64>,
    coefficients: DVector<f64>,
    /// The candidates of the steps that count, one column each, their products and the inverse of these.
    counted: DMatrix<f64>,
    gram: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl LeastSquares {
    fn new(columns: &DMatrix<f64>, (state, steps): (usize, &[usize]), next: &[Vec<f64>]) -> Self {
        let mut counted = columns.select_columns(steps);
        let y = DVector::from_iterator(steps.len(), steps.iter().map(|&k| next[k][state]));
        let length = |row: usize| counted.row(row).norm().max(f64::MIN_POSITIVE);
        let lengths = DVector::from_fn(counted.nrows(), |row, _| length(row));
        for (mut row, length) in counted.row_iter_mut().zip(lengths.iter()) {
            row /= *length;
        }
        let gram = &counted * counted.transpose();
        let inverse = pseudo_inverse(&gram);
        Self {
            coefficients: &inverse * (&counted * y),
            lengths,
            counted,
            gram,
            inverse,
        }
    }

    /// The errors at all steps.
    fn errors(&self, columns: &DMatrix<f64>, state: usize, next: &[Vec<f64>]) -> Vec<f64> {
        let predicted = columns.tr_mul(&self.coefficients.component_div(&self.lengths));
        let steps = next.iter().zip(predicted.iter());
        steps
            .map(|(next, predicted)| next[state] - predicted)
            .collect()
    }

    /// Whether each step begins no further away than those that count.
    fn inside(&self, columns: &DMatrix<f64>) -> Vec<bool> {
        let away = |point: &DVector<f64>| point.dot(&(&self.inverse * point));
        // What the counted ones do not span, they do not say.
        let beyond = |point: &DVector<f64>| {
            let left = point - &self.gram * (&self.inverse * point);
            left.norm() / point.norm().max(f64::MIN_POSITIVE)
        };
        let (mut furthest, mut most) = (0.0_f64, SPANNED);
        for point in self.counted.column_iter().map(Matrix::into_owned) {
            (furthest, most) = (furthest.max(away(&point)), most.max(beyond(&point)));
        }
        let points = columns
            .column_iter()
            .map(|c| c.component_div(&self.lengths));
        points
            .map(|point| beyond(&point) <= most && away(&point) <= furthest)
            .collect()
    }
}

/// All steps from row to row.
pub(super) struct Steps {
    /// States and inputs of the first row.
    pub points: Vec<Vec<f64>>,
    /// States of the next row.
    pub next: Vec<Vec<f64>>,
    /// Stretch and place of the next row.
    pub place: Vec<(usize, usize)>,
    /// Steps that the map is estimated from, with their points in units of the spread.
    sample: Vec<usize>,
    scaled: Vec<Vec<f64>>,
    pub spread: Vec<f64>,
}

impl Steps {
    pub(super) fn of(data: &Dataset, stretches: &[Stretch<'_>]) -> Self {
        let n = data.states().len();
        let (mut points, mut next, mut place) = (Vec::new(), Vec::new(), Vec::new());
        for (index, s) in stretches.iter().enumerate() {
            for k in 1..s.time.len() {
                points.push(s.columns.iter().map(|c| c[k - 1]).collect::<Vec<f64>>());
                next.push(s.columns[..n].iter().map(|c| c[k]).collect());
                place.push((index, k));
            }
        }
        let spread: Vec<f64> = deviations(&points);
        let scale = |point: &Vec<f64>| -> Vec<f64> {
            let all = point.iter().zip(&spread);
            all.map(|(v, s)| if *s > 0.0 { v / s } else { 0.0 })
                .collect()
        };
        Self {
            scaled: points.iter().map(scale).collect(),
            sample: (0..points.len())
                .step_by(points.len().div_ceil(STEPS).max(1))
                .collect(),
            points,
            next,
            place,
            spread,
        }
    }

    /// The nearest steps of the sample to a step, itself left out.
    pub(super) fn nearest(&self, step: usize, number: usize) -> Vec<usize> {
        let others = self.sample.iter().filter(|&&j| j != step);
        let own = &self.scaled[step];
        let mut all: Vec<(f64, usize)> = others
            .map(|&j| (distance(own, &self.scaled[j]), j))
            .collect();
        let number = number.min(all.len());
        if number < all.len() {
            all.select_nth_unstable_by(number, |a, b| a.0.total_cmp(&b.0));
        }
        all[..number].iter().map(|(_, j)| *j).collect()
    }

    /// The robust map of each state; `None` where candidates are not finite.
    pub(super) fn predictions(
        &self,
        data: &Dataset,
        libraries: &[Library],
        known: &[KnownPart],
    ) -> Result<Option<Vec<Prediction>>, SindyError> {
        let n = data.states().len();
        let mut columns = Vec::new();
        for (i, known) in known.iter().enumerate().take(n) {
            let library = known.with(&libraries[i.min(libraries.len() - 1)]);
            let program = library.compile(&data.names())?;
            let mut scratch = Scratch::new();
            let mut all = DMatrix::zeros(library.len(), self.points.len());
            for (point, mut column) in self.points.iter().zip(all.column_iter_mut()) {
                program.eval_row(point, column.as_mut_slice(), &mut scratch);
            }
            if all.iter().any(|v| !v.is_finite()) {
                return Ok(None);
            }
            columns.push(all);
        }
        let mut counted = self.best(&self.first_guess(n));
        for round in 1.. {
            let fit = |i| LeastSquares::new(&columns[i], (i, &counted), &self.next);
            let fits: Vec<LeastSquares> = (0..n).map(fit).collect();
            let errors: Vec<Vec<f64>> = (0..n)
                .map(|i| fits[i].errors(&columns[i], i, &self.next))
                .collect();
            let next = self.best(&errors);
            if next == counted || round == ROUNDS {
                let all = fits.iter().zip(errors).zip(&columns);
                let predictions = all.map(|((fit, errors), columns)| Prediction {
                    errors,
                    inside: fit.inside(columns),
                });
                return Ok(Some(predictions.collect()));
            }
            counted = next;
        }
        Ok(None)
    }

    /// Errors of the median of what follows the nearest points; zero of steps that are not in the sample.
    fn first_guess(&self, n: usize) -> Vec<Vec<f64>> {
        let mut errors = vec![vec![0.0; self.points.len()]; n];
        for &step in &self.sample {
            let nearest = self.nearest(step, NEAREST);
            for (i, errors) in errors.iter_mut().enumerate() {
                let mut values: Vec<f64> = nearest.iter().map(|&j| self.next[j][i]).collect();
                let middle = upper_median(&mut values).unwrap_or(f64::NAN);
                errors[step] = self.next[step][i] - middle;
            }
        }
        errors
    }

    /// The scale of a state's errors, by their median over the sample.
    pub(super) fn scale(&self, errors: &[f64], state: usize) -> f64 {
        let mut sizes: Vec<f64> = self.sample.iter().map(|&k| errors[k].abs()).collect();
        let median = upper_median(&mut sizes).unwrap_or(0.0);
        (MEDIAN * median).max(FLOOR * self.spread[state])
    }

    /// The steps of the sample that count: those whose errors, and those of the step before, are least.
    fn best(&self, errors: &[Vec<f64>]) -> Vec<usize> {
        let scales: Vec<f64> = (0..errors.len())
            .map(|i| self.scale(&errors[i], i).max(f64::MIN_POSITIVE))
            .collect();
        let size = |k: usize| {
            let of = |(e, s): (&Vec<f64>, &f64)| e[k].abs() / s;
            errors.iter().zip(&scales).map(of).fold(0.0, f64::max)
        };
        let largest = |k: usize| match self.follows(k) {
            true => size(k).max(size(k - 1)),
            false => size(k),
        };
        let mut all: Vec<(f64, usize)> = self.sample.iter().map(|&k| (largest(k), k)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.truncate((COUNTED * all.len() as f64).ceil() as usize);
        let mut out: Vec<usize> = all.into_iter().map(|(_, k)| k).collect();
        out.sort_unstable();
        out
    }

    /// Whether a step begins where the one before ends.
    pub(super) fn follows(&self, k: usize) -> bool {
        k > 0 && self.place[k - 1].0 == self.place[k].0
    }
}
