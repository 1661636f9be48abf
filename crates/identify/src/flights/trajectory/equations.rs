//! The equations of a Gauss–Newton step on the cost of trajectories, from differences, and the last steps of a fit.

use nalgebra::{DMatrix, DVector};

use super::kalman::Pass;
use super::{Point, Problem};
use crate::flights::differences::{LastSteps, ends};
use crate::flights::normal::{ReducedEquations, hold};

/// Length of the stretches that count as independent of one another (s).
/// Several correlation times of turbulence, and yet ten in half a minute. Half or twice moves intervals by a tenth.
const STRETCH_S: f64 = 2.0;

/// Width of a difference over a standard error.
const OF_ERROR: f64 = 0.1;

/// Equations of all runs at a point, and the numbers that are held at a bound.
pub(super) struct Equations {
    pub(super) reduced: Vec<ReducedEquations>,
    matrix: DMatrix<f64>,
    vector: DVector<f64>,
    pub(super) held: Vec<usize>,
    pub(super) slopes: Vec<DVector<f64>>,
}

impl Problem<'_> {
    /// The Gauss–Newton step in which no number at a bound is asked to leave it: a step that is cut off at bounds need not
    /// lower the cost.
    pub(super) fn within_bounds(
        &self,
        equations: &Equations,
        theta: &[f64],
    ) -> Option<DVector<f64>> {
        let mut held = equations.held.clone();
        loop {
            let (mut matrix, mut vector) = (equations.matrix.clone(), equations.vector.clone());
            hold(&mut matrix, &mut vector, &held);
            let step = matrix.cholesky()?.solve(&vector);
            let leaves = |&k: &usize| {
                let p = &self.parameters[k];
                (theta[k] <= p.min && step[k] < 0.0) || (theta[k] >= p.max && step[k] > 0.0)
            };
            let more: Vec<usize> = (0..theta.len()).filter(leaves).collect();
            if more.is_empty() {
                return Some(step);
            }
            held.extend(more);
        }
    }

    /// The last steps of a fit, from a point near its end; the equations there.
    ///
    /// The information is not the curvature of the cost, whose variances move with the model: steps by it alone become shorter
    /// by a third only. What slopes say of the curvature from one step to the next is added to it (BFGS).
    pub(super) fn settle(&self, point: &mut Point) -> Equations {
        let mut last = LastSteps::new();
        let wide = self.widths(&self.equations(point, None));
        let mut equations = self.equations(point, Some(&wide));
        loop {
            let Some(step) = self.within_bounds(&equations, &point.theta) else {
                return equations;
            };
            if !last.include(step.dot(&(&equations.matrix * &step))) {
                return equations;
            }
            let theta = self.moved(&point.theta, &step);
            let gone = theta.iter().zip(&point.theta).map(|(to, from)| to - from);
            let gone = DVector::from_iterator(theta.len(), gone);
            point.theta = theta;
            point.cost = self.cost(&point.theta, point.noise);
            let next = self.equations(point, Some(&wide));
            let lower = &equations.vector - &next.vector;
            equations = Equations {
                matrix: with_curvature(&equations.matrix, &gone, &lower),
                ..next
            };
        }
    }

    /// Widths of differences for the last steps: shares of standard errors.
    fn widths(&self, equations: &Equations) -> DVector<f64> {
        let inverse = equations.matrix.clone().cholesky().map(|c| c.inverse());
        let variances = inverse.map_or_else(
            || equations.matrix.diagonal().map(f64::recip),
            |m| m.diagonal(),
        );
        variances.map(|v| OF_ERROR * v.sqrt())
    }

    /// Numbers after a step, within their bounds.
    pub(super) fn moved(&self, theta: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let all = theta.iter().zip(step.iter()).zip(&self.parameters);
        all.map(|((t, s), p)| (t + s).clamp(p.min, p.max)).collect()
    }

    /// Fisher's information and half the slope of the cost downwards.
    pub(super) fn equations(&self, point: &Point, wide: Option<&DVector<f64>>) -> Equations {
        let n = point.theta.len();
        let base = self.passes(&point.theta, point.noise);
        let moved: Vec<Moved> = (0..n)
            .map(|k| self.moved_by(point, k, wide.map_or(0.0, |w| w[k])))
            .collect();
        let ends = |run: usize| -> Vec<Ends<'_>> {
            moved.iter().map(|m| m.ends(run, &base[run])).collect()
        };
        let runs = 0..base.len();
        let reduced: Vec<ReducedEquations> = runs.clone().map(|run| of_run(&ends(run))).collect();
        let slopes = runs.flat_map(|run| slopes_of_stretches(&base[run], &ends(run)));
        let slopes = slopes.collect();
        let mut matrix = DMatrix::zeros(n, n);
        let mut vector = DVector::zeros(n);
        for run in &reduced {
            matrix += &run.matrix;
            vector += &run.vector;
        }
        for (k, (p, v)) in self.parameters.iter().zip(&point.theta).enumerate() {
            let precision = p.prior_sd.powi(-2);
            matrix[(k, k)] += precision;
            vector[k] -= precision * (v - p.start);
        }
        let held = (0..n).filter(|&k| {
            let (p, v) = (&self.parameters[k], point.theta[k]);
            (v <= p.min && vector[k] < 0.0) || (v >= p.max && vector[k] > 0.0)
        });
        Equations {
            held: held.collect(),
            reduced,
            matrix,
            vector,
            slopes,
        }
    }

    /// All runs at the two ends of a difference by one number.
    fn moved_by(&self, point: &Point, k: usize, wide: f64) -> Moved {
        let [low, high] = ends(&self.parameters[k], point.theta[k], wide);
        let at = |by: f64| {
            let mut theta = point.theta.clone();
            theta[k] += by;
            self.passes(&theta, point.noise)
        };
        Moved {
            low: (low != 0.0).then(|| at(low)),
            high: at(high),
            width: high - low,
        }
    }
}

