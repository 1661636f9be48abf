use std::f64::consts::TAU;
use std::fmt::Write;

use super::*;

/// What is said of a heave of 0.2 m and 4 s, recorded for 400 s at a rate, with noise.
fn warnings(rate_hz: f64, noise_m: f64, more: &str) -> Vec<String> {
    // The longer wave makes the rows fall on all phases of the shorter.
    warnings_of(rate_hz, noise_m, more, |t| {
        0.1 * (TAU * t / 4.0).sin() + 0.02 * (TAU * t / 5.3).sin()
    })
}

/// The same of any heave.
fn warnings_of(rate_hz: f64, noise_m: f64, more: &str, heave: impl Fn(f64) -> f64) -> Vec<String> {
    read(rate_hz, noise_m, more, "heave", heave)
        .unwrap()
        .warnings
}

/// A coordinate, recorded for 400 s at a rate, with noise.
fn read(
    rate_hz: f64,
    noise: f64,
    more: &str,
    axis: &str,
    value: impl Fn(f64) -> f64,
) -> Result<MeasuredDeck> {
    let folder = tempfile::tempdir().unwrap();
    let mut table = String::from("t,z\n");
    // 1 and -1 in an order that has no period.
    let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
    for i in 0..(400.0 * rate_hz) as u32 {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let noise = if bits >> 63 == 0 { noise } else { -noise };
        let t = f64::from(i) / rate_hz;
        let z = value(t) + noise;
        writeln!(table, "{t:.4},{z:.6}").unwrap();
    }
    std::fs::write(folder.path().join("z.csv"), table).unwrap();
    let settings = format!(
        "file = \"z.csv\"\n{more}[format]\ntime = [{{ column = \"t\", factor = 1.0 }}]\n\
         channels = [{{ axis = \"{axis}\", column = \"z\", factor = 1.0 }}]\nlongest_step_s = 2.0\n",
    );
    let settings: SeriesSettings = toml::from_str(&settings).unwrap();
    MeasuredDeck::read(&settings, folder.path())
}

#[test]
fn prop_short_waves_that_noise_hides_are_told() {
    // Beside a swell, a wind sea from 3 s down, whose spectrum decreases as f⁻⁵.
    let seas = |t: f64| {
        let tones = (0..30).map(|k| 0.33 * 1.05_f64.powi(k)).zip(0..);
        let wind: f64 = tones
            .map(|(hz, phase)| {
                (0.33_f64 / hz).powi(2) * (TAU * hz * t + f64::from(phase * phase)).sin()
            })
            .sum();
        0.25 * (TAU * t / 12.0).sin() + 0.012 * wind
    };
    let hidden = |noise_m: f64, more: &str| -> Vec<String> {
        let mut told = warnings_of(10.0, noise_m, more, seas);
        told.retain(|text| text.contains("hides"));
        told
    };
    assert_eq!(hidden(0.003, ""), [""; 0]);
    let [told] = &hidden(0.04, "")[..] else {
        panic!("expected one warning");
    };
    assert!(
        told.contains("noise of 0.04") && told.contains("short waves"),
        "{told}"
    );
    // Who says what to smooth knows.
    assert_eq!(hidden(0.04, "cutoff_hz = 1.0\n"), [""; 0]);
}

#[test]
fn prop_rows_far_apart_and_noise_above_the_waves_are_told() {
    assert_eq!(warnings(10.0, 0.003, ""), [""; 0]);
    let [told] = &warnings(1.3, 0.0, "")[..] else {
        panic!("expected one warning");
    };
    assert!(
        told.contains("5.2 rows in a mean period are too few"),
        "{told}"
    );
    // Who says what to smooth knows.
    assert_eq!(warnings(1.3, 0.0, "cutoff_hz = \"off\"\n"), [""; 0]);
    // A cutoff below the waves loses them, not the noise.
    let [told] = &warnings(10.0, 0.003, "cutoff_hz = 0.1\n")[..] else {
        panic!("expected one warning");
    };
    assert!(told.contains("Raise cutoff_hz"), "{told}");
    let [told] = &warnings(10.0, 0.1, "")[..] else {
        panic!("expected one warning");
    };
    assert!(
        told.contains("noise of 0.10") && told.contains("hides waves"),
        "{told}"
    );
}

