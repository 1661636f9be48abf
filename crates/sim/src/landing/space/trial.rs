//! Random differences between the trials of a scenario.

use super::scenario::SpaceScenario;
use crate::STEP_S;
use crate::air::turbulence::RotorTurbulence;
use crate::air::wind::Wind;
use crate::body::cascade::AttitudeSetpoint;
use crate::body::rigid::{Disturbance, RigidState, RigidVehicle};
use crate::deck::rigid::DeckPose;
use crate::error::SimError;
use crate::random::{Purpose, Stream};

/// Draws of a start that are replaced before the mean start is taken. Of a spread that [`SpaceScenario::check`] accepts at least a
/// tenth starts in the air near the mean start, so that one trial in 1e45 needs as many.
const MOST_REDRAWS: u32 = 1000;

/// The random numbers of a trial.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrialDraw {
    /// Relative error of the rotors' thrust.
    thrust_error: f64,
    /// Scale of the ground effect γ.
    ground_effect_scale: f64,
    /// Phase of the deck's motion at the start, in [0, 1).
    pub(super) phase: f64,
    /// Place relative to the deck's centre, m.
    place_m: [f64; 3],
    /// Draws that this place replaces.
    redrawn: u32,
}

impl TrialDraw {
    pub(super) fn new(scenario: &SpaceScenario, trial: u64, seed: u64) -> Self {
        let mut spread = Stream::new(seed, trial, Purpose::Spread);
        let (thrust, scale, phase) = (spread.normal(), spread.uniform(), spread.uniform());
        let (place_m, redrawn) = place_of(scenario, &mut spread);
        let of = &scenario.spread;
        let (low, high) = (of.ground_effect_scale_min, of.ground_effect_scale_max);
        let scale = scenario.ground_effect_strength * (low + (high - low) * scale);
        Self {
            thrust_error: of.thrust_scale_sd * thrust,
            ground_effect_scale: scenario.plant.ground_effect_scale * scale,
            phase,
            place_m,
            redrawn,
        }
    }

    /// The trial's vehicle.
    pub(super) fn vehicle(&self, nominal: &RigidVehicle) -> Result<RigidVehicle, SimError> {
        Ok(nominal
            .clone()
            .with_ground_effect_scale(self.ground_effect_scale)?
            .with_thrust_scale_error([self.thrust_error; 4]))
    }

    /// The state at rest relative to the deck, trimmed in the steady wind, and the throttle
    /// that holds it.
    pub(super) fn start(
        &self,
        scenario: &SpaceScenario,
        vehicle: &RigidVehicle,
        deck: &DeckPose,
    ) -> (RigidState, f64) {
        let [x, y, height_m] = self.place_m;
        // The mean wind where it starts.
        let wake = scenario.wind.airwake;
        let lost = wake.map_or(0.0, |wake| wake.deficit() * wake.share(height_m));
        let wind_mps = scenario.wind.steady_mps.map(|mps| (1.0 - lost) * mps);
        let calm = wind_mps[0].hypot(wind_mps[1]) <= 0.0 && !scenario.course.is_under_way();
        let (mut state, mut throttle) = if calm {
            vehicle.balanced(height_m, deck)
        } else {
            vehicle.trimmed(height_m, deck, wind_mps)
        };
        if scenario.course.is_under_way() {
            (state, throttle) = vehicle.following((state, throttle), deck.acceleration_mps2);
        }
        state.position_m[0] += x;
        state.position_m[1] += y;
        (state, throttle)
    }
}

/// The first drawn place from which a landing can begin, m, and how many draws it replaces.
fn place_of(scenario: &SpaceScenario, spread: &mut Stream) -> ([f64; 3], u32) {
    for redrawn in 0..MOST_REDRAWS {
        let offset: [f64; 3] = std::array::from_fn(|_| spread.normal());
        let start = |k: usize| scenario.start_m[k] + scenario.start_sd_m[k] * offset[k];
        let place_m = std::array::from_fn(start);
        if scenario.can_start_at(place_m) {
            return (place_m, redrawn);
        }
    }
    (scenario.start_m, MOST_REDRAWS)
}

impl SpaceScenario {
    /// How many draws of a trial's start were replaced, because no landing can begin there.
    #[must_use]
    pub fn redrawn_starts(&self, trial: u64, seed: u64) -> u32 {
        TrialDraw::new(self, trial, seed).redrawn
    }
}

/// The setpoint of a hover in a state whose forces are in balance.
pub(super) fn hover(state: &RigidState) -> AttitudeSetpoint {
    AttitudeSetpoint {
        thrust_n: 0.25 * state.rotors.root_thrust.iter().map(|x| x * x).sum::<f64>(),
        attitude: state.attitude,
        yaw_rate: 0.0,
        body_rates: None,
    }
}

/// The air of a trial at its start.
pub(super) struct TrialAir {
    pub(super) wind: Wind,
    pub(super) turbulence: Option<RotorTurbulence>,
    /// Wind and turbulence at the start.
    pub(super) disturbance: Disturbance,
}

impl TrialAir {
    /// The air of a vehicle that starts in a state over the deck.
    ///
    /// # Errors
    /// Settings of the wind that make no sense.
    pub(super) fn new(
        scenario: &SpaceScenario,
        vehicle: &RigidVehicle,
        state: &RigidState,
        deck: &DeckPose,
        trial: u64,
        seed: u64,
    ) -> Result<Self, SimError> {
        let turbulence = scenario.turbulence.then(|| {
            let stream = Stream::new(seed, trial, Purpose::Turbulence);
            let still = vehicle.loads(state, deck, &Disturbance::default());
            let roots = &state.rotors.root_thrust;
            let sd_n = vehicle.rotors().turbulence_sd_n(roots, &still.target);
            let correlation_s = scenario.plant.turbulence_correlation_s;
            RotorTurbulence::new(stream, correlation_s, STEP_S, sd_n)
        });
        let wind = Wind::new(&scenario.wind, STEP_S, seed, trial)?;
        let disturbance = Disturbance {
            wind_mps: wind.velocity_at(state.position_m[2] - deck.origin_m[2]),
            turbulence_n: turbulence
                .as_ref()
                .map_or([0.0; 4], RotorTurbulence::values_n),
        };
        Ok(Self {
            wind,
            turbulence,
            disturbance,
        })
    }
}
