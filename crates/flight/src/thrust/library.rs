//! Eq. (8): sparse library model of the thrust dynamics.

use crate::error::{SettingsError, finite};
use crate::kernel::first_rise;
use crate::real::{Real, r};

/// Longest Runge-Kutta step, s.
const STEP_MAX_S: f64 = 0.02;
/// Most Runge-Kutta steps in one call; a longer `dt` takes longer steps.
const STEPS_MAX: f64 = 256.0;

/// Eq. (8), `x' = a1 + a2 x + a3 s + a4 s² + a5 x³ + a6 s³ + a7 e^(-x) s + a8 sin(x) s`
/// with `x = √T` (√N) and throttle `s`.
///
/// Valid above the unstable branch that such a model can have near `x = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Library<R> {
    /// Coefficient of 1.
    pub one: R,
    /// Coefficient of x.
    pub x: R,
    /// Coefficient of s.
    pub s: R,
    /// Coefficient of s².
    pub s2: R,
    /// Coefficient of x³.
    pub x3: R,
    /// Coefficient of s³.
    pub s3: R,
    /// Coefficient of e^(-x) s.
    pub exp_neg_x_s: R,
    /// Coefficient of sin(x) s.
    pub sin_x_s: R,
}

impl<R: Real> Library<R> {
    /// The terms in the order of [`Library::from_array`], as expressions in
    /// `x` and `s`.
    pub const TERMS: [&'static str; 8] =
        ["1", "x", "s", "s^2", "x^3", "s^3", "exp(-x)*s", "sin(x)*s"];

    /// The published coefficients, eq. (11).
    #[must_use]
    pub fn published() -> Self {
        Self::from_array([
            r(0.215),
            r(-0.650),
            r(13.882),
            r(11.815),
            r(-0.123),
            r(-12.825),
            r(-16.647),
            r(-1.457),
        ])
    }

    /// Coefficients in the order of [`Library::TERMS`].
    #[must_use]
    pub fn from_array([one, x, s, s2, x3, s3, exp_neg_x_s, sin_x_s]: [R; 8]) -> Self {
        Self {
            one,
            x,
            s,
            s2,
            x3,
            s3,
            exp_neg_x_s,
            sin_x_s,
        }
    }

    pub(super) fn validate(&self) -> Result<(), SettingsError> {
        finite("thrust.library.one", self.one)?;
        finite("thrust.library.x", self.x)?;
        finite("thrust.library.s", self.s)?;
        finite("thrust.library.s2", self.s2)?;
        finite("thrust.library.x3", self.x3)?;
        finite("thrust.library.s3", self.s3)?;
        finite("thrust.library.exp_neg_x_s", self.exp_neg_x_s)?;
        finite("thrust.library.sin_x_s", self.sin_x_s)
    }

    /// The model at a given x, as a cubic in s.
    fn cubic(&self, x: R) -> [R; 4] {
        [
            self.one + x * (self.x + self.x3 * x * x),
            self.s + self.exp_neg_x_s * (-x).exp() + self.sin_x_s * x.sin(),
            self.s2,
            self.s3,
        ]
    }

    pub(super) fn derivative(&self, x: R, s: R) -> R {
        let [a, b, c, d] = self.cubic(x);
        a + s * (b + s * (c + s * d))
    }

    pub(super) fn step(&self, mut x: R, s: R, dt: R) -> R {
        let mut steps = R::ONE;
        if dt > r(STEP_MAX_S) {
            let wanted = (dt / r(STEP_MAX_S)).min(r(STEPS_MAX));
            while steps < wanted {
                steps += R::ONE;
            }
        }
        let h = dt / steps;
        let half = r::<R>(0.5) * h;
        let sixth = h / r(6.0);
        let mut done = R::ZERO;
        while done < steps {
            let near = Near::new(self, x);
            let k1 = near.derivative_here(s);
            let k2 = near.derivative(half * k1, s);
            let k3 = near.derivative(half * k2, s);
            let k4 = near.derivative(h * k3, s);
            let next = x + sixth * (k1 + r::<R>(2.0) * (k2 + k3) + k4);
            x = super::limit(next.finite_or(x));
            done += R::ONE;
        }
        x
    }

    /// The greatest root of the derivative above which x falls: the greatest stable one. Where x rises everywhere, the greatest x.
    pub(super) fn rest(&self, s: R) -> R {
        let mut high = r::<R>(super::ROOT_THRUST_MAX);
        let least = r::<R>(super::ROOT_THRUST_MIN);
        // A cubic term above zero lets x rise without end above a root that no vehicle reaches. From the top in steps of 10 % until x
        // falls.
        let mut low = high;
        while !(self.derivative(low, s) < R::ZERO) {
            low *= r(0.9);
            if low <= least {
                return high;
            }
        }
        // Further until it no longer falls.
        while self.derivative(low, s) < R::ZERO {
            high = low;
            low *= r(0.9);
            if low <= least {
                low = least;
                break;
            }
        }
        // 60 halvings resolve an f64 in the bracket.
        for _ in 0..60 {
            let middle = r::<R>(0.5) * (low + high);
            if self.derivative(middle, s) < R::ZERO {
                high = middle;
            } else {
                low = middle;
            }
        }
        low
    }

    pub(super) fn throttle_for(&self, x: R, near: R) -> R {
        first_rise(self.cubic(x), near)
    }
}

/// Greatest distance at which the series of [`Near`] stands for the elementary functions, √N.
const NEAR_MAX: f64 = 0.02;

/// The derivative close to a state, with elementary functions of that state alone.
struct Near<'a, R> {
    model: &'a Library<R>,
    x: R,
    /// `exp_neg_x_s exp(-x) + sin_x_s sin(x)` as a Taylor series about the state; the next
    /// term is below 3e-16 of the coefficients within [`NEAR_MAX`].
    series: [R; 7],
}

