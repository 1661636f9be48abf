use super::*;
use crate::statistics::normal::tests::random_rows;
use crate::statistics::regression::least_squares;
use crate::{Library, Outcome, Samples, Solver, Sr3, Stlsq};
use proptest::prelude::*;

/// Powers 0 to 4 of numbers from 1 to 1.02 with ten binary places: every entry is exact, and the condition
/// is above 10⁹.
fn powers(truth: [f64; 5]) -> (Library, Samples) {
    let x: Vec<f64> = (0..1050)
        .map(|i| 1.0 + f64::from(i % 21) / 1024.0)
        .collect();
    // Numbers of at most 50 bits: the target is exact.
    let y = x
        .iter()
        .map(|x| truth.iter().rev().fold(0.0, |sum, c| sum * x + c))
        .collect();
    let mut samples = Samples::new(&["x", "y"]);
    samples.push_group(vec![x, y]).unwrap();
    let terms = ["1", "x", "x*x", "x*x*x", "x*x*x*x"];
    (Library::parse(&terms).unwrap(), samples)
}

#[test]
fn analytic_coefficients_survive_a_condition_that_the_gram_matrix_loses() {
    let truth = [3.0, -2.0, 1.0, 4.0, -5.0];
    let (library, samples) = powers(truth);
    let settings = Accumulate::new(&library, "y");
    let found = by_condition(&settings, &samples).unwrap();
    assert_eq!(found.route, Route::Triangle);
    assert!(
        (1e9..1e11).contains(&found.condition),
        "{}",
        found.condition
    );
    let error = |gram: &Gram| {
        let xi = least_squares(gram, &[true; 5]);
        (xi - DVector::from_column_slice(&truth)).amax()
    };
    // Householder's backward error of some 1e-16 of each column, times the condition of about 1e10.
    let by_triangle = error(&found.grams[0]);
    assert!(by_triangle < 1e-5, "{by_triangle}");
    // The Gram matrix has no digit left along the smallest direction.
    let by_gram = error(&settings.over(&samples).unwrap()[0]);
    assert!(by_gram > 0.1, "{by_gram}");
    // The exact target: what is left is rounding of numbers of order one, twice 1050 of them.
    let xi = DVector::from_column_slice(&truth);
    assert!(found.grams[0].residual_sum(&xi) < 1e-25);
}

#[test]
fn analytic_sparse_solvers_use_the_factor() {
    let truth = [0.0, 1.0, 0.0, 0.0, -3.0];
    let (library, samples) = powers(truth);
    let settings = Accumulate::new(&library, "y").triangle(true);
    let gram = settings.over(&samples).unwrap().remove(0);
    let without = Gram {
        triangle: None,
        ..gram.clone()
    };
    let exact = DVector::from_column_slice(&truth);
    let stlsq = Stlsq::new(0.01, 0.0).unwrap();
    // With two terms left the condition is below 1e3; with five, as above.
    let fit = stlsq.fit(&gram).unwrap();
    assert_eq!(fit.support, truth.map(|c| c != 0.0));
    assert!((&fit.coefficients - &exact).amax() < 1e-10);
    assert_ne!(stlsq.fit(&without).unwrap().support, fit.support);
    let sr3 = Sr3::new(1e-5, 1.0).unwrap();
    let fit = sr3.solve(&gram);
    assert_eq!(
        (fit.outcome, &fit.support[..]),
        (Outcome::Converged, &truth.map(|c| c != 0.0)[..])
    );
    assert!((&fit.refit - &exact).amax() < 1e-10);
}

