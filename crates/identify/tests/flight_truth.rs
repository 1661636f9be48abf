//! Ground effect from flights of independent vehicles whose truth is known, with noise of the height.

#[path = "flight_truth/late_sensors.rs"]
mod late_sensors;
#[path = "common/vertical.rs"]
mod vertical;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;
use touchdown_identify::estimate::Estimate;
use touchdown_identify::flights::{
    Basis, Flight, FlightSettings, ground_effect, ground_effect_by_routes,
};
use touchdown_identify::warning::Warning;
use touchdown_identify::{IdentificationSettings, Origin};
use touchdown_trial::Trial;
use vertical::found::{Cell, QUANTITIES, identify};
use vertical::{Law, Vehicle, fly};

/// Identifies one set of six flights; every quantity has to be found, climb damping and the lag of the motors only with an
/// accelerometer. Its interval stretched by half has to hold the truth.
fn holds(vehicle: &Vehicle, seed: u64) {
    let found = match identify(vehicle, seed, 6) {
        Cell::Found(found, _) => found,
        Cell::Refused(why) => panic!("{why}"),
    };
    // A latency of the accelerometer only where there is one.
    assert!(found[7].is_none(), "{:?}", found[7]);
    for ((name, truth), found) in QUANTITIES.iter().zip(vehicle.truth()).zip(*found) {
        if ["damping", "motor lag"].contains(name) && !vehicle.accelerometer {
            // Turbulence would pass for the one, the filter of heights for the other.
            assert!(found.is_none(), "{name}: {found:?}");
            continue;
        }
        let Some(found) = found else {
            panic!("{name}: not identified");
        };
        let half = 0.5 * (found.ci95[1] - found.ci95[0]);
        // One in 400 intervals of three standard errors misses by chance; the seeds are fixed.
        assert!(
            (found.value - truth).abs() < 1.5 * half,
            "{name}: {found:?}, truth {truth}"
        );
        // An interval as wide as the number would hold anything; a lag is known least.
        assert!(half < 0.7 * truth, "{name}: {found:?}");
    }
}

#[test]
fn analytic_noise_of_the_range_biases_no_number() {
    let vehicle = Vehicle {
        range_noise_m: 0.004,
        range_hz: 50.0,
        ..Vehicle::default()
    };
    holds(&vehicle, 71_000);
}

#[test]
fn analytic_a_deck_that_heaves_biases_no_number() {
    // The ground was taken to rest: innovations far from white, and a fit along measured heights with a warning.
    let vehicle = Vehicle {
        ground_mps: 0.05,
        ..Vehicle::default()
    };
    holds(&vehicle, 74_000);
    // An inertial climb rate that a filter smoothed contradicts the range over a deck, and its errors go on.
    let vehicle = Vehicle {
        filtered_climb: true,
        ground_period_s: 3.0,
        ..vehicle
    };
    holds(&vehicle, 74_100);
}

#[test]
fn analytic_without_accelerometer_the_motion_tells_lift_and_lag() {
    let vehicle = Vehicle {
        accelerometer: false,
        range_noise_m: 0.004,
        range_hz: 25.0,
        ..Vehicle::default()
    };
    holds(&vehicle, 72_000);
}

#[test]
fn regress_without_accelerometer_the_throttle_acts_as_it_was_logged() {
    // The filter followed the throttle that is smoothed over 0.1 s to either side for forces from heights. That smoothing is
    // no lag: the motors' came to its lower bound of 0.002 s with a dead time of 0.03 s, and the wake's took the rest.
    let vehicle = Vehicle {
        accelerometer: false,
        range_noise_m: 0.0005,
        range_hz: 50.0,
        ..Vehicle::default()
    };
    let settings = FlightSettings {
        rotor_radius_m: Some(vehicle.rotor_radius_m),
        ..FlightSettings::default()
    };
    let logs = (73_000..73_003).map(|seed| Flight::of(&fly(&vehicle, seed), &settings).unwrap());
    let found = ground_effect(&logs.collect::<Vec<_>>(), &settings).unwrap();
    let of = |name| found.fit.value(name).unwrap();
    // Standard error 1 ms; lag and dead time of rows 10 ms apart are confounded by another.
    assert!(
        (of("T_m") - vehicle.motor_lag_s).abs() < 0.004,
        "{}",
        of("T_m")
    );
    assert!(of("dead_time") < 0.004, "{}", of("dead_time"));
    // Without accelerometer lags are a tenth short, for a cause that is not known: that is a standard error beside the others.
    // Card, page and JSON have the same interval.
    let lag = found.lag_s().expect("a lag");
    let of_likelihood = found.spread.number(&found.fit, "tau").expect("a lag");
    let beside = of_likelihood.std_error.hypot(0.1 * lag.value);
    // Rounding only.
    assert!(
        (lag.std_error - beside).abs() < 1e-12,
        "{lag:?} {of_likelihood:?}"
    );
    let shown = found.numbers();
    let shown = shown.iter().find(|n| n.name == "lag").expect("the lag");
    assert_eq!(shown.estimate, lag);
}

