//! What is known of the deck before a descent begins.

use touchdown_flight::reference::{Reference, Terminal};
use touchdown_lander::computer::{Computer, Descent};
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};
use touchdown_lander::planner::{DeckOutlook, Planner, Quiescence, Verdict};
use touchdown_lander::state_machine::{Phase, StateMachine};

use crate::world::{DT, Rate, State, World, computer};

#[test]
fn analytic_a_deck_that_was_never_seen_is_not_at_rest() {
    let estimator = DeckEstimator::<f64>::new(Observed::Displacement, 0.005);
    let mut state = estimator.initial();
    let planner = Planner::<f64>::default();
    for i in 0..1000 {
        let ahead = |t: f64| DeckOutlook::from_heave(&estimator.predict(&state, t), 0.0, 0.0);
        let verdict = planner.assess(0.0, 0.8, true, &ahead);
        assert_eq!(verdict, Verdict::Blind, "{i}");
        assert!(state.observed_s() < 1e-9, "{i}");
        // NaN is no reading.
        estimator.step(&mut state, (i % 2 == 0).then_some(f64::NAN), DT);
    }
    for _ in 0..500 {
        estimator.step(&mut state, Some(0.3), DT);
    }
    // Five seconds, from the first to the last.
    assert!((state.observed_s() - 4.99).abs() < 1e-6);
    let ahead = |t: f64| DeckOutlook::from_heave(&estimator.predict(&state, t), 0.0, 0.0);
    assert!(planner.assess(0.0, 0.8, false, &ahead).plan().is_some());
    // What passes between readings far apart has not been seen, and long ago is over.
    for _ in 0..300 {
        estimator.step(&mut state, None, DT);
    }
    estimator.step(&mut state, Some(0.3), DT);
    assert!((state.observed_s() - 4.99).abs() < 1e-6);
    for _ in 0..2000 {
        estimator.step(&mut state, None, DT);
    }
    estimator.step(&mut state, Some(0.3), DT);
    assert!(state.observed_s() < 1e-9);
}

#[test]
fn analytic_the_watch_begins_with_the_first_sight_of_the_deck() {
    let mut computer = computer();
    // It does not climb before it sees the deck.
    computer.state_machine.lost_s = 10.0;
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    let (range, tag) = (world.range.take(), world.tag.take());
    for i in 0..2000 {
        if i == 500 {
            (world.range, world.tag) = (range, tag);
        }
        let output = world.step(&computer, &mut state);
        if output.state_machine.phase == Phase::Descend {
            let watched_s = DT * f64::from(i - 500);
            // 3 s, and up to 0.1 s to the next look of the planner, of readings that are
            // 50 ms late.
            assert!((3.0..3.3).contains(&watched_s), "{watched_s}");
            return;
        }
    }
    panic!("never descended: {:?}", state.phase());
}

#[test]
fn analytic_a_fast_deck_is_too_fast_before_its_period_is_known() {
    let computer = Computer {
        descent: Descent::Straight(Reference::Terminal(Terminal {
            start_height_m: 0.8,
            end_height_m: 0.1,
            sink_rate_mps: 0.03,
            duration_s: 2.5,
        })),
        state_machine: StateMachine {
            deck_speed_mps: 0.1,
            ..StateMachine::default()
        },
        watch_s: 0.3,
        ..computer()
    };
    computer.validate().unwrap();
    // 0.25 m/s; and one of half the limit.
    for (amplitude_m, may) in [(0.1, false), (0.01, true)] {
        let mut state: State = computer.initial(World::throttle());
        let mut world = World::new(0.0);
        world.heave = (amplitude_m, 2.5);
        let mut descended = false;
        for _ in 0..1500 {
            let output = world.step(&computer, &mut state);
            descended |= output.state_machine.phase == Phase::Descend;
        }
        assert_eq!(descended, may, "{amplitude_m}");
    }
}

#[test]
fn analytic_late_readings_show_the_deck_when_they_were_taken() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    world.heave = (0.1, 2.5);
    world.request = touchdown_lander::state_machine::OperatorRequest::Abort;
    // 0.15 and 0.14 s old, where the estimator is told of 0.05 s.
    world.range = Some(Rate { every: 2, age: 15 });
    world.tag = Some(Rate { every: 3, age: 14 });
    let (mut error2, mut truth2) = (0.0, 0.0);
    for i in 0..3000 {
        let truth = world.deck()[1];
        let output = world.step(&computer, &mut state);
        // What is forecast for now is what is said of now.
        assert_eq!(computer.forecast(&state, 0.0), output.deck, "{i}");
        if i > 1500 {
            error2 += (output.deck.velocity_mps - truth).powi(2);
            truth2 += truth * truth;
        }
    }
    let relative = f64::sqrt(error2 / truth2);
    // 0.1 s late would be 0.25; what is left is that of the estimator's noise.
    assert!(relative < 0.08, "{relative}");
}

#[test]
fn analytic_flicker_does_not_keep_the_planner_waiting_for_ever() {
    let computer = Computer {
        descent: Descent::Planned(Planner {
            // No deck is this quiet: it waits for its deadline, less what it looks ahead.
            quiescence: Quiescence {
                speed_mps: 1e-6,
                ..Quiescence::default()
            },
            wait_s: 8.0,
            ..Planner::default()
        }),
        ..computer()
    };
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    let range = world.range;
    for i in 0..3000 {
        // No range for 0.3 s of every 1.5 s: out of Wait, and back.
        world.range = range.filter(|_| i % 150 >= 30);
        let output = world.step(&computer, &mut state);
        if output.state_machine.phase == Phase::Descend {
            return;
        }
    }
    panic!("still waiting: {:?}", state.phase());
}

#[test]
fn prop_a_plan_is_told_only_where_it_is_flown() {
    let computer = computer();
    let mut state: State = computer.initial(World::throttle());
    let mut world = World::new(0.0);
    let (mut told, mut begun) = (0, 0);
    for _ in 0..800 {
        let (before, mut twin) = (state, world.clone());
        let output = world.step(&computer, &mut state);
        told += usize::from(output.plan.is_some());
        let begins =
            output.state_machine.phase == Phase::Descend && before.phase() != Phase::Descend;
        begun += usize::from(begins);
        if begins {
            // The same step with a battery that has just become low.
            let mut state = before;
            twin.battery_share = 0.15;
            let output = twin.step(&computer, &mut state);
            assert_eq!(output.state_machine.phase, Phase::GivenUp);
            assert_eq!(output.plan, None);
        }
    }
    assert_eq!([told, begun], [1, 1]);
}
