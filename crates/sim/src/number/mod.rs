//! Numbers that the vehicle is computed with: one, or several side by side.
//!
//! Rotors, body, legs and attitude control are written once, for any [`Number`]:
//! `f64` flies one landing, [`space::Batch`](crate::landing::space::Batch) one in each lane of a
//! processor's vector. Operations round as those of `f64` do and are never
//! contracted, so that a lane gets bit for bit what a landing alone gets.

pub(crate) mod lanes;
pub(crate) mod rk4;
pub(crate) mod vector;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Numbers side by side in the widest vectors.
pub const MOST_LANES: usize = 8;

/// Passes bounds on `T` on to users of a trait, for which Rust repeats only bounds on `Self`.
pub trait Implies<T> {
    /// `T`.
    type Is;
}

impl<N, T> Implies<T> for N {
    type Is = T;
}

/// A number, or one number in each SIMD lane. Constants (`f64`) stand on either side of an operator.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + Operand<Self>
    // Constants on the left.
    + Implies<f64, Is = f64>
    + Implies<
        f64,
        Is: Add<Self, Output = Self>
                + Sub<Self, Output = Self>
                + Mul<Self, Output = Self>
                + Div<Self, Output = Self>
                + Operand<Self>,
    >
    // Without these, `f64` would lose its own operators where a `Number` is in scope.
    + Implies<
        f64,
        Is: Add<f64, Output = f64>
                + Sub<f64, Output = f64>
                + Mul<f64, Output = f64>
                + Div<f64, Output = f64>,
    >
{
    /// Truth of a comparison, one for each number.
    type Truth: Copy
        + BitAnd<Output = Self::Truth>
        + BitOr<Output = Self::Truth>
        + Not<Output = Self::Truth>;

    /// The value in as many lanes as `self` has.
    #[must_use]
    fn splat(self, value: f64) -> Self;

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;

    /// Whether `self < other`, lane by lane.
    fn less_than(self, other: Self) -> Self::Truth;

    /// `yes` where true, else `no`, lane by lane.
    #[must_use]
    fn blend(truth: Self::Truth, yes: Self, no: Self) -> Self;

    /// True for any of the numbers.
    fn any(truth: Self::Truth) -> bool;

    /// How many numbers there are.
    const COUNT: usize;

    /// One of the numbers.
    fn get(self, lane: usize) -> f64;

    /// The first of the values, as many as there are numbers in `self`.
    #[must_use]
    fn of_lanes(self, values: &[f64; MOST_LANES]) -> Self;

    /// With one of the numbers replaced.
    #[must_use]
    fn with(self, lane: usize, value: f64) -> Self;

    /// Number by number.
    #[must_use]
    fn each(self, f: impl Fn(f64) -> f64) -> Self;

    /// Several values, number by number.
    #[must_use]
    fn look_up<const K: usize>(self, f: impl Fn(f64) -> [f64; K]) -> [Self; K];

    /// The rows at an index, number by number; the last where there is none.
    #[must_use]
    fn gather<const K: usize>(self, rows: &[[f64; K]]) -> [Self; K];

    /// Whether `self < other`.
    #[inline(always)]
    fn below(self, other: impl Operand<Self>) -> Self::Truth {
        self.less_than(other.lanes_of(self))
    }

    /// Whether `self > other`.
    #[inline(always)]
    fn above(self, other: impl Operand<Self>) -> Self::Truth {
        other.lanes_of(self).less_than(self)
    }

    /// `yes` where true, else `no`.
    #[inline(always)]
    #[must_use]
    fn select(truth: Self::Truth, yes: Self, no: impl Operand<Self>) -> Self {
        Self::blend(truth, yes, no.lanes_of(yes))
    }

    /// The smaller; `bound` where they cannot be compared.
    #[inline(always)]
    #[must_use]
    fn at_most(self, bound: impl Operand<Self>) -> Self {
        let bound = bound.lanes_of(self);
        Self::select(self.less_than(bound), self, bound)
    }

    /// The larger; `bound` where they cannot be compared.
    #[inline(always)]
    #[must_use]
    fn at_least(self, bound: impl Operand<Self>) -> Self {
        let bound = bound.lanes_of(self);
        Self::select(bound.less_than(self), self, bound)
    }

    /// Held within two bounds.
    #[inline(always)]
    #[must_use]
    fn within(self, low: impl Operand<Self>, high: impl Operand<Self>) -> Self {
        self.at_least(low).at_most(high)
    }
}

