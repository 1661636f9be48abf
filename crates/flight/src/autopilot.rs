//! The whole vertical controller: measurement in, command out.

use crate::control::{ControlInput, Law, LawState, Saturation};
use crate::deck::{HarmonicFilter, HarmonicState};
use crate::error::{SettingsError, positive};
use crate::ground_effect::{GroundEffect, GroundEffectInput, Guarded, Lift};
use crate::kernel::{Sum, usable_dt};
use crate::real::Real;
use crate::reference::Reference;
use crate::thrust::{ThrustModel, ThrustState};
use crate::types::{Command, Limits, Measurement};

/// A vertical landing controller.
///
/// Each step advances the thrust model with the throttle sent last, feeds its
/// thrust to the ground-effect model, predicts the deck's acceleration where a
/// deck filter is given, asks the law for a thrust, limits it and finds the
/// throttle. The same controller serves a deck at rest and a moving one.
///
/// | method | law | ground effect |
/// | --- | --- | --- |
/// | feedback | [`Law::Composite`] | `GroundEffectModel::None` |
/// | empirical | [`Law::Composite`] | `GroundEffectModel::Empirical` |
/// | dynamic | [`Law::Composite`] | any dynamic family |
/// | imbc | [`Law::Imbc`] | not used |
/// | ssc | [`Law::Ssc`] | not used |
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize, G: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>, G: serde::Deserialize<'de>"
    ))
)]
pub struct Autopilot<R: Real, G = Guarded<R>> {
    /// Mass of the vehicle, kg.
    pub mass_kg: R,
    /// Acceleration of gravity, m/s².
    pub gravity_mps2: R,
    /// The control law.
    pub law: Law<R>,
    /// The descent.
    pub reference: Reference<R>,
    /// Throttle to thrust.
    pub thrust: ThrustModel<R>,
    /// The ground effect.
    pub ground_effect: G,
    /// Estimate of the deck's motion, where its acceleration is fed forward.
    pub deck: Option<HarmonicFilter<R>>,
    /// Limits of the actuators.
    pub limits: Limits<R>,
}

/// State of an [`Autopilot`] whose ground-effect model has state `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AutopilotState<R, S> {
    time: Sum<R>,
    /// State of the control law.
    pub law: LawState<R>,
    /// State of the thrust model.
    pub thrust: ThrustState<R>,
    /// State of the ground-effect model.
    pub ground_effect: S,
    /// State of the deck filter, where there is one.
    pub deck: Option<HarmonicState<R>>,
    /// The last measurement, with every value finite.
    pub measurement: Measurement<R>,
    /// The last command.
    pub command: Command<R>,
}

impl<R: Real, S> AutopilotState<R, S> {
    /// Time since the start of the descent, s.
    pub fn time_s(&self) -> R {
        self.time.value()
    }
}

