//! The inertial unit: specific force, attitude and rates.

use serde::{Deserialize, Serialize};

use touchdown_flight::Attitude;
use touchdown_lander::estimate::relative::ImuSample;

use super::history::History;
use super::schedule::Wander;
use super::suite::{NanReadings, nan_if, steps, vector};
use crate::STEP_S;
use crate::body::rigid::RigidState;
use crate::check;
use crate::error::SimError;
use crate::number::vector::{add, along, normalised, product, scale};
use crate::random::{Purpose, Stream};

/// Steps between two samples of the inertial unit in a log: 250 Hz, as autopilots log.
pub(crate) const LOG_STEPS: u64 = 4;

/// Inertial unit and its attitude estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImuSettings {
    /// Specific force, white noise, m/s²/√Hz.
    pub noise_density: f64,
    /// Specific force, bias on each axis, constant over a landing: standard deviation, m/s².
    pub bias_sd_mps2: f64,
    /// Age of specific force and attitude when the landing computer gets them, s.
    pub latency_s: f64,
    /// Error of roll and pitch, constant over a landing: standard deviation, rad.
    pub tilt_bias_sd_rad: f64,
    /// Slowly varying error of roll and pitch, standard deviation, rad.
    pub tilt_wander_sd_rad: f64,
    /// Correlation time of the slowly varying error, s.
    pub tilt_wander_s: f64,
    /// Error of heading, constant over a landing: standard deviation, rad.
    pub yaw_bias_sd_rad: f64,
    /// White noise of the rates in a step of the attitude control, rad/s.
    pub gyro_sd: f64,
}

impl Default for ImuSettings {
    /// A MEMS unit on a vibrating airframe, by order of magnitude.
    ///
    /// - Noise 0.015 m/s²/√Hz: 0.15 m/s² over 10 ms, ten times a data sheet's noise, for
    ///   the vibration of the rotors.
    /// - Bias 0.03 m/s², which remains after calibration; latency 20 ms of filters and bus.
    /// - Errors of the attitude: 5 mrad of tilt, 2 mrad varying within 1 s, 20 mrad of
    ///   heading; rates 10 mrad/s.
    fn default() -> Self {
        Self {
            noise_density: 0.015,
            bias_sd_mps2: 0.03,
            latency_s: 0.02,
            tilt_bias_sd_rad: 0.005,
            tilt_wander_sd_rad: 0.002,
            tilt_wander_s: 1.0,
            yaw_bias_sd_rad: 0.02,
            gyro_sd: 0.01,
        }
    }
}

impl ImuSettings {
    pub(super) fn validate(&self) -> Result<(), SimError> {
        check::not_negative("noise_density", self.noise_density)?;
        check::not_negative("bias_sd_mps2", self.bias_sd_mps2)?;
        check::within("latency_s", self.latency_s, 0.0, 0.1)?;
        check::within("tilt_bias_sd_rad", self.tilt_bias_sd_rad, 0.0, 0.2)?;
        check::within("tilt_wander_sd_rad", self.tilt_wander_sd_rad, 0.0, 0.2)?;
        check::positive("tilt_wander_s", self.tilt_wander_s)?;
        check::within("yaw_bias_sd_rad", self.yaw_bias_sd_rad, 0.0, 1.0)?;
        check::not_negative("gyro_sd", self.gyro_sd)
    }
}

/// The inertial unit during one landing.
pub(crate) struct InertialUnit {
    settings: ImuSettings,
    /// Steps of a control period; a sample is their mean.
    control_steps: usize,
    stream: Stream,
    bias_mps2: [f64; 3],
    /// Latency of the unit, in steps.
    latency_steps: usize,
    /// Specific forces in body axes, and attitudes.
    forces_mps2: History<[f64; 3]>,
    attitudes: History<[f64; 4]>,
    attitude: Stream,
    tilt_wander: [Wander; 2],
    /// Error of the attitude, a small rotation about world axes, rad.
    turn: [f64; 3],
    turn_bias: [f64; 3],
}

