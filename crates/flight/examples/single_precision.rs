//! The greatest errors of the elementary functions in single precision over all numbers, against `libm` in double precision:
//! `cargo run --release -p touchdown-flight --example single_precision`. Some minutes.

#![allow(clippy::print_stdout)]

use touchdown_flight::Real;

/// Error of `found` in units of the last place of single precision, at least those of the least normal number.
fn ulps(found: f32, exact: f64) -> f64 {
    let exponent = (exact.to_bits() >> 52 & 0x7ff).max(1023 - 126);
    let unit = f64::from_bits((exponent - 23) << 52);
    (f64::from(found) - exact).abs() / unit
}

fn main() {
    let names = ["sin, cos to 12 800 rad", "sin, cos beyond", "exp", "exp_m1"];
    let mut worst = [0.0_f64; 4];
    for bits in 0..f32::INFINITY.to_bits() {
        for x in [f32::from_bits(bits), -f32::from_bits(bits)] {
            let wide = f64::from(x);
            let (sin, cos) = Real::sin_cos(x);
            let far = usize::from(x.abs() > 12_800.0);
            let angle = ulps(sin, libm::sin(wide)).max(ulps(cos, libm::cos(wide)));
            worst[far] = worst[far].max(angle);
            // Other results are subnormal or infinite.
            if (-87.3..88.72).contains(&x) {
                worst[2] = worst[2].max(ulps(Real::exp(x), libm::exp(wide)));
                worst[3] = worst[3].max(ulps(Real::exp_m1(x), libm::expm1(wide)));
            }
        }
    }
    for (name, error) in names.iter().zip(worst) {
        println!("{name}: {error:.3} units of the last place");
    }
}
