//! `touchdown validate` as a command, and the whole path from rig trials to judged models.

use crate::vertical;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::common::{
    LARGE_PAGE, data, fails, json, map, number, page, rotor_row, run, text, write_log,
};
use serde_json::Value;
use touchdown_model::Card;
use touchdown_sim::body::plant::{Plant, PlantSettings};
use touchdown_sim::rig::sets::{self, Extent};
use touchdown_sim::rig::{self, RigSettings, RigTrial};

const SEED: u64 = 7;

fn words(args: &[&str], paths: &[PathBuf]) -> Vec<OsString> {
    let args = args.iter().map(OsString::from);
    args.chain(paths.iter().map(OsString::from)).collect()
}

/// Runs trials on the virtual rig and writes them, one file each.
fn record(settings: &RigSettings, trials: &[RigTrial], folder: &Path) -> Vec<PathBuf> {
    std::fs::create_dir_all(folder).unwrap();
    let write = |trial: &RigTrial| {
        let path = folder.join(format!("{}.csv", trial.name));
        touchdown_log::write_csv(&rig::run(settings, trial, SEED).unwrap(), &path).unwrap();
        path
    };
    trials.iter().map(write).collect()
}

/// Trials of the virtual rig, written as logs.
struct Logs {
    thrust: Vec<PathBuf>,
    thrust_unseen: Vec<PathBuf>,
    ground: Vec<PathBuf>,
    ground_unseen: Vec<PathBuf>,
}

fn logs(plant: PlantSettings, folder: &Path) -> Logs {
    let settings = RigSettings {
        plant,
        ..RigSettings::default()
    };
    let motor = *Plant::new(&settings.plant).unwrap().motor();
    let quick = Extent::Quick;
    let unseen = sets::ground_effect_validation(&motor, quick);
    let at_13_n: Vec<RigTrial> = unseen
        .into_iter()
        .filter(|t| t.name.ends_with("13N"))
        .collect();
    let record = |trials: &[RigTrial], name: &str| record(&settings, trials, &folder.join(name));
    Logs {
        thrust: record(&sets::thrust_training(false, quick), "thrust"),
        thrust_unseen: record(&sets::thrust_validation(false), "thrust-unseen"),
        ground: record(&sets::ground_effect_rich(quick), "ground"),
        ground_unseen: record(&at_13_n, "ground-unseen"),
    }
}

