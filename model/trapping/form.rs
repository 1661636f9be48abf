//! Terms of degree 2 at most in the states, taken apart.

use nalgebra::DMatrix;
use sindy_expr::Expr;

/// The linear and the quadratic part of a term: `θ(x, u) = c(u) + l·x + xᵀ H x / 2`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct QuadraticTerm {
    /// Derivatives at the origin.
    pub linear: Vec<f64>,
    /// Second derivatives.
    pub hessian: DMatrix<f64>,
    /// Whether it is zero where all states are.
    pub vanishes: bool,
}

impl QuadraticTerm {
    /// The parts of a term; `None` where it is of another kind.
    pub(crate) fn of(term: &Expr, states: &[String]) -> Option<Self> {
        let zero = Expr::constant(0.0);
        let at_origin = |of: &Expr| {
            let rest = states
                .iter()
                .fold(of.clone(), |of, s| of.substitute(s, &zero));
            rest.simplify()
        };
        let n = states.len();
        let mut linear = vec![0.0; n];
        let mut hessian = DMatrix::zeros(n, n);
        for (j, state) in states.iter().enumerate() {
            let slope = term.derivative(state).simplify();
            for (k, other) in states.iter().enumerate() {
                let second = slope.derivative(other).simplify().as_constant()?;
                hessian[(j, k)] = Some(second).filter(|v| v.is_finite())?;
            }
            let value = at_origin(&slope).as_constant()?;
            linear[j] = Some(value).filter(|v| v.is_finite())?;
        }
        Some(Self {
            linear,
            hessian,
            vanishes: at_origin(term).as_constant() == Some(0.0),
        })
    }

    pub(crate) fn is_quadratic(&self) -> bool {
        self.hessian.iter().any(|v| *v != 0.0)
    }

    pub(crate) fn is_linear(&self) -> bool {
        self.linear.iter().any(|v| *v != 0.0)
    }

    /// Adds the term times `factor` in the equation of state `i`: to `L`, and to the derivatives of the Jacobian by each state.
    pub(crate) fn add_to(
        &self,
        i: usize,
        factor: f64,
        linear: &mut DMatrix<f64>,
        quadratic: &mut [DMatrix<f64>],
    ) {
        for j in 0..self.linear.len() {
            linear[(i, j)] += factor * self.linear[j];
            for (k, by) in quadratic.iter_mut().enumerate() {
                by[(i, j)] += factor * self.hessian[(j, k)];
            }
        }
    }
}

/// The largest coefficient of `Σ_i x_i Q_i(x)`, as a share of the largest that the parts have; `quadratic[k]` is the derivative of the
/// Jacobian by the state k.
pub(crate) fn change_of_energy(quadratic: &[DMatrix<f64>]) -> f64 {
    let n = quadratic.len();
    let (mut most, mut size) = (0.0_f64, 0.0_f64);
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let parts = [
                    quadratic[k][(i, j)],
                    quadratic[i][(j, k)],
                    quadratic[j][(k, i)],
                ];
                most = most.max(parts.iter().sum::<f64>().abs());
                size = size.max(parts.iter().map(|p| p.abs()).sum());
            }
        }
    }
    most / size.max(f64::MIN_POSITIVE)
}
