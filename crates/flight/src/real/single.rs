//! Elementary functions in single precision, without a step in double precision.
//!
//! A Cortex-M4F has no double precision: there `libm::sinf`, which computes in double
//! precision, is several hundred instructions of software. These functions use single
//! precision and integers only, in a fixed order, so that they return the same bits on every
//! target.
//!
//! Polynomials follow S. L. Moshier's Cephes library; the reduction of arguments follows
//! W. J. Cody & W. Waite (1980) and, for large angles, M. H. Payne & R. N. Hanek (1983).
//! Greatest errors over all numbers, in units of the last place: sine and cosine 1.04 up to
//! 12 800 rad and 2.4 beyond, `exp` 1.0, `exp_m1` 1.6 (`examples/single_precision.rs`
//! measures them); `tanh` 2.5 over a sample.

/// 1.5 · 2^23: a small number that is added to it is rounded to an integer, in the low bits.
const TO_INTEGER: f32 = 12_582_912.0;

/// π/2 in four parts of few bits: up to [`MEDIUM_MAX`] the products of the first three with
/// the number of quarter turns are exact.
const QUARTER_TURN: [f32; 4] = [1.570_312_5, 4.837_513e-4, 7.549_533_6e-8, 2.563_344e-12];

/// π/2 less its value in single precision.
const FRAC_PI_2_LOST: f32 = -4.371_139e-8;

/// Greatest angle that is reduced by parts of π/2, rad: less than 2^13 quarter turns.
const MEDIUM_MAX: f32 = 12_800.0;

/// 2/π in words of 32 bits, after one word of zeros.
const TWO_OVER_PI: [u32; 8] = [
    0,
    0xa2f9_836e,
    0x4e44_1529,
    0xfc27_57d1,
    0xf534_ddc0,
    0xdb62_9599,
    0x3c43_9041,
    0xfe51_63ab,
];

/// ln 2 in two parts: the product of the first with the exponent of a number is exact.
const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];

/// An angle less the nearest number of quarter turns.
struct Reduced {
    /// The angle, and what its rounding lost, rad.
    angle: f32,
    lost: f32,
    /// The low bits of the number of quarter turns.
    quarters: u32,
}

/// Sine of an angle in radians.
pub(super) fn sin(x: f32) -> f32 {
    let reduced = reduced(x);
    reduced.sine_after(reduced.quarters)
}

/// Cosine of an angle in radians.
pub(super) fn cos(x: f32) -> f32 {
    let reduced = reduced(x);
    reduced.sine_after(reduced.quarters.wrapping_add(1))
}

