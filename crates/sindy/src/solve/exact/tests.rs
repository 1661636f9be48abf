use super::*;
use crate::statistics::normal::tests::random_gram;
use proptest::prelude::*;

/// Coefficients with a few terms that matter, and the rest zero.
fn truth(p: usize) -> Vec<f64> {
    (0..p)
        .map(|j| {
            if j % 4 == 1 {
                1.0 / (1 + j) as f64
            } else {
                0.0
            }
        })
        .collect()
}

/// Least squares with signs, by coordinate descent.
fn descend(gram: &Gram, signs: &[Sign]) -> nalgebra::DVector<f64> {
    let p = gram.xty.len();
    let mut xi = nalgebra::DVector::zeros(p);
    for _ in 0..5000 {
        for (j, sign) in signs.iter().enumerate() {
            let slope = gram.xty[j] - (gram.xtx.row(j) * &xi)[0];
            let next = xi[j] + slope / gram.xtx[(j, j)];
            xi[j] = if sign.allows(next) { next } else { 0.0 };
        }
    }
    xi
}

/// The smallest residual sum of every size, by trying all subsets that keep the signs.
fn brute_force(gram: &Gram, signs: &[Sign]) -> Vec<f64> {
    let p = gram.xty.len();
    let mut best = vec![f64::INFINITY; p + 1];
    for mask in 0..1usize << p {
        let support: Vec<bool> = (0..p).map(|j| mask >> j & 1 == 1).collect();
        let xi = crate::statistics::regression::least_squares(gram, &support);
        let size = mask.count_ones() as usize;
        if sign::broken(signs, xi.as_slice()).next().is_some() {
            continue;
        }
        best[size] = best[size].min(gram.residual_sum(&xi));
    }
    best
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn prop_every_size_is_that_of_trying_all_subsets(
        seed in 0u64..10_000, p in 1usize..=10, mix in -1.5..1.5f64, noise in 0.0..1.0f64,
    ) {
        let gram = random_gram(seed, 40, &truth(p), mix, noise);
        let found = BestSubset::new().solve(&gram).unwrap();
        prop_assert_eq!(found.outcome, Outcome::Optimal);
        let all = brute_force(&gram, &[]);
        for (s, subset) in found.sizes.iter().enumerate() {
            prop_assert_eq!(subset.fit.terms(), s);
            prop_assert_eq!(subset.gap(), 0.0);
            // Both residuals are differences of numbers of order yᵀy, with rounding of the same order.
            prop_assert!(
                (subset.fit.residual_sum - all[s]).abs() < 1e-12 * gram.yty.max(1e-300),
                "size {} of {}: {} against {}", s, p, subset.fit.residual_sum, all[s]
            );
        }
    }

    #[test]
    fn prop_with_signs_every_size_is_that_of_trying_all_subsets_that_keep_them(
        seed in 0u64..10_000, p in 1usize..=9, mix in -1.5..1.5f64, noise in 0.0..1.0f64, given in 0usize..19_683,
    ) {
        let gram = random_gram(seed, 40, &truth(p), mix, noise);
        let all = [Sign::Any, Sign::Positive, Sign::Negative];
        let signs: Vec<Sign> = (0..p).map(|j| all[given / 3usize.pow(j as u32) % 3]).collect();
        let found = BestSubset::new().solve_signed(&gram, &signs).unwrap();
        prop_assert_eq!(found.outcome, Outcome::Optimal);
        let slack = 1e-12 * gram.yty.max(1e-300);
        let mut left = f64::INFINITY;
        for (s, least) in brute_force(&gram, &signs).into_iter().enumerate() {
            let own = found.sizes.iter().find(|f| f.fit.terms() == s);
            if let Some(own) = own {
                prop_assert!(sign::broken(&signs, own.fit.coefficients.as_slice()).next().is_none());
                prop_assert!((own.fit.residual_sum - least).abs() < slack);
            } else {
                // None keeps the signs, or a smaller one is as good.
                prop_assert!(least >= left - slack, "size {s}: {least} against {left}");
            }
            left = left.min(least);
        }
        // What the largest leaves is what least squares with signs leaves, which coordinate descent finds in another way: its
        // steps shrink by a factor each round, and 5000 rounds leave 1e-6 where columns are as nearly parallel as here.
        let last = found.sizes.iter().map(|f| f.fit.residual_sum).fold(f64::INFINITY, f64::min);
        let descended = gram.residual_sum(&descend(&gram, &signs));
        prop_assert!((descended - last).abs() < 1e-6 * gram.yty, "{descended} {last}");
    }

    #[test]
    fn prop_bounds_hold_when_the_search_is_cut_short(
        seed in 0u64..1000, limit in 1u64..40, tolerance in 0.0..0.5f64, max in 1usize..9,
    ) {
        let gram = random_gram(seed, 40, &truth(9), 0.8, 1.0);
        let found = BestSubset::new()
            .node_limit(limit)
            .max_size(max)
            .tolerance(tolerance)
            .unwrap()
            .solve(&gram)
            .unwrap();
        let all = brute_force(&gram, &[]);
        prop_assert_eq!(found.sizes.len(), max + 1);
        for (s, subset) in found.sizes.iter().enumerate() {
            // Rounding of yᵀy on either side.
            let slack = 1e-12 * gram.yty;
            prop_assert!(subset.lower_bound <= all[s] + slack, "size {}", s);
            prop_assert!(subset.fit.residual_sum >= all[s] - slack);
            prop_assert!((0.0..=1.0).contains(&subset.gap()));
            match subset.fit.outcome {
                Outcome::Optimal => prop_assert!(subset.fit.residual_sum <= all[s] + slack),
                Outcome::WithinTolerance => {
                    prop_assert!(subset.gap() <= tolerance + 1e-9);
                }
                other => prop_assert_eq!(other, Outcome::NodeLimit),
            }
        }
    }
}

