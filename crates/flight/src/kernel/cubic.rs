//! The least argument at which a cubic rises to zero on [0, 1].

use crate::real::{Real, r};

/// Least `s` in [0, 1] with `a + b s + c s² + d s³ >= 0`; where the cubic stays
/// below zero, the `s` of its greatest value.
///
/// Newton's method from `near` mostly ends at it. Otherwise the stationary points cut [0, 1]
/// into at most three monotone pieces; the first one that ends at or above zero is halved.
pub fn first_rise<R: Real>(cubic: [R; 4], near: R) -> R {
    let [a, b, c, d] = cubic;
    if a >= R::ZERO {
        return R::ZERO;
    }
    if let Some(s) = rise_near(&cubic, near) {
        return s;
    }
    let (first, second) = stationary(b, c, d);
    let mut low = R::ZERO;
    let mut best = (low, a);
    for high in [first, second, R::ONE] {
        if high <= low {
            continue;
        }
        let at_high = value(&cubic, high);
        if at_high >= R::ZERO {
            return search(&cubic, low, high);
        }
        if at_high > best.1 {
            best = (high, at_high);
        }
        low = high;
    }
    best.0
}

/// Most steps of Newton's method from a start that is known to be near.
const NEAR_STEPS: u8 = 4;

/// The first rise of a cubic that begins below zero, if Newton's method from `near` ends at it in few steps, all of which lie within
/// (0, 1) where the cubic rises.
///
/// Divided by `s - s0`, s0 the root, the cubic is `q(s) = d s² + e s + f` with `e = c + d s0` and `f = b + e s0 = -a/s0 > 0`. At the
/// root, q is the slope, above zero as well. An earlier root is one of q: there is none if q is concave (d <= 0), has its least value
/// before 0 or behind the root, or is above zero there.
fn rise_near<R: Real>(cubic: &[R; 4], near: R) -> Option<R> {
    let [_, b, c, d] = *cubic;
    let two = r::<R>(2.0);
    let mut s = near;
    for _ in 0..NEAR_STEPS {
        if !(s > R::ZERO && s < R::ONE) {
            return None;
        }
        let steeper = s * r::<R>(3.0) * d;
        let slope = b + s * (two * c + steeper);
        if !(slope > R::ZERO) {
            return None;
        }
        let newton = s - value(cubic, s) / slope;
        let step = newton - s;
        // Value of the cubic after the step.
        let left = (c + steeper + d * step) * (step * step);
        let last = left.abs() <= R::EPSILON * s * slope;
        s = newton;
        if last {
            let e = c + d * s;
            let f = b + e * s;
            let monotone = e >= R::ZERO || e + two * d * s <= R::ZERO;
            let first = d <= R::ZERO || monotone || e * e < r::<R>(4.0) * d * f;
            let rises = f + s * (e + d * s) > R::ZERO;
            return Some(s).filter(|_| first && rises && s > R::ZERO && s < R::ONE);
        }
    }
    None
}

fn value<R: Real>(&[a, b, c, d]: &[R; 4], s: R) -> R {
    a + s * (b + s * (c + s * d))
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

/// The root between `low`, where the cubic is below zero, and `high`, where it is not.
fn search<R: Real>(cubic: &[R; 4], mut low: R, mut high: R) -> R {
    // 60 halvings resolve an f64 on [0, 1].
    for _ in 0..60 {
        let middle = r::<R>(0.5) * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if value(cubic, middle) >= R::ZERO {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
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

    #[test]
    fn prop_wherever_the_search_starts_it_finds_the_first_of_three_roots() {
        let places = [-0.4, -0.1, 0.05, 0.2, 0.45, 0.6, 0.85, 0.99, 1.2, 1.7];
        let mut crossings = 0;
        for (i, &a) in places.iter().enumerate() {
            for (k, &b) in places.iter().enumerate().skip(i + 1) {
                for &c in places.iter().skip(k + 1) {
                    // Rising at a and c, with d above zero; negated, rising at b alone.
                    let up = [-a * b * c, a * b + b * c + c * a, -(a + b + c), 1.0_f64];
                    for (p, rises) in [(up, [a, c]), (up.map(|x| -x), [b, b])] {
                        let within = |s: &f64| (0.0..=1.0).contains(s);
                        let Some(first) = rises.into_iter().find(within).filter(|_| p[0] < 0.0)
                        else {
                            continue;
                        };
                        crossings += 1;
                        for near in 0..=40 {
                            let found = first_rise(p, f64::from(near) / 40.0);
                            // Rounding over the least slope, 0.04 between roots that are 0.14 apart.
                            assert!((found - first).abs() < 1e-13, "{p:?} {near}: {found}");
                        }
                    }
                }
            }
        }
        assert!(crossings > 100, "{crossings}");
    }
}
