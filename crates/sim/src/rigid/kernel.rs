//! One step of the vehicle, for any [`Number`].

use super::state::Moving;
use super::{RigidVehicle, SPIN};
use crate::contact::{Body, Foothold, Legs};
use crate::deck::rigid::DeckPose;
use crate::number::Number;
use crate::rotors::Held;
use crate::vector::{Axes, add, along, axes_of, cross, dot, normalised, scale, sub, to_world};
use crate::vector::{corners, product, turned};

/// In what vehicles of one kind differ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind<N> {
    /// By how much each rotor's thrust differs from the nominal, as a share.
    pub(crate) thrust_scale_error: [N; 4],
    /// Strength of the ground effect γ.
    pub(crate) ground_effect_scale: N,
}

/// What drives and disturbs a vehicle during a step; see
/// [`Disturbance`](super::Disturbance).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<N> {
    pub(crate) throttle: [N; 4],
    pub(crate) wind_mps: [N; 3],
    pub(crate) turbulence_n: [N; 4],
}

/// What is held over a step: the rotors' surroundings and the deck's normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around<N> {
    pub(crate) rotors: Held<N>,
    normal: [N; 3],
}

/// Legs that may touch, and where feet stick.
pub(crate) struct Standing<'a, N: Number> {
    pub(crate) legs: &'a Legs,
    pub(crate) foothold: Foothold<N>,
}

/// Accelerations and forces in a state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Acting<N> {
    pub(crate) acceleration_mps2: [N; 3],
    pub(crate) angular_acceleration: [N; 3],
    pub(crate) rotor_n: [N; 4],
    pub(crate) ground_effect_n: [N; 4],
}

impl RigidVehicle {
    /// The surroundings of a vehicle at a place.
    #[inline(always)]
    pub(super) fn around<N: Number>(
        &self,
        kind: &Kind<N>,
        root_thrust: &[N; 4],
        position_m: [N; 3],
        axes: &Axes<N>,
        deck: &DeckPose<N>,
    ) -> Around<N> {
        // Everything in the deck's axes; its rotation enters the speed of the point below.
        let centre = along(&deck.axes, sub(position_m, deck.origin_m));
        let x = along(&deck.axes, axes[0]);
        let y = along(&deck.axes, axes[1]);
        let z = along(&deck.axes, axes[2]);
        let heave = dot(deck.axes[2], deck.velocity_mps);
        let roll = dot(deck.axes[0], deck.angular_velocity);
        let pitch = dot(deck.axes[1], deck.angular_velocity);
        let mut places_m = [centre; 4];
        let mut deck_mps = [heave; 4];
        let [a, _, h] = self.hubs_m[0];
        for k in 0..3 {
            let at = corners(x[k] * a, y[k] * a, centre[k] + z[k] * h);
            for i in 0..4 {
                places_m[i][k] = at[i];
            }
        }
        for i in 0..4 {
            deck_mps[i] = heave + roll * places_m[i][1] - pitch * places_m[i][0];
        }
        let scale = kind.ground_effect_scale;
        Around {
            rotors: self.rotors.held(scale, root_thrust, &places_m, deck_mps),
            normal: deck.axes[2],
        }
    }

