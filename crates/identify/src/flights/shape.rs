//! What a model of flights has, and the numbers that are fitted.

use serde::Serialize;

use super::curve::Curve;

/// Longest time by which a throttle may be logged after it acts (s), as long as the longest dead time. At 0.05 a log that was 0.08 s
/// late had a motor lag of 0.004 for 0.045 s; with 0.2 it is found to 1 ms, and later ones show no thrust that follows the throttle.
const LATEST_S: f64 = 0.2;

/// Longest latency of an accelerometer (s): logs without stamps of the sensor, and default low-pass filters, have 0.1 at most.
const LONGEST_LATENCY_S: f64 = 0.15;

/// What a model has beside the scales of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModelTerms {
    /// What is known beforehand of the elasticity dlnT/dlns: its value and standard deviation.
    pub exponent: [f64; 2],
    /// Motor lag and dead time.
    pub motor_lag: bool,
    /// Commands may act before they are logged.
    pub logged_late: bool,
    /// Motors whose load is partly proportional to the square of their speed.
    pub drag: bool,
    /// A second term of throttle.
    pub curvature: bool,
    /// Thrust settles after the motors start.
    pub settling: bool,
    /// Thrust follows the battery's voltage.
    pub battery: bool,
    /// Climb damping.
    pub damping: bool,
    /// Climb damping that grows towards the ground.
    pub near_damping: bool,
    /// The static curve.
    pub curve: Curve,
    /// Whether the ground effect lags.
    pub wake_lag: bool,
    /// Whether the fountain of [`Curve::Images`] has a lag of its own, and both go with the height.
    pub fountain_lag: bool,
    /// Whether the accelerometer has a latency against height and command.
    pub accelerometer_latency: bool,
}

/// A number that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// First guess.
    pub start: f64,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Weak knowledge beforehand: standard deviation about the first guess.
    pub prior_sd: f64,
}

const fn p(
    name: &'static str,
    unit: &'static str,
    start: f64,
    [min, max]: [f64; 2],
    prior_sd: f64,
) -> Parameter {
    Parameter {
        name,
        unit,
        start,
        min,
        max,
        prior_sd,
    }
}

impl ModelTerms {
    /// Motors, climb damping, and a steady curve.
    #[must_use]
    pub fn plain(curve: Curve, damping: bool, motor_lag: bool) -> Self {
        Self {
            exponent: [1.5, 1.0],
            motor_lag,
            logged_late: motor_lag,
            drag: motor_lag,
            curvature: false,
            settling: false,
            battery: false,
            damping,
            near_damping: false,
            curve,
            wake_lag: false,
            fountain_lag: false,
            accelerometer_latency: false,
        }
    }

    /// The numbers to fit, in the order of their values.
    ///
    /// Starts are the middle of what multirotors show. Prior standard deviations are at least as wide as what is plausible:
    /// they decide only where the data contain no information; a number known by its prior alone has an interval as wide.
    /// Bounds keep a step from where the model has no sense; a number at its bound is reported without an interval.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let [start, sd] = self.exponent;
        // Thrust goes with throttle to the power 1 (commands of thrust) to 2 (of speed); curvature and vibration widen that.
        let mut out = vec![p("elasticity", "1", start, [0.2, 4.0], sd)];
        if self.motor_lag {
            // Rotors of 5 to 30 cm: 0.02 to 0.2 s.
            out.push(p("T_m", "s", 0.06, [0.002, 1.0], 0.1));
            // Command line and accelerometer filter: some 10 ms, up to 0.1 s by telemetry.
            let least = if self.logged_late { -LATEST_S } else { 0.0 };
            out.push(p("dead_time", "s", 0.01, [least, 0.2], 0.05));
        }
        if self.drag {
            // A share of the load: 0 is friction alone, 1 drag alone.
            out.push(p("drag", "1", 0.5, [0.0, 1.0], 0.3));
        }
        if self.curvature {
            // Second order of √T in throttle: 0 without saturation, 0.5 would halve the slope within hover.
            out.push(p("curvature", "1", 0.0, [-3.0, 3.0], 0.5));
        }
        if self.settling {
            // Batteries and motors lose some per cent in the first seconds after the start.
            out.push(p("settling", "1", -0.03, [-0.5, 0.5], 0.2));
            out.push(p("settling_time", "s", 1.0, [0.2, 10.0], 1.0));
        }
        if self.battery {
            // Thrust goes with the square of voltage at most: 0.2 per volt on three cells; in 300 s it loses less than a third.
            out.push(p("battery", "1/V", 0.0, [-1.0, 1.0], 0.3));
        }
        if self.damping {
            // Momentum theory: 1/(2 v_i) = 0.03 to 0.1 s/m for small rotors.
            out.push(p("damping", "s/m", 0.03, [-1.0, 2.0], 0.2));
        }
        if self.near_damping {
            // No theory: as wide as the damping itself.
            out.push(p("near_damping", "s/m", 0.0, [-2.0, 2.0], 0.2));
        }
        match self.curve {
            Curve::Free => {}
            Curve::Exponential => {
                // Static curves end at 0.1 to 0.4 on the ground and fall over one to three radii.
                out.push(p("amplitude", "1", 0.1, [-1.0, 2.0], 0.3));
                out.push(p("length", "R", 2.0, [0.2, 10.0], 3.0));
            }
            Curve::Empirical => {
                // One rotor has mu = 1 (Cheeseman and Bennett); four have more, by their images.
                out.push(p("mu", "1", 1.5, [-5.0, 30.0], 5.0));
                out.push(p("rotor_offset", "R", 0.5, [0.0, 4.0], 1.0));
            }
            Curve::Rational => {
                // Together the amplitude of the curve, 0.1 to 0.4.
                out.push(p("h1", "1", 0.03, [-1.0, 1.0], 0.15));
                out.push(p("h2", "1", 0.05, [-1.0, 1.0], 0.15));
                out.push(p("h3", "1", 0.03, [-1.0, 1.0], 0.15));
            }
            // One image for each rotor, a fountain a third as strong. Neighbours 2.2 to 3.5 R apart, rotors in the plane of
            // which the height is measured or up to R above it.
            Curve::Images => {
                out.push(p("images", "1", 1.0, [-5.0, 10.0], 1.0));
                out.push(p("fountain", "1", 0.3, [-3.0, 5.0], 0.5));
                out.push(p("fountain_distance", "R", 1.9, [0.8, 5.0], 0.4));
                out.push(p("rotor_offset", "R", 0.5, [0.0, 4.0], 0.5));
            }
        }
        if self.wake_lag {
            // Wakes of small rotors: R over the wake's speed and a few times that, 0.05 to 0.5 s.
            out.push(p("tau", "s", 0.1, [0.005, 2.0], 0.5));
        }
        if self.fountain_lag {
            // The fountain has twice the way.
            out.push(p("fountain_tau", "s", 0.2, [0.005, 2.0], 0.5));
        }
        if self.accelerometer_latency {
            // Low-pass filters of autopilots: 3 to 20 ms, and up to 0.1 s by telemetry.
            let bounds = [0.0, LONGEST_LATENCY_S];
            out.push(p("accelerometer_latency", "s", 0.0, bounds, 0.05));
        }
        out
    }
}
