//! The control's step, for any [`Number`].

use super::{Cascade, LowPass};
use crate::body::rigid::SPIN;
use crate::number::vector::{axes_of, cross, dot, normalised, product};
use crate::number::{Number, angle, sin_cos};

/// A setpoint; see [`AttitudeSetpoint`](super::AttitudeSetpoint).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setpoint<N> {
    pub(crate) thrust_n: N,
    pub(crate) attitude: [N; 4],
    pub(crate) yaw_rate: N,
    /// Rates about body axes in the place of the attitude, rad/s.
    pub(crate) body_rates: Option<[N; 3]>,
}

/// What the control remembers from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CascadeMemory<N = f64> {
    integral: [N; 3],
    gyro: [[N; 2]; 3],
    filtered: [N; 3],
    derivative: [N; 3],
    yaw_torque: N,
    /// Sign of the torque that the mixer could not give, 0 where it could.
    saturated: [N; 3],
    pub(super) throttle: [N; 4],
}

/// What a step gives; see [`CascadeOutput`](super::CascadeOutput).
#[derive(Clone, Copy, Debug)]
pub(crate) struct ControlOutput<N> {
    pub(crate) throttle: [N; 4],
    pub(crate) rate_setpoint: [N; 3],
    pub(crate) given_up: [N; 3],
}

impl<N: Number> CascadeMemory<N> {
    /// Nothing yet, for as many vehicles as there are numbers in `like`.
    #[inline(always)]
    pub(crate) fn none(like: N) -> Self {
        let zero = like.splat(0.0);
        Self {
            integral: [zero; 3],
            gyro: [[zero; 2]; 3],
            filtered: [zero; 3],
            derivative: [zero; 3],
            yaw_torque: zero,
            saturated: [zero; 3],
            throttle: [zero; 4],
        }
    }

    /// With nothing where `truth` holds.
    #[inline(always)]
    pub(crate) fn without(mut self, truth: N::Truth) -> Self {
        let zero = self.integral[0].splat(0.0);
        self.yaw_torque = N::select(truth, zero, self.yaw_torque);
        for k in 0..3 {
            self.integral[k] = N::select(truth, zero, self.integral[k]);
            self.derivative[k] = N::select(truth, zero, self.derivative[k]);
            self.saturated[k] = N::select(truth, zero, self.saturated[k]);
        }
        self
    }
}

impl LowPass {
    #[inline(always)]
    fn step<N: Number>(&self, state: &mut [N; 2], x: N) -> N {
        let y = x * self.b + state[0];
        state[0] = x * (2.0 * self.b) - y * self.a[0] + state[1];
        state[1] = x * self.b - y * self.a[1];
        y
    }

    /// The state in which a constant x passes unchanged.
    #[inline(always)]
    fn at_rest<N: Number>(&self, x: N) -> [N; 2] {
        [x * (1.0 - self.b), x * (self.b - self.a[1])]
    }
}

#[inline(always)]
fn inverse<N: Number>(q: [N; 4]) -> [N; 4] {
    [q[0], -q[1], -q[2], -q[3]]
}

#[inline(always)]
fn choose4<N: Number>(truth: N::Truth, yes: [N; 4], no: [N; 4]) -> [N; 4] {
    [
        N::select(truth, yes[0], no[0]),
        N::select(truth, yes[1], no[1]),
        N::select(truth, yes[2], no[2]),
        N::select(truth, yes[3], no[3]),
    ]
}