#[test]
fn analytic_orthogonal_columns_are_ranked_by_their_share() {
    // An identity Gram matrix: the best subset of size s are the s largest |b|.
    let p = 40;
    let b: Vec<f64> = (0..p).map(|j| ((j * 17 % 41) as f64) / 100.0).collect();
    let gram = Gram {
        xtx: nalgebra::DMatrix::identity(p, p),
        xty: nalgebra::DVector::from_vec(b.clone()),
        yty: 10.0,
        rows: 100,
        ..Gram::zeros(p)
    };
    let found = BestSubset::new().solve(&gram).unwrap();
    let mut sorted = b.clone();
    sorted.sort_by(|x, y| y.total_cmp(x));
    for (s, subset) in found.sizes.iter().enumerate() {
        let residual = 10.0 - sorted[..s].iter().map(|v| v * v).sum::<f64>();
        // Sums of 40 numbers below one.
        assert!((subset.fit.residual_sum - residual).abs() < 1e-13);
    }
    // The bound on several removals is exact here: the root alone proves everything.
    assert_eq!((found.outcome, found.nodes), (Outcome::Optimal, 1));
}

#[test]
fn prop_the_caller_can_stop_the_search() {
    // Correlated columns and nothing but noise: the hard case.
    let gram = random_gram(4, 60, &[0.0; 26], 0.9, 1.0);
    let mut asked = 0;
    let found = BestSubset::new()
        .solve_while(&gram, &mut || {
            asked += 1;
            asked < 3
        })
        .unwrap();
    assert_eq!((found.outcome, found.nodes), (Outcome::Stopped, 3 * 1024));
    let worst = found.sizes.iter().map(Subset::gap).fold(0.0, f64::max);
    assert!(worst > 0.0 && worst <= 1.0, "{worst}");
    assert_eq!(found.sizes[26].gap(), 0.0);
}

