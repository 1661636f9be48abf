//! Thrust from flights of a simulated vehicle: what is refused, what stays rising, and cards that read back.

use crate::common::{json, number};
use crate::flights;
use touchdown_identify::flights::{Flight, FlightSettings, ground_effect, thrust_alone};
use touchdown_sim::body::plant::GroundLaw;
use touchdown_trial::Trial;

/// Rotor radius (m) and mass (kg).
const R: f64 = 0.12;
const MASS_KG: f64 = 1.4;

fn settings() -> FlightSettings {
    FlightSettings {
        mass_kg: Some(MASS_KG),
        rotor_radius_m: Some(R),
        ..FlightSettings::default()
    }
}

/// Flights over ground that lifts by a share `amplitude` at height zero.
fn fly(count: u64, amplitude: f64) -> Vec<Trial> {
    let mut plant = flights::vehicle(MASS_KG, R, GroundLaw::Exponential, 0.05);
    plant.exponential.amplitude = amplitude;
    (0..count)
        .map(|k| flights::fly(&plant, k, 250.0, 250.0).trial)
        .collect()
}

fn flights_of(trials: &[Trial]) -> Vec<Flight> {
    trials
        .iter()
        .map(|t| Flight::of(t, &settings()).unwrap())
        .collect()
}

#[test]
fn regress_flights_with_and_without_accelerometer_do_not_mix() {
    let mut trials = fly(2, 0.18);
    let mut poses = Trial::new("poses", trials[1].time_s().to_vec()).unwrap();
    for (name, values) in trials[1].channels() {
        if name != "specific_force_mps2" {
            poses.insert(name, values.to_vec()).unwrap();
        }
    }
    trials[1] = poses;
    let mixed = flights_of(&trials);
    for found in [
        thrust_alone(&mixed, &settings()).map(|_| ()),
        ground_effect(&mixed, &settings()).map(|_| ()),
    ] {
        let error = found.unwrap_err();
        assert_eq!(error.exit_status(), 1);
        let text = error.to_string();
        assert!(text.contains("in all logs or in none"), "{text}");
    }
}

#[test]
fn regress_thrust_that_would_fall_with_throttle_takes_no_second_term() {
    let mut flown = flights_of(&fly(4, 0.18));
    for flight in &mut flown {
        let n = flight.throttle.len() as f64;
        let hover = flight.throttle.iter().sum::<f64>() / n;
        let step_s = flight.step_s();
        let mut late = 0.0;
        for (force, s) in flight.force.iter_mut().zip(&flight.throttle) {
            // Behind motors of 0.05 s, thrust loses so much above and below hover that it falls at the highest throttles.
            late += (s / hover - 1.0 - late) * step_s / 0.05;
            *force -= 4.0 * late * late;
        }
    }
    for found in [
        ground_effect(&flown, &settings()).unwrap(),
        thrust_alone(&flown, &settings()).unwrap(),
    ] {
        let tried: Vec<&str> = found.tried.iter().map(|c| c.name.as_str()).collect();
        let without = "without it: thrust would fall with throttle";
        assert!(tried.contains(&without), "{tried:?}");
        assert!(!found.fit.shape.curvature, "{tried:?}");
    }
}

#[test]
fn regress_cards_of_flights_without_rotor_radius_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    // Without a radius all flight counts as out of ground effect.
    for (k, trial) in fly(2, 0.001).iter().enumerate() {
        let log = folder.path().join(format!("{k}.csv"));
        touchdown_log::write_csv(trial, &log).unwrap();
    }
    std::fs::write(
        path("quad.toml"),
        format!("[flight]\nmass_kg = {MASS_KG}\n"),
    )
    .unwrap();
    let (logs, quad) = ([path("0.csv"), path("1.csv")], path("quad.toml"));
    let common = [
        "identify",
        "thrust",
        &logs[0],
        &logs[1],
        "--settings",
        &quad,
    ];
    let (card, out) = (path("together.toml"), path("apart"));
    let found = json(0, common.into_iter().chain(["--out", &card]));
    // One object with what both flights say.
    let runs = found["flight"]["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    assert!(runs.iter().all(|r| r["height_error_m"].is_null()));
    // The simulated vehicle hovers at 0.4869; the thrust of runs differs by 1 %, and turbulence adds to that over seconds.
    let hover = number(&runs[0]["hover"]["throttle"]);
    assert!((hover - 0.4869).abs() < 0.015, "{hover}");
    assert!(found["flight"]["extra_lift"].is_null());
    let all = json(0, common.into_iter().chain(["--out", &out]));
    for one in all.as_array().unwrap() {
        assert_eq!(one["flight"]["runs"].as_array().unwrap().len(), 1, "{one}");
    }
    let report = std::fs::read_to_string(path("apart/report.html")).unwrap();
    assert!(report.contains("Armed intervals"));
    for card in [card, path("apart/0.toml"), path("apart/1.toml")] {
        let text = std::fs::read_to_string(&card).unwrap();
        assert!(!text.contains("= nan"), "{text}");
        let card = touchdown_model::Card::read(card.as_ref()).unwrap();
        assert_eq!(card.vehicle.rotor_radius_m, None);
        assert_eq!(card.vehicle.mass_kg, Some(MASS_KG));
        card.thrust_model().unwrap();
    }
}
