//! What a model of flights has, and the numbers that are fitted.

use serde::Serialize;

use super::curve::Curve;

/// What a model has beside the scales of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModelTerms {
    /// What is known beforehand of the elasticity dlnT/dlns: its value and standard deviation.
    pub exponent: [f64; 2],
    /// Motor lag and dead time.
    pub motor_lag: bool,
    /// Motors whose load goes partly with the square of their speed.
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
    /// Motors and climb damping, and a curve at rest.
    #[must_use]
    pub fn plain(curve: Curve, damping: bool, motor_lag: bool) -> Self {
        Self {
            exponent: [1.5, 1.0],
            motor_lag,
            drag: motor_lag,
            curvature: false,
            settling: false,
            battery: false,
            damping,
            near_damping: false,
            curve,
            wake_lag: false,
            fountain_lag: false,
        }
    }

    /// The numbers to fit, in the order of their values.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let [start, sd] = self.exponent;
        let mut out = vec![p("elasticity", "1", start, [0.2, 4.0], sd)];
        if self.motor_lag {
            out.push(p("T_m", "s", 0.06, [0.002, 1.0], 0.1));
            out.push(p("dead_time", "s", 0.01, [0.0, 0.2], 0.05));
        }
        if self.drag {
            out.push(p("drag", "1", 0.5, [0.0, 1.0], 0.3));
        }
        if self.curvature {
            out.push(p("curvature", "1", 0.0, [-3.0, 3.0], 0.5));
        }
        if self.settling {
            out.push(p("settling", "1", -0.03, [-0.5, 0.5], 0.2));
            out.push(p("settling_time", "s", 1.0, [0.2, 10.0], 1.0));
        }
        if self.battery {
            out.push(p("battery", "1/V", 0.0, [-1.0, 1.0], 0.3));
        }
        if self.damping {
            out.push(p("damping", "s/m", 0.03, [-1.0, 2.0], 0.2));
        }
        if self.near_damping {
            out.push(p("near_damping", "s/m", 0.0, [-2.0, 2.0], 0.2));
        }
        match self.curve {
            Curve::Free => {}
            Curve::Exponential => {
                out.push(p("amplitude", "1", 0.1, [-1.0, 2.0], 0.3));
                out.push(p("length", "R", 2.0, [0.2, 10.0], 3.0));
            }
            Curve::Empirical => {
                out.push(p("mu", "1", 1.5, [-5.0, 30.0], 5.0));
                out.push(p("rotor_offset", "R", 0.5, [0.0, 4.0], 1.0));
            }
            Curve::Rational => {
                out.push(p("h1", "1", 0.03, [-1.0, 1.0], 0.15));
                out.push(p("h2", "1", 0.05, [-1.0, 1.0], 0.15));
                out.push(p("h3", "1", 0.03, [-1.0, 1.0], 0.15));
            }
            // Neighbours 2.2 to 3.5 R apart, rotors in the plane of which the height is measured or up to R above it.
            Curve::Images => {
                out.push(p("images", "1", 1.0, [-5.0, 10.0], 1.0));
                out.push(p("fountain", "1", 0.3, [-3.0, 5.0], 0.5));
                out.push(p("fountain_distance", "R", 1.9, [0.8, 5.0], 0.4));
                out.push(p("rotor_offset", "R", 0.5, [0.0, 4.0], 0.5));
            }
        }
        if self.wake_lag {
            out.push(p("tau", "s", 0.1, [0.005, 2.0], 0.5));
        }
        if self.fountain_lag {
            out.push(p("fountain_tau", "s", 0.2, [0.005, 2.0], 0.5));
        }
        out
    }
}
