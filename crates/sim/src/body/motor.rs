//! The motors: throttle to thrust in free air, with battery sag.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::number::Number;

/// Settings of the motor law `J x' = s (1 - k s) - b x - c x²`, x = √T.
///
/// The inertia J is set through the time constant at hover,
/// `J = time_constant_s (b + 2 c √W)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotorSettings {
    /// Time constant of √T at hover, s.
    pub time_constant_s: f64,
    /// Linear loss b, throttle per √N.
    pub linear_loss: f64,
    /// Quadratic loss c, throttle per N.
    pub quadratic_loss: f64,
    /// Sag k: the share of voltage lost at full throttle, in [0, 0.5].
    pub sag: f64,
}

impl Default for MotorSettings {
    /// Losses and sag are fitted to the steady thrust of the paper's eq. (11): they agree
    /// within 0.03 N from throttle 0.3 to 1. The time constant has the order of hobby motors
    /// with electronic speed controllers, 0.03 to 0.1 s.
    fn default() -> Self {
        Self {
            time_constant_s: 0.06,
            linear_loss: 0.052_197_828_2,
            quadratic_loss: 0.013_332_785_4,
            sag: 0.490_793_060_9,
        }
    }
}

/// All four motors together: x = √T in √N, throttle s in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    inverse_inertia: f64,
    b: f64,
    c: f64,
    k: f64,
}

impl Motor {
    /// Checks the settings and builds the motors of a vehicle that hovers at
    /// `hover_thrust_n`.
    ///
    /// # Errors
    /// Times and losses must be positive; a sag above 0.5 would let thrust fall
    /// with throttle.
    pub fn new(settings: &MotorSettings, hover_thrust_n: f64) -> Result<Self, SimError> {
        check::positive("time_constant_s", settings.time_constant_s)?;
        check::positive("linear_loss", settings.linear_loss)?;
        check::positive("quadratic_loss", settings.quadratic_loss)?;
        check::within("sag", settings.sag, 0.0, 0.5)?;
        check::positive("hover_thrust_n", hover_thrust_n)?;
        let (b, c) = (settings.linear_loss, settings.quadratic_loss);
        let inertia = settings.time_constant_s * (b + 2.0 * c * hover_thrust_n.sqrt());
        Ok(Self {
            inverse_inertia: 1.0 / inertia,
            b,
            c,
            k: settings.sag,
        })
    }

    /// dx/dt at x = √T and throttle s.
    #[inline]
    #[must_use]
    pub fn derivative(&self, x: f64, s: f64) -> f64 {
        self.derivative_at_load(x, s, s)
    }

    /// dx/dt of one of several motors on the same battery, whose voltage sags with the
    /// mean throttle `load`: `J x' = s (1 - k load) - b x - c x²`. x is on the scale of
    /// the whole vehicle: √(4 T_i) for four motors.
    #[inline(always)]
    #[must_use]
    pub fn derivative_at_load<N: Number>(&self, x: N, s: N, load: N) -> N {
        self.derivative_under(x, self.drive(s, load))
    }

    /// The drive `s (1 - k load)` of one motor of several on the same battery.
    #[inline(always)]
    pub(crate) fn drive<N: Number>(&self, s: N, load: N) -> N {
        s * (1.0 - self.k * load)
    }

    /// dx/dt under a drive.
    #[inline(always)]
    pub(crate) fn derivative_under<N: Number>(&self, x: N, drive: N) -> N {
        (drive - self.b * x - self.c * x * x) * self.inverse_inertia
    }

    /// The drive `s (1 - k load) = b x + c x²` of the steady state x.
    #[inline]
    #[must_use]
    pub fn drive_for<N: Number>(&self, x: N) -> N {
        self.b * x + self.c * x * x
    }

    /// Sag k.
    #[must_use]
    pub fn sag(&self) -> f64 {
        self.k
    }

