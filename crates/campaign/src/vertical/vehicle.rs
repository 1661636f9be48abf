//! The vehicle of model cards as the simulated one.
//!
//! Cards say which vehicle they are of: its mass m and rotor radius R. A landing whose scenario leaves the plant at its
//! default flies that vehicle instead: the default one (m₀ = 1.37 kg, R₀ = 0.12 m) in proportion by Froude's law, lengths
//! with R/R₀, times with √(R/R₀), forces with m/m₀, so that a thrust that is wrong by one per cent costs the same share of
//! a rotor radius. What no proportion can know comes from the cards: the motors and the strength of the ground effect.

use touchdown_flight::ground_effect::{GroundEffect as _, GroundEffectInput, GroundEffectModel};
use touchdown_model::{Card, Form};
use touchdown_sim::body::motor::Motor;
use touchdown_sim::body::plant::{Plant, PlantSettings};
use touchdown_sim::landing::vertical::LandingScenario;

use super::scenario::LandScenario;
use crate::error::{Error, Result};
use crate::vehicle::{MotorFit, VehicleSettings, in_proportion, motors_of};
use touchdown_flight::method::VerticalSettings;

/// Share by which masses and radii may differ and still be of one vehicle.
const SAME: f64 = 0.01;
/// Weakest and strongest ground effect that a card may give, of the default vehicle's.
const STRENGTH: [f64; 2] = [0.1, 2.0];

/// A scenario of the cards' vehicle.
#[derive(Clone, Debug)]
pub struct VehicleOfCards {
    /// The scenario, with every value that followed the vehicle.
    pub scenario: LandScenario,
    /// R/R₀.
    pub size: f64,
    /// One line for people: what is flown.
    pub text: String,
}

/// The scenario with the vehicle of `[vehicle]` and of the cards in it: mass and rotor radius where the scenario leaves the
/// plant at its default, motors where it leaves those. None where nothing changes. Settings of heights, gains and limits
/// follow mass and size where they have their defaults. Without a radius, that of a vehicle of equal density is taken.
///
/// # Errors
/// Cards that cannot be flown, a vehicle that cannot lift itself, or one that both `[vehicle]` and the plant state.
pub fn follow(
    scenario: &LandScenario,
    thrust: Option<&Card>,
    dynamic: Option<&Card>,
) -> Result<Option<VehicleOfCards>> {
    let given = &scenario.vehicle.with_preset();
    let Some(card) = thrust else {
        return match given.is_empty() {
            true => Ok(None),
            false => Err(Error::Arguments(
                "[vehicle] needs the thrust of its motors: give a card with --thrust".to_string(),
            )),
        };
    };
    let model = given.thrust(card)?;
    let mut own = scenario.clone();
    let size = size_of(&mut own, &[thrust, dynamic])?;
    let fit = motors_of(card, &model, &own.scenario.plant)?;
    if size.is_none() && fit.is_none() {
        return Ok(None);
    }
    let plant = &mut own.scenario.plant;
    plant.motor = fit.map_or(plant.motor, |fit| fit.motor);
    let strength = match dynamic.filter(|_| size.is_some()) {
        Some(card) => strength(card, plant)?,
        None => None,
    };
    plant.ground_effect_scale = strength.unwrap_or(plant.ground_effect_scale);
    let plant = *plant;
    let full_n = Motor::new(&plant.motor, plant.weight_n())?
        .rest(1.0)
        .powi(2);
    let size = size.unwrap_or(1.0);
    own.control = control(&scenario.control, &plant, size, full_n);
    // What is in the plant now is stated once.
    own.vehicle = VehicleSettings {
        rotors: given.rotors,
        ..VehicleSettings::default()
    };
    let text = description(&card.name, &own.scenario, fit.as_ref(), strength);
    Ok(Some(VehicleOfCards {
        scenario: own,
        size,
        text,
    }))
}

/// Puts mass and rotor radius of `[vehicle]` or of the cards into the plant, with heights in proportion; R/R₀ where that
/// makes another vehicle.
fn size_of(own: &mut LandScenario, cards: &[Option<&Card>; 2]) -> Result<Option<f64>> {
    let standard = PlantSettings::default();
    let given = own.vehicle.with_preset();
    let plant = &mut own.scenario.plant;
    if *plant != standard {
        return match given.mass_kg.or(given.rotor_radius_m).or(given.arm_m) {
            None => Ok(None),
            Some(_) => Err(Error::Arguments(
                "[vehicle] and [scenario.plant] both set the vehicle; remove one of them"
                    .to_string(),
            )),
        };
    }
    let common = |value: fn(&Card) -> Option<f64>| common_value(*cards, value);
    let mass_kg = given.mass_kg.or(common(|c| c.vehicle.mass_kg));
    let radius_m = given
        .rotor_radius_m
        .or(common(|c| c.vehicle.rotor_radius_m));
    let Some(mass_kg) = mass_kg else {
        return Ok(None);
    };
    let of_density = || standard.rotor_radius_m * (mass_kg / standard.mass_kg).cbrt();
    let radius_m = radius_m.unwrap_or_else(of_density);
    if same(mass_kg, standard.mass_kg) && same(radius_m, standard.rotor_radius_m) {
        return Ok(None);
    }
    *plant = in_proportion(mass_kg, radius_m, given.arm_m)?;
    let size = radius_m / standard.rotor_radius_m;
    scale_heights(&mut own.scenario, size);
    Ok(Some(size))
}

