//! Steps of single models.

use core::hint::black_box;

use touchdown_flight::ground_effect::{
    GroundEffect, GroundEffectInput, GroundEffectModel, Polynomial,
};
use touchdown_flight::thrust::{ThrustModel, ThrustState};
use touchdown_lander::models::FlightModels;

use crate::words::{Port, Reader, Writer};

/// A model whose step is replayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelCall {
    /// Ground effect, eq. (12).
    Polynomial,
    /// Ground effect, the fitted lag.
    Lag,
    /// The same within its limits of validity.
    GuardedLag,
    /// Thrust, eq. (8), one Runge–Kutta step.
    ThrustLibrary,
}

impl ModelCall {
    /// All calls.
    pub const ALL: [Self; 4] = [
        Self::Polynomial,
        Self::Lag,
        Self::GuardedLag,
        Self::ThrustLibrary,
    ];

    pub(crate) fn word(self) -> u32 {
        self as u32
    }

    pub(crate) fn of_word(word: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|call| call.word() == word)
    }
}

/// Inputs of a call: dt, throttle, thrust, height, velocities of vehicle and deck.
pub(crate) fn replay(call: ModelCall, port: &mut impl Port) -> Option<()> {
    let models = FlightModels::<f32>::default();
    let start = GroundEffectInput {
        height_m: 0.8,
        thrust_n: 13.4,
        throttle: 0.5,
        ..GroundEffectInput::default()
    };
    let polynomial = Polynomial::published();
    match (call, models.dynamic.model) {
        (ModelCall::Polynomial, _) => ground(port, &polynomial, 0.0),
        (ModelCall::Lag, GroundEffectModel::Lag(lag)) => ground(port, &lag, lag.rest(&start)),
        (ModelCall::Lag, _) => None,
        (ModelCall::GuardedLag, _) => ground(port, &models.dynamic, models.dynamic.rest(&start)),
        (ModelCall::ThrustLibrary, _) => thrust(port, &models.thrust),
    }
}

fn ground<G: GroundEffect<f32>>(
    port: &mut impl Port,
    model: &G,
    mut state: G::State,
) -> Option<()> {
    let model = black_box(model);
    while let Some(dt) = port.number() {
        let [throttle, thrust_n, height_m, vehicle, deck] = port.numbers()?;
        let input = GroundEffectInput {
            thrust_n,
            throttle,
            height_m,
            vehicle_velocity_mps: vehicle,
            deck_velocity_mps: deck,
            rotor_heights_m: None,
        };
        let input = black_box(&input);
        port.begin();
        let lift = model.step(&mut state, input, dt);
        port.end();
        port.put(lift.ratio);
        port.put(lift.force_n);
    }
    Some(())
}

fn thrust(port: &mut impl Port, model: &ThrustModel<f32>) -> Option<()> {
    let model = black_box(model);
    let mut state = ThrustState { x: model.rest(0.5) };
    while let Some(dt) = port.number() {
        let [throttle, ..] = port.numbers::<5>()?;
        let throttle = black_box(throttle);
        port.begin();
        model.step(&mut state, throttle, dt);
        port.end();
        port.put(state.x);
    }
    Some(())
}
