//! Tests of the whole sampler.

mod analytic;

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::library::Library;
use crate::model::{Model, Time};
use crate::solve::outcome::Outcome;
use crate::statistics::normal::tests::{of_rows, random_rows, reference};

/// Chains of 5000 draws in the units of the data.
fn long(seed: u64) -> Horseshoe {
    Horseshoe::new(seed)
        .scaling(Scaling::None)
        .draws(5000)
        .unwrap()
}

/// Mean and standard deviation of logarithms.
fn of_logarithms(draws: &[f64]) -> (f64, f64) {
    let n = draws.len() as f64;
    let mean = draws.iter().map(|v| v.ln()).sum::<f64>() / n;
    let square = draws.iter().map(|v| (v.ln() - mean).powi(2)).sum::<f64>();
    (mean, (square / n).sqrt())
}

/// Mean, standard deviation and ends of the 95 % interval by the NUTS of numpyro 0.22.0.
type Nuts = (f64, f64, f64, f64);

/// Compares means to a twentieth of the standard deviation (five times the error of a mean of 20 000 draws worth at least 10 000,
/// against one of 40 000 or more), standard deviations to 5 % (as these errors, twice) and ends of intervals to a fifth of it
/// (five times their error, 2.7 times that of a mean, and NUTS's few divergent steps).
fn assert_same_as_nuts(found: &Marginal, (mean, sd, lower, upper): Nuts) {
    assert!((found.mean - mean).abs() < 0.05 * sd, "{found:?} {mean}");
    assert!((found.sd / sd - 1.0).abs() < 0.05, "{found:?} {sd}");
    assert!((found.lower - lower).abs() < 0.2 * sd, "{found:?} {lower}");
    assert!((found.upper - upper).abs() < 0.2 * sd, "{found:?} {upper}");
}

#[test]
fn xval_posterior_of_pysindy() {
    // PySINDy 2.1.0 with numpyro 0.22.0 in double precision, 60 rows: SBR(num_warmup=2000, num_samples=25000,
    // mcmc_kwargs={"num_chains": 4, "seed": 1}, nuts_kwargs={"target_accept_prob": 0.99, "max_tree_depth": 12}).fit(X, y).
    let coefficients: [Nuts; 6] = [
        (
            0.49958195227617846,
            0.009405063448105948,
            0.48104725,
            0.51804778,
        ),
        (
            1.196924515876193,
            0.009658324342076322,
            1.1780352,
            1.21605481,
        ),
        (
            0.056313321516960294,
            0.006665109364882201,
            0.04318876,
            0.06930313,
        ),
        (
            0.005501222525856129,
            0.012053632419521305,
            -0.01747371,
            0.03099853,
        ),
        (
            -0.08000710939644701,
            0.0018518247163324358,
            -0.08364114,
            -0.07636145,
        ),
        (
            3.0902826379007067,
            0.06642667829728036,
            2.95922991,
            3.22138137,
        ),
    ];
    let logarithms = [
        (-1.100976448457067, 0.816897765447702),
        (1.8703530738375373, 0.7413162409438692),
        (-3.335882765372008, 0.09785348158417718),
    ];
    let found = long(1).sample(&[reference()]).unwrap();
    assert_eq!((found.outcome, found.warning()), (Outcome::Converged, None));
    let target = &found.targets[0];
    for (marginal, nuts) in target.marginals.iter().zip(coefficients) {
        assert_same_as_nuts(marginal, nuts);
    }
    for (draws, (mean, sd)) in found.scales.iter().zip(logarithms) {
        let own = of_logarithms(draws);
        // As for the coefficients.
        assert!((own.0 - mean).abs() < 0.05 * sd, "{own:?} {mean}");
        assert!((own.1 / sd - 1.0).abs() < 0.05, "{own:?} {sd}");
    }
    assert_eq!(target.selected, [true, true, true, false, true, true]);
}

#[test]
fn prop_scaled_draws_do_not_depend_on_units() {
    // Factors of 2 leave no rounding, so that even the random walk is the same.
    let (theta, y) = random_rows(2, 100, &[1.0, 0.0, 0.4], 0.5, 0.2);
    let units = [1024.0, 0.125, 4.0];
    let other = DMatrix::from_fn(100, 3, |i, j| theta[(i, j)] * units[j]);
    let settings = Horseshoe::new(7).draws(50).unwrap();
    let a = settings.sample(&[of_rows(&theta, &y)]).unwrap();
    let b = settings.sample(&[of_rows(&other, &(&y * 8.0))]).unwrap();
    for j in 0..3 {
        let (a, b) = (a.targets[0].draws.row(j), b.targets[0].draws.row(j));
        assert_eq!(a * (8.0 / units[j]), b);
    }
    assert_eq!(a.targets[0].shrinkage, b.targets[0].shrinkage);
    assert_eq!(8.0 * a.noise.mean, b.noise.mean);
}

