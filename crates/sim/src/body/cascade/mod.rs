//! Attitude and rate control as on a PX4 vehicle: thrust and attitude in,
//! throttles of four motors out.
//!
//! ```text
//! attitude   ω_sp = 2 K_a sgn(q_e0) q_e⃗ , yaw weighted, limited               (each control step)
//! rates      α = K_p (ω_sp - ω) + ∫ K_i (ω_sp - ω) dt - K_d dω_f/dt           (each control step)
//! mixer      F_i = T/4 + roll, pitch (first), yaw (what is left)
//! motors     throttle by the inverse of the motor law at rest, by the battery's sag
//! ```
//!
//! The attitude law is the reduced-attitude law of Brescianini, Hehn & D'Andrea
//! (2013), in the form of PX4's `mc_att_control`: the thrust direction is turned
//! over the shortest way and yaw follows with a weight. The rate law is PX4's
//! PID with its derivative on the filtered rate and an integral that stops
//! where the mixer saturates; yaw's output passes a low-pass; its output is an angular acceleration (K_p in
//! 1/s), which the moments of inertia turn into torque, so that gains do not
//! depend on the vehicle's size. The mixer gives way in PX4's order without
//! "air mode": too much thrust is lowered, then roll and pitch are scaled; yaw
//! gets the margin. Lags: gyro low-pass of second order (`gyro_cutoff_hz`), one
//! control step of computing time, and the plant's motors.

mod law;

use std::f64::consts::{SQRT_2, TAU};

use serde::{Deserialize, Serialize};

use crate::body::motor::Motor;
use crate::body::rigid::RigidVehicle;
use crate::check;
use crate::error::SimError;

pub(crate) use law::{CascadeMemory, Setpoint};

/// Gains and limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CascadeSettings {
    /// Time between two steps of the control, s.
    pub period_s: f64,
    /// Attitude gain of roll and pitch K_a, 1/s (PX4 `MC_ROLL_P`).
    pub tilt_gain_per_s: f64,
    /// Attitude gain of yaw, 1/s (`MC_YAW_P`).
    pub yaw_gain_per_s: f64,
    /// Weight of yaw against tilt in [0, 1] (`MC_YAW_WEIGHT`).
    pub yaw_weight: f64,
    /// Greatest roll and pitch rate asked for, rad/s (`MC_ROLLRATE_MAX`).
    pub greatest_tilt_rate: f64,
    /// Greatest yaw rate asked for, rad/s (`MC_YAWRATE_MAX`).
    pub greatest_yaw_rate: f64,
    /// Rate gains K_p about x, y, z, 1/s.
    pub rate_gain_per_s: [f64; 3],
    /// Integral gains K_i, 1/s².
    pub integral_gain_per_s2: [f64; 3],
    /// Derivative gains K_d, a number.
    pub derivative_gain: [f64; 3],
    /// Greatest integral, rad/s².
    pub greatest_integral: f64,
    /// Cut-off of the gyro's low-pass, Hz (`IMU_GYRO_CUTOFF`).
    pub gyro_cutoff_hz: f64,
    /// Cut-off of the derivative's low-pass, Hz (`IMU_DGYRO_CUTOFF`).
    pub derivative_cutoff_hz: f64,
    /// Cut-off of the low-pass of the yaw torque, Hz (`MC_YAW_TQ_CUTOFF`): rotors that change their
    /// speed turn the body at once, and more than the torque that was asked for.
    pub yaw_torque_cutoff_hz: f64,
    /// Least throttle of a motor in flight.
    pub least_throttle: f64,
    /// Greatest tilt that is flown, rad (`MPC_TILTMAX_AIR`).
    pub greatest_tilt_rad: f64,
}

impl Default for CascadeSettings {
    fn default() -> Self {
        Self {
            period_s: 0.002,
            tilt_gain_per_s: 6.5,
            yaw_gain_per_s: 2.8,
            yaw_weight: 0.4,
            greatest_tilt_rate: 3.84,
            greatest_yaw_rate: 3.49,
            rate_gain_per_s: [22.0, 22.0, 6.0],
            integral_gain_per_s2: [20.0, 20.0, 3.0],
            derivative_gain: [0.6, 0.6, 0.0],
            greatest_integral: 10.0,
            gyro_cutoff_hz: 40.0,
            derivative_cutoff_hz: 30.0,
            yaw_torque_cutoff_hz: 2.0,
            least_throttle: 0.05,
            greatest_tilt_rad: 0.785,
        }
    }
}

