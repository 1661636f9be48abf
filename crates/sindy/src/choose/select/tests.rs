use super::*;
use crate::{Grid, Library, Samples};
use rand::RngExt;

/// Groups with y = 0.7 x - 0.4 x u + noise, over seven terms.
fn groups(seed: u64, count: usize, noise: f64) -> Vec<Gram> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut samples = Samples::new(&["x", "u", "y"]);
    for _ in 0..count {
        let mut draw = |n: usize, a: f64| -> Vec<f64> {
            (0..n).map(|_| a * rng.random_range(-1.0..1.0)).collect()
        };
        let (x, u, e) = (draw(200, 1.0), draw(200, 1.0), draw(200, noise));
        let y = (0..200)
            .map(|i| 0.7 * x[i] - 0.4 * x[i] * u[i] + e[i])
            .collect();
        samples.push_group(vec![x, u, y]).unwrap();
    }
    let library = Library::parse(&["1", "x", "u", "x^2", "x*u", "u^2", "x^3"]).unwrap();
    Gram::accumulate(&library, "y", &samples).unwrap()
}

const TRUTH: [bool; 7] = [false, true, false, false, true, false, false];

#[test]
fn analytic_every_family_finds_the_two_terms_by_every_rule() {
    let grams = groups(1, 8, 0.05);
    let bic = Rule::Criterion {
        criterion: Criterion::Bic,
        effective_rows: None,
    };
    for rule in [Rule::LeftOut, bic] {
        let found = select(
            &grams,
            &sr3_points(&Grid::default().points().unwrap()).unwrap(),
            rule,
        )
        .unwrap();
        assert_eq!(found.fit().support, TRUTH, "{}", found.reason);
        let thresholds = Grid::default().thresholds;
        let family = stlsq_thresholds(&thresholds, 0.0).unwrap();
        let found = select(&grams, &family, rule).unwrap();
        assert_eq!(found.fit().support, TRUTH, "{}", found.reason);
        let found = select(&grams, &best_subsets(None), rule).unwrap();
        assert_eq!(found.fit().support, TRUTH, "{}", found.reason);
        assert_eq!(found.members.len(), 8);
        assert_eq!(found.member().score.is_some(), rule == bic);
    }
}

#[test]
fn analytic_left_out_error_is_that_of_a_fit_without_the_group() {
    let grams = groups(2, 4, 0.3);
    let all = |gram: &Gram| {
        Ok(vec![Fit::on_support(
            gram,
            vec![true; 7],
            crate::Outcome::Converged,
            1,
        )])
    };
    let found = select(&grams, &all, Rule::LeftOut).unwrap();
    let by_hand: Vec<f64> = (0..4)
        .map(|k| {
            let rest: Vec<Gram> = (0..4)
                .filter(|g| *g != k)
                .map(|g| grams[g].clone())
                .collect();
            let xi = crate::statistics::regression::least_squares(&Gram::total(&rest), &[true; 7]);
            grams[k].residual_sum(&xi) / 200.0
        })
        .collect();
    let mean = by_hand.iter().sum::<f64>() / 4.0;
    let left_out = found.member().left_out.unwrap();
    // Total minus a part and the sum of the other parts differ by rounding.
    assert!((left_out.rmse - mean.sqrt()).abs() < 1e-12);
    // 0.3 times a uniform draw has 0.1732 rms; seven coefficients of 600 rows add a hundredth to it.
    assert!((left_out.rmse - 0.174).abs() < 0.01, "{left_out:?}");
    assert!(found.member().training_rmse < left_out.rmse);
}

#[test]
fn prop_dealt_folds_hold_every_group_once_and_follow_the_seed() {
    let grams = groups(3, 11, 0.1);
    let (a, b, c) = (
        deal(&grams, 4, 1).unwrap(),
        deal(&grams, 4, 1).unwrap(),
        deal(&grams, 4, 2).unwrap(),
    );
    assert!(a == b && a != c);
    let mut rows: Vec<usize> = a.iter().map(|g| g.rows / 200).collect();
    rows.sort_unstable();
    assert_eq!(rows, [2, 3, 3, 3]);
    let (whole, dealt) = (Gram::total(&grams), Gram::total(&a));
    // The same sums in another order.
    assert!((&whole.xtx - &dealt.xtx).amax() < 1e-9 * whole.xtx.amax());
    assert!(deal(&grams, 1, 1).is_err() && deal(&grams, 12, 1).is_err());
}

#[test]
fn prop_bad_families_and_single_groups_are_refused() {
    let grams = groups(4, 3, 0.1);
    let none = |_: &Gram| Ok(Vec::new());
    assert!(select(&grams, &none, Rule::LeftOut).is_err());
    let changing = |gram: &Gram| {
        let fit = Fit::on_support(gram, vec![true; 7], crate::Outcome::Converged, 1);
        Ok(vec![fit; gram.rows / 200])
    };
    let error = select(&grams, &changing, Rule::LeftOut).unwrap_err();
    assert!(error.to_string().contains("left out"), "{error}");
    let one = &grams[..1];
    let error = select(one, &best_subsets(None), Rule::LeftOut).unwrap_err();
    assert!(error.to_string().contains("groups"), "{error}");
    let aicc = Rule::Criterion {
        criterion: Criterion::Aicc,
        effective_rows: None,
    };
    let found = select(one, &best_subsets(None), aicc).unwrap();
    assert!(found.member().left_out.is_none());
    assert!(select(&[Gram::zeros(3)], &best_subsets(None), aicc).is_err());
    assert!(stlsq_thresholds(&[], 0.0).is_err());
}

#[test]
fn prop_folds_are_an_upper_limit() {
    let grams = groups(5, 7, 0.1);
    let total = Gram::total(&grams);
    for folds in [2, 3, 7, 20] {
        let found = folded(&grams, folds);
        assert_eq!(found.len(), folds.min(7));
        let sum = Gram::total(&found);
        // Sums of the same seven numbers in another order.
        assert!((&sum.xtx - &total.xtx).amax() < 1e-9 * total.xtx.amax());
        assert_eq!((sum.rows, sum.skipped), (total.rows, total.skipped));
    }
    let mut with_empty = grams;
    with_empty.insert(1, Gram::zeros(7));
    assert_eq!(folded(&with_empty, 20).len(), 7);
}
