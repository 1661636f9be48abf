//! The touch: found soon, and never in the air, by a vehicle whose rotors and sensors lag.

use proptest::prelude::*;
use touchdown_lander::state_machine::{MachineInput, MachineState, Maneuver, Phase, StateMachine};

use crate::world::{DT, STANDING_M, good};

/// Lag of the rotors, s, and delay of what the inertial unit measures, in steps.
const ROTOR_S: f64 = 0.05;
const DELAY: usize = 3;

/// A vehicle above a level deck: heights in m, forces in shares of the weight.
struct Vehicle {
    height_m: f64,
    velocity_mps: f64,
    commanded: f64,
    thrust: f64,
    /// The load factors of the last steps, newest last.
    loads: [f64; DELAY],
    /// The deck's force on the legs.
    support: f64,
}

impl Vehicle {
    /// In balance.
    fn at(height_m: f64, ground_effect: f64) -> Self {
        let thrust = 1.0 / (1.0 + ground_effect);
        Self {
            height_m,
            velocity_mps: 0.0,
            commanded: thrust,
            thrust,
            loads: [1.0; DELAY],
            support: 0.0,
        }
    }

    fn stands(&self) -> bool {
        self.height_m <= STANDING_M
    }

    /// A step in which the ground effect lifts by a share of the thrust.
    fn fly(&mut self, maneuver: Maneuver<f64>, ground_effect: f64) {
        let lift = 1.0 + ground_effect;
        self.commanded = match maneuver {
            // 40 N/s of a vehicle of 13.4 N.
            Maneuver::Idle => (self.commanded - 3.0 * DT).max(0.0),
            Maneuver::Rest => self.commanded,
            Maneuver::Disarm => 0.0,
            // A controller that sinks at 0.05 m/s.
            _ => ((1.0 - 5.0 * (self.velocity_mps + 0.05) / 9.81) / lift).clamp(0.0, 2.0),
        };
        self.thrust += (self.commanded - self.thrust) * DT / (ROTOR_S + DT);
        let free = self.thrust * lift;
        self.support = if self.stands() {
            (1.0 - free).max(0.0)
        } else {
            0.0
        };
        self.loads.rotate_left(1);
        self.loads[DELAY - 1] = free + self.support;
        self.velocity_mps += 9.81 * (free + self.support - 1.0) * DT;
        self.height_m += DT * self.velocity_mps;
        if self.stands() {
            self.height_m = STANDING_M;
            self.velocity_mps = self.velocity_mps.max(0.0);
        }
    }
}

/// What is wrong in a step: errors of height (m), velocity (m/s) and load factor, and the force that the deck seems to have.
#[derive(Clone, Copy, Debug)]
struct Wrong {
    height_m: f64,
    velocity_mps: f64,
    load: f64,
    support: f64,
}

/// Errors as large as those of a range finder in whole centimetres, of a filter at contact and of a shaking body, and any force.
fn wrong() -> impl Strategy<Value = Wrong> {
    let support = prop_oneof![Just(f64::NAN), Just(0.0), Just(1.0), -0.5..1.5_f64];
    (-0.02..0.02_f64, -0.1..0.1_f64, -0.05..0.05_f64, support).prop_map(
        |(height_m, velocity_mps, load, support)| Wrong {
            height_m,
            velocity_mps,
            load,
            support,
        },
    )
}

fn seen(vehicle: &Vehicle, wrong: &Wrong) -> MachineInput<f64> {
    MachineInput {
        height_m: vehicle.height_m + wrong.height_m,
        relative_velocity_mps: vehicle.velocity_mps + wrong.velocity_mps,
        thrust_share: vehicle.commanded,
        load_factor: vehicle.loads[0] + wrong.load,
        support_share: wrong.support,
        ..good()
    }
}

