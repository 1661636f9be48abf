//! Disturbances whose size depends on the state.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::quiet;
use crate::identify::{Identification, Identify, NoiseSource, Settings};
use crate::{Dataset, Library};

/// Coefficients by state and term.
type Truth = &'static [&'static [(&'static str, f64)]];

/// A system `dx = f dt + g dW`, its candidates and its rows.
struct Problem {
    name: &'static str,
    states: &'static [&'static str],
    drift: Truth,
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
    drift: &[&[("x", 0.8)]],
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
    drift: &[&[("x", -1.0)]],
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
    drift: &[&[("x", 2.0), ("x^3", -2.0)]],
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
    drift: &[&[("1", 2.0), ("x", -2.0)]],
    diffusion: &[&[("x", 0.36)]],
    library: "poly(2)",
    starts: &[&[3.0], &[0.2], &[1.0]],
    period: 0.02,
    rows: 2000,
    of: |x, f, q| {
        f[0] = 2.0 - 2.0 * x[0];
        q[0] = 0.36 * x[0].max(0.0);
    },
};

const LOTKA_VOLTERRA: Problem = Problem {
    name: "Lotka-Volterra with demographic noise",
    states: &["x", "y"],
    drift: &[&[("x", 1.1), ("x*y", -0.4)], &[("y", -0.4), ("x*y", 0.1)]],
    diffusion: &[&[("x", 0.02)], &[("y", 0.01)]],
    library: "poly(2)",
    starts: &[&[10.0, 5.0], &[6.0, 2.0]],
    period: 0.05,
    rows: 1200,
    of: |x, f, q| {
        f[0] = 1.1 * x[0] - 0.4 * x[0] * x[1];
        f[1] = -0.4 * x[1] + 0.1 * x[0] * x[1];
        q[0] = 0.02 * x[0].max(0.0);
        q[1] = 0.01 * x[1].max(0.0);
    },
};

impl Problem {
    fn data(&self, seed: u64) -> Dataset {
        let mut rng = Pcg64::seed_from_u64(seed);
        let n = self.states.len();
        let mut data = Dataset::new(self.states, &[]).unwrap();
        let (mut f, mut q) = (vec![0.0; n], vec![0.0; n]);
        for start in self.starts {
            let mut x = start.to_vec();
            let mut columns = vec![Vec::new(); n];
            for _ in 0..self.rows {
                columns.iter_mut().zip(&x).for_each(|(c, x)| c.push(*x));
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

    fn fit(&self, seed: u64, diffusion: Option<&str>, noise: NoiseSource) -> Identification {
        let settings = Settings {
            noise,
            diffusion: diffusion.iter().map(ToString::to_string).collect(),
            ..Settings::default()
        };
        let library = Library::specification(self.library, self.states).unwrap();
        let identify = Identify::new(library).settings(settings).unwrap();
        identify.run(&self.data(seed), &mut quiet()).unwrap()
    }
}

/// What fits of a problem are worth.
#[derive(Debug, Default)]
struct Score {
    drifts: usize,
    diffusions: usize,
    both: usize,
    /// True coefficients of exact diffusions in their intervals, and intervals.
    held: (usize, usize),
    warned: usize,
}

fn score(
    problem: &Problem,
    seeds: std::ops::Range<u64>,
    noise: NoiseSource,
    verbose: bool,
) -> Score {
    let mut out = Score::default();
    for seed in seeds {
        let found = problem.fit(seed, Some(CANDIDATES), noise);
        let terms = found.model.equations().iter();
        let drift = terms
            .map(|e| e.iter().map(|t| t.expression.to_string()).collect::<Vec<_>>())
            .eq(names(problem.drift));
        let own = found.equations.iter().map(|e| &e.diffusion);
        let diffusion = own
            .clone()
            .map(|e| e.iter().map(|t| t.term.clone()).collect::<Vec<_>>())
            .eq(names(problem.diffusion));
        out.drifts += usize::from(drift);
        out.diffusions += usize::from(diffusion);
        out.both += usize::from(drift && diffusion);
        out.warned += usize::from(!found.warnings.is_empty());
        if diffusion {
            for (own, truth) in own.zip(problem.diffusion) {
                for (term, (_, c)) in own.iter().zip(*truth) {
                    let [low, high] = term.interval.unwrap();
                    out.held.0 += usize::from(low <= *c && *c <= high);
                    out.held.1 += 1;
                }
            }
        }
        if verbose && !(drift && diffusion) {
            let own: Vec<String> = found
                .equations
                .iter()
                .flat_map(|e| &e.diffusion)
                .map(|t| format!("{:.3} {} ({:.2})", t.coefficient, t.term, t.inclusion))
                .collect();
            eprintln!("{seed}: {:.3}{own:?} {:?}", found.model, found.warnings);
        }
    }
    out
}

fn names(truth: Truth) -> Vec<Vec<String>> {
    let of = |e: &&[(&str, f64)]| e.iter().map(|(t, _)| (*t).to_owned()).collect();
    truth.iter().map(of).collect()
}

/// `cargo test -p sindy --release --lib diffusion -- --ignored --nocapture`: the figures of the documentation.
#[test]
#[ignore = "the figures of the documentation, in some minutes"]
fn analytic_figures_of_many_seeds() {
    let seeds = 100..140;
    for problem in [
        BLACK_SCHOLES,
        ORNSTEIN_UHLENBECK,
        DOUBLE_WELL,
        COX_INGERSOLL_ROSS,
        LOTKA_VOLTERRA,
    ] {
        let of = score(&problem, seeds.clone(), NoiseSource::Process, true);
        let silent = |seed| {
            let found = problem.fit(seed, None, NoiseSource::Process);
            !found.warnings.iter().any(|w| w.contains("--diffusion"))
        };
        let warned = seeds.clone().filter(|seed| !silent(*seed)).count();
        eprintln!(
            "{}: {of:?}; without the option {warned} are warned of",
            problem.name
        );
    }
}