#[test]
fn prop_the_order_of_columns_changes_no_distribution() {
    let gram = reference();
    let order = [3, 5, 0, 2, 4, 1];
    let mut other = gram.clone();
    other.xtx = DMatrix::from_fn(6, 6, |i, j| gram.xtx[(order[i], order[j])]);
    other.xty = DVector::from_fn(6, |i, _| gram.xty[order[i]]);
    let [a, b] =
        [&gram, &other].map(|g| Horseshoe::new(5).sample(std::slice::from_ref(g)).unwrap());
    for (i, j) in order.into_iter().enumerate() {
        let (a, b) = (a.targets[0].marginals[j], b.targets[0].marginals[i]);
        // Five standard errors of the difference of two means of 4000 draws worth at least 2000: 5 √(2/2000) = 0.16.
        assert!((a.mean - b.mean).abs() < 0.16 * a.sd, "{j}: {a:?} {b:?}");
    }
}

#[test]
fn prop_several_targets_are_one_whose_statistics_are_blocks() {
    // Rows of all targets below one another, with columns for each target, are one regression with the same scales.
    let (theta, y) = random_rows(8, 15, &[1.0, 0.3], 0.5, 0.5);
    let (other_theta, other_y) = random_rows(9, 12, &[0.0, -0.8, 0.2], 0.5, 0.5);
    let parts = [of_rows(&theta, &y), of_rows(&other_theta, &other_y)];
    let mut whole = Gram::zeros(5);
    whole.xtx.view_mut((0, 0), (2, 2)).copy_from(&parts[0].xtx);
    whole.xtx.view_mut((2, 2), (3, 3)).copy_from(&parts[1].xtx);
    whole.xty.rows_mut(0, 2).copy_from(&parts[0].xty);
    whole.xty.rows_mut(2, 3).copy_from(&parts[1].xty);
    whole.yty = parts[0].yty + parts[1].yty;
    whole.rows = 27;
    let (a, b) = (
        long(4).sample(&parts).unwrap(),
        long(5).sample(&[whole]).unwrap(),
    );
    let each = a.targets.iter().flat_map(|t| &t.marginals);
    for (a, b) in each.zip(&b.targets[0].marginals) {
        // Five standard errors of the difference of two means of 20 000 draws worth at least 5000: 5 √(2/5000).
        assert!((a.mean - b.mean).abs() < 0.1 * b.sd, "{a:?} {b:?}");
        assert!((a.sd / b.sd - 1.0).abs() < 0.1, "{a:?} {b:?}");
    }
    for (a, b) in a.scales.iter().zip(&b.scales) {
        let (a, b) = (of_logarithms(a), of_logarithms(b));
        // As above.
        assert!((a.0 - b.0).abs() < 0.1 * b.1, "{a:?} {b:?}");
    }
}

#[test]
fn prop_draws_depend_on_the_seed_and_not_on_threads() {
    let settings = Horseshoe::new(11).warm_up(20).draws(30).unwrap();
    let with = |threads: usize, settings: &Horseshoe| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| settings.sample(&[reference()]).unwrap())
    };
    let (one, three) = (with(1, &settings), with(3, &settings));
    assert_eq!(one.targets[0].draws, three.targets[0].draws);
    assert_eq!(one.scales, three.scales);
    let other = Horseshoe {
        seed: 12,
        ..settings
    };
    assert_ne!(with(1, &other).scales, one.scales);
}

#[test]
fn prop_data_without_noise_give_their_coefficients() {
    let (theta, y) = random_rows(4, 50, &[1.0, 0.0, -2.0, 0.1], 0.4, 0.0);
    let gram = of_rows(&theta, &y);
    let found = Horseshoe::new(1)
        .sample(std::slice::from_ref(&gram))
        .unwrap();
    let sparse = found.targets[0].sparse();
    for (value, truth) in sparse.iter().zip([1.0, 0.0, -2.0, 0.1]) {
        // Half of the digits: squares are all that the sums hold.
        assert!((value - truth).abs() < 1e-6, "{sparse}");
    }
    assert_eq!(
        found.fit(0, &gram).unwrap().support,
        [true, false, true, true]
    );
    // A target of zeros has no terms.
    let fit = Horseshoe::new(1)
        .fit(&of_rows(&theta, &DVector::zeros(50)))
        .unwrap();
    assert_eq!((fit.terms(), fit.outcome), (0, Outcome::Empty));
}

