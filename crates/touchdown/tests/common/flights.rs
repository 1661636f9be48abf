//! Flights of a simulated vehicle near the ground, logged as an autopilot would: the truth behind them is known.
#![allow(dead_code, unreachable_pub)]

use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};
use touchdown_sim::air::exponential::ExponentialSettings;
use touchdown_sim::body::motor::MotorSettings;
use touchdown_sim::body::plant::{GroundLaw, Plant, PlantSettings, Surface};
use touchdown_sim::body::vertical::VerticalVehicle;
use touchdown_sim::deck::DeckPoint;
use touchdown_sim::sensors::FlightSensorSettings;
use touchdown_trial::Trial;

/// Step of the simulation (s).
const STEP_S: f64 = 0.001;
/// Age of every measurement (s).
const LATENCY_S: f64 = 0.02;

/// A vehicle scaled from the default one (1.37 kg, R = 0.12 m): the same hover throttle, damping by momentum theory.
pub fn vehicle(mass_kg: f64, rotor_radius_m: f64, law: GroundLaw, lag_s: f64) -> PlantSettings {
    let standard = PlantSettings::default();
    let weight = mass_kg * standard.gravity_mps2 / standard.weight_n();
    let size = rotor_radius_m / standard.rotor_radius_m;
    let induced = weight.sqrt() / size;
    PlantSettings {
        mass_kg,
        rotor_radius_m,
        rotor_spacing_m: standard.rotor_spacing_m * size,
        rotor_height_m: standard.rotor_height_m * size,
        surface: Surface::Ground,
        ground_law: law,
        climb_damping_ns_per_m: standard.climb_damping_ns_per_m * weight / induced,
        motor: MotorSettings {
            linear_loss: standard.motor.linear_loss / weight.sqrt(),
            quadratic_loss: standard.motor.quadratic_loss / weight,
            ..standard.motor
        },
        exponential: ExponentialSettings {
            amplitude: 0.18,
            decay_per_m: 0.6 / rotor_radius_m,
            lag_s,
        },
        // Air takes time with the root of length.
        rotor_lag_s: standard.rotor_lag_s * size.sqrt(),
        fountain_lag_s: standard.fountain_lag_s * size.sqrt(),
        ..standard
    }
}

/// The ratio of thrusts minus one at rest.
pub fn true_ratio(settings: &PlantSettings, height_m: f64) -> f64 {
    let plant = Plant::new(settings).expect("valid settings");
    plant.lift_ratio(plant.target(height_m))
}

/// What a flight was, and what was logged of it.
pub struct Flown {
    /// The log.
    pub trial: Trial,
    /// True height (m) and true ratio of thrusts minus one, every [`STEP_S`].
    pub truth: Vec<[f64; 2]>,
}

/// The single lag that tells best, by least squares, how the ratio of a plant follows its value at rest along the
/// flights (s): exact where the plant has one lag, and the best that one number can say where it has several.
pub fn true_lag_s(settings: &PlantSettings, flown: &[Flown]) -> f64 {
    let plant = Plant::new(settings).expect("valid settings");
    let at_rest: Vec<Vec<f64>> = flown
        .iter()
        .map(|f| {
            let of = |[z, _]: &[f64; 2]| plant.lift_ratio(plant.target(*z));
            f.truth.iter().map(of).collect()
        })
        .collect();
    let missed = |lag_s: f64| -> f64 {
        let keep = (-STEP_S / lag_s).exp();
        let of_one = |(f, rest): (&Flown, &Vec<f64>)| -> f64 {
            let mut g = rest[0];
            let each = f.truth.iter().zip(rest).map(|([_, ratio], h)| {
                let error = ratio - g;
                g = h + (g - h) * keep;
                error * error
            });
            each.sum()
        };
        flown.iter().zip(&at_rest).map(of_one).sum()
    };
    // Golden section in the logarithm; the sum of squares has one least value.
    let (mut lo, mut hi) = (0.005_f64.ln(), 2.0_f64.ln());
    while hi - lo > 1e-3 {
        let (a, b) = (lo + 0.382 * (hi - lo), lo + 0.618 * (hi - lo));
        if missed(a.exp()) < missed(b.exp()) {
            hi = b;
        } else {
            lo = a;
        }
    }
    (0.5 * (lo + hi)).exp()
}

