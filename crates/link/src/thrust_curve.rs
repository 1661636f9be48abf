//! The autopilot's own curve between its thrust setpoint and the signal of its motors.
//!
//! A thrust card maps a throttle in [0, 1] to thrust. That throttle is either the motors' signal (a card from a thrust
//! stand, or from a log of motor outputs) or the autopilot's thrust setpoint (a card from a log of setpoints). The two
//! differ by the curve below. `vehicle.throttle` in the settings names the side on which the card stands.
//!
//! With the motors' signal s and the setpoint u:
//!
//! * PX4: `u = f s² + (1 - f) s`, f being `THR_MDL_FAC`. The default f = 0 makes both sides equal.
//! * ArduPilot: `u = e x² + (1 - e) x` with `x = (s - s_min) / (s_max - s_min)`, e being `MOT_THST_EXPO`, s_min
//!   `MOT_SPIN_MIN` and s_max `MOT_SPIN_MAX`.

/// Curve of an autopilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustCurve {
    /// Share of the square, f or e.
    pub curvature: f64,
    /// Motor signal at a setpoint of zero.
    pub least_signal: f64,
    /// Motor signal at a setpoint of one.
    pub greatest_signal: f64,
}

impl ThrustCurve {
    /// The curve of PX4.
    #[must_use]
    pub fn px4(thr_mdl_fac: f64) -> Self {
        Self {
            curvature: thr_mdl_fac,
            least_signal: 0.0,
            greatest_signal: 1.0,
        }
    }

    /// The curve of ArduPilot.
    #[must_use]
    pub fn ardupilot(mot_thst_expo: f64, mot_spin_min: f64, mot_spin_max: f64) -> Self {
        Self {
            curvature: mot_thst_expo,
            least_signal: mot_spin_min,
            greatest_signal: mot_spin_max,
        }
    }

    /// The thrust setpoint that gives a motor signal, in [0, 1].
    #[must_use]
    pub fn setpoint(self, motor_signal: f64) -> f64 {
        let span = self.greatest_signal - self.least_signal;
        let x = ((motor_signal - self.least_signal) / span).clamp(0.0, 1.0);
        (self.curvature * x * x + (1.0 - self.curvature) * x).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The motor signal as the autopilots compute it from a setpoint, by the root of the quadratic.
    fn signal(curve: ThrustCurve, setpoint: f64) -> f64 {
        let f = curve.curvature;
        let x = if f < f64::EPSILON {
            setpoint
        } else {
            (f - 1.0 + ((1.0 - f) * (1.0 - f) + 4.0 * f * setpoint).sqrt()) / (2.0 * f)
        };
        curve.least_signal + x * (curve.greatest_signal - curve.least_signal)
    }

    #[test]
    fn analytic_the_autopilot_undoes_the_curve() {
        let curves = [
            ThrustCurve::px4(0.0),
            ThrustCurve::px4(0.3),
            ThrustCurve::px4(1.0),
            ThrustCurve::ardupilot(0.65, 0.15, 0.95),
        ];
        for curve in curves {
            for setpoint in [0.0, 0.1, 0.37, 0.5, 0.99, 1.0] {
                let back = curve.setpoint(signal(curve, setpoint));
                assert!(
                    (back - setpoint).abs() < 1e-12,
                    "{curve:?} {setpoint} {back}"
                );
            }
        }
    }

    #[test]
    fn analytic_without_curvature_px4_passes_the_signal_on() {
        assert_eq!(ThrustCurve::px4(0.0).setpoint(0.42), 0.42);
        // Half the signal at f = 0.5: 0.5 · 0.25 + 0.5 · 0.5.
        assert_eq!(ThrustCurve::px4(0.5).setpoint(0.5), 0.375);
        assert_eq!(ThrustCurve::ardupilot(0.65, 0.15, 0.95).setpoint(0.1), 0.0);
    }
}
