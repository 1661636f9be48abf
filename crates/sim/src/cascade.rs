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
//! where the mixer saturates; its output is an angular acceleration (K_p in
//! 1/s), which the moments of inertia turn into torque, so that gains do not
//! depend on the vehicle's size. The mixer gives way in PX4's order without
//! "air mode": too much thrust is lowered, then roll and pitch are scaled; yaw
//! gets the margin. Lags: gyro low-pass of second order (`gyro_cutoff_hz`), one
//! control step of computing time, and the plant's motors.

use std::f64::consts::{SQRT_2, TAU};

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::motor::Motor;
use crate::rigid::{RigidVehicle, SPIN};
use crate::vector::{axes_of, cross, dot, normalised, product};

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
}

/// State of the control between steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CascadeState {
    integral: [f64; 3],
    gyro: [[f64; 2]; 3],
    filtered: [f64; 3],
    derivative: [f64; 3],
    /// Sign of the torque that the mixer could not give, 0 where it could.
    saturated: [f64; 3],
    throttle: [f64; 4],
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

    #[inline]
    fn step(&self, state: &mut [f64; 2], x: f64) -> f64 {
        let y = self.b * x + state[0];
        state[0] = 2.0 * self.b * x - self.a[0] * y + state[1];
        state[1] = self.b * x - self.a[1] * y;
        y
    }

    /// The state in which a constant x passes unchanged.
    fn at_rest(&self, x: f64) -> [f64; 2] {
        [(1.0 - self.b) * x, (self.b - self.a[1]) * x]
    }
}

