//! Whole flights of the computer, compared with recorded ones: whatever changes a command, an
//! estimate or a phase shows here.

mod common;
#[allow(dead_code, reason = "other tests use the rest of the world")]
#[path = "onboard/world.rs"]
mod world;

use std::f64::consts::PI;

use touchdown_flight::Vector;
use touchdown_flight::method::Method;
use touchdown_flight::reference::{Exponential, Reference};
use touchdown_lander::computer::{Computer, ComputerOutput, Descent, NormalReading, Sensed};
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};
use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::{ControlSettings, LoopTiming, SensorNumbers, VehicleNumbers};
use touchdown_lander::state_machine::OperatorRequest;

use crate::common::deck::Sines;
use crate::common::flight::recorded::Means;
use crate::common::noise::Noise;
use crate::world::{DT, Rate, State, World, computer};

const COLUMNS: [&str; 37] = [
    "phase",
    "troubled",
    "go_arounds",
    "hurry",
    "rotors_on",
    "thrust_n",
    "throttle",
    "attitude_w",
    "attitude_x",
    "attitude_y",
    "attitude_z",
    "ground_effect_n",
    "limited",
    "x_m",
    "y_m",
    "z_m",
    "vx_mps",
    "vy_mps",
    "vz_mps",
    "deck_vz_mps",
    "bias_z_mps2",
    "sd_x_m",
    "sd_z_m",
    "sd_vz_mps",
    "diverged",
    "deck_m",
    "deck_mps",
    "deck_mps2",
    "deck_sd_mps",
    "planned",
    "latency_s",
    "target_m",
    "target_mps",
    "target_deck_mps2",
    "disturbance_x_n",
    "disturbance_z_n",
    "true_height_m",
];

fn figures(output: &ComputerOutput<f64>, world: &World) -> [f64; 37] {
    let is = |yes: bool| f64::from(u8::from(yes));
    let command = output.command.unwrap_or_default();
    let [w, x, y, z] = command.attitude.to_quaternion();
    let (estimate, deck) = (&output.estimate, &output.deck);
    let target = output.target;
    [
        f64::from(output.state_machine.phase as u8),
        is(output.state_machine.reason.is_some()),
        f64::from(output.state_machine.go_arounds),
        is(output.state_machine.hurry),
        is(output.command.is_some()),
        command.thrust_n,
        command.throttle,
        w,
        x,
        y,
        z,
        command.ground_effect_n,
        is(command.saturated || command.limited),
        estimate.position_m.x,
        estimate.position_m.y,
        estimate.position_m.z,
        estimate.velocity_mps.x,
        estimate.velocity_mps.y,
        estimate.velocity_mps.z,
        estimate.deck_velocity_mps.z,
        estimate.bias_mps2.z,
        estimate.position_sd_m.x,
        estimate.position_sd_m.z,
        estimate.relative_velocity_sd_mps.z,
        is(output.health.diverged),
        deck.displacement_m,
        deck.velocity_mps,
        deck.acceleration_mps2,
        deck.velocity_sd_mps.min(1e3),
        output.plan.map_or(0.0, |plan| plan.reference.duration_s),
        output.latency_s,
        target.map_or(0.0, |target| target.vertical.height_m),
        target.map_or(0.0, |target| target.vertical.velocity_mps),
        target.map_or(0.0, |target| target.deck_acceleration_mps2.z),
        output.disturbance_n.x,
        output.disturbance_n.z,
        world.height_m(),
    ]
}

/// A flight: what changes with time, and for how long.
struct Flight {
    computer: Computer<f64>,
    world: World,
    seconds: usize,
    /// Changes the world at a time.
    events: fn(f64, &mut World),
    /// Changes what is sensed at a time.
    faults: fn(f64, &mut Sensed<'_, f64>),
    /// Tilt of the deck as the camera sees it at a time, about two axes, rad.
    tilt: fn(f64) -> [f64; 2],
}

impl Flight {
    fn new(computer: Computer<f64>, heave: (f64, f64), seed: u64) -> Self {
        computer.validate().unwrap();
        let mut world = World::new(0.3);
        world.heave = heave;
        world.noise = Some(Noise::new(seed));
        world.position_m.x = 0.2;
        Self {
            computer,
            world,
            seconds: 20,
            events: |_, _| (),
            faults: |_, _| (),
            tilt: |t| [0.02 * (1.3 * t).sin(), 0.01 * (0.7 * t).cos()],
        }
    }

