//! Exact steps of scalar linear differential equations.

use crate::real::Real;

/// `dt` if it is finite and positive, otherwise zero.
pub fn usable_dt<R: Real>(dt: R) -> R {
    if dt.is_finite() && dt > R::ZERO {
        dt
    } else {
        R::ZERO
    }
}

/// `y' = a + b y` with constant a, b, over `dt`; holds `y` where the result is
/// not finite.
pub fn linear_step<R: Real>(y: R, a: R, b: R, dt: R) -> R {
    let bdt = b * dt;
    let scale = if bdt == R::ZERO {
        R::ONE
    } else {
        bdt.exp_m1() / bdt
    };
    (y + (a + b * y) * dt * scale).finite_or(y)
}

/// The rest of `y' = a + b y` where it is stable (b < 0), otherwise zero.
pub fn linear_rest<R: Real>(a: R, b: R) -> R {
    if b < R::ZERO {
        (-a / b).finite_or(R::ZERO)
    } else {
        R::ZERO
    }
}

/// The share of its way that `y' = (target - y) / tau` goes in `dt`.
pub fn lag_share<R: Real>(tau: R, dt: R) -> R {
    -(-dt / tau).exp_m1()
}

/// `y' = (target - y) / tau` over `dt`; holds `y` where the result is not finite.
pub fn lag_step<R: Real>(y: R, target: R, tau: R, dt: R) -> R {
    lag_by(y, target, lag_share(tau, dt))
}

/// A step by a share of the way, as of [`lag_share`]; holds `y` where the result is not finite.
pub fn lag_by<R: Real>(y: R, target: R, share: R) -> R {
    (y + (target - y) * share).finite_or(y)
}

#[cfg(test)]
mod tests {
    use super::{lag_share, lag_step, linear_rest, linear_step};

    #[test]
    fn analytic_exponentials() {
        let (a, b, y0, t) = (0.7_f64, -3.0, 0.2, 0.4);
        let exact = -a / b + (y0 + a / b) * (b * t).exp();
        // A few roundings of numbers below one.
        assert!((linear_step(y0, a, b, t) - exact).abs() < 1e-15);
        assert!((linear_rest(a, b) - 0.7 / 3.0).abs() < 1e-15);
        assert!((linear_step(y0, a, 0.0, t) - (y0 + a * t)).abs() < 1e-15);
        assert!((lag_share(0.5_f64, 0.2) - (1.0 - (-0.4_f64).exp())).abs() < 1e-15);
        assert!((lag_step(y0, 1.0, 0.5, 0.5) - (1.0 - 0.8 * (-1.0_f64).exp())).abs() < 1e-15);
        assert!(linear_step(y0, f64::NAN, b, t) == y0);
    }
}
