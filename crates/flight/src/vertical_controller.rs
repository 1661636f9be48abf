//! The whole vertical controller: measurement in, command out.

use crate::control::channel::{ChannelInput, VerticalChannel, ground_input};
use crate::control::{Law, VerticalState};
use crate::deck::{HarmonicFilter, HarmonicState};
use crate::error::SettingsError;
use crate::ground_effect::{GroundEffect, Guarded};
use crate::kernel::{Sum, usable_dt};
use crate::real::Real;
use crate::reference::Reference;
use crate::thrust::ThrustModel;
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
pub struct VerticalController<R: Real, G = Guarded<R>> {
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

/// State of an [`VerticalController`] whose ground-effect model has state `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerticalControllerState<R, S> {
    time: Sum<R>,
    /// Law, models and the last command.
    pub vertical: VerticalState<R, S>,
    /// State of the deck filter, where there is one.
    pub deck: Option<HarmonicState<R>>,
    /// The last measurement, with every value finite.
    pub measurement: Measurement<R>,
}

impl<R: Real, S> VerticalControllerState<R, S> {
    /// Time since the start of the descent, s.
    pub fn time_s(&self) -> R {
        self.time.value()
    }
}

impl<R: Real, G: GroundEffect<R>> VerticalController<R, G> {
    /// Checks all settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.channel().validate()?;
        self.reference.validate()?;
        match &self.deck {
            Some(deck) => deck.validate(),
            None => Ok(()),
        }
    }

    fn channel(&self) -> VerticalChannel<'_, R, G> {
        VerticalChannel {
            mass_kg: self.mass_kg,
            gravity_mps2: self.gravity_mps2,
            law: &self.law,
            thrust: &self.thrust,
            motor_lag_share: R::ONE,
            ground_effect: &self.ground_effect,
            limits: &self.limits,
        }
    }

    /// The state at the start of the descent: rotors and air at rest at
    /// `throttle`, which is being sent.
    pub fn initial(
        &self,
        measurement: &Measurement<R>,
        throttle: R,
    ) -> VerticalControllerState<R, G::State> {
        let start = Measurement {
            height_m: self.reference.at(R::ZERO).height_m,
            ..Measurement::default()
        };
        let measurement = measurement.or_previous(&start);
        VerticalControllerState {
            time: Sum::default(),
            vertical: self
                .channel()
                .initial(&ground_input(&measurement), throttle),
            deck: self.deck.map(|filter| filter.initial()),
            measurement,
        }
    }

    /// One control period: takes the measurement at its beginning, gives the
    /// command to hold for its `dt` seconds.
    ///
    /// Values that are not finite are replaced by the last ones that were; the
    /// command is always finite and within the limits.
    pub fn step(
        &self,
        state: &mut VerticalControllerState<R, G::State>,
        measurement: &Measurement<R>,
        dt: R,
    ) -> Command<R> {
        let dt = usable_dt(dt);
        let deck_velocity_mps = measurement.deck_velocity_mps();
        let measurement = measurement.or_previous(&state.measurement);
        state.measurement = measurement;
        let channel = self.channel();
        let lift = channel.advance_models(&mut state.vertical, &ground_input(&measurement), dt);
        let input = ChannelInput {
            measurement,
            reference: self.reference.at(state.time.value()),
            deck_acceleration_mps2: self.deck_acceleration(state, deck_velocity_mps, dt),
            disturbance_n: R::ZERO,
            cos_tilt: R::ONE,
        };
        let output = channel.command(&mut state.vertical, &input, lift, dt);
        state.time.add(dt);
        output.command
    }

    fn deck_acceleration(
        &self,
        state: &mut VerticalControllerState<R, G::State>,
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
}
