//! Cubics through values and slopes.

/// The cubic on [0, 1] with end values `a`, `b` and end slopes `p`, `q`.
pub(crate) fn hermite(a: f64, b: f64, p: f64, q: f64, s: f64) -> f64 {
    let rise = b - a;
    let (c2, c3) = (3.0 * rise - 2.0 * p - q, p + q - 2.0 * rise);
    a + s * (p + s * (c2 + s * c3))
}

/// Slopes at the knots of the not-a-knot cubic spline, from its tridiagonal equations.
pub(crate) fn spline_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let h: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
    let m: Vec<f64> = y
        .windows(2)
        .zip(&h)
        .map(|(w, h)| (w[1] - w[0]) / h)
        .collect();
    if n == 2 {
        return vec![m[0]; 2];
    }
    let (mut lower, mut diagonal, mut upper) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut right = vec![0.0; n];
    for i in 1..n - 1 {
        (lower[i], diagonal[i], upper[i]) = (h[i], 2.0 * (h[i - 1] + h[i]), h[i - 1]);
        right[i] = 3.0 * (h[i] * m[i - 1] + h[i - 1] * m[i]);
    }
    if n == 3 {
        (diagonal[0], upper[0], right[0]) = (1.0, 1.0, 2.0 * m[0]);
        (lower[2], diagonal[2], right[2]) = (1.0, 1.0, 2.0 * m[1]);
    } else {
        let end = |h0: f64, h1: f64, m0: f64, m1: f64| {
            let d = h0 + h1;
            (h1, d, ((h0 + 2.0 * d) * h1 * m0 + h0 * h0 * m1) / d)
        };
        (diagonal[0], upper[0], right[0]) = end(h[0], h[1], m[0], m[1]);
        (diagonal[n - 1], lower[n - 1], right[n - 1]) = end(h[n - 2], h[n - 3], m[n - 2], m[n - 3]);
    }
    for i in 1..n {
        let factor = lower[i] / diagonal[i - 1];
        diagonal[i] -= factor * upper[i - 1];
        right[i] -= factor * right[i - 1];
    }
    let mut slopes = right;
    slopes[n - 1] /= diagonal[n - 1];
    for i in (0..n - 1).rev() {
        slopes[i] = (slopes[i] - upper[i] * slopes[i + 1]) / diagonal[i];
    }
    slopes
}
