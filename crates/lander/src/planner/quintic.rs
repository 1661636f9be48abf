//! The greatest speed and acceleration of the quintic descent.

use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::Terminal;

/// Greatest rate of descent and greatest acceleration (either way) of a
/// reference, m/s and m/s².
///
/// With D the height descended, T the duration and `w = v_s T / D` in [0, 2.5],
///
/// ```text
/// -z'  = D/T  u² ((30 - 12 w) - (60 - 28 w) u + (30 - 15 w) u²)
/// -z'' = D/T² u  ((60 - 24 w) - (180 - 84 w) u + (120 - 60 w) u²)
/// ```
///
/// z'' vanishes at u = 0, at u = 1 and at `u = (1 - 0.4 w) / (2 - w)`, where the speed
/// is greatest if that is before the end; z''' vanishes at the roots of
/// `(5 - 2 w) - (30 - 14 w) u + (30 - 15 w) u²`.
pub(super) fn peaks<R: Real>(reference: &Terminal<R>) -> (R, R) {
    let n = r::<R>;
    let drop_m = reference.start_height_m - reference.end_height_m;
    let t = reference.duration_s;
    let w = reference.sink_rate_mps * t / drop_m;
    let speed = |u: R| {
        let [a, b, c] = [
            n(30.0) - n(12.0) * w,
            n(60.0) - n(28.0) * w,
            n(30.0) - n(15.0) * w,
        ];
        u * u * (a - u * (b - u * c))
    };
    let fastest = ((R::ONE - n(0.4) * w) / (n(2.0) - w)).finite_or(R::ONE);
    let greatest_speed = if fastest > R::ZERO && fastest < R::ONE {
        speed(fastest).max(w)
    } else {
        w
    };
    let acceleration = |u: R| {
        let [a, b, c] = [
            n(60.0) - n(24.0) * w,
            n(180.0) - n(84.0) * w,
            n(120.0) - n(60.0) * w,
        ];
        (u * (a - u * (b - u * c))).abs()
    };
    // c - b u + a u² = 0, solved without cancellation: b > 0 for w < 15/7, and beyond
    // that a < 0, so the root keeps its sign.
    let (a, b, c) = (
        n(30.0) - n(15.0) * w,
        n(30.0) - n(14.0) * w,
        n(5.0) - n(2.0) * w,
    );
    let root = (b * b - n(4.0) * a * c).max(R::ZERO).sqrt();
    let q = n(0.5) * if b < R::ZERO { b - root } else { b + root };
    let within = |u: R| u.finite_or(R::ZERO).clamp(R::ZERO, R::ONE);
    let greatest = acceleration(within(q / a)).max(acceleration(within(c / q)));
    (greatest_speed * drop_m / t, greatest * drop_m / (t * t))
}

#[cfg(test)]
mod tests {
    use super::peaks;
    use touchdown_flight::reference::Terminal;

    #[test]
    fn analytic_peaks_are_those_of_the_reference() {
        for w in [
            0.0,
            0.1,
            0.5,
            1.0,
            1.6,
            5.0 / 3.0,
            1.9,
            2.0,
            2.1,
            2.2,
            2.4,
            2.5,
        ] {
            let reference = Terminal {
                start_height_m: 0.8,
                end_height_m: 0.1,
                sink_rate_mps: w * 0.7 / 2.5,
                duration_s: 2.5,
            };
            reference.validate().unwrap();
            let (mut speed, mut acceleration) = (0.0_f64, 0.0_f64);
            for i in 0..=20_000 {
                let at = reference.at(2.5 * f64::from(i) / 20_000.0);
                speed = speed.max(-at.velocity_mps);
                acceleration = acceleration.max(at.acceleration_mps2.abs());
            }
            let (found_speed, found_acceleration) = peaks(&reference);
            // Samples miss a peak by its curvature, 20 D/T³ (1e-4 s)²/2 and 400 D/T⁴ of
            // the same.
            assert!(
                (found_speed - speed).abs() < 1e-7,
                "{w} {found_speed} {speed}"
            );
            assert!(
                (found_acceleration - acceleration).abs() < 1e-6,
                "{w} {found_acceleration} {acceleration}"
            );
        }
        // From rest to rest: 15/8 of the mean speed, 10/√3 D/T².
        let rest = Terminal {
            start_height_m: 1.0,
            end_height_m: 0.0,
            sink_rate_mps: 0.0,
            duration_s: 2.0,
        };
        let (speed, acceleration) = peaks::<f64>(&rest);
        assert!((speed - 15.0 / 16.0).abs() < 1e-15);
        // Differences of numbers up to 180 at most.
        assert!((acceleration - 10.0 / 3.0_f64.sqrt() / 4.0).abs() < 1e-13);
    }
}
