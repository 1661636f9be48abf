//! Systems that are disturbed.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::quiet;
use crate::identify::{Between, Identification, Identify, NoiseSource, Settings};
use crate::{Dataset, Library};

/// Rows of a Van der Pol oscillator, dx = y dt + 0.02 dw, dy = (y - x - x² y) dt + 0.05 dw, with noise of a deviation on both; by
/// Euler and Maruyama in twentieths of a row.
pub(super) fn van_der_pol(noise: f64, seed: u64) -> Dataset {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut data = Dataset::new(&["x", "y"], &[]).unwrap();
    for start in [2.0, -0.5] {
        let (mut x, mut y) = (start, 0.0);
        let mut columns = vec![Vec::new(), Vec::new()];
        for _ in 0..1500 {
            columns[0].push(x + noise * normal());
            columns[1].push(y + noise * normal());
            let h: f64 = 0.04 / 20.0;
            for _ in 0..20 {
                let dx = y * h + 0.02 * h.sqrt() * normal();
                let dy = (y - x - x * x * y) * h + 0.05 * h.sqrt() * normal();
                (x, y) = (x + dx, y + dy);
            }
        }
        let time = (0..1500).map(|k| 0.04 * f64::from(k)).collect();
        data.push("run", time, columns, None).unwrap();
    }
    data
}

pub(super) fn fit(data: &Dataset, without: &[&str], settings: Settings) -> Identification {
    let library = Library::polynomial(&["x", "y"], 3).unwrap();
    let lacking: Vec<usize> = (0..library.len())
        .filter(|&j| without.contains(&library.names()[j].as_str()))
        .collect();
    let identify = Identify::new(library.without(&lacking));
    identify
        .settings(settings)
        .unwrap()
        .run(data, &mut quiet())
        .unwrap()
}

pub(super) fn by(noise: NoiseSource) -> Settings {
    Settings {
        noise,
        ..Settings::default()
    }
}

pub(super) fn terms(found: &Identification) -> Vec<Vec<String>> {
    let names = |e: &Vec<crate::model::Term>| e.iter().map(|t| t.expression.to_string()).collect();
    found.model.equations().iter().map(names).collect()
}

#[test]
fn analytic_a_disturbed_system_is_found_with_its_disturbances() {
    for (noise, seed) in [(0.0, 1), (0.01, 2)] {
        let found = fit(&van_der_pol(noise, seed), &[], Settings::default());
        assert_eq!(
            terms(&found),
            [vec!["y"], vec!["x", "y", "x^2*y"]],
            "{}",
            found.model
        );
        assert_eq!(found.choice.method, "prediction_error");
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        for (equation, truth) in found.equations.iter().zip([0.02, 0.05]) {
            // Of 3000 rows to 3 % where nothing else acts, and to 15 % where a row's noise is twice what the disturbance adds.
            let size = equation.disturbance.unwrap();
            assert!((size / truth - 1.0).abs() < 0.3, "{size} {truth}");
            // The noise of the measurement, or next to none.
            assert!(
                (equation.residual.unwrap() - noise).abs() < 0.002,
                "{:?}",
                equation.residual
            );
        }
    }
}

#[test]
fn analytic_a_missing_term_is_not_taken_for_a_disturbance() {
    for noise in [0.0, 0.01] {
        let found = fit(&van_der_pol(noise, 3), &["x^2*y"], Settings::default());
        let doubted = found
            .warnings
            .iter()
            .any(|w| w.contains("not in the library"));
        assert!(doubted, "{:?} {}", found.warnings, found.model);
        // Nor where the filter is asked for.
        let found = fit(&van_der_pol(noise, 3), &["x^2*y"], by(NoiseSource::Both));
        let doubted = found
            .warnings
            .iter()
            .any(|w| w.contains("not in the library"));
        assert!(doubted, "{:?} {}", found.warnings, found.model);
    }
}

/// Rows of dx = -x dt + 0.5 dw, a tenth of the time apart, from x = 2 on.
fn relaxation(rows: usize, seed: u64) -> Dataset {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut x = 2.0;
    let mut column = Vec::new();
    for _ in 0..rows {
        column.push(x);
        // The exact transition: variances 0.25 (1 - e^(-2 h)) / 2.
        let (kept, h): (f64, f64) = ((-0.1_f64).exp(), 0.1);
        let normal: f64 = StandardNormal.sample(&mut rng);
        x = kept * x + (0.125 * (1.0 - (-2.0 * h).exp())).sqrt() * normal;
    }
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    let time = (0..rows).map(|k| 0.1 * k as f64).collect();
    data.push("run", time, vec![column], None).unwrap();
    data
}

#[test]
fn prop_one_disturbed_state_is_found_or_said_to_be_as_likely() {
    for seed in 0..4 {
        // 1000 rows distinguish an Ornstein–Uhlenbeck process from correlated noise; 60 rows do not.
        for (rows, method) in [(1000, "prediction_error"), (60, "output_error")] {
            let identify = Identify::new(Library::parse(&["1", "x"]).unwrap());
            let found = identify.run(&relaxation(rows, seed), &mut quiet()).unwrap();
            assert_eq!(found.choice.method, method, "{rows} {seed}");
            let said = found.warnings.iter().any(|w| w.contains("equally likely"));
            assert_eq!(said, rows == 60, "{seed}: {:?}", found.warnings);
        }
    }
}

