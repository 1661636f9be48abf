//! `touchdown land`: the vertical vehicle.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use serde::Serialize;
use touchdown::settings;
use touchdown::{Error, Result};
use touchdown_campaign::cards::CardPaths;
use touchdown_campaign::measured_deck::{MeasuredDeck, SERIES};
use touchdown_campaign::progress::Progress as _;
use touchdown_campaign::vehicle::check_lift;
use touchdown_campaign::vertical::controllers::{Cards, controller_over};
use touchdown_campaign::vertical::landings::{self, LandingFigures};
use touchdown_campaign::vertical::scenario::LandScenario;
use touchdown_campaign::vertical::vehicle::{self, VehicleOfCards};
use touchdown_flight::Method;
use touchdown_model::Card;
use touchdown_reproduce::experiments::identify_cards;
use touchdown_reproduce::experiments::landing::{MethodLandings, TRACES};
use touchdown_reproduce::pages;
use touchdown_sim::body::plant::PlantSettings;
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::rig::RigSettings;

use super::outcomes;
use crate::cli::args::land::LandArgs;
use crate::cli::context::Context;
use crate::cli::output;
use touchdown_terminal::Done;

/// Name of the scenario beside the results.
const SCENARIO: &str = "scenario.toml";

#[derive(Serialize)]
struct LandResults<'a> {
    schema: u32,
    version: &'static str,
    seed: u64,
    trials: usize,
    deck_acceleration: bool,
    landing: BTreeMap<&'static str, &'a LandingFigures>,
}

pub(super) fn run(context: &Context, args: &LandArgs) -> Result<Done> {
    let mut scenario = load(args)?;
    let measured = measured_deck(&mut scenario)?;
    if let Some(measured) = &measured {
        context.aside(&measured.text);
        for warning in &measured.warnings {
            context.warn(warning);
        }
    }
    let given = GivenCards::read(&scenario.cards)?;
    let followed = vehicle::follow(&scenario, given.thrust.as_ref(), given.dynamic.as_ref())?;
    if let Some(followed) = &followed {
        scenario = followed.scenario.clone();
        scenario.check("the vehicle of the cards")?;
        context.say(&followed.text);
    }
    if let Some(text) = given
        .thrust
        .as_ref()
        .and_then(|card| scenario.vehicle.multiplied(card))
    {
        context.say(&text);
    }
    let all = [&given.thrust, &given.empirical, &given.dynamic].map(Option::as_ref);
    let mismatches = vehicle::mismatches(&all, &scenario.scenario.plant);
    for mismatch in &mismatches {
        context.warn(mismatch);
    }
    // A folder that cannot be written to is better known before the work than after it.
    output::folder(&args.out)?;
    let cards = cards(context, &scenario, given, followed.as_ref())?;
    check_lift(
        &cards.thrust,
        &cards.thrust_model()?,
        scenario.scenario.plant.weight_n(),
    )?;
    if let Some(given) = &args.scenario {
        output::replaces_not(&args.out.join(SCENARIO), "scenario", given)?;
    }
    let methods = fly(context, &scenario, measured.as_ref(), &cards)?;

    output::results_folder(context, &args.out)?;
    if let Some(measured) = &measured {
        output::write(&args.out.join(SERIES), &measured.bytes)?;
    }
    // The scenario beside the results names the cards that were flown, wherever they came from.
    let scenario = LandScenario {
        cards: write_cards(&cards, &args.out)?,
        ..scenario
    };
    output::write(
        &args.out.join(SCENARIO),
        settings::to_toml(&scenario)?.as_bytes(),
    )?;
    output::write(
        &args.out.join("landings.csv"),
        outcomes::vertical(&methods).as_bytes(),
    )?;
    let flown = followed.as_ref().map(|f| f.text.as_str());
    pages::land(&methods, &scenario, flown, &mismatches, &args.out)?;
    let results = LandResults {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        seed: scenario.seed,
        trials: scenario.trials,
        deck_acceleration: scenario.deck_acceleration,
        landing: methods
            .iter()
            .map(|m| (m.method.name(), &m.figures))
            .collect(),
    };
    output::results(&args.out, &results)?;
    let mut lines: Vec<String> = methods.iter().map(line).collect();
    lines.extend(methods.iter().filter_map(outcomes::why_not_landed));
    context.reported(&lines.join("\n"), &args.out, &results);
    Ok(Done::Whole)
}

/// Lands with every controller. All of them are built before the first landing, so that a bad card costs no time.
fn fly(
    context: &Context,
    scenario: &LandScenario,
    measured: Option<&MeasuredDeck>,
    cards: &Cards,
) -> Result<Vec<MethodLandings>> {
    let land = scenario.land();
    let acceleration = scenario.deck_acceleration;
    let measured_frequency = measured.and_then(|m| m.mean_period_s).map(|s| TAU / s);
    let frequency = measured_frequency.or(land.scenario.deck.angular_frequency());
    let motion = measured.and_then(MeasuredDeck::spline);
    let controllers = scenario
        .controllers
        .iter()
        .map(|&method| {
            Ok((
                method,
                controller_over(method, cards, &land, acceleration, frequency)?,
            ))
        })
        .collect::<Result<Vec<_>>>()?;
    context.stage("landings", (controllers.len() * scenario.trials) as u64);
    controllers
        .iter()
        .map(|(method, controller)| {
            let (trials, seed) = (scenario.trials, scenario.seed);
            let landings = landings::run(
                &land.scenario,
                motion,
                controller,
                trials,
                seed,
                TRACES,
                context,
            )?;
            Ok(MethodLandings {
                method: *method,
                figures: LandingFigures::of(&landings, land.scenario.crash_speed_mps),
                landings,
            })
        })
        .collect()
}

