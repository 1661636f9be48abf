//! Landings, decks and wind, compared with recorded ones: whatever changes the plant, its
//! sensors or the loop around the landing computer shows here.

#[allow(unreachable_pub, reason = "one helper for the tests of three crates")]
#[path = "../../flight/tests/common/recorded.rs"]
mod recorded;

use recorded::Means;
use touchdown_flight::method::Method;
use touchdown_flight::types::{Command, Measurement};
use touchdown_sim::air::wind::{DrydenSettings, GustSettings, Wind, WindSettings};
use touchdown_sim::body::plant::Plant;
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::deck::rigid::{Axis, RigidMotion, SeaSettings, Tone};
use touchdown_sim::landing::space::{Case, SpaceLander, SpaceScenario, TraceRow};
use touchdown_sim::landing::vertical::{LandingScenario, land};

const GRAVITY: f64 = 9.81;

const SPACE: [&str; 42] = [
    "x_m",
    "y_m",
    "z_m",
    "vx_mps",
    "vy_mps",
    "vz_mps",
    "q_w",
    "q_x",
    "q_y",
    "q_z",
    "rate_x",
    "rate_y",
    "rate_z",
    "rotor_1_n",
    "rotor_2_n",
    "rotor_3_n",
    "rotor_4_n",
    "ground_effect_n",
    "foot_1_n",
    "foot_2_n",
    "foot_3_n",
    "foot_4_n",
    "wind_x_mps",
    "wind_y_mps",
    "wind_z_mps",
    "throttle_1",
    "throttle_2",
    "throttle_3",
    "throttle_4",
    "deck_z_m",
    "deck_vz_mps",
    "normal_x",
    "estimated_x_m",
    "estimated_z_m",
    "estimated_vz_mps",
    "latency_s",
    "estimated_deck_mps",
    "forecast_deck_mps",
    "counted_n",
    "disturbance_n",
    "thrust_n",
    "phase",
];

fn figures(row: &TraceRow) -> Vec<f64> {
    [
        &row.position_m[..],
        &row.velocity_mps,
        &row.attitude,
        &row.rates,
        &row.rotor_n,
        &[row.ground_effect_n],
        &row.feet_n,
        &row.wind_mps,
        &row.throttle,
        &[
            row.deck_m[2],
            row.deck_mps[2],
            row.deck_normal[0],
            row.estimated_m[0],
            row.estimated_m[2],
            row.estimated_mps[2],
            row.estimated_latency_s,
            row.estimated_deck_mps,
            row.forecast_deck_mps,
            row.counted_ground_effect_n,
            row.disturbance_n[2],
            row.thrust_n.unwrap_or_default(),
            f64::from(row.phase as u8),
        ],
    ]
    .concat()
}

/// Lands once, and compares the means of every two seconds.
fn compare(scenario: &SpaceScenario, name: &str) {
    let lander = SpaceLander::new(scenario).unwrap();
    let landing = lander.land(1, 5, true).unwrap();
    let mut means = Means::new(&SPACE, 200);
    for row in &landing.trace.unwrap().rows {
        means.add(&figures(row));
    }
    means.compare(env!("CARGO_MANIFEST_DIR"), name);
}

#[test]
fn regress_every_case() {
    for case in Case::ALL {
        compare(&case.scenario(), &format!("case_{}", case.name()));
    }
}

/// Wind that blows and changes.
fn windy() -> WindSettings {
    WindSettings {
        steady_mps: [1.5, -1.0, 0.2],
        dryden: Some(DrydenSettings::low_altitude(3.0, 4.0).unwrap()),
        gust: Some(GustSettings {
            velocity_mps: [0.0, 2.0, -0.5],
            start_s: 4.0,
            rise_s: 0.4,
            hold_s: 0.5,
        }),
        airwake: None,
    }
}

/// A deck that surges, sways, heaves, rolls and pitches.
fn restless() -> RigidMotion {
    let tone = |axis, amplitude, frequency_hz, phase_rad| Tone {
        axis,
        amplitude,
        frequency_hz,
        phase_rad,
    };
    RigidMotion::Sines {
        tones: vec![
            tone(Axis::Heave, 0.1, 0.3, 0.2),
            tone(Axis::Heave, 0.03, 0.7, 1.1),
            tone(Axis::Roll, 0.04, 0.25, 0.4),
            tone(Axis::Pitch, 0.03, 0.2, 2.0),
            tone(Axis::Surge, 0.1, 0.1, 0.0),
            tone(Axis::Sway, 0.08, 0.15, 0.9),
        ],
    }
}

