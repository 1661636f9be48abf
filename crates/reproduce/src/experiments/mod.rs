//! The paper's four experiments on the virtual rig and vehicle, and landings at sea.

pub mod ground_effect;
pub mod landing;
pub mod results;
pub mod sea;
pub mod thrust;

use rayon::prelude::*;
use touchdown_campaign::progress::Progress;
use touchdown_campaign::settings_file::check_seed;
use touchdown_campaign::vehicle::VehicleSettings;
use touchdown_campaign::vertical::controllers::{self, Cards};
use touchdown_identify::{Origin, rig as force_rig, thrust as stand};
use touchdown_model::Form;
use touchdown_model::card::Vehicle;
use touchdown_sim::rig::sets;
use touchdown_sim::rig::{self, RigSettings, RigTrial};
use touchdown_trial::Trial;

use crate::error::{Error, Result};
use crate::settings::ReproduceSettings;

/// All experiments of one run.
#[derive(Clone, Debug)]
pub struct Run {
    /// The settings.
    pub settings: ReproduceSettings,
    /// IV-B.1: with the plate at 0.75 m, then without it.
    pub thrust: [thrust::PlateState; 2],
    /// IV-B.2.
    pub ground_effect: ground_effect::GroundEffectExperiment,
    /// The cards that are flown.
    pub cards: Cards,
    /// IV-C and IV-D.
    pub landing: landing::LandingExperiments,
    /// At sea, in six degrees of freedom.
    pub sea: sea::SeaExperiment,
}

/// Runs everything: a pure function of the settings, with any number of threads.
///
/// # Errors
/// Settings that make no sense.
pub fn run(settings: &ReproduceSettings, progress: &dyn Progress) -> Result<Run> {
    check(settings, "settings")?;
    let origin = origin(settings, Some(command(settings)))?;
    let thrust = thrust::run(settings, &origin, progress)?;
    // The force is extracted with the better of the two: the plate was out of the way.
    let [_, removed] = &thrust;
    let thrust_card = removed.models[0].card.clone();
    let ground_effect = ground_effect::run(settings, &thrust_card, &origin, progress)?;
    let flown = |form| {
        let rich = ground_effect.card(1, form).cloned();
        rich.ok_or_else(|| Error::data("rich data", format!("a card `{form:?}`"), "none"))
    };
    let cards = Cards {
        vehicle: VehicleSettings::default(),
        thrust: thrust_card,
        empirical: Some(flown(Form::Empirical)?),
        dynamic: Some(flown(Form::Lag)?),
    };
    let landing = landing::run(settings, &cards, progress)?;
    let sea = sea::run(settings, &cards, progress)?;
    Ok(Run {
        settings: settings.clone(),
        thrust,
        ground_effect,
        cards,
        landing,
        sea,
    })
}

/// Checks all settings of a run; `file` names them in errors.
///
/// # Errors
/// The first setting out of range.
pub fn check(settings: &ReproduceSettings, file: &str) -> Result<()> {
    let bad = |key: &str, message: String| Error::setting(file, key, &message);
    if !(1..=100_000).contains(&settings.trials) {
        return Err(bad(
            "trials",
            format!("expected 1 to 100000, found {}", settings.trials),
        ));
    }
    check_seed(settings.seed, file)?;
    settings
        .rig
        .validate()
        .map_err(|e| bad("rig", e.to_string()))?;
    settings.identification.check(file)?;
    for (key, land) in [
        ("ground_landing", settings.ground_landing),
        ("deck_landing", settings.deck_landing),
    ] {
        controllers::check(&land).map_err(|(of, message)| bad(&format!("{key}.{of}"), message))?;
        land.scenario
            .validate()
            .map_err(|e| bad(&format!("{key}.scenario"), e.to_string()))?;
    }
    sea::cells(settings, None, file).map(drop)
}

/// The command that redoes a run with these settings.
#[must_use]
pub fn command(settings: &ReproduceSettings) -> String {
    let reference = if settings.quick {
        ReproduceSettings::quick()
    } else {
        ReproduceSettings::default()
    };
    let mut out = String::from("touchdown reproduce");
    if settings.quick {
        out.push_str(" --quick");
    }
    let plain = ReproduceSettings {
        seed: reference.seed,
        trials: reference.trials,
        ..settings.clone()
    };
    if plain != reference {
        out.push_str(" --settings settings.toml");
    }
    out.push_str(&format!(
        " --seed {} --trials {}",
        settings.seed, settings.trials
    ));
    out
}

/// The cards that landings need, identified on the virtual rig of `rig`: eq. (8) with the plate removed, then
/// eq. (2) and the lag form on the rich data.
///
/// # Errors
/// Settings that make no sense.
pub fn identify_cards(rig: &RigSettings, seed: u64, progress: &dyn Progress) -> Result<Cards> {
    let settings = ReproduceSettings {
        seed,
        rig: *rig,
        ..ReproduceSettings::default()
    };
    check(&settings, "settings")?;
    let origin = origin(&settings, None)?;
    let identification = &settings.identification;
    let thrust_trials = sets::thrust_training(false, extent(&settings));
    let ground_trials = sets::ground_effect_rich(extent(&settings));
    progress.stage(
        "identification",
        (thrust_trials.len() + ground_trials.len() + 3) as u64,
    );
    let recorded = record(&thrust_trials, &settings, progress)?;
    let thrust_origin = origin.with_inputs(&recorded);
    let settings_of_thrust = thrust::of_the_rig(identification);
    let thrust = stand::library(&recorded, &settings_of_thrust, &thrust_origin)?.card;
    progress.step();
    let recorded = record(&ground_trials, &settings, progress)?;
    let ground_origin = origin.with_inputs(&recorded);
    let prepared = recorded
        .iter()
        .map(|t| Ok(force_rig::prepare(t, &thrust)?))
        .collect::<Result<Vec<_>>>()?;
    let fit = |form| -> Result<_> {
        let made = force_rig::fit(form, &prepared, identification, &ground_origin)?;
        progress.step();
        Ok(made.card)
    };
    Ok(Cards {
        empirical: Some(fit(Form::Empirical)?),
        dynamic: Some(fit(Form::Lag)?),
        vehicle: VehicleSettings::default(),
        thrust,
    })
}

/// The origin of cards that are identified on the virtual rig.
fn origin(settings: &ReproduceSettings, command: Option<String>) -> Result<Origin> {
    let plant = &settings.rig.plant;
    let vehicle = Vehicle {
        name: "virtual vehicle".into(),
        mass_kg: Some(plant.mass_kg),
        rotor_radius_m: Some(plant.rotor_radius_m),
        ..Vehicle::default()
    };
    let mut origin = Origin::of(&[], vehicle);
    origin.provenance.seed = Some(settings.seed);
    origin.provenance.settings_sha256 = Some(results::settings_sha256(settings)?);
    origin.provenance.command = command;
    Ok(origin)
}

/// Runs rig trials, in order.
fn record(
    trials: &[RigTrial],
    settings: &ReproduceSettings,
    progress: &dyn Progress,
) -> Result<Vec<Trial>> {
    trials
        .par_iter()
        .map(|trial| {
            let recorded = rig::run(&settings.rig, trial, settings.seed)?;
            progress.step();
            Ok(recorded)
        })
        .collect()
}

/// Fewer trials for a fast look.
fn extent(settings: &ReproduceSettings) -> touchdown_sim::rig::sets::Extent {
    use touchdown_sim::rig::sets::Extent;
    if settings.quick {
        Extent::Quick
    } else {
        Extent::Full
    }
}