/// The value that the cards have in common; none where they differ or none has it.
fn common_value(cards: [Option<&Card>; 2], value: fn(&Card) -> Option<f64>) -> Option<f64> {
    match cards.map(|card| card.and_then(value)) {
        [Some(a), Some(b)] if !same(a, b) => None,
        [a, b] => a.or(b).filter(|v| v.is_finite() && *v > 0.0),
    }
}

/// Start, touchdown and ceiling of the vehicle, where the scenario leaves them at their defaults.
fn scale_heights(landing: &mut LandingScenario, size: f64) {
    let default = LandScenario::default().scenario;
    let highest_m = landing.deck.highest_m();
    follows(&mut landing.landed_height_m, default.landed_height_m, |v| {
        v * size
    });
    // In proportion the start is above four rotor radii; a small vehicle also starts well above the deck's swing.
    follows(&mut landing.start_height_m, default.start_height_m, |v| {
        (v * size).max(3.0 * highest_m)
    });
    let start_height_m = landing.start_height_m;
    follows(&mut landing.ceiling_m, default.ceiling_m, |v| {
        v.max(3.0 * start_height_m)
    });
}

/// What is flown, in one line.
fn description(
    card: &str,
    landing: &LandingScenario,
    fit: Option<&MotorFit>,
    strength: Option<f64>,
) -> String {
    let standard = PlantSettings::default();
    let ground_effect = strength.map_or_else(
        || "as the default one's".to_string(),
        |s| {
            let like = if STRENGTH.contains(&s) {
                "as near to the card's as is taken"
            } else {
                "as the card's"
            };
            format!("{s:.2} times the default one's, {like}")
        },
    );
    let motors = fit.map_or_else(
        || "motors as the default one's".to_string(),
        |fit| format!("motors of card `{card}` {}", fit.text()),
    );
    format!(
        "simulated vehicle: {} kg, rotor radius {:.4} m (the default one, {} kg and {} m, in proportion); {motors}; ground effect \
         {ground_effect}; starts at {:.3} m, has landed at {:.3} m",
        landing.plant.mass_kg,
        landing.plant.rotor_radius_m,
        standard.mass_kg,
        standard.rotor_radius_m,
        landing.start_height_m,
        landing.landed_height_m,
    )
}

/// Warnings about cards of another vehicle than the plant: one line for each.
#[must_use]
pub fn mismatches(cards: &[Option<&Card>], plant: &PlantSettings) -> Vec<String> {
    let told = |card: &Card| {
        let other = |value: Option<f64>, simulated: f64| value.filter(|v| !same(*v, simulated));
        let wrong = [
            other(card.vehicle.mass_kg, plant.mass_kg)
                .map(|v| format!("of {v} kg, the simulated vehicle has {} kg", plant.mass_kg)),
            other(card.vehicle.rotor_radius_m, plant.rotor_radius_m).map(|v| {
                let simulated = plant.rotor_radius_m;
                format!("of rotor radius {v} m, the simulated vehicle has {simulated} m")
            }),
        ];
        let wrong: Vec<String> = wrong.into_iter().flatten().collect();
        (!wrong.is_empty()).then(|| {
            format!(
                "card `{}` is of another vehicle than the simulated one: {}; set `scenario.plant` to the card's vehicle, \
                 or (without --space) leave it out and give a thrust and a ground-effect card of one vehicle",
                card.name,
                wrong.join("; ")
            )
        })
    };
    cards
        .iter()
        .flatten()
        .filter_map(|card| told(card))
        .collect()
}

/// The card of eq. (2), identified on the default vehicle, for the vehicle of a scenario that followed the cards: lengths
/// in proportion, `mu` by the strength of the ground effect.
#[must_use]
pub fn empirical(mut card: Card, followed: &VehicleOfCards) -> Card {
    let plant = &followed.scenario.scenario.plant;
    for name in ["r", "h_r"] {
        if let Some(length) = card.constants.get_mut(name) {
            *length *= followed.size;
        }
    }
    if let Some(range) = card.validity.inputs.get_mut("z") {
        *range = range.map(|z| z * followed.size);
    }
    for term in card.terms.iter_mut().filter(|t| t.of == "mu") {
        let by = plant.ground_effect_scale;
        term.value *= by;
        term.std_error = term.std_error.map(|v| v * by);
        term.ci95 = term.ci95.map(|ci| ci.map(|v| v * by));
    }
    card.vehicle.mass_kg = Some(plant.mass_kg);
    card.vehicle.rotor_radius_m = Some(plant.rotor_radius_m);
    card.description =
        "Identified on the virtual rig for the default vehicle, lengths in proportion.".into();
    card
}

