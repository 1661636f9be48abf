//! Problems with known answers, for tests, examples and benches.
//!
//! Each [`Problem`] has equations with their true coefficients, a candidate library that contains them,
//! and trajectories to be fitted, made by this crate's own integrator at a fine step. Noise comes from an
//! explicit seed.
//!
//! | problem | states, inputs | of note |
//! | --- | --- | --- |
//! | [`damped_oscillator`] | 2 | linear, solved in closed form |
//! | [`duffing`] | 2, 1 | chaotic under a sinusoidal force |
//! | [`lorenz`] | 3 | chaotic |
//! | [`rossler`] | 3 | chaotic, with fast spikes |
//! | [`van_der_pol`] | 2 | limit cycle with fast and slow parts |
//! | [`lotka_volterra`] | 2 | closed orbits, a conserved quantity |
//! | [`propeller_thrust`] | 1, 1 | terms with exp and sin |
//! | [`ground_effect`] | 1, 4 | five trajectories, inputs nearly collinear |
//!
//! ```
//! use sindy::problems;
//!
//! let lorenz = problems::lorenz();
//! assert_eq!(format!("{:.3}", lorenz.model()?).lines().next(), Some("x' = -10.0*x + 10.0*y"));
//! let records = lorenz.noisy(1.0, 42)?; // 1 % of each state's standard deviation, seed 42
//! assert_eq!(records[0].states[0].len(), 5000);
//! # Ok::<(), sindy::SindyError>(())
//! ```

mod damped_oscillator;
mod duffing;
mod ground_effect;
mod lorenz;
mod lotka_volterra;
mod propeller_thrust;
mod rossler;
#[cfg(test)]
mod tests;
mod van_der_pol;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

pub use damped_oscillator::damped_oscillator;
pub use duffing::duffing;
pub use ground_effect::ground_effect;
pub use lorenz::lorenz;
pub use lotka_volterra::lotka_volterra;
pub use propeller_thrust::propeller_thrust;
pub use rossler::rossler;
pub use van_der_pol::van_der_pol;

use crate::error::{SindyError, require};
use crate::library::Library;
use crate::model::{Inputs, Model, RunOutcome, Simulation, Term, Time};

/// Steps of the integrator from one sample to the next: its error stays far below any noise that is added.
const FINE: f64 = 10.0;

/// A system with a known answer.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Problem {
    /// A name for tables.
    pub name: &'static str,
    /// The states' names.
    pub states: Vec<&'static str>,
    /// The inputs' names.
    pub inputs: Vec<&'static str>,
    /// The candidate terms.
    pub terms: Vec<String>,
    /// For each state, the terms of its equation, all among the candidates, with their coefficients.
    pub truth: Vec<Vec<(&'static str, f64)>>,
    /// The trajectories.
    pub trajectories: Vec<Trajectory>,
    /// Time from one sample to the next.
    pub step: f64,
    /// Samples of each trajectory.
    pub rows: usize,
}

/// Where a trajectory starts and what drives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// The initial state.
    pub start: Vec<f64>,
    /// The inputs as expressions of `t`.
    pub inputs: Vec<String>,
}

/// Samples of one trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Times from 0.
    pub time: Vec<f64>,
    /// One column for each state.
    pub states: Vec<Vec<f64>>,
    /// One column for each input, free of noise.
    pub inputs: Vec<Vec<f64>>,
    /// The true time derivatives of the true states, one column for each state.
    pub derivatives: Vec<Vec<f64>>,
}

/// All problems, in the order of the table above.
#[must_use]
pub fn all() -> Vec<Problem> {
    vec![
        damped_oscillator(),
        duffing(),
        lorenz(),
        rossler(),
        van_der_pol(),
        lotka_volterra(),
        propeller_thrust(),
        ground_effect(),
    ]
}

impl Problem {
    /// The candidate library.
    ///
    /// # Errors
    /// None for the problems here; for one that was changed, those of [`Library::parse`].
    pub fn library(&self) -> Result<Library, SindyError> {
        Library::parse(&self.terms)
    }

    /// The true coefficients over the library: one row for each state, one column for each term.
    #[must_use]
    pub fn coefficients(&self) -> Vec<Vec<f64>> {
        let of = |equation: &Vec<(&str, f64)>, term: &String| {
            equation
                .iter()
                .find(|(t, _)| t == term)
                .map_or(0.0, |(_, c)| *c)
        };
        self.truth
            .iter()
            .map(|equation| self.terms.iter().map(|term| of(equation, term)).collect())
            .collect()
    }