#[test]
fn analytic_well_conditioned_libraries_need_one_pass_and_agree() {
    let (theta, y) = random_rows(1, 300, &[1.0, 0.0, -2.0, 0.5], 0.5, 0.1);
    let triangle = Triangle::of_rows(&theta, &y).unwrap();
    let by_triangle = triangle.to_gram(300, y.sum());
    let by_gram = crate::statistics::normal::tests::of_rows(&theta, &y);
    // Condition of about 3: rounding of sums of 300 numbers.
    assert!((&by_triangle.xtx - &by_gram.xtx).amax() < 1e-11);
    assert!((&by_triangle.xty - &by_gram.xty).amax() < 1e-11);
    assert!((by_triangle.yty - by_gram.yty).abs() < 1e-11);
    assert!((by_triangle.condition() / by_gram.condition() - 1.0).abs() < 1e-11);
    for support in [[true; 4], [true, false, true, false], [false; 4]] {
        let (a, b) = (
            least_squares(&by_triangle, &support),
            least_squares(&by_gram, &support),
        );
        assert!((&a - &b).amax() < 1e-12);
        let r = y.clone() - &theta * &a;
        assert!((by_triangle.residual_sum(&a) - r.norm_squared()).abs() < 1e-11);
    }
    for solver in [
        &Stlsq::new(0.1, 0.2).unwrap() as &dyn Solver,
        &Sr3::new(1e-3, 0.5).unwrap(),
    ] {
        let (a, b) = (
            solver.fit(&by_triangle).unwrap(),
            solver.fit(&by_gram).unwrap(),
        );
        assert_eq!(a.support, b.support);
        assert!((a.coefficients - b.coefficients).amax() < 1e-12);
    }
    let stlsq = Stlsq::new(0.1, 0.2).unwrap().refit(false);
    let (a, b) = (
        stlsq.fit(&by_triangle).unwrap(),
        stlsq.fit(&by_gram).unwrap(),
    );
    // With the ridge in the coefficients.
    assert!((a.coefficients - b.coefficients).amax() < 1e-12);

    let mut samples = Samples::new(&["x", "y"]);
    let x: Vec<f64> = (0..100).map(|i| f64::from(i).sin()).collect();
    samples.push_group(vec![x.clone(), x]).unwrap();
    let library = Library::parse(&["1", "x"]).unwrap();
    let found = by_condition(&Accumulate::new(&library, "y"), &samples).unwrap();
    assert_eq!(found.route, Route::Gram);
    assert!(found.grams[0].triangle.is_none() && found.condition < 2.0);
}

#[test]
fn analytic_dependent_and_zero_columns_share_the_coefficient() {
    let (one, y) = random_rows(2, 50, &[3.0], 0.0, 0.0);
    let theta = DMatrix::from_fn(50, 3, |i, j| [1.0, 2.0, 0.0][j] * one[(i, 0)]);
    let triangle = Triangle::of_rows(&theta, &y).unwrap();
    let xi = triangle.least_squares(&[true; 3]);
    // Columns of unit length are equal: half of 3 each, in their own units. Rounding.
    assert!((xi - DVector::from_vec(vec![1.5, 0.75, 0.0])).amax() < 1e-12);
    assert!(triangle.condition() > 1e14);
    assert_eq!(Triangle::new(2).condition(), 1.0);
    assert_eq!(
        Triangle::new(2).least_squares(&[true; 2]),
        DVector::zeros(2)
    );
}

#[test]
fn prop_merging_knows_empty_parts_and_downdating_drops_the_factor() {
    let (theta, y) = random_rows(3, 40, &[1.0, 2.0], 0.2, 0.1);
    let of = |from: usize, n: usize| {
        let y = y.rows(from, n).into_owned();
        let triangle = Triangle::of_rows(&theta.rows(from, n).into_owned(), &y).unwrap();
        triangle.to_gram(n, y.sum())
    };
    let whole = of(0, 40);
    let total = Gram::total(&[Gram::zeros(2), of(0, 15), Gram::zeros(2), of(15, 25)]);
    let r = |g: &Gram| g.triangle.as_ref().unwrap().matrix().clone();
    // Two orders of reflections on numbers of order one to ten.
    assert!((r(&total) - r(&whole)).amax() < 1e-13);
    let mut thrice = Gram::zeros(2);
    thrice.merge_copies(&whole, 3.0);
    assert!((r(&thrice) - r(&whole) * 3f64.sqrt()).amax() < 1e-13);
    assert_eq!(thrice.rows, 120);
    let mut mixed = whole.clone();
    mixed.merge(&Gram {
        triangle: None,
        ..of(0, 15)
    });
    assert!(mixed.triangle.is_none());
    let mut less = whole.clone();
    less.downdate(&of(0, 15));
    assert!(less.triangle.is_none() && less.rows == 25);
    assert!(Triangle::of_rows(&theta, &y.rows(0, 3).into_owned()).is_err());
    let bad = Triangle::of_rows(&DMatrix::from_element(1, 1, f64::NAN), &DVector::zeros(1));
    assert!(bad.unwrap_err().to_string().contains("column 0"));
}

