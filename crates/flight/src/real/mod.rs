//! The scalar type: `f32` on a small flight computer, `f64` in simulation.

mod single;

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point scalar, `f32` or `f64` (sealed: no other type can implement it).
///
/// Elementary functions come from `libm`, and in single precision from this module where
/// those of `libm` compute in double precision or by software. So a result is the same on
/// every target that rounds IEEE 754 arithmetic correctly.
pub trait Real:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// The distance from one to the next larger value.
    const EPSILON: Self;

    /// The nearest value to `value`.
    fn from_f64(value: f64) -> Self;
    /// The nearest value to a count.
    fn from_count(count: usize) -> Self;
    /// The value in double precision (exact).
    fn to_f64(self) -> f64;
    /// Square root; NaN for a negative argument.
    fn sqrt(self) -> Self;
    /// Exponential function.
    fn exp(self) -> Self;
    /// `exp(x) - 1` without loss of digits near zero.
    fn exp_m1(self) -> Self;
    /// Natural logarithm; NaN for a negative argument.
    fn ln(self) -> Self;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Sine and cosine of an angle in radians: the bits of both, sooner.
    fn sin_cos(self) -> (Self, Self);
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Angle of the point (`x`, `self`), in (-π, π].
    fn atan2(self, x: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller value; a NaN operand is ignored.
    fn min(self, other: Self) -> Self;
    /// The larger value; a NaN operand is ignored.
    fn max(self, other: Self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// `self` limited to `[low, high]`. NaN stays NaN, and unlike
    /// [`f64::clamp`] crossed limits do not panic (`low` wins).
    #[must_use]
    fn clamp(self, low: Self, high: Self) -> Self {
        if self < low {
            low
        } else if self > high {
            if high < low { low } else { high }
        } else {
            self
        }
    }

    /// `self` if it is finite, otherwise `fallback`.
    #[must_use]
    fn finite_or(self, fallback: Self) -> Self {
        if self.is_finite() { self } else { fallback }
    }
}

macro_rules! impl_real {
    ($t:ident: $($name:ident = $function:path),+; $sin_cos:path, $widened:path, $atan2:path, $least:path, $greatest:path) => {
        impl Real for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $t::EPSILON;

            // Always inlined: a constant in double precision then becomes one in single
            // precision at every level of optimisation, without a conversion at run time.
            #[allow(clippy::cast_possible_truncation, trivial_numeric_casts)]
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $t
            }
            #[allow(clippy::cast_precision_loss)]
            fn from_count(count: usize) -> Self {
                count as $t
            }
            fn to_f64(self) -> f64 {
                $widened(self)
            }
            $(
                fn $name(self) -> Self {
                    $function(self)
                }
            )+
            fn sin_cos(self) -> (Self, Self) {
                $sin_cos(self)
            }
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
            }
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                $least(self, other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                $greatest(self, other)
            }
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
        }
    };
}

impl_real!(
    f32:
    sqrt = touchdown_square_root::square_root,
    exp = single::exp,
    exp_m1 = single::exp_m1,
    ln = libm::logf,
    sin = single::sin,
    cos = single::cos,
    tanh = single::tanh;
    single::sin_cos, single::widened, libm::atan2f, single::least, single::greatest
);
impl_real!(
    f64:
    sqrt = libm::sqrt,
    exp = libm::exp,
    exp_m1 = libm::expm1,
    ln = libm::log,
    sin = libm::sin,
    cos = libm::cos,
    tanh = libm::tanh;
    sin_and_cos, core::convert::identity, libm::atan2, f64::min, f64::max
);

/// Sine and cosine in double precision: the bits of each (`libm::sincos` has others).
fn sin_and_cos(x: f64) -> (f64, f64) {
    (libm::sin(x), libm::cos(x))
}

/// Short for [`Real::from_f64`], for constants in kernels.
#[inline(always)]
pub fn r<R: Real>(value: f64) -> R {
    R::from_f64(value)
}