/// From logs to judged models. Gives the judgement of the thrust card and of the ground-effect cards.
fn whole_path(plant: PlantSettings) -> (Value, Value) {
    let folder = tempfile::tempdir().unwrap();
    let logs = logs(plant, folder.path());
    let (thrust, models) = (
        folder.path().join("thrust.toml"),
        folder.path().join("models"),
    );
    let mut args = words(&["identify", "thrust", "--form", "library"], &logs.thrust);
    args.extend(words(&["--out"], std::slice::from_ref(&thrust)));
    let fitted = json(0, args);
    assert_eq!(fitted["form"], "library");

    let mut args = words(&["validate"], std::slice::from_ref(&thrust));
    args.extend(words(&[], &logs.thrust_unseen));
    args.extend(words(&[], &logs.thrust[..1]));
    let of_thrust = json(0, args);

    let doubt = "the curve is wrong by 0.1 N";
    let mut card = Card::read(&thrust).unwrap();
    card.warnings.push(doubt.into());
    card.write(&thrust).unwrap();
    let mut args = words(&["identify", "ground-effect"], &logs.ground);
    args.extend(words(&["--thrust"], std::slice::from_ref(&thrust)));
    args.extend(words(
        &["--form", "lag", "--form", "static", "--out"],
        std::slice::from_ref(&models),
    ));
    let fitted = json(0, args);
    assert_eq!(
        fitted.as_array().unwrap().len(),
        2,
        "a list where there are several forms"
    );
    assert!(number(&fitted[0]["lag_s"]) > 0.0 && fitted[1]["lag_s"].is_null());
    // What the thrust card warns of holds for the force that is found with it; the library of eq. (9) is that of no form here.
    let passed_on = format!("thrust card `{}`: {doubt}", card.name);
    for (index, form) in ["lag", "static"].into_iter().enumerate() {
        let told = fitted[index]["warnings"].to_string();
        assert!(told.contains(&passed_on), "{told}");
        assert!(!told.contains("library of eq. (9)"), "{told}");
        let card = Card::read(&models.join(format!("{form}.toml"))).unwrap();
        assert!(card.warnings.contains(&passed_on), "{:?}", card.warnings);
    }

    let judged = folder.path().join("judged");
    let mut args = words(
        &["validate"],
        &[models.join("lag.toml"), models.join("static.toml")],
    );
    args.extend(words(&[], &logs.ground_unseen));
    args.extend(words(&["--thrust"], std::slice::from_ref(&thrust)));
    args.extend(words(&["--out"], std::slice::from_ref(&judged)));
    let of_ground = json(0, args);
    for file in ["report.html", "results.json", "summary.csv"] {
        assert!(
            models.join(file).exists() && judged.join(file).exists(),
            "{file}"
        );
    }
    page(&models, LARGE_PAGE);
    let html = page(&judged, LARGE_PAGE);
    assert!(html.contains("predicts best: its mean absolute error in"));
    let written: Value =
        serde_json::from_str(&std::fs::read_to_string(judged.join("results.json")).unwrap())
            .unwrap();
    assert_eq!(written, of_ground, "what is printed is what is written");
    // A figure a log, as SVG and PNG.
    let pictures = std::fs::read_dir(judged.join("figures")).unwrap().count();
    assert_eq!(pictures, 2 * logs.ground_unseen.len());
    (of_thrust, of_ground)
}

fn pooled_truth(judged: &Value, form: &str) -> f64 {
    let all = judged["unseen"].as_array().unwrap();
    number(&all.iter().find(|p| p["form"] == form).unwrap()["truth"]["mae"])
}

#[test]
fn prop_the_whole_path_on_the_virtual_rig() {
    let (thrust, ground) = whole_path(PlantSettings::default());
    let rows = thrust["results"].as_array().unwrap();
    assert_eq!(
        rows.iter()
            .map(|r| r["seen"].as_bool().unwrap())
            .collect::<Vec<_>>(),
        [false, false, true]
    );
    assert_eq!(
        thrust["unseen"][0]["logs"], 2,
        "a log of the training is not unseen"
    );
    for row in rows {
        // The bar of the full trial set, 0.06 N; this is the quick one.
        assert!(number(&row["truth"]["mae"]) <= 0.06, "{row}");
        assert!(number(&row["noise_floor"]["mae"]) > 0.0, "{row}");
        // Noise can only hide the prediction's error in part: what is measured is no better than the noise alone.
        assert!(
            number(&row["measured"]["mae"]) > 0.9 * number(&row["noise_floor"]["mae"]),
            "{row}"
        );
    }
    // The bar of the full trial set, 0.03 N on each kind.
    assert!(
        pooled_truth(&ground, "lag") <= 0.03,
        "{}",
        pooled_truth(&ground, "lag")
    );
    assert!(
        ground["results"]
            .as_array()
            .unwrap()
            .iter()
            .all(|r| r["seen"] == false && r["unit"] == "N")
    );
}

#[test]
fn prop_the_whole_path_on_another_plant() {
    let (thrust, ground) = whole_path(PlantSettings::exponential());
    assert!(
        pooled_truth(&thrust, "library") <= 0.06,
        "{}",
        pooled_truth(&thrust, "library")
    );
    // Neither form holds this plant's law: within 0.06 N, where the force is 0.1 to 0.9 N.
    assert!(
        pooled_truth(&ground, "lag") <= 0.06,
        "{}",
        pooled_truth(&ground, "lag")
    );
}