fn load(args: &LandArgs) -> Result<LandScenario> {
    let (mut scenario, file) = match &args.scenario {
        Some(path) => {
            let mut scenario = settings::read::<LandScenario>(path)?;
            let folder = path.parent().unwrap_or(Path::new("."));
            scenario.cards = scenario.cards.from(folder);
            if let Some(series) = &mut scenario.series {
                series.file = folder.join(&series.file);
            }
            (scenario, path.display().to_string())
        }
        None => (LandScenario::default(), "arguments".to_string()),
    };
    if !args.controllers.is_empty() {
        scenario.controllers = args
            .controllers
            .iter()
            .map(|name| method(name))
            .collect::<Result<_>>()?;
    }
    if let Some(trials) = args.trials {
        scenario.trials = trials;
    }
    if let Some(seed) = args.seed {
        scenario.seed = seed;
    }
    if args.no_acceleration {
        scenario.deck_acceleration = false;
    }
    let CardPaths {
        thrust,
        empirical,
        dynamic,
    } = &mut scenario.cards;
    for (path, given) in [
        (thrust, &args.thrust),
        (empirical, &args.empirical),
        (dynamic, &args.dynamic),
    ] {
        if let Some(given) = given {
            *path = Some(given.clone());
        }
    }
    scenario.check(&file)?;
    Ok(scenario)
}

/// The measured motion of the deck, where the scenario names one; the deck of the scenario then lies still.
fn measured_deck(scenario: &mut LandScenario) -> Result<Option<MeasuredDeck>> {
    let Some(series) = &mut scenario.series else {
        return Ok(None);
    };
    let measured = MeasuredDeck::read(series, Path::new(""))?;
    series.file = SERIES.into();
    scenario.scenario.deck = DeckMotion::Still;
    Ok(Some(measured))
}

fn method(name: &str) -> Result<Method> {
    let found = Method::VERTICAL.into_iter().find(|m| m.name() == name);
    found.ok_or_else(|| {
        let names = Method::VERTICAL.map(Method::name).join(", ");
        Error::Arguments(format!(
            "--controller: `{name}` needs six degrees of freedom (--space); expected some of {names}"
        ))
    })
}

/// The cards that are given.
struct GivenCards {
    thrust: Option<Card>,
    empirical: Option<Card>,
    dynamic: Option<Card>,
}

impl GivenCards {
    fn read(paths: &CardPaths) -> Result<Self> {
        let read = |path: &Option<PathBuf>| path.as_deref().map(Card::read).transpose();
        Ok(Self {
            thrust: read(&paths.thrust)?,
            empirical: read(&paths.empirical)?,
            dynamic: read(&paths.dynamic)?,
        })
    }
}

/// The cards that are given; identifies those that are not and that a method needs. For the vehicle of the cards that is
/// that of the default vehicle in proportion.
fn cards(
    context: &Context,
    scenario: &LandScenario,
    given: GivenCards,
    followed: Option<&VehicleOfCards>,
) -> Result<Cards> {
    let flies = |m: Method| scenario.controllers.contains(&m);
    let missing = given.thrust.is_none()
        || given.empirical.is_none() && flies(Method::Empirical)
        || given.dynamic.is_none() && flies(Method::Dynamic);
    let own = if missing {
        let plant = match followed {
            Some(_) => PlantSettings::default(),
            None => scenario.scenario.plant,
        };
        let rig = RigSettings {
            plant,
            ..RigSettings::default()
        };
        Some(identify_cards(&rig, scenario.seed, context)?)
    } else {
        None
    };
    let of_rig = |pick: fn(&Cards) -> Option<Card>| own.as_ref().and_then(pick);
    let empirical = || {
        let card = of_rig(|c| c.empirical.clone())?;
        Some(match followed {
            Some(followed) => vehicle::empirical(card, followed),
            None => card,
        })
    };
    let dynamic = || {
        let card = of_rig(|c| c.dynamic.clone())?;
        match followed {
            Some(followed) => vehicle::dynamic(card, followed),
            None => Some(card),
        }
    };
    Ok(Cards {
        vehicle: scenario.vehicle,
        empirical: given.empirical.or_else(empirical),
        dynamic: given.dynamic.or_else(dynamic),
        thrust: given
            .thrust
            .or_else(|| of_rig(|c| Some(c.thrust.clone())))
            .ok_or_else(|| Error::Arguments("no thrust card".into()))?,
    })
}

/// Writes the cards that are flown and gives their paths, relative to the folder.
fn write_cards(cards: &Cards, out: &Path) -> Result<CardPaths> {
    let write = |card: &Card| {
        let path = Path::new("cards").join(format!("{}.toml", card.name));
        card.write(&out.join(&path)).map(|()| path)
    };
    Ok(CardPaths {
        thrust: Some(write(&cards.thrust)?),
        empirical: cards.empirical.as_ref().map(write).transpose()?,
        dynamic: cards.dynamic.as_ref().map(write).transpose()?,
    })
}

fn line(m: &MethodLandings) -> String {
    let f = &m.figures;
    let mean = |s: Option<touchdown_campaign::statistics::Summary>| {
        s.map_or_else(
            || "–".to_string(),
            |s| format!("{:.3} ± {:.3}", s.mean, s.sd.unwrap_or(0.0)),
        )
    };
    format!(
        "{:<10} landed {:>3} of {:<3} (hard {}, crashed {})  T_L {} s   V_L {} m/s   S_L {} m",
        m.method.name(),
        f.landed,
        f.trials,
        f.hard,
        f.crashed,
        mean(f.t_l_s),
        mean(f.v_l_mps),
        mean(f.s_l_m)
    )
}
