//! What the machine promises for any sequence of inputs.

use proptest::prelude::*;
use touchdown_lander::state_machine::{MachineInput, OperatorRequest, Phase, StateMachine};

use crate::world::{DT, Flight, good};

/// The input's data are fresh and finite, written out anew from the settings'
/// meaning.
fn is_fresh(state_machine: &StateMachine<f64>, s: &MachineInput<f64>) -> bool {
    let young = |age: f64, limit: f64| (0.0..=limit).contains(&age);
    // The tag gives the whole position, the height as well.
    young(s.tag_age_s, state_machine.tag_age_s)
        && young(s.imu_age_s, state_machine.imu_age_s)
        && !s.diverged
        && s.height_m.is_finite()
        && s.relative_velocity_mps.is_finite()
        && s.lateral_error_m.is_finite()
        && s.tilt_rad.is_finite()
}

/// Evidence of a touchdown, written out anew.
fn is_evidence(state_machine: &StateMachine<f64>, s: &MachineInput<f64>) -> bool {
    let young = |age: f64, limit: f64| (0.0..=limit).contains(&age);
    let measured = young(s.range_age_s, state_machine.range_age_s)
        || young(s.tag_age_s, state_machine.tag_age_s)
        || young(s.height_sd_m, state_machine.coast_sd_m);
    let near = measured
        && young(s.imu_age_s, state_machine.imu_age_s)
        && !s.diverged
        && s.height_m <= state_machine.touchdown_height_m
        && s.relative_velocity_mps.abs() <= state_machine.touchdown_speed_mps
        && s.lateral_speed_mps.abs() <= state_machine.touchdown_lateral_mps;
    let carried = match s.thrust_share {
        // Rotors that hardly turn: all beyond their thrust and a fifth of the weight.
        share if share <= 0.1 => s.load_factor - share >= 0.2 - 1e-12,
        share => {
            share <= state_machine.idle_thrust_share
                && s.load_factor >= state_machine.supported_load_factor
        }
    };
    near && match s.contact {
        Some(contact) => contact,
        None => carried,
    }
}

/// Watches a machine and checks the promises in every step.
struct Watch {
    flight: Flight,
    evidence_s: Option<f64>,
    restarts: u32,
    critical: bool,
    aborted: u32,
    descents: u32,
    disarmed: u32,
}

impl Watch {
    fn new() -> Self {
        Self {
            flight: Flight::new(),
            evidence_s: None,
            restarts: 0,
            critical: false,
            aborted: 0,
            descents: 0,
            disarmed: 0,
        }
    }

    fn step(&mut self, seen: &MachineInput<f64>, dt: f64) {
        let state_machine = self.flight.state_machine;
        let before = self.flight.state.phase();
        let out = state_machine.step(&mut self.flight.state, seen, dt);
        self.flight.world.fly(out.maneuver);
        let passed = if dt.is_finite() && dt > 0.0 { dt } else { 0.0 };
        self.evidence_s = match self.evidence_s {
            Some(t)
                if is_evidence(&state_machine, seen) && passed <= state_machine.greatest_step_s =>
            {
                Some(t + passed)
            }
            _ => is_evidence(&state_machine, seen).then_some(0.0),
        };
        if out.phase == Phase::Descend && before != Phase::Descend {
            self.descents += 1;
            assert!(is_fresh(&state_machine, seen), "{seen:?}");
            assert!(matches!(before, Phase::Wait | Phase::Commit), "{before:?}");
        }
        if out.phase == Phase::Disarmed && before != Phase::Disarmed {
            self.disarmed += 1;
            // Rounding of the sum of at most some thousand steps.
            let held = self.evidence_s.unwrap_or(0.0) + 1e-9;
            assert!(
                seen.request == OperatorRequest::Disarm || held >= state_machine.confirm_s,
                "{before:?} {held} {seen:?}"
            );
        }
        if before == Phase::Disarmed && out.phase != Phase::Disarmed {
            assert_eq!(seen.request, OperatorRequest::Restart);
        }
        // Tries are limited where neither operator nor battery says otherwise.
        self.restarts += u32::from(seen.request == OperatorRequest::Restart);
        let counted = seen.request != OperatorRequest::Abort;
        self.aborted +=
            u32::from(out.phase == Phase::GoAround && before != Phase::GoAround && counted);
        self.critical |= seen.battery_share <= state_machine.battery_critical;
        if self.restarts == 0 && !self.critical {
            let most = state_machine.go_arounds
                + state_machine.wind_go_arounds
                + state_machine.hover_go_arounds
                + 1;
            assert!(out.go_arounds <= most);
        }
    }
}

