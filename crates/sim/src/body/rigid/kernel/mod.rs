//! One step of the vehicle, for any [`Number`].

use super::state::MotionState;
use super::{RigidVehicle, SPIN};
use crate::body::contact::{Body, Foothold, Legs};
use crate::body::rotors::{HeldRotors, Shares};
use crate::deck::rigid::DeckPose;
use crate::number::Number;
use crate::number::vector::{
    Axes, add, along, axes_of, cross, dot, normalised, scale, sub, to_world,
};
use crate::number::vector::{corners, product, turned};

/// Differences between vehicles of one design.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VehicleVariation<N> {
    /// Relative error ε_i of each rotor's thrust.
    pub(crate) thrust_scale_error: [N; 4],
    /// Scale of the ground effect γ.
    pub(crate) ground_effect_scale: N,
}

/// Throttles and disturbances of a vehicle during a step; see
/// [`Disturbance`](super::Disturbance).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<N> {
    pub(crate) throttle: [N; 4],
    pub(crate) wind_mps: [N; 3],
    pub(crate) turbulence_n: [N; 4],
    /// See [`RigidVehicle::shares_ahead`].
    pub(crate) shares: Shares<N>,
}

/// The rotors' surroundings and the deck's normal, constant over a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings<N> {
    pub(crate) rotors: HeldRotors<N>,
    normal: [N; 3],
}

/// Legs that may touch, and where feet stick.
pub(crate) struct LegContact<'a, N: Number> {
    pub(crate) legs: &'a Legs,
    pub(crate) foothold: Foothold<N>,
}

/// Accelerations and forces in a state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dynamics<N> {
    pub(crate) acceleration_mps2: [N; 3],
    pub(crate) angular_acceleration: [N; 3],
    pub(crate) rotor_n: [N; 4],
    pub(crate) ground_effect_n: [N; 4],
}

impl RigidVehicle {
    /// The hubs of a vehicle, in the deck's axes.
    #[inline(always)]
    pub(super) fn hubs_over<N: Number>(
        &self,
        position_m: [N; 3],
        axes: &Axes<N>,
        deck: &DeckPose<N>,
    ) -> [[N; 3]; 4] {
        let centre = along(&deck.axes, sub(position_m, deck.origin_m));
        let x = along(&deck.axes, axes[0]);
        let y = along(&deck.axes, axes[1]);
        let z = along(&deck.axes, axes[2]);
        let mut places_m = [centre; 4];
        let [a, _, h] = self.hubs_m[0];
        for k in 0..3 {
            let at = corners(x[k] * a, y[k] * a, centre[k] + z[k] * h);
            for i in 0..4 {
                places_m[i][k] = at[i];
            }
        }
        places_m
    }

    /// The hubs predicted for `time_s` ahead, in the axes of the deck then.
    #[inline(always)]
    fn hubs_ahead<N: Number>(
        &self,
        state: &MotionState<N>,
        time_s: f64,
        deck: &DeckPose<N>,
    ) -> [[N; 3]; 4] {
        let attitude = normalised(turned(state.attitude, state.rates, 0.5 * time_s));
        let mut position_m = state.position_m;
        for k in 0..3 {
            position_m[k] = position_m[k] + state.velocity_mps[k] * time_s;
        }
        self.hubs_over(position_m, &axes_of(attitude), deck)
    }

    /// The rotors' shares of the plate at the places predicted for `time_s` ahead; `deck` is the
    /// deck then.
    #[inline(always)]
    pub(crate) fn shares_ahead<N: Number>(
        &self,
        state: &MotionState<N>,
        time_s: f64,
        deck: &DeckPose<N>,
    ) -> Shares<N> {
        self.rotors.shares(&self.hubs_ahead(state, time_s, deck))
    }

    /// The surroundings of rotors whose hubs are at places in the deck's axes.
    #[inline(always)]
    pub(super) fn around<N: Number>(
        &self,
        kind: &VehicleVariation<N>,
        root_thrust: &[N; 4],
        hubs_m: &[[N; 3]; 4],
        shares: &Shares<N>,
        deck: &DeckPose<N>,
    ) -> Surroundings<N> {
        // In the deck's axes; its rotation enters the speed of the point below.
        let heave = dot(deck.axes[2], deck.velocity_mps);
        let roll = dot(deck.axes[0], deck.angular_velocity);
        let pitch = dot(deck.axes[1], deck.angular_velocity);
        let mut deck_mps = [heave; 4];
        for i in 0..4 {
            deck_mps[i] = heave + roll * hubs_m[i][1] - pitch * hubs_m[i][0];
        }
        let scale = kind.ground_effect_scale;
        Surroundings {
            rotors: self
                .rotors
                .held(scale, root_thrust, hubs_m, deck_mps, shares),
            normal: deck.axes[2],
        }
    }

    /// Angular momentum of the rotors along the body's z axis, or its rate, from their roots of thrust or the rates of these.
    #[inline(always)]
    fn rotor_momentum<N: Number>(&self, roots: &[N; 4]) -> N {
        let mut sum = roots[0].splat(0.0);
        for i in 0..4 {
            sum = sum - roots[i] * SPIN[i];
        }
        sum * self.momentum_share
    }