#[test]
fn analytic_terms_that_would_do_in_place_of_one_are_named_and_counted() {
    for seed in 0..4 {
        // dx = (3 - x) dt + 0.5 dw: x stays within a third of 3, where a line and a parabola are alike.
        let near = relaxation(1000, seed);
        let x = near.trajectories()[0].columns[0].iter().map(|x| x + 3.0);
        let mut data = Dataset::new(&["x"], &[]).unwrap();
        let time = near.trajectories()[0].time.clone();
        data.push("run", time, vec![x.collect()], None).unwrap();
        let identify = Identify::new(Library::polynomial(&["x"], 2).unwrap());
        let identify = identify.settings(by(NoiseSource::Process)).unwrap();
        let found = identify.run(&data, &mut quiet()).unwrap();
        let (kept, other) = match terms(&found)[0].join(" ").as_str() {
            "1 x" => ("x", "x^2"),
            "1 x^2" => ("x^2", "x"),
            "x x^2" => ("x^2", "1"),
            kept => panic!("{seed}: {kept}"),
        };
        let said = found.warnings.join("; ");
        let named = "equation of x: other terms are about as likely: ";
        assert!(said.contains(named), "{said}");
        assert!(
            said.contains(&format!("{other} instead of {kept} (odds 1 to ")),
            "{said}"
        );
        // Odds above 1 to 20 leave less than this of the probability.
        let inclusion = found.model.equations()[0][1].inclusion.unwrap();
        assert!(inclusion < 1.0 / (1.0 + 1.0 / 20.0), "{inclusion}");
    }
}

/// dx = (-x + u + a u²) dt + 0.3 dw with a white input u. The library lacks u², so the residual is white in time and depends on u:
/// only the comparison of neighbours shows it.
#[test]
fn analytic_a_missing_term_that_is_white_in_time_is_seen_among_neighbours() {
    for (missing, seed) in [(0.0, 5), (0.5, 5), (0.5, 6)] {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut x = 0.0;
        let mut columns = vec![Vec::new(), Vec::new()];
        for _ in 0..2000 {
            let u = normal();
            columns[0].push(x);
            columns[1].push(u);
            let h: f64 = 0.1 / 20.0;
            for _ in 0..20 {
                x += (u + missing * u * u - x) * h + 0.3 * h.sqrt() * normal();
            }
        }
        let mut data = Dataset::new(&["x"], &["u"]).unwrap();
        let time = (0..2000).map(|k| 0.1 * f64::from(k)).collect();
        data.push("run", time, columns, None).unwrap();
        let library = Library::parse(&["1", "x", "u"]).unwrap();
        let settings = Settings {
            inputs_between: Between::Hold,
            ..by(NoiseSource::Process)
        };
        let identify = Identify::new(library).settings(settings).unwrap();
        let found = identify.run(&data, &mut quiet()).unwrap();
        let seen = found.warnings.iter().any(|w| w.contains("neighbours"));
        assert_eq!(seen, missing > 0.0, "{:?} {}", found.warnings, found.model);
        let correlated = found.warnings.iter().any(|w| w.contains("correlated"));
        assert!(!correlated, "{:?}", found.warnings);
    }
}

#[test]
fn prop_the_source_of_the_noise_is_as_it_was_asked_for() {
    let data = van_der_pol(0.01, 4);
    let both = fit(&data, &[], by(NoiseSource::Both));
    let found = fit(&data, &[], Settings::default());
    assert_eq!(both.model, found.model);
    let process = fit(&data, &[], by(NoiseSource::Process));
    // What there is of noise counts as disturbance: √(2 r / h) = 0.07 beside 0.02.
    let size = process.equations[0].disturbance.unwrap();
    assert!((0.05..0.1).contains(&size), "{size}");
    // Rows as states: their noise is not what makes the next row.
    let says = |found: &Identification, text: &str| found.warnings.iter().any(|w| w.contains(text));
    assert!(
        says(&process, "not disturbed by white noise"),
        "{:?}",
        process.warnings
    );
    let measured = fit(&data, &[], by(NoiseSource::Measurement));
    assert_eq!(measured.choice.method, "output_error");
    assert!(measured.equations.iter().all(|e| e.disturbance.is_none()));
    let misfit = says(&measured, "times the noise") || says(&measured, "not white");
    assert!(misfit, "{:?}", measured.warnings);
    assert!(!says(&measured, "arc"), "{:?}", measured.warnings);
}

#[test]
fn analytic_positions_alone_of_a_disturbed_oscillator() {
    let whole = van_der_pol(0.002, 5);
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    for s in whole.stretches() {
        data.push("run", s.time.to_vec(), vec![s.columns[0].to_vec()], None)
            .unwrap();
    }
    let settings = Settings {
        second_order: vec!["x".into()],
        ..by(NoiseSource::Both)
    };
    let library = Library::polynomial(&["x", "x_dot"], 3).unwrap();
    let found = Identify::new(library)
        .settings(settings)
        .unwrap()
        .run(&data, &mut quiet())
        .unwrap();
    let own = &found.model.equations()[1];
    let names: Vec<String> = own.iter().map(|t| t.expression.to_string()).collect();
    assert_eq!(names, ["x", "x_dot", "x^2*x_dot"], "{}", found.model);
    for (term, truth) in own.iter().zip([-1.0, 1.0, -1.0]) {
        // Six coefficients in all runs of this test: none of them is five standard errors off.
        let error = term.std_error.unwrap();
        assert!(
            (term.coefficient - truth).abs() < 5.0 * error,
            "{}",
            found.model
        );
    }
}

#[test]
fn prop_a_source_that_nothing_is_made_of_is_refused() {
    let refused = [
        Settings {
            discrete: true,
            ..by(NoiseSource::Process)
        },
        Settings {
            method: crate::identify::Method::Regression,
            ..by(NoiseSource::Both)
        },
    ];
    for settings in refused {
        let error = settings.validate().unwrap_err().to_string();
        assert!(error.contains("noise"), "{error}");
    }
}