#[test]
fn xval_a_flight_judges_the_card_of_another() {
    let Some(folder) = data("flight-crazyflie-1khz-throttle") else {
        return;
    };
    let temporary = tempfile::tempdir().unwrap();
    let card = temporary.path().join("lagged.toml");
    let map = map("flight-crazyflie-1khz-throttle.toml");
    let (fitted, unseen) = (folder.join("log10.csv"), folder.join("log15.csv"));
    // The reference values leave the dead time to the lag.
    let settings = temporary.path().join("none.toml");
    std::fs::write(&settings, "[thrust]\ndead_time = \"none\"\n").unwrap();
    let args = words(
        &["identify", "thrust", "--form", "lagged_motors"],
        &[
            fitted.clone(),
            "--settings".into(),
            settings,
            "--map".into(),
            map.clone(),
        ],
    );
    let own = json(
        0,
        [args, words(&["--out"], std::slice::from_ref(&card))].concat(),
    );
    let judged = json(
        0,
        words(&["validate"], &[card, fitted, unseen, "--map".into(), map]),
    );
    let [first, second] = &judged["results"].as_array().unwrap()[..] else {
        panic!("{judged}")
    };
    assert_eq!(
        (&first["seen"], &second["seen"]),
        (&true.into(), &false.into())
    );
    assert!(
        judged["warnings"][0]
            .as_str()
            .unwrap()
            .contains("are not those on unseen data")
    );
    // The same free run on the same rows as in the fit.
    let difference = number(&first["measured"]["rmse"]) - number(&own["rmse"]["value"]);
    assert!(difference.abs() < 1e-12, "{difference}");
    // Reference value 0.013372 N: fitted and evaluated in plain Python (exact answer of the lag to held commands, the
    // lag on a grid of 0.5 ms, which moves the figure by less than 1e-5 N).
    assert!(
        (number(&second["measured"]["rmse"]) - 0.013_372_4).abs() < 1e-5,
        "{second}"
    );
    assert!(
        first["truth"].is_null(),
        "nobody knows the truth of a flight"
    );
}

#[test]
fn prop_gaps_in_the_input_are_not_judged() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_log(&path("rotor.csv"), 3000, rotor_row);
    write_log(&path("gaps.csv"), 3000, |i| {
        let row = rotor_row(i);
        if i % 5 != 4 {
            return row;
        }
        let [t, _, thrust] = row.split(',').collect::<Vec<_>>()[..] else {
            unreachable!()
        };
        format!("{t},,{thrust}")
    });
    let args = words(&["identify", "thrust"], &[path("rotor.csv")]);
    assert!(
        run([args, words(&["--out"], &[path("card.toml")])].concat())
            .status
            .success()
    );
    let judged = json(
        0,
        words(
            &["validate"],
            &[path("card.toml"), path("gaps.csv"), path("rotor.csv")],
        ),
    );
    let [gaps, whole] = [0, 1].map(|i| &judged["results"][i]["measured"]);
    assert_eq!(
        (&gaps["samples"], &whole["samples"]),
        // The first row is what the run starts from.
        (&2399.into(), &2999.into())
    );
    // The run starts from the mean thrust of the first 0.1 s, in which it rises by 0.3 N; the error of half of that
    // decays with the lag of 0.1 s, in 0.3 % of the log.
    assert!(
        number(&whole["worst"]) < 0.2 && number(&whole["mae"]) < 1e-3,
        "{whole}"
    );
    // The throttle is smooth over a gap of one row: interpolation adds less than 0.1 mN.
    assert!(
        (number(&gaps["mae"]) - number(&whole["mae"])).abs() < 1e-4,
        "{judged}"
    );
    assert!(
        judged["warnings"][0]
            .as_str()
            .unwrap()
            .contains("600 of 3000 rows have a gap")
    );
}