/// A number that is good most of the time, and otherwise anything.
fn mostly(value: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        12 => Just(value),
        1 => proptest::num::f64::ANY,
        1 => Just(f64::NAN),
        2 => (-2.0..2.0_f64).prop_map(move |factor| factor * value),
    ]
}

fn request() -> impl Strategy<Value = OperatorRequest> {
    prop_oneof![
        30 => Just(OperatorRequest::None),
        1 => Just(OperatorRequest::Abort),
        1 => Just(OperatorRequest::Restart),
    ]
}

prop_compose! {
    /// Any input, without a world behind it.
    fn any_input()(
        ages in (mostly(0.05), mostly(0.02), mostly(0.002), mostly(0.01)),
        place in (prop_oneof![Just(0.8), Just(0.25), Just(0.1), mostly(0.5)], mostly(0.05)),
        lateral in (mostly(0.02), mostly(0.01), mostly(0.02)),
        air in (mostly(0.3), prop::bool::weighted(0.05)),
        deck in (mostly(0.03), mostly(0.15), mostly(0.7)),
        forces in (prop_oneof![Just(1.0), Just(0.3), mostly(0.5)], mostly(1.0), mostly(0.05)),
        flags in (prop::bool::weighted(0.03), prop::bool::weighted(0.05), prop::bool::weighted(0.7)),
        contact in prop_oneof![8 => Just(None), 1 => Just(Some(true)), 1 => Just(Some(false))],
        request in prop_oneof![20 => request(), 1 => Just(OperatorRequest::Disarm)],
    ) -> MachineInput<f64> {
        MachineInput {
            tag_age_s: ages.0, range_age_s: ages.1, imu_age_s: ages.2,
            diverged: flags.0, saturated: flags.1, go: flags.2,
            height_m: place.0, height_sd_m: ages.3, foot_drop_m: 0.0, hold_extra_m: 0.0, wind_slope: air.0, gusty: air.1, relative_velocity_mps: place.1,
            lateral_error_m: lateral.0, lateral_speed_mps: lateral.1, tilt_rad: lateral.2,
            deck_tilt_rad: deck.0, deck_speed_mps: deck.1, battery_share: deck.2,
            thrust_share: forces.0, load_factor: forces.1,
            support_share: forces.2, contact, request,
        }
    }
}

/// Something that goes wrong in the world for a while.
#[derive(Clone, Copy, Debug)]
struct Fault {
    kind: u8,
    value: f64,
    request: OperatorRequest,
    steps: u16,
}

impl Fault {
    fn apply(&self, s: &mut MachineInput<f64>) {
        s.request = self.request;
        match self.kind {
            0 => s.tag_age_s = self.value,
            1 => s.range_age_s = self.value,
            2 => s.imu_age_s = self.value,
            3 => s.height_m = self.value,
            4 => s.relative_velocity_mps = self.value,
            5 => s.lateral_error_m = self.value,
            6 => s.tilt_rad = self.value,
            7 => s.load_factor = self.value,
            8 => s.thrust_share = self.value,
            9 => s.battery_share = self.value,
            10 => s.deck_tilt_rad = self.value,
            11 => s.saturated = true,
            12 => s.diverged = true,
            13 => s.contact = Some(self.value > 0.0),
            14 => s.go = false,
            _ => {}
        }
    }
}

fn faults() -> impl Strategy<Value = Vec<Fault>> {
    let value = prop_oneof![
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(0.1),
        Just(0.05),
        -1.0..2.0_f64,
    ];
    let fault =
        (0..40_u8, value, request(), 1..300_u16).prop_map(|(kind, value, request, steps)| Fault {
            kind,
            value,
            request,
            steps,
        });
    proptest::collection::vec(fault, 1..30)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn prop_promises_hold_for_any_input(
        inputs in proptest::collection::vec((any_input(), mostly(0.05), 1..20_usize), 1..60),
    ) {
        let mut watch = Watch::new();
        for (seen, dt, times) in inputs {
            for _ in 0..times {
                watch.step(&seen, dt);
            }
        }
    }

    #[test]
    fn prop_promises_hold_in_a_world_with_faults(faults in faults()) {
        let mut watch = Watch::new();
        for fault in faults {
            for _ in 0..fault.steps {
                let mut seen = watch.flight.world.seen();
                fault.apply(&mut seen);
                watch.step(&seen, DT);
            }
        }
    }

    #[test]
    fn prop_no_state_without_a_way_out(faults in faults()) {
        let mut flight = Flight::new();
        for fault in &faults {
            for _ in 0..fault.steps {
                flight.step(|s| fault.apply(s));
            }
        }
        // From wherever this has led: nothing wrong any more, and an operator who
        // starts anew where it has given up. It lands within a minute.
        if flight.state.phase() == Phase::Disarmed {
            flight.step(|_| ());
            flight.step(|s| s.request = OperatorRequest::Restart);
            prop_assert_eq!(flight.state.phase(), Phase::Approach);
        }
        for i in 0..6000 {
            let given_up = flight.state.phase() == Phase::GivenUp;
            flight.step(|s| {
                if given_up && i % 2 == 1 {
                    s.request = OperatorRequest::Restart;
                }
            });
        }
        prop_assert_eq!(flight.state.phase(), Phase::Disarmed);
        prop_assert!(flight.world.standing());
    }
}

