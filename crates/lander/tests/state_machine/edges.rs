//! Odd steps, single precision, settings.

use touchdown_lander::state_machine::{Funnel, MachineInput, Phase, StateMachine};

use crate::world::{DT, Flight, good};

#[test]
fn analytic_long_steps_are_gaps() {
    // One sample a second: nothing has ever held for half a second.
    let state_machine = StateMachine::<f64>::default();
    let mut state = state_machine.initial();
    let mut out = state_machine.step(&mut state, &good(), 1.0);
    for _ in 0..100 {
        out = state_machine.step(&mut state, &good(), 1.0);
        assert_eq!(out.phase, Phase::Hold);
    }
    // But the time has passed.
    for _ in 0..30 {
        out = state_machine.step(&mut state, &good(), 1.0);
    }
    assert_eq!(out.phase, Phase::GivenUp);
    // Steps without a time: none passes.
    let mut state = state_machine.initial();
    for dt in [f64::NAN, -1.0, 0.0, f64::INFINITY].repeat(100) {
        assert_eq!(
            state_machine.step(&mut state, &good(), dt).phase,
            Phase::Hold
        );
    }
}

#[test]
fn prop_single_precision_takes_the_same_way() {
    let narrow = |s: &MachineInput<f64>| MachineInput::<f32> {
        tag_age_s: s.tag_age_s as f32,
        range_age_s: s.range_age_s as f32,
        imu_age_s: s.imu_age_s as f32,
        diverged: s.diverged,
        foot_drop_m: s.foot_drop_m as f32,
        wind_slope: s.wind_slope as f32,
        gusty: s.gusty,
        hold_extra_m: s.hold_extra_m as f32,
        height_m: s.height_m as f32,
        height_sd_m: s.height_sd_m as f32,
        relative_velocity_mps: s.relative_velocity_mps as f32,
        lateral_error_m: s.lateral_error_m as f32,
        lateral_speed_mps: s.lateral_speed_mps as f32,
        tilt_rad: s.tilt_rad as f32,
        saturated: s.saturated,
        deck_tilt_rad: s.deck_tilt_rad as f32,
        deck_speed_mps: s.deck_speed_mps as f32,
        battery_share: s.battery_share as f32,
        thrust_share: s.thrust_share as f32,
        load_factor: s.load_factor as f32,
        support_share: s.support_share as f32,
        contact: s.contact,
        go: s.go,
        request: s.request,
    };
    let state_machine = StateMachine::<f32>::default();
    state_machine.validate().unwrap();
    let mut state = state_machine.initial();
    let mut flight = Flight::new();
    let mut differ = 0;
    for _ in 0..2500 {
        let seen = flight.world.seen();
        let single = state_machine.step(&mut state, &narrow(&seen), DT as f32);
        let double = flight.step(|_| ());
        differ += u32::from(single.phase != double.phase);
    }
    assert_eq!(state.phase(), Phase::Disarmed);
    // A time may be reached a step later by rounding, at each of five changes.
    assert!(differ <= 5, "{differ}");
}

#[test]
fn analytic_settings_are_checked() {
    let refused = |change: fn(&mut StateMachine<f64>), key: &str| {
        let mut state_machine = StateMachine::default();
        change(&mut state_machine);
        let error = state_machine.validate().unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    };
    refused(|l| l.confirm_s = 0.0, "lander.confirm_s");
    refused(|l| l.tag_age_s = f64::NAN, "lander.tag_age_s");
    refused(|l| l.commit_height_m = 0.1, "lander.touchdown_height_m");
    refused(|l| l.hold_height_m = 0.5, "lander.commit_height_m");
    refused(|l| l.idle_thrust_share = 0.8, "lander.idle_thrust_share");
    refused(|l| l.supported_load_factor = 1.0, "supported_load_factor");
    refused(|l| l.battery_low = 1.5, "lander.battery_low");
    refused(|l| l.battery_critical = 0.3, "lander.battery_critical");
    refused(
        |l| {
            l.lateral_m = Funnel {
                at_deck: 0.1,
                per_m: -0.1,
            };
        },
        "lander.lateral_m.per_m",
    );
}