proptest! {
    #[test]
    fn prop_every_split_gives_the_same_factor(seed in 0_u64..1000, cut in 0_usize..60, again in 0_usize..60) {
        let (theta, y) = random_rows(seed, 60, &[1.0, -1.0, 0.5], 0.9, 0.1);
        let whole = Triangle::of_rows(&theta, &y).unwrap();
        let (a, b) = (cut.min(again), cut.max(again));
        let part = |from: usize, to: usize| {
            Triangle::of_rows(
                &theta.rows(from, to - from).into_owned(),
                &y.rows(from, to - from).into_owned(),
            )
            .unwrap()
        };
        // One tree, and the same leaves in another order.
        let mut one = part(0, a);
        one.merge(&part(a, b));
        one.merge(&part(b, 60));
        let mut other = part(b, 60);
        let mut first = part(a, b);
        first.merge(&part(0, a));
        other.merge(&first);
        // A diagonal of at least 0 makes R unique: rounding of entries below ten, times a condition of about 5.
        prop_assert!((one.matrix() - whole.matrix()).amax() < 1e-12);
        prop_assert!((other.matrix() - whole.matrix()).amax() < 1e-12);
        prop_assert!((0..4).all(|j| whole.matrix()[(j, j)] >= 0.0));
    }
}

#[test]
fn prop_the_factor_knows_no_unit() {
    let rows = 40;
    let theta = DMatrix::from_fn(rows, 3, |i, j| {
        (1.0 + i as f64 * (j + 1) as f64 * 0.7).sin()
    });
    let truth = DVector::from_vec(vec![2.0, -3.0, 0.5]);
    let noise = DVector::from_fn(rows, |i, _| 0.1 * (5.1 * i as f64).cos());
    let y = &theta * &truth + noise;
    let plain = Triangle::of_rows(&theta, &y).unwrap();
    let (xi, condition) = (plain.least_squares(&[true; 3]), plain.condition());
    for exponent in [-300, -160, -150, -100, 100, 140, 150, 160, 300] {
        let scale = 10f64.powi(exponent);
        for (of_theta, of_y) in [(scale, scale), (scale, 1.0), (1.0, scale)] {
            // Beyond the largest number is no coefficient.
            if !(of_y / of_theta).is_finite() || of_y / of_theta < 1e-300 {
                continue;
            }
            let mut theta = &theta * of_theta;
            // Columns of different units in one library.
            theta.column_mut(1).scale_mut(1.0 / of_theta);
            let (first, second) = (
                Triangle::of_rows(&theta.rows(0, 15).into_owned(), &(y.rows(0, 15) * of_y))
                    .unwrap(),
                Triangle::of_rows(&theta.rows(15, 25).into_owned(), &(y.rows(15, 25) * of_y))
                    .unwrap(),
            );
            let mut both = first;
            both.merge(&second);
            let found = both.least_squares(&[true; 3]);
            for (j, unit) in [(0, of_theta), (1, 1.0), (2, of_theta)] {
                // A condition below 3, and the rounding of 40 rows.
                let error = found[j] * unit / of_y / xi[j] - 1.0;
                assert!(error.abs() < 1e-12, "{exponent} {j}: {error}");
            }
            assert!(
                (both.condition() / condition - 1.0).abs() < 1e-10,
                "{exponent}"
            );
        }
    }
}

#[test]
fn prop_statistics_of_any_unit_are_right_or_refused() {
    for exponent in [-160, -155, -150, -140, -100, 100, 140, 150, 155, 160] {
        let scale = 10f64.powi(exponent);
        let x: Vec<f64> = (0..50)
            .map(|i| scale * (2.0 + f64::from(i).sin()))
            .collect();
        let y = x.iter().map(|x| 3.0 * x / scale - 1.0).collect();
        let mut samples = Samples::new(&["x", "y"]);
        samples.push_group(vec![x, y]).unwrap();
        let library = Library::parse(&["1", "x"]).unwrap();
        let settings = Accumulate::new(&library, "y");
        for triangle in [false, true] {
            match settings.triangle(triangle).over(&samples) {
                Ok(parts) => {
                    assert!((-145..=152).contains(&exponent), "{exponent}");
                    let xi = least_squares(&parts[0], &[true; 2]);
                    // A condition of some 10, squared, times rounding.
                    assert!((xi[1] * scale - 3.0).abs() < 1e-12, "{exponent}: {xi}");
                    assert!((xi[0] + 1.0).abs() < 1e-12, "{exponent}: {xi}");
                }
                Err(error) => {
                    assert!(!(-144..=152).contains(&exponent), "{exponent}: {error}");
                    assert!(error.to_string().contains("term `x`: the sum"), "{error}");
                }
            }
        }
        assert!(by_condition(&settings, &samples).is_ok() == (-145..=152).contains(&exponent));
    }
}
