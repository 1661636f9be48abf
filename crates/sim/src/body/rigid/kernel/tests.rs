//! Lanes against vehicles stepped alone.

use pulp::{Arch, Simd, WithSimd};

use super::*;
use crate::STEP_S;
use crate::body::BodySettings;
use crate::body::contact::{ContactState, LegSettings};
use crate::body::plant::PlantSettings;
use crate::body::rigid::{Disturbance, RigidState};
use crate::deck::rigid::{Axis, RigidDeck, RigidMotion, Tone};
use crate::number::MOST_LANES;
use crate::number::lanes::Lanes;

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
        let mut kind = VehicleVariation {
            thrust_scale_error: [zero; 4],
            ground_effect_scale: zero.splat(self.vehicle.rotors.ground_effect_scale()),
        };
        for i in 0..4 {
            kind.thrust_scale_error[i] = wide(zero, |lane| Self::kind(lane)[i]);
        }
        let start = self.start.moving().to_array();
        let mut state = MotionState::from_array(&start.map(|value| zero.splat(value)));
        let mut foothold = Foothold {
            sticks: [zero.below(zero); 4],
            stuck_m: [[zero; 2]; 4],
        };
        for step in 0..STEPS {
            let t = f64::from(step) * STEP_S;
            let deck = [t, t + 0.5 * STEP_S, t + STEP_S].map(|t| {
                let pose = self.deck.at(t);
                let of = |v: [f64; 3]| v.map(|value| zero.splat(value));
                DeckPose {
                    origin_m: of(pose.origin_m),
                    velocity_mps: of(pose.velocity_mps),
                    acceleration_mps2: of(pose.acceleration_mps2),
                    axes: pose.axes.map(of),
                    angular_velocity: of(pose.angular_velocity),
                    angular_acceleration: of(pose.angular_acceleration),
                }
            });
            let of = |lane| commands(lane, step, self.hover);
            let shares = self.vehicle.shares_ahead(&state, 0.5 * STEP_S, &deck[1]);
            let input = Input {
                shares,
                throttle: [0, 1, 2, 3].map(|i| wide(zero, |lane| of(lane).0[i])),
                wind_mps: [0, 1, 2].map(|k| wide(zero, |lane| of(lane).1.wind_mps[k])),
                turbulence_n: [0, 1, 2, 3].map(|i| wide(zero, |lane| of(lane).1.turbulence_n[i])),
            };
            // With legs at all steps: far from the deck they change nothing.
            let mut standing = LegContact { legs, foothold };
            let contact = Some(&mut standing);
            self.vehicle
                .advance(&kind, &mut state, &deck, &input, contact, STEP_S);
            foothold = standing.foothold;
        }
        let ones = zero.splat(1.0);
        let sticks = foothold
            .sticks
            .map(|truth| Lanes::select(truth, ones, zero));
        let at = |lane: usize| {
            let mut one = RigidState::default();
            let values = state.to_array().map(|value| value.get(lane));
            one.take(&MotionState::from_array(&values));
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