/// The cascade with coefficients that do not change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade {
    settings: CascadeSettings,
    gyro: LowPass,
    derivative_share: f64,
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
        let corner = TAU * settings.derivative_cutoff_hz * settings.period_s;
        Ok(Self {
            settings: *settings,
            gyro: LowPass::new(settings.gyro_cutoff_hz, settings.period_s),
            derivative_share: corner / (1.0 + corner),
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
        let s = &self.settings;
        let wanted = self.within_tilt(normalised(setpoint.attitude));
        // The shortest turn of the thrust direction.
        let (z, z_wanted) = (axes_of(q)[2], axes_of(wanted)[2]);
        let cosine = dot(z, z_wanted);
        let reduced = if cosine < -1.0 + 1e-6 {
            wanted
        } else {
            let [a, b, c] = cross(z, z_wanted);
            product(normalised([1.0 + cosine, a, b, c]), q)
        };
        // What is left of the setpoint is a turn about the body's z: weighted.
        let inverse = |q: [f64; 4]| [q[0], -q[1], -q[2], -q[3]];
        let mix = product(inverse(reduced), wanted);
        let sign = if mix[0] < 0.0 { -1.0 } else { 1.0 };
        let half = s.yaw_weight * (sign * mix[3]).clamp(-1.0, 1.0).asin();
        let weighted = product(reduced, [half.cos(), 0.0, 0.0, half.sin()]);
        let error = product(inverse(q), weighted);
        let sign = if error[0] < 0.0 { -2.0 } else { 2.0 };
        // As PX4: the yaw gain is raised by the weight's inverse.
        let yaw_gain = s.yaw_gain_per_s / s.yaw_weight.max(0.1);
        let gains = [s.tilt_gain_per_s, s.tilt_gain_per_s, yaw_gain];
        let limits = [
            s.greatest_tilt_rate,
            s.greatest_tilt_rate,
            s.greatest_yaw_rate,
        ];
        let axes = axes_of(q);
        std::array::from_fn(|k| {
            let rate = sign * gains[k] * error[k + 1] + axes[k][2] * setpoint.yaw_rate;
            rate.clamp(-limits[k], limits[k])
        })
    }

    /// The attitude with its tilt reduced to the limit.
    fn within_tilt(&self, q: [f64; 4]) -> [f64; 4] {
        let z = axes_of(q)[2];
        if z[2] >= self.cos_greatest_tilt {
            return q;
        }
        let tilt = z[2].clamp(-1.0, 1.0).acos();
        let back = 0.5 * (self.settings.greatest_tilt_rad - tilt);
        // Turn about the horizontal axis e_z × z, which raised the tilt.
        let side = z[0].hypot(z[1]).max(1e-12);
        let axis = [-z[1] / side, z[0] / side];
        let (sin, cos) = back.sin_cos();
        product([cos, sin * axis[0], sin * axis[1], 0.0], q)
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
        let s = &self.settings;
        let first = state.setpoint.is_none();
        if setpoint.is_finite() {
            state.setpoint = Some(*setpoint);
        }
        let measured = attitude.iter().chain(&rates).all(|v| v.is_finite());
        let (Some(setpoint), true) = (state.setpoint, measured) else {
            return CascadeOutput {
                throttle: state.throttle,
                ..CascadeOutput::default()
            };
        };
        let rate_setpoint = self.rate_setpoint(attitude, &setpoint);
        let mut torque = [0.0; 3];
        for k in 0..3 {
            if first {
                state.gyro[k] = self.gyro.at_rest(rates[k]);
                state.filtered[k] = rates[k];
            }
            let filtered = self.gyro.step(&mut state.gyro[k], rates[k]);
            let slope = (filtered - state.filtered[k]) / s.period_s;
            state.filtered[k] = filtered;
            state.derivative[k] += self.derivative_share * (slope - state.derivative[k]);
            let error = rate_setpoint[k] - filtered;
            let alpha = s.rate_gain_per_s[k] * error + state.integral[k]
                - s.derivative_gain[k] * state.derivative[k];
            torque[k] = self.inertia_kg_m2[k] * alpha;
            // The integral stops where the mixer cannot follow.
            if error * state.saturated[k] <= 0.0 {
                let next = state.integral[k] + s.integral_gain_per_s2[k] * error * s.period_s;
                state.integral[k] = next.clamp(-s.greatest_integral, s.greatest_integral);
            }
        }
        let (thrusts_n, given_up) = self.mix(setpoint.thrust_n, torque);
        for k in 0..3 {
            let share = given_up[if k < 2 { 1 } else { 2 }];
            state.saturated[k] = if share > 0.0 { torque[k].signum() } else { 0.0 };
        }
        let next = self.throttles(thrusts_n);
        let throttle = if first { next } else { state.throttle };
        state.throttle = next;
        CascadeOutput {
            throttle,
            rate_setpoint,
            given_up,
        }
    }

    /// Thrusts of the rotors for a total thrust in N and torques about the
    /// body's axes in N m, within the motors' limits; and the shares of thrust,
    /// of roll and pitch, and of yaw that were given up.
    #[must_use]
    pub fn mix(&self, thrust_n: f64, torque_nm: [f64; 3]) -> ([f64; 4], [f64; 3]) {
        let (least, greatest) = (self.least_n, self.greatest_n);
        let wanted = 0.25 * thrust_n;
        let mut base = wanted.clamp(least, greatest);
        // Left rotors 0 and 1 roll to the right, rear rotors 1 and 2 pitch down.
        let per_arm = 0.25 / self.arm_m;
        let (roll, pitch) = (per_arm * torque_nm[0], per_arm * torque_nm[1]);
        let tilt = [roll - pitch, roll + pitch, pitch - roll, -roll - pitch];
        let high = tilt.iter().copied().fold(0.0, f64::max);
        // Roll and pitch are symmetric: the least is -high. Too much thrust is lowered, but not
        // below the middle of the range; then roll and pitch are scaled to what fits.
        let middle = 0.5 * (least + greatest);
        if base > middle {
            base = base.min((greatest - high).max(middle));
        }
        let room = (greatest - base).min(base - least);
        let scale = if high > room { room / high } else { 1.0 };
        let mut thrusts_n = tilt.map(|t| base + scale * t);
        let yaw = if self.torque_per_thrust_m > 0.0 {
            0.25 * torque_nm[2] / self.torque_per_thrust_m
        } else {
            0.0
        };
        let mut share: f64 = 1.0;
        for i in 0..4 {
            let step = SPIN[i] * yaw;
            let room = if step > 0.0 {
                greatest - thrusts_n[i]
            } else {
                thrusts_n[i] - least
            };
            if step.abs() > room {
                share = share.min(room.max(0.0) / step.abs());
            }
        }
        for i in 0..4 {
            thrusts_n[i] = (thrusts_n[i] + share * SPIN[i] * yaw).clamp(least, greatest);
        }
        let lost = if wanted > base {
            1.0 - base / wanted
        } else {
            0.0
        };
        (thrusts_n, [lost, 1.0 - scale, 1.0 - share])
    }

    /// Throttles that hold the rotors' thrusts in N at rest, with the sag of the
    /// common battery.
    #[must_use]
    pub fn throttles(&self, thrusts_n: [f64; 4]) -> [f64; 4] {
        let drive = thrusts_n.map(|t| self.motor.drive_for((4.0 * t.max(0.0)).sqrt()));
        let mean = 0.25 * (drive[0] + drive[1] + drive[2] + drive[3]);
        let voltage = 1.0 - self.motor.sag() * self.motor.throttle_for_drive(mean);
        drive.map(|d| (d / voltage).clamp(0.0, 1.0))
    }
}

impl AttitudeSetpoint {
    /// Every number is finite and the quaternion is one.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let size: f64 = self.attitude.iter().map(|q| q * q).sum();
        let rest = self.thrust_n.is_finite() && self.yaw_rate.is_finite();
        rest && size.is_finite() && size > 1e-6
    }
}
