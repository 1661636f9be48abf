//! The vehicle of a sweep: what `[vehicle]` and the cards say, in the scenario.
//!
//! A setting that the sweep states itself wins over what follows from the vehicle.

use touchdown_flight::thrust::LEAST_THRUST_TO_WEIGHT;
use touchdown_model::Card;
use touchdown_sim::landing::space::{SpaceScenario, thrust_to_weight};

use super::axes::KeyError;
use super::stated::StatedKeys;
use crate::error::Result;
use crate::vehicle::scaling::{deck, scaled};
use crate::vehicle::{PRESETS, RotorLayout, VehicleSettings, greatest_thrust_n, motors_by};

/// Keys of the scenario that state what a key of `[vehicle]` states.
const SAME: [(&str, &str); 3] = [
    ("mass_kg", "plant.mass_kg"),
    ("rotor_radius_m", "plant.rotor_radius_m"),
    ("arm_m", "plant.rotor_spacing_m"),
];

/// Cards that describe the vehicle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct VehicleCards<'a> {
    pub(super) thrust: Option<&'a Card>,
    pub(super) dynamic: Option<&'a Card>,
}

/// Scales the scenario to the vehicle of `[vehicle]` and of the cards, and puts the motors of the thrust card into it.
/// Returns what was done, in a line, and what may be wrong.
///
/// # Errors
/// A mass or size that the scenario states, too; a deck that is scaled by nothing; fewer than three arms; a vehicle whose thrust
/// does not lift it.
pub(super) fn put_into(
    scenario: &mut SpaceScenario,
    vehicle: &VehicleSettings,
    cards: VehicleCards<'_>,
    stated: &StatedKeys,
    bad: &KeyError<'_>,
) -> Result<(Option<String>, Option<String>)> {
    let mut said = Vec::new();
    let given = vehicle.with_preset();
    conflicts(&given, stated, bad)?;
    let own_plant = SAME.iter().any(|(_, key)| stated.states(key));
    let of_cards = [cards.thrust, cards.dynamic].into_iter().flatten();
    let mut given = of_cards
        .filter(|_| !own_plant)
        .fold(given, |given, card| given.with_card(card));
    if let Some(card) = cards.thrust {
        let model = vehicle.thrust(card)?;
        given.greatest_thrust_n = given.greatest_thrust_n.or(Some(greatest_thrust_n(&model)));
    }
    let own = vehicle.with_preset();
    let sized = given.mass_kg.or(given.rotor_radius_m).or(given.arm_m);
    if sized.is_none() && own.scales_deck == Some(true) {
        let message =
            "expected `mass_kg` or `rotor_radius_m` beside it, by which the deck is scaled";
        return Err(bad("vehicle.scales_deck", message));
    }
    // Rotors in a row or on one axis cannot hold an attitude.
    if given.layout().arms() < 3 {
        let message = format!(
            "expected at least three arms (3 rotors, or 6 coaxial ones), found {}",
            given.layout().arms()
        );
        return Err(bad("vehicle.rotors", &message));
    }
    let another =
        own.greatest_thrust_n.is_some() || own.layout() != VehicleSettings::default().layout();
    let resized = (sized.is_some() || another) && resize(scenario, &given, cards, stated)?;
    if resized {
        said.push(text(scenario, given.layout()));
    }
    if let Some(card) = cards.thrust {
        said.extend(vehicle.multiplied(card));
        // Nothing else than the card knows the motors of a vehicle of a user's own.
        let only_card = resized && own.greatest_thrust_n.is_none();
        said.extend(motors(scenario, card, only_card, stated)?);
    }
    // The card's own thrust is checked with its motors, whose law may give less beyond the card's throttles.
    let lift = thrust_to_weight(&scenario.plant);
    if let (false, None, Ok(lift)) = (given.is_empty(), cards.thrust, lift)
        && lift < LEAST_THRUST_TO_WEIGHT
    {
        let expected = format!(
            "expected a greatest thrust of at least {LEAST_THRUST_TO_WEIGHT} times the weight, found {lift:.3}"
        );
        return Err(bad("vehicle", &expected));
    }
    let warning = resized.then(|| given.overlap()).flatten();
    Ok(((!said.is_empty()).then(|| said.join("; ")), warning))
}

/// A vehicle that `[vehicle]` and the scenario state apart.
fn conflicts(given: &VehicleSettings, stated: &StatedKeys, bad: &KeyError<'_>) -> Result<()> {
    let values = [given.mass_kg, given.rotor_radius_m, given.arm_m];
    for ((name, key), value) in SAME.iter().zip(values) {
        if value.is_some() && stated.states(key) {
            let message = format!("`scenario.{key}` states it as well; remove one of them");
            return Err(bad(&format!("vehicle.{name}"), &message));
        }
    }
    Ok(())
}

/// Scales the scenario; whether the vehicle is another than the standard one.
fn resize(
    scenario: &mut SpaceScenario,
    given: &VehicleSettings,
    cards: VehicleCards<'_>,
    stated: &StatedKeys,
) -> Result<bool> {
    let of = given.ratios();
    let of_card = |key: &str| {
        cards.thrust.is_some() && key.starts_with("models.thrust")
            || cards.dynamic.is_some() && key.starts_with("models.dynamic")
    };
    let mut own = scaled(scenario, &of, &|key| stated.states(key) || of_card(key))?;
    if !stated.states("plant.rotor_spacing_m") {
        own.plant.rotor_spacing_m *= given.layout().lever_of_four();
    }
    if given.scales_deck == Some(true) {
        deck(&mut own.deck, of.radius);
    }
    let others = own != *scenario;
    *scenario = own;
    Ok(others)
}

fn text(scenario: &SpaceScenario, layout: RotorLayout) -> String {
    let plant = &scenario.plant;
    let rotors = match layout {
        RotorLayout {
            rotors,
            coaxial: true,
        } => format!(", {rotors} coaxial rotors, simulated by four"),
        RotorLayout { rotors: 4, .. } => String::new(),
        RotorLayout { rotors, .. } => format!(", {rotors} rotors, simulated by four"),
    };
    // Scaled values end in digits of rounding.
    let mass_kg = (plant.mass_kg * 1e6).round() / 1e6;
    let presets = PRESETS.iter().map(|preset| preset.mass_kg);
    let least_kg = presets.clone().fold(f64::INFINITY, f64::min);
    let greatest_kg = presets.fold(0.0, f64::max);
    let tried = match (least_kg..=greatest_kg).contains(&mass_kg) {
        true => String::new(),
        false => format!("; landings were tried with {least_kg} to {greatest_kg} kg"),
    };
    format!(
        "simulated vehicle: {mass_kg} kg, rotor radius {:.4} m{rotors}{tried}",
        plant.rotor_radius_m
    )
}

/// Puts the motors of a thrust card into the belief, and into the vehicle where only the card knows them or its own motors
/// give another thrust. Returns what was done.
fn motors(
    scenario: &mut SpaceScenario,
    card: &Card,
    only_card: bool,
    stated: &StatedKeys,
) -> Result<Option<String>> {
    let (fit, others) = motors_by(card, &scenario.models.thrust, &scenario.plant)?;
    if !stated.states("believed.motor") {
        scenario.believed.motor = Some(fit.motor);
    }
    if !(others || only_card) || stated.states("plant.motor") {
        return Ok(None);
    }
    scenario.plant.motor = fit.motor;
    Ok(Some(format!(
        "simulated motors: those of card `{}` {}",
        card.name,
        fit.text()
    )))
}
