use super::*;
use crate::statistics::normal::tests::{of_rows, random_rows};
use crate::statistics::regression::cluster_errors;
use crate::{Criterion, Library, Samples, Stepwise, Stlsq, solve::stepwise::Direction};

/// Statistics of single rows of `n` random rows with two terms that matter and three that do not.
fn rows_of(seed: u64, n: usize) -> Vec<Gram> {
    let (theta, y) = random_rows(seed, n, &[1.0, 0.0, -0.5, 0.0, 0.0], 0.3, 0.5);
    (0..n)
        .map(|i| {
            of_rows(
                &theta.rows(i, 1).into_owned(),
                &DVector::from_element(1, y[i]),
            )
        })
        .collect()
}

fn bic() -> Stepwise {
    Stepwise::new(Direction::Both, Criterion::Bic)
}

#[test]
fn analytic_bootstrap_spread_is_that_of_the_sandwich() {
    let parts = rows_of(1, 400);
    let total = Gram::total(&parts);
    let full = |g: &Gram| Ok(Fit::on_support(g, vec![true; 5], Outcome::Converged, 1));
    let ensemble = Ensemble::new(2000, 7).unwrap().run(&parts, &full).unwrap();
    let xi = crate::statistics::regression::least_squares(&total, &[true; 5]);
    let se = cluster_errors(&parts, &xi, &[true; 5]).unwrap();
    for j in 0..5 {
        let row = ensemble.coefficients.row(j);
        let sd = row.variance().sqrt();
        // 2000 replicates give a standard deviation to 1/√4000 = 1.6 %; the sandwich is its limit for many
        // rows, to about 1 % with 400.
        assert!((sd / se[j] - 1.0).abs() < 0.08, "{} {}", sd, se[j]);
        // Ends of a normal 95 % interval, known to about 5 % of its half width.
        let half = 0.5 * (ensemble.upper[j] - ensemble.lower[j]);
        assert!((half / (1.96 * se[j]) - 1.0).abs() < 0.12);
        assert!((ensemble.mean[j] - xi[j]).abs() < 0.2 * se[j]);
    }
}

#[test]
fn prop_terms_that_matter_are_always_kept_and_others_rarely() {
    let parts = rows_of(2, 300);
    let ensemble = Ensemble::new(200, 3).unwrap().run(&parts, &bic()).unwrap();
    for j in [0, 2] {
        assert_eq!(ensemble.inclusion[j], 1.0);
    }
    for j in [1, 3, 4] {
        // BIC keeps an idle term of 300 rows in 1.7 % of data sets; the bootstrap doubles its variance,
        // which makes it about 9 % on average; a data set that favours one may double that again.
        assert!(ensemble.inclusion[j] < 0.5, "{}", ensemble.inclusion);
        assert_eq!(ensemble.median[j], 0.0);
    }
    let total = Gram::total(&parts);
    let fit = ensemble.refit(&total, 0.9).unwrap();
    assert_eq!(fit.support, [true, false, true, false, false]);
    let none = ensemble.refit(&total, 1.1).unwrap();
    assert_eq!((none.terms(), none.outcome), (0, Outcome::Empty));
    assert!(ensemble.refit(&Gram::zeros(2), 0.5).is_err());
}

#[test]
fn prop_results_depend_on_the_seed_and_not_on_the_threads() {
    let parts = rows_of(4, 60);
    let run = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let ensemble = Ensemble::new(40, seed).unwrap().omit(2);
        pool.install(|| ensemble.run(&parts, &bic()).unwrap())
    };
    assert_eq!(run(1, 5), run(3, 5));
    assert_ne!(run(1, 5).coefficients, run(1, 6).coefficients);
}

#[test]
fn analytic_library_bagging_offers_terms_equally_and_fits_without_the_omitted() {
    let parts = rows_of(6, 200);
    let total = Gram::total(&parts);
    let ensemble = Ensemble::new(1000, 1)
        .unwrap()
        .resample(false)
        .omit(1)
        .run(&parts[..], &Stlsq::new(0.0, 0.0).unwrap())
        .unwrap();
    assert_eq!(ensemble.offered.iter().sum::<usize>(), 4000);
    for r in 0..1000 {
        let support: Vec<bool> = ensemble
            .coefficients
            .column(r)
            .iter()
            .map(|v| *v != 0.0)
            .collect();
        let expected = crate::statistics::regression::least_squares(&total, &support);
        // The sums over parts are taken in the same order; rounding of a well-conditioned solve.
        assert!((ensemble.coefficients.column(r) - expected).amax() < 1e-12);
        assert_eq!(support.iter().filter(|s| !**s).count(), 1);
    }
    // Left out 200 times each, binomial with a standard deviation of 13: five of them.
    assert!(ensemble.offered.iter().all(|n| n.abs_diff(800) < 65));
    // A term counts only where it was offered.
    assert_eq!(ensemble.inclusion, DVector::from_element(5, 1.0));
}

