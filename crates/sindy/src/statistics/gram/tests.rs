use super::driver::SEGMENT;
use super::*;
use crate::{OwnedBlock, Samples, Stream};
use proptest::prelude::*;

fn three_groups() -> (Library, Vec<Gram>, Samples) {
    let mut samples = Samples::new(&["x", "y"]);
    for g in 0..3 {
        let x: Vec<f64> = (0..700)
            .map(|i| (0.37 * f64::from(i) + f64::from(g)).sin())
            .collect();
        let y = x.iter().map(|x| 1.0 - 2.0 * x + 0.5 * x * x).collect();
        samples.push_group(vec![x, y]).unwrap();
    }
    let library = Library::parse(&["1", "x", "x^2"]).unwrap();
    let grams = Gram::accumulate(&library, "y", &samples).unwrap();
    (library, grams, samples)
}

#[test]
fn analytic_entries_are_the_sums() {
    let (_, grams, samples) = three_groups();
    let x = &samples.group(1)[0];
    let power = |k: i32| x.iter().map(|v| v.powi(k)).sum::<f64>();
    for i in 0..3 {
        for j in 0..3 {
            // Sums of 700 numbers below one in another order: rounding only.
            assert!((grams[1].xtx[(i, j)] - power((i + j) as i32)).abs() < 1e-11);
        }
    }
    let residual = grams[1].residual_sum(&DVector::from_vec(vec![1.0, -2.0, 0.5]));
    // The target is in the library's span; the sums cancel to rounding of numbers of order 1000.
    assert!(residual < 1e-9, "{residual}");
    assert!(grams[1].r_squared(&DVector::from_vec(vec![1.0, -2.0, 0.5])) > 1.0 - 1e-9);
}

#[test]
fn prop_equal_products_and_several_targets_change_nothing_but_rounding() {
    // Ten monomials of degree 3 in two variables, of whose 55 products 28 differ; and the same terms
    // spelt such that no two products look equal.
    let powers = (0..4).flat_map(|n| (0..=n).map(move |j| (n - j, j)));
    let (mut shared, mut apart) = (Vec::new(), Vec::new());
    for (k, (i, j)) in powers.enumerate() {
        shared.push(format!("x^{i}*y^{j}"));
        apart.push(format!("x^{i}*y^{j} + 0*exp({k}*x)"));
    }
    let [shared, apart] = [shared, apart].map(|t| Library::parse(&t).unwrap());
    let n = 1000;
    let column = |w: f64| -> Vec<f64> { (0..n).map(|i| (w * f64::from(i)).sin()).collect() };
    let mut samples = Samples::new(&["x", "y", "u", "v"]);
    let columns = [0.37, 0.91, 1.3, 2.1].map(column);
    samples.push_group(columns.to_vec()).unwrap();
    let both = Gram::accumulate_targets(&shared, &["u", "v"], &samples).unwrap();
    for (target, gram) in ["u", "v"].into_iter().zip(&both) {
        assert_eq!(*gram, Gram::accumulate(&shared, target, &samples).unwrap());
        let other = &Gram::accumulate(&apart, target, &samples).unwrap()[0];
        // Sums of 1000 numbers below one.
        assert!((&gram[0].xtx - &other.xtx).amax() < 1e-11);
        assert!((&gram[0].xty - &other.xty).amax() < 1e-11);
        assert!((gram[0].yty - other.yty).abs() < 1e-11);
        assert!((gram[0].sum_y - other.sum_y).abs() < 1e-11);
        assert_eq!((gram[0].rows, gram[0].skipped), (1000, 0));
    }
}

#[test]
fn analytic_downdating_undoes_merging() {
    let (_, grams, _) = three_groups();
    let mut all = Gram::total(&grams);
    assert_eq!(all.rows, 2100);
    all.downdate(&grams[2]);
    let two = Gram::total(&grams[..2]);
    // One addition and one subtraction of entries of order 1000.
    assert!((&all.xtx - &two.xtx).amax() < 1e-10 && (&all.xty - &two.xty).amax() < 1e-10);
    assert_eq!(all.rows, two.rows);
}

#[test]
fn prop_rows_that_are_not_finite_are_left_out_and_counted() {
    let library = Library::parse(&["1", "log(x)"]).unwrap();
    let mut samples = Samples::new(&["x", "y"]);
    samples
        .push_group(vec![
            vec![1.0, -1.0, 2.0, f64::NAN, 3.0],
            vec![1.0, 1.0, f64::INFINITY, 1.0, 2.0],
        ])
        .unwrap();
    let gram = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
    assert_eq!((gram.rows, gram.skipped), (2, 3));
    assert_eq!(gram.xtx[(0, 0)], 2.0);
    assert_eq!(gram.xty[0], 3.0);
}