#[test]
fn prop_zero_and_repeated_columns_do_no_harm() {
    let (theta, y) =
        crate::statistics::normal::tests::random_rows(3, 500, &[1.0, 0.0, 0.5], 0.3, 0.1);
    // Column 3 is column 0 again, column 4 is zero.
    let wide = nalgebra::DMatrix::from_fn(500, 5, |i, j| match j {
        3 => theta[(i, 0)] * 2.0,
        4 => 0.0,
        j => theta[(i, j)],
    });
    let gram = crate::statistics::normal::tests::of_rows(&wide, &y);
    let found = BestSubset::new().solve(&gram).unwrap();
    assert_eq!(found.sizes.len(), 5);
    assert!(found.ridge > 0.0 && found.outcome == Outcome::Optimal);
    let best = brute_force(&gram, &[]);
    for s in 0..4 {
        // The ridge of 2e-13 moves a residual by less than its square coefficients, which are about 1.
        assert!((found.sizes[s].fit.residual_sum - best[s]).abs() < 1e-11 * gram.yty);
    }
    let chosen = found.choose(&gram, Criterion::Bic, None).unwrap();
    assert_eq!(chosen.fit.terms(), 2);
    assert!(chosen.fit.support[2] && chosen.fit.support[0] != chosen.fit.support[3]);
}

#[test]
fn prop_bad_input_is_refused() {
    assert!(BestSubset::new().solve(&Gram::zeros(3)).is_err());
    assert!(BestSubset::new().tolerance(1.0).is_err());
    assert!(BestSubset::new().tolerance(f64::NAN).is_err());
    let mut gram = random_gram(1, 300, &[1.0; 129], 0.0, 0.1);
    assert!(
        BestSubset::new()
            .solve(&gram)
            .unwrap_err()
            .to_string()
            .contains("128")
    );
    // No column moves: only the empty subset is left.
    gram.xtx.fill(0.0);
    gram.xty.fill(0.0);
    let found = BestSubset::new().solve(&gram).unwrap();
    assert_eq!((found.sizes.len(), found.outcome), (1, Outcome::Optimal));
}

#[test]
fn prop_ill_conditioned_libraries_are_searched_exactly() {
    // Powers of x on [0.9, 1.1]: condition of the scaled library about 1e6.
    let n = 400;
    let x: Vec<f64> = (0..n)
        .map(|i| 0.8 + 0.4 * f64::from(i) / f64::from(n))
        .collect();
    let theta = nalgebra::DMatrix::from_fn(n as usize, 5, |i, j| x[i].powi(j as i32));
    let y = nalgebra::DVector::from_fn(n as usize, |i, _| {
        x[i] - 2.0 * x[i].powi(3) + 1e-3 * (97.0 * x[i]).sin()
    });
    let gram = crate::statistics::normal::tests::of_rows(&theta, &y);
    let condition = {
        let svd = crate::statistics::normal::Normal::new(&gram)
            .unwrap()
            .g
            .singular_values();
        (svd.max() / svd.min()).sqrt()
    };
    assert!((1e5..5e6).contains(&condition), "{condition:e}");
    let found = BestSubset::new().solve(&gram).unwrap();
    assert_eq!((found.outcome, found.ridge), (Outcome::Optimal, 0.0));
    assert_eq!(
        found.sizes[2].fit.support,
        [false, true, false, true, false]
    );
    // Against a singular value decomposition of the columns themselves: the Gram matrix of the two
    // terms has a condition of about 1e3, so rounding is far below the tolerance.
    let two = theta.select_columns(&[1, 3]);
    let direct = two.svd(true, true).solve(&y, 0.0).unwrap();
    assert!((found.sizes[2].fit.coefficients[1] - direct[0]).abs() < 1e-9);
    assert!((found.sizes[2].fit.coefficients[3] - direct[1]).abs() < 1e-9);
}
