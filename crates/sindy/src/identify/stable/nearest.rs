//! The nearest coefficients of a stable model.
//!
//! With the fit â and its information H (the inverse covariance),
//!
//! ```text
//! min over a, m   (a - â)ᵀ H (a - â)     so that   A_S(m) < -margin    (quadratic equations: all eigenvalues)
//!                                                  Re λ(A) < -margin   (linear equations)
//! ```
//!
//! The objective is twice the log-likelihood that is lost, in its quadratic approximation. A barrier φ keeps steps inside the condition:
//! `-ln det(-margin - A_S(m))`, or `ln tr X` with `(A + margin) X + X (A + margin)ᵀ = -1`, which grows without bound where an eigenvalue
//! reaches the margin. It is weighted less and less. The problem is not convex, so the minimum is a local one.
//!
//! Source of the second barrier: J. Vanbiervliet et al., "The smoothed spectral abscissa for robust stability optimization", SIAM J.
//! Optim. 20 (2009).

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::model::stability::centre::centre;
use crate::model::stability::form::QuadraticForm;
use crate::numerics::bfgs;

/// The margin, as a share of the size of the Jacobian at the mean of the data, or of the slowest rate that these show: decay within 10⁴
/// times the time scale of the system.
const MARGIN: f64 = 1e-4;
/// Doublings of the shift that makes a first stable model: beyond 2^12 times the needed one the lacking terms decide.
const DOUBLINGS: usize = 12;
/// The barrier's last weight for each dimension, as a share of the loss (or of 1, which makes a loss of 1 exact to as much).
const LAST: f64 = 1e-5;
const FACTOR: f64 = 0.1;
/// Steps for each weight of the barrier, at most.
const STEPS: usize = 300;
/// Weights of the barrier, at most: losses up to 1e20 end there.
const WEIGHTS: usize = 30;
/// Added to the diagonal of the information, as a share: terms that depend on each other leave it singular.
const RIDGE: f64 = 1e-12;

/// The kept coefficients of a fit, and the equations of a unit of each.
pub(super) struct Fitted<'a> {
    pub coefficients: &'a DVector<f64>,
    pub information: &'a DMatrix<f64>,
    pub forms: &'a [QuadraticForm],
    /// Which coefficients are those of x in the equation of x.
    pub diagonal: &'a [usize],
    pub mean: &'a DVector<f64>,
    /// The size of the states.
    pub rms: f64,
    /// The slowest rate that the data show.
    pub slowest: f64,
}

/// Coefficients that satisfy the condition, and the twice log-likelihood that they lose.
pub(super) struct Nearest {
    pub coefficients: DVector<f64>,
    pub lost: f64,
}

