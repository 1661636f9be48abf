//! The standard trials of the rig: what models are trained on and judged by.

use serde::{Deserialize, Serialize};

use crate::body::motor::Motor;
use crate::rig::RigTrial;
use crate::rig::profile::Profile;

/// How many of a set's trials to run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Extent {
    /// All trials.
    #[default]
    Full,
    /// A shorter list for a quick look; every kind of trial stays.
    Quick,
}

impl Extent {
    fn pick(self, values: &'static [f64], quick: &'static [f64]) -> &'static [f64] {
        match self {
            Self::Full => values,
            Self::Quick => quick,
        }
    }
}

/// Height of the plate where it stays in thrust trials, m.
pub const HOME_HEIGHT_M: f64 = 0.75;
/// Kinds of ground-effect validation: a trial's name is `kind-13N`.
pub const VALIDATION_KINDS: [&str; 5] = [
    "approach",
    "triangle_low",
    "triangle_mid",
    "sine",
    "fast_approach",
];
/// Free-air thrusts of the ground-effect validation, N.
pub const VALIDATION_THRUSTS_N: [f64; 7] = [10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0];

const THROTTLES: &[f64] = &[0.36, 0.42, 0.48, 0.54, 0.60];
const QUICK_THROTTLES: &[f64] = &[0.36, 0.48, 0.60];
const THROTTLE_FREQUENCIES: &[f64] = &[0.5, 1.2, 2.5];
const QUICK_THROTTLE_FREQUENCIES: &[f64] = &[1.2];
const STILL_HEIGHTS_M: &[f64] = &[0.10, 0.13, 0.17, 0.22, 0.30, 0.40, 0.55];
const QUICK_STILL_HEIGHTS_M: &[f64] = &[0.10, 0.22, 0.55];
/// Triangles of the plate between 0.10 m and these heights.
const TRIANGLES: [(&str, f64); 2] = [("low", 0.30), ("high", 0.55)];
const TRIANGLE_SPEED_MPS: f64 = 0.08;

fn constant(value: f64) -> Profile {
    Profile::Constant { value }
}

fn sine(mean: f64, amplitude: f64, angular_frequency: f64) -> Profile {
    Profile::Sine {
        mean,
        amplitude,
        angular_frequency,
        hold_s: 0.0,
        hold_value: None,
    }
}

fn move_to(from: f64, to: f64, rate: f64, hold_s: f64, back: bool) -> Profile {
    Profile::Ramp {
        from,
        to,
        rate,
        hold_s,
        back,
    }
}

fn triangle(low: f64, high: f64, speed: f64) -> Profile {
    Profile::Triangle { low, high, speed }
}

fn multi_sine(mean: f64, amplitude: f64) -> Profile {
    Profile::MultiSine {
        mean,
        amplitude,
        tones: 8,
        lowest: 0.6,
        highest: 7.0,
    }
}

fn trial(name: String, throttle: Profile, plate: Profile, duration_s: f64) -> RigTrial {
    RigTrial {
        name,
        throttle,
        plate,
        carriage: None,
        duration_s,
        plate_present: true,
        start_throttle: None,
    }
}

fn thrust_trial(name: String, throttle: Profile, duration_s: f64, plate: bool) -> RigTrial {
    RigTrial {
        plate_present: plate,
        ..trial(name, throttle, constant(HOME_HEIGHT_M), duration_s)
    }
}

/// Training of the thrust model: five ramps 0.2 to 0.8 and back, five sines
/// `0.5 + 0.3 sin(ω t)` of 30 s, with the plate at [`HOME_HEIGHT_M`] or removed.
#[must_use]
pub fn thrust_training(plate_present: bool, extent: Extent) -> Vec<RigTrial> {
    let slopes = extent.pick(&[0.02, 0.05, 0.1, 0.2, 0.4], &[0.05, 0.2]);
    let frequencies = extent.pick(&[0.5, 1.0, 2.0, 4.0, 8.0], &[1.0, 4.0]);
    let ramps = slopes.iter().map(|&slope| {
        // One second at the end shows the rest.
        let duration_s = 2.0 * 0.6 / slope + 1.0;
        let throttle = move_to(0.2, 0.8, slope, 0.0, true);
        thrust_trial(format!("ramp-{slope}"), throttle, duration_s, plate_present)
    });
    let sines = frequencies.iter().map(|&w| {
        let throttle = sine(0.5, 0.3, w);
        thrust_trial(format!("sine-{w}"), throttle, 30.0, plate_present)
    });
    ramps.chain(sines).collect()
}

/// Validation of the thrust model: `ramp` rests at 0.2 for 5 s and rises by
/// 0.06 1/s to 0.8; `sine` rests at 0.25 for 10 s and goes on as
/// `0.5 + 0.25 sin(0.8 (t - 10))`.
#[must_use]
pub fn thrust_validation(plate_present: bool) -> Vec<RigTrial> {
    let ramp = move_to(0.2, 0.8, 0.06, 5.0, false);
    let wave = Profile::Sine {
        mean: 0.5,
        amplitude: 0.25,
        angular_frequency: 0.8,
        hold_s: 10.0,
        hold_value: Some(0.25),
    };
    vec![
        thrust_trial("ramp".to_owned(), ramp, 20.0, plate_present),
        thrust_trial("sine".to_owned(), wave, 40.0, plate_present),
    ]
}