    /// Flies it, and compares it with the recorded one.
    fn compare(mut self, name: &str) {
        let mut means = Means::new(&COLUMNS, 200);
        let mut state: State = self.computer.initial(World::throttle());
        let camera = self.computer.relative.tag.attitude;
        for i in 0..100 * self.seconds {
            let t = DT * i as f64;
            (self.events)(t, &mut self.world);
            let (faults, tilt) = (self.faults, (self.tilt)(t));
            let output = self.world.step_with(&self.computer, &mut state, |sensed| {
                if i % 3 == 0 {
                    let normal = Vector::new(tilt[0], tilt[1], 1.0);
                    sensed.deck_normal = Some(NormalReading {
                        normal: camera.unrotate(normal),
                        age_s: 0.04,
                    });
                }
                faults(t, sensed);
            });
            means.add(&figures(&output, &self.world));
        }
        means.compare(env!("CARGO_MANIFEST_DIR"), name);
    }
}

/// The computer of the default settings, for the delays of [`World`], changed by `change`.
fn by_default(change: impl FnOnce(&mut ControlSettings<f64>)) -> Computer<f64> {
    let mut settings = ControlSettings::default();
    change(&mut settings);
    settings
        .computer(
            &FlightModels::default(),
            &VehicleNumbers::default(),
            &SensorNumbers {
                camera_position_m: Vector::ZERO,
                ..SensorNumbers::default()
            },
            &LoopTiming::default(),
            0.8,
        )
        .unwrap()
}

#[test]
fn regress_a_landing_on_a_deck_that_heaves() {
    Flight::new(computer(), (0.08, 2.5), 1).compare("heave");
}

#[test]
fn regress_a_landing_with_the_default_settings_and_a_latency_that_nobody_stamps() {
    let mut flight = Flight::new(by_default(|_| ()), (0.05, PI), 2);
    flight.world.range = Some(Rate { every: 2, age: 6 });
    flight.world.tag = Some(Rate { every: 3, age: 12 });
    flight.seconds = 40;
    // Ages are told 80 ms too short.
    flight.world.unstamped_s = 0.08;
    flight.compare("default_latency");
}

#[test]
fn regress_sensors_come_and_go() {
    let mut flight = Flight::new(computer(), (0.05, 2.0), 3);
    flight.seconds = 40;
    flight.world.barometer = Some(Rate { every: 5, age: 5 });
    flight.events = |t, world| {
        let at = |from: f64, to: f64| (from..to).contains(&t);
        world.tag = (!at(5.2, 6.9) && !at(20.0, 26.0)).then_some(Rate { every: 3, age: 4 });
        world.range = (!at(9.0, 9.6) && !at(22.0, 26.0)).then_some(Rate { every: 2, age: 2 });
        world.gnss = (!at(21.0, 26.0)).then_some(Rate { every: 10, age: 10 });
        // Climbs away from the first descent, and lands after the second loss.
        world.request = if at(4.5, 18.0) {
            OperatorRequest::Abort
        } else {
            OperatorRequest::None
        };
    };
    flight.compare("sensors_lost");
}

#[test]
fn regress_an_inertial_unit_without_numbers() {
    let mut flight = Flight::new(computer(), (0.05, 2.0), 4);
    flight.seconds = 40;
    flight.faults = |t, sensed| {
        if (4.0..4.3).contains(&t) || (9.0..10.2).contains(&t) {
            sensed.imu.specific_force_mps2.z = f64::NAN;
        }
        if (6.0..6.4).contains(&t) {
            sensed.readings = &[];
            sensed.deck_normal = None;
        }
    };
    flight.compare("imu_nan");
}

#[test]
fn regress_an_operator_who_changes_his_mind_and_a_battery_that_empties() {
    let mut flight = Flight::new(by_default(|_| ()), (0.1, 1.5), 5);
    flight.seconds = 50;
    flight.events = |t, world| {
        world.request = match t {
            t if (4.5..7.0).contains(&t) => OperatorRequest::Abort,
            t if (30.0..30.1).contains(&t) => OperatorRequest::Restart,
            t if (47.0..47.1).contains(&t) => OperatorRequest::Disarm,
            _ => OperatorRequest::None,
        };
        world.battery_share = 0.5 - 0.012 * t;
    };
    flight.compare("operator");
}

#[test]
fn regress_a_deck_that_is_too_fast_and_then_is_not() {
    let mut flight = Flight::new(
        by_default(|settings| {
            // A planner in a hurry, for a deck that may fall faster than it rises.
            settings.planning.cost_per_s = 0.4;
            settings.planning.quiescence.acceleration_max_mps2 = 0.7;
        }),
        (0.3, 2.5),
        6,
    );
    flight.seconds = 60;
    flight.events = |t, world| {
        if t > 30.0 {
            world.heave = (0.3 * (-(t - 30.0) / 4.0).exp(), 2.5);
        }
    };
    flight.tilt = |t| [0.1 * (0.8 * t).sin(), 0.0];
    flight.compare("fast_deck");
}

#[test]
fn regress_an_approach_from_afar_with_weak_rotors() {
    let mut flight = Flight::new(by_default(|_| ()), (0.05, 2.0), 7);
    flight.seconds = 30;
    // The force sideways is limited on the way, and the thrust when the rotors fade.
    flight.world.position_m.x = 3.0;
    flight.world.position_m.y = -2.0;
    flight.events = |t, world| {
        world.thrust_scale = if (9.0..11.0).contains(&t) { 0.6 } else { 1.0 };
    };
    flight.compare("afar");
}

#[test]
fn regress_every_method_and_straight_descents() {
    for (k, method) in Method::ALL.into_iter().enumerate() {
        let mut flight = Flight::new(
            by_default(|settings| {
                settings.method = method;
                settings.planner = k % 2 == 0;
                settings.adaptation = k % 3 == 2;
                settings.deck_acceleration = k % 4 != 3;
            }),
            (0.05, PI),
            10 + k as u64,
        );
        flight.world.thrust_scale = 0.95 + 0.02 * k as f64;
        flight.compare(&format!("method_{}", method.name().replace('+', "_")));
    }
    let mut flight = Flight::new(
        Computer {
            descent: Descent::Straight(Reference::Exponential(Exponential {
                c_per_s: 1.0,
                start_height_m: 0.8,
                end_height_m: 0.09,
            })),
            ..computer()
        },
        (0.03, 4.0),
        20,
    );
    // Readings that are late for guidance, too; an offset of the deck that is known well.
    flight.computer.guidance.sensing_s = 0.04;
    flight.computer.deck.offset_sd = 0.3;
    // Without satellites, and the legs tell of contact.
    flight.world.gnss = None;
    flight.events = |_, world| world.contact = Some(world.height_m() < 0.1);
    flight.compare("straight");
}

const DECK: [&str; 12] = [
    "count",
    "amplitude_m",
    "angular_frequency",
    "angular_frequency_sd",
    "forgetting",
    "now_m",
    "now_mps2",
    "now_sd_mps",
    "soon_m",
    "soon_mps",
    "soon_sd_m",
    "late_sd_mps2",
];

/// Runs a deck estimator on the first deck, and after half of the time on the second, and compares.
fn compare_estimator(name: &str, observed: Observed, decks: [&Sines; 2]) {
    let sd = match observed {
        Observed::Displacement => 0.005,
        Observed::Velocity => 0.03,
    };
    let estimator = DeckEstimator {
        offset_sd: 0.3,
        offset_rate_sd: 0.02,
        ..DeckEstimator::new(observed, sd)
    };
    let mut state = estimator.initial();
    let (mut noise, mut means) = (Noise::new(7), Means::new(&DECK, 400));
    for i in 0..8000 {
        let motion = decks[i / 4000].at(DT * i as f64);
        let reading = match observed {
            Observed::Displacement => 0.4 + motion[0],
            Observed::Velocity => 0.02 + motion[1],
        } + sd * noise.normal();
        // Gaps of half a second every ten.
        let seen = (i % 1000 < 950).then_some(reading);
        estimator.step(&mut state, seen, DT);
        let harmonics = || (0..state.count()).filter_map(|k| state.harmonic(k));
        let [now, soon, late] = [0.0, 0.7, 4.0].map(|ahead| estimator.predict(&state, ahead));
        means.add(&[
            state.count() as f64,
            harmonics().map(|one| one.amplitude_m).sum(),
            harmonics().map(|one| one.angular_frequency).sum(),
            harmonics().map(|one| one.angular_frequency_sd).sum(),
            state.forgetting_per_s(),
            now.displacement_m,
            now.acceleration_mps2,
            now.velocity_sd_mps.min(1e3),
            soon.displacement_m,
            soon.velocity_mps,
            soon.displacement_sd_m.min(1e3),
            late.acceleration_sd_mps2.min(1e3),
        ]);
    }
    means.compare(env!("CARGO_MANIFEST_DIR"), name);
}

#[test]
fn regress_the_deck_estimator_on_tones_and_seas_that_change() {
    let tones = Sines(vec![[0.1, 1.3, 0.2], [0.05, 2.1, 1.0], [0.03, 3.4, 2.0]]);
    let near = Sines(vec![[0.1, 1.3, 0.2], [0.08, 1.5, 0.5]]);
    let slow = Sines(vec![[0.2, 0.6, 0.0]]);
    let sea = Sines::jonswap(0.4, 5.0, 3);
    for (name, observed, decks) in [
        ("deck_tones", Observed::Displacement, [&tones, &slow]),
        ("deck_tones_velocity", Observed::Velocity, [&tones, &near]),
        ("deck_sea", Observed::Displacement, [&sea, &tones]),
        ("deck_sea_velocity", Observed::Velocity, [&near, &sea]),
    ] {
        compare_estimator(name, observed, decks);
    }
}