#[test]
fn prop_few_draws_are_an_outcome_with_a_warning() {
    let found = Horseshoe::new(1)
        .warm_up(0)
        .draws(3)
        .unwrap()
        .sample(&[reference()])
        .unwrap();
    assert_eq!(found.outcome, Outcome::IterationLimit);
    assert!(found.warning().unwrap().contains("have not converged"));
    let fit = Horseshoe::new(1)
        .draws(20)
        .unwrap()
        .fit(&reference())
        .unwrap();
    assert_eq!(fit.outcome, Outcome::IterationLimit);
}

#[test]
fn prop_dependent_columns_are_shared_and_selected_by_nobody() {
    // The same column twice: which of the two holds the term is not to be known.
    let (theta, _) = random_rows(5, 100, &[0.0, 0.0], 0.0, 0.0);
    let twice = DMatrix::from_fn(100, 3, |i, j| theta[(i, j / 2)]);
    let y = DVector::from_fn(100, |i, _| {
        2.0 * theta[(i, 0)] + 0.1 * (i as f64 * i as f64).cos()
    });
    let found = Horseshoe::new(1).sample(&[of_rows(&twice, &y)]).unwrap();
    let target = &found.targets[0];
    assert_eq!(target.selected, [false; 3]);
    let sums = target.draws.row(0) + target.draws.row(1);
    // Their sum is known to the standard error, 0.07/√(100/3).
    assert!(sums.iter().all(|s| (s - 2.0).abs() < 0.1));
}

#[test]
fn prop_settings_and_statistics_that_do_not_fit_are_refused() {
    assert!(
        Prior::new(0.0, 4.0, 2.0, 1.0).is_err() && Prior::new(0.1, 4.0, 2.0, f64::NAN).is_err()
    );
    let settings = Horseshoe::new(1);
    assert!(
        settings.chains(0).is_err() && settings.draws(0).is_err() && settings.level(1.0).is_err()
    );
    assert!(settings.sample(&[]).is_err() && settings.sample(&[Gram::zeros(2)]).is_err());
    let found = settings.draws(4).unwrap().sample(&[reference()]).unwrap();
    assert!(found.fit(1, &reference()).is_err() && found.fit(0, &Gram::zeros(2)).is_err());
}

#[test]
fn prop_terms_make_a_model() {
    let library = Library::parse(&["1", "x", "x^2"]).unwrap();
    let (theta, y) = random_rows(6, 80, &[0.0, -1.5, 0.0], 0.0, 0.1);
    let found = Horseshoe::new(2).sample(&[of_rows(&theta, &y)]).unwrap();
    let terms = found.terms(0, &library).unwrap();
    let [term] = &terms[..] else {
        panic!("{terms:?}");
    };
    let sd = found.targets[0].marginals[1].sd;
    assert_eq!(term.std_error, Some(sd));
    // Uniform noise of ±0.1 over 80 rows of a column of variance 1/3: 0.058/√(80/3) = 0.011.
    assert!(
        (term.coefficient + 1.5).abs() < 0.05 && sd > 0.005 && sd < 0.02,
        "{term:?}"
    );
    assert!(Model::new(Time::Continuous, &["x"], &[], vec![terms]).is_ok());
    assert!(found.terms(0, &Library::parse(&["x"]).unwrap()).is_err());
}

#[test]
fn prop_terms_of_noise_are_not_selected_and_true_ones_are() {
    // Standardised, the weakest term has six standard errors.
    let mut truth = vec![0.0; 10];
    (truth[1], truth[4], truth[7]) = (1.0, -0.5, 0.2);
    let mut wrong = 0;
    for seed in 0..10 {
        let (theta, y) = random_rows(seed, 200, &truth, 0.5, 0.5);
        let found = Horseshoe::new(1).sample(&[of_rows(&theta, &y)]).unwrap();
        assert_eq!(found.warning(), None);
        for (selected, truth) in found.targets[0].selected.iter().zip(&truth) {
            assert!(*selected || *truth == 0.0, "{seed}");
            wrong += usize::from(*selected && *truth == 0.0);
        }
    }
    // Intervals without shrinkage would miss 0 in 5 % of 70 cases; shrinkage makes fewer.
    assert!(wrong <= 3, "{wrong}");
}
