//! How much of a rising lift a descent takes back.

use touchdown_flight::ground_effect::Lift;
use touchdown_flight::real::Real;

/// The lift to count after `last`, while the lift itself is `now`: its ratio and its force follow a fall at once, and of a
/// rise only `share`, 0 to 1.
///
/// Lift that is not counted stays as a force up. With the share of a lag of `rise_s` a descent at ż is left
/// `-ż ∂f/∂z rise_s`: the air brakes a vehicle that comes down faster than planned. A vehicle that counts all lift at once has
/// taken this brake away.
pub(crate) fn counted<R: Real>(last: Lift<R>, now: Lift<R>, share: R) -> Lift<R> {
    let follow = |last: R, now: R| {
        if now > last && share < R::ONE {
            last + (now - last) * share
        } else {
            now
        }
    };
    Lift {
        ratio: follow(last.ratio, now.ratio),
        force_n: follow(last.force_n, now.force_n),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use touchdown_flight::kernel::lag_share;

    const DT: f64 = 0.01;

    fn lift(ratio: f64, force_n: f64) -> Lift<f64> {
        Lift { ratio, force_n }
    }

    #[test]
    fn analytic_a_rise_is_counted_late_and_a_fall_at_once() {
        // A step up: 1 - exp(-1) of it after one time constant.
        let mut now = lift(0.0, 1.0);
        for _ in 0..20 {
            now = counted(now, lift(0.1, 3.0), lag_share(0.2, DT));
        }
        let share = 1.0 - (-1.0_f64).exp();
        // The exact step of a lag, 20 times: roundings.
        assert!((now.ratio - 0.1 * share).abs() < 1e-14, "{}", now.ratio);
        assert!((now.force_n - 1.0 - 2.0 * share).abs() < 1e-13);
        // Ratio and force go each for itself.
        let next = counted(now, lift(0.0, 3.0), lag_share(0.2, DT));
        assert_eq!(next.ratio, 0.0);
        assert!(next.force_n > now.force_n && next.force_n < 3.0);
        // Of a whole share nothing is late, and of none nothing is counted.
        assert_eq!(counted(now, lift(0.1, 3.0), 1.0), lift(0.1, 3.0));
        assert_eq!(counted(now, lift(0.1, 3.0), 0.0), now);
    }

    #[test]
    fn analytic_what_is_not_counted_brakes_a_descent() {
        // A lift that rises at 2 N/s is counted 0.2 s late: 0.4 N.
        let mut last = lift(0.0, 0.0);
        for k in 0..1000 {
            last = counted(last, lift(0.0, 2.0 * DT * f64::from(k)), lag_share(0.2, DT));
        }
        let left_n = 2.0 * DT * 999.0 - last.force_n;
        // A lag in steps of 0.01 s: 0.01 s less or more.
        assert!((left_n - 0.4).abs() < 2.0 * DT, "{left_n}");
    }
}
