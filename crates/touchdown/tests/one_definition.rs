//! A model has one meaning: the expression that judges a card and the flight model made from it agree.

use touchdown_flight::ground_effect::{GroundEffect as _, GroundEffectInput};
use touchdown_flight::thrust::ThrustState;
use touchdown_identify::prediction::{Columns, Predictor};
use touchdown_identify::rig::GroundTrial;
use touchdown_model::{Card, published};

const DT: f64 = 1e-3;

/// Ten seconds of smooth motion, at 1 kHz so that the two integrators' orders do not matter.
fn trial() -> GroundTrial {
    let time_s: Vec<f64> = (0..10_000).map(|i| DT * f64::from(i)).collect();
    let of = |f: &dyn Fn(f64) -> f64| time_s.iter().map(|&t| f(t)).collect::<Vec<f64>>();
    GroundTrial {
        name: "motion".into(),
        throttle: of(&|t| 0.48 + 0.1 * (0.9 * t).sin()),
        height_m: of(&|t| 0.3 + 0.15 * (1.3 * t).sin()),
        deck_velocity_mps: of(&|t| -0.195 * (1.3 * t).cos()),
        vehicle_velocity_mps: of(&|_| 0.0),
        free_air_thrust_n: of(&|t| 13.0 + 2.0 * (0.9 * t).sin()),
        force_n: vec![0.0; time_s.len()],
        truth_n: None,
        time_s,
    }
}

/// Largest difference between flight and expression, both started from the flight model's rest.
fn largest_difference(card: &Card) -> f64 {
    let t = trial();
    let mut guarded = card.ground_effect().unwrap();
    guarded.velocity = touchdown_model::card::VelocityInput::Deck;
    let input = |i: usize| GroundEffectInput {
        thrust_n: t.free_air_thrust_n[i],
        throttle: t.throttle[i],
        height_m: t.height_m[i],
        vehicle_velocity_mps: t.vehicle_velocity_mps[i],
        deck_velocity_mps: t.deck_velocity_mps[i],
        ..GroundEffectInput::default()
    };
    let mut state = guarded.rest(&input(0));
    let first = guarded
        .lift(&state, &input(0))
        .total_n(t.free_air_thrust_n[0]);
    let expression = Predictor::new(card)
        .unwrap()
        .run("t", &t.time_s, &t.columns(), first)
        .unwrap();
    let mut worst: f64 = 0.0;
    for i in 0..t.time_s.len() {
        if i > 0 {
            guarded.step(&mut state, &input(i), DT);
        }
        let flown = guarded
            .lift(&state, &input(i))
            .total_n(t.free_air_thrust_n[i]);
        worst = worst.max((flown - expression[i]).abs());
    }
    worst
}

#[test]
fn prop_ground_effect_in_flight_is_the_card_s_expression() {
    let settings = touchdown_reproduce::settings::ReproduceSettings::quick();
    let cards = touchdown_reproduce::experiments::identify_cards(
        &settings.rig,
        3,
        &touchdown_campaign::progress::Silent,
    )
    .unwrap();
    for card in [
        cards.empirical.as_ref().unwrap(),
        cards.dynamic.as_ref().unwrap(),
    ] {
        let worst = largest_difference(card);
        // Flight holds its inputs over a step, the expression interpolates them: half a step (0.5 ms) of a
        // force that changes by at most 3 N/s.
        assert!(worst < 2e-3, "{}: {worst} N", card.name);
    }
}

#[test]
fn prop_thrust_in_flight_is_the_card_s_expression() {
    let card = Card::parse(published::EQ_11, "eq11").unwrap();
    let flight = card.thrust_model().unwrap();
    let t = trial();
    let mut state = ThrustState {
        x: flight.rest(t.throttle[0]),
    };
    let columns = Columns {
        throttle: &t.throttle,
        ..Columns::default()
    };
    let start = state.thrust_n();
    let expression = Predictor::new(&card)
        .unwrap()
        .run("t", &t.time_s, &columns, start)
        .unwrap();
    for i in 1..t.time_s.len() {
        flight.step(&mut state, t.throttle[i], DT);
        // As above: half a step of a thrust that changes by at most 3 N/s.
        assert!((state.thrust_n() - expression[i]).abs() < 2e-3, "{i}");
    }
}

/// A static map with a box of heights, and no memory.
fn static_card() -> Card {
    let settings = touchdown_reproduce::settings::ReproduceSettings::quick();
    let mut card = touchdown_reproduce::experiments::identify_cards(
        &settings.rig,
        3,
        &touchdown_campaign::progress::Silent,
    )
    .unwrap()
    .dynamic
    .unwrap();
    card.form = touchdown_model::Form::Static;
    card.terms.retain(|t| t.of == "h");
    card.validity.inputs.insert("z".into(), [0.2, 0.4]);
    card
}

#[test]
fn prop_heights_outside_the_box_are_those_of_its_edge() {
    let card = static_card();
    let run = |height_m: f64| {
        let (z, thrust) = ([height_m; 2], [13.0; 2]);
        let columns = Columns {
            height_m: &z,
            free_air_thrust_n: &thrust,
            ..Columns::default()
        };
        Predictor::new(&card)
            .unwrap()
            .run("t", &[0.0, 0.01], &columns, 0.0)
            .unwrap()[1]
    };
    assert_eq!(run(0.1), run(0.2));
    assert_eq!(run(0.9), run(0.4));
    assert!(run(0.2) > run(0.3) && run(0.3) > run(0.4));
}

#[test]
fn prop_inputs_of_a_ground_effect_trial_are_as_late_as_the_load_cell() {
    let mut card = Card::parse(published::EQ_11, "eq11").unwrap();
    let t = trial();
    let recorded = touchdown_trial::Trial::new("late", t.time_s.clone())
        .unwrap()
        .with_channel("throttle", t.throttle.clone())
        .unwrap()
        .with_channel("thrust_n", t.free_air_thrust_n.clone())
        .unwrap()
        .with_channel("height_m", t.height_m.clone())
        .unwrap()
        .with_channel("deck_velocity_mps", t.deck_velocity_mps.clone())
        .unwrap();
    let prepare = |card: &Card| touchdown_identify::rig::prepare(&recorded, card).unwrap();
    let prompt = prepare(&card);
    assert_eq!(prompt.height_m, t.height_m);
    card.terms.push(touchdown_model::Term {
        of: "dead_time".into(),
        expression: "1".into(),
        value: 0.025,
        std_error: None,
        ci95: None,
        unit: "s".into(),
        mark: None,
        upper_bound: None,
    });
    let late = prepare(&card);
    // 25 samples of 1 ms; interpolated between stamps that carry rounding.
    for i in 100..t.time_s.len() {
        for (late, prompt) in [
            (&late.height_m, &prompt.height_m),
            (&late.deck_velocity_mps, &prompt.deck_velocity_mps),
            (&late.throttle, &prompt.throttle),
            (&late.free_air_thrust_n, &prompt.free_air_thrust_n),
        ] {
            assert!(
                (late[i] - prompt[i - 25]).abs() < 1e-9,
                "{i}: {} {}",
                late[i],
                prompt[i - 25]
            );
        }
    }
}