/// Four flights of a vehicle that `flight_coverage` drew; returns it and the estimates.
fn drawn(
    seed: u64,
    accelerometer: bool,
    noise_m: f64,
    hz: f64,
) -> (Vehicle, [Option<Estimate>; 8]) {
    let mut random = Pcg64::seed_from_u64(seed);
    let vehicle = Vehicle::draw(&mut random, accelerometer, noise_m, hz);
    match identify(&vehicle, seed, 4) {
        Cell::Found(found, _) => (vehicle, *found),
        Cell::Refused(why) => panic!("{why}"),
    }
}

#[test]
fn regress_another_law_of_height_moves_no_number_out_of_its_interval() {
    let (vehicle, found) = drawn(3_340_004_000, true, 0.002, 50.0);
    assert_eq!(vehicle.law, Law::Image);
    let all = QUANTITIES.iter().zip(vehicle.truth()).zip(found);
    for ((name, truth), found) in all.filter(|((name, _), _)| **name != "damping") {
        let found = found.unwrap_or_else(|| panic!("{name}: not identified"));
        // Errors are 0.02 to 0.35 half widths. An exponential, which held-out flights do not tell from it, gave a lift at 2 R of
        // 0.0063 (0.0043 to 0.0083) for 0.0118 and a decay of 1.55 (1.33 to 1.77) for 0.89.
        assert!(
            found.ci95[0] < truth && truth < found.ci95[1],
            "{name}: {found:?}, truth {truth}"
        );
    }
}

#[test]
fn regress_a_step_that_a_bound_cuts_off_does_not_end_the_search() {
    // Without an accelerometer the lag of the motors comes to its lower bound. The search ended there, 166 units of
    // twice the log-likelihood above the minimum, with a lag of the wake of 0.418 s (0.248 to 0.587); the truth is 0.070 s.
    let (vehicle, found) = drawn(100_004_800, false, 0.0005, 25.0);
    // The likelihood gives 0.047 s with a standard error of 0.028 s: no number. Of another vehicle it has one.
    assert!(found[3].is_none(), "{:?}", found[3]);
    let (other, of_other) = drawn(110_804_800, false, 0.0005, 25.0);
    let lag = of_other[3].expect("a lag");
    let half = 0.5 * (lag.ci95[1] - lag.ci95[0]);
    // One in 400 intervals misses by 1.5 half widths by chance; the seed is fixed. It was 2.05 with the vehicle above.
    assert!((lag.value - other.wake_lag_s).abs() < 1.5 * half, "{lag:?}");
    // The lift at one radius is within its interval, which is at most a third of it.
    let (lift, truth) = (found[1].expect("a lift"), vehicle.truth()[1]);
    assert!(lift.ci95[0] < truth && truth < lift.ci95[1], "{lift:?}");
}

