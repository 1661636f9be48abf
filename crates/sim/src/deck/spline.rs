//! Piecewise quintic motions: fast to evaluate, two derivatives continuous.

use std::sync::Arc;

use super::rigid::DeckCoordinates;
use crate::number::Number;

/// Quintic Hermite interpolation between knots that carry value, rate and
/// acceleration. A cubic spline is the case in which the accelerations are
/// piecewise linear. Before the first and after the last knot the motion is
/// held, at rest. Clones share the knots.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSpline {
    times_s: Arc<[f64]>,
    /// Intervals per second, to guess the interval of a time.
    per_s: f64,
    /// For each interval, coordinate by coordinate, the polynomial in the time
    /// since its first knot, lowest order first.
    pieces: Arc<[[[f64; 5]; 6]]>,
}

impl MotionSpline {
    /// A spline through knots at increasing times, at least two.
    pub(crate) fn new(times_s: &[f64], knots: &[DeckCoordinates]) -> Self {
        let pieces = times_s.windows(2).zip(knots.windows(2));
        let span = times_s[times_s.len() - 1] - times_s[0];
        Self {
            times_s: times_s.into(),
            per_s: (times_s.len() - 1) as f64 / span,
            pieces: pieces
                .map(|(t, k)| piece(t[1] - t[0], &k[0], &k[1]))
                .collect(),
        }
    }

    /// First and last time, s.
    #[must_use]
    pub fn range_s(&self) -> (f64, f64) {
        (self.times_s[0], self.times_s[self.times_s.len() - 1])
    }

    /// The motion at the time t.
    #[inline]
    #[must_use]
    pub fn at(&self, time_s: f64) -> DeckCoordinates {
        let (first, last) = self.range_s();
        let held = time_s.clamp(first, last);
        let mut i = (((held - first) * self.per_s) as usize).min(self.pieces.len() - 1);
        while i > 0 && held < self.times_s[i] {
            i -= 1;
        }
        while i + 1 < self.pieces.len() && held >= self.times_s[i + 1] {
            i += 1;
        }
        let t = held - self.times_s[i];
        let motion = on_piece(&self.pieces[i], t);
        if held != time_s {
            return DeckCoordinates {
                value: motion.value,
                ..DeckCoordinates::default()
            };
        }
        motion
    }
}

/// The quintics between two knots h apart, one for each coordinate.
pub(crate) fn piece(h: f64, a: &DeckCoordinates, b: &DeckCoordinates) -> [[f64; 5]; 6] {
    let mut piece = [[0.0; 5]; 6];
    for axis in 0..5 {
        let (v, r, c) = (a.value[axis], a.rate[axis], 0.5 * a.acceleration[axis]);
        // The residual of the quadratic at the end, scaled to h = 1.
        let dv = b.value[axis] - (v + h * (r + h * c));
        let dr = h * (b.rate[axis] - (r + 2.0 * h * c));
        let da = h * h * (b.acceleration[axis] - 2.0 * c);
        let h3 = h * h * h;
        piece[0][axis] = v;
        piece[1][axis] = r;
        piece[2][axis] = c;
        piece[3][axis] = (10.0 * dv - 4.0 * dr + 0.5 * da) / h3;
        piece[4][axis] = (-15.0 * dv + 7.0 * dr - da) / (h3 * h);
        piece[5][axis] = (6.0 * dv - 3.0 * dr + 0.5 * da) / (h3 * h * h);
    }
    piece
}

/// The motion at the time t since the first knot of a piece.
#[inline(always)]
pub(crate) fn on_piece<N: Number>(p: &[[N; 5]; 6], t: f64) -> DeckCoordinates<N> {
    let mut motion = DeckCoordinates {
        value: p[0],
        rate: p[1],
        acceleration: p[2],
    };
    for a in 0..5 {
        let (p3, p4, p5) = (p[3][a], p[4][a], p[5][a]);
        motion.value[a] = ((((p5 * t + p4) * t + p3) * t + p[2][a]) * t + p[1][a]) * t + p[0][a];
        motion.rate[a] =
            (((p5 * (5.0 * t) + p4 * 4.0) * t + p3 * 3.0) * t + p[2][a] * 2.0) * t + p[1][a];
        motion.acceleration[a] = ((p5 * (20.0 * t) + p4 * 12.0) * t + p3 * 6.0) * t + p[2][a] * 2.0;
    }
    motion
}

/// Second derivatives of the natural cubic spline through `(times, values)`.
pub(crate) fn natural_cubic(times_s: &[f64], values: &[f64]) -> Vec<f64> {
    let n = times_s.len();
    let mut second = vec![0.0; n];
    // Thomas algorithm: the matrix is diagonally dominant.
    let mut upper = vec![0.0; n];
    for i in 1..n.saturating_sub(1) {
        let (h0, h1) = (times_s[i] - times_s[i - 1], times_s[i + 1] - times_s[i]);
        let slope = (values[i + 1] - values[i]) / h1 - (values[i] - values[i - 1]) / h0;
        let pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
        upper[i] = h1 / pivot;
        second[i] = (6.0 * slope - h0 * second[i - 1]) / pivot;
    }
    for i in (1..n.saturating_sub(1)).rev() {
        second[i] -= upper[i] * second[i + 1];
    }
    second
}

/// Rates at the knots of a cubic spline with the given second derivatives.
pub(crate) fn cubic_rates(times_s: &[f64], values: &[f64], second: &[f64]) -> Vec<f64> {
    let n = times_s.len();
    (0..n)
        .map(|i| {
            // From the interval that starts at the knot; the last knot ends one.
            let (a, sign) = if i + 1 < n { (i, 1.0) } else { (i - 1, -1.0) };
            let h = times_s[a + 1] - times_s[a];
            let chord = (values[a + 1] - values[a]) / h;
            chord - sign * h / 6.0 * (2.0 * second[i] + second[if i + 1 < n { i + 1 } else { a }])
        })
        .collect()
}
