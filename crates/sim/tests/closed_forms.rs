//! Closed forms of small parts of the plant: splines and windows of decks, speeds of rotors over a turning deck,
//! energy in the legs, rest of the plant.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use touchdown_sim::STEP_S;
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::contact::{ContactLog, ContactState, Foot, LegSettings, Legs};
use touchdown_sim::body::plant::{Plant, PlantSettings};
use touchdown_sim::body::rigid::{RigidState, RigidVehicle};
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::deck::rigid::{Axis, RigidDeck, RigidMotion, Tone};
use touchdown_sim::deck::series::{Channel, Column, MotionSeries, SeriesFormat};

fn format() -> SeriesFormat {
    SeriesFormat {
        time: vec![Column {
            column: "t".to_owned(),
            factor: 1.0,
        }],
        channels: vec![Channel {
            axis: Axis::Heave,
            column: "z".to_owned(),
            factor: 0.1,
        }],
        longest_step_s: 2.0,
        greatest_excursion_m: 15.0,
        greatest_angle_rad: 0.8,
    }
}

fn series(rows: &[(f64, f64)]) -> MotionSeries {
    let lines = rows.iter().map(|(t, z)| format!("{t}, {z}\n"));
    let table = "t, z\n".to_owned() + &lines.collect::<String>();
    MotionSeries::read_csv(table.as_bytes(), &format()).expect("a good table")
}

#[test]
fn analytic_a_series_is_a_natural_cubic_spline_without_mean() {
    let rows = [
        (3.0, 1.0),
        (3.4, 4.0),
        (4.5, -2.0),
        (4.8, 0.5),
        (6.1, 3.0),
        (6.5, 2.5),
    ];
    let series = series(&rows);
    assert_eq!(series.rows(), rows.len());
    let deck = series.deck();
    let mean_m = 0.1 * rows.iter().map(|r| r.1).sum::<f64>() / rows.len() as f64;
    let heave = |t: f64| {
        let at = deck.coordinates(t);
        (at.value[2], at.acceleration[2])
    };
    for (t, z) in rows {
        // Rounding of times and values of order 1.
        assert!((heave(t - 3.0).0 - (0.1 * z - mean_m)).abs() < 1e-13);
    }
    for pair in rows.windows(2) {
        let [a, b] = [pair[0].0 - 3.0, pair[1].0 - 3.0];
        let [start, end] = [heave(a).1, heave(b).1];
        for share in [0.25, 0.5, 0.75] {
            let linear = start + share * (end - start);
            // A cubic has a linear second derivative; accelerations are of order 10, so this is rounding.
            assert!((heave(a + share * (b - a)).1 - linear).abs() < 1e-11);
        }
    }
    for end_s in [0.0, 3.5] {
        assert!(heave(end_s).1.abs() < 1e-11, "natural at {end_s}");
    }
}

#[test]
fn analytic_limits_of_a_series_have_defaults() {
    let toml = "time = [{ column = 't', factor = 1.0 }]\nchannels = []\nlongest_step_s = 2.0";
    let format: SeriesFormat = toml::from_str(toml).expect("keys without limits");
    assert_eq!(
        (format.greatest_excursion_m, format.greatest_angle_rad),
        (15.0, 0.8)
    );
    // A column in SI units needs no factor.
    let short =
        "channels = [{ axis = \"heave\", column = \"z_m\" }]\ntime = [{ column = \"time_s\" }]\n";
    let short: SeriesFormat = toml::from_str(short).expect("keys without factors");
    assert_eq!(short, SeriesFormat::default());
    let all: SeriesFormat = toml::from_str("").expect("no key");
    let table = "z_m,time_s\n0.5,10.0\n1.5,11.0\n0.5,12.0\n1.5,13.0\n";
    let series = MotionSeries::read_csv(table.as_bytes(), &all).expect("the names of the defaults");
    // Half a metre about the mean, four standard deviations.
    assert_eq!(
        (series.duration_s(), series.significant_height_m()),
        (3.0, 2.0)
    );
}