impl CascadeSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Times, cut-offs and limits must be positive, gains not negative; a cut-off
    /// must lie below half the sampling rate.
    pub fn validate(&self) -> Result<(), SimError> {
        check::within("period_s", self.period_s, crate::STEP_S, 0.05)?;
        let steps = self.period_s / crate::STEP_S;
        check::that(
            (steps - steps.round()).abs() < 1e-6,
            "period_s",
            "a multiple of 0.001 s",
            self.period_s,
        )?;
        check::not_negative("tilt_gain_per_s", self.tilt_gain_per_s)?;
        check::not_negative("yaw_gain_per_s", self.yaw_gain_per_s)?;
        check::within("yaw_weight", self.yaw_weight, 0.0, 1.0)?;
        check::positive("greatest_tilt_rate", self.greatest_tilt_rate)?;
        check::positive("greatest_yaw_rate", self.greatest_yaw_rate)?;
        for k in 0..3 {
            check::not_negative("rate_gain_per_s", self.rate_gain_per_s[k])?;
            check::not_negative("integral_gain_per_s2", self.integral_gain_per_s2[k])?;
            check::not_negative("derivative_gain", self.derivative_gain[k])?;
        }
        check::not_negative("greatest_integral", self.greatest_integral)?;
        let half_hz = 0.5 / self.period_s;
        check::within("gyro_cutoff_hz", self.gyro_cutoff_hz, 0.1, half_hz)?;
        check::within(
            "derivative_cutoff_hz",
            self.derivative_cutoff_hz,
            0.1,
            half_hz,
        )?;
        check::within(
            "yaw_torque_cutoff_hz",
            self.yaw_torque_cutoff_hz,
            0.1,
            half_hz,
        )?;
        check::within("least_throttle", self.least_throttle, 0.0, 0.5)?;
        check::within("greatest_tilt_rad", self.greatest_tilt_rad, 0.01, 1.5)
    }
}

/// What a vehicle is asked to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeSetpoint {
    /// Thrust along the body's z axis, all rotors in free air, N.
    pub thrust_n: f64,
    /// Attitude wanted, unit quaternion w, x, y, z from body to world.
    pub attitude: [f64; 4],
    /// Yaw rate wanted about the world's z axis, rad/s.
    pub yaw_rate: f64,
    /// Rates wanted about body axes, in the place of the attitude, rad/s.
    pub body_rates: Option<[f64; 3]>,
}

/// State of the control between steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CascadeState {
    memory: CascadeMemory,
    setpoint: Option<AttitudeSetpoint>,
}

/// What a step of the control gives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CascadeOutput {
    /// Throttles for the motors during the next control period.
    pub throttle: [f64; 4],
    /// Rates asked for, rad/s.
    pub rate_setpoint: [f64; 3],
    /// Share of thrust, of roll and pitch, and of yaw that the mixer had to give up.
    pub given_up: [f64; 3],
}

/// Second-order Butterworth low-pass, transposed direct form II.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LowPass {
    b: f64,
    a: [f64; 2],
}

impl LowPass {
    fn new(cutoff_hz: f64, period_s: f64) -> Self {
        let w = (0.5 * TAU * cutoff_hz * period_s).min(1.5).tan();
        let n = 1.0 / (1.0 + SQRT_2 * w + w * w);
        Self {
            b: w * w * n,
            a: [2.0 * (w * w - 1.0) * n, (1.0 - SQRT_2 * w + w * w) * n],
        }
    }
}

/// The cascade with coefficients that do not change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade {
    settings: CascadeSettings,
    gyro: LowPass,
    derivative_share: f64,
    yaw_torque_share: f64,
    motor: Motor,
    arm_m: f64,
    torque_per_thrust_m: f64,
    inertia_kg_m2: [f64; 3],
    least_n: f64,
    greatest_n: f64,
    cos_greatest_tilt: f64,
}