#[test]
fn regress_every_method_in_wind_above_a_restless_deck() {
    for (k, method) in Method::ALL.into_iter().enumerate() {
        let mut scenario = SpaceScenario {
            deck: restless(),
            wind: windy(),
            timeout_s: 30.0,
            ..SpaceScenario::default()
        };
        scenario.control.method = method;
        scenario.control.planner = k % 2 == 0;
        compare(
            &scenario,
            &format!("wind_{}", method.name().replace('+', "_")),
        );
    }
}

const VERTICAL: [&str; 8] = [
    "height_m",
    "relative_mps",
    "deck_m",
    "vehicle_m",
    "throttle",
    "ground_effect_n",
    "measured_m",
    "measured_mps2",
];

#[test]
fn regress_the_vertical_vehicle_on_every_deck() {
    let triangle = DeckMotion::Triangle {
        amplitude_m: 0.1,
        speed_mps: 0.08,
        phase_rad: 0.5,
    };
    let oscillating = LandingScenario::oscillating_deck();
    let decks = [
        ("still", DeckMotion::Still),
        ("sine", oscillating.deck),
        ("triangle", triangle),
    ];
    for (name, deck) in decks {
        let scenario = LandingScenario {
            deck,
            timeout_s: 12.0,
            ..LandingScenario::default()
        };
        let motor = *Plant::new(&scenario.plant).unwrap().motor();
        let weight_n = scenario.plant.weight_n();
        let mut seen = Vec::new();
        // Sinks at 0.12 m/s.
        let mut pilot = |m: &Measurement<f64>| {
            seen.push([m.height_m, m.acceleration_mps2]);
            let thrust_n = weight_n - 6.0 * (m.relative_velocity_mps + 0.12);
            Command {
                thrust_n,
                throttle: motor.throttle_for(thrust_n),
                ground_effect_n: 0.0,
            }
        };
        let trace = land(&scenario, 2, 9, &mut pilot, true)
            .unwrap()
            .trace
            .unwrap();
        let mut means = Means::new(&VERTICAL, 50);
        for (i, [height_m, acceleration_mps2]) in seen.into_iter().enumerate() {
            means.add(&[
                trace.height_m[i],
                trace.relative_velocity_mps[i],
                trace.deck_height_m[i],
                trace.vehicle_height_m[i],
                trace.throttle[i],
                trace.ground_effect_n[i],
                height_m,
                acceleration_mps2,
            ]);
        }
        means.compare(env!("CARGO_MANIFEST_DIR"), &format!("vertical_{name}"));
    }
}

const DECK: [&str; 24] = [
    "x_m",
    "y_m",
    "z_m",
    "vx_mps",
    "vy_mps",
    "vz_mps",
    "ax_mps2",
    "ay_mps2",
    "az_mps2",
    "forward_x",
    "forward_y",
    "forward_z",
    "port_x",
    "port_y",
    "port_z",
    "normal_x",
    "normal_y",
    "normal_z",
    "rate_x",
    "rate_y",
    "rate_z",
    "turn_x",
    "turn_y",
    "turn_z",
];

#[test]
fn regress_every_motion_of_a_deck() {
    let sea = SeaSettings::default();
    let quartering = SeaSettings {
        heading_rad: 0.8,
        ..sea
    };
    let triangle = RigidMotion::Triangle {
        amplitude_m: 0.2,
        speed_mps: 0.15,
        phase_rad: 0.3,
    };
    for (name, motion) in [
        ("sines", restless()),
        ("triangle", triangle),
        ("sea", RigidMotion::Sea(sea)),
        ("sea_quartering", RigidMotion::Sea(quartering)),
    ] {
        let deck = motion.build(GRAVITY, 3, 1).unwrap();
        let splined = deck.splined(0.0, 40.0, 0.05).unwrap();
        let mut means = Means::new(&DECK, 50);
        for i in 0..800 {
            let time_s = 0.05 * f64::from(i);
            // Half of the spans by the splines of a landing.
            let deck = if i % 100 < 50 { &deck } else { &splined };
            let pose = deck.at(time_s);
            let parts = [
                pose.origin_m,
                pose.velocity_mps,
                pose.acceleration_mps2,
                pose.axes[0],
                pose.axes[1],
                pose.axes[2],
                pose.angular_velocity,
                pose.angular_acceleration,
            ];
            means.add(&parts.concat());
        }
        means.compare(env!("CARGO_MANIFEST_DIR"), &format!("deck_{name}"));
    }
}

#[test]
fn regress_wind() {
    let mut wind = Wind::new(&windy(), 0.02, 4, 2).unwrap();
    let mut means = Means::new(&["x_mps", "y_mps", "z_mps"], 25);
    for _ in 0..500 {
        wind.step();
        means.add(&wind.velocity_mps());
    }
    means.compare(env!("CARGO_MANIFEST_DIR"), "wind");
}