#[test]
fn xval_quantiles_of_numpy() {
    // NumPy 2.4: np.percentile([-3, 0.5, 0.7, 2, 10, 11], [2.5, 50, 97.5]).
    let sorted = [-3.0, 0.5, 0.7, 2.0, 10.0, 11.0];
    for (q, expected) in [(0.025, -2.5625), (0.5, 1.35), (0.975, 10.875)] {
        // One interpolation: rounding.
        assert!((quantile(&sorted, q) - expected).abs() < 1e-13);
    }
    assert_eq!(quantile(&[4.0], 0.9), 4.0);
}

#[test]
fn analytic_blocks_have_the_same_total_and_never_span_groups() {
    let mut samples = Samples::new(&["x", "y"]);
    for n in [25_i32, 0, 7, 10] {
        let x: Vec<f64> = (0..n).map(|i| f64::from(i + n)).collect();
        samples.push_group(vec![x.clone(), x]).unwrap();
    }
    let library = Library::parse(&["1", "x"]).unwrap();
    let blocks = Blocks::new(&samples, 10).unwrap();
    let cut = Gram::accumulate(&library, "y", &blocks).unwrap();
    let rows: Vec<usize> = cut.iter().map(|g| g.rows).collect();
    assert_eq!(rows, [10, 10, 5, 7, 10]);
    let groups: Vec<usize> = (0..5).map(|b| blocks.group_of(b)).collect();
    assert_eq!(groups, [0, 0, 0, 2, 3]);
    let whole = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
    // Sums of integers below 2^53: exact.
    assert_eq!(Gram::total(&cut), whole);
    assert!(Blocks::new(&samples, 0).is_err());
}

#[test]
fn prop_bad_input_is_refused() {
    let parts = rows_of(9, 10);
    let solver = bic();
    let ensemble = Ensemble::new(10, 0).unwrap();
    assert!(Ensemble::new(0, 0).is_err());
    assert!(ensemble.level(1.0).is_err() && ensemble.level(f64::NAN).is_err());
    assert!(ensemble.run(&[], &solver).is_err());
    assert!(ensemble.run(&parts[..1], &solver).is_err());
    assert!(ensemble.omit(5).run(&parts, &solver).is_err());
    let mut mixed = parts.clone();
    mixed[3] = Gram {
        rows: 1,
        ..Gram::zeros(2)
    };
    assert!(ensemble.run(&mixed, &solver).is_err());
    mixed[3].xty = DVector::from_element(5, f64::NAN);
    assert!(ensemble.run(&mixed, &solver).is_err());
    let failing = |_: &Gram| Err(SindyError::Singular { what: "a test" });
    assert!(ensemble.run(&parts, &failing).is_err());
}

#[test]
fn prop_terms_are_left_out_of_statistics_with_a_triangle_too() {
    let (theta, y) = random_rows(4, 200, &[1.0, 0.0, -0.5, 0.0, 0.0], 0.3, 0.5);
    let plain: Vec<Gram> = (0..10)
        .map(|k| {
            of_rows(
                &theta.rows(20 * k, 20).into_owned(),
                &y.rows(20 * k, 20).into_owned(),
            )
        })
        .collect();
    let with: Vec<Gram> = (0..10)
        .map(|k| {
            let rows = (
                theta.rows(20 * k, 20).into_owned(),
                y.rows(20 * k, 20).into_owned(),
            );
            let triangle = crate::statistics::tsqr::Triangle::of_rows(&rows.0, &rows.1).unwrap();
            Gram {
                triangle: Some(triangle),
                ..plain[k].clone()
            }
        })
        .collect();
    let full = |g: &Gram| {
        Ok(Fit::on_support(
            g,
            vec![true; g.xty.len()],
            Outcome::Converged,
            1,
        ))
    };
    let ensemble = Ensemble::new(40, 3).unwrap().omit(2);
    let (a, b) = (
        ensemble.run(&plain, &full).unwrap(),
        ensemble.run(&with, &full).unwrap(),
    );
    assert_eq!(a.offered, b.offered);
    // A condition of a few: rounding of sums of 200 rows.
    assert!((a.coefficients - b.coefficients).amax() < 1e-9);
}
