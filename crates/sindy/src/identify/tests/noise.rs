//! Noise that is not white, and rows that are not there.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::disturbed::by;
use super::{against_truth, quiet};
use crate::identify::{Identification, Identify, NoiseSource};
use crate::problems::{self, Problem};
use crate::{Dataset, Library};

/// The rows with noise `e[k] = of e[k-1] + ...` of `percent` of each state's standard deviation.
pub(super) fn coloured(problem: &Problem, of: f64, percent: f64, seed: u64) -> Dataset {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
    for mut record in problem.clean().unwrap() {
        for column in &mut record.states {
            let n = column.len() as f64;
            let mean = column.iter().sum::<f64>() / n;
            let sd = (column.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
            let mut e: f64 = StandardNormal.sample(&mut rng);
            for v in column.iter_mut() {
                *v += 0.01 * percent * sd * e;
                let z: f64 = StandardNormal.sample(&mut rng);
                e = of * e + (1.0 - of * of).sqrt() * z;
            }
        }
        let columns = [record.states, record.inputs].concat();
        data.push("run", record.time, columns, None).unwrap();
    }
    data
}

pub(super) fn doubted(found: &Identification) -> bool {
    let says = |w: &String| w.contains("not in the library");
    found.warnings.iter().any(says)
}

#[test]
fn analytic_true_models_are_accepted_in_noise_of_any_colour() {
    for (problem, of, percent) in [
        (problems::lotka_volterra(), 0.5, 2.0),
        (problems::van_der_pol(), 0.9, 1.0),
        (problems::lorenz(), 0.9, 0.5),
        // Close to a random walk: a tenth of the size of the noise is new after 50 rows.
        (problems::lorenz(), 0.9999, 2.0),
    ] {
        let identify = Identify::new(problem.library().unwrap());
        let found = identify
            .run(&coloured(&problem, of, percent, 31), &mut quiet())
            .unwrap();
        let (error, exact) = against_truth(&problem, &found.model);
        // Half a percent: what new noise there is in each row is below 2 % of the states.
        assert!(
            exact && error < 5e-3,
            "{}: {error} {}",
            problem.name,
            found.model
        );
        assert!(!doubted(&found), "{}: {:?}", problem.name, found.warnings);
        let colour = found.warnings.iter().any(|w| w.contains("is not white"));
        assert!(colour, "{}: {:?}", problem.name, found.warnings);
    }
}

#[test]
fn prop_a_source_that_is_not_the_noises_own_leaves_no_doubtful_terms() {
    // Noise of the measurement that remembers is no disturbance: prediction errors are correlated, and terms imitate that.
    for (problem, of, percent) in [
        (problems::lorenz(), 0.9999, 2.0),
        (problems::van_der_pol(), 0.9, 1.0),
    ] {
        let identify = Identify::new(problem.library().unwrap());
        let found = identify
            .settings(by(NoiseSource::Process))
            .unwrap()
            .run(&coloured(&problem, of, percent, 31), &mut quiet())
            .unwrap();
        let says = |text: &str| found.warnings.iter().any(|w| w.contains(text));
        assert!(!says("absent than not"), "{:?}", found.warnings);
        assert!(says("are correlated"), "{:?}", found.warnings);
        let (_, exact) = against_truth(&problem, &found.model);
        assert!(exact, "{}: {}", problem.name, found.model);
    }
}

#[test]
fn analytic_a_missing_term_is_not_taken_for_noise() {
    let problem = problems::van_der_pol();
    let lacking: Vec<&String> = problem.terms.iter().filter(|t| *t != "x^2*y").collect();
    let identify = Identify::new(Library::parse(&lacking).unwrap());
    for (of, percent) in [(0.0, 1.0), (0.9, 1.0)] {
        let found = identify
            .run(&coloured(&problem, of, percent, 32), &mut quiet())
            .unwrap();
        assert!(
            doubted(&found),
            "{of}: {:?} {}",
            found.warnings,
            found.model
        );
    }
}

#[test]
fn analytic_lost_rows_cost_no_more_than_their_number() {
    let problem = problems::lorenz();
    let library = problem.library().unwrap();
    let record = problem.noisy(1.0, 33).unwrap().remove(0);
    let fit = |lost: f64| {
        let mut rng = Pcg64::seed_from_u64(34);
        let mut columns = record.states.clone();
        for row in 0..record.time.len() {
            if rng.random_range(0.0..1.0) < lost {
                columns.iter_mut().for_each(|c| c[row] = f64::NAN);
            }
        }
        let mut data = Dataset::new(&problem.states, &[]).unwrap();
        data.push("run", record.time.clone(), columns, None)
            .unwrap();
        Identify::new(library.clone())
            .run(&data, &mut quiet())
            .unwrap()
    };
    let ((all, _), (error, exact)) = (
        against_truth(&problem, &fit(0.0).model),
        against_truth(&problem, &fit(0.1).model),
    );
    // A tenth of the rows less changes an estimate by a third of its standard error: three of them at most, and one for
    // an error of all rows that is small by chance.
    assert!(
        exact && error < 3.0 * all.max(1e-4),
        "{error}, {all} of all rows"
    );
}