/// The card of the dynamic model, identified on the default vehicle, for the vehicle of a scenario that followed the cards:
/// lengths in proportion, lags with √(R/R₀), the ratio by the strength of the ground effect, and its change with velocity as
/// the climb damping over the weight. None for forms other than `lag`.
#[must_use]
pub fn dynamic(mut card: Card, followed: &VehicleOfCards) -> Option<Card> {
    if card.form != Form::Lag {
        return None;
    }
    let (plant, standard) = (&followed.scenario.scenario.plant, PlantSettings::default());
    for length in card.constants.values_mut() {
        *length *= followed.size;
    }
    if let Some(range) = card.validity.inputs.get_mut("z") {
        *range = range.map(|z| z * followed.size);
    }
    let damping = |p: &PlantSettings| p.climb_damping_ns_per_m / p.weight_n();
    for term in &mut card.terms {
        let by = match term.of.as_str() {
            "tau" => followed.size.sqrt(),
            "h" => plant.ground_effect_scale,
            _ => damping(plant) / damping(&standard),
        };
        term.value *= by;
        term.std_error = term.std_error.map(|v| v * by);
        term.ci95 = term.ci95.map(|ci| ci.map(|v| v * by));
    }
    card.vehicle.mass_kg = Some(plant.mass_kg);
    card.vehicle.rotor_radius_m = Some(plant.rotor_radius_m);
    card.description =
        "Identified on the virtual rig for the default vehicle, in proportion.".into();
    Some(card)
}

fn same(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() <= SAME
}

fn follows(value: &mut f64, default: f64, own: impl Fn(f64) -> f64) {
    if *value == default {
        *value = own(*value);
    }
}

/// Gains and limits: forces with the weight, rates with 1/√size.
fn control(
    given: &VerticalSettings<f64>,
    plant: &PlantSettings,
    size: f64,
    full_n: f64,
) -> VerticalSettings<f64> {
    let (default, standard) = (VerticalSettings::default(), PlantSettings::default());
    let weight = plant.mass_kg / standard.mass_kg;
    let rate = 1.0 / size.sqrt();
    let mut own = *given;
    if given.gains == default.gains {
        own.gains.k_p *= weight * rate;
        own.gains.k_i *= weight * rate * rate;
        own.gains.gamma *= rate;
        own.gains.integral_limit_n *= weight;
    }
    if given.limits == default.limits {
        own.limits.thrust_min_n *= weight;
        own.limits.thrust_max_n = full_n;
    }
    if given.imbc_poles_per_s == default.imbc_poles_per_s {
        // No quicker than the default ones: delays do not shrink with the vehicle, and this law does not bear them.
        own.imbc_poles_per_s = given.imbc_poles_per_s.map(|p| p * rate.min(1.0));
    }
    follows(&mut own.ssc_rho_n, default.ssc_rho_n, |v| v * weight);
    follows(&mut own.ssc_phi_mps, default.ssc_phi_mps, |v| v / rate);
    // The motors' share of the delay.
    follows(&mut own.deck_lead_s, default.deck_lead_s, |v| {
        (v - standard.motor.time_constant_s + plant.motor.time_constant_s).max(0.0)
    });
    own
}

/// Scale factor of the plant's ground effect that gives the card's steady ratio, by least squares over 0.3 to 2 rotor
/// radii within the card's heights; none for forms whose state at rest is not known.
fn strength(card: &Card, plant: &PlantSettings) -> Result<Option<f64>> {
    let model = card.ground_effect()?;
    if !matches!(
        model.model,
        GroundEffectModel::StaticMap(_)
            | GroundEffectModel::Lag(_)
            | GroundEffectModel::Empirical(_)
    ) {
        return Ok(None);
    }
    let heights: Vec<f64> = (3..=20)
        .map(|i| 0.1 * f64::from(i) * plant.rotor_radius_m)
        .filter(|z| (model.validity.height_min_m..=model.validity.height_max_m).contains(z))
        .collect();
    let ratio = |height_m: f64| {
        let input = GroundEffectInput {
            thrust_n: plant.weight_n(),
            throttle: 0.5,
            height_m,
            ..GroundEffectInput::default()
        };
        let lift = model.lift(&model.rest(&input), &input);
        lift.total_n(input.thrust_n) / input.thrust_n
    };
    let wanted: Vec<f64> = heights.iter().map(|z| ratio(*z)).collect();
    let mut scale = 1.0;
    // The plant's ratio is not quite linear in its strength.
    for _ in 0..5 {
        let own = Plant::new(&PlantSettings {
            ground_effect_scale: scale,
            ..*plant
        })?;
        let (mut both, mut square) = (0.0, 0.0);
        for (z, wanted) in heights.iter().zip(&wanted) {
            let simulated = own.lift_ratio(own.target(*z));
            both += wanted * simulated;
            square += simulated * simulated;
        }
        if square <= 0.0 {
            return Ok(None);
        }
        scale = (scale * both / square).clamp(STRENGTH[0], STRENGTH[1]);
    }
    Ok(Some(scale))
}