impl Cascade {
    /// Checks the settings and builds the control for the nominal `vehicle`.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn new(settings: &CascadeSettings, vehicle: &RigidVehicle) -> Result<Self, SimError> {
        settings.validate()?;
        let motor = *vehicle.rotors().plant().motor();
        let quarter = |s: f64| 0.25 * motor.rest(s).powi(2);
        // Share of a new value that a first-order low-pass takes.
        let share = |cutoff_hz: f64| {
            let corner = TAU * cutoff_hz * settings.period_s;
            corner / (1.0 + corner)
        };
        Ok(Self {
            settings: *settings,
            gyro: LowPass::new(settings.gyro_cutoff_hz, settings.period_s),
            derivative_share: share(settings.derivative_cutoff_hz),
            yaw_torque_share: share(settings.yaw_torque_cutoff_hz),
            motor,
            arm_m: vehicle.rotors().hubs_m()[0][0],
            torque_per_thrust_m: vehicle.body().torque_per_thrust_m,
            inertia_kg_m2: vehicle.body().inertia_kg_m2,
            least_n: quarter(settings.least_throttle),
            greatest_n: quarter(1.0),
            cos_greatest_tilt: settings.greatest_tilt_rad.cos(),
        })
    }

    /// Time between two steps, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.settings.period_s
    }

    /// Rates that turn the attitude `q` towards the setpoint, rad/s in body axes.
    #[must_use]
    pub fn rate_setpoint(&self, q: [f64; 4], setpoint: &AttitudeSetpoint) -> [f64; 3] {
        self.rates_for(q, &setpoint.wanted())
    }

    /// One step of the control on a measured attitude and measured rates (body
    /// axes). The throttles it returns are those of the step before: computing
    /// takes one period. A setpoint that is not finite leaves the last one in
    /// place, measurements that are not the last throttles.
    pub fn step(
        &self,
        state: &mut CascadeState,
        attitude: [f64; 4],
        rates: [f64; 3],
        setpoint: &AttitudeSetpoint,
    ) -> CascadeOutput {
        let first = state.setpoint.is_none();
        if setpoint.is_finite() {
            state.setpoint = Some(*setpoint);
        }
        let measured = attitude.iter().chain(&rates).all(|v| v.is_finite());
        let (Some(setpoint), true) = (state.setpoint, measured) else {
            return CascadeOutput {
                throttle: state.memory.throttle,
                ..CascadeOutput::default()
            };
        };
        let wanted = setpoint.wanted();
        let given = self.control(&mut state.memory, first, attitude, rates, &wanted);
        CascadeOutput {
            throttle: given.throttle,
            rate_setpoint: given.rate_setpoint,
            given_up: given.given_up,
        }
    }

    /// Thrusts of the rotors for a total thrust in N and torques about the
    /// body's axes in N m, within the motors' limits; and the shares of thrust,
    /// of roll and pitch, and of yaw that were given up.
    #[must_use]
    pub fn mix(&self, thrust_n: f64, torque_nm: [f64; 3]) -> ([f64; 4], [f64; 3]) {
        self.mixed(thrust_n, torque_nm)
    }

    /// Throttles that hold the rotors' thrusts in N at rest, with the sag of the
    /// common battery.
    #[must_use]
    pub fn throttles(&self, thrusts_n: [f64; 4]) -> [f64; 4] {
        self.driven(thrusts_n)
    }
}

impl AttitudeSetpoint {
    pub(crate) fn wanted(&self) -> Setpoint<f64> {
        Setpoint {
            thrust_n: self.thrust_n,
            attitude: self.attitude,
            yaw_rate: self.yaw_rate,
            body_rates: self.body_rates,
        }
    }

    /// Every number is finite and the quaternion is one.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let size: f64 = self.attitude.iter().map(|q| q * q).sum();
        let rates = self.body_rates.unwrap_or_default();
        let rest = [self.thrust_n, self.yaw_rate]
            .iter()
            .chain(&rates)
            .all(|v| v.is_finite());
        rest && size.is_finite() && size > 1e-6
    }
}