#[test]
fn regress_a_card_that_export_refuses_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_log(&path("rotor.csv"), 3000, rotor_row);
    let mut args = words(&["identify", "thrust"], &[path("rotor.csv")]);
    args.extend(words(&["--out"], &[path("card.toml")]));
    json(0, args);
    let card = std::fs::read_to_string(path("card.toml")).unwrap();
    let diverged = card.replace("schema = 1", "schema = 1\ndiverged = true");
    std::fs::write(path("diverged.toml"), diverged).unwrap();
    let files = ["card.toml", "diverged.toml", "rotor.csv"].map(path);
    let judged = json(0, words(&["validate"], &files));
    let warnings: Vec<&str> = judged["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(Value::as_str)
        .filter(|w| w.contains("does not fly"))
        .collect();
    let [warning] = warnings[..] else {
        panic!("{judged}")
    };
    assert!(
        warning.contains("diverged.toml: does not fly")
            && warning.contains("its free run leaves the data"),
        "{warning}"
    );
}

#[test]
fn prop_bad_input_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_log(&path("log.csv"), 3000, rotor_row);
    write_log(&path("gaps.csv"), 300, |i| format!("{i},nan,1"));
    let args = words(&["identify", "thrust"], &[path("log.csv")]);
    assert!(
        run([args, words(&["--out"], &[path("card.toml")])].concat())
            .status
            .success()
    );
    let card = std::fs::read_to_string(path("card.toml")).unwrap();
    std::fs::write(
        path("schema.toml"),
        card.replace("schema = 1", "schema = 7"),
    )
    .unwrap();
    std::fs::write(path("key.toml"), format!("nonsense = 1\n{card}")).unwrap();
    std::fs::write(path("eq12.toml"), touchdown_model::published::EQ_12).unwrap();
    let validate = |files: &[&str]| {
        words(
            &["validate"],
            &files.iter().map(|f| path(f)).collect::<Vec<_>>(),
        )
    };
    for (status, files, what) in [
        (
            2,
            ["schema.toml", "log.csv"],
            "key `schema`: expected 1, found 7",
        ),
        (2, ["key.toml", "log.csv"], "nonsense"),
        (2, ["card.toml", "card.toml"], "expected a log"),
        (2, ["log.csv", "log.csv"], "expected a model card"),
        (2, ["eq12.toml", "log.csv"], "expected --thrust"),
        (2, ["none.toml", "log.csv"], "none.toml"),
        (1, ["card.toml", "none.csv"], "none.csv: cannot be read"),
        (1, ["card.toml", "gaps.csv"], "found none of 300"),
    ] {
        let error = fails(status, validate(&files));
        assert!(error.contains(what), "{files:?}: {error}");
    }
    // One that cannot be judged does not keep the others from it.
    let output = run(validate(&["card.toml", "gaps.csv", "log.csv"]));
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("not judged"));
    assert!(text(&output.stdout).contains("log.csv"));
}

/// Three flights of an independent vehicle, and a fourth whose heights read 0.03 m less; written as logs with a map.
fn flights(folder: &Path) -> (Vec<PathBuf>, PathBuf, PathBuf) {
    let vehicle = vertical::Vehicle::default();
    let write = |trial: &touchdown_trial::Trial, name: &str| {
        let path = folder.join(name);
        touchdown_log::write_csv(trial, &path).unwrap();
        path
    };
    let seen = (0..3).map(|k| {
        write(
            &vertical::fly(&vehicle, 81_000 + k),
            &format!("flight-{k}.csv"),
        )
    });
    let seen = seen.collect();
    let mut unseen = vertical::fly(&vehicle, 82_000);
    let low: Vec<f64> = unseen
        .require("height_m")
        .unwrap()
        .iter()
        .map(|z| z - 0.03)
        .collect();
    unseen.insert("height_m", low).unwrap();
    let map = folder.join("map.toml");
    let channels = ["time_s", "throttle", "specific_force_mps2", "height_m"];
    let channels: String = channels.iter().map(|c| format!("{c} = '{c}'\n")).collect();
    let text = format!(
        "schema = 1\n[channels]\n{channels}[vehicle]\nmass_kg = 1.4\nrotor_radius_m = 0.12\n"
    );
    std::fs::write(&map, text).unwrap();
    (seen, write(&unseen, "unseen.csv"), map)
}