    /// √T in the steady state of the throttle s (clamped to [0, 1]).
    #[must_use]
    pub fn rest(&self, s: f64) -> f64 {
        let s = s.clamp(0.0, 1.0);
        let drive = s * (1.0 - self.k * s);
        ((self.b * self.b + 4.0 * self.c * drive).sqrt() - self.b) / (2.0 * self.c)
    }

    /// The throttle of the steady thrust `thrust_n`, clamped to [0, 1].
    #[must_use]
    pub fn throttle_for(&self, thrust_n: f64) -> f64 {
        self.throttle_for_drive(self.drive_for(thrust_n.max(0.0).sqrt()))
    }

    /// The throttle s with `s (1 - k s) = drive`, clamped to [0, 1].
    #[must_use]
    pub fn throttle_for_drive<N: Number>(&self, drive: N) -> N {
        // 2y/(1 + √(1 - 4ky)) is (1 - √(1 - 4ky))/(2k), also for k = 0.
        let root = (1.0 - 4.0 * self.k * drive).at_least(0.0).sqrt();
        (2.0 * drive / (1.0 + root)).within(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motor() -> Motor {
        Motor::new(&MotorSettings::default(), 13.4397).expect("defaults are valid")
    }

    #[test]
    fn analytic_rest_thrust() {
        // Reference values with four decimals.
        for (s, thrust_n) in [
            (0.2, 4.8798),
            (0.4869, 13.4397),
            (0.8, 19.2614),
            (1.0, 20.4764),
        ] {
            let x = motor().rest(s);
            // The printed throttle 0.4869 is rounded: dT/ds ≈ 25 N gives 1.3e-3.
            let tolerance = if s == 0.4869 { 1.3e-3 } else { 5.1e-5 };
            assert!((x * x - thrust_n).abs() < tolerance, "{s}: {}", x * x);
        }
    }

    #[test]
    fn analytic_step_of_throttle() {
        let motor = motor();
        let (start, end) = (motor.rest(0.4869), motor.rest(0.55));
        // Riccati equation with the roots `end` and `other`:
        // (x - end)/(x - other) decays at the rate c (end - other)/J.
        let other = -motor.b / motor.c - end;
        let rate = motor.c * (end - other) * motor.inverse_inertia;
        let exact = |t: f64| {
            let r = (start - end) / (start - other) * (-rate * t).exp();
            (end - other * r) / (1.0 - r)
        };
        let mut x = [start];
        for i in 1..=200 {
            x = crate::number::rk4::step(&x, 0.001, |_, x| [motor.derivative(x[0], 0.55)]);
            // Order four at a step of 1/60 of the time constant: (1/60)^5 a step.
            assert!((x[0] - exact(f64::from(i) * 0.001)).abs() < 1e-9);
        }
        // Reference values with three decimals.
        for (t, thrust_n) in [(0.05, 14.308), (0.2, 14.919), (10.0, 14.969)] {
            assert!((exact(t).powi(2) - thrust_n).abs() < 5.1e-4);
        }
        // On the steep part the reference, stepped at 1 ms to first order, is one unit of its last digit off.
        assert!((exact(0.1).powi(2) - 14.688).abs() < 1e-3);
    }

    #[test]
    fn prop_throttle_is_the_inverse_of_rest() {
        let without_sag = MotorSettings {
            sag: 0.0,
            ..MotorSettings::default()
        };
        for motor in [
            motor(),
            Motor::new(&without_sag, 13.4397).expect("valid settings"),
        ] {
            for i in 0..=100 {
                let s = f64::from(i) / 100.0;
                let x = motor.rest(s);
                // Rounding only; the root is flat near s = 1, hence not 1e-15.
                assert!((motor.throttle_for(x * x) - s).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn prop_bad_settings_name_key_and_number() {
        let settings = MotorSettings {
            sag: 0.7,
            ..MotorSettings::default()
        };
        let message = Motor::new(&settings, 13.4)
            .map(|_| ())
            .expect_err("a sag of 0.7 is not monotone")
            .to_string();
        assert!(
            message.contains("sag") && message.contains("0.7"),
            "{message}"
        );
    }
}