impl Cascade {
    /// Rates that turn the attitude `q` towards the setpoint, or those that are asked for; within limits, rad/s in body axes.
    #[inline(always)]
    pub(super) fn rates_for<N: Number>(&self, q: [N; 4], wanted: &Setpoint<N>) -> [N; 3] {
        let s = &self.settings;
        let limits = [
            s.greatest_tilt_rate,
            s.greatest_tilt_rate,
            s.greatest_yaw_rate,
        ];
        if let Some(rates) = wanted.body_rates {
            return [0, 1, 2].map(|k| rates[k].within(-limits[k], limits[k]));
        }
        let yaw_rate = wanted.yaw_rate;
        let wanted = self.within_tilt(normalised(wanted.attitude));
        let zero = yaw_rate.splat(0.0);
        // The shortest turn of the thrust direction.
        let axes = axes_of(q);
        let (z, z_wanted) = (axes[2], axes_of(wanted)[2]);
        let cosine = dot(z, z_wanted);
        let [a, b, c] = cross(z, z_wanted);
        let shortest = product(normalised([cosine + 1.0, a, b, c]), q);
        let reduced = choose4(cosine.below(-1.0 + 1e-6), wanted, shortest);
        // What is left of the setpoint is a turn about the body's z: weighted.
        let mix = product(inverse(reduced), wanted);
        let turn = N::select(mix[0].below(0.0), -mix[3], mix[3]).within(-1.0, 1.0);
        let half = angle((1.0 - turn * turn).sqrt(), turn) * s.yaw_weight;
        let (sine, cosine) = sin_cos(half);
        let weighted = product(reduced, [cosine, zero, zero, sine]);
        let error = product(inverse(q), weighted);
        let sign = N::select(error[0].below(0.0), zero.splat(-2.0), 2.0);
        // As PX4: the yaw gain is raised by the weight's inverse.
        let yaw_gain = s.yaw_gain_per_s / s.yaw_weight.max(0.1);
        let gains = [s.tilt_gain_per_s, s.tilt_gain_per_s, yaw_gain];
        let mut rates = [zero; 3];
        for k in 0..3 {
            let rate = sign * gains[k] * error[k + 1] + axes[k][2] * yaw_rate;
            rates[k] = rate.within(-limits[k], limits[k]);
        }
        rates
    }

    /// The attitude with its tilt reduced to the limit.
    #[inline(always)]
    fn within_tilt<N: Number>(&self, q: [N; 4]) -> [N; 4] {
        let z = axes_of(q)[2];
        let beyond = z[2].below(self.cos_greatest_tilt);
        if !N::any(beyond) {
            return q;
        }
        let up = z[2].within(-1.0, 1.0);
        let tilt = angle(up, (1.0 - up * up).sqrt());
        let back = 0.5 * (self.settings.greatest_tilt_rad - tilt);
        // Turn about the horizontal axis e_z × z, which raised the tilt.
        let side = (z[0] * z[0] + z[1] * z[1]).sqrt().at_least(1e-12);
        let (sin, cos) = sin_cos(back);
        let turn = [
            cos,
            sin * (-z[1] / side),
            sin * (z[0] / side),
            z[0].splat(0.0),
        ];
        choose4(beyond, product(turn, q), q)
    }

    /// One step on a measured attitude and measured rates; where `first`, the memory
    /// is made up from them.
    #[inline(always)]
    pub(crate) fn control<N: Number>(
        &self,
        memory: &mut CascadeMemory<N>,
        first: N::Truth,
        attitude: [N; 4],
        rates: [N; 3],
        wanted: &Setpoint<N>,
    ) -> ControlOutput<N> {
        let s = &self.settings;
        let rate_setpoint = self.rates_for(attitude, wanted);
        let zero = wanted.thrust_n.splat(0.0);
        let mut torque = [zero; 3];
        for k in 0..3 {
            let rest = self.gyro.at_rest(rates[k]);
            let gyro = &mut memory.gyro[k];
            gyro[0] = N::select(first, rest[0], gyro[0]);
            gyro[1] = N::select(first, rest[1], gyro[1]);
            let before = N::select(first, rates[k], memory.filtered[k]);
            let filtered = self.gyro.step(gyro, rates[k]);
            memory.filtered[k] = filtered;
            let slope = (filtered - before) * (1.0 / s.period_s);
            let last = memory.derivative[k];
            memory.derivative[k] = last + (slope - last) * self.derivative_share;
            let error = rate_setpoint[k] - filtered;
            let integral = memory.integral[k];
            let alpha = error * s.rate_gain_per_s[k] + integral
                - memory.derivative[k] * s.derivative_gain[k];
            torque[k] = alpha * self.inertia_kg_m2[k];
            // The integral stops where the mixer cannot follow.
            let next = integral + error * (s.integral_gain_per_s2[k] * s.period_s);
            let stops = (error * memory.saturated[k]).above(0.0);
            memory.integral[k] = N::select(
                stops,
                integral,
                next.within(-s.greatest_integral, s.greatest_integral),
            );
        }
        let last = memory.yaw_torque;
        memory.yaw_torque = last + (torque[2] - last) * self.yaw_torque_share;
        torque[2] = memory.yaw_torque;
        let (thrusts_n, given_up) = self.mixed(wanted.thrust_n, torque);
        for k in 0..3 {
            let share = given_up[if k < 2 { 1 } else { 2 }];
            let sign = N::select(torque[k].below(0.0), zero.splat(-1.0), 1.0);
            memory.saturated[k] = N::select(share.above(0.0), sign, 0.0);
        }
        let next = self.driven(thrusts_n);
        let throttle = choose4(first, next, memory.throttle);
        memory.throttle = next;
        ControlOutput {
            throttle,
            rate_setpoint,
            given_up,
        }
    }

