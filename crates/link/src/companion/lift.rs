//! Whether the accelerometer feels the motors.
//!
//! In flight an accelerometer feels the force of the rotors. One that feels next to nothing of it, or a force downwards, while the
//! motors carry the vehicle is wrong: the estimate falls, and the landing computer climbs at full thrust. Where it is right, the
//! motors have failed.

/// Share of the hover throttle above which the motors carry the vehicle: two thirds of its weight. At less, a vehicle that is let
/// sink may feel as little as [`FELT`].
const CARRIES: f64 = 0.8;
/// Least specific force along the rotors of a vehicle that is carried, as a share of gravity: half of what the motors give at least.
const FELT: f64 = 0.3;
/// Time constant over which the specific force is averaged, s. Vibration has zero mean over it.
const AVERAGE_S: f64 = 0.1;
/// Time for which the force may be missing, µs. After a command at idle the average of motors with a lag of 0.12 s is at 0.4 by then.
const LONGEST_US: i64 = 250_000;

/// How long the accelerometer has not felt the motors.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lift {
    /// The averaged specific force along the rotors as a share of gravity, and the time of the newest reading.
    average: Option<(f64, i64)>,
    missing_since_us: Option<i64>,
}

impl Lift {
    /// A specific force along the rotors (a share of gravity) while this throttle (a share of that in hover) was commanded.
    pub(super) fn feels(&mut self, load: f64, throttle: f64, now_us: i64) {
        // Values that are not finite are those of a sensor that is not fresh, which is judged elsewhere.
        if !load.is_finite() {
            return;
        }
        let (average, then_us) = self.average.unwrap_or((1.0, now_us));
        let weight = 1.0 - (-((now_us - then_us) as f64) * 1e-6 / AVERAGE_S).exp();
        let average = average + weight * (load - average);
        self.average = Some((average, now_us));
        self.missing_since_us = if throttle > CARRIES && average < FELT {
            self.missing_since_us.or(Some(now_us))
        } else {
            None
        };
    }

    /// Whether it is missing for so long that the accelerometer, or a motor, must have failed.
    pub(super) fn is_missing(&self, now_us: i64) -> bool {
        self.missing_since_us
            .is_some_and(|since| now_us - since > LONGEST_US)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the force is missing after a second of `load` at `throttle`, each a function of time in seconds.
    fn missing(load: impl Fn(f64) -> f64, throttle: impl Fn(f64) -> f64) -> bool {
        let mut lift = Lift::default();
        (0..100).any(|tick| {
            let time_s = 0.01 * f64::from(tick);
            let now_us = 10_000 * i64::from(tick);
            lift.feels(load(time_s), throttle(time_s), now_us);
            lift.is_missing(now_us)
        })
    }

    #[test]
    fn prop_only_a_force_that_stays_away_while_the_motors_carry_is_missing() {
        let carried = |_| 1.0;
        // Zero, upside down, and zero with vibration of one g.
        assert!(missing(|_| 0.0, carried));
        assert!(missing(|_| -1.0, carried));
        assert!(missing(|time_s| (200.0 * time_s).sin(), carried));
        // A hover with vibration, free fall at idle, a sensor that says nothing.
        assert!(!missing(|time_s| 1.0 + (200.0 * time_s).sin(), carried));
        assert!(!missing(|_| 0.0, |_| 0.3));
        assert!(!missing(|_| f64::NAN, carried));
    }

    #[test]
    fn analytic_slow_motors_that_start_from_idle_are_waited_for() {
        // Thrust of motors with a lag of 0.12 s that are commanded 0.8 of the hover throttle after free fall: 0.64 of the weight.
        let load = |time_s: f64| match time_s < 0.4 {
            true => 0.0,
            false => 0.64 * (1.0 - (-(time_s - 0.4) / 0.12).exp()),
        };
        let throttle = |time_s: f64| if time_s < 0.4 { 0.1 } else { 0.81 };
        assert!(!missing(load, throttle));
    }
}