#[test]
fn prop_an_offset_of_the_height_moves_no_number() {
    // A marker 0.3 m above the feet: 2.5 rotor radii, so no logged height is near the ground.
    let vehicle = Vehicle::default();
    let lift = |shift_m: f64, height_offset_m: f64| {
        let settings = FlightSettings {
            rotor_radius_m: Some(vehicle.rotor_radius_m),
            height_offset_m,
            ..FlightSettings::default()
        };
        let flights: Vec<Flight> = (91_000..91_003)
            .map(|seed| {
                let mut trial = fly(&vehicle, seed);
                let height = trial.require("height_m").unwrap().to_vec();
                let height = height.iter().map(|z| z + shift_m).collect();
                trial.insert("height_m", height).unwrap();
                Flight::of(&trial, &settings).unwrap()
            })
            .collect();
        let found = ground_effect(&flights, &settings)?;
        Ok::<_, touchdown_identify::Error>(found.extra_lift([0.12; 2], [0.72; 2]).unwrap())
    };
    let refused = lift(0.3, 0.0).unwrap_err().to_string();
    assert!(refused.contains("flight below 0.240 m"), "{refused}");
    let (plain, shifted) = (lift(0.0, 0.0).unwrap(), lift(0.3, -0.3).unwrap());
    // Sums in another order: rounding of heights, amplified by the search that ends within a fiftieth of a likelihood's unit.
    assert!(
        (plain.value - shifted.value).abs() < 0.02 * plain.std_error,
        "{plain:?} {shifted:?}"
    );
}

/// A vehicle of 30 g that `flight_cases` drew, without accelerometer and with motion capture at 100 Hz.
fn small(seed: u64) -> Vehicle {
    Vehicle::draw_30_g(&mut Pcg64::seed_from_u64(seed), false)
}

/// Lifts at half, one and two radii and the wake's lag, which have to be within their intervals.
fn holds_lift_and_lag(vehicle: &Vehicle, seed: u64) {
    let found = match identify(vehicle, seed, 4) {
        Cell::Found(found, _) => found,
        Cell::Refused(why) => panic!("{why}"),
    };
    for ((name, truth), found) in QUANTITIES.iter().zip(vehicle.truth()).zip(*found).take(4) {
        let found = found.unwrap_or_else(|| panic!("{name}: not identified"));
        assert!(
            found.ci95[0] < truth && truth < found.ci95[1],
            "{name}: {found:?}, truth {truth}"
        );
    }
}

#[test]
fn regress_small_rotors_leave_the_covariance_a_covariance() {
    // Over small rotors a ground effect that follows late makes the motion unstable. Rounding made the covariance asymmetric, a
    // variance fell below zero after 50 s, and the fit along measured heights took over: no lag, and a lift 15 % low.
    let seed = 700_001_300;
    holds_lift_and_lag(&small(seed), seed);
}

#[test]
fn regress_rows_that_hold_older_heights_leave_lift_and_lag() {
    // A range of 40 Hz in rows of 50 Hz is up to 15 ms older than its row. Its innovations are not quite white, and the fit along
    // measured heights took over, whose lift at half a radius missed by two half widths.
    let seed = 700_001_100;
    let vehicle = Vehicle {
        log_hz: 50.0,
        range_hz: 40.0,
        ..Vehicle::draw(&mut Pcg64::seed_from_u64(seed), false, 0.002, 50.0)
    };
    holds_lift_and_lag(&vehicle, seed);
}

#[test]
fn regress_heights_of_a_filter_without_accelerometer_leave_hovers_at_rest() {
    // The autopilot's estimate: by its motion lifts were up to a third low, with half widths of a fifth.
    let vehicle = Vehicle {
        accelerometer: false,
        filtered_height: true,
        ..Vehicle::default()
    };
    let settings = FlightSettings {
        rotor_radius_m: Some(vehicle.rotor_radius_m),
        ..FlightSettings::default()
    };
    let trials: Vec<Trial> = (800_000_700..800_000_704)
        .map(|seed| fly(&vehicle, seed))
        .collect();
    let trials: Vec<&Trial> = trials.iter().collect();
    let found = ground_effect_by_routes(&trials, &settings, None).unwrap();
    assert!(
        matches!(found.found.basis, Basis::Hovers { .. }),
        "{:?}",
        found.found.basis
    );
    let by_poses = found.routes.iter().find(|r| r.basis == Basis::Poses);
    let why = by_poses.and_then(|r| r.refused.as_deref()).unwrap();
    assert!(why.contains("before any filter"), "{why}");
}

