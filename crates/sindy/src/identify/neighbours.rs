//! Whether what a map leaves depends on its state: a test by nearest neighbours.
//!
//! If a map lacks a term, the error `r` of its next sample is a function of states and inputs, so that rows that are
//! neighbours there err alike. Noise does not. With `n(k)` the nearest neighbour of row k,
//!
//! ```text
//! T(s) = Σ_k | r(k + s) - r(n(k) + s) |²,      p = share of the shifts s, with s = 0 among them, that have T(s) <= T(0)
//! ```
//!
//! A shift around the record keeps colour and distribution of the errors, and takes them from the rows that they belong to. So p
//! is uniform where errors are noise that does not depend on the state, and 0.01 where they follow it.
//!
//! Source: P. J. Bickel, L. Breiman, "Sums of functions of nearest neighbor distances", Annals of Probability 11 (1983); the
//! shifts as in `trajectory::output_error`.

use crate::data::dataset::Stretch;
use crate::error::SindyError;
use crate::model::Model;

/// Shifts beside that of 0.
const SHIFTS: usize = 99;
/// Rows that are compared, about: the time grows with the square of their number.
pub(super) const ROWS: usize = 1000;
/// Rows below which nothing is tested: shifts would hardly differ.
const FEWEST: usize = 30;

/// How likely errors of the next sample that do not depend on the state would be as alike among neighbours as these; `None`
/// where there are too few rows, or where errors are below `floor` throughout.
pub(super) fn independence(
    model: &Model,
    stretches: &[Stretch<'_>],
    floor: &[f64],
) -> Result<Option<f64>, SindyError> {
    let states = model.states().len();
    let rows: usize = stretches.iter().map(|s| s.time.len()).sum();
    let stride = rows.div_ceil(ROWS).max(1);
    let mut points: Vec<Vec<f64>> = Vec::new();
    let mut errors: Vec<Vec<f64>> = Vec::new();
    for s in stretches {
        let last = s.time.len().saturating_sub(1);
        let columns: Vec<&[f64]> = s.columns.iter().map(|c| &c[..last]).collect();
        let next = model.predict(&columns)?;
        for k in (0..last).step_by(stride) {
            let error: Vec<f64> = (0..states)
                .map(|i| s.columns[i][k + 1] - next[i][k])
                .collect();
            let point: Vec<f64> = columns.iter().map(|c| c[k]).collect();
            if error.iter().chain(&point).all(|v| v.is_finite()) {
                points.push(point);
                errors.push(error);
            }
        }
    }
    let sizes = deviations(&errors);
    if sizes.iter().zip(floor).all(|(size, floor)| size <= floor) {
        return Ok(None);
    }
    Ok(independence_of(points, errors))
}

/// How likely errors that do not depend on the points would be as alike among neighbours as these, in the order of time; `None` where
/// there are too few.
pub(super) fn independence_of(mut points: Vec<Vec<f64>>, mut errors: Vec<Vec<f64>>) -> Option<f64> {
    if errors.len() < FEWEST {
        return None;
    }
    let sizes = deviations(&errors);
    scale(&mut errors, &sizes);
    let sizes = deviations(&points);
    scale(&mut points, &sizes);
    let nearest = nearest(&points);
    let n = errors.len();
    let sum = |shift: usize| -> f64 {
        let at = |k: usize| &errors[(k + shift) % n];
        let pairs = nearest.iter().enumerate();
        pairs.map(|(k, near)| distance(at(k), at(*near))).sum()
    };
    let own = sum(0);
    // Multiples of the root of two are spread evenly. Neighbours were neighbours some samples ago, and still are some samples
    // later: shifts of less than a tenth of the record are left out.
    let spread = |s: usize| 0.1 + 0.8 * (s as f64 * 2.0_f64.sqrt()).fract();
    let shifts = (1..=SHIFTS).map(|s| (spread(s) * n as f64) as usize);
    let as_small = shifts.filter(|&s| sum(s) <= own).count() + 1;
    Some(as_small as f64 / (SHIFTS + 1) as f64)
}

/// Root mean square of each column about its mean.
pub(super) fn deviations(rows: &[Vec<f64>]) -> Vec<f64> {
    let n = rows.len().max(1) as f64;
    let width = rows.first().map_or(0, Vec::len);
    (0..width)
        .map(|j| {
            let mean = rows.iter().map(|r| r[j]).sum::<f64>() / n;
            (rows.iter().map(|r| (r[j] - mean).powi(2)).sum::<f64>() / n).sqrt()
        })
        .collect()
}

/// Divides columns by their sizes; those without size do not count.
fn scale(rows: &mut [Vec<f64>], sizes: &[f64]) {
    for row in rows {
        for (v, size) in row.iter_mut().zip(sizes) {
            *v = if *size > 0.0 { *v / size } else { 0.0 };
        }
    }
}

pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}

/// The nearest other row of each.
fn nearest(points: &[Vec<f64>]) -> Vec<usize> {
    (0..points.len())
        .map(|k| {
            let others = (0..points.len()).filter(|j| *j != k);
            let to = |j: usize| distance(&points[k], &points[j]);
            others.min_by(|a, b| to(*a).total_cmp(&to(*b))).unwrap_or(k)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::model::{Term, Time};

    /// p of a Hénon map that is driven by noise, by a model with this coefficient of x².
    fn p(square: f64, seed: u64) -> f64 {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let (mut x, mut y) = (0.1, 0.1);
        let mut columns = [Vec::new(), Vec::new()];
        for _ in 0..300 {
            columns[0].push(x);
            columns[1].push(y);
            let z: f64 = StandardNormal.sample(&mut rng);
            (x, y) = (1.0 - 1.4 * x * x + y + 0.003 * z, 0.3 * x);
        }
        let time: Vec<f64> = (0..300).map(f64::from).collect();
        let term = |t: &str, c| Term::parse(t, c).unwrap();
        let equations = vec![
            vec![term("1", 1.0), term("x^2", square), term("y", 1.0)],
            vec![term("x", 0.3)],
        ];
        let model = Model::new(Time::Discrete { period: 1.0 }, &["x", "y"], &[], equations);
        let stretch = Stretch {
            trajectory: 0,
            time: &time,
            columns: columns.iter().map(Vec::as_slice).collect(),
            weights: None,
            seen: Vec::new(),
        };
        let p = independence(&model.unwrap(), &[stretch], &[1e-6; 2]);
        p.unwrap().unwrap()
    }

    #[test]
    fn analytic_noise_does_not_follow_the_state_and_a_wrong_map_does() {
        // 40 uniform numbers: 4 or fewer of them at or below 0.05 in 95 % of draws, 7 or more in 0.3 %.
        let refused = (0..40).filter(|seed| p(-1.4, *seed) <= 0.05).count();
        assert!(refused < 7, "{refused}");
        // Off by 1 %, about twice the noise.
        let found = (0..10).filter(|seed| p(-1.386, *seed) <= 0.01).count();
        assert!(found >= 9, "{found}");
    }
}