#[test]
fn prop_the_number_of_threads_changes_nothing() {
    let n = 70 * SEGMENT + 1234; // more than one wave, and a ragged end
    let mut x: Vec<f64> = (0..n).map(|i| (1e-3 * i as f64).sin()).collect();
    let y: Vec<f64> = x.iter().map(|x| 1.0 / (2.0 + x)).collect();
    x[3 * SEGMENT + 7] = f64::NAN;
    let mut samples = Samples::new(&["x", "y"]);
    samples.push_group(vec![x, y]).unwrap();
    let library = Library::parse(&["1", "x", "x^2"]).unwrap();
    let [one, two, five] = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| Gram::accumulate(&library, "y", &samples).unwrap())
    });
    assert_eq!(one, two);
    assert_eq!(one, five);
    assert_eq!((one[0].rows, one[0].skipped), (n - 1, 1));
    assert_eq!(one[0].xtx[(0, 0)], (n - 1) as f64);
    let [x, _] = samples.group(0) else {
        unreachable!("two columns")
    };
    let sum: f64 = x.iter().filter(|x| x.is_finite()).sum();
    // 600 000 numbers below one, summed in another order: far below 1e-12 of their number.
    assert!((one[0].xtx[(0, 1)] - sum).abs() < 1e-12 * n as f64);
}

/// Columns x, y and w of `n` rows, one of which is not a number.
fn weighted_columns(n: usize) -> Vec<Vec<f64>> {
    let mut x: Vec<f64> = (0..n).map(|i| (1e-3 * i as f64).sin()).collect();
    let y = x.iter().map(|x| 1.0 / (2.0 + x)).collect();
    let w = (0..n).map(|i| (i % 5) as f64).collect();
    x[n / 2] = f64::NAN;
    vec![x, y, w]
}

#[test]
fn prop_blocks_of_any_size_and_any_threads_give_the_same_bits() {
    let library = Library::parse(&["1", "x", "x^2"]).unwrap();
    // Segments that are summed as they come, copied, and read where they are, with ragged ends.
    let groups: Vec<Vec<Vec<f64>>> = [3 * SEGMENT + 11, 300, 7 * SEGMENT + 5, 0, 257]
        .map(|n| {
            if n > 0 {
                weighted_columns(n)
            } else {
                vec![vec![]; 3]
            }
        })
        .to_vec();
    let mut whole = Samples::new(&["x", "y", "w"]);
    for columns in &groups {
        whole.push_group(columns.clone()).unwrap();
    }
    for triangle in [false, true] {
        let settings = Accumulate::new(&library, "y")
            .weights("w")
            .triangle(triangle);
        let expected = settings.over(&whole).unwrap();
        for (threads, size) in [
            (1, 37),
            (1, 8192),
            (2, 37),
            (2, 3000),
            (3, 8193),
            (2, 33_000),
        ] {
            let blocks = groups.iter().enumerate().flat_map(|(group, columns)| {
                (0..columns[0].len()).step_by(size).map(move |start| {
                    let end = columns[0].len().min(start + size);
                    let columns = columns.iter().map(|c| c[start..end].to_vec()).collect();
                    Ok(OwnedBlock { group, columns })
                })
            });
            let blocks: Vec<_> = blocks.collect();
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let found = pool.install(|| {
                let stream = Stream::new(&["x", "y", "w"], groups.len(), blocks);
                settings.over(&stream).unwrap()
            });
            assert_eq!(found, expected, "{threads} threads, blocks of {size}");
        }
    }
}

#[test]
fn analytic_weights_are_copies_of_rows() {
    let library = Library::parse(&["1", "x", "x^2"]).unwrap();
    let columns = weighted_columns(500);
    let mut once = Samples::new(&["x", "y", "w"]);
    once.push_group(columns.clone()).unwrap();
    // Weights 0 to 4 are whole numbers of copies.
    let mut copies = vec![Vec::new(); 3];
    for r in 0..500 {
        for _ in 0..columns[2][r] as usize {
            (0..3).for_each(|c| copies[c].push(columns[c][r]));
        }
    }
    let mut copied = Samples::new(&["x", "y", "w"]);
    copied.push_group(copies).unwrap();
    let settings = Accumulate::new(&library, "y").triangle(true);
    let weighted = &settings.weights("w").over(&once).unwrap()[0];
    let plain = &settings.over(&copied).unwrap()[0];
    // Row 250 is not a number, but its weight is zero: it does not count at all.
    assert_eq!((weighted.rows, weighted.skipped), (400, 0));
    assert_eq!((plain.rows, plain.skipped), (1000, 0));
    assert_eq!(weighted.weight(), 1000.0);
    // (Σ w)² / Σ w² of 100 times 1 to 4.
    assert!((weighted.effective_rows() - 1000.0 * 1000.0 / 3000.0).abs() < 1e-9);
    // Sums of a thousand numbers below one in another order.
    assert!((&weighted.xtx - &plain.xtx).amax() < 1e-10);
    assert!((&weighted.xty - &plain.xty).amax() < 1e-10);
    assert!((weighted.sum_y - plain.sum_y).abs() < 1e-10);
    assert!((weighted.column_rms() - plain.column_rms()).amax() < 1e-12);
    let r = |g: &Gram| g.triangle.as_ref().unwrap().matrix().clone();
    assert!((r(weighted) - r(plain)).amax() < 1e-10);
}

