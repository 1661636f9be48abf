//! Cards on trials: which rows count, and the warnings of trials that say little.

use touchdown_identify::rig::GroundTrial;
use touchdown_identify::validation::{FreeRun, judge_ground, judge_thrust};
use touchdown_model::Card;
use touchdown_trial::Trial;

/// A card of one lag, without any ground effect.
fn lag_card(tau_s: f64) -> Card {
    let term = |of: &str, expression: &str, value: f64, unit: &str| {
        format!(
            "[[terms]]\nof = \"{of}\"\nexpression = \"{expression}\"\nvalue = {value:?}\nunit = \"{unit}\"\n"
        )
    };
    let head = "schema = 1\nname = \"lag\"\nkind = \"ground_effect\"\nform = \"lag\"\nstatus = \"fitted\"\nequation = \"\"\n\
                [vehicle]\nname = \"\"\n[validity]\noutput = [-0.1, 0.6]\noutside = \"clamp\"\n[validity.inputs]\nz = [0.1, 1.0]\n\
                [constants]\nl1 = 0.08\nl2 = 0.2\nl3 = 0.45\n[definitions]\npsi1 = \"1/(1 + (z/l1)^2)\"\n\
                psi2 = \"1/(1 + (z/l2)^2)\"\npsi3 = \"1/(1 + (z/l3)^2)\"\n[provenance]\nsource = \"\"\n";
    let text = [
        head.to_string(),
        term("tau", "1", tau_s, "s"),
        term("h", "1", 0.0, "1"),
        term("h", "psi1", 0.0, "1"),
        term("h", "psi2", 0.0, "1"),
        term("h", "psi3", 0.0, "1"),
        term("k", "1", 0.0, "s/m"),
        term("k", "psi3", 0.0, "s/m"),
    ];
    Card::parse(&text.concat(), "lag.toml").unwrap()
}

/// A trial at a height of 0.3 m with 10 N of free-air thrust.
fn ground(time_s: Vec<f64>, force_n: Vec<f64>) -> GroundTrial {
    let all = |value: f64| vec![value; time_s.len()];
    GroundTrial {
        name: "t".into(),
        throttle: all(0.5),
        height_m: all(0.3),
        deck_velocity_mps: all(0.0),
        vehicle_velocity_mps: all(0.0),
        free_air_thrust_n: all(10.0),
        force_n,
        truth_n: None,
        time_s,
    }
}

fn judged(tau_s: f64, ground: &GroundTrial) -> touchdown_identify::Result<FreeRun> {
    let trial = Trial::new("t", ground.time_s.clone()).unwrap();
    judge_ground(&lag_card(tau_s), ground, &trial)
}

fn times(rows: u32) -> Vec<f64> {
    (0..rows).map(|i| 0.01 * f64::from(i)).collect()
}

#[test]
fn regress_a_run_that_is_no_number_is_infinitely_wrong() {
    let trial = ground(times(300), vec![1.0; 300]);
    // A lag of zero divides by it: all rows but the first are no number.
    let judged = judged(0.0, &trial).unwrap();
    assert_eq!(judged.measured.rmse, f64::INFINITY);
    assert!(
        judged.warnings.iter().any(|w| w == "the free run diverges"),
        "{:?}",
        judged.warnings
    );
}

#[test]
fn regress_the_row_that_a_run_starts_from_is_no_evidence() {
    let error = judged(0.15, &ground(times(1), vec![1.0]))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("after the first, which the free run starts from, found none"),
        "{error}"
    );
    let short = judged(0.15, &ground(times(20), vec![1.0; 20])).unwrap();
    assert_eq!(short.measured.samples, 19);
    assert!(
        short.warnings[0].contains("less than three times the lag of 0.150 s"),
        "{:?}",
        short.warnings
    );
    let long = judged(0.15, &ground(times(300), vec![1.0; 300])).unwrap();
    assert!(long.warnings.is_empty(), "{:?}", long.warnings);
}

#[test]
fn regress_a_free_run_starts_again_after_a_hole() {
    // 1 N before a hole of 20 s, 2 N after it. The lag is as long as the hole.
    let mut time_s = times(300);
    time_s.extend(times(300).iter().map(|t| t + 23.0));
    let force_n: Vec<f64> = (0..600).map(|i| if i < 300 { 1.0 } else { 2.0 }).collect();
    let judged = judged(20.0, &ground(time_s, force_n)).unwrap();
    // The start is the mean of the first 0.2 s: rounding.
    assert!(
        (judged.predicted_n[300] - 2.0).abs() < 1e-9,
        "{}",
        judged.predicted_n[300]
    );
    // Over 3 s the run decays by 3/20: at most 0.3 N. Through the hole it errs by 1.4 N.
    assert!(judged.measured.worst < 0.31, "{:?}", judged.measured);
    assert_eq!(judged.measured.samples, 598);
    assert!(
        judged
            .warnings
            .iter()
            .any(|w| w.starts_with("holes in the log: 1, the longest of 20.01 s")),
        "{:?}",
        judged.warnings
    );
}

#[test]
fn regress_thrust_of_another_unit_is_named() {
    let card = "schema = 1\nname = \"t\"\nkind = \"thrust\"\nform = \"static_thrust\"\nstatus = \"fitted\"\nequation = \"\"\n\
                [vehicle]\nname = \"\"\n[validity]\noutside = \"clamp\"\n[provenance]\nsource = \"\"\n\
                [[terms]]\nof = \"T\"\nexpression = \"s^2\"\nvalue = 40.0\nunit = \"N\"\n";
    let card = Card::parse(card, "t.toml").unwrap();
    let throttle: Vec<f64> = (0..200).map(|i| 0.3 + 0.002 * f64::from(i)).collect();
    let warnings = |change: fn(f64) -> f64| {
        let thrust = throttle.iter().map(|s| change(40.0 * s * s)).collect();
        let trial = Trial::new("t", times(200)).unwrap();
        let trial = trial.with_channel("throttle", throttle.clone()).unwrap();
        let trial = trial.with_channel("thrust_n", thrust).unwrap();
        judge_thrust(&card, &trial).unwrap().warnings
    };
    assert_eq!(warnings(|f| 0.9 * f), Vec::<String>::new());
    for (change, words) in [
        (
            (|f| f / 9.80665e-3) as fn(f64) -> f64,
            "'9.80665e-3 * \"thrust_n\"'",
        ),
        (|f| 1000.0 * f, "in millinewtons?"),
        (|f| -f, "Is the load cell inverted?"),
        (|f| 4.0 * f, "Is the thrust card that of one of 4 rotors?"),
    ] {
        let [warning] = &warnings(change)[..] else {
            panic!("one warning")
        };
        assert!(warning.contains(words), "{warning}");
    }
    let trial = ground(times(300), vec![-21.0; 300]);
    let warnings = judged(0.15, &trial).unwrap().warnings;
    assert!(
        warnings[0].contains("Is the load cell inverted?"),
        "{warnings:?}"
    );
}
