//! Sums of eight partial sums in a fixed order. They have the same bits for vector instructions of any width.

/// Partial sums of each sum.
pub(crate) const LANES: usize = 8;

/// The partial sums of one sum.
pub(crate) type Lanes = [f64; LANES];

/// The partial sums added in a fixed order.
#[inline(always)]
pub(crate) fn total(s: &Lanes) -> f64 {
    ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]))
}

/// `x · y`.
#[inline(always)]
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut s = [0.0; LANES];
    let (x, y) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let tail: f64 = x
        .remainder()
        .iter()
        .zip(y.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (x, y) in x.zip(y) {
        for k in 0..LANES {
            s[k] += x[k] * y[k];
        }
    }
    total(&s) + tail
}