impl<R: Real, G: GroundEffect<R>> Autopilot<R, G> {
    /// Checks all settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("mass_kg", self.mass_kg)?;
        positive("gravity_mps2", self.gravity_mps2)?;
        self.law.validate()?;
        self.reference.validate()?;
        self.thrust.validate()?;
        self.ground_effect.validate()?;
        if let Some(deck) = &self.deck {
            deck.validate()?;
        }
        self.limits.validate()
    }

    /// The state at the start of the descent: rotors and air at rest at
    /// `throttle`, which is being sent.
    pub fn initial(
        &self,
        measurement: &Measurement<R>,
        throttle: R,
    ) -> AutopilotState<R, G::State> {
        let start = Measurement {
            height_m: self.reference.at(R::ZERO).height_m,
            ..Measurement::default()
        };
        let measurement = measurement.or_previous(&start);
        let throttle = self.limits.throttle(throttle.finite_or(R::ZERO));
        let thrust = ThrustState {
            x: self.thrust.rest(throttle),
        };
        let input = ground_input(&measurement, thrust, throttle);
        let ground_effect = self.ground_effect.rest(&input);
        let lift = self.ground_effect.lift(&ground_effect, &input);
        AutopilotState {
            time: Sum::default(),
            law: self.law.initial(thrust.thrust_n()),
            thrust,
            ground_effect,
            deck: self.deck.map(|filter| filter.initial()),
            measurement,
            command: Command {
                thrust_n: thrust.thrust_n(),
                throttle,
                ground_effect_n: self.used_force(lift, thrust),
            },
        }
    }

    /// One control period: takes the measurement at its beginning, gives the
    /// command to hold for its `dt` seconds.
    ///
    /// Values that are not finite are replaced by the last ones that were; the
    /// command is always finite and within the limits.
    pub fn step(
        &self,
        state: &mut AutopilotState<R, G::State>,
        measurement: &Measurement<R>,
        dt: R,
    ) -> Command<R> {
        let dt = usable_dt(dt);
        let deck_velocity_mps = measurement.deck_velocity_mps();
        let measurement = measurement.or_previous(&state.measurement);
        state.measurement = measurement;
        let sent = state.command;
        self.thrust.step(&mut state.thrust, sent.throttle, dt);
        let input = ground_input(&measurement, state.thrust, sent.throttle);
        let lift = self
            .ground_effect
            .step(&mut state.ground_effect, &input, dt);
        let deck_acceleration_mps2 = self.deck_acceleration(state, deck_velocity_mps, dt);

        let control = ControlInput {
            height_m: measurement.height_m,
            relative_velocity_mps: measurement.relative_velocity_mps,
            reference: self.reference.at(state.time.value()),
            deck_acceleration_mps2,
            mass_kg: self.mass_kg,
            gravity_mps2: self.gravity_mps2,
        };
        let demand = self.law.demand(&state.law, &control, lift, dt);
        let asked = demand.thrust_n.finite_or(sent.thrust_n);
        let thrust_n = self.limits.thrust(asked);
        let throttle = self.limits.throttle(self.thrust.throttle_for(thrust_n));
        // At the end of the throttle the rotors may not give what is asked for.
        let saturation = if asked > thrust_n || throttle >= self.limits.throttle_max {
            Saturation::High
        } else if asked < thrust_n || throttle <= self.limits.throttle_min {
            Saturation::Low
        } else {
            Saturation::No
        };
        self.law
            .advance(&mut state.law, &demand, thrust_n, saturation, dt);
        state.time.add(dt);
        state.command = Command {
            thrust_n,
            throttle,
            ground_effect_n: self.used_force(lift, state.thrust),
        };
        state.command
    }

    fn deck_acceleration(
        &self,
        state: &mut AutopilotState<R, G::State>,
        deck_velocity_mps: R,
        dt: R,
    ) -> R {
        match &self.deck {
            None => R::ZERO,
            Some(filter) => {
                let deck = state.deck.get_or_insert_with(|| filter.initial());
                filter.step(deck, deck_velocity_mps, dt).acceleration_mps2
            }
        }
    }

    /// The ground-effect force that the law uses, N.
    fn used_force(&self, lift: Lift<R>, thrust: ThrustState<R>) -> R {
        if self.law.uses_ground_effect() {
            lift.total_n(thrust.thrust_n()).finite_or(R::ZERO)
        } else {
            R::ZERO
        }
    }
}

/// What a measurement tells the ground-effect model.
fn ground_input<R: Real>(
    measurement: &Measurement<R>,
    thrust: ThrustState<R>,
    throttle: R,
) -> GroundEffectInput<R> {
    GroundEffectInput {
        thrust_n: thrust.thrust_n(),
        throttle,
        height_m: measurement.height_m,
        vehicle_velocity_mps: measurement.vehicle_velocity_mps,
        deck_velocity_mps: measurement.deck_velocity_mps(),
        tilt_rad: R::ZERO,
        rotor_heights_m: None,
    }
}
