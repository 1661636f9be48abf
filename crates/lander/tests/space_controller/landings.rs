//! State machine, planner, guidance and controller together, until the rotors stop.

use touchdown_flight::Vector;
use touchdown_flight::reference::Reference;
use touchdown_lander::control::Observer;
use touchdown_lander::guidance::{Guidance, GuidanceCommand};
use touchdown_lander::planner::{DeckOutlook, Planner};
use touchdown_lander::space_controller::{SpaceCommand, SpaceController};
use touchdown_lander::state_machine::{MachineInput, OperatorRequest, Phase, Reason, StateMachine};

use crate::common::flight::{GRAVITY, WEIGHT_N, lag};
use crate::plant::{Plant, hover_throttle, space_controller};

const DT: f64 = 0.01;

/// What a flight came to.
#[derive(Debug)]
struct Record {
    phases: Vec<Phase>,
    reasons: Vec<Reason>,
    /// Greatest speed towards the deck when the legs first touched, m/s.
    impact_mps: Option<f64>,
    /// From the start of the last descent to the legs' first touch, s.
    descent_s: f64,
    lateral_m: f64,
    go_arounds: u8,
    least_height_m: f64,
}

/// Flies until disarmed, at most two minutes, with what is seen changed.
fn fly(plant: &mut Plant, change: impl Fn(&mut MachineInput<f64>, Phase, f64)) -> Record {
    let controller = SpaceController {
        observer: Some(Observer::default()),
        ..space_controller(lag())
    };
    let (state_machine, planner, guidance) = (
        StateMachine::default(),
        Planner::default(),
        Guidance::default(),
    );
    guidance.validate().unwrap();
    let mut controller_state = controller.initial(&plant.sense(), hover_throttle());
    let (mut state, mut planning, mut guiding) = (
        state_machine.initial(),
        planner.initial(),
        guidance.initial(),
    );
    let mut command = SpaceCommand {
        thrust_n: WEIGHT_N,
        ..SpaceCommand::default()
    };
    let mut record = Record {
        phases: vec![],
        reasons: vec![],
        impact_mps: None,
        descent_s: 0.0,
        lateral_m: 0.0,
        go_arounds: 0,
        least_height_m: f64::INFINITY,
    };
    let mut descending_s = 0.0;
    for _ in 0..12_000 {
        let motion = plant.sense();
        let now = plant.time_s;
        let world = plant.clone();
        let forecast = move |t: f64| {
            let [_, velocity_mps, acceleration_mps2] = world.deck(now + t);
            DeckOutlook {
                velocity_mps,
                acceleration_mps2,
                ..DeckOutlook::default()
            }
        };
        if state.phase() != Phase::Wait {
            planning = planner.initial();
        }
        let verdict = planner.step(&mut planning, motion.position_m.z, false, &forecast, DT);
        let plan = verdict.plan();
        let felt = plant.acceleration() + Vector::UP * GRAVITY;
        let mut seen = MachineInput {
            tag_age_s: 0.05,
            range_age_s: 0.03,
            imu_age_s: 0.005,
            diverged: false,
            foot_drop_m: 0.0,
            wind_slope: 0.0,
            gusty: false,
            hold_extra_m: 0.0,
            height_m: motion.position_m.z,
            height_sd_m: 0.01,
            relative_velocity_mps: motion.relative_velocity_mps.z,
            lateral_error_m: motion.position_m.horizontal().norm(),
            lateral_speed_mps: motion.relative_velocity_mps.horizontal().norm(),
            tilt_rad: motion.attitude.tilt_rad(),
            saturated: command.saturated,
            deck_tilt_rad: 0.0,
            deck_speed_mps: plant.heave.0 * plant.heave.1,
            battery_share: 0.6,
            thrust_share: command.thrust_n / WEIGHT_N,
            load_factor: felt.dot(plant.up) / GRAVITY,
            support_share: 0.0,
            contact: None,
            go: plan.is_some(),
            request: OperatorRequest::None,
        };
        change(&mut seen, state.phase(), now);
        let out = state_machine.step(&mut state, &seen, DT);
        if record.phases.last() != Some(&out.phase) {
            record.phases.push(out.phase);
            record.reasons.extend(out.reason);
            if out.phase == Phase::Descend {
                descending_s = now;
            }
        }
        let [_, _, ahead] = plant.deck(now + 0.07);
        let deck = Vector::UP * ahead;
        let descent = plan.map(|plan| Reference::Terminal(plan.reference));
        let order = guidance.step(
            &mut guiding,
            out.maneuver,
            descent.as_ref(),
            &motion,
            deck,
            DT,
        );
        command = match order {
            GuidanceCommand::Track(target) => {
                controller.step(&mut controller_state, &motion, &target, DT)
            }
            GuidanceCommand::Idle { rate_n_per_s } => {
                controller.idle(&mut controller_state, &motion, rate_n_per_s, DT)
            }
            GuidanceCommand::Off => break,
        };
        plant.fly(&command);
        record.least_height_m = record.least_height_m.min(plant.height_m());
        if plant.legs_n() > 0.0 && record.impact_mps.is_none() {
            record.impact_mps = Some(-plant.relative_velocity_mps());
            record.descent_s = plant.time_s - descending_s;
            record.lateral_m = plant.position_m.horizontal().norm();
        }
        record.go_arounds = out.go_arounds;
    }
    record
}

