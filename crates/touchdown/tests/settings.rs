//! Every key of the settings of identification does what it says: it is refused where it is unknown, and it changes
//! the fit where it is known.

use crate::flights;
use std::collections::BTreeMap;

use touchdown::settings::parse;
use touchdown_identify::flights::{Flight, ground_effect as from_flights};
use touchdown_identify::rig::{self as ground_effect, GroundTrial, levels};
use touchdown_identify::{FittedCard, IdentificationSettings, Origin, thrust};
use touchdown_model::Form;
use touchdown_sim::body::plant::GroundLaw;
use touchdown_sim::rig::sets::{self, Extent};
use touchdown_sim::rig::{self, RigSettings, RigTrial};
use touchdown_trial::Trial;

fn record(trials: Vec<RigTrial>, duration_s: f64) -> Vec<Trial> {
    let short = |trial: RigTrial| RigTrial {
        duration_s,
        ..trial
    };
    let run = |trial| rig::run(&RigSettings::default(), &short(trial), 1).unwrap();
    trials.into_iter().map(run).collect()
}

/// A rotor behind a lag of 0.1 s on a staircase of throttle, with a battery that sags.
fn staircase() -> Trial {
    let time_s: Vec<f64> = (0..1600).map(|i| 0.01 * f64::from(i)).collect();
    let throttle: Vec<f64> = (0..1600).map(|i| 0.2 + 0.08 * f64::from(i / 200)).collect();
    let late = sindy::trajectory::delay::first_order_lag(&time_s, &throttle, 0.1, 0.0);
    let battery: Vec<f64> = time_s.iter().map(|t| 12.0 - 0.03 * t * t).collect();
    let thrust = late
        .iter()
        .zip(&battery)
        .map(|(s, u)| (3.0 * s + s * s) * u / 6.0)
        .collect();
    Trial::new("staircase", time_s)
        .unwrap()
        .with_channel("throttle", throttle)
        .unwrap()
        .with_channel("thrust_n", thrust)
        .unwrap()
        .with_channel("battery_v", battery)
        .unwrap()
}

struct Data {
    staircase: Trial,
    thrust: Vec<Trial>,
    ground: Vec<GroundTrial>,
    flights: Vec<Trial>,
}

impl Data {
    fn new() -> Self {
        let thrust = record(sets::thrust_training(false, Extent::Quick), 12.0);
        let card = thrust::first_order(
            &thrust,
            &IdentificationSettings::default(),
            &Origin::default(),
        )
        .unwrap()
        .card;
        let moving = sets::ground_effect_rich(Extent::Quick);
        let moving = moving
            .into_iter()
            .filter(|t| t.name.starts_with("multisine"));
        let ground = record(moving.collect(), 12.0)
            .iter()
            .map(|t| ground_effect::prepare(t, &card).unwrap())
            .collect();
        let plant = flights::vehicle(1.4, 0.12, GroundLaw::Exponential, 0.15);
        Self {
            staircase: staircase(),
            thrust,
            ground,
            flights: (0..3)
                .map(|seed| flights::fly(&plant, seed, 50.0, 50.0).trial)
                .collect(),
        }
    }

    /// What comes of the settings, in the part that a key belongs to.
    fn result(&self, area: &str, text: &str) -> String {
        let settings: IdentificationSettings = parse(text, "s.toml").unwrap();
        settings.check("s.toml").unwrap();
        let origin = Origin::default();
        let shown = |made: FittedCard| {
            let card = serde_json::to_string(&made.card).unwrap();
            format!("{card} {} {:?}", made.rmse, made.rows_used)
        };
        let ground = |form| {
            let made = ground_effect::fit(form, &self.ground, &settings, &origin);
            made.unwrap()
        };
        let one = std::slice::from_ref(&self.staircase);
        match area {
            "flight" => {
                let flown: touchdown_identify::Result<Vec<Flight>> = self
                    .flights
                    .iter()
                    .map(|trial| Flight::of(trial, &settings.flight))
                    .collect();
                let found = flown.and_then(|flown| {
                    let found = from_flights(&flown, &settings.flight)?;
                    let thrust = found.thrust_card(&settings, &origin);
                    let terms = thrust.map(|made| made.card.terms);
                    Ok(format!(
                        "{:?} {terms:?}",
                        found.result(&flown, &settings.flight)
                    ))
                });
                format!("{found:?}")
            }
            "steps" => shown(thrust::fit(one, &settings, &origin).unwrap()),
            "eq7" => shown(thrust::first_order(&self.thrust, &settings, &origin).unwrap()),
            "eq8" => shown(thrust::library(&self.thrust, &settings, &origin).unwrap()),
            "levels" => {
                let made = ground(Form::Derivative);
                let fitted = levels::Fitted {
                    form: Form::Derivative,
                    made: &made,
                    free_run_rmse_n: None,
                };
                let found = levels::compare(&self.ground, &self.ground[..2], &[fitted], &settings);
                format!("{:?}", found.unwrap())
            }
            form => shown(ground(
                Form::GROUND_EFFECT
                    .into_iter()
                    .find(|f| f.name() == form)
                    .unwrap(),
            )),
        }
    }
}

