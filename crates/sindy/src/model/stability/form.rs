//! Equations as polynomials of degree 2 in the states: `x_i' = c_i(u) + Σ_j L_ij x_j + Σ_jk Q_ijk x_j x_k`.

use nalgebra::{DMatrix, DVector, Schur, SymmetricEigen};
use sindy_expr::Expr;

/// Steps of the Schur decomposition, at most: far more than its convergence takes.
const STEPS: usize = 10_000;
/// A quadratic part keeps the energy if it changes it by less than this share of its largest coefficient: a thousand times what
/// fields of the fit leave (1e-12).
const KEPT: f64 = 1e-9;

/// A term as a polynomial in the states.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TermForm {
    pub linear: DVector<f64>,
    /// Symmetric: the quadratic part is `xᵀ H x`.
    pub quadratic: DMatrix<f64>,
}

impl TermForm {
    /// `None` for a term of a degree above 2, or of states and inputs together.
    pub(crate) fn of(term: &Expr, states: &[String]) -> Option<Self> {
        let n = states.len();
        let mut linear = DVector::zeros(n);
        let mut quadratic = DMatrix::zeros(n, n);
        let variables = term.variables();
        let is_state = |v: &&str| states.iter().any(|s| s == v);
        if !variables.iter().any(is_state) {
            return Some(Self { linear, quadratic });
        }
        if !variables.iter().all(is_state) {
            return None;
        }
        for (j, name) in states.iter().enumerate() {
            let slope = term.derivative(name);
            let zero = Expr::constant(0.0);
            let at_zero = states
                .iter()
                .fold(slope.clone(), |e, s| e.substitute(s, &zero));
            linear[j] = at_zero.simplify().as_constant().filter(|v| v.is_finite())?;
            for (k, other) in states.iter().enumerate() {
                let curvature = slope.derivative(other).simplify();
                quadratic[(j, k)] = 0.5 * curvature.as_constant().filter(|v| v.is_finite())?;
            }
        }
        Some(Self { linear, quadratic })
    }

    pub(crate) fn is_quadratic(&self) -> bool {
        self.quadratic.iter().any(|v| *v != 0.0)
    }
}

/// The parts of all equations that depend on the states.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct QuadraticForm {
    pub linear: DMatrix<f64>,
    /// One symmetric matrix for each equation.
    pub quadratic: Vec<DMatrix<f64>>,
}

impl QuadraticForm {
    pub(crate) fn zeros(n: usize) -> Self {
        Self {
            linear: DMatrix::zeros(n, n),
            quadratic: vec![DMatrix::zeros(n, n); n],
        }
    }

    pub(crate) fn add(&mut self, equation: usize, term: &TermForm, coefficient: f64) {
        let mut row = self.linear.row_mut(equation);
        row += coefficient * term.linear.transpose();
        self.quadratic[equation] += coefficient * &term.quadratic;
    }

    pub(crate) fn is_quadratic(&self) -> bool {
        self.quadratic.iter().any(|q| q.amax() > 0.0)
    }

    /// The change of the energy `|x|²/2` by the quadratic part, its largest coefficient as a share of the largest of the part.
    pub(crate) fn energy_change(&self) -> f64 {
        let n = self.linear.nrows();
        let q = &self.quadratic;
        let size = q.iter().map(DMatrix::amax).fold(0.0, f64::max);
        let mut largest: f64 = 0.0;
        for i in 0..n {
            for j in 0..=i {
                for k in 0..=j {
                    let sum: f64 = q[i][(j, k)] + q[j][(i, k)] + q[k][(i, j)];
                    largest = largest.max(sum.abs());
                }
            }
        }
        largest / size.max(f64::MIN_POSITIVE)
    }

    pub(crate) fn keeps_energy(&self) -> bool {
        self.energy_change() <= KEPT
    }

    /// The Jacobian at `m`.
    pub(crate) fn jacobian(&self, m: &DVector<f64>) -> DMatrix<f64> {
        let mut out = self.linear.clone();
        for (i, q) in self.quadratic.iter().enumerate() {
            let mut row = out.row_mut(i);
            row += 2.0 * (q * m).transpose();
        }
        out
    }

    /// The symmetric part of the Jacobian at `m`: what changes the energy about `m`, if the quadratic part keeps it.
    pub(crate) fn symmetric(&self, m: &DVector<f64>) -> DMatrix<f64> {
        let jacobian = self.jacobian(m);
        (&jacobian + jacobian.transpose()) * 0.5
    }

    /// The derivative of `tr(P A_S(m))` by m, for a symmetric P.
    pub(crate) fn slope(&self, p: &DMatrix<f64>) -> DVector<f64> {
        let n = self.linear.nrows();
        let mut out = DVector::zeros(n);
        for (i, q) in self.quadratic.iter().enumerate() {
            out += 2.0 * q * p.column(i);
        }
        out
    }

    /// The largest real part of the eigenvalues of the linear part.
    pub(crate) fn growth(&self) -> f64 {
        largest_real_part(&self.linear)
    }
}

/// The largest real part of the eigenvalues; infinite where they cannot be computed.
pub(crate) fn largest_real_part(a: &DMatrix<f64>) -> f64 {
    match Schur::try_new(a.clone(), f64::EPSILON, STEPS) {
        Some(schur) => {
            let all = schur.complex_eigenvalues();
            all.iter().map(|v| v.re).fold(f64::NEG_INFINITY, f64::max)
        }
        None => f64::INFINITY,
    }
}

/// The largest eigenvalue of a symmetric matrix.
pub(crate) fn largest_eigenvalue(a: &DMatrix<f64>) -> f64 {
    SymmetricEigen::new(a.clone()).eigenvalues.max()
}