impl<'a, R: Real> Near<'a, R> {
    fn new(model: &'a Library<R>, x: R) -> Self {
        let falling = model.exp_neg_x_s * (-x).exp();
        let (sine, cosine) = x.sin_cos();
        let (sine, cosine) = (model.sin_x_s * sine, model.sin_x_s * cosine);
        Self {
            model,
            x,
            series: [
                falling + sine,
                cosine - falling,
                (falling - sine) * r(1.0 / 2.0),
                -(falling + cosine) * r(1.0 / 6.0),
                (falling + sine) * r(1.0 / 24.0),
                (cosine - falling) * r(1.0 / 120.0),
                (falling - sine) * r(1.0 / 720.0),
            ],
        }
    }

    /// [`Library::derivative`] at the state plus `by`. Inlined, it keeps the coefficients in
    /// registers.
    #[inline(always)]
    fn derivative(&self, by: R, s: R) -> R {
        // Also where `by` is not a number.
        if !(by.abs() <= r(NEAR_MAX)) {
            return self.derivative_far(by, s);
        }
        let [c0, c1, c2, c3, c4, c5, c6] = self.series;
        let change = by * (c1 + by * (c2 + by * (c3 + by * (c4 + by * (c5 + by * c6)))));
        self.driven(self.x + by, self.model.s + c0 + change, s)
    }

    /// [`Library::derivative`] at the state itself.
    #[inline(always)]
    fn derivative_here(&self, s: R) -> R {
        let [c0, ..] = self.series;
        self.driven(self.x, self.model.s + c0, s)
    }

    #[inline(always)]
    fn driven(&self, x: R, drive: R, s: R) -> R {
        let m = self.model;
        m.one + x * (m.x + m.x3 * x * x) + s * (drive + s * (m.s2 + s * m.s3))
    }

    #[cold]
    #[inline(never)]
    fn derivative_far(&self, by: R, s: R) -> R {
        self.model.derivative(self.x + by, s)
    }
}

#[cfg(test)]
mod tests {
    use super::{Library, Near};
    use crate::thrust::ROOT_THRUST_MAX;

    #[test]
    fn analytic_rest_is_the_greatest_stable_root() {
        // x³ - 84 x + 160 has the roots -10, 2 and 8.
        let cubic = |scale: f64| Library {
            one: 160.0 * scale,
            x: -84.0 * scale,
            s: 0.0,
            s2: 0.0,
            x3: scale,
            s3: 0.0,
            exp_neg_x_s: 0.0,
            sin_x_s: 0.0,
        };
        // x falls between 2 and 8 and rises without end above 8, as fits without data there do; bisection to rounding.
        assert!((cubic(1.0).rest(0.5) - 2.0).abs() < 1e-12);
        // The other way round 8 is stable.
        assert!((cubic(-1.0).rest(0.5) - 8.0).abs() < 1e-12);
        let rises = Library {
            one: 1.0,
            x: 0.0,
            x3: 0.0,
            ..cubic(1.0)
        };
        assert_eq!(rises.rest(0.5), ROOT_THRUST_MAX);
    }

    #[test]
    fn analytic_close_to_a_state_it_is_the_derivative() {
        let model = Library::<f64>::published();
        for i in 0..300 {
            let x = 0.3 + 0.1 * f64::from(i);
            let near = Near::new(&model, x);
            for by in [0.0, 1e-4, -0.013, 0.02, -0.02, 0.0201, -0.5, 3.0] {
                let exact = model.derivative(x + by, 0.6);
                // 3e-16 of 17 by the series; otherwise roundings of sums up to x³.
                let bound = 1e-14 + 1e-15 * exact.abs();
                let found = near.derivative(by, 0.6);
                assert!((found - exact).abs() < bound, "{x} + {by}: {found} {exact}");
            }
        }
        assert!(Near::new(&model, 3.0).derivative(f64::NAN, 0.5).is_nan());
    }
}