#[test]
fn regress_heights_of_a_filter_beside_an_accelerometer_come_with_a_warning() {
    // Of six such sets (`flight_cases`, `filtered`) three intervals of the climb damping held, and four of the lift at two radii.
    let warned = |filtered_height: bool| {
        let vehicle = Vehicle {
            filtered_height,
            ..Vehicle::default()
        };
        let settings = FlightSettings {
            rotor_radius_m: Some(vehicle.rotor_radius_m),
            ..FlightSettings::default()
        };
        let logs = (800_000_600..800_000_603).map(|s| Flight::of(&fly(&vehicle, s), &settings));
        let logs: Vec<Flight> = logs.map(Result::unwrap).collect();
        let found = ground_effect(&logs, &settings).unwrap();
        assert_eq!(found.basis, Basis::Accelerometer);
        let all = IdentificationSettings {
            flight: settings,
            ..IdentificationSettings::default()
        };
        let card = found.card(&all, &Origin::default());
        card.warnings
            .iter()
            .any(|w| w.to_string().contains("but of an estimate"))
    };
    assert_eq!([true, false].map(warned), [true, false]);
}

#[test]
fn prop_a_throttle_that_is_logged_less_often_than_the_acceleration_is_warned_of() {
    let of = |rows_a_throttle| Vehicle {
        rows_a_throttle,
        ..Vehicle::default()
    };
    let vehicle = of(1);
    let all = settings_of(&vehicle);
    let warned = |rows_a_throttle: usize| {
        let log = |seed| Flight::of(&fly(&of(rows_a_throttle), seed), &all.flight).unwrap();
        let logs: Vec<Flight> = (75_000..75_004).map(log).collect();
        let found = ground_effect(&logs, &all.flight).unwrap();
        let delay = found.delay_s().expect("a delay");
        let said = found.card(&all, &Origin::default()).warnings;
        let said = said.iter().find_map(|w| match w {
            Warning::ThrottleBetweenRows { period_s } => Some(*period_s),
            _ => None,
        });
        (delay, said)
    };
    let (delay, said) = warned(1);
    assert_eq!(said, None);
    // Three standard errors: the seeds are fixed.
    assert!((delay.value - vehicle.motor_lag_s).abs() < 3.0 * delay.std_error);
    // The commands of this vehicle change in every row: half of them are logged a row late. The dead time takes that up.
    let (late, said) = warned(2);
    let period_s = said.expect("a warning");
    // The stamps are whole rows: rounding only.
    assert!((period_s - 2.0 / vehicle.log_hz).abs() < 1e-9);
    // The warning says up to a third of the period; with this vehicle it is below a quarter.
    let short = vehicle.motor_lag_s - late.value;
    assert!(short > 0.0 && short < 0.25 * period_s, "{short}");
    assert!(late.ci95[1] > vehicle.motor_lag_s, "{late:?}");
}

#[test]
fn prop_a_ground_that_moves_without_a_lag_of_the_wake_is_warned_of() {
    // Of 5 ms nothing is seen in rows of 10 ms.
    let warned = |wake_lag_s: f64| {
        let vehicle = Vehicle {
            ground_mps: 0.05,
            wake_lag_s,
            ..Vehicle::default()
        };
        let settings = settings_of(&vehicle);
        let logs = flights(&vehicle, 78_000, |trial| trial, &settings.flight);
        let found = ground_effect(&logs, &settings.flight).unwrap();
        let said = found.card(&settings, &Origin::default()).warnings;
        let warned = said.contains(&Warning::MovingGroundWithoutLag);
        // Its sensors are punctual.
        assert_eq!(late_sensors::told(&said), [None; 2]);
        (found.lag_s().is_some(), warned)
    };
    assert_eq!(warned(0.005), (false, true));
    assert_eq!(warned(Vehicle::default().wake_lag_s), (true, false));
}

/// The settings that name a vehicle's rotor radius.
fn settings_of(vehicle: &Vehicle) -> IdentificationSettings {
    IdentificationSettings {
        flight: FlightSettings {
            rotor_radius_m: Some(vehicle.rotor_radius_m),
            ..FlightSettings::default()
        },
        ..IdentificationSettings::default()
    }
}