    /// See [`Cascade::mix`].
    #[inline(always)]
    pub(super) fn mixed<N: Number>(&self, thrust_n: N, torque_nm: [N; 3]) -> ([N; 4], [N; 3]) {
        let (least_n, greatest_n) = (self.least_n, self.greatest_n);
        let wanted = thrust_n * 0.25;
        let base = wanted.within(least_n, greatest_n);
        // Left rotors 0 and 1 roll to the right, rear rotors 1 and 2 pitch down.
        let per_arm = 0.25 / self.arm_m;
        let (roll, pitch) = (torque_nm[0] * per_arm, torque_nm[1] * per_arm);
        let tilt = [roll - pitch, roll + pitch, pitch - roll, -roll - pitch];
        // Roll and pitch are symmetric: the least is -high. Too much thrust is lowered, but not
        // below the middle of the range; then roll and pitch are scaled to what fits.
        let high = tilt[0].abs().at_least(tilt[1].abs());
        let middle_n = 0.5 * (least_n + greatest_n);
        let lowered = base.at_most((greatest_n - high).at_least(middle_n));
        let base = N::select(base.above(middle_n), lowered, base);
        let room = (greatest_n - base).at_most(base - least_n);
        let scale = N::select(room.below(high), room / high, 1.0);
        let yaw = if self.torque_per_thrust_m > 0.0 {
            torque_nm[2] * (0.25 / self.torque_per_thrust_m)
        } else {
            thrust_n.splat(0.0)
        };
        // The rotor with the least room to one side bounds them all.
        let (mut thrusts_n, mut room) = (tilt, thrust_n.splat(f64::INFINITY));
        for i in 0..4 {
            thrusts_n[i] = base + scale * tilt[i];
            let up = greatest_n - thrusts_n[i];
            let rises = (yaw * SPIN[i]).above(0.0);
            room = room.at_most(N::select(rises, up, thrusts_n[i] - least_n));
        }
        let size = yaw.abs();
        let share = N::select(room.below(size), room.at_least(0.0) / size, 1.0);
        for i in 0..4 {
            let thrust_n = thrusts_n[i] + share * (yaw * SPIN[i]);
            thrusts_n[i] = thrust_n.within(least_n, greatest_n);
        }
        let lost = N::select(base.below(wanted), 1.0 - base / wanted, 0.0);
        let given_up = [lost, 1.0 - scale, 1.0 - share];
        (thrusts_n, given_up)
    }

    /// See [`Cascade::throttles`].
    #[inline(always)]
    pub(super) fn driven<N: Number>(&self, thrusts_n: [N; 4]) -> [N; 4] {
        let mut drive = thrusts_n;
        for i in 0..4 {
            drive[i] = self
                .motor
                .drive_for((4.0 * thrusts_n[i].at_least(0.0)).sqrt());
        }
        let mean = (drive[0] + drive[1] + drive[2] + drive[3]) * 0.25;
        let voltage = 1.0 - self.motor.throttle_for_drive(mean) * self.motor.sag();
        let part = 1.0 / voltage;
        for i in 0..4 {
            drive[i] = (drive[i] * part).within(0.0, 1.0);
        }
        drive
    }
}