#[test]
fn prop_a_column_that_stands_twice_is_refused_where_it_is_asked_for() {
    let read = |header: &str| {
        let table = format!("{header}\n0,1,2\n1,1,2\n2,1,3\n3,1,2\n");
        MotionSeries::read_csv(table.as_bytes(), &SeriesFormat::default())
    };
    for (header, column, places) in [
        ("time_s,z_m,z_m", "`z_m`", "columns 2 and 3"),
        ("time_s,# z_m,z_m", "`z_m`", "columns 2 and 3"),
        ("time_s,z_m,time_s", "`time_s`", "columns 1 and 3"),
    ] {
        let error = read(header).expect_err("twice").to_string();
        for word in [column, "one column of this name", places] {
            assert!(error.contains(word), "{word}: {error}");
        }
    }
    // Of columns that nobody asks for, as many as there are.
    let series = read("x,time_s,x").expect_err("no heave");
    assert!(
        series
            .to_string()
            .contains("a column of this name, found x, time_s, x")
    );
    let table = "time_s,x,z_m,x\n0,1,2,1\n1,1,3,1\n2,1,2,1\n3,1,3,1\n";
    MotionSeries::read_csv(table.as_bytes(), &SeriesFormat::default()).expect("one of each");
}

#[test]
fn analytic_equal_values_are_no_motion_to_scale() {
    // The sum of a hundred times 0.3, over a hundred, is another number.
    let rows: String = (0..100).map(|k| format!("{k},0.3\n")).collect();
    let table = format!("time_s,z_m\n{rows}");
    let series = MotionSeries::read_csv(table.as_bytes(), &SeriesFormat::default()).unwrap();
    assert_eq!(series.deck().coordinates(1.5).value, [0.0; 5]);
    let refused = series.scaled_to(0.5).expect_err("nothing to scale");
    assert!(
        refused.to_string().contains("significant height"),
        "{refused}"
    );
}

#[test]
fn prop_windows_lie_anywhere_within_the_series() {
    // The heave is 0.1 m/s times the time, so a window shows where it begins.
    let rows: Vec<(f64, f64)> = (0..=60).map(|t| (f64::from(t), f64::from(t))).collect();
    let series = series(&rows);
    let (duration_s, latest_s) = (10.0, 50.0);
    assert!(series.window(latest_s, duration_s).is_ok());
    assert!(series.window(latest_s + 0.1, duration_s).is_err());
    let start_s = |index: u64| {
        let window = series.random_window(duration_s, 1, index).expect("long");
        (window.deck().coordinates(0.0).value[2] + 3.0) / 0.1
    };
    let starts: Vec<f64> = (0..200).map(start_s).collect();
    let least = starts.iter().copied().fold(f64::MAX, f64::min);
    let most = starts.iter().copied().fold(f64::MIN, f64::max);
    // Of 200 uniform draws over 50 s, none in the first or last 5 s has the probability 0.9^200 = 7e-10.
    assert!((-1e-9..5.0).contains(&least), "{least}");
    assert!((45.0..50.0 + 1e-9).contains(&most), "{most}");
}

#[test]
fn analytic_sine_and_triangle_have_one_period_and_one_acceleration() {
    let sine = DeckMotion::Sine {
        amplitude_m: 0.05,
        frequency_hz: 0.5,
        phase_rad: 0.3,
    };
    assert_eq!(sine.angular_frequency(), Some(PI));
    for t in [0.0, 0.4, 1.1] {
        let expected = -PI * PI * 0.05 * (PI * t + 0.3).sin();
        // Rounding.
        assert!((sine.acceleration_mps2(t) - expected).abs() < 1e-14);
    }
    let triangle = DeckMotion::Triangle {
        amplitude_m: 0.05,
        speed_mps: 0.08,
        phase_rad: 0.3,
    };
    // Four amplitudes in a period.
    let period_s = 4.0 * 0.05 / 0.08;
    let omega = triangle.angular_frequency().expect("it moves");
    assert!((omega - TAU / period_s).abs() < 1e-14);
    assert!((triangle.at(0.7).height_m - triangle.at(0.7 + period_s).height_m).abs() < 1e-14);
    assert_eq!(DeckMotion::Still.angular_frequency(), None);
}

/// A deck that rolls, pitches and heaves.
fn turning() -> RigidDeck {
    let tone = |axis, amplitude, frequency_hz| Tone {
        axis,
        amplitude,
        frequency_hz,
        phase_rad: 0.4,
    };
    let tones = vec![
        tone(Axis::Heave, 0.2, 0.31),
        tone(Axis::Roll, 0.3, 0.27),
        tone(Axis::Pitch, 0.2, 0.41),
    ];
    let motion = RigidMotion::Sines { tones };
    motion.build(9.81, 0, 0).expect("valid motion")
}

