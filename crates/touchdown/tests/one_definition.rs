//! A model has one meaning: the expression that judges a card and the flight model made from it agree.

use touchdown::identify::ground_effect::GroundTrial;
use touchdown::predict::{Columns, Predictor};
use touchdown_flight::ground_effect::{GroundEffect as _, GroundEffectInput};
use touchdown_flight::thrust::ThrustState;
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
    let settings = touchdown::settings::ReproduceSettings::quick();
    let cards =
        touchdown::experiments::identify_cards(&settings.rig, 3, &touchdown::progress::Silent)
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
