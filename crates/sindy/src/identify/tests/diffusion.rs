//! Disturbances whose size depends on the state.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::quiet;
use crate::identify::{Identification, Identify, NoiseSource, Settings};
use crate::{Dataset, Library};

/// Coefficients by state and term.
type Truth = &'static [&'static [(&'static str, f64)]];

/// A system `dx = f dt + g dW`, its candidates and its rows. `benches/field` has them on many seeds, with drift and intervals scored.
struct Problem {
    name: &'static str,
    states: &'static [&'static str],
    diffusion: Truth,
    library: &'static str,
    starts: &'static [&'static [f64]],
    period: f64,
    rows: usize,
    /// Drift and squared diffusion.
    of: fn(&[f64], &mut [f64], &mut [f64]),
}

/// Steps of Euler and Maruyama between rows: their error of half a step is a hundredth of what a row adds.
const STEPS: usize = 50;

const CANDIDATES: &str = "poly(2)";

const BLACK_SCHOLES: Problem = Problem {
    name: "geometric Brownian motion",
    states: &["x"],
    diffusion: &[&[("x^2", 0.09)]],
    library: "poly(2)",
    starts: &[
        &[1.0],
        &[2.0],
        &[0.5],
        &[1.5],
        &[3.0],
        &[0.8],
        &[1.2],
        &[2.5],
    ],
    period: 0.01,
    rows: 250,
    of: |x, f, q| {
        f[0] = 0.8 * x[0];
        q[0] = 0.09 * x[0] * x[0];
    },
};

const ORNSTEIN_UHLENBECK: Problem = Problem {
    name: "Ornstein-Uhlenbeck",
    states: &["x"],
    diffusion: &[&[("1", 0.25)]],
    library: "poly(2)",
    starts: &[&[2.0], &[-1.0]],
    period: 0.05,
    rows: 1500,
    of: |x, f, q| {
        f[0] = -x[0];
        q[0] = 0.25;
    },
};

const DOUBLE_WELL: Problem = Problem {
    name: "double well",
    states: &["x"],
    diffusion: &[&[("1", 0.2), ("x^2", 0.4)]],
    library: "poly(3)",
    starts: &[&[1.5], &[-1.5], &[0.0], &[0.3]],
    period: 0.02,
    rows: 2500,
    of: |x, f, q| {
        f[0] = 2.0 * x[0] - 2.0 * x[0].powi(3);
        q[0] = 0.2 + 0.4 * x[0] * x[0];
    },
};

const COX_INGERSOLL_ROSS: Problem = Problem {
    name: "Cox-Ingersoll-Ross",
    states: &["x"],
    diffusion: &[&[("x", 0.36)]],
    library: "poly(2)",
    starts: &[&[3.0], &[0.2], &[1.0]],
    period: 0.02,
    rows: 2000,
    of: |x, f, q| {
        f[0] = 2.0 - 2.0 * x[0];
        q[0] = 0.36 * x[0];
    },
};

/// Populations stay so large that none dies out.
const LOTKA_VOLTERRA: Problem = Problem {
    name: "Lotka-Volterra with demographic noise",
    states: &["x", "y"],
    diffusion: &[&[("x", 0.004)], &[("y", 0.002)]],
    library: "poly(2)",
    starts: &[&[6.0, 2.0], &[5.0, 4.0]],
    period: 0.05,
    rows: 1000,
    of: |x, f, q| {
        f[0] = 1.1 * x[0] - 0.4 * x[0] * x[1];
        f[1] = -0.4 * x[1] + 0.1 * x[0] * x[1];
        q[0] = 0.004 * x[0];
        q[1] = 0.002 * x[1];
    },
};

impl Problem {
    /// Rows, with measurement noise of a deviation.
    fn data(&self, seed: u64, noise: f64) -> Dataset {
        let mut rng = Pcg64::seed_from_u64(seed);
        let n = self.states.len();
        let mut data = Dataset::new(self.states, &[]).unwrap();
        let (mut f, mut q) = (vec![0.0; n], vec![0.0; n]);
        for start in self.starts {
            let mut x = start.to_vec();
            let mut columns = vec![Vec::new(); n];
            for _ in 0..self.rows {
                for (column, x) in columns.iter_mut().zip(&x) {
                    let normal: f64 = StandardNormal.sample(&mut rng);
                    column.push(x + noise * normal);
                }
                let h = self.period / STEPS as f64;
                for _ in 0..STEPS {
                    (self.of)(&x, &mut f, &mut q);
                    for i in 0..n {
                        let normal: f64 = StandardNormal.sample(&mut rng);
                        x[i] += f[i] * h + (q[i] * h).sqrt() * normal;
                    }
                }
            }
            let time = (0..self.rows).map(|k| self.period * k as f64).collect();
            data.push("run", time, columns, None).unwrap();
        }
        data
    }

