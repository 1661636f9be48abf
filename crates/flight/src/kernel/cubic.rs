//! The least argument at which a cubic rises to zero on [0, 1].

use crate::real::{Real, r};

/// Least `s` in [0, 1] with `a + b s + c s² + d s³ >= 0`; where the cubic stays
/// below zero, the `s` of its greatest value.
///
/// The stationary points cut [0, 1] into at most three monotone pieces; the
/// first one that ends at or above zero is searched by Newton's method, kept
/// inside its bracket by bisection, from `near` where that lies inside.
pub fn first_rise<R: Real>([a, b, c, d]: [R; 4], near: R) -> R {
    let value = |s: R| a + s * (b + s * (c + s * d));
    let slope = |s: R| b + s * (r::<R>(2.0) * c + s * r::<R>(3.0) * d);
    let (first, second) = stationary(b, c, d);
    let mut low = R::ZERO;
    let at_low = value(low);
    let mut best = (low, at_low);
    if at_low >= R::ZERO {
        return low;
    }
    for high in [first, second, R::ONE] {
        if high <= low {
            continue;
        }
        let at_high = value(high);
        if at_high >= R::ZERO {
            return search(low, high, near, value, slope);
        }
        if at_high > best.1 {
            best = (high, at_high);
        }
        low = high;
    }
    best.0
}

/// The stationary points, in rising order and limited to [0, 1].
fn stationary<R: Real>(b: R, c: R, d: R) -> (R, R) {
    // 3 d s² + 2 c s + b = 0, in the form that does not cancel.
    let three_d = r::<R>(3.0) * d;
    let discriminant = c * c - three_d * b;
    if discriminant <= R::ZERO || !discriminant.is_finite() {
        return (R::ONE, R::ONE);
    }
    let root = discriminant.sqrt();
    let q = if c < R::ZERO { root - c } else { -(root + c) };
    let unit = |s: R| {
        if s.is_finite() {
            s.clamp(R::ZERO, R::ONE)
        } else {
            R::ONE
        }
    };
    let (s1, s2) = (unit(q / three_d), unit(b / q));
    if s1 <= s2 { (s1, s2) } else { (s2, s1) }
}

fn search<R: Real>(
    mut low: R,
    mut high: R,
    near: R,
    value: impl Fn(R) -> R,
    slope: impl Fn(R) -> R,
) -> R {
    let half = r::<R>(0.5);
    let mut s = if near > low && near < high {
        near
    } else {
        half * (low + high)
    };
    // 60 halvings resolve an f64 on [0, 1]; Newton needs about five steps.
    for _ in 0..60 {
        let y = value(s);
        if y >= R::ZERO {
            high = s;
        } else {
            low = s;
        }
        let newton = s - y / slope(s);
        let next = if newton > low && newton < high {
            newton
        } else {
            half * (low + high)
        };
        if (next - s).abs() <= R::EPSILON * s.abs() {
            return next;
        }
        s = next;
    }
    s
}

#[cfg(test)]
mod tests {
    use super::first_rise;

    #[test]
    fn analytic_roots_of_products() {
        // (s - 0.3)(s - 0.6)(s - 0.9), rising first at 0.3.
        let p = [-0.162, 0.99, -1.8, 1.0];
        // Newton ends within a few rounding errors divided by the slope 0.18.
        assert!((first_rise::<f64>(p, 0.5) - 0.3).abs() < 1e-14);
        // From wherever it starts, also where Newton's first step leads out of the bracket.
        for near in [0.01, 0.29, 0.4, 0.45, f64::NAN, -1.0, 2.0] {
            assert!((first_rise(p, near) - 0.3).abs() < 1e-14, "{near}");
        }
        // (s - 0.6)(0.7 - s)(s + 1): zero or above between 0.6 and 0.7 only.
        let narrow = [-0.42_f64, 0.88, 0.3, -1.0];
        assert!((first_rise(narrow, 0.5) - 0.6).abs() < 1e-14);
        // Negated: at 0 it is already positive.
        assert!(first_rise(p.map(|c: f64| -c), 0.5) == 0.0);
        // Linear, and constant below zero: the first end with the greatest value.
        assert!((first_rise([-0.5_f64, 1.0, 0.0, 0.0], 0.5) - 0.5).abs() < 1e-15);
        assert!(first_rise([-1.0_f64, 0.0, 0.0, 0.0], 0.5) == 0.0);
        // Never reaches zero, greatest at 0.5: -1 + s - s².
        assert!((first_rise([-1.0_f64, 1.0, -1.0, 0.0], 0.5) - 0.5).abs() < 1e-15);
    }
}
