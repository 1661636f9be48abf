//! Decks that move in five degrees of freedom: derivatives, seas, splines, series. The measured buoy is looked for
//! in the folder that `TOUCHDOWN_DATA` names, by default beside the workspace; its test says when it skips.
#![allow(clippy::print_stderr)]

use std::path::{Path, PathBuf};

use touchdown_sim::deck::DeckMotion;
use touchdown_sim::deck::rigid::{Axis, RigidDeck, RigidMotion, SeaSettings, Tone};
use touchdown_sim::deck::series::{Channel, Column, MotionSeries, SeriesFormat};
use touchdown_sim::deck::ship::ShipSettings;
use touchdown_sim::deck::wave::WaveSpectrum;

const G: f64 = 9.81;

fn sea() -> RigidMotion {
    RigidMotion::Sea(SeaSettings::default())
}

fn sines() -> RigidMotion {
    let tone = |axis, amplitude, frequency_hz, phase_rad| Tone {
        axis,
        amplitude,
        frequency_hz,
        phase_rad,
    };
    RigidMotion::Sines {
        tones: vec![
            tone(Axis::Surge, 0.10, 0.11, 0.1),
            tone(Axis::Sway, 0.08, 0.13, 0.7),
            tone(Axis::Heave, 0.05, 0.5, 0.3),
            tone(Axis::Heave, 0.02, 0.83, 2.0),
            tone(Axis::Roll, 0.30, 0.21, 1.1),
            tone(Axis::Pitch, 0.25, 0.17, 2.2),
        ],
    }
}

fn build(motion: &RigidMotion, seed: u64) -> RigidDeck {
    motion.build(G, seed, 0).expect("valid motion")
}

fn decks() -> Vec<RigidDeck> {
    let sea = build(&sea(), 1);
    let splined = sea.splined(0.0, 60.0, 0.1).expect("valid times");
    vec![build(&sines(), 1), sea, splined, series().deck()]
}

/// A made-up series: uneven steps, two channels in other units.
fn series() -> MotionSeries {
    let mut table = String::from("# minute, second, z (cm), roll (deg)\n");
    for i in 0..300 {
        let t = 0.2 * f64::from(i) + 0.01 * f64::from(i % 3);
        let (z, roll) = (30.0 * (0.9 * t).sin() + 12.0, 4.0 * (0.7 * t).cos());
        let minute = (t / 60.0).floor();
        table += &format!("{minute}, {:.3}, {z:.6}, {roll:.6}\n", t - 60.0 * minute);
    }
    MotionSeries::read_csv(table.as_bytes(), &format()).expect("a good table")
}

fn format() -> SeriesFormat {
    let time = |column: &str, factor| Column {
        column: column.to_owned(),
        factor,
    };
    let channel = |axis, column: &str, factor| Channel {
        axis,
        column: column.to_owned(),
        factor,
    };
    SeriesFormat {
        time: vec![time("minute", 60.0), time("second", 1.0)],
        channels: vec![
            channel(Axis::Heave, "z (cm)", 0.01),
            channel(Axis::Roll, "roll (deg)", 1.0_f64.to_radians()),
        ],
        longest_step_s: 0.5,
        greatest_excursion_m: 15.0,
        greatest_angle_rad: 0.8,
    }
}

#[test]
fn analytic_rates_and_accelerations_are_derivatives() {
    for deck in decks() {
        for i in 0..400 {
            let (t, h) = (1.0 + 0.1371 * f64::from(i), 1e-4);
            let (a, at, b) = (
                deck.coordinates(t - h),
                deck.coordinates(t),
                deck.coordinates(t + h),
            );
            for axis in 0..5 {
                // Central differences: h²/6 times third derivatives of order 1; at a knot of the
                // cubic spline the third derivative jumps (by less than 10): h²/12 and h/2 times that.
                let rate = (b.value[axis] - a.value[axis]) / (2.0 * h);
                assert!((rate - at.rate[axis]).abs() < 1e-7, "{axis} at {t}");
                let second = (b.rate[axis] - a.rate[axis]) / (2.0 * h);
                assert!(
                    (second - at.acceleration[axis]).abs() < 1e-3,
                    "{axis} at {t}"
                );
            }
        }
    }
}

