//! Steps for stiff systems: Radau IIA of order 5, implicit and L-stable, with the derivatives of the step itself.
//!
//! With the stages `x + Z_i` at the times `c_i h`, where `c` are the Radau points of (0, 1],
//!
//! ```text
//! Z_i = h Σ_j a_ij f(x + Z_j),    the step ends at x + Z_3,
//! (δ_ij I - h a_ij J_j) dZ_j = h a_ij (J_j dx + θ_j dξ),    hence    dZ_3 = Σ_j W_j (J_j dx + θ_j dξ)
//! ```
//!
//! where `W_j` are n x n, so that the derivatives by any number of candidates cost hardly more than the step. Newton's method
//! solves the stages, with the Jacobian of each. The error is that of an embedded formula of order 3, damped by `(I - h γ J)⁻¹`
//! so that it stays small where the step is long for fast modes.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition (1996), sections IV.5 and IV.8.

use nalgebra::{DMatrix, DVector};

use super::{Step, System, Work};

/// Newton's iterations, at most. It doubles digits, so that it needs six from any start where it converges.
const ITERATIONS: usize = 10;
/// A change of a stage, relative to the state, that ends them: the next would be its square.
const CONVERGED: f64 = 1e-8;

const ROOT6: f64 = 2.449_489_742_783_178;
/// The times of the stages.
pub(in crate::trajectory::output_error) const NODES: [f64; 3] =
    [(4.0 - ROOT6) / 10.0, (4.0 + ROOT6) / 10.0, 1.0];
/// Weights of the slopes at the stages.
const A: [[f64; 3]; 3] = [
    [
        (88.0 - 7.0 * ROOT6) / 360.0,
        (296.0 - 169.0 * ROOT6) / 1800.0,
        (-2.0 + 3.0 * ROOT6) / 225.0,
    ],
    [
        (296.0 + 169.0 * ROOT6) / 1800.0,
        (88.0 + 7.0 * ROOT6) / 360.0,
        (-2.0 - 3.0 * ROOT6) / 225.0,
    ],
    [(16.0 - ROOT6) / 36.0, (16.0 + ROOT6) / 36.0, 1.0 / 9.0],
];
/// Weight of the slope at the start in the embedded formula: the inverse of the real eigenvalue of `A⁻¹`, so that its matrix is one
/// of the step's own scale.
const GAMMA: f64 = 0.274_888_829_595_676_7;
/// Weights of the stages in the error, in units of [`GAMMA`]: those with which it vanishes for polynomials of degree 3.
const ERROR: [f64; 3] = [
    (-13.0 - 7.0 * ROOT6) / 3.0,
    (-13.0 + 7.0 * ROOT6) / 3.0,
    -1.0 / 3.0,
];

/// A step whose stages were solved.
pub(in crate::trajectory::output_error) struct Stages {
    /// `Z`, 3 n.
    z: DVector<f64>,
    /// The estimated error of each state, of order 4 in the step.
    pub error: DVector<f64>,
}

