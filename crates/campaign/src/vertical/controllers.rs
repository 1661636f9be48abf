//! Vertical controllers of the methods by name, with the models of cards.

use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, Validity};
use touchdown_flight::method::{Feedforward, VerticalLanding};
use touchdown_flight::thrust::ThrustModel;
use touchdown_flight::vertical_controller::VerticalController;
use touchdown_flight::{Method, SettingsError};
use touchdown_model::{Card, Form};
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::landing::refused_setting;

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
/// The first setting out of range: its key in the file of a landing, and what is wrong with it.
pub fn check(settings: &LandSettings) -> std::result::Result<(), (String, String)> {
    let other = |error: Error| ("control".to_owned(), error.to_string());
    let thrust = Card::parse(touchdown_model::published::EQ_11, "eq11");
    let thrust = thrust.map_err(|error| other(error.into()))?;
    let thrust = VehicleSettings::default().thrust(&thrust).map_err(other)?;
    let plant = &settings.scenario.plant;
    let landing = VerticalLanding {
        mass_kg: plant.mass_kg,
        gravity_mps2: plant.gravity_mps2,
        start_height_m: settings.scenario.start_height_m,
        // Any: it is that of the deck, which may be measured.
        deck_angular_frequency: Some(std::f64::consts::PI),
        deck_acceleration: true,
    };
    let none = Guarded::new(GroundEffectModel::None, Validity::default());
    for method in [Method::Feedback, Method::Imbc, Method::Ssc] {
        let made = settings.control.controller(method, &landing, thrust, none);
        made.map_err(|error| refused(&error))?;
    }
    Ok(())
}

/// A refused setting by its key in the file of a landing, and what is wrong with it.
fn refused(error: &SettingsError) -> (String, String) {
    match refused_setting(error, key_of_file) {
        Some((key, expected, found)) => (key, format!("expected {expected}, found {found}")),
        None => ("control".to_owned(), error.to_string()),
    }
}

/// The key of a landing's file that sets a setting of the vertical controller.
fn key_of_file(key: &str) -> String {
    match key {
        "mass_kg" | "gravity_mps2" => format!("scenario.plant.{key}"),
        "reference.exponential.start_height_m" => "scenario.start_height_m".to_owned(),
        "deck.lead_s" => "control.deck_lead_s".to_owned(),
        "imbc.poles_per_s" => "control.imbc_poles_per_s".to_owned(),
        "imbc.k_p" | "ssc.k_p" => "control.gains.k_p".to_owned(),
        "imbc.gamma" | "ssc.gamma" => "control.gains.gamma".to_owned(),
        _ => match key.split_once('.') {
            Some(("ssc", rest)) => format!("control.ssc_{rest}"),
            Some(("reference", rest)) => {
                format!("control.{}", rest.trim_start_matches("exponential."))
            }
            _ => format!("control.{key}"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_refused_setting_is_named_by_the_key_of_the_file() {
        let refused = |change: fn(&mut LandSettings)| {
            let mut settings = LandSettings::deck();
            change(&mut settings);
            check(&settings).unwrap_err()
        };
        for (change, key, message) in [
            (
                (|s| s.control.deck_lead_s = -1.0) as fn(&mut LandSettings),
                "control.deck_lead_s",
                "found -1",
            ),
            (
                |s| s.control.end_height_m = 1e9,
                "control.end_height_m",
                "less than `scenario.start_height_m` = 0.5",
            ),
            (|s| s.control.c_per_s = 0.0, "control.c_per_s", "found 0"),
            (
                |s| s.control.gains.k_p = 0.0,
                "control.gains.k_p",
                "found 0",
            ),
            (
                |s| s.control.ssc_rho_n = -2.0,
                "control.ssc_rho_n",
                "found -2",
            ),
            (
                |s| s.control.limits.thrust_min_n = 30.0,
                "control.limits.thrust_min_n",
                "less than `control.limits.thrust_max_n` = 20.4",
            ),
        ] {
            let (named, said) = refused(change);
            assert_eq!(named, key);
            assert!(said.contains(message), "{said}");
        }
        check(&LandSettings::deck()).unwrap();
    }
}