#[test]
fn analytic_each_rotor_sees_the_deck_below_it_move() {
    let vehicle = RigidVehicle::new(&PlantSettings::default(), &BodySettings::default())
        .expect("valid settings");
    let state = RigidState {
        position_m: [0.3, -0.2, 0.8],
        ..RigidState::default()
    };
    for i in 0..50 {
        let deck = turning().at(0.1 * f64::from(i));
        for rotor in vehicle.places(&state, &deck, [0.0; 3]) {
            let [forward, port, _] = rotor.place_m;
            let below_m =
                std::array::from_fn(|k| forward * deck.axes[0][k] + port * deck.axes[1][k]);
            let velocity = deck.point_velocity(below_m);
            let expected: f64 = (0..3).map(|k| deck.axes[2][k] * velocity[k]).sum();
            // Rounding.
            assert!((rotor.deck_mps - expected).abs() < 1e-14);
        }
    }
}

#[test]
fn analytic_energy_of_pressed_and_dragged_feet() {
    let settings = LegSettings::default();
    let legs = Legs::new(&settings, &PlantSettings::default()).expect("valid legs");
    let foot = Foot {
        depth_m: 0.002,
        place_m: [0.10, 0.20],
        force_n: [0.0, 0.0, 4.0],
        slides: false,
    };
    let lifted = Foot {
        force_n: [0.0; 3],
        ..foot
    };
    let contact = ContactState {
        stuck_m: [Some([0.097, 0.204]), None, None, None],
    };
    let energy_j = legs.spring_energy_j(&[foot, foot, lifted, lifted], &contact);
    // Two legs pressed by 2 mm, one foot 3 mm and 4 mm from its anchor: 2 k δ²/2 + k_t (5 mm)²/2, rounding.
    let expected = 2_000.0 * 0.002 * 0.002 + 0.5 * 2_000.0 * 0.005 * 0.005;
    assert!((energy_j - expected).abs() < 1e-13, "{energy_j}");
}

#[test]
fn analytic_legs_in_the_air_hold_no_energy_and_touch_nothing() {
    let plant = PlantSettings::default();
    let bare = RigidVehicle::new(&plant, &BodySettings::default()).expect("valid settings");
    let legged = bare.clone().with_legs(&LegSettings::default(), &plant);
    let high = RigidState {
        position_m: [0.0, 0.0, 0.5],
        ..RigidState::default()
    };
    let deck = RigidDeck::Still.at(0.0);
    for vehicle in [bare, legged.expect("valid legs")] {
        assert_eq!(vehicle.spring_energy_j(&high, &deck), 0.0);
        let mut log = ContactLog::default();
        vehicle.log_contact(&mut log, STEP_S, &high, &deck);
        assert_eq!(log, ContactLog::default());
    }
    // A foot without force is not on the deck.
    let mut log = ContactLog::default();
    log.add(STEP_S, &[Foot::default(); 4], 0.1, &LegSettings::default());
    assert_eq!(log, ContactLog::default());
}

#[test]
fn analytic_the_plant_rests_where_it_is_at_rest() {
    let settings = PlantSettings::default();
    let plant = Plant::new(&settings).expect("defaults are valid");
    for (throttle, height_m) in [(0.3, 0.2), (0.5, 0.6)] {
        let rest = plant.rest(throttle, height_m);
        assert!(rest.root_thrust > 1.0, "{rest:?}");
        let rate = plant.derivative(&rest, throttle, height_m);
        // Rounding over the shortest lag of 0.03 s.
        assert!(rate.root_thrust.abs() < 1e-12, "{rate:?}");
        assert!(rate.inflow.iter().all(|q| q.abs() < 1e-12), "{rate:?}");
    }
}

#[test]
fn analytic_wrong_settings_of_the_plant_are_named() {
    let settings = PlantSettings {
        mass_kg: -FRAC_PI_2,
        ..PlantSettings::default()
    };
    assert!(PlantSettings::default().validate().is_ok());
    let error = settings.validate().expect_err("a mass below zero");
    assert!(error.to_string().contains("mass_kg"), "{error}");
}