#[test]
fn analytic_pose_is_a_rigid_motion() {
    for deck in decks() {
        for i in 0..200 {
            let (t, h) = (0.5 + 0.2713 * f64::from(i), 1e-4);
            let (a, at, b) = (deck.at(t - h), deck.at(t), deck.at(t + h));
            let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
            let arm = [0.4, -0.3, 0.2];
            let place = |p: &touchdown_sim::deck::rigid::DeckPose| -> [f64; 3] {
                std::array::from_fn(|k| {
                    p.origin_m[k] + (0..3).map(|j| arm[j] * p.axes[j][k]).sum::<f64>()
                })
            };
            let lever = std::array::from_fn(|k| place(&at)[k] - at.origin_m[k]);
            let velocity = at.point_velocity(lever);
            for k in 0..3 {
                for j in 0..3 {
                    let expected = f64::from(u8::from(j == k));
                    // Rounding only.
                    assert!((dot(at.axes[j], at.axes[k]) - expected).abs() < 1e-14);
                }
                // Central differences over 1e-4 s, as above.
                let moved = (place(&b)[k] - place(&a)[k]) / (2.0 * h);
                assert!((moved - velocity[k]).abs() < 1e-7);
                let spun = (b.angular_velocity[k] - a.angular_velocity[k]) / (2.0 * h);
                assert!((spun - at.angular_acceleration[k]).abs() < 1e-3);
            }
        }
    }
}

#[test]
fn analytic_small_roll_and_pitch_have_their_signs() {
    let tones = |axis| RigidMotion::Sines {
        tones: vec![Tone {
            axis,
            amplitude: 0.1,
            frequency_hz: 0.25,
            phase_rad: 0.0,
        }],
    };
    let quarter_s = 1.0; // the sine's crest
    let rolled = build(&tones(Axis::Roll), 0).at(quarter_s);
    // Roll: port side up, the normal leans to starboard.
    assert!(rolled.axes[1][2] > 0.09 && rolled.axes[2][1] < -0.09);
    let pitched = build(&tones(Axis::Pitch), 0).at(quarter_s);
    // Pitch: bow down, the normal leans forward.
    assert!(pitched.axes[0][2] < -0.09 && pitched.axes[2][0] > 0.09);
}

#[test]
fn analytic_sea_on_a_raft_has_the_spectrum_s_height() {
    // A raft much shorter than the waves follows the surface: its heave has their significant height.
    for spectrum in [
        WaveSpectrum::PiersonMoskowitz {
            significant_height_m: 0.5,
            peak_period_s: 9.0,
        },
        WaveSpectrum::Jonswap {
            significant_height_m: 0.5,
            peak_period_s: 9.0,
            peakedness: 3.3,
        },
    ] {
        let motion = RigidMotion::Sea(SeaSettings {
            spectrum,
            ship: ShipSettings {
                length_m: 0.3,
                beam_m: 0.3,
                draught_m: 0.05,
                roll_period_s: 0.3,
                deck_place_m: [0.0; 3],
                ..ShipSettings::default()
            },
            waves: 200,
            ..SeaSettings::default()
        });
        let deck = build(&motion, 3);
        let (mut sum, count) = (0.0, 40_000);
        for i in 0..count {
            sum += deck.coordinates(0.5 * f64::from(i)).value[2].powi(2);
        }
        let height_m = 4.0 * (sum / f64::from(count)).sqrt();
        // 20 000 s resolve lines 3e-4 rad/s apart, about the spacing of 200 waves: their cross
        // terms leave a per cent or two. The raft itself changes the shortest waves by as much.
        assert!((height_m / 0.5 - 1.0).abs() < 0.04, "{height_m}");
    }
}

#[test]
fn prop_seas_follow_seed_and_index() {
    let at = |seed, index| sea().build(G, seed, index).expect("valid").coordinates(3.0);
    assert_eq!(at(1, 0), at(1, 0));
    assert_ne!(at(1, 0), at(2, 0));
    assert_ne!(at(1, 0), at(1, 1));
}

