//! Gross errors in single rows of a map.
//!
//! Neighbours in time do not predict each other here, the map does. It is estimated robustly, by least squares over all candidates on
//! the rows that it leaves least of (least trimmed squares, by concentration steps), from a first guess that has no candidates:
//! the median of what follows the nearest points. A wrong row spoils two errors of the next sample, its own and that of the row
//! after it, which is predicted from it. So a step from row to row counts by the largest of its errors and those of the step before.
//!
//! A row is set aside if its error is more than noise: beyond the level of a test, beside the scale of all errors and beside that of
//! its neighbours in state and inputs. What a missing term does, and noise that depends on the state, is seen by neighbours as well.
//! Nothing is said of a row that is predicted from further away than the rows that count lie: by `φᵀ (ΦᵀΦ)⁻¹ φ` of its candidates.
//!
//! Sources: P. J. Rousseeuw, K. Van Driessen, "Computing LTS regression for large data sets", Data Mining and Knowledge Discovery 12
//! (2006); F. R. Hampel, "The influence curve and its role in robust estimation", J. Am. Stat. Assoc. 69 (1974).

use nalgebra::{DMatrix, DVector, Matrix};
use sindy_expr::Scratch;
use statrs::distribution::{ContinuousCDF as _, StudentsT};

use super::known::KnownPart;
use super::neighbours::{deviations, distance};
use crate::data::dataset::{Dataset, FEWEST, Stretch};
use crate::error::SindyError;
use crate::library::Library;
use crate::model::Model;
use crate::numerics::upper_median;
use crate::statistics::regression::pseudo_inverse;

/// Steps that the map is estimated from, about: time grows with the square of their number.
const STEPS: usize = 2000;
/// Steps for each candidate, at least: the half that counts then determines the map with some steps to spare.
const FOR_EACH: usize = 4;
/// Nearest points whose next values give the first guess: the median of seven stands three wrong ones.
const NEAREST: usize = 7;
/// Share of the steps that count: a half stands the most wrong ones, and more of it loses less of the others.
const COUNTED: f64 = 0.6;
/// Concentration steps, at most; they end by themselves after a few.
const ROUNDS: usize = 30;
/// Median of the absolute value of a standard normal variable, inverted.
const MEDIAN: f64 = 1.482_602_218_505_602;
/// Neighbours whose errors give the local scale, and what their median is worth: 0.37 as much as a standard deviation.
const AROUND: usize = 50;
const DEGREES: f64 = 0.37 * AROUND as f64;
/// Level of the test for all rows together: of clean maps one in a hundred loses a row.
const LEVEL: f64 = 0.01;
/// The least scale, as a share of a state's spread: the rounding of six printed digits.
const FLOOR: f64 = 1e-6;
/// Share of a point that steps which span it may leave of it: normal equations hold seven of sixteen digits.
const SPANNED: f64 = 1e-7;
/// A larger share of rows is something else: a second regime, or a term that lacks.
const SHARE: f64 = 0.1;
/// Places that a warning names, for each state.
const NAMED: usize = 3;

/// A row that is none of its map.
struct Outlier {
    stretch: usize,
    row: usize,
    state: usize,
    /// Its error over that of its neighbours.
    distance: f64,
}

/// The stretches without their outliers.
pub(super) struct WithoutOutliers<'a> {
    pub stretches: Vec<Stretch<'a>>,
    /// One for each state that has outliers.
    pub warnings: Vec<String>,
}

/// The stretches without rows that are gross errors; `None` where there are none.
pub(super) fn set_aside<'a>(
    data: &Dataset,
    stretches: &[Stretch<'a>],
    libraries: &[Library],
    known: &[KnownPart],
) -> Result<Option<WithoutOutliers<'a>>, SindyError> {
    let steps = Steps::of(data, stretches);
    let most = libraries.iter().map(Library::len).max().unwrap_or(0);
    if steps.points.len() < FOR_EACH * (most + 1) || steps.points.len() <= AROUND {
        return Ok(None);
    }
    let Some(predictions) = steps.predictions(data, libraries, known)? else {
        return Ok(None);
    };
    let found = steps.outliers(&predictions);
    if found.is_empty() || found.len() as f64 > SHARE * steps.points.len() as f64 {
        return Ok(None);
    }
    let mut kept = Vec::new();
    for (index, stretch) in stretches.iter().enumerate() {
        let own = found.iter().filter(|o| o.stretch == index);
        let mut from = 0;
        for end in own.map(|o| o.row).chain([stretch.time.len()]) {
            if end >= from + FEWEST {
                kept.push(stretch.part(from..end));
            }
            from = end + 1;
        }
    }
    Ok(Some(WithoutOutliers {
        stretches: kept,
        warnings: warnings(data, stretches, &found),
    }))
}