    fn fit(&self, seed: u64, diffusion: Option<&str>) -> Identification {
        self.fit_in_noise((seed, 0.0), diffusion, NoiseSource::Process)
    }

    fn fit_in_noise(
        &self,
        (seed, noise): (u64, f64),
        diffusion: Option<&str>,
        source: NoiseSource,
    ) -> Identification {
        let settings = Settings {
            noise: source,
            diffusion: diffusion.iter().map(ToString::to_string).collect(),
            ..Settings::default()
        };
        let library = Library::specification(self.library, self.states).unwrap();
        let identify = Identify::new(library).settings(settings).unwrap();
        identify.run(&self.data(seed, noise), &mut quiet()).unwrap()
    }
}

fn names(truth: Truth) -> Vec<Vec<String>> {
    let of = |e: &&[(&str, f64)]| e.iter().map(|(t, _)| (*t).to_owned()).collect();
    truth.iter().map(of).collect()
}

/// Whether a fit without the option is warned of.
fn is_warned(problem: &Problem, seed: u64) -> bool {
    let found = problem.fit(seed, None);
    assert!(found.equations.iter().all(|e| e.diffusion.is_empty()));
    found.warnings.iter().any(|w| w.contains("--diffusion"))
}

const PROBLEMS: [Problem; 5] = [
    BLACK_SCHOLES,
    ORNSTEIN_UHLENBECK,
    DOUBLE_WELL,
    COX_INGERSOLL_ROSS,
    LOTKA_VOLTERRA,
];

#[test]
fn analytic_the_diffusion_of_known_systems_is_found() {
    for problem in &PROBLEMS {
        for seed in 0..2 {
            let found = problem.fit(seed, Some(CANDIDATES));
            let own = found.equations.iter().map(|e| &e.diffusion);
            let terms = own.map(|e| e.iter().map(|t| t.term.clone()).collect());
            let terms: Vec<Vec<String>> = terms.collect();
            let name = problem.name;
            assert_eq!(terms, names(problem.diffusion), "{name}, seed {seed}");
        }
    }
}

#[test]
fn analytic_a_size_that_depends_on_the_state_is_warned_of_where_it_is_not_asked_for() {
    for seed in 0..2 {
        assert!(!is_warned(&ORNSTEIN_UHLENBECK, seed), "{seed}");
        for problem in [&BLACK_SCHOLES, &DOUBLE_WELL, &COX_INGERSOLL_ROSS] {
            assert!(is_warned(problem, seed), "{} {seed}", problem.name);
        }
    }
}

#[test]
fn analytic_a_constant_is_said_to_be_one() {
    let found = ORNSTEIN_UHLENBECK.fit(3, Some(CANDIDATES));
    assert_eq!(found.equations[0].diffusion.len(), 1);
    assert!(
        found
            .choice
            .reason
            .contains("every disturbance is a constant"),
        "{}",
        found.choice.reason
    );
    // The constant of the option is that without it, to the width of the search for the latter.
    let without = ORNSTEIN_UHLENBECK.fit(3, None);
    let size = without.equations[0].disturbance.unwrap();
    let own = found.equations[0].diffusion[0].coefficient.sqrt();
    assert!((size / own - 1.0).abs() < 0.03, "{size} {own}");
}

#[test]
fn analytic_a_diffusion_beside_noise_of_the_measurement() {
    // A row adds a deviation of 0.06 to 0.1.
    let found = DOUBLE_WELL.fit_in_noise((0, 0.03), Some(CANDIDATES), NoiseSource::Both);
    let own = &found.equations[0];
    let terms: Vec<&str> = own.diffusion.iter().map(|t| t.term.as_str()).collect();
    assert_eq!(terms, ["1", "x^2"], "{:?}", own.diffusion);
    for (term, truth) in own.diffusion.iter().zip([0.2, 0.4]) {
        let z = (term.coefficient - truth) / term.std_error;
        assert!(z.abs() < 4.0, "{term:?}");
    }
    // From 10 000 rows to some percent.
    assert!((own.residual.unwrap() / 0.03 - 1.0).abs() < 0.15);
}