/// One flight: hover well above, down in steps, bobbing near the ground, up again; sensor noise on.
pub fn fly(settings: &PlantSettings, seed: u64, rate_hz: f64, throttle_hz: f64) -> Flown {
    let mut random = Pcg64::seed_from_u64(seed);
    let uniform = |r: &mut Pcg64, lo: f64, hi: f64| {
        lo + (hi - lo) * (r.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    };
    let r_m = settings.rotor_radius_m;
    let noise = FlightSensorSettings::default();
    let thrust_error = 0.01 * normal(&mut random);
    let bias = noise.acceleration_bias_sd_mps2 * normal(&mut random);
    let plant = Plant::new(settings).expect("valid settings");
    let craft = VerticalVehicle::new(plant, settings.mass_kg, thrust_error);
    let still = DeckPoint::default();
    let (mut state, hover) = craft.balanced(6.0 * r_m, still);
    // Small vehicles are quicker: time goes with the root of length.
    let pace = (r_m / 0.12).sqrt().clamp(0.5, 1.2);
    // Heights in R with the time (s) at which each is reached; on a line in between.
    let mut course = vec![(0.0, 6.0), (4.0, 6.0)];
    let mut t = 4.0;
    for level in [
        3.0, 2.0, 1.2, 0.7, 0.4, 0.9, 0.45, 2.5, 0.5, 6.0, 6.0, 1.0, 0.45, 5.0,
    ] {
        let level = level * uniform(&mut random, 0.9, 1.1);
        t += pace * uniform(&mut random, 0.6, 1.5);
        course.push((t, level));
        t += uniform(&mut random, 1.0, 2.0);
        course.push((t, level));
    }
    let end_s = t + 2.0;
    let tones: Vec<[f64; 3]> = (0..3)
        .map(|_| {
            let rate = uniform(&mut random, 2.5, 7.0) / pace;
            [
                uniform(&mut random, 0.3, 0.6) / (rate * pace),
                rate,
                uniform(&mut random, 0.0, std::f64::consts::TAU),
            ]
        })
        .collect();
    let dither: Vec<[f64; 3]> = (0..4)
        .map(|_| {
            [
                0.02,
                uniform(&mut random, 15.0, 40.0),
                uniform(&mut random, 0.0, std::f64::consts::TAU),
            ]
        })
        .collect();
    let sum = |all: &[[f64; 3]], t: f64| -> f64 {
        all.iter().map(|[a, w, p]| a * (w * t + p).sin()).sum()
    };
    let wanted = |t: f64| {
        let k = course
            .partition_point(|c| c.0 <= t)
            .clamp(1, course.len() - 1);
        let ((a, from), (b, to)) = (course[k - 1], course[k]);
        let level = from + (to - from) * ((t - a) / (b - a)).clamp(0.0, 1.0);
        // Bobbing fades with the height that is left to bob in.
        r_m * (level + sum(&tones, t) * (level / 1.2).min(1.0)).max(0.33)
    };
    let mut turbulence = 0.0;
    let keep = (-STEP_S / settings.turbulence_correlation_s).exp();
    let (mut integral, mut command) = (0.0, hover);
    let (mut rows, mut written) = (0u64, 0u64);
    let mut truth = Vec::new();
    let mut log: [Vec<f64>; 5] = std::array::from_fn(|_| Vec::new());
    let mut held = hover;
    let steps = (end_s / STEP_S) as u64;
    // Throttle for an acceleration: thrust goes with the 1.3rd power of throttle in hover.
    let slope = hover / (1.3 * settings.gravity_mps2);
    for step in 0..steps {
        let t = step as f64 * STEP_S;
        truth.push([state.height_m, craft.plant().lift_ratio(state.plant.inflow)]);
        if step % 4 == 0 {
            let error = wanted(t) - state.height_m;
            let speed = (wanted(t + 0.02) - wanted(t - 0.02)) / 0.04 - state.velocity_mps;
            integral += 4.0 * STEP_S * error;
            let ahead = |dt: f64| wanted(t + 0.06 + dt);
            let push = (ahead(0.05) - 2.0 * ahead(0.0) + ahead(-0.05)) / 0.0025;
            let lift = push.clamp(-3.0, 3.0) + 30.0 * error + 8.0 * speed + 12.0 * integral;
            command = (hover + slope * lift + hover * sum(&dither, t)).clamp(0.1, 1.0);
        }
        let sd = plant.turbulence_sd_n(&state.plant, state.height_m);
        turbulence = turbulence * keep + sd * (1.0 - keep * keep).sqrt() * normal(&mut random);
        if t * throttle_hz >= written as f64 {
            held = command;
            written += 1;
        }
        if t * rate_hz >= rows as f64 {
            rows += 1;
            let lift = craft.acceleration_mps2(&state, still, turbulence) + settings.gravity_mps2;
            let measured = [
                t,
                held,
                lift + bias + noise.acceleration_sd_mps2 * normal(&mut random),
                state.height_m + noise.height_sd_m.min(0.03 * r_m) * normal(&mut random),
                state.velocity_mps + noise.vehicle_velocity_sd_mps * normal(&mut random),
            ];
            for (column, value) in log.iter_mut().zip(measured) {
                column.push(value);
            }
        }
        craft.step(&mut state, &[still; 3], command, turbulence, STEP_S);
        // The air takes heights below zero as zero; feet are not simulated.
    }
    let [time, throttle, force, height, climb] = log;
    // The throttle is known at once, all that is measured is late.
    let late = (LATENCY_S * rate_hz).round() as usize;
    let n = time.len() - late;
    let cut = |c: Vec<f64>| c[..n].to_vec();
    let trial = Trial::new(format!("flight-{seed}"), time[late..].to_vec())
        .and_then(|t| t.with_channel("throttle", throttle[late..].to_vec()))
        .and_then(|t| t.with_channel("specific_force_mps2", cut(force)))
        .and_then(|t| t.with_channel("height_m", cut(height)))
        .and_then(|t| t.with_channel("vehicle_velocity_mps", cut(climb)))
        .expect("columns of one length");
    Flown { trial, truth }
}

fn normal(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}