/// Rows that a model leaves, of those that it was fitted to: far off what it predicts from the row before.
pub(super) fn left(
    data: &Dataset,
    stretches: &[Stretch<'_>],
    model: &Model,
) -> Result<usize, SindyError> {
    let steps = Steps::of(data, stretches);
    if steps.points.len() <= AROUND {
        return Ok(0);
    }
    let mut of: Vec<Prediction> = data
        .states()
        .iter()
        .map(|_| Prediction::default())
        .collect();
    for s in stretches {
        let last = s.time.len().saturating_sub(1);
        let columns: Vec<&[f64]> = s.columns.iter().map(|c| &c[..last]).collect();
        let next = model.predict(&columns)?;
        for (i, of) in of.iter_mut().enumerate() {
            let errors = (0..last).map(|k| s.columns[i][k + 1] - next[i][k]);
            of.errors.extend(errors);
            of.inside.resize(of.errors.len(), true);
        }
    }
    Ok(steps.outliers(&of).len())
}

fn warnings(data: &Dataset, stretches: &[Stretch<'_>], found: &[Outlier]) -> Vec<String> {
    let mut out = Vec::new();
    for (i, state) in data.states().iter().enumerate() {
        let own: Vec<&Outlier> = found.iter().filter(|o| o.state == i).collect();
        let place = |o: &&Outlier| {
            let stretch = &stretches[o.stretch];
            let name = &data.trajectories()[stretch.trajectory].name;
            let (time, distance) = (stretch.time[o.row], o.distance);
            format!("{name} at time {time} ({distance:.2e} times the noise)")
        };
        let places: Vec<String> = own.iter().take(NAMED).map(place).collect();
        let more = if own.len() > NAMED { ", …" } else { "" };
        if !own.is_empty() {
            out.push(format!(
                "{} of {} values of {state} are taken for outliers, which single rows far off what the row before predicts are, and \
                 have no weight: {}{more} (`outliers = false` in the settings keeps them)",
                own.len(),
                data.report().rows,
                places.join(", ")
            ));
        }
    }
    out
}

/// A map at all steps, for one state.
#[derive(Default)]
struct Prediction {
    errors: Vec<f64>,
    /// Whether the step begins where those that count do.
    inside: Vec<bool>,
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
struct Steps {
    /// States and inputs of the first row.
    points: Vec<Vec<f64>>,
    /// States of the next row.
    next: Vec<Vec<f64>>,
    /// Stretch and place of the next row.
    place: Vec<(usize, usize)>,
    /// Steps that the map is estimated from, with their points in units of the spread.
    sample: Vec<usize>,
    scaled: Vec<Vec<f64>>,
    spread: Vec<f64>,
}

impl Steps {
    fn of(data: &Dataset, stretches: &[Stretch<'_>]) -> Self {
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
    fn nearest(&self, step: usize, number: usize) -> Vec<usize> {
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
    fn predictions(
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
    fn scale(&self, errors: &[f64], state: usize) -> f64 {
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
    fn follows(&self, k: usize) -> bool {
        k > 0 && self.place[k - 1].0 == self.place[k].0
    }

    /// Rows beyond the level, in the order of time.
    fn outliers(&self, of: &[Prediction]) -> Vec<Outlier> {
        let tests = (of.len() * self.points.len()) as f64;
        let far = StudentsT::new(0.0, 1.0, DEGREES)
            .map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - 0.5 * LEVEL / tests));
        let scales: Vec<f64> = (0..of.len())
            .map(|i| self.scale(&of[i].errors, i))
            .collect();
        let worst = |k: usize, inside: bool| {
            let errors = of.iter().zip(&scales).enumerate();
            let beyond = errors
                .filter(|(_, (p, s))| p.inside[k] == inside && p.errors[k].abs() > far * **s)
                .map(|(i, (p, s))| (i, p.errors[k].abs() / self.local(k, &p.errors, *s)));
            let most = beyond.max_by(|a, b| a.1.total_cmp(&b.1));
            most.filter(|(_, distance)| *distance > far)
        };
        let mut found: Vec<Outlier> = Vec::new();
        for k in 0..self.points.len() {
            let (stretch, row) = self.place[k];
            let last = found.last();
            let follows_one = last.is_some_and(|o| o.stretch == stretch && o.row + 1 == row);
            let outlier = match follows_one {
                false => worst(k, true),
                // A row that is none of the map predicts nothing. The next one is none either where it lies outside and predicts
                // what does not follow.
                true if k + 1 < self.points.len() && self.follows(k + 1) => worst(k + 1, false),
                true => None,
            };
            if let Some((state, distance)) = outlier {
                found.push(Outlier {
                    stretch,
                    row,
                    state,
                    distance,
                });
            }
        }
        found
    }

    /// The scale of the errors around a step, at least that of all.
    fn local(&self, step: usize, errors: &[f64], scale: f64) -> f64 {
        let nearest = self.nearest(step, AROUND);
        let mut sizes: Vec<f64> = nearest.iter().map(|&j| errors[j].abs()).collect();
        let median = upper_median(&mut sizes).unwrap_or(f64::INFINITY);
        (MEDIAN * median).max(scale)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, StandardNormal};

    use crate::identify::{Identification, Settings};
    use crate::{Dataset, Identify, Library};

    /// A map with an input that settles on a cycle after a start far away; one row in `every` is off.
    fn fitted(seed: u64, every: usize, outliers: bool) -> (Identification, usize) {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut data = Dataset::new(&["x"], &["u"]).unwrap();
        let mut spoilt = 0;
        for start in [2.0, -1.6] {
            let mut columns = vec![Vec::new(), Vec::new()];
            let mut x = start;
            for k in 0..300 {
                let u = (0.3 * f64::from(k)).sin() + 0.8 * (0.83 * f64::from(k)).sin();
                let noise: f64 = StandardNormal.sample(&mut rng);
                let off = k > 0 && rng.random_range(0..every) == 0;
                spoilt += usize::from(off);
                let wrong = if off { rng.random_range(1.0..4.0) } else { 0.0 };
                columns[0].push(x + 0.005 * noise + wrong);
                columns[1].push(u);
                x = 0.6 * x - 0.1 * x.powi(3) + 0.3 * u;
            }
            let time = (0..300).map(f64::from).collect();
            data.push("run", time, columns, None).unwrap();
        }
        let settings = Settings {
            discrete: true,
            outliers,
            ..Settings::default()
        };
        let identify = Identify::new(Library::polynomial(&["x", "u"], 3).unwrap());
        let identify = identify.settings(settings).unwrap();
        (identify.run(&data, &mut |_| ()).unwrap(), spoilt)
    }

    fn terms(found: &Identification) -> Vec<String> {
        let equation = found.model.equations()[0].iter();
        equation.map(|t| t.expression.to_string()).collect()
    }

    #[test]
    fn analytic_rows_that_are_off_have_no_weight_in_a_map() {
        for seed in 0..3 {
            let (found, spoilt) = fitted(seed, 40, true);
            assert_eq!(terms(&found), ["x", "u", "x^3"], "{}", found.model);
            let said = found.warnings.join("; ");
            let count: usize = said.split(' ').next().unwrap().parse().unwrap();
            // A row that follows one that is off is not predicted: some of those that are off are neighbours.
            assert!(count <= spoilt && count + 3 >= spoilt, "{spoilt}: {said}");
            let (kept, _) = fitted(seed, 40, false);
            assert_ne!(terms(&kept), ["x", "u", "x^3"], "{}", kept.model);
        }
    }

    #[test]
    fn analytic_a_clean_map_keeps_all_rows() {
        for seed in 0..6 {
            let (found, _) = fitted(seed, usize::MAX, true);
            let said = found.warnings.join("; ");
            // A level of 1 % for each of them.
            assert!(!said.contains("outliers"), "{said}");
        }
    }
}