#[test]
fn analytic_splines_meet_the_motion() {
    // What a spline of 0.1 s and of 0.05 s leaves of the default sea.
    let exact = build(&sea(), 1);
    let error = |step_s: f64| {
        let spline = exact.splined(0.0, 60.0, step_s).expect("valid times");
        exact.greatest_difference(&spline, 0.0, 60.0, 30_000)
    };
    let (coarse, fine) = (error(0.1), error(0.05));
    for axis in 0..5 {
        // Highest waves 6 × 1.26 rad/s: h⁶ w⁶/46080 of a few mm is 4e-8 m or less, in the
        // acceleration h⁴ w⁶/1920-like of 1e-4 m/s² or less.
        assert!(fine.value[axis] < 1e-9, "{fine:?}");
        assert!(
            coarse.value[axis] < 5e-8 && coarse.rate[axis] < 2e-6,
            "{coarse:?}"
        );
        assert!(coarse.acceleration[axis] < 1e-4, "{coarse:?}");
        // Orders six and four: 64 and 16, less the next order's share.
        assert!(
            coarse.value[axis] / fine.value[axis] > 40.0,
            "{coarse:?} {fine:?}"
        );
        let ratio = coarse.acceleration[axis] / fine.acceleration[axis];
        assert!((10.0..20.0).contains(&ratio), "{ratio}");
    }
}

#[test]
fn analytic_vertical_motions_are_special_cases() {
    let sine = DeckMotion::Sine {
        amplitude_m: 0.05,
        frequency_hz: 0.5,
        phase_rad: 0.3,
    };
    let triangle = DeckMotion::Triangle {
        amplitude_m: 0.05,
        speed_mps: 0.08,
        phase_rad: 0.3,
    };
    for motion in [DeckMotion::Still, sine, triangle] {
        let deck = build(&RigidMotion::from(motion), 0);
        for i in 0..100 {
            let t = 0.1 * f64::from(i);
            let (pose, point) = (deck.at(t), motion.at(t));
            // Rounding of sin(a + b) against sin a cos b + cos a sin b.
            assert!((pose.origin_m[2] - point.height_m).abs() < 1e-14);
            assert!((pose.velocity_mps[2] - point.velocity_mps).abs() < 1e-14);
            assert!((pose.acceleration_mps2[2] - motion.acceleration_mps2(t)).abs() < 1e-13);
            assert_eq!(pose.axes[2], [0.0, 0.0, 1.0]);
        }
    }
}

#[test]
fn analytic_series_is_met_at_its_rows_and_between_them() {
    let deck = series().deck();
    // The mean of the rows (which is removed) is not that of the sine: compare differences.
    let of = |t: f64| deck.coordinates(t).value;
    let (base, origin) = (of(10.0), 0.3 * 9.0_f64.sin());
    for i in 0..500 {
        let t = 5.0 + 0.1 * f64::from(i);
        let expected = base[2] + 0.3 * (0.9 * t).sin() - origin;
        // Cubic splines: (5/384) h⁴ |f⁗| = 0.013 × 0.22⁴ × 0.2 m.
        assert!((of(t)[2] - expected).abs() < 1e-5, "{t}");
    }
    assert!((series().significant_height_m() / (4.0 * 0.3 / 2.0_f64.sqrt()) - 1.0).abs() < 0.02);
    let scaled = series().scaled_to(0.1).expect("it heaves");
    assert!((scaled.significant_height_m() - 0.1).abs() < 1e-12);
    let window = series().window(20.0, 10.0).expect("inside").deck();
    // Natural ends: away from them the window is the whole.
    let (a, b) = (window.coordinates(5.0).value[2], of(25.0)[2]);
    assert!((a - b).abs() < 1e-6, "{a} {b}");
}

#[test]
fn prop_bad_series_name_key_row_and_value() {
    let read = |table: &str, format: &SeriesFormat| {
        MotionSeries::read_csv(table.as_bytes(), format)
            .expect_err("a bad table")
            .to_string()
    };
    let head = "minute,second,z (cm),roll (deg)\n";
    let rows = "0,0.0,1,0\n0,0.2,2,0\n0,0.4,1,0\n0,0.6,0,0\n";
    let gap = read(&format!("{head}{rows}0,2.0,1,0\n"), &format());
    assert!(gap.contains("row 5") && gap.contains("time"), "{gap}");
    let word = read(&format!("{head}{rows}0,0.8,high,0\n"), &format());
    assert!(
        word.contains("row 5") && word.contains("found high"),
        "{word}"
    );
    let none = read(&format!("minute,second,z\n{rows}"), &format());
    assert!(
        none.contains("z (cm)") && none.contains("minute, second, z"),
        "{none}"
    );
    let mut degrees = format();
    degrees.channels[1].factor = 1.0;
    let unit = read(&format!("{head}{rows}0,0.8,1,5\n"), &degrees);
    assert!(unit.contains("roll") && unit.contains("rad"), "{unit}");
    let short = read(&format!("{head}0,0.0,1,0\n"), &format());
    assert!(short.contains("at least 4 rows"), "{short}");
    let window = series().window(55.0, 10.0).expect_err("beyond").to_string();
    assert!(
        window.contains("start_s") && window.contains("55"),
        "{window}"
    );
}

