//! Wind: its spectra, its seed, its gust.

use touchdown_sim::air::wind::{DrydenSettings, GustSettings, Wind, WindSettings};

const DRYDEN: DrydenSettings = DrydenSettings {
    intensity_mps: [1.0, 0.8, 0.5],
    length_m: [4.0, 4.0, 2.0],
    passing_mps: 4.0,
};

fn settings() -> WindSettings {
    WindSettings {
        steady_mps: [0.0, 4.0, 0.0],
        dryden: Some(DRYDEN),
        gust: None,
        airwake: None,
    }
}

#[test]
fn analytic_dryden_has_its_variances_and_correlations() {
    for step_s in [0.01, 0.1] {
        let mut wind = Wind::new(&settings(), step_s, 2, 0).expect("valid settings");
        let count = 2_000_000;
        let values: Vec<[f64; 3]> = (0..count)
            .map(|_| {
                wind.step();
                let [x, y, z] = wind.velocity_mps();
                // The steady wind blows along y: along is y, across is -x.
                [y - 4.0, -x, z]
            })
            .collect();
        for (k, (sd, time_s)) in [(1.0, 1.0), (0.8, 1.0), (0.5, 0.5_f64)]
            .into_iter()
            .enumerate()
        {
            let covariance = |lag: usize| {
                let pairs = values.iter().zip(&values[lag..]);
                pairs.map(|(a, b)| a[k] * b[k]).sum::<f64>() / (count - lag) as f64
            };
            // 20 000 s and more hold 10 000 independent values of 2τ: 1.4 %; 4 of these.
            assert!((covariance(0) / (sd * sd) - 1.0).abs() < 0.06, "{k}");
            let lag = (time_s / step_s).round() as usize;
            // e^(-t/τ) along; e^(-t/τ) (1 - t/(2τ)) across; at t = τ.
            let expected = (-1.0_f64).exp() * if k == 0 { 1.0 } else { 0.5 };
            assert!((covariance(lag) / (sd * sd) - expected).abs() < 0.06, "{k}");
        }
    }
}

#[test]
fn analytic_low_altitude_lengths_and_intensities() {
    // h = 100 ft: 0.177 + 0.0823 = 0.2593; 100/0.2593^1.2 = 505.2 ft; 0.2593^-0.4 = 1.71585.
    let dryden = DrydenSettings::low_altitude(30.48, 10.0).expect("valid");
    // The digits above.
    assert!(
        (dryden.length_m[0] / 0.3048 - 505.2).abs() < 0.1,
        "{dryden:?}"
    );
    assert!((dryden.length_m[2] - 30.48).abs() < 1e-12);
    assert!((dryden.intensity_mps[2] - 1.0).abs() < 1e-12);
    assert!(
        (dryden.intensity_mps[0] - 1.715_85).abs() < 1e-5,
        "{dryden:?}"
    );
    // At 1000 ft the field is isotropic: 0.177 + 0.823 = 1.
    let high = DrydenSettings::low_altitude(304.8, 10.0).expect("valid");
    assert!((high.length_m[0] - high.length_m[2]).abs() < 1e-9);
    assert!(DrydenSettings::low_altitude(0.0, 10.0).is_err());
}

#[test]
fn analytic_gust_rises_holds_and_falls() {
    let gust = GustSettings {
        velocity_mps: [8.0, 0.0, -1.0],
        start_s: 2.0,
        rise_s: 0.5,
        hold_s: 1.0,
    };
    // Rounding only.
    for (t, share) in [
        (1.9, 0.0),
        (2.25, 0.5),
        (2.5, 1.0),
        (3.4, 1.0),
        (3.75, 0.5),
        (4.1, 0.0),
    ] {
        let [x, _, z] = gust.at(t);
        assert!(
            (x - 8.0 * share).abs() < 1e-12 && (z + share).abs() < 1e-12,
            "{t}"
        );
    }
}

#[test]
fn prop_wind_follows_seed_and_settings() {
    let at = |seed, index| {
        let mut wind = Wind::new(&settings(), 0.001, seed, index).expect("valid settings");
        wind.step();
        wind.velocity_mps()
    };
    assert_eq!(at(1, 0), at(1, 0));
    assert_ne!(at(1, 0), at(2, 0));
    assert_ne!(at(1, 0), at(1, 1));
    let calm = Wind::new(&WindSettings::default(), 0.001, 1, 0).expect("valid settings");
    assert_eq!(calm.velocity_mps(), [0.0; 3]);
    let bad = WindSettings {
        dryden: Some(DrydenSettings {
            passing_mps: 0.0,
            ..DRYDEN
        }),
        ..WindSettings::default()
    };
    let message = bad.validate().expect_err("no speed").to_string();
    assert!(message.contains("dryden.passing_mps") && message.contains("found 0"));
    let text = toml::to_string(&settings()).expect("settings are text");
    assert_eq!(
        toml::from_str::<WindSettings>(&text).expect("read back"),
        settings()
    );
}