/// A machine in `Commit`.
fn committed() -> (StateMachine<f64>, MachineState<f64>) {
    let machine = StateMachine::default();
    let mut state = machine.initial();
    for step in 0..400 {
        let height_m = if step < 200 { 0.8 } else { 0.25 };
        let input = MachineInput { height_m, ..good() };
        if machine.step(&mut state, &input, DT).phase == Phase::Commit {
            return (machine, state);
        }
    }
    panic!("no descent");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever force the models find, and with noise on all else, the rotors stop on the deck only.
    #[test]
    fn prop_rotors_never_stop_in_the_air(
        start_m in 0.1005..0.3_f64,
        ground_effect in 0.0..0.2_f64,
        bias in wrong(),
        noise in proptest::collection::vec((wrong(), 1..40_usize), 10..60),
    ) {
        let (machine, mut state) = committed();
        let mut vehicle = Vehicle::at(start_m, ground_effect);
        for (wrong, steps) in noise {
            for _ in 0..steps {
                let wrong = Wrong {
                    height_m: bias.height_m + 0.5 * wrong.height_m,
                    velocity_mps: bias.velocity_mps + 0.5 * wrong.velocity_mps,
                    ..wrong
                };
                let out = machine.step(&mut state, &seen(&vehicle, &wrong), DT);
                if out.phase == Phase::Disarmed {
                    prop_assert!(vehicle.stands(), "{} m", vehicle.height_m);
                    return Ok(());
                }
                vehicle.fly(out.maneuver, ground_effect);
            }
        }
    }

    /// From the contact on: 30 ms of felt force, half the weight in 1/6 s, and 0.2 s of evidence; 50 ms for what lags.
    #[test]
    fn prop_a_contact_that_is_felt_stops_the_rotors_within_0_45_s(
        height_m in -0.01..0.018_f64,
        velocity_mps in -0.2..0.2_f64,
        load in -0.05..0.05_f64,
        ground_effect in 0.0..0.2_f64,
    ) {
        let (machine, mut state) = committed();
        let mut vehicle = Vehicle::at(STANDING_M, ground_effect);
        let mut steps = 0;
        loop {
            // The first contact presses the legs with a tenth of the weight.
            let support = vehicle.support.max(0.1);
            let wrong = Wrong { height_m, velocity_mps, load, support };
            let out = machine.step(&mut state, &seen(&vehicle, &wrong), DT);
            if out.phase == Phase::Disarmed {
                break;
            }
            vehicle.fly(out.maneuver, ground_effect);
            steps += 1;
            prop_assert!(f64::from(steps) * DT < 0.45, "{:?}", out.phase);
        }
    }
}

/// The generator of the first property reaches stops and touchdowns that begin in the air: without them it holds for want of a case.
#[test]
fn prop_the_noise_reaches_stops_and_false_touches() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let errors = proptest::collection::vec((wrong(), 1..40_usize), 10..60);
    let (mut stops, mut in_the_air) = (0, 0);
    for _ in 0..200 {
        let (machine, mut state) = committed();
        let mut vehicle = Vehicle::at(0.12, 0.1);
        'flight: for (wrong, steps) in errors.new_tree(&mut runner).unwrap().current() {
            for _ in 0..steps {
                let out = machine.step(&mut state, &seen(&vehicle, &wrong), DT);
                if out.phase == Phase::Disarmed {
                    stops += 1;
                    break 'flight;
                }
                in_the_air += u32::from(out.phase == Phase::Touchdown && !vehicle.stands());
                vehicle.fly(out.maneuver, 0.1);
            }
        }
    }
    assert!(stops > 100 && in_the_air > 100, "{stops} {in_the_air}");
}

#[test]
fn prop_a_vehicle_that_the_deck_carries_is_down_at_any_estimated_speed() {
    let (machine, mut state) = committed();
    // A deck that sways out of the tag's sight: height and velocity drift, the feet press.
    let drifts = |thrust_share| MachineInput {
        height_m: 0.14,
        relative_velocity_mps: 0.3,
        lateral_speed_mps: 0.6,
        support_share: 1.0 - thrust_share,
        load_factor: 1.0,
        thrust_share,
        ..good()
    };
    let mut phases = Vec::new();
    for step in 0..60 {
        let thrust_share = (0.8 - 3.0 * DT * f64::from(step)).max(0.2);
        let out = machine.step(&mut state, &drifts(thrust_share), DT);
        if phases.last() != Some(&out.phase) {
            phases.push(out.phase);
        }
    }
    assert_eq!(phases, [Phase::Commit, Phase::Touchdown, Phase::Disarmed]);
    // The same without the force is flown on.
    let (machine, mut state) = committed();
    for _ in 0..60 {
        let input = MachineInput {
            support_share: 0.0,
            ..drifts(0.8)
        };
        let out = machine.step(&mut state, &input, DT);
        assert_ne!(out.phase, Phase::Touchdown);
    }
}