/// What a [`Number`] is compared with: another one, or a constant for all lanes.
pub trait Operand<N>: Copy {
    /// The value in each lane of `like`.
    #[must_use]
    fn lanes_of(self, like: N) -> N;
}

impl Operand<f64> for f64 {
    #[inline(always)]
    fn lanes_of(self, _: f64) -> f64 {
        self
    }
}

impl Number for f64 {
    type Truth = bool;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn less_than(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn blend(truth: bool, yes: Self, no: Self) -> Self {
        if truth { yes } else { no }
    }

    #[inline(always)]
    fn any(truth: bool) -> bool {
        truth
    }

    const COUNT: usize = 1;

    #[inline(always)]
    fn get(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn of_lanes(self, values: &[f64; MOST_LANES]) -> Self {
        values[0]
    }

    #[inline(always)]
    fn with(self, _: usize, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }

    #[inline(always)]
    fn look_up<const K: usize>(self, f: impl Fn(f64) -> [f64; K]) -> [Self; K] {
        f(self)
    }

    #[inline(always)]
    fn gather<const K: usize>(self, rows: &[[f64; K]]) -> [Self; K] {
        rows[(self as usize).min(rows.len() - 1)]
    }
}

/// `atan(t)/t` as a polynomial in t² up to t = tan 22.5°, lowest order first; its
/// greatest relative error is 3.5e-17.
const ARC: [f64; 11] = [
    1.0,
    -0.333_333_333_333_284_4,
    0.199_999_999_988_551_09,
    -0.142_857_141_809_763_92,
    0.111_111_061_804_528_65,
    -0.090_907_730_747_368_6,
    0.076_899_534_952_989_42,
    -0.066_402_339_216_734_51,
    0.056_883_491_809_884_175,
    -0.043_480_520_833_406_28,
    0.021_135_371_536_498_415,
];

/// The angle of the complex number `re + i im` in (-π, π].
#[inline(always)]
#[must_use]
pub(crate) fn angle<N: Number>(re: N, im: N) -> N {
    let [angle] = angles([re], [im]);
    angle
}

/// [`angle`] of several; side by side, as no part of one waits for another's.
#[inline(always)]
#[must_use]
pub(crate) fn angles<N: Number, const K: usize>(re: [N; K], im: [N; K]) -> [N; K] {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    let (mut t, mut s, mut series) = (re, re, re);
    for i in 0..K {
        let (a, b) = (re[i].abs(), im[i].abs());
        let (small, large) = (a.at_most(b), a.at_least(b));
        // Above 22.5°, 45° less the angle of what is left: one division for both.
        let steep = (large * TAN_PI_8).below(small);
        t[i] = N::select(steep, small - large, small) / N::select(steep, small + large, large);
        s[i] = t[i] * t[i];
        series[i] = t[i].splat(ARC[10]);
    }
    for k in (0..10).rev() {
        for i in 0..K {
            series[i] = series[i] * s[i] + ARC[k];
        }
    }
    let mut angle = t;
    for i in 0..K {
        let (a, b) = (re[i].abs(), im[i].abs());
        let steep = (a.at_least(b) * TAN_PI_8).below(a.at_most(b));
        let arc = t[i] * series[i];
        let arc = N::select(steep, arc + FRAC_PI_4, arc);
        let arc = N::select(a.below(b), FRAC_PI_2 - arc, arc);
        let arc = N::select(re[i].below(0.0), PI - arc, arc);
        angle[i] = N::select(im[i].below(0.0), -arc, arc);
    }
    angle
}

/// `1/d` of several numbers whose product is not 0: one division, the rest are products.
#[inline(always)]
#[must_use]
pub(crate) fn inverses<N: Number, const K: usize>(d: [N; K]) -> [N; K] {
    let mut before = d;
    for i in 1..K {
        before[i] = before[i - 1] * d[i];
    }
    let mut rest = 1.0 / before[K - 1];
    let mut inverse = d;
    for i in (1..K).rev() {
        inverse[i] = rest * before[i - 1];
        rest = rest * d[i];
    }
    inverse[0] = rest;
    inverse
}

/// tan 22.5°.
const TAN_PI_8: f64 = std::f64::consts::SQRT_2 - 1.0;

/// `sin(x)/x` and `cos(x)` as polynomials in x² up to π/4, lowest order first; their
/// greatest errors are 3.1e-18 and 3.0e-20.
const SINE: [f64; 7] = [
    1.0,
    -0.166_666_666_666_666_16,
    0.008_333_333_333_320_356,
    -0.000_198_412_698_286_452_6,
    2.755_731_337_464_985_7e-06,
    -2.505_071_669_669_567_6e-08,
    1.589_472_030_022_310_9e-10,
];
const COSINE: [f64; 8] = [
    1.0,
    -0.5,
    0.041_666_666_666_666_45,
    -0.001_388_888_888_886_108_2,
    2.480_158_728_387_408_4e-05,
    -2.755_731_309_595_641e-07,
    2.087_558_214_647_743_3e-09,
    -1.135_336_795_783_079_2e-11,
];

/// Sine and cosine: fast up to 45°.
#[inline(always)]
#[must_use]
pub(crate) fn sin_cos<N: Number>(x: N) -> (N, N) {
    let s = x * x;
    let (mut sine, mut cosine) = (s.splat(SINE[6]), s.splat(COSINE[7]));
    for k in (0..6).rev() {
        sine = sine * s + SINE[k];
    }
    for k in (0..7).rev() {
        cosine = cosine * s + COSINE[k];
    }
    let (sine, cosine) = (sine * x, cosine);
    let far = x.abs().above(std::f64::consts::FRAC_PI_4);
    if !N::any(far) {
        return (sine, cosine);
    }
    let (far_sine, far_cosine) = (x.each(f64::sin), x.each(f64::cos));
    (
        N::select(far, far_sine, sine),
        N::select(far, far_cosine, cosine),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_angles_are_those_of_atan2() {
        for i in 0..10_000 {
            let turn = 1e-3 + 6.28e-4 * f64::from(i) - std::f64::consts::PI;
            let (re, im) = (3.7 * turn.cos(), 3.7 * turn.sin());
            let difference = angle(re, im) - im.atan2(re);
            // Three roundings of numbers up to π, each half of 4.4e-16.
            assert!(difference.abs() < 1e-15, "{turn}: {difference}");
        }
        // 0 divided by 0 is no angle here: callers have a length.
        assert_eq!(angle(1.0, 0.0), 0.0);
        assert_eq!(angle(0.0, 2.0), std::f64::consts::FRAC_PI_2);
    }

    #[test]
    fn analytic_inverses() {
        let d = [0.4, 7.0, 1e-3, -25.0];
        for (inverse, d) in inverses(d).into_iter().zip(d) {
            // Five products and a division round by 1.1e-16 each.
            assert!((inverse * d - 1.0).abs() < 7e-16, "{d}");
        }
        assert_eq!(inverses([8.0]), [0.125]);
    }

    #[test]
    fn analytic_sine_and_cosine() {
        for i in -2_000..=2_000 {
            let x = 1e-3 * f64::from(i);
            let (sine, cosine) = sin_cos(x);
            // The polynomial's sum and its product with x round once each: 2.2e-16 up to 1.
            assert!((sine - x.sin()).abs() < 2.3e-16, "{x}");
            assert!((cosine - x.cos()).abs() < 2.3e-16, "{x}");
        }
    }
}