    /// Rate of the state, and what acts, with what drives the motors.
    #[inline(always)]
    pub(super) fn rate<N: Number>(
        &self,
        kind: &VehicleVariation<N>,
        state: &MotionState<N>,
        input: &Input<N>,
        drive: &[N; 4],
        around: &Surroundings<N>,
        contact: Option<(&LegContact<'_, N>, &DeckPose<N>)>,
    ) -> (MotionState<N>, Dynamics<N>) {
        let axes = axes_of(state.attitude);
        let through = sub(state.velocity_mps, input.wind_mps);
        // Speed of a hub along the normal n: n · v + r · (n × ω), in the body's axes. Over a
        // leaning deck the wind blows along it: only its vertical part climbs.
        let climb = dot(around.normal, state.velocity_mps) - input.wind_mps[2];
        let swing = cross(along(&axes, around.normal), state.rates);
        let [a, _, h] = self.hubs_m[0];
        let climb_mps = corners(swing[0] * a, swing[1] * a, climb + swing[2] * h);
        let forces = self
            .rotors
            .forces(&state.rotors, &around.rotors, &climb_mps);

        let zero = climb.splat(0.0);
        let (mut spin_n, mut rotor_n) = (zero, [zero; 4]);
        for i in 0..4 {
            let free_n = forces.free_air_n[i];
            let force_n = free_n * (1.0 + kind.thrust_scale_error[i])
                + forces.ground_effect_n[i]
                + input.turbulence_n[i];
            spin_n = spin_n + free_n * SPIN[i];
            rotor_n[i] = force_n;
        }
        let (left, right) = (rotor_n[0] + rotor_n[1], rotor_n[2] + rotor_n[3]);
        let (front, rear) = (rotor_n[0] + rotor_n[3], rotor_n[1] + rotor_n[2]);
        let lift_n = left + right;
        let mut torque = [
            (left - right) * a,
            (rear - front) * a,
            spin_n * self.body.torque_per_thrust_m,
        ];
        let (ahead, aside) = (dot(axes[0], through), dot(axes[1], through));
        let speed = (ahead * ahead + aside * aside).sqrt();
        let roots = state.rotors.root_thrust;
        let spin = (roots[0] + roots[1] + roots[2] + roots[3]) * self.spin_share;
        let drag =
            -(self.body.drag_ns2_per_m2 * speed + self.body.drag_ns_per_m * spin.at_most(1.0));
        let mut force = to_world(&axes, [drag * ahead, drag * aside, lift_n]);
        if let Some((standing, deck)) = contact {
            let body = state.body(&axes);
            let (push, turn) = standing.legs.load(&body, deck, &standing.foothold);
            force = add(force, push);
            torque = add(torque, turn);
        }
        let mut acceleration_mps2 = scale(force, 1.0 / self.mass_kg);
        acceleration_mps2[2] = acceleration_mps2[2] - self.gravity_mps2;
        let rotors = self.rotors.rate(&state.rotors, &around.rotors, drive);
        torque[2] = torque[2] - self.rotor_momentum(&rotors.root_thrust);
        let inertia = self.body.inertia_kg_m2;
        let [p, q, r] = state.rates;
        let momentum_z = inertia[2] * r + self.rotor_momentum(&state.rotors.root_thrust);
        let momentum = [inertia[0] * p, inertia[1] * q, momentum_z];
        let turning = sub(torque, cross(state.rates, momentum));
        let mut angular_acceleration = turning;
        for k in 0..3 {
            angular_acceleration[k] = turning[k] * (1.0 / inertia[k]);
        }
        let rate = MotionState {
            rotors,
            position_m: state.velocity_mps,
            velocity_mps: acceleration_mps2,
            attitude: product(state.attitude, [zero, 0.5 * p, 0.5 * q, 0.5 * r]),
            rates: angular_acceleration,
        };
        let acting = Dynamics {
            acceleration_mps2,
            angular_acceleration,
            rotor_n,
            ground_effect_n: forces.ground_effect_n,
        };
        (rate, acting)
    }

    /// One Runge–Kutta step of `dt`; see [`RigidVehicle::step`]. Footholds are moved.
    #[inline(always)]
    pub(crate) fn advance<N: Number>(
        &self,
        kind: &VehicleVariation<N>,
        state: &mut MotionState<N>,
        deck: &[DeckPose<N>; 3],
        input: &Input<N>,
        mut contact: Option<&mut LegContact<'_, N>>,
        dt: f64,
    ) -> (Dynamics<N>, HeldRotors<N>) {
        let drive = self.rotors.drive(&input.throttle);
        let around = {
            let mut roots = state.rotors.root_thrust;
            let spin_up = self.rotors.spin_up(&roots, &drive);
            for i in 0..4 {
                roots[i] = roots[i] + spin_up[i] * (0.5 * dt);
            }
            let hubs_m = self.hubs_ahead(state, 0.5 * dt, &deck[1]);
            self.around(kind, &roots, &hubs_m, &input.shares, &deck[1])
        };
        let start = *state;
        let (mut here, mut sum) = (start, start);
        let zero = start.rates[0].splat(0.0);
        let mut acting = Dynamics {
            acceleration_mps2: [zero; 3],
            angular_acceleration: [zero; 3],
            rotor_n: [zero; 4],
            ground_effect_n: [zero; 4],
        };
        for stage in 0..4_usize {
            let standing = contact.as_deref();
            let touching = standing.map(|legs| (legs, &deck[stage.div_ceil(2)]));
            let (rate, acts) = self.rate(kind, &here, input, &drive, &around, touching);
            if stage == 0 {
                acting = acts;
            }
            let (weight, ahead) = [
                (dt / 6.0, 0.5 * dt),
                (dt / 3.0, 0.5 * dt),
                (dt / 3.0, dt),
                (dt / 6.0, 0.0),
            ][stage];
            sum = sum.after(&rate, weight);
            if stage < 3 {
                here = start.after(&rate, ahead);
            }
        }
        *state = sum;
        state.attitude = normalised(state.attitude);
        if let Some(standing) = &mut contact {
            let axes = axes_of(state.attitude);
            let body: Body<'_, N> = state.body(&axes);
            standing
                .legs
                .settle(&body, &deck[2], &mut standing.foothold);
        }
        (acting, around.rotors)
    }
}

#[cfg(test)]
mod tests;
