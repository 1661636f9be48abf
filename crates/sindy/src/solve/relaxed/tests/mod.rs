mod inequalities;
mod trimming;

use super::*;
use crate::statistics::normal::tests::{of_rows, random_gram, random_rows, reference};
use proptest::prelude::*;

/// Penalty, λ, weights, w and ξ.
type Case<'a> = (Penalty, f64, &'a [f64], [f64; 6], [f64; 6]);

#[test]
fn xval_weighted_penalties_of_pysindy() {
    // PySINDy 2.1.0, `SR3(reg_weight_lam, relax_coeff_nu=0.05, regularizer, tol=1e-12)`, converged after 96
    // to 1602 steps: `coef_` (w) and `coef_full_` (ξ).
    let ones: &[f64] = &[1.0; 6];
    let cases: [Case<'_>; 3] = [
        (
            Penalty::L1,
            2.0,
            ones,
            [0.2096591037251531, 0.9317953532849229, 0.0, 0.0, 0.0, 0.0],
            [
                0.3096591037251531,
                1.031795353284923,
                0.015597676319944149,
                -0.006992275013936013,
                -0.04733066531568219,
                0.045541988299976584,
            ],
        ),
        (
            Penalty::L1,
            1.0,
            &[1.0, 1.0, 4.0, 4.0, 0.2, 0.02],
            [
                0.3498198056850361,
                1.053332880663808,
                0.0,
                0.0,
                -0.05129952859369417,
                3.0549901039250167,
            ],
            [
                0.3998198056850361,
                1.103332880663808,
                0.031253156546431564,
                -0.004298555455254706,
                -0.06129952859369417,
                3.0559901039250166,
            ],
        ),
        (
            Penalty::L0,
            0.1,
            &[1.0, 1.0, 4.0, 4.0, 0.2, 1.0],
            [
                0.49849769230329616,
                1.1958350454012348,
                0.0,
                0.0,
                -0.07997528366834603,
                3.0779663856919623,
            ],
            [
                0.49849769230329616,
                1.1958350454012348,
                0.033540275452736766,
                0.002622908013566485,
                -0.07997528366834603,
                3.0779663856919623,
            ],
        ),
    ];
    let gram = reference();
    for (penalty, lambda, weights, sparse, dense) in cases {
        let s = Relaxed::new(penalty, lambda, 0.05)
            .unwrap()
            .weights(weights)
            .unwrap()
            .scaling(Scaling::None)
            .solve(&gram)
            .unwrap();
        assert_eq!(s.outcome, Outcome::Converged);
        for j in 0..6 {
            // PySINDy stops at steps of 5e-14 at a rate of about 0.98: a remaining distance of some 1e-12.
            assert!((s.sparse[j] - sparse[j]).abs() < 1e-11, "{s:?}");
            assert!((s.dense[j] - dense[j]).abs() < 1e-11, "{s:?}");
        }
    }
}

#[test]
fn xval_converged_sr3_of_pysindy_by_every_route() {
    // PySINDy 2.1.0, `SR3(reg_weight_lam=0.05, relax_coeff_nu=0.05, regularizer="L0", tol=1e-13, max_iter=100000)`
    // and the same with "L1" and 1.0: `coef_full_` (ξ); `coef_` keeps four and three terms of it.
    let l0 = [
        0.4984976923033114,
        1.1958350454012603,
        0.033540275452723374,
        0.0026229080135699297,
        -0.07997528366835227,
        3.0779663856889354,
    ];
    let l1 = [
        0.4056154407494271,
        1.1227024158047485,
        0.017719881916187966,
        0.000328456456813033,
        -0.06541072407342616,
        0.044896982379545716,
    ];
    let gram = reference();
    // Any factor with RᵀR = [G b; bᵀ c] will do: here that of Cholesky, as rows.
    let mut all = gram.xtx.clone().resize(7, 7, gram.yty);
    all.view_mut((0, 6), (6, 1)).copy_from(&gram.xty);
    all.view_mut((6, 0), (1, 6)).tr_copy_from(&gram.xty);
    let rows = all.cholesky().unwrap().l().transpose();
    let (theta, y) = (rows.columns(0, 6).into_owned(), rows.column(6).into_owned());
    let triangle = crate::statistics::tsqr::Triangle::of_rows(&theta, &y).unwrap();
    let by_triangle = triangle.to_gram(gram.rows, gram.sum_y);
    let sr3 = Sr3::new(0.05, 0.05).unwrap().scaling(Scaling::None);
    let relaxed = |penalty, lambda| {
        let relaxed = Relaxed::new(penalty, lambda, 0.05).unwrap();
        relaxed.scaling(Scaling::None).solve(&gram).unwrap()
    };
    for (s, dense, kept) in [
        (sr3.solve(&gram), l0, 0b11_0011),
        (sr3.solve(&by_triangle), l0, 0b11_0011),
        (
            sr3.path(crate::solve::sr3::Path::Relaxation, 100_000)
                .solve(&gram),
            l0,
            0b11_0011,
        ),
        (relaxed(Penalty::L0, 0.05), l0, 0b11_0011),
        (relaxed(Penalty::L1, 1.0), l1, 0b01_0011),
    ] {
        assert_eq!(s.outcome, Outcome::Converged);
        for j in 0..6 {
            // PySINDy's last step is 5e-15 at a rate of about 0.98, ours 5e-11: remaining distances of 50 steps.
            assert!((s.dense[j] - dense[j]).abs() < 5e-9, "{s:?}");
            assert_eq!(s.support[j], kept >> j & 1 == 1, "{s:?}");
        }
    }
}