/// Sine and cosine of an angle in radians: the bits of [`sin`] and [`cos`].
pub(super) fn sin_cos(x: f32) -> (f32, f32) {
    let reduced = reduced(x);
    let (sine, cosine) = (reduced.sine(), reduced.cosine());
    match reduced.quarters & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

impl Reduced {
    /// Sine of the angle plus a number of quarter turns.
    fn sine_after(&self, quarters: u32) -> f32 {
        let value = if quarters & 1 == 0 {
            self.sine()
        } else {
            self.cosine()
        };
        if quarters & 2 == 0 { value } else { -value }
    }

    fn sine(&self) -> f32 {
        let r = self.angle;
        // Cubes vanish beside one; the sign of zero and subnormal numbers remain.
        if r.abs() < 2.441_406_3e-4 {
            return r + self.lost;
        }
        let z = r * r;
        let cube = r * z * (-1.666_665_5e-1 + z * (8.332_161e-3 + z * -1.951_529_6e-4));
        r + (cube + self.lost)
    }

    fn cosine(&self) -> f32 {
        let z = self.angle * self.angle;
        let tail = z * z * (4.166_664_6e-2 + z * (-1.388_731_6e-3 + z * 2.443_315_7e-5));
        1.0 - (0.5 * z - (tail - self.angle * self.lost))
    }
}

/// The angle less the nearest number of quarter turns.
fn reduced(x: f32) -> Reduced {
    // A lost part of -0 leaves the sign of zero.
    let exact = |angle, quarters| Reduced {
        angle,
        lost: -0.0,
        quarters,
    };
    let magnitude = x.abs();
    if magnitude <= core::f32::consts::FRAC_PI_4 {
        return exact(x, 0);
    }
    if magnitude <= MEDIUM_MAX {
        let shifted = x * core::f32::consts::FRAC_2_PI + TO_INTEGER;
        let turns = shifted - TO_INTEGER;
        let [a, b, c, d] = QUARTER_TURN;
        let coarse = (x - turns * a) - turns * b;
        let angle = coarse - turns * c;
        return Reduced {
            angle,
            lost: ((coarse - angle) - turns * c) - turns * d,
            quarters: shifted.to_bits(),
        };
    }
    if !x.is_finite() {
        return exact(f32::NAN, 0);
    }
    let (turn, quarters) = reduced_large(magnitude.to_bits());
    let (turn, quarters) = if x < 0.0 {
        (-turn, quarters.wrapping_neg())
    } else {
        (turn, quarters)
    };
    Reduced {
        angle: turn * core::f32::consts::FRAC_PI_2,
        lost: turn * FRAC_PI_2_LOST,
        quarters,
    }
}

/// The angle with these bits in quarter turns, less the nearest number of them, and the low
/// bits of that number: in integers, with those bits of 2/π that do not give whole turns.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)]
fn reduced_large(bits: u32) -> (f32, u32) {
    let mantissa = u64::from((bits & 0x007f_ffff) | 0x0080_0000);
    // x = mantissa · 2^(exponent - 150); the first bit of 2/π that counts has the weight
    // 2^(151 - exponent). The word of zeros is 32 bits before the binary point.
    let first = (bits >> 23).saturating_sub(152 - 32);
    let (word, shift) = ((first >> 5) as usize, first & 31);
    let at = |i: usize| TWO_OVER_PI.get(word + i).copied().unwrap_or(0);
    let window = |i: usize| {
        let pair = u64::from(at(i)) << 32 | u64::from(at(i + 1));
        (pair << shift) >> 32
    };
    // The product in units of 2^-62 quarter turns, without multiples of four.
    let turns = (mantissa.wrapping_mul(window(0)) << 32)
        .wrapping_add(mantissa.wrapping_mul(window(1)))
        .wrapping_add(mantissa.wrapping_mul(window(2)) >> 32);
    let quarters = (turns.wrapping_add(1 << 61) >> 62) as u32;
    let rest = turns.wrapping_sub(u64::from(quarters) << 62).cast_signed();
    // The leading 32 bits, as an integer that single precision rounds once.
    let lead = rest
        .unsigned_abs()
        .leading_zeros()
        .saturating_sub(1)
        .min(62);
    let high = ((rest << lead) >> 32) as i32;
    let scale = f32::from_bits((127 - 30 - lead) << 23);
    (high as f32 * scale, quarters)
}

/// Exponential function.
pub(super) fn exp(x: f32) -> f32 {
    // Beyond these the result is infinite or zero; NaN passes.
    if x > 88.722_84 {
        return f32::INFINITY;
    }
    if x < -103.972_08 {
        return 0.0;
    }
    let (rise, exponent) = exponential_parts(x);
    // Two factors, because 2^128 and subnormal powers are not a single one.
    let half = exponent >> 1;
    (rise + 1.0) * power_of_two(half) * power_of_two(exponent - half)
}

/// `exp(x) - 1` without loss of digits near zero.
pub(super) fn exp_m1(x: f32) -> f32 {
    // The exponent is 128 above, and the result -1 below.
    if x > 88.0 {
        return exp(x) - 1.0;
    }
    if x < -18.0 {
        return -1.0;
    }
    let (rise, exponent) = exponential_parts(x);
    let scale = power_of_two(exponent);
    scale * rise + (scale - 1.0)
}

/// Hyperbolic tangent.
pub(super) fn tanh(x: f32) -> f32 {
    // exp(-2|x|) - 1 is in (-1, 0]: nothing cancels or overflows.
    let fall = exp_m1(-2.0 * x.abs());
    let magnitude = -fall / (fall + 2.0);
    if x < 0.0 { -magnitude } else { magnitude }
}

/// `exp(r) - 1` and k, with `x = r + k ln 2` and |r| at most half of ln 2.
#[allow(clippy::cast_possible_wrap)]
fn exponential_parts(x: f32) -> (f32, i32) {
    let shifted = x * core::f32::consts::LOG2_E + TO_INTEGER;
    let k = shifted - TO_INTEGER;
    let exponent = shifted.to_bits().wrapping_sub(TO_INTEGER.to_bits()) as i32;
    let r = (x - k * LN_2[0]) - k * LN_2[1];
    let tail = 4.166_579_6e-2 + r * (8.333_452e-3 + r * (1.398_2e-3 + r * 1.987_569_2e-4));
    let curve = 0.5 + r * (1.666_666_5e-1 + r * tail);
    (r + r * r * curve, exponent)
}

/// 2^k for k in [-126, 127].
#[allow(clippy::cast_sign_loss)]
fn power_of_two(k: i32) -> f32 {
    f32::from_bits(((k + 127) as u32) << 23)
}

/// The smaller value; a NaN operand is ignored. Comparisons in place of `fminf`, which is a call
/// on a Cortex-M4F.
pub(super) fn least(a: f32, b: f32) -> f32 {
    if b < a || a.is_nan() { b } else { a }
}

/// The larger value; a NaN operand is ignored.
pub(super) fn greatest(a: f32, b: f32) -> f32 {
    if a < b || a.is_nan() { b } else { a }
}

/// The value in double precision, by its bits: no instruction or routine of double
/// precision is linked for it.
pub(super) fn widened(x: f32) -> f64 {
    let bits = u64::from(x.to_bits());
    let (sign, exponent, fraction) = (bits >> 31, (bits >> 23) & 0xff, bits & 0x007f_ffff);
    let (exponent, fraction) = match exponent {
        0 if fraction == 0 => (0, 0),
        0 => {
            // Subnormal numbers of single precision are normal ones of double precision.
            let shift = u64::from(fraction.leading_zeros()) - 40;
            (897 - shift, (fraction << shift) & 0x007f_ffff)
        }
        0xff => (0x7ff, fraction),
        _ => (exponent + 896, fraction),
    };
    f64::from_bits(sign << 63 | exponent << 52 | fraction << 29)
}

#[cfg(test)]
mod tests {
    use super::{MEDIUM_MAX, cos, exp, exp_m1, greatest, least, sin, sin_cos, tanh, widened};

    /// Error of `found` in units of the last place of single precision, at least those of
    /// the least normal number.
    fn ulps(found: f32, exact: f64) -> f64 {
        let exponent = (exact.to_bits() >> 52 & 0x7ff).max(1023 - 126);
        let unit = f64::from_bits((exponent - 23) << 52);
        (f64::from(found) - exact).abs() / unit
    }

    fn all(step: usize) -> impl Iterator<Item = f32> {
        let positive = (0..f32::INFINITY.to_bits()).step_by(step);
        positive.flat_map(|bits| [f32::from_bits(bits), -f32::from_bits(bits)])
    }

    /// The errors that the module states: sine and cosine up to [`MEDIUM_MAX`] and beyond,
    /// [`exp`], [`exp_m1`].
    const STATED: [f64; 4] = [1.04, 2.4, 1.0, 1.6];

    fn angle_error(x: f32) -> f64 {
        let wide = f64::from(x);
        ulps(sin(x), libm::sin(wide)).max(ulps(cos(x), libm::cos(wide)))
    }

    /// The greatest errors over a sample of all numbers, in the order of [`STATED`].
    fn greatest_errors() -> [f64; 4] {
        let mut worst = [0.0_f64; 4];
        // A prime, so that all low bits occur.
        for x in all(1009) {
            let wide = f64::from(x);
            let far = usize::from(x.abs() > MEDIUM_MAX);
            worst[far] = worst[far].max(angle_error(x));
            // Results that are subnormal or infinite have their own test.
            if (-87.3..88.72).contains(&x) {
                worst[2] = worst[2].max(ulps(exp(x), libm::exp(wide)));
                worst[3] = worst[3].max(ulps(exp_m1(x), libm::expm1(wide)));
            }
        }
        worst
    }

    #[test]
    fn analytic_errors_are_within_those_stated() {
        let found = greatest_errors();
        for (found, stated) in found.into_iter().zip(STATED) {
            assert!(found <= stated, "{found:?} {stated:?}");
        }
    }

    #[test]
    fn analytic_angles_nearest_to_quarter_turns() {
        // Where the reduction cancels most: the numbers beside each multiple of π/2.
        for k in 1..40_000 {
            #[allow(clippy::cast_possible_truncation)]
            let near = (f64::from(k) * core::f64::consts::FRAC_PI_2) as f32;
            for x in [near.next_down(), near, near.next_up(), -near] {
                let stated = STATED[usize::from(x.abs() > MEDIUM_MAX)];
                assert!(angle_error(x) <= stated, "{x}");
            }
        }
    }

    #[test]
    fn analytic_ends_of_the_range() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(sin(x).is_nan() && cos(x).is_nan());
        }
        assert!(exp(f32::NAN).is_nan() && exp_m1(f32::NAN).is_nan());
        assert!(exp(f32::INFINITY) == f32::INFINITY && exp_m1(f32::INFINITY) == f32::INFINITY);
        assert!(exp(f32::NEG_INFINITY) == 0.0 && exp_m1(f32::NEG_INFINITY) == -1.0);
        assert!(exp(88.73) == f32::INFINITY && exp(88.722) < f32::INFINITY);
        assert!(exp(-103.9) > 0.0 && exp(-104.0) == 0.0);
        assert!(exp(0.0) == 1.0 && exp_m1(0.0) == 0.0 && cos(0.0) == 1.0);
        assert!(sin(-0.0).is_sign_negative());
        // Subnormal results: one rounding, of half of the least number.
        let least = f64::from(f32::from_bits(1));
        for x in [-88.0_f32, -95.5, -100.25, -103.5] {
            let error = (f64::from(exp(x)) - libm::exp(f64::from(x))).abs();
            assert!(error <= 2.0 * least, "{x}");
        }
    }

    #[test]
    fn analytic_sine_and_cosine_together_are_the_same_bits() {
        for x in all(100_003) {
            let (sine, cosine) = sin_cos(x);
            assert_eq!(sine.to_bits(), sin(x).to_bits());
            assert_eq!(cosine.to_bits(), cos(x).to_bits());
        }
    }

    #[test]
    fn analytic_tanh_is_within_its_error() {
        for x in all(1009).filter(|x| x.is_finite()) {
            assert!(ulps(tanh(x), libm::tanh(f64::from(x))) <= 2.5, "{x}");
        }
        assert!(tanh(f32::INFINITY) == 1.0 && tanh(f32::NEG_INFINITY) == -1.0);
        assert!(tanh(f32::NAN).is_nan());
    }

    #[test]
    fn analytic_the_smaller_and_the_larger_are_those_of_the_standard_library() {
        let ends = [0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0, -1.0];
        for a in all(100_003).chain(ends) {
            for b in ends.into_iter().chain([a, -a, a.next_up()]) {
                // Equal numbers, zeros of either sign among them, may be either.
                let same = |x: f32, y: f32| x == y || x.is_nan() && y.is_nan();
                assert!(same(least(a, b), a.min(b)), "{a} {b}");
                assert!(same(greatest(a, b), a.max(b)), "{a} {b}");
            }
        }
    }

    #[test]
    fn analytic_widening_is_exact() {
        let ends = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY];
        let small = (0..100).map(|k| f32::from_bits(1 << (k % 24) | k));
        for x in all(10_007).chain(ends).chain(small) {
            assert_eq!(widened(x).to_bits(), f64::from(x).to_bits());
        }
        assert!(widened(f32::NAN).is_nan());
    }
}