/// Ground-effect training in the manner of the published experiment: (1)
/// constant throttle above a plate that moves in triangles at 0.08 m/s, (2)
/// sines of the throttle above a still plate, (3) both.
#[must_use]
pub fn ground_effect_paper(extent: Extent) -> Vec<RigTrial> {
    let frequencies = extent.pick(THROTTLE_FREQUENCIES, QUICK_THROTTLE_FREQUENCIES);
    let mut trials = Vec::new();
    for &s in extent.pick(THROTTLES, QUICK_THROTTLES) {
        for (name, high) in TRIANGLES {
            let plate = triangle(0.10, high, TRIANGLE_SPEED_MPS);
            trials.push(trial(
                format!("constant-{s:.2}-{name}"),
                constant(s),
                plate,
                60.0,
            ));
        }
    }
    for &w in frequencies {
        for &height_m in extent.pick(STILL_HEIGHTS_M, QUICK_STILL_HEIGHTS_M) {
            let name = format!("sine-{w}-still-{height_m:.2}");
            trials.push(trial(name, sine(0.48, 0.12, w), constant(height_m), 30.0));
        }
    }
    for &w in frequencies {
        for (name, high) in TRIANGLES {
            let plate = triangle(0.10, high, TRIANGLE_SPEED_MPS);
            let name = format!("sine-{w}-{name}");
            trials.push(trial(name, sine(0.48, 0.12, w), plate, 60.0));
        }
    }
    trials
}

/// [`ground_effect_paper`] and more: multi-sines of the plate, which separate
/// the lag from the plate's velocity, and slow sweeps over all heights.
#[must_use]
pub fn ground_effect_rich(extent: Extent) -> Vec<RigTrial> {
    let mut trials = ground_effect_paper(extent);
    for &s in extent.pick(THROTTLES, QUICK_THROTTLES) {
        for mean in [0.25, 0.40] {
            let name = format!("multisine-{s:.2}-{mean:.2}");
            trials.push(trial(name, constant(s), multi_sine(mean, 0.15), 60.0));
        }
    }
    for &s in extent.pick(QUICK_THROTTLES, &[0.48]) {
        // Down from where landings start, and up again.
        let plate = move_to(0.85, 0.10, 0.02, 0.0, true);
        trials.push(trial(format!("sweep-{s:.2}"), constant(s), plate, 75.0));
    }
    trials
}

/// Vehicle and plate both in motion, so that the two velocities can be told
/// apart: multi-sines of plate and carriage (0.6 to 7 rad/s, phases of their own),
/// with constant throttle and with a sine of it, 30 s each.
#[must_use]
pub fn ground_effect_moving(extent: Extent) -> Vec<RigTrial> {
    let constants = extent.pick(THROTTLES, QUICK_THROTTLES).iter();
    let constants = constants.map(|&s| (format!("constant-{s:.2}"), constant(s)));
    let frequencies = extent.pick(THROTTLE_FREQUENCIES, QUICK_THROTTLE_FREQUENCIES);
    let sines = frequencies.iter();
    let sines = sines.map(|&w| (format!("sine-{w}"), sine(0.48, 0.12, w)));
    let mut trials = Vec::new();
    for (name, throttle) in constants.chain(sines) {
        for mean in [0.30, 0.45] {
            trials.push(RigTrial {
                carriage: Some(multi_sine(0.0, 0.08)),
                ..trial(
                    format!("moving-{name}-{mean:.2}"),
                    throttle,
                    multi_sine(mean, 0.12),
                    30.0,
                )
            });
        }
    }
    trials
}

/// As [`ground_effect_moving`], at throttles between those and never trained
/// on, 30 s each.
#[must_use]
pub fn ground_effect_moving_validation(extent: Extent) -> Vec<RigTrial> {
    let throttles = extent.pick(&[0.39, 0.45, 0.51, 0.57], &[0.39, 0.57]);
    let of = |&s: &f64| RigTrial {
        carriage: Some(multi_sine(0.0, 0.08)),
        ..trial(
            format!("moving-unseen-{s:.2}"),
            constant(s),
            multi_sine(0.35, 0.12),
            30.0,
        )
    };
    throttles.iter().map(of).collect()
}

/// Ground-effect validation, never trained on: the five
/// [`VALIDATION_KINDS`] at each of [`VALIDATION_THRUSTS_N`], 30 s each, at the
/// throttle at which `motor` rests at that thrust.
#[must_use]
pub fn ground_effect_validation(motor: &Motor, extent: Extent) -> Vec<RigTrial> {
    let thrusts_n = extent.pick(&VALIDATION_THRUSTS_N, &[10.0, 13.0, 16.0]);
    let mut trials = Vec::new();
    for (kind, plate) in VALIDATION_KINDS.into_iter().zip(validation_plates()) {
        for &thrust_n in thrusts_n {
            let throttle = constant(motor.throttle_for(thrust_n));
            let name = format!("{kind}-{thrust_n:.0}N");
            trials.push(trial(name, throttle, plate, 30.0));
        }
    }
    trials
}

/// The plate of each of [`VALIDATION_KINDS`], in their order.
fn validation_plates() -> [Profile; 5] {
    [
        move_to(0.75, 0.10, 0.65 / 30.0, 0.0, false),
        triangle(0.11, 0.29, 0.07),
        triangle(0.15, 0.25, 0.08),
        sine(0.2, 0.05, std::f64::consts::TAU * 0.5),
        move_to(0.5, 0.12, 0.2, 0.0, false),
    ]
}
