//! Cards on trials: what counts, and what is told of a trial that cannot be judged as it is.

use touchdown_identify::rig::GroundTrial;
use touchdown_identify::validation::{FreeRun, judge_ground};
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