const MULTIPLICATIVE: Problem = Problem {
    name: "reversion with a constant and a multiplicative disturbance",
    states: &["x"],
    diffusion: &[&[("1", 0.1), ("x^2", 0.3)]],
    library: "poly(2)",
    starts: &[&[0.0], &[0.5], &[1.0], &[1.5], &[2.0], &[3.0]],
    period: 0.04,
    rows: 500,
    of: |x, f, q| {
        f[0] = 1.0 - x[0];
        q[0] = 0.1 + 0.3 * x[0] * x[0];
    },
};

#[test]
fn analytic_noise_of_the_measurement_is_told_from_a_constant_disturbance() {
    // The constant adds a deviation of 0.063 to a row. A row alone cannot tell it from noise: neighbours of differences can.
    for noise in [0.02, 0.05] {
        for seed in 0..3 {
            let asked = ((seed, noise), Some(CANDIDATES), NoiseSource::Both);
            let found = MULTIPLICATIVE.fit_in_noise(asked.0, asked.1, asked.2);
            let own = &found.equations[0];
            let terms: Vec<&str> = own.diffusion.iter().map(|t| t.term.as_str()).collect();
            assert_eq!(terms, ["1", "x^2"], "{noise} {seed}: {:?}", own.diffusion);
            for (term, truth) in own.diffusion.iter().zip([0.1, 0.3]) {
                // Chance exceeds 4 standard errors in one of 16 000; and they are known to a third of the coefficient.
                let z = (term.coefficient - truth) / term.std_error;
                assert!(
                    z.abs() < 4.0 && term.std_error < truth / 3.0,
                    "{noise} {seed}: {term:?}"
                );
            }
            // Beside a disturbance of 0.12 a row, noise of 0.02 is known to half of it.
            let off = own.residual.unwrap() - noise;
            assert!(off.abs() < 0.012, "{noise} {seed}: {off}");
        }
    }
}

#[test]
fn prop_a_library_without_a_variance_leaves_a_constant_and_a_warning() {
    let found = ORNSTEIN_UHLENBECK.fit(1, Some("x"));
    assert!(found.equations[0].diffusion.is_empty());
    let said = |w: &String| w.contains("positive on all rows");
    assert!(found.warnings.iter().any(said), "{:?}", found.warnings);
}

#[test]
fn prop_a_diffusion_that_nothing_is_made_of_is_refused() {
    let asked = |noise| Settings {
        diffusion: vec!["poly(2)".into()],
        noise,
        ..Settings::default()
    };
    let refused = [
        asked(NoiseSource::Automatic),
        asked(NoiseSource::Measurement),
        Settings {
            second_order: vec!["x".into()],
            ..asked(NoiseSource::Process)
        },
        Settings {
            discrete: true,
            ..asked(NoiseSource::Automatic)
        },
    ];
    for settings in refused {
        let error = settings.validate().unwrap_err().to_string();
        assert!(error.contains("diffusion"), "{error}");
    }
    assert!(asked(NoiseSource::Both).validate().is_ok());
    // A state that does not move has no disturbance.
    let mut still = Dataset::new(&["x", "y"], &[] as &[&str]).unwrap();
    let time = (0..200).map(|k| 0.01 * f64::from(k)).collect();
    let moves = (0..200).map(|k| f64::from(k * k % 17)).collect();
    still
        .push("run", time, vec![moves, vec![3.0; 200]], None)
        .unwrap();
    let library = Library::polynomial(&["x", "y"], 1).unwrap();
    let identify = Identify::new(library)
        .settings(asked(NoiseSource::Process))
        .unwrap();
    let error = identify.run(&still, &mut quiet()).unwrap_err().to_string();
    assert!(
        error.contains("states that change, found one value of y"),
        "{error}"
    );
    // Names that are no columns.
    let settings = Settings {
        diffusion: vec!["y".into()],
        ..asked(NoiseSource::Process)
    };
    let library = Library::parse(&["x"]).unwrap();
    let identify = Identify::new(library).settings(settings).unwrap();
    let data = ORNSTEIN_UHLENBECK.data(0, 0.0);
    assert!(identify.run(&data, &mut quiet()).is_err());
}