/// Static maps alone have plateaus; without a form, free run decides.
const STATIC: &str = "[thrust]\nform = \"static_sqrt\"\n";

/// Key, what is changed, where it shows, and what the other settings are meanwhile.
const CASES: &[(&str, &str, &str, &str)] = &[
    ("smoothing.window", "21", "derivative", ""),
    ("smoothing.degree", "4", "derivative", ""),
    (
        "smoothing.thrust_window",
        "31",
        "eq8",
        "[thrust]\nrefine = false\n",
    ),
    ("choice.solver", "\"least_squares\"", "derivative", ""),
    ("choice.criterion", "\"bic\"", "derivative", ""),
    ("choice.folds", "3", "derivative", ""),
    ("choice.seed", "5", "derivative", "[choice]\nfolds = 3\n"),
    (
        "choice.effective_rows",
        "5.0",
        "derivative",
        "[choice]\ncriterion = \"bic\"\n",
    ),
    ("sr3.thresholds", "[0.3]", "derivative", ""),
    ("sr3.nus", "[7.0]", "derivative", ""),
    ("sr3.lambda", "0.3", "derivative", ""),
    ("sr3.nu", "7.0", "derivative", ""),
    ("published.threshold", "3.0", "levels", ""),
    ("published.nu", "1e-7", "levels", ""),
    ("weak.half_width_s", "0.9", "levels", ""),
    ("weak.spacing", "0.5", "levels", ""),
    ("weak.power", "3", "levels", ""),
    ("weak.generalised", "true", "levels", ""),
    ("shooting.window_s", "3.0", "lag", ""),
    (
        "shooting.stride_s",
        "2.0",
        "lag",
        "[shooting]\nwindow_s = 3.0\n",
    ),
    ("shooting.every", "8", "lag", ""),
    ("shooting.noise_n", "3.0", "lag", ""),
    ("shooting.max_iterations", "1", "lag", ""),
    ("thrust.form", "\"static_thrust\"", "steps", ""),
    ("thrust.degree", "1", "steps", STATIC),
    ("thrust.battery", "true", "steps", STATIC),
    ("thrust.settle_s", "0.1", "steps", STATIC),
    ("thrust.min_thrust_n", "2.5", "steps", STATIC),
    ("thrust.library", "[\"1\", \"x\", \"s\"]", "eq8", ""),
    ("thrust.refine", "false", "eq8", ""),
    ("thrust.max_lag_s", "0.03", "eq7", ""),
    ("thrust.dead_time", "\"none\"", "eq8", ""),
    ("ground_effect.rotor_radius_m", "0.2", "empirical", ""),
    ("ground_effect.lengths_m", "[0.1, 0.2, 0.4]", "static", ""),
    (
        "ground_effect.library",
        "[\"1\", \"f\", \"v_p\"]",
        "derivative",
        "",
    ),
    ("ground_effect.lag_bounds_s", "[0.6, 3.0]", "lag", ""),
    ("ground_effect.ratio_limits", "[-0.2, 0.5]", "lag", ""),
    ("ground_effect.velocity_input", "\"deck\"", "lag", ""),
    ("flight.mass_kg", "1.5", "flight", FLIGHT),
    (
        "flight.rotor_radius_m",
        "0.12",
        "flight",
        "[flight]\nresamples = 100\n",
    ),
    ("flight.height_offset_m", "0.02", "flight", FLIGHT),
    ("flight.gravity_mps2", "9.7", "flight", FLIGHT),
    ("flight.idle_throttle", "0.3", "flight", FLIGHT),
    ("flight.reference_radii", "2.5", "flight", FLIGHT),
    ("flight.height_bias_radii", "0.5", "flight", FLIGHT),
    ("flight.least_rate_hz", "100.0", "flight", FLIGHT),
    (
        "flight.resamples",
        "120",
        "flight",
        "[flight]\nrotor_radius_m = 0.12\n",
    ),
    ("flight.seed", "5", "flight", FLIGHT),
];

/// A vehicle whose intervals are drawn quickly.
const FLIGHT: &str = "[flight]\nrotor_radius_m = 0.12\nresamples = 100\n";

