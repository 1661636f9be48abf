use super::*;
use crate::statistics::gram::Accumulate;
use crate::{Library, Samples, Stlsq};

/// y = 1 - 2 x + noise, with every seventh row far off; groups of 300 and 200 rows, one row not a number.
fn outliers() -> (Library, Samples) {
    let mut samples = Samples::new(&["x", "y", "w", "kept"]);
    for (g, n) in [300, 200].into_iter().enumerate() {
        let x: Vec<f64> = (0..n).map(|i| (1.3 * f64::from(i)).sin()).collect();
        let mut y: Vec<f64> = (0..n)
            .map(|i| {
                let noise = 0.01 * (17.0 * f64::from(i * i)).cos();
                let far = if i % 7 == 0 {
                    5.0 + f64::from(i % 3)
                } else {
                    0.0
                };
                1.0 - 2.0 * x[i as usize] + noise + far
            })
            .collect();
        if g == 1 {
            y[3] = f64::NAN;
        }
        let w = (0..n).map(|i| f64::from(u8::from(i != 5))).collect();
        let other = vec![0.0; n as usize];
        samples.push_group(vec![x, y, w, other]).unwrap();
    }
    (Library::parse(&["1", "x", "x^2"]).unwrap(), samples)
}

#[test]
fn analytic_gross_errors_are_left_out() {
    let (library, samples) = outliers();
    let accumulate = Accumulate::new(&library, "y");
    let solver = Relaxed::new(Penalty::L0, 1e-4, 1.0).unwrap();
    let all = solver
        .fit(&Gram::total(&accumulate.over(&samples).unwrap()))
        .unwrap();
    // One row in seven is off by 5 to 7: the constant is off by a seventh of that.
    assert!((all.coefficients[0] - 1.0).abs() > 0.5);
    let trimmed = Trimming::new(0.85)
        .unwrap()
        .run(&accumulate, &samples, &solver)
        .unwrap();
    assert_eq!(trimmed.outcome, Outcome::Converged);
    assert_eq!(trimmed.fit.support, [true, true, false]);
    // Noise of 0.007 over 424 rows: a standard error of 5e-4 at most; four of them.
    let truth = DVector::from_vec(vec![1.0, -2.0, 0.0]);
    assert!((&trimmed.fit.coefficients - truth).amax() < 2e-3);
    for (g, n) in [(0, 300), (1, 200)] {
        for i in (0..n).step_by(7) {
            assert!(!trimmed.kept[g][i], "row {i} of group {g}");
        }
    }
    assert!(!trimmed.kept[1][3]);
    let count = trimmed.kept.iter().flatten().filter(|k| **k).count();
    // 85 % of 499 rows, rounded up.
    assert_eq!(count, 425);
    assert_eq!(Gram::total(&trimmed.grams).rows, 425);
}

#[test]
fn prop_squares_fall_and_weights_and_shares_of_one_are_kept() {
    let (library, samples) = outliers();
    let accumulate = Accumulate::new(&library, "y");
    let full = |g: &Gram| Ok(Fit::on_support(g, vec![true; 3], Outcome::Converged, 1));
    for keep in [0.3, 0.6, 0.9] {
        let trimmed = Trimming::new(keep)
            .unwrap()
            .run(&accumulate, &samples, &full)
            .unwrap();
        assert_eq!(trimmed.outcome, Outcome::Converged);
        for pair in trimmed.squares.windows(2) {
            // Rounding of sums below 5000.
            assert!(pair[1] <= pair[0] + 1e-9, "{:?}", trimmed.squares);
        }
    }
    let plain = full(&Gram::total(&accumulate.over(&samples).unwrap())).unwrap();
    let whole = Trimming::new(1.0)
        .unwrap()
        .run(&accumulate, &samples, &full)
        .unwrap();
    // Every weight is 1: the same sums.
    assert!((whole.fit.coefficients - plain.coefficients).amax() < 1e-12);
    let weighted = accumulate.weights("w");
    let trimmed = Trimming::new(0.5)
        .unwrap()
        .run(&weighted, &samples, &full)
        .unwrap();
    assert!(!trimmed.kept[0][5] && !trimmed.kept[1][5]);
    let once = Trimming::new(0.5).unwrap().max_iterations(0);
    let once = once.run(&accumulate, &samples, &full).unwrap();
    assert_eq!(
        (once.outcome, once.squares.len()),
        (Outcome::IterationLimit, 1)
    );

    assert!(Trimming::new(0.0).is_err() && Trimming::new(1.1).is_err());
    assert!(Trimming::new(f64::NAN).is_err());
    let stlsq = Stlsq::new(0.1, 0.0).unwrap();
    let half = Trimming::new(0.5).unwrap();
    assert!(
        half.run(&Accumulate::new(&library, "z"), &samples, &stlsq)
            .is_err()
    );
    assert!(
        half.run(&accumulate, &Samples::new(&["x", "y"]), &stlsq)
            .is_err()
    );
}

#[test]
fn analytic_residuals_are_trimmed_by_their_weights() {
    // One row off by 0.5 that is known to be exact, others off by 1 that are known to be rough: in units of what is known
    // of each, the exact one is the furthest off.
    let n = 60;
    let mut samples = Samples::new(&["y", "w"]);
    let y = (0..n)
        .map(|i| match i {
            30 => 0.5,
            _ if i % 6 == 0 => {
                if i % 12 == 0 {
                    1.0
                } else {
                    -1.0
                }
            }
            _ => 0.01 * f64::from(i % 3 - 1),
        })
        .collect();
    let w = (0..n)
        .map(|i| if i != 30 && i % 6 == 0 { 0.01 } else { 1.0 })
        .collect();
    samples.push_group(vec![y, w]).unwrap();
    let library = Library::parse(&["1"]).unwrap();
    let solver = |g: &Gram| Ok(Fit::on_support(g, vec![true], Outcome::Converged, 1));
    let gone = |accumulate: Accumulate<'_>| -> Vec<usize> {
        let trimming = Trimming::new(1.0 - 1.0 / f64::from(n)).unwrap();
        let found = trimming.run(&accumulate, &samples, &solver).unwrap();
        let kept = found.kept[0].iter().enumerate();
        kept.filter(|(_, k)| !**k).map(|(i, _)| i).collect()
    };
    let plain = Accumulate::new(&library, "y");
    assert_eq!(gone(plain.weights("w")), [30]);
    assert_ne!(gone(plain), [30]);
}