fn over(amplitude_m: f64, hertz: f64) -> Plant {
    let mut plant = Plant::new(Vector::new(0.1, -0.05, 0.8));
    plant.heave = (amplitude_m, core::f64::consts::TAU * hertz);
    // At rest with the deck.
    plant.velocity_mps.z = plant.deck(0.0)[1];
    plant.gain = 1.0;
    plant
}

#[test]
fn regress_landings_from_the_hover_to_disarmed() {
    use Phase::*;
    for (amplitude_m, hertz, gain) in [
        (0.0, 0.5, 1.0),
        (0.05, 0.5, 1.0),
        (0.05, 0.5, 1.6),
        (0.3, 0.2, 1.0),
    ] {
        for shift in 0..5 {
            let mut plant = over(amplitude_m, hertz);
            plant.time_s = f64::from(shift) / (5.0 * hertz);
            plant.position_m.z += plant.deck(plant.time_s)[0];
            plant.velocity_mps.z = plant.deck(plant.time_s)[1];
            plant.gain = gain;
            plant.wind_n = Vector::new(0.4, 0.0, 0.0);
            let record = fly(&mut plant, |_, _, _| ());
            assert_eq!(
                record.phases,
                [Hold, Wait, Descend, Commit, Touchdown, Disarmed],
                "{amplitude_m} {hertz} {gain} {record:?}"
            );
            // Softly and on the spot; the deck's speed reaches 0.16 and 0.38 m/s.
            let impact = record.impact_mps.unwrap();
            assert!(impact < 0.08, "{amplitude_m} {gain} {record:?}");
            assert!(record.lateral_m < 0.02, "{record:?}");
            assert!(record.descent_s < 4.5, "{record:?}");
            // Legs of 4 kN/m: weight, and what is left of the fall.
            assert!(record.least_height_m > 0.09, "{record:?}");
        }
    }
}

#[test]
fn prop_a_tag_lost_on_the_way_costs_one_go_around() {
    let mut plant = over(0.05, 0.5);
    // For a second, from the first moment of the first descent.
    let lost = core::cell::Cell::new(None);
    let record = fly(&mut plant, |seen, phase, now| {
        if phase == Phase::Descend && lost.get().is_none() {
            lost.set(Some(now + 0.5));
        }
        if lost
            .get()
            .is_some_and(|since| (since..since + 1.0).contains(&now))
        {
            seen.tag_age_s = 0.5;
        }
    });
    use Phase::*;
    assert_eq!(
        record.phases,
        [
            Hold, Wait, Descend, GoAround, Approach, Hold, Wait, Descend, Commit, Touchdown,
            Disarmed
        ]
    );
    assert_eq!(record.go_arounds, 1);
    assert_eq!(record.reasons[0], Reason::TagLost);
    assert!(record.impact_mps.unwrap() < 0.08);
}

#[test]
fn prop_an_abort_near_the_deck_climbs_away_without_touching() {
    let mut plant = over(0.05, 0.5);
    let record = fly(&mut plant, |seen, phase, now| {
        // Range finder and camera die below the commit height, and come back.
        if phase == Phase::Commit && now < 6.0 {
            (seen.range_age_s, seen.tag_age_s, seen.height_sd_m) = (1.0, 1.0, 1.0);
        }
    });
    assert!(record.phases.contains(&Phase::GoAround), "{record:?}");
    assert_eq!(record.phases.last(), Some(&Phase::Disarmed));
    assert_eq!(record.reasons[0], Reason::RangeStale);
    assert!(record.impact_mps.unwrap() < 0.08, "{record:?}");
}

#[test]
fn prop_given_up_it_holds_its_place_in_the_world() {
    let mut plant = over(0.05, 0.5);
    plant.wind_n = Vector::new(0.5, 0.5, 0.0);
    // Never sees the tag again, from before the descent: climbs to its safe height and stays there.
    let record = fly(&mut plant, |seen, _, now| {
        if now > 0.3 {
            seen.tag_age_s = f64::INFINITY;
        }
    });
    assert!(!record.phases.contains(&Phase::Disarmed));
    assert!(record.impact_mps.is_none());
    // By velocity alone: it stops, within what it moved while it followed the deck at
    // up to 0.16 m/s, and what is left in the integral drifts in two minutes.
    assert!(plant.velocity_mps.norm() < 0.01, "{plant:?}");
    assert!(plant.position_m.horizontal().norm() < 0.5, "{plant:?}");
    assert!((plant.position_m.z - 3.2).abs() < 0.5, "{plant:?}");
}