#[test]
fn xval_constraints_of_pysindy() {
    // PySINDy 2.1.0, `ConstrainedSR3(..., constraint_lhs=C, constraint_rhs=d, equality_constraints=True)` with
    // relax_coeff_nu=0.05, tol=1e-13: `coef_full_` (ξ); terms that it drops are zero in `coef_`.
    let c = DMatrix::from_row_slice(
        2,
        6,
        &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0],
    );
    let cases = [
        (
            Penalty::L0,
            0.05,
            [
                0.41727209639308493,
                1.0808995145795,
                -0.04044975728975015,
                -0.01624079639206838,
                -0.06307376365320791,
                2.5827279036069153,
            ],
        ),
        (
            Penalty::L1,
            1.0,
            [
                0.4036313537787149,
                1.0469430584279245,
                -0.023471529213962457,
                -0.025513197720025083,
                -0.059745789351705075,
                2.5963686462212854,
            ],
        ),
    ];
    for (penalty, lambda, dense) in cases {
        let s = Relaxed::new(penalty, lambda, 0.05)
            .unwrap()
            .scaling(Scaling::None)
            .constraints(c.clone(), DVector::from_vec(vec![3.0, 1.0]))
            .unwrap()
            .solve(&reference())
            .unwrap();
        assert_eq!(s.outcome, Outcome::Converged);
        let kept = [true, true, false, false, penalty == Penalty::L1, true];
        assert_eq!(s.support, kept);
        for j in 0..6 {
            // As above.
            assert!((s.dense[j] - dense[j]).abs() < 1e-11, "{s:?}");
        }
    }
}

#[test]
fn analytic_equal_weights_and_l0_are_plain_sr3() {
    let gram = random_gram(2, 100, &[1.0, 0.0, -0.6, 0.0, 0.05], 0.4, 0.2);
    for (lambda, nu) in [(1e-3, 0.1), (1e-2, 1.0), (0.1, 10.0)] {
        let plain = Sr3::new(lambda, nu).unwrap().solve(&gram);
        let general = Relaxed::new(Penalty::L0, lambda, nu)
            .unwrap()
            .solve(&gram)
            .unwrap();
        assert_eq!(plain.support, general.support);
        // The same system through two routes: rounding.
        assert!((&plain.dense - &general.dense).amax() < 1e-12);
        assert!((&plain.refit - &general.refit).amax() < 1e-12);
        assert!((plain.objective - general.objective).abs() < 1e-12);
    }
}