impl Fitted<'_> {
    fn form(&self, a: &DVector<f64>) -> QuadraticForm {
        let mut out = QuadraticForm::zeros(self.mean.len());
        for (form, a) in self.forms.iter().zip(a.iter()) {
            out.linear += *a * &form.linear;
            for (sum, own) in out.quadratic.iter_mut().zip(&form.quadratic) {
                *sum += *a * own;
            }
        }
        out
    }

    /// Whether the equations are quadratic.
    fn is_quadratic(&self) -> bool {
        self.form(self.coefficients).is_quadratic()
    }

    /// The largest eigenvalue (its real part), and the centre.
    fn largest(&self, a: &DVector<f64>) -> (DVector<f64>, f64) {
        let form = self.form(a);
        match self.is_quadratic() {
            true => centre(&form, self.mean),
            false => (self.mean.clone(), form.growth()),
        }
    }

    fn margin(&self) -> f64 {
        let jacobian = self.form(self.coefficients).jacobian(self.mean);
        let size = jacobian.norm() / (self.mean.len() as f64).sqrt();
        MARGIN * size.max(self.slowest)
    }

    /// Whether the fit satisfies the condition as it is.
    pub(super) fn is_stable(&self) -> bool {
        self.largest(self.coefficients).1 <= -self.margin()
    }

    /// A first stable model: the diagonal coefficients moved down.
    fn start(&self) -> Option<(DVector<f64>, DVector<f64>)> {
        let margin = self.margin();
        let needed = self.largest(self.coefficients).1;
        let mut shift = (needed + 2.0 * margin).max(margin);
        for _ in 0..DOUBLINGS {
            let mut a = self.coefficients.clone();
            self.diagonal.iter().for_each(|&j| a[j] -= shift);
            let (m, value) = self.largest(&a);
            if value < -1.5 * margin {
                return Some((a, m));
            }
            shift *= 2.0;
        }
        None
    }

    /// The nearest stable coefficients, from the first that are found; `None` if these terms have none.
    pub(super) fn nearest(&self) -> Option<Nearest> {
        let (first, m) = self.start()?;
        let k = first.len();
        let mut information = self.information.clone();
        for j in 0..k {
            information[(j, j)] *= 1.0 + RIDGE;
        }
        let root = Cholesky::new(information)?.l();
        let margin = self.margin();
        let quadratic = self.is_quadratic();
        let free = if quadratic { m.len() } else { 0 };
        // Coefficients in units of their errors, and the centre in units of the states.
        let coefficients = |z: &DVector<f64>| {
            let scaled = z.rows(0, k).into_owned();
            root.tr_solve_lower_triangular(&scaled)
                .map(|moved| self.coefficients + moved)
        };
        let mut z = DVector::zeros(k + free);
        z.rows_mut(0, k)
            .copy_from(&root.tr_mul(&(&first - self.coefficients)));
        if quadratic {
            z.rows_mut(k, free).copy_from(&(&m / self.rms));
        }
        let mut weight = z.rows(0, k).norm_squared().max(1.0) / (k + free) as f64;
        for _ in 0..WEIGHTS {
            let objective = |z: &DVector<f64>| {
                let a = coefficients(z)?;
                let m = z.rows(k, free) * self.rms;
                let (value, by_a, by_m) = match quadratic {
                    true => self.trapping_barrier(&a, &m, margin)?,
                    false => self.linear_barrier(&a, margin)?,
                };
                let own = z.rows(0, k);
                let mut gradient = DVector::zeros(k + free);
                let by_z = root.solve_lower_triangular(&by_a)?;
                gradient
                    .rows_mut(0, k)
                    .copy_from(&(2.0 * own + weight * by_z));
                if quadratic {
                    gradient
                        .rows_mut(k, free)
                        .copy_from(&(weight * self.rms * by_m));
                }
                Some((own.norm_squared() + weight * value, gradient))
            };
            z = bfgs(objective, &z, STEPS);
            let lost = z.rows(0, k).norm_squared();
            if weight * (k + free) as f64 <= LAST * lost.max(1.0) {
                break;
            }
            weight *= FACTOR;
        }
        Some(Nearest {
            coefficients: coefficients(&z)?,
            lost: z.rows(0, k).norm_squared(),
        })
    }

    /// `-ln det(-margin - A_S(m))` and its gradients by a and m; `None` outside the condition.
    fn trapping_barrier(
        &self,
        a: &DVector<f64>,
        m: &DVector<f64>,
        margin: f64,
    ) -> Option<(f64, DVector<f64>, DVector<f64>)> {
        let form = self.form(a);
        let n = m.len();
        let slack = -form.symmetric(m) - DMatrix::identity(n, n) * margin;
        let factor = Cholesky::new(slack)?;
        let value = -2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
        let inverse = factor.inverse();
        let by_a = |own: &QuadraticForm| inverse.dot(&own.symmetric(m));
        let by_a = DVector::from_iterator(a.len(), self.forms.iter().map(by_a));
        value
            .is_finite()
            .then(|| (value, by_a, form.slope(&inverse)))
    }

    /// `ln tr X` and its gradient by a; `None` outside the condition.
    fn linear_barrier(
        &self,
        a: &DVector<f64>,
        margin: f64,
    ) -> Option<(f64, DVector<f64>, DVector<f64>)> {
        let n = self.mean.len();
        let shifted = self.form(a).linear + DMatrix::identity(n, n) * margin;
        let x = lyapunov(&shifted)?;
        // A solution that is positive definite exists for decaying eigenvalues alone.
        Cholesky::new(x.clone())?;
        let y = lyapunov(&shifted.transpose())?;
        let slope = (y * &x) * (2.0 / x.trace());
        let by_a = self.forms.iter().map(|own| slope.dot(&own.linear));
        let by_a = DVector::from_iterator(a.len(), by_a);
        Some((x.trace().ln(), by_a, DVector::zeros(0)))
    }
}

/// The symmetric X with `B X + X Bᵀ = -1`.
fn lyapunov(b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = b.nrows();
    let one = DMatrix::<f64>::identity(n, n);
    let sums = one.kronecker(b) + b.kronecker(&one);
    let right = DVector::from_column_slice((-one).as_slice());
    let x = DMatrix::from_column_slice(n, n, sums.lu().solve(&right)?.as_slice());
    Some((&x + x.transpose()) * 0.5)
}