#[test]
fn analytic_cards_are_judged_on_a_flight_with_another_scale_and_zero_of_height() {
    let folder = tempfile::tempdir().unwrap();
    let (seen, unseen, map) = flights(folder.path());
    let models = folder.path().join("models");
    let with_map = |mut args: Vec<OsString>| {
        args.extend(words(&["--map"], std::slice::from_ref(&map)));
        args
    };
    let mut args = with_map(words(&["identify", "ground-effect"], &seen));
    args.extend(words(&["--out"], std::slice::from_ref(&models)));
    json(0, args);
    let [thrust, ground] = ["thrust.toml", "ground-effect.toml"].map(|name| models.join(name));

    let out = folder.path().join("judged");
    let judge = |more: &[&str]| {
        let mut args = with_map(words(
            &["validate"],
            &[thrust.clone(), ground.clone(), unseen.clone()],
        ));
        args.extend(words(&["--thrust"], std::slice::from_ref(&thrust)));
        args.extend(words(more, &[]));
        json(0, args)["results"].clone()
    };
    let free = judge(&["--out", out.to_str().unwrap()]);
    let [of_thrust, of_ground] = [&free[0], &free[1]];
    assert_eq!(of_ground["seen"], false);
    // Noise of the accelerometer and turbulence make 1.4 kg times 0.17 m/s², of which 0.8 is the mean of amounts: 0.19 N.
    // A model that is off by a twentieth of the lift at the ground adds 0.03 N.
    for row in [of_thrust, of_ground] {
        assert!(number(&row["measured"]["mae"]) < 0.22, "{row}");
    }
    let factors = &of_ground["armed_intervals"][0];
    // Scales of flights differ by 1 % each: three standard deviations of two.
    assert!((number(&factors["scale"]) - 1.0).abs() < 0.045, "{factors}");
    // Three flights know the lift to some 7 %, as much as 10 mm of height where it falls by e in 0.144 m: two of these.
    let offset_m = number(&factors["height_offset_m"]);
    assert!((offset_m - 0.03).abs() < 0.02, "{factors}");
    assert_eq!(factors["scale_is_held"], false);
    assert!(of_thrust["armed_intervals"][0]["height_offset_m"].is_null());
    let report = page(&out, LARGE_PAGE);
    assert!(report.contains("of flights. The least square error gives thrust scale"));

    let held = &judge(&["--scale", "1", "--height-offset", "0"])[1];
    let factors = &held["armed_intervals"][0];
    assert_eq!(
        (&factors["scale"], &factors["height_offset_m"]),
        (&1.0.into(), &0.0.into())
    );
    assert_eq!(factors["height_offset_is_held"], true);
    let error = |row: &Value| number(&row["measured"]["rmse"]);
    assert!(error(held) > error(of_ground), "{held}");
}

#[test]
fn prop_a_flight_without_mass_or_height_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let (_, unseen, map) = flights(folder.path());
    let rig = logs(PlantSettings::default(), folder.path());
    let thrust = folder.path().join("thrust.toml");
    let mut args = words(
        &["identify", "thrust", "--form", "first_order"],
        &rig.thrust,
    );
    args.extend(words(&["--out"], std::slice::from_ref(&thrust)));
    json(0, args);
    let text = std::fs::read_to_string(&map).unwrap();
    std::fs::write(&map, text.replace("mass_kg = 1.4\n", "")).unwrap();
    let mut args = words(&["validate"], &[thrust, unseen]);
    args.extend(words(&["--map"], std::slice::from_ref(&map)));
    let error = fails(2, args);
    assert!(
        error.contains("expected `mass_kg` in the table [vehicle]"),
        "{error}"
    );
}
