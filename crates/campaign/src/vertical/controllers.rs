//! Vertical controllers of the methods by name, with the models of cards.

use touchdown_flight::Method;
use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, Validity};
use touchdown_flight::method::{Feedforward, VerticalLanding};
use touchdown_flight::thrust::ThrustModel;
use touchdown_flight::vertical_controller::VerticalController;
use touchdown_model::{Card, Form};
use touchdown_sim::deck::DeckMotion;

use super::settings::LandSettings;
use crate::error::{Error, Result};
use crate::vehicle::VehicleSettings;

/// The cards that controllers are made from.
#[derive(Clone, Debug)]
pub struct Cards {
    /// Throttle to thrust.
    pub thrust: Card,
    /// What is stated of the vehicle: its rotors multiply the thrust.
    pub vehicle: VehicleSettings,
    /// Eq. (2), for `empirical`.
    pub empirical: Option<Card>,
    /// The dynamic model, for `dynamic`.
    pub dynamic: Option<Card>,
}

impl Cards {
    /// The thrust of the whole vehicle.
    ///
    /// # Errors
    /// A thrust card that does not fly.
    pub fn thrust_model(&self) -> Result<ThrustModel<f64>> {
        self.vehicle.thrust(&self.thrust)
    }
}

/// Builds the controller of a method. `acceleration`: whether the deck's acceleration, estimated by the
/// harmonic filter, is fed forward (never for `imbc`, whose law has no such term).
///
/// # Errors
/// A method that does not fly vertically, a card that cannot be flown, or settings out of range.
pub fn controller(
    method: Method,
    cards: &Cards,
    settings: &LandSettings,
    acceleration: bool,
) -> Result<VerticalController<f64>> {
    let angular_frequency = settings.scenario.deck.angular_frequency();
    controller_over(method, cards, settings, acceleration, angular_frequency)
}

/// As [`controller`], over a deck that heaves with this mean angular frequency (rad/s).
///
/// # Errors
/// As of [`controller`].
pub fn controller_over(
    method: Method,
    cards: &Cards,
    settings: &LandSettings,
    acceleration: bool,
    deck_angular_frequency: Option<f64>,
) -> Result<VerticalController<f64>> {
    if !Method::VERTICAL.contains(&method) {
        return Err(Error::Arguments(format!(
            "method `{}` needs an inertial unit, which only flights in six degrees of freedom have (--space)",
            method.name()
        )));
    }
    let scenario = &settings.scenario;
    let ground_effect = match method.feedforward() {
        Feedforward::None => Guarded::new(GroundEffectModel::None, Validity::default()),
        Feedforward::Empirical => empirical(cards)?.ground_effect()?,
        Feedforward::Dynamic => card(&cards.dynamic, method)?.ground_effect()?,
    };
    if acceleration && matches!(scenario.deck, DeckMotion::Triangle { .. }) {
        return Err(Error::Arguments(
            "the harmonic filter needs a sinusoidal deck motion; this one is a triangle".into(),
        ));
    }
    let landing = VerticalLanding {
        mass_kg: scenario.plant.mass_kg,
        gravity_mps2: scenario.plant.gravity_mps2,
        start_height_m: scenario.start_height_m,
        deck_angular_frequency,
        deck_acceleration: acceleration,
    };
    let thrust = cards.thrust_model()?;
    Ok(settings
        .control
        .controller(method, &landing, thrust, ground_effect)?)
}

fn card(card: &Option<Card>, method: Method) -> Result<&Card> {
    card.as_ref().ok_or_else(|| {
        Error::Arguments(format!(
            "method `{}` needs a ground-effect card",
            method.name()
        ))
    })
}

/// The card of `empirical`, which is eq. (2) and nothing else.
fn empirical(cards: &Cards) -> Result<&Card> {
    let card = card(&cards.empirical, Method::Empirical)?;
    if card.form == Form::Empirical {
        return Ok(card);
    }
    Err(Error::Arguments(format!(
        "method `empirical` needs a card of form `empirical` (eq. 2); card `{}` is of form {:?}",
        card.name, card.form
    )))
}

/// Checks controllers' settings without any card.
///
/// # Errors
/// The first setting out of range.
pub fn check(settings: &LandSettings) -> Result<()> {
    let cards = Cards {
        thrust: Card::parse(touchdown_model::published::EQ_11, "eq11")?,
        vehicle: VehicleSettings::default(),
        empirical: None,
        dynamic: None,
    };
    for method in [Method::Feedback, Method::Imbc, Method::Ssc] {
        controller(method, &cards, settings, false)?;
    }
    Ok(())
}
