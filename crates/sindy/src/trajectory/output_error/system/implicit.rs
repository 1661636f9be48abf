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
    /// Whether an implicit integrator follows it.
    pub(crate) fn is_stiff(&self) -> bool {
        self.stiff
    }

    /// The same, followed by an implicit integrator, for rates that steps of the data are too long for.
    pub(crate) fn stiff(self, stiff: bool) -> Self {
        Self { stiff, ..self }
    }

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
            active,
            slopes,
            row,
            theta: [t0, ..],
            gradient,
            scratch,
            jacobian: [j0, ..],
            stages: [.., slope],
            ..
        } = work;
        self.rhs((x, &inputs[0]), active, row, t0, scratch, slope);
        self.jacobian(row, slopes, gradient, scratch, j0);
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
            active,
            slopes,
            row,
            theta,
            gradient,
            scratch,
            jacobian,
            stages,
            point,
            ..
        } = work;
        for i in 0..3 {
            for (e, point) in point.iter_mut().enumerate() {
                *point = x[e] + z[i * self.n + e];
            }
            let (values, slope) = (&mut theta[i], &mut stages[i]);
            self.rhs((point, &inputs[i + 1]), active, row, values, scratch, slope);
            self.jacobian(row, slopes, gradient, scratch, &mut jacobian[i]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::Library;
    use crate::model::Time;

    fn system(names: &[&str], inputs: &[&str], terms: &[&str]) -> System {
        let strings =
            |names: &[&str]| -> Vec<String> { names.iter().map(ToString::to_string).collect() };
        let libraries = vec![Library::parse(terms).unwrap(); names.len()];
        System::new(
            Time::Continuous,
            &strings(names),
            &strings(inputs),
            &libraries,
        )
        .unwrap()
    }

    fn step(system: &System, c: &[f64], x: &[f64], over: (f64, &[Vec<f64>; 4])) -> (Step, f64) {
        let (mut work, mut out) = (system.work(c), system.blank());
        let stages = system.stages(x, over, &mut work).unwrap();
        system
            .end(x, over, &stages, true, &mut work, &mut out)
            .unwrap();
        (out, stages.error.amax())
    }

    const NO_INPUTS: [Vec<f64>; 4] = [const { Vec::new() }; 4];

    #[test]
    fn paper_a_linear_step_is_the_pade_approximation_of_the_exponential() {
        // Hairer and Wanner, IV.5: R(z) = (1 + 2z/5 + z²/20) / (1 - 3z/5 + 3z²/20 - z³/60).
        let system = system(&["x"], &[], &["x"]);
        for z in [0.3, -0.1, -1.0, -30.0, -1e6] {
            let truth =
                (1.0 + 0.4 * z + 0.05 * z * z) / (1.0 - 0.6 * z + 0.15 * z * z - z * z * z / 60.0);
            let (out, _) = step(&system, &[z / 0.7], &[2.0], (0.7, &NO_INPUTS));
            // Rounding, in units of the start.
            assert!(
                (out.state[0] - 2.0 * truth).abs() < 1e-13,
                "{z}: {:?}",
                out.state
            );
            assert!((out.transition[(0, 0)] - truth).abs() < 1e-13, "{z}");
        }
    }

    #[test]
    fn analytic_errors_fall_with_the_sixth_power_of_the_step_and_their_estimate_with_the_fourth() {
        let system = system(&["x"], &[], &["x"]);
        let errors = [0.4, 0.2].map(|h: f64| {
            let (out, estimate) = step(&system, &[-1.0], &[1.0], (h, &NO_INPUTS));
            ((out.state[0] - (-h).exp()).abs(), estimate)
        });
        let orders = (
            (errors[0].0 / errors[1].0).log2(),
            (errors[0].1 / errors[1].1).log2(),
        );
        // The next power of the step adds a share h of some units.
        assert!(
            (orders.0 - 6.0).abs() < 0.8 && (orders.1 - 4.0).abs() < 0.8,
            "{orders:?}"
        );
        assert!(
            errors.iter().all(|(error, estimate)| error < estimate),
            "{errors:?}"
        );
    }

    #[test]
    fn analytic_derivatives_of_a_step_against_differences() {
        let system = system(&["x", "y"], &["u"], &["x", "y", "x*y", "sin(x)", "u"]);
        let c: Vec<f64> = (0..10).map(|k| 3.0 * (f64::from(k) * 1.7).sin()).collect();
        let inputs = [0.2, 0.24, 0.31, 0.4].map(|u| vec![u]);
        let run = |x: &[f64], c: &[f64]| step(&system, c, x, (0.4, &inputs)).0;
        let x = [0.7, -0.4];
        let at = run(&x, &c);
        let e = 1e-5;
        let central = |up: Step, down: Step, i: usize| (up.state[i] - down.state[i]) / (2.0 * e);
        for j in 0..2 {
            let moved = |by: f64| {
                let mut x = x;
                x[j] += by;
                run(&x, &c)
            };
            for i in 0..2 {
                let difference = central(moved(e), moved(-e), i);
                // Central differences with 1e-5 are good to some 1e-10, and Newton's method to the square of 1e-8.
                assert!((at.transition[(i, j)] - difference).abs() < 1e-8, "{i} {j}");
            }
        }
        for k in 0..10 {
            let moved = |by: f64| {
                let mut c = c.clone();
                c[k] += by;
                run(&x, &c)
            };
            for i in 0..2 {
                let difference = central(moved(e), moved(-e), i);
                assert!((at.forcing[(i, k)] - difference).abs() < 1e-8, "{i} {k}");
            }
        }
    }
}