    /// Rate of the state, and what acts, with what drives the motors.
    #[inline(always)]
    pub(super) fn rate<N: Number>(
        &self,
        kind: &Kind<N>,
        state: &Moving<N>,
        input: &Input<N>,
        drive: &[N; 4],
        around: &Around<N>,
        contact: Option<(&Standing<'_, N>, &DeckPose<N>)>,
    ) -> (Moving<N>, Acting<N>) {
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

        let zero = climb.like(0.0);
        let (mut spin_n, mut rotor_n) = (zero, [zero; 4]);
        for i in 0..4 {
            let free_n = forces.free_air_n[i];
            let force_n = free_n * (kind.thrust_scale_error[i] + 1.0)
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
        let drag = -(speed * self.body.drag_ns2_per_m2 + self.body.drag_ns_per_m);
        let mut force = to_world(&axes, [drag * ahead, drag * aside, lift_n]);
        if let Some((standing, deck)) = contact {
            let body = state.body(&axes);
            let (push, turn) = standing.legs.load(&body, deck, &standing.foothold);
            force = add(force, push);
            torque = add(torque, turn);
        }
        let mut acceleration_mps2 = scale(force, zero.like(1.0 / self.mass_kg));
        acceleration_mps2[2] = acceleration_mps2[2] - self.gravity_mps2;
        let inertia = self.body.inertia_kg_m2;
        let [p, q, r] = state.rates;
        let momentum = [p * inertia[0], q * inertia[1], r * inertia[2]];
        let turning = sub(torque, cross(state.rates, momentum));
        let mut angular_acceleration = turning;
        for k in 0..3 {
            angular_acceleration[k] = turning[k] * (1.0 / inertia[k]);
        }
        let rate = Moving {
            rotors: self.rotors.rate(&state.rotors, &around.rotors, drive),
            position_m: state.velocity_mps,
            velocity_mps: acceleration_mps2,
            attitude: product(state.attitude, [zero, p * 0.5, q * 0.5, r * 0.5]),
            rates: angular_acceleration,
        };
        let acting = Acting {
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
        kind: &Kind<N>,
        state: &mut Moving<N>,
        deck: &[DeckPose<N>; 3],
        input: &Input<N>,
        mut contact: Option<&mut Standing<'_, N>>,
        dt: f64,
    ) -> (Acting<N>, Held<N>) {
        let drive = self.rotors.drive(&input.throttle);
        let around = {
            let attitude = normalised(turned(state.attitude, state.rates, 0.25 * dt));
            let mut position_m = state.position_m;
            for k in 0..3 {
                position_m[k] = position_m[k] + state.velocity_mps[k] * (0.5 * dt);
            }
            let mut roots = state.rotors.root_thrust;
            let spin_up = self.rotors.spin_up(&roots, &drive);
            for i in 0..4 {
                roots[i] = roots[i] + spin_up[i] * (0.5 * dt);
            }
            self.around(kind, &roots, position_m, &axes_of(attitude), &deck[1])
        };
        let start = *state;
        let (mut here, mut sum) = (start, start);
        let zero = start.rates[0].like(0.0);
        let mut acting = Acting {
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
            here = start.after(&rate, ahead);
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
mod tests {
    use pulp::{Arch, Simd, WithSimd};

    use super::*;
    use crate::STEP_S;
    use crate::body::BodySettings;
    use crate::contact::{ContactState, LegSettings};
    use crate::deck::rigid::{Axis, RigidDeck, RigidMotion, Tone};
    use crate::lanes::Lanes;
    use crate::number::MOST_LANES;
    use crate::plant::PlantSettings;
    use crate::rigid::{Disturbance, RigidState};

    const STEPS: u32 = 600;

    /// Commands made by hand: each lane its own, down onto the deck and then off.
    fn commands(lane: usize, step: u32, hover: f64) -> ([f64; 4], Disturbance) {
        let (t, kind) = (f64::from(step) * STEP_S, lane as f64);
        let sink = hover - 0.02 - 0.004 * kind;
        let roll = 0.004 * (9.0 * t + kind).sin();
        // Nobody holds the attitude: down before it tumbles.
        let throttle = if t < 0.1 { sink } else { 0.0 };
        let disturbance = Disturbance {
            wind_mps: [0.3 * kind, -0.2, 0.1 * (3.0 * t).sin()],
            turbulence_n: [0.05 * (20.0 * t).sin(), 0.0, 0.02 * kind, 0.01],
        };
        let [a, b] = [throttle + roll, throttle - roll];
        ([a, a, b, b], disturbance)
    }

    struct Fly<'a> {
        vehicle: &'a RigidVehicle,
        deck: &'a RigidDeck,
        start: RigidState,
        hover: f64,
    }

    impl Fly<'_> {
        fn kind(lane: usize) -> [f64; 4] {
            [0.01 * lane as f64, 0.0, -0.01, 0.02]
        }

        fn alone(&self, lane: usize) -> RigidState {
            let vehicle = self
                .vehicle
                .clone()
                .with_thrust_scale_error(Self::kind(lane));
            let mut state = self.start;
            for step in 0..STEPS {
                let (throttle, disturbance) = commands(lane, step, self.hover);
                let t = f64::from(step) * STEP_S;
                let deck = [t, t + 0.5 * STEP_S, t + STEP_S].map(|t| self.deck.at(t));
                vehicle.step(&mut state, &deck, &throttle, &disturbance, STEP_S);
            }
            state
        }
    }

    fn wide<N: Number>(like: N, of: impl Fn(usize) -> f64) -> N {
        let mut row = [0.0; MOST_LANES];
        for (lane, value) in row.iter_mut().enumerate() {
            *value = of(lane);
        }
        like.of_lanes(&row)
    }

    impl WithSimd for Fly<'_> {
        type Output = Vec<RigidState>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let zero = Lanes::splat(simd, 0.0);
            let legs = self.vehicle.legs.as_ref().expect("it has legs");
            let mut kind = Kind {
                thrust_scale_error: [zero; 4],
                ground_effect_scale: zero.like(self.vehicle.rotors.ground_effect_scale()),
            };
            for i in 0..4 {
                kind.thrust_scale_error[i] = wide(zero, |lane| Self::kind(lane)[i]);
            }
            let start = self.start.moving().to_array();
            let mut state = Moving::from_array(&start.map(|value| zero.like(value)));
            let mut foothold = Foothold {
                sticks: [zero.below(zero); 4],
                stuck_m: [[zero; 2]; 4],
            };
            for step in 0..STEPS {
                let of = |lane| commands(lane, step, self.hover);
                let input = Input {
                    throttle: [0, 1, 2, 3].map(|i| wide(zero, |lane| of(lane).0[i])),
                    wind_mps: [0, 1, 2].map(|k| wide(zero, |lane| of(lane).1.wind_mps[k])),
                    turbulence_n: [0, 1, 2, 3]
                        .map(|i| wide(zero, |lane| of(lane).1.turbulence_n[i])),
                };
                let t = f64::from(step) * STEP_S;
                let deck = [t, t + 0.5 * STEP_S, t + STEP_S].map(|t| {
                    let pose = self.deck.at(t);
                    let of = |v: [f64; 3]| v.map(|value| zero.like(value));
                    DeckPose {
                        origin_m: of(pose.origin_m),
                        velocity_mps: of(pose.velocity_mps),
                        acceleration_mps2: of(pose.acceleration_mps2),
                        axes: pose.axes.map(of),
                        angular_velocity: of(pose.angular_velocity),
                        angular_acceleration: of(pose.angular_acceleration),
                    }
                });
                // With legs at all steps: far from the deck they change nothing.
                let mut standing = Standing { legs, foothold };
                let contact = Some(&mut standing);
                self.vehicle
                    .advance(&kind, &mut state, &deck, &input, contact, STEP_S);
                foothold = standing.foothold;
            }
            let ones = zero.like(1.0);
            let sticks = foothold
                .sticks
                .map(|truth| Lanes::choose(truth, ones, zero));
            let at = |lane: usize| {
                let mut one = RigidState::default();
                let values = state.to_array().map(|value| value.get(lane));
                one.take(&Moving::from_array(&values));
                one.contact = ContactState::of(&Foothold {
                    sticks: sticks.map(|value| value.get(lane) > 0.0),
                    stuck_m: foothold.stuck_m.map(|place| place.map(|m| m.get(lane))),
                });
                one
            };
            (0..Lanes::<S>::COUNT).map(at).collect()
        }
    }

    #[test]
    fn prop_a_lane_is_a_vehicle_stepped_alone() {
        let tone = |axis, amplitude, frequency_hz| Tone {
            axis,
            amplitude,
            frequency_hz,
            phase_rad: 0.3,
        };
        let tones = vec![tone(Axis::Heave, 0.05, 0.5), tone(Axis::Roll, 0.05, 0.3)];
        let deck = RigidMotion::Sines { tones }.build(9.81, 0, 0);
        let deck = deck.expect("valid waves");
        let plant = PlantSettings::default();
        let vehicle = RigidVehicle::new(&plant, &BodySettings::default())
            .and_then(|vehicle| vehicle.with_legs(&LegSettings::default(), &plant))
            .expect("valid settings");
        let (start, hover) = vehicle.balanced(0.12, &deck.at(0.0));
        let fly = Fly {
            vehicle: &vehicle,
            deck: &deck,
            start,
            hover,
        };
        let alone: Vec<RigidState> = (0..MOST_LANES).map(|lane| fly.alone(lane)).collect();
        let stands = |state: &&RigidState| state.contact.stuck_m.iter().flatten().count() >= 3;
        assert!(alone.iter().filter(stands).count() >= 2, "{alone:?}");
        // Bit for bit: the same operations in the same order, none contracted.
        for (lane, state) in Arch::new().dispatch(fly).into_iter().enumerate() {
            assert_eq!(state, alone[lane], "lane {lane}");
        }
    }
}