#[test]
fn prop_equal_weights_change_no_fit_and_bad_weights_are_refused() {
    let library = Library::parse(&["1", "x", "x^2"]).unwrap();
    let mut columns = weighted_columns(3000);
    columns[2] = vec![0.37; 3000];
    let mut samples = Samples::new(&["x", "y", "w"]);
    samples.push_group(columns.clone()).unwrap();
    let plain = Gram::accumulate(&library, "y", &samples).unwrap();
    let settings = Accumulate::new(&library, "y").weights("w");
    let mut weighted = settings.over(&samples).unwrap();
    assert_eq!((weighted[0].rows, weighted[0].skipped), (2999, 1));
    // Rounding of 2999 equal numbers, squared and added.
    assert!((weighted[0].effective_rows() - 2999.0).abs() < 1e-8);
    // The same but for rounding of sums of 3000 numbers.
    assert!((&weighted[0].xtx / 0.37 - &plain[0].xtx).amax() < 1e-9);
    assert!((weighted[0].column_rms() - plain[0].column_rms()).amax() < 1e-12);
    assert!((weighted[0].target_rms() - plain[0].target_rms()).abs() < 1e-12);
    let sr3 = crate::Sr3::new(1e-4, 1.0).unwrap();
    let (a, b) = (sr3.solve(&weighted[0]), sr3.solve(&plain[0]));
    assert_eq!(a.support, b.support);
    assert!((a.refit - b.refit).amax() < 1e-9 && (a.dense - b.dense).amax() < 1e-9);
    let part = weighted[0].clone();
    weighted[0].merge(&plain[0]);
    assert!((weighted[0].weight() - 2999.0 * 1.37).abs() < 1e-8);
    weighted[0].downdate(&part);
    assert!((weighted[0].effective_rows() - 2999.0).abs() < 1e-6);

    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        columns[2][1234] = bad;
        let mut samples = Samples::new(&["x", "y", "w"]);
        samples.push_group(columns.clone()).unwrap();
        let error = settings.over(&samples).unwrap_err().to_string();
        assert!(error.contains("weights"), "{error}");
    }
    assert!(
        Accumulate::new(&library, "y")
            .weights("v")
            .over(&samples)
            .is_err()
    );
    assert!(Accumulate::new(&library, "v").over(&samples).is_err());
    assert!(Gram::accumulate(&Library::parse(&["z"]).unwrap(), "y", &samples).is_err());
}

proptest! {
    #[test]
    fn prop_any_numbers_give_finite_statistics(
        x in prop::collection::vec(prop::num::f64::ANY, 0..600),
    ) {
        let library = Library::parse(&["1", "x"]).unwrap();
        let mut samples = Samples::new(&["x"]);
        // Squares of more than 1e150 overflow: those rows are not asked about here.
        let x: Vec<f64> = x.into_iter().filter(|v| !(v.is_finite() && v.abs() > 1e150)).collect();
        let finite = x.iter().filter(|v| v.is_finite()).count();
        samples.push_group(vec![x]).unwrap();
        let found = match Gram::accumulate(&library, "x", &samples) {
            Ok(found) => found,
            // Nothing but numbers whose squares underflow.
            Err(error) => {
                let underflow = matches!(error, SindyError::Range { .. });
                prop_assert!(underflow);
                return Ok(());
            }
        };
        let gram = Gram::total(&found);
        prop_assert_eq!(gram.rows, finite);
        prop_assert!(gram.xtx.iter().all(|v| v.is_finite()));
    }
}

#[test]
fn prop_coefficients_that_are_not_numbers_leave_no_number() {
    let library = Library::parse(&["1", "x"]).unwrap();
    let mut samples = Samples::new(&["x", "y"]);
    samples
        .push_group(vec![vec![1.0, 2.0, 4.0], vec![1.0, 2.0, 3.0]])
        .unwrap();
    for triangle in [false, true] {
        let settings = Accumulate::new(&library, "y").triangle(triangle);
        let gram = &settings.over(&samples).unwrap()[0];
        for j in 0..2 {
            let mut xi = DVector::from_vec(vec![1.0, 1.0]);
            xi[j] = f64::NAN;
            assert!(gram.residual_sum(&xi).is_nan() && gram.r_squared(&xi).is_nan());
        }
        // An exact fit leaves nothing, and not less.
        assert!(gram.residual_sum(&DVector::from_vec(vec![0.0, 1.0])) >= 0.0);
    }
}