/// A curvature after a step and by how much it lowered the slope; the same where that is no curvature.
fn with_curvature(
    matrix: &DMatrix<f64>,
    step: &DVector<f64>,
    lower: &DVector<f64>,
) -> DMatrix<f64> {
    let before = matrix * step;
    let (of_step, expected) = (step.dot(lower), step.dot(&before));
    if !(of_step > 0.0 && expected > 0.0) {
        return matrix.clone();
    }
    matrix + lower * lower.transpose() / of_step - &before * before.transpose() / expected
}

/// All runs at the two ends of a difference; the low end is the point itself where the difference is one-sided.
struct Moved {
    low: Option<Vec<Pass>>,
    high: Vec<Pass>,
    width: f64,
}

/// One run at the two ends of a difference.
struct Ends<'a> {
    low: &'a Pass,
    high: &'a Pass,
    width: f64,
}

impl Moved {
    fn ends<'a>(&'a self, run: usize, base: &'a Pass) -> Ends<'a> {
        Ends {
            low: self.low.as_ref().map_or(base, |low| &low[run]),
            high: &self.high[run],
            width: self.width,
        }
    }
}

/// Information and half the slope of the cost downwards of one run.
fn of_run(moved: &[Ends<'_>]) -> ReducedEquations {
    let n = moved.len();
    let mut matrix = DMatrix::zeros(n, n);
    let mut slope = DVector::zeros(n);
    let rows = moved.first().map_or(0, |m| m.low.innovations.len());
    for row in 0..rows {
        for (slope, m) in slope.iter_mut().zip(moved) {
            let [low, high] = [m.low, m.high].map(|p| p.innovations[row].value);
            *slope = (high - low) / m.width;
        }
        matrix.ger(1.0, &slope, &slope, 1.0);
    }
    // The slope of the whole cost: variances move with the model too.
    let of = moved
        .iter()
        .map(|m| -0.5 * (m.high.cost - m.low.cost) / m.width);
    let vector = DVector::from_iterator(n, of);
    ReducedEquations { matrix, vector }
}

/// Half the slope of the cost downwards in each stretch of a run.
fn slopes_of_stretches(base: &Pass, moved: &[Ends<'_>]) -> Vec<DVector<f64>> {
    let mut out: Vec<DVector<f64>> = Vec::new();
    let mut until_s = f64::NEG_INFINITY;
    for (row, at) in base.innovations.iter().enumerate() {
        if at.time_s >= until_s {
            until_s = at.time_s + STRETCH_S;
            out.push(DVector::zeros(moved.len()));
        }
        if let Some(sum) = out.last_mut() {
            for (k, m) in moved.iter().enumerate() {
                let [low, high] = [m.low, m.high].map(|p| p.innovations[row].cost);
                sum[k] -= 0.5 * (high - low) / m.width;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution as _, StandardNormal};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::SeedableRng as _;

    use super::*;
    use crate::flights::fit::fit;
    use crate::flights::made::up_and_down;
    use crate::flights::model::{Curve, ModelTerms, Segment};
    use crate::flights::trajectory::{Noise, Settings};

    const UNITS: Settings = Settings {
        radius_m: 0.1,
        gravity_mps2: 9.81,
    };

    /// A flight whose thrust rises near the ground and whose sensors have white noise; ranges are multiplied by `scale`.
    fn piece(flight: usize, scale: f64) -> Segment {
        let mut random = Pcg64::seed_from_u64(flight as u64);
        let mut noise = |sd: f64| {
            let white: f64 = StandardNormal.sample(&mut random);
            sd * white
        };
        let pace = 3.0 + 0.7 * flight as f64;
        let of_motion = |t: f64| 1.0 + 0.07 * pace * pace * (pace * t).cos() / UNITS.gravity_mps2;
        let mut piece = up_and_down(flight, |_, t| of_motion(t));
        piece.tilt_rad = vec![0.0; piece.time_s.len()];
        for (row, t) in piece.time_s.iter().enumerate() {
            let (h, force) = (piece.height[row], piece.force[row]);
            piece.throttle[row] = force / (1.0 + 0.2 * (-h).exp());
            piece.force[row] = force + noise(0.01);
            piece.range_m[row] = scale * (UNITS.radius_m * h + noise(0.002));
            let climb = 0.07 * pace * (pace * t).sin();
            piece.climb_measured_mps.push(climb + noise(0.02));
        }
        piece
    }

    #[test]
    fn prop_the_last_bit_of_ranges_moves_no_number_of_the_likeliest_trajectories() {
        // These motors have no lag, which nothing tells from commands that act before they are logged.
        let shape = ModelTerms {
            logged_late: false,
            ..ModelTerms::plain(Curve::Exponential, false, true)
        };
        let theta = |scale: f64| {
            let pieces: Vec<Segment> = (0..4).map(|flight| piece(flight, scale)).collect();
            let start = fit(&pieces, shape, None);
            let problem = Problem::of(&pieces, &start, UNITS);
            let found = problem.track(&start, Noise::first(&start), true).unwrap();
            assert!(found.fit.converged);
            found.fit.theta
        };
        let pairs = theta(1.0).into_iter().zip(theta(1.0_f64.next_up()));
        let moved = pairs.map(|(a, b)| (a - b).abs() / a.abs().max(1e-3));
        let moved = moved.fold(0.0, f64::max);
        // Measured: 8e-11, and 7e-8 before the last steps. What rounding moves in the filter is divided by the width of differences.
        assert!(moved < 5e-10, "{moved:e}");
    }

    #[test]
    fn analytic_a_number_at_its_bound_is_held_where_the_others_would_push_it_out() {
        let shape = ModelTerms::plain(Curve::Free, false, true);
        let parameters = shape.parameters();
        let n = parameters.len();
        let lag = parameters.iter().position(|p| p.name == "T_m").unwrap();
        let mut theta: Vec<f64> = parameters.iter().map(|p| p.start).collect();
        theta[lag] = parameters[lag].min;
        let problem = Problem {
            pieces: &[],
            shape,
            parameters,
            settings: UNITS,
        };
        let mut matrix = DMatrix::identity(n, n);
        (matrix[(0, lag)], matrix[(lag, 0)]) = (0.9, 0.9);
        let mut vector = DVector::zeros(n);
        // The slope asks the lag to rise, the step with the elasticity to fall: 0.1 - 0.9 before it is divided.
        (vector[0], vector[lag]) = (1.0, 0.1);
        let equations = Equations {
            reduced: Vec::new(),
            matrix,
            vector,
            held: Vec::new(),
            slopes: Vec::new(),
        };
        let step = problem.within_bounds(&equations, &theta).unwrap();
        // Alone, the elasticity goes by 1/1: rounding only.
        assert!(step[lag] == 0.0 && (step[0] - 1.0).abs() < 1e-15, "{step}");
    }
}