    /// The true model.
    ///
    /// # Errors
    /// None for the problems here; for one that was changed, those of [`Model::new`].
    pub fn model(&self) -> Result<Model, SindyError> {
        let equations = self
            .truth
            .iter()
            .map(|equation| {
                equation
                    .iter()
                    .map(|(term, c)| Term::parse(term, *c))
                    .collect()
            })
            .collect::<Result<_, _>>()?;
        Model::new(Time::Continuous, &self.states, &self.inputs, equations)
    }

    /// The trajectories without noise: Runge–Kutta of order 4 with 10 steps from sample to sample.
    ///
    /// # Errors
    /// None for the problems here; for one that was changed, those of [`Model::simulate`], and a setting
    /// error for a trajectory that does not reach its end.
    pub fn clean(&self) -> Result<Vec<Record>, SindyError> {
        let model = self.model()?;
        let time: Vec<f64> = (0..self.rows).map(|i| i as f64 * self.step).collect();
        let how = Simulation::fixed(self.step / FINE);
        let mut records = Vec::with_capacity(self.trajectories.len());
        for trajectory in &self.trajectories {
            let drive = Inputs::formulas(&trajectory.inputs)?;
            let run = model.simulate(&trajectory.start, &time, &drive, &how)?;
            if run.outcome != RunOutcome::Finished {
                let found = format!("{:?}", run.outcome);
                return Err(SindyError::setting(
                    "trajectories",
                    "runs that finish",
                    found,
                ));
            }
            let mut inputs = vec![Vec::with_capacity(time.len()); self.inputs.len()];
            for &t in &time {
                for (column, value) in inputs.iter_mut().zip(drive.at(t)?) {
                    column.push(value);
                }
            }
            let columns: Vec<&[f64]> = run
                .states
                .iter()
                .chain(&inputs)
                .map(Vec::as_slice)
                .collect();
            let derivatives = model.predict(&columns)?;
            records.push(Record {
                time: run.time,
                states: run.states,
                inputs,
                derivatives,
            });
        }
        Ok(records)
    }

    /// The trajectories with independent Gaussian noise on the states, of a standard deviation of
    /// `percent` of that of each state over each trajectory. Inputs and derivatives stay true. The same
    /// seed gives the same data.
    ///
    /// # Errors
    /// A percentage that is negative or not finite, and those of [`Problem::clean`].
    pub fn noisy(&self, percent: f64, seed: u64) -> Result<Vec<Record>, SindyError> {
        require(
            percent >= 0.0 && percent.is_finite(),
            "percent",
            "finite, not negative",
            percent,
        )?;
        let mut records = self.clean()?;
        let mut generator = Pcg64::seed_from_u64(seed);
        for column in records.iter_mut().flat_map(|record| &mut record.states) {
            let n = column.len() as f64;
            let mean = column.iter().sum::<f64>() / n;
            let variance = column.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
            let size = 0.01 * percent * variance.sqrt();
            for value in column {
                let noise: f64 = StandardNormal.sample(&mut generator);
                *value += size * noise;
            }
        }
        Ok(records)
    }
}

/// All monomials of the variables up to a degree, by degree: `1`, `x`, `y`, `x^2`, `x*y`, …
fn monomials(variables: &[&str], degree: usize) -> Vec<String> {
    let mut all = vec![String::from("1")];
    // Exponents of one degree; each is extended by variables from its last one on, so that none repeats.
    let mut level = vec![vec![0_usize; variables.len()]];
    for _ in 0..degree {
        let mut next = Vec::new();
        for powers in &level {
            let last = powers.iter().rposition(|&p| p > 0).unwrap_or(0);
            for variable in last..variables.len() {
                let mut more = powers.clone();
                more[variable] += 1;
                next.push(more);
            }
        }
        all.extend(next.iter().map(|powers| {
            let factors = variables.iter().zip(powers).filter(|(_, p)| **p > 0);
            let factors: Vec<String> = factors
                .map(|(v, p)| {
                    if *p == 1 {
                        (*v).to_owned()
                    } else {
                        format!("{v}^{p}")
                    }
                })
                .collect();
            factors.join("*")
        }));
        level = next;
    }
    all
}
