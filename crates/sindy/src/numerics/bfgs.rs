//! Minimisation of a smooth function by the method of Broyden, Fletcher, Goldfarb and Shanno.

use nalgebra::{DMatrix, DVector};

/// A step is accepted if it lowers the function by this share of what its slope promises (Armijo).
const ENOUGH: f64 = 1e-4;
/// Halvings of a step, at most: 2^-60 is below rounding.
const HALVINGS: usize = 60;
/// An update of the curvature below this share of its step is rounding.
const CURVED: f64 = 1e-12;

/// The lowest point found from `start`, in at most `iterations` steps. The function gives its value and gradient, or `None` outside
/// its domain, which no step leaves. A start outside it is returned as it is.
pub(crate) fn bfgs(
    mut function: impl FnMut(&DVector<f64>) -> Option<(f64, DVector<f64>)>,
    start: &DVector<f64>,
    iterations: usize,
) -> DVector<f64> {
    let n = start.len();
    let mut x = start.clone();
    let Some((mut value, mut gradient)) = function(&x) else {
        return x;
    };
    let mut inverse = DMatrix::identity(n, n);
    let mut is_first = true;
    for _ in 0..iterations {
        let mut step = -(&inverse * &gradient);
        let mut slope = step.dot(&gradient);
        if slope >= 0.0 {
            inverse = DMatrix::identity(n, n);
            step = -&gradient;
            slope = -gradient.norm_squared();
        }
        if slope == 0.0 || !slope.is_finite() {
            break;
        }
        let mut accepted = None;
        for _ in 0..HALVINGS {
            let point = &x + &step;
            if let Some((v, g)) = function(&point)
                && v <= value + ENOUGH * slope
            {
                accepted = Some((point, v, g));
                break;
            }
            step *= 0.5;
            slope *= 0.5;
        }
        let Some((point, v, g)) = accepted else { break };
        let change = &g - &gradient;
        let curvature = step.dot(&change);
        if curvature > CURVED * step.norm() * change.norm() {
            if is_first {
                inverse *= curvature / change.norm_squared();
                is_first = false;
            }
            let mapped = &inverse * &change;
            let factor = (1.0 + change.dot(&mapped) / curvature) / curvature;
            inverse += factor * &step * step.transpose()
                - (&mapped * step.transpose() + &step * mapped.transpose()) / curvature;
        }
        let is_done = v == value;
        (x, value, gradient) = (point, v, g);
        if is_done {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_rosenbrocks_valley_ends_at_one_and_one() {
        let rosenbrock = |p: &DVector<f64>| {
            let (x, y) = (p[0], p[1]);
            let bend = y - x * x;
            let gradient = [-400.0 * x * bend - 2.0 * (1.0 - x), 200.0 * bend];
            let value = 100.0 * bend * bend + (1.0 - x).powi(2);
            Some((value, DVector::from_column_slice(&gradient)))
        };
        let start = DVector::from_column_slice(&[-1.2, 1.0]);
        let end = bfgs(rosenbrock, &start, 200);
        // The valley's curvature is 0.4: values that differ by rounding differ by 1e-8 in x.
        assert!(
            (end[0] - 1.0).abs() < 1e-7 && (end[1] - 1.0).abs() < 1e-7,
            "{end}"
        );
    }

    #[test]
    fn analytic_no_step_leaves_the_domain() {
        // x - ln x within x > 0 has its minimum at 1; Newton's first steps from 3 would leave the domain.
        let barrier = |p: &DVector<f64>| {
            let x = p[0];
            (x > 0.0).then(|| (x - x.ln(), DVector::from_element(1, 1.0 - 1.0 / x)))
        };
        let end = bfgs(barrier, &DVector::from_element(1, 1e-3), 100);
        // The curvature is 1, and values round at 1e-16.
        assert!((end[0] - 1.0).abs() < 1e-7, "{end}");
        let outside = DVector::from_element(1, -1.0);
        assert_eq!(bfgs(barrier, &outside, 100), outside);
    }
}