#[test]
fn prop_motions_survive_text_and_bad_ones_are_named() {
    for motion in [RigidMotion::Still {}, sines(), sea()] {
        let text = toml::to_string(&motion).expect("settings are text");
        assert_eq!(
            toml::from_str::<RigidMotion>(&text).expect("read back"),
            motion
        );
    }
    let unknown = toml::from_str::<RigidMotion>("kind = \"sea\"\nwave = 3");
    assert!(unknown.is_err());
    let bad = RigidMotion::Sea(SeaSettings {
        waves: 0,
        ..SeaSettings::default()
    });
    let message = bad.validate().expect_err("no waves").to_string();
    assert!(
        message.contains("waves") && message.contains("found 0"),
        "{message}"
    );
    let bad = RigidMotion::Sea(SeaSettings {
        spectrum: WaveSpectrum::PiersonMoskowitz {
            significant_height_m: 0.5,
            peak_period_s: 0.0,
        },
        ..SeaSettings::default()
    });
    let message = bad.validate().expect_err("no period").to_string();
    assert!(message.contains("spectrum.peak_period_s"), "{message}");
}

fn buoy() -> Option<PathBuf> {
    let folder = std::env::var_os("TOUCHDOWN_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = folder.join("waves-spotter-buoy/displacement.csv");
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no data at {}", path.display());
    None
}

#[test]
fn xval_measured_buoy() {
    let Some(path) = buoy() else { return };
    let file = std::fs::File::open(path).expect("a readable file");
    let time = |column: &str, factor| Column {
        column: column.to_owned(),
        factor,
    };
    let channel = |axis, column: &str| Channel {
        axis,
        column: column.to_owned(),
        factor: 1.0,
    };
    let format = SeriesFormat {
        time: vec![
            time("hour", 3600.0),
            time("min", 60.0),
            time("sec", 1.0),
            time("msec", 1e-3),
        ],
        channels: vec![
            channel(Axis::Surge, "x (m)"),
            channel(Axis::Sway, "y(m)"),
            channel(Axis::Heave, "z(m)"),
        ],
        longest_step_s: 0.41,
        greatest_excursion_m: 15.0,
        greatest_angle_rad: 0.8,
    };
    let series = MotionSeries::read_csv(file, &format).expect("the buoy's table");
    assert_eq!(series.rows(), 54_000);
    assert!((series.duration_s() - 21_599.6).abs() < 0.01);
    // Python's csv module: 4 standard deviations of z over the rows from the last at or before the
    // start to the first at or after the end.
    for (start_s, height_m) in [
        (0.0, 3.118_057_445_205_37),
        (7_200.0, 2.546_180_429_891_982),
        (19_799.0, 3.749_766_241_910_56),
    ] {
        let window = series.window(start_s, 1_800.0).expect("inside");
        let found = window.significant_height_m();
        // Sums of 4500 numbers in another order, after a mean is taken off: rounding.
        assert!((found - height_m).abs() < 1e-10, "{start_s}: {found}");
    }
    // On a laboratory's scale; the burst of errors of 12:17 is not in this window.
    let scaled = series.scaled_to(0.5).expect("it heaves");
    let window = scaled.random_window(60.0, 1, 0).expect("long enough");
    let deck = window.deck();
    for i in 0..600 {
        let at = deck.coordinates(0.1 * f64::from(i));
        // H_s bounds the excursions; waves of 2 s and longer, their accelerations.
        assert!(at.value[2].abs() < 0.5, "{at:?}");
        assert!(at.acceleration[2].abs() < 3.0, "{at:?}");
    }
}