impl InertialUnit {
    pub(super) fn new(
        settings: &ImuSettings,
        control_period_s: f64,
        start: &RigidState,
        gravity_mps2: f64,
        stream: impl Fn(Purpose) -> Stream,
    ) -> Self {
        let (mut imu, mut attitude) = (stream(Purpose::Imu), stream(Purpose::Attitude));
        let bias_mps2 = std::array::from_fn(|_| settings.bias_sd_mps2 * imu.normal());
        let turn_bias = [
            settings.tilt_bias_sd_rad * attitude.normal(),
            settings.tilt_bias_sd_rad * attitude.normal(),
            settings.yaw_bias_sd_rad * attitude.normal(),
        ];
        let tilt_wander = std::array::from_fn(|_| {
            let (sd, time_s) = (settings.tilt_wander_sd_rad, settings.tilt_wander_s);
            Wander::new(sd, time_s, control_period_s, &mut attitude)
        });
        let control_steps = steps(control_period_s);
        let latency_steps = steps(settings.latency_s);
        let remembered = (latency_steps + control_steps).max(LOG_STEPS as usize);
        let level = along(&start.axes(), [0.0, 0.0, gravity_mps2]);
        Self {
            settings: *settings,
            control_steps,
            stream: imu,
            bias_mps2,
            latency_steps,
            forces_mps2: History::new(remembered, level),
            attitudes: History::new(remembered, start.attitude),
            attitude,
            tilt_wander,
            turn: turn_bias,
            turn_bias,
        }
    }

    /// Adds the motion of a step.
    pub(super) fn observe(
        &mut self,
        state: &RigidState,
        mut acceleration_mps2: [f64; 3],
        gravity_mps2: f64,
    ) {
        acceleration_mps2[2] += gravity_mps2;
        let force_mps2 = along(&state.axes(), acceleration_mps2);
        self.forces_mps2.push(force_mps2);
        self.attitudes.push(state.attitude);
    }

    /// Mean specific force over a control period and the attitude at its end, both with
    /// the unit's latency.
    pub(super) fn sample(&mut self, nan: &NanReadings) -> ImuSample<f64> {
        let count = self.control_steps;
        let mean = mean(&self.forces_mps2, self.latency_steps, count);
        let sd = self.settings.noise_density / (count as f64 * STEP_S).sqrt();
        let force: [f64; 3] =
            std::array::from_fn(|k| mean[k] + self.bias_mps2[k] + sd * self.stream.normal());
        for k in 0..2 {
            self.turn[k] = self.turn_bias[k] + self.tilt_wander[k].step(&mut self.attitude);
        }
        let measured = self.believed(self.attitudes.at(self.latency_steps));
        ImuSample {
            specific_force_mps2: vector(force.map(|f| nan_if(nan.specific_force, f))),
            attitude: if nan.attitude {
                Attitude::from_yaw(f64::NAN)
            } else {
                Attitude::from_quaternion(measured).unwrap_or_default()
            },
        }
    }

    /// Mean specific force over the interval of a logged sample, without noise.
    pub(crate) fn logged_force_mps2(&self) -> [f64; 3] {
        add(
            mean(&self.forces_mps2, 0, LOG_STEPS as usize),
            self.bias_mps2,
        )
    }

    /// The attitude with the error of the unit's estimate.
    pub(crate) fn believed(&self, attitude: [f64; 4]) -> [f64; 4] {
        let [a, b, c] = scale(self.turn, 0.5);
        normalised(product([1.0, a, b, c], attitude))
    }

    /// The rates with the noise of the gyros.
    pub(crate) fn rates(&mut self, rates: [f64; 3]) -> [f64; 3] {
        let sd = self.settings.gyro_sd;
        rates.map(|rate| rate + sd * self.attitude.normal())
    }
}

/// Mean of the `count` values of which the newest is `age` steps old.
fn mean(history: &History<[f64; 3]>, age: usize, count: usize) -> [f64; 3] {
    let steps = (age..age + count).rev();
    let sum = steps.fold([0.0; 3], |sum, back| add(sum, history.at(back)));
    sum.map(|sum| sum / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_means_of_a_ramp() {
        let mut history = History::new(6, [0.0; 3]);
        // Sums and quotients of small whole numbers are exact.
        for step in 1..=20 {
            let force = f64::from(step);
            history.push([force, 0.0, 2.0 * force]);
        }
        assert_eq!(mean(&history, 0, 1), [20.0, 0.0, 40.0]);
        assert_eq!(mean(&history, 0, 4), [18.5, 0.0, 37.0]);
        assert_eq!(mean(&history, 2, 4), [16.5, 0.0, 33.0]);
    }
}