#[test]
fn prop_a_deck_that_was_recorded_at_rest_has_neither_noise_nor_waves_to_lose() {
    // The mean of equal heights is rounded, and what it leaves of them must count as nothing.
    for height_m in [0.1, 0.3, 0.7, 1.1] {
        let [told] = &warnings_of(10.0, 0.0, "", |_| height_m)[..] else {
            panic!("expected one warning at {height_m} m");
        };
        assert!(told.contains("does not heave"), "{told}");
    }
    let told = warnings_of(10.0, 0.0, "", |t| 0.3 + 0.1 * (TAU * t / 4.0).sin());
    assert_eq!(told, [""; 0]);
}

#[test]
fn prop_a_mean_tilt_that_is_left_out_is_told() {
    let swing = |mean_rad: f64| move |t: f64| mean_rad + 0.02 * (TAU * t / 6.0).sin();
    for (axis, mean_rad, told) in [
        ("pitch", 0.3, "; mean pitch of 0.300 rad left out"),
        ("roll", -0.2, "; mean roll of -0.200 rad left out"),
    ] {
        let deck = read(5.0, 0.0, "", axis, swing(mean_rad)).unwrap();
        assert!(deck.text.ends_with(told), "{}", deck.text);
    }
    // Half a degree, and a height above any zero, are nobody's loss.
    for (axis, mean) in [("pitch", 0.009), ("heave", 1.0)] {
        let deck = read(5.0, 0.0, "", axis, swing(mean)).unwrap();
        assert!(!deck.text.contains("mean pitch"), "{}", deck.text);
    }
}

#[test]
fn regress_a_steady_drift_is_a_deck_at_rest_without_faults() {
    let deck = read(10.0, 0.0, "", "heave", |t| 0.02 * t).unwrap();
    assert_eq!(deck.warnings, [""; 0]);
    assert_eq!(deck.mean_period_s, None);
    let words = [
        "significant height 0.000 m, noise 0.0000 m",
        "not smoothed",
        "8.00 m from lowest to highest, left out",
    ];
    for word in words {
        assert!(deck.text.contains(word), "{word}: {}", deck.text);
    }
}

#[test]
fn prop_a_longest_period_below_that_of_the_waves_is_refused() {
    let waves = |t: f64| 0.1 * (TAU * t).sin();
    for (longest_s, refused) in [(0.1, true), (0.9, true), (1.1, false), (30.0, false)] {
        let more = format!("longest_period_s = {longest_s}\n");
        let deck = read(20.0, 0.0, &more, "heave", waves);
        let told = deck.err().map(|error| error.to_string());
        let words = format!(
            "mean period of the heave, 1.00 s, because slower heave is left out; found {longest_s}"
        );
        assert_eq!(
            told.is_some_and(|told| told.contains(&words)),
            refused,
            "{longest_s}"
        );
    }
}

#[test]
fn prop_a_cutoff_that_no_row_can_show_smooths_nothing() {
    // Rows at 10 Hz have motion up to 5 Hz.
    for (cutoff_hz, told) in [
        ("4.9", "smoothed at 4.90 Hz"),
        (
            "5.1",
            "not smoothed: cutoff_hz = 5.1 is above half of the rate of the rows, 5.00 Hz",
        ),
        (
            "100.0",
            "not smoothed: cutoff_hz = 100 is above half of the rate of the rows, 5.00 Hz",
        ),
        ("\"off\"", "; not smoothed"),
    ] {
        let more = format!("cutoff_hz = {cutoff_hz}\n");
        let waves = |t: f64| 0.1 * (TAU * t / 4.0).sin();
        let deck = read(10.0, 0.0, &more, "heave", waves).unwrap();
        assert!(deck.text.contains(told), "{}", deck.text);
    }
}