/// The generators reach what the promises are about; without this a promise
/// could hold for want of a descent.
#[test]
fn prop_the_faults_reach_descents_and_touchdowns() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let (mut descents, mut disarmed, mut aborted) = (0, 0, 0);
    for _ in 0..200 {
        let mut watch = Watch::new();
        for fault in faults().new_tree(&mut runner).unwrap().current() {
            for _ in 0..fault.steps {
                let mut seen = watch.flight.world.seen();
                fault.apply(&mut seen);
                watch.step(&seen, DT);
            }
        }
        descents += watch.descents;
        disarmed += watch.disarmed;
        aborted += watch.aborted;
    }
    // Of 200 flights of half a minute.
    assert!(
        descents > 100 && disarmed > 20 && aborted > 50,
        "{descents} {disarmed} {aborted}"
    );
}

#[test]
fn prop_nan_lets_nothing_through() {
    type Change = fn(&mut MachineInput<f64>);
    let numbers: [Change; 13] = [
        |s| s.tag_age_s = f64::NAN,
        |s| (s.range_age_s, s.tag_age_s, s.height_sd_m) = (f64::NAN, f64::NAN, f64::NAN),
        |s| s.imu_age_s = f64::NAN,
        |s| s.height_m = f64::NAN,
        |s| s.relative_velocity_mps = f64::NAN,
        |s| s.lateral_error_m = f64::NAN,
        |s| s.lateral_speed_mps = f64::NAN,
        |s| s.tilt_rad = f64::NAN,
        |s| s.deck_tilt_rad = f64::NAN,
        |s| s.deck_speed_mps = f64::NAN,
        |s| s.battery_share = f64::NAN,
        |s| s.thrust_share = f64::NAN,
        |s| s.load_factor = f64::NAN,
    ];
    for (i, change) in numbers.into_iter().enumerate() {
        // From the start: no descent.
        let mut flight = Flight::new();
        for _ in 0..2000 {
            let out = flight.step(change);
            assert!(
                matches!(
                    out.phase,
                    Phase::Approach | Phase::Hold | Phase::GoAround | Phase::GivenUp
                ),
                "{i} {out:?}"
            );
        }
        // On the deck, from the first moment of thrust taken back: no disarming
        // where the number is part of the evidence.
        let mut flight = Flight::new();
        flight.until(|out| out.phase == Phase::Touchdown);
        let evidence = [1, 2, 3, 4, 6, 11, 12].contains(&i);
        for _ in 0..200 {
            let out = flight.step(change);
            assert!(!(evidence && out.phase == Phase::Disarmed), "{i}");
        }
    }
}

#[test]
fn prop_lying_sensors_one_at_a_time_do_not_disarm_in_the_air() {
    type Lie = fn(&mut MachineInput<f64>);
    let lies: [Lie; 6] = [
        |s| s.height_m = 0.1,
        |s| {
            // A stuck range finder, and velocity estimated from it.
            s.height_m = 0.1;
            s.relative_velocity_mps = 0.0;
        },
        |s| s.load_factor = 1.0,
        |s| s.contact = Some(true),
        |s| s.thrust_share = 0.2,
        |s| s.relative_velocity_mps = 0.0,
    ];
    for (i, lie) in lies.into_iter().enumerate() {
        for start in [Phase::Hold, Phase::Descend, Phase::Commit] {
            let mut flight = Flight::new();
            flight.until(|out| out.phase == start);
            for _ in 0..3000 {
                let out = flight.step(lie);
                // Where it is disarmed it stands.
                assert!(
                    out.phase != Phase::Disarmed || flight.world.standing(),
                    "{i} {start:?}"
                );
            }
        }
    }
    // The input of the tests is itself good.
    let mut flight = Flight::new();
    assert_eq!(flight.step(|s| *s = good()).phase, Phase::Hold);
}