impl System {
    /// Solves the stages of a step from `x` over `h`, with the inputs at its start and at [`NODES`]; `None` where Newton's method does
    /// not converge.
    pub(in crate::trajectory::output_error) fn stages(
        &self,
        x: &[f64],
        (h, inputs): (f64, &[Vec<f64>; 4]),
        work: &mut Work,
    ) -> Option<Stages> {
        let n = self.n;
        let mut z = DVector::zeros(3 * n);
        let mut converged = false;
        for _ in 0..ITERATIONS {
            self.at_stages(x, &z, inputs, work);
            let residual = DVector::from_fn(3 * n, |r, _| {
                let (i, e) = (r / n, r % n);
                let sum: f64 = (0..3).map(|j| A[i][j] * work.stages[j][e]).sum();
                h * sum - z[r]
            });
            let change = self.matrix(h, work).lu().solve(&residual)?;
            z += &change;
            if !z.iter().all(|v| v.is_finite()) {
                return None;
            }
            let size = |r: usize| {
                let e = r % n;
                let stages = (0..3).map(|i| z[i * n + e].abs());
                stages.fold(x[e].abs(), f64::max)
            };
            if (0..3 * n).all(|r| change[r].abs() <= CONVERGED * size(r)) {
                converged = true;
                break;
            }
        }
        if !converged {
            return None;
        }
        let Work {
            coefficients,
            active,
            row,
            theta: [t0, ..],
            gradient,
            scratch,
            jacobian: [j0, ..],
            stages: [.., slope],
            ..
        } = work;
        self.rhs((x, &inputs[0]), active, row, t0, scratch, slope);
        self.jacobian(row, coefficients, gradient, scratch, j0);
        let raw = DVector::from_fn(n, |e, _| {
            let stages: f64 = (0..3).map(|i| ERROR[i] * z[i * n + e]).sum();
            GAMMA * (h * slope[e] + stages)
        });
        let error = (DMatrix::identity(n, n) - &*j0 * (h * GAMMA))
            .lu()
            .solve(&raw)?;
        let is_finite = error.iter().all(|e| e.is_finite());
        is_finite.then_some(Stages { z, error })
    }

    /// Where a step ends; where `sensitive`, its derivatives as well.
    pub(in crate::trajectory::output_error) fn end(
        &self,
        x: &[f64],
        (h, inputs): (f64, &[Vec<f64>; 4]),
        stages: &Stages,
        sensitive: bool,
        work: &mut Work,
        out: &mut Step,
    ) -> Option<()> {
        let n = self.n;
        for (e, state) in out.state.iter_mut().enumerate() {
            *state = x[e] + stages.z[2 * n + e];
        }
        if !sensitive {
            return Some(());
        }
        self.at_stages(x, &stages.z, inputs, work);
        let last = DMatrix::from_fn(3 * n, n, |r, c| f64::from(r == 2 * n + c));
        let inverse = self.matrix(h, work).transpose().lu().solve(&last)?;
        out.transition.fill_with_identity();
        out.forcing.fill(0.0);
        for j in 0..3 {
            // `inverse` holds the last stage's rows of the matrix' inverse as columns.
            let by = DMatrix::from_fn(n, n, |r, c| {
                let sum: f64 = (0..3).map(|i| inverse[(i * n + c, r)] * A[i][j]).sum();
                h * sum
            });
            out.transition += &by * &work.jacobian[j];
            for p in &self.parts {
                let weight = p.factor * work.theta[j][p.term];
                for e in 0..n {
                    out.forcing[(e, p.candidate)] += weight * by[(e, p.equation)];
                }
            }
        }
        Some(())
    }

    /// Slopes, terms and Jacobians at the stages.
    fn at_stages(&self, x: &[f64], z: &DVector<f64>, inputs: &[Vec<f64>; 4], work: &mut Work) {
        let Work {
            coefficients,
            active,
            row,
            theta,
            gradient,
            scratch,
            jacobian,
            stages,
            point,
        } = work;
        for i in 0..3 {
            for (e, point) in point.iter_mut().enumerate() {
                *point = x[e] + z[i * self.n + e];
            }
            let (values, slope) = (&mut theta[i], &mut stages[i]);
            self.rhs((point, &inputs[i + 1]), active, row, values, scratch, slope);
            self.jacobian(row, coefficients, gradient, scratch, &mut jacobian[i]);
        }
    }

    /// `δ_ij I - h a_ij J_j`, 3 n x 3 n.
    fn matrix(&self, h: f64, work: &Work) -> DMatrix<f64> {
        let n = self.n;
        DMatrix::from_fn(3 * n, 3 * n, |r, c| {
            let slope = A[r / n][c / n] * work.jacobian[c / n][(r % n, c % n)];
            f64::from(r == c) - h * slope
        })
    }
}