fn keys(table: &toml::Table, above: &str, out: &mut Vec<String>) {
    for (key, value) in table {
        match value {
            toml::Value::Table(t) => keys(t, &format!("{above}{key}."), out),
            _ => out.push(format!("{above}{key}")),
        }
    }
}

/// `key = value` in its section, after the other settings.
fn with(other: &str, key: &str, value: &str) -> String {
    let (section, name) = key.split_once('.').unwrap();
    let head = format!("[{section}]\n");
    match other.strip_prefix(&head) {
        Some(rest) => format!("{head}{name} = {value}\n{rest}"),
        None => format!("{head}{name} = {value}\n{other}"),
    }
}

#[test]
fn prop_every_key_changes_what_it_says() {
    let mut all = Vec::new();
    let text = toml::to_string(&IdentificationSettings::default()).unwrap();
    keys(&toml::from_str(&text).unwrap(), "", &mut all);
    // Those without a default value stand in the printed settings as comments. Those of [vehicle], the last table, go into
    // cards (tests/stand_to_landing.rs).
    let lines = touchdown::settings::defaults::IDENTIFY.lines();
    for line in lines.take_while(|line| *line != "[vehicle]") {
        if let Some((name, _)) = line.strip_prefix("# ").and_then(|l| l.split_once(" = "))
            && !name.contains(' ')
        {
            let of = |c: &&(&str, &str, &str, &str)| c.0.ends_with(&format!(".{name}"));
            all.push(CASES.iter().find(of).expect(name).0.to_string());
        }
    }
    for key in &all {
        assert!(CASES.iter().any(|c| c.0 == key), "no case for `{key}`");
    }
    assert_eq!(all.len(), CASES.len(), "a case for a key that is none");
    let data = Data::new();
    let mut before: BTreeMap<(&str, &str), String> = BTreeMap::new();
    for (key, value, area, other) in CASES.iter().copied() {
        let unchanged = before
            .entry((area, other))
            .or_insert_with(|| data.result(area, other));
        let changed = data.result(area, &with(other, key, value));
        assert!(*unchanged != changed, "`{key} = {value}` changes nothing");
    }
}

#[test]
fn prop_the_help_names_every_key() {
    let help = assert_cmd::Command::cargo_bin("touchdown")
        .unwrap()
        .args(["identify", "thrust", "--help"])
        .output()
        .unwrap();
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    for (key, ..) in CASES {
        let (section, name) = key.split_once('.').unwrap();
        assert!(
            help.contains(&format!("[{section}]")) && help.contains(name),
            "{key}: {help}"
        );
    }
}

#[test]
fn prop_unknown_keys_are_refused_by_name_in_every_section() {
    for section in [
        "smoothing",
        "choice",
        "sr3",
        "published",
        "weak",
        "shooting",
        "thrust",
        "ground_effect",
        "flight",
        "vehicle",
    ] {
        let text = format!("[{section}]\ncolour = 3\n");
        let error = parse::<IdentificationSettings>(&text, "s.toml")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("colour") && error.contains("s.toml") && error.contains("line 2"),
            "{section}: {error}"
        );
    }
}

#[test]
fn prop_values_out_of_range_are_refused_by_key() {
    for (text, key) in [
        ("[choice]\nfolds = 1\n", "choice.folds"),
        ("[choice]\nsolver = \"stepwise\"\n", "choice.criterion"),
        ("[choice]\neffective_rows = 0.0\n", "choice.effective_rows"),
        ("[sr3]\nlambda = -1.0\n", "sr3.lambda"),
        ("[sr3]\nnu = 0.0\n", "sr3.nu"),
        ("[sr3]\nthresholds = []\n", "sr3"),
        ("[published]\nnu = 0.0\n", "published.nu"),
        ("[published]\nthreshold = -0.1\n", "published.threshold"),
        ("[weak]\npower = 1\n", "weak"),
        ("[vehicle]\nrotors = 0\n", "vehicle.rotors"),
        (
            "[vehicle]\nmass_kg = 1.0\n[flight]\nmass_kg = 2.0\n",
            "vehicle.mass_kg",
        ),
        ("[flight]\nresamples = 20\n", "flight.resamples"),
        ("[weak]\nspacing = 9.0\n", "spacing"),
        ("[weak]\nhalf_width_s = -1.0\n", "half_width"),
    ] {
        let settings: IdentificationSettings = parse(text, "s.toml").unwrap();
        let error = settings.check("s.toml").unwrap_err().to_string();
        assert!(error.contains(key), "{text}: {error}");
    }
    let solver = parse::<IdentificationSettings>("[choice]\nsolver = \"magic\"\n", "s.toml");
    let error = solver.unwrap_err().to_string();
    assert!(
        error.contains("magic") && error.contains("best_subset"),
        "{error}"
    );
}