/// Three flights from a seed, through a change of each log.
fn flights(
    vehicle: &Vehicle,
    seed: u64,
    change: impl Fn(Trial) -> Trial,
    settings: &FlightSettings,
) -> Vec<Flight> {
    let logs = (seed..seed + 3).map(|s| Flight::of(&change(fly(vehicle, s)), settings));
    logs.map(Result::unwrap).collect()
}

#[test]
fn analytic_commands_that_act_before_they_are_logged_bias_no_lag() {
    // Rows in which an autopilot reports what it commanded before, as over telemetry; rows of 2 ms, averaged by fours; and rows of
    // 10 ms for five commands each. Dead times below zero were excluded: the motor lag was short by the age of the command, 5 ms, with half
    // widths of 0.5 to 1 ms, and the lag of the wake by up to two thirds.
    let late = Vehicle {
        throttle_late_s: 0.005,
        ..Vehicle::default()
    };
    let averaged = Vehicle {
        log_hz: 500.0,
        ..Vehicle::default()
    };
    let between = Vehicle {
        commands_a_row: 5,
        ..Vehicle::default()
    };
    for vehicle in [late, averaged, between] {
        let settings = settings_of(&vehicle).flight;
        let logs = flights(&vehicle, 76_000, |trial| trial, &settings);
        let found = ground_effect(&logs, &settings).unwrap();
        let numbers = found.numbers();
        let of = |name: &str| numbers.iter().find(|n| n.name == name).unwrap().estimate;
        let lags = [
            ("motor lag", of("T_m"), vehicle.motor_lag_s),
            ("wake lag", of("lag"), vehicle.wake_lag_s),
        ];
        for (name, lag, truth) in lags {
            let half = 0.5 * (lag.ci95[1] - lag.ci95[0]);
            // One in 400 intervals of three standard errors misses by chance; the seeds are fixed.
            assert!((lag.value - truth).abs() < 1.5 * half, "{name} {lag:?}");
        }
        // The vehicle has no dead time, and its delay is the lag alone: the interval has what the log does not tell.
        let (dead_time, delay) = (of("dead_time"), of("delay"));
        assert_eq!(dead_time.ci95[0], 0.0);
        assert!(dead_time.value < 1e-3, "{dead_time:?}");
        assert!(
            delay.ci95[0] < vehicle.motor_lag_s && vehicle.motor_lag_s < delay.ci95[1],
            "{delay:?}"
        );
        // Near zero a lag is not identifiable from a dead time: neither has a number, nor has their sum.
        let mut short = found.clone();
        let lag = short.fit.theta.iter_mut().find(|v| **v == of("T_m").value);
        *lag.unwrap() = 1e-3;
        let times = [short.motor_lag_s(), short.dead_time_s(), short.delay_s()];
        assert_eq!(times, [None; 3]);
    }
}

#[test]
fn analytic_a_log_that_is_later_than_its_period_has_no_dead_time() {
    let vehicle = Vehicle::default();
    let all = settings_of(&vehicle);
    // The clock of another computer: the throttle of so many rows of 10 ms before.
    for rows in [3, 8] {
        let late = |mut trial: Trial| {
            let throttle = trial.require("throttle").unwrap();
            let late = (0..throttle.len()).map(|i| throttle[i.saturating_sub(rows)]);
            let late = late.collect();
            trial.insert("throttle", late).unwrap();
            trial
        };
        let logs = flights(&vehicle, 77_000, late, &all.flight);
        let found = ground_effect(&logs, &all.flight).unwrap();
        assert!(found.dead_time_s().is_none() && found.delay_s().is_none());
        let motors = found.spread.number(&found.fit, "T_m").unwrap();
        // Three standard errors: the seeds are fixed.
        assert!(
            (motors.value - vehicle.motor_lag_s).abs() < 3.0 * motors.std_error,
            "{motors:?}"
        );
        let said = found.card(&all, &Origin::default()).warnings;
        let late_s = said.iter().find_map(|w| match w {
            Warning::ThrottleLoggedLate { late_s } => Some(*late_s),
            _ => None,
        });
        // Three standard errors of a dead time are 2 ms.
        assert!(
            late_s.is_some_and(|s| (s - 0.01 * rows as f64).abs() < 0.002),
            "{late_s:?}"
        );
    }
}