#[test]
fn analytic_a_constraint_is_the_same_as_one_column_less() {
    // ξ₀ + ξ₂ = 0.5 by substitution: y - 0.5 x₀ = (x₂ - x₀) ξ₂ + x₁ ξ₁.
    let (theta, y) = random_rows(3, 80, &[1.0, 0.3, -0.4], 0.5, 0.2);
    let gram = of_rows(&theta, &y);
    let c = DMatrix::from_row_slice(2, 3, &[1.0, 0.0, 1.0, 2.0, 0.0, 2.0]);
    // The second row repeats the first.
    let relaxed = Relaxed::new(Penalty::L1, 0.0, 1.0)
        .unwrap()
        .constraints(c.clone(), DVector::from_vec(vec![0.5, 1.0]))
        .unwrap();
    let s = relaxed.solve(&gram).unwrap();
    let less = DMatrix::from_fn(80, 2, |i, j| match j {
        0 => theta[(i, 1)],
        _ => theta[(i, 2)] - theta[(i, 0)],
    });
    let rest = &y - theta.column(0) * 0.5;
    let direct = less.svd(true, true).solve(&rest, 0.0).unwrap();
    let expected = DVector::from_vec(vec![0.5 - direct[1], direct[0], direct[1]]);
    // Well-conditioned systems of two unknowns: rounding.
    assert!((&s.refit - &expected).amax() < 1e-12, "{s:?}");
    assert!((&s.dense - &expected).amax() < 1e-12);
    // A penalty that leaves x₁ alone cannot meet ξ₀ + ξ₂ = 0.5.
    let none = Relaxed::new(Penalty::L1, 100.0, 1e-6)
        .unwrap()
        .weights(&[1e9, 0.0, 1e9])
        .unwrap()
        .constraints(c, DVector::from_vec(vec![0.5, 1.0]))
        .unwrap()
        .solve(&gram)
        .unwrap();
    assert_eq!(none.support, [false, true, false]);
    assert_eq!(none.outcome, Outcome::Infeasible);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn prop_l1_is_a_minimum_and_keeps_its_constraint(
        seed in 0u64..1000, lambda in 0.0..0.5f64, nu in 0.01..10.0f64, mix in -1.0..1.0f64,
    ) {
        let gram = random_gram(seed, 60, &[0.5, 0.0, -0.5, 0.2], mix, 0.3);
        let c = DMatrix::from_row_slice(1, 4, &[1.0, 0.0, 1.0, 0.0]);
        let relaxed = Relaxed::new(Penalty::L1, lambda, nu)
            .unwrap()
            .scaling(Scaling::None)
            .constraints(c, DVector::zeros(1))
            .unwrap();
        let s = relaxed.solve(&gram).unwrap();
        prop_assert_eq!(s.outcome, Outcome::Converged);
        prop_assert!((s.dense[0] + s.dense[2]).abs() < 1e-12);
        let at = |xi: &DVector<f64>| {
            0.5 * gram.yty + relaxed.objective(&Problem::new(&gram, Scaling::None), xi)
        };
        // Two routes to one sum of numbers of order yᵀy.
        prop_assert!((at(&s.dense) - s.objective).abs() < 1e-10);
        for (direction, step) in [
            ([1.0, 0.0, -1.0, 0.0], 1e-4),
            ([0.0, 1.0, 0.0, 0.0], 1e-4),
            ([0.0, 0.0, 0.0, 1.0], 1e-4),
            ([0.3, -1.0, -0.3, 0.7], 1e-2),
        ] {
            for sign in [-1.0, 1.0] {
                let moved = &s.dense + DVector::from_column_slice(&direction) * (sign * step);
                prop_assert!(at(&moved) >= s.objective - 1e-10);
            }
        }
    }
}

#[test]
fn prop_bad_input_is_refused_and_degenerate_input_solved() {
    assert!(Relaxed::new(Penalty::L1, -1.0, 1.0).is_err());
    let l1 = || Relaxed::new(Penalty::L1, 0.1, 1.0).unwrap();
    assert!(l1().weights(&[1.0, f64::NAN]).is_err());
    assert!(l1().weights(&[-1.0]).is_err());
    let c = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
    assert!(l1().constraints(c.clone(), DVector::zeros(1)).is_err());
    let against = DVector::from_vec(vec![0.0, 1.0]);
    assert!(l1().constraints(c, against).is_err());
    let bad = DMatrix::from_element(1, 2, f64::INFINITY);
    assert!(l1().constraints(bad, DVector::zeros(1)).is_err());
    let gram = random_gram(1, 20, &[1.0, 0.0, 0.0], 0.0, 0.1);
    assert!(l1().weights(&[1.0]).unwrap().solve(&gram).is_err());
    let narrow = l1().constraints(DMatrix::identity(2, 2), DVector::zeros(2));
    assert!(narrow.unwrap().solve(&gram).is_err());
    assert!(l1().solve(&Gram::zeros(3)).is_err());
    // Every coefficient fixed by the constraints.
    let fixed = DVector::from_vec(vec![1.0, 2.0, 3.0]);
    let s = l1()
        .constraints(DMatrix::identity(3, 3), fixed.clone())
        .unwrap()
        .solve(&gram)
        .unwrap();
    // Divided and multiplied by the scale.
    assert!((s.dense - fixed).amax() < 1e-12);
    // Equal and zero columns.
    let (theta, y) = random_rows(4, 30, &[1.0], 0.0, 0.1);
    let wide = DMatrix::from_fn(30, 3, |i, j| if j < 2 { theta[(i, 0)] } else { 0.0 });
    let s = l1().solve(&of_rows(&wide, &y)).unwrap();
    assert!(s.refit.iter().all(|v| v.is_finite()) && !s.support[2]);
    assert!((s.refit[0] + s.refit[1] - 1.0).abs() < 0.1);
}
