use super::*;

#[test]
fn analytic_polynomials_of_the_degree_pass_unchanged() {
    let time: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
    let uneven: Vec<f64> = time.iter().map(|t| t + 0.03 * (3.0 * t).sin()).collect();
    let p = |t: f64| 1.0 - 2.0 * t + 0.5 * t * t - 0.1 * t * t * t;
    let dp = |t: f64| -2.0 + t - 0.3 * t * t;
    let filter = SavitzkyGolay::new(11, 3).unwrap();
    for grid in [&time, &uneven] {
        let y: Vec<f64> = grid.iter().map(|&t| p(t)).collect();
        let out = filter.apply(grid, &y).unwrap();
        for (i, &t) in grid.iter().enumerate() {
            // Rounding in a window of 11 values of size 10: some 1e-13.
            assert!((out.value[i] - p(t)).abs() < 1e-11, "value at {t}");
            assert!((out.derivative[i] - dp(t)).abs() < 1e-10, "slope at {t}");
        }
    }
}

/// Made with SciPy 1.17.1 on NumPy 2.4.6:
/// `t = arange(25)*0.05; y = sin(3*t) + 0.1*cos(17*t)`, `savgol_filter(y, w, d, mode="interp")` and
/// the same with `deriv=1, delta=0.05`; sample `k`, value, derivative.
#[test]
fn xval_scipy_savgol_filter() {
    let expected = [
        (7, 2, 0, 0.12519930278217864, 0.9285093931917615),
        (7, 2, 1, 0.18288652795410537, 1.3789796136853083),
        (7, 2, 2, 0.26309726415070944, 1.8294498341788552),
        (7, 2, 5, 0.6443884166817322, 2.7015131621088715),
        (7, 2, 12, 0.9142284736471264, -0.22318924153694097),
        (7, 2, 20, 0.11820269085918596, -2.287363727431692),
        (7, 2, 23, -0.2441441964371357, -3.2220328021661526),
        (7, 2, 24, -0.41561916166697543, -3.636965807027439),
        (11, 4, 0, 0.11559182231132555, 1.4839944548054933),
        (11, 4, 1, 0.18807716506734534, 1.4829664022815858),
        (11, 4, 2, 0.2692564870880416, 1.804019822671128),
        (11, 4, 5, 0.6427976570306755, 3.035640758034897),
        (11, 4, 12, 0.9116568935992806, -0.022391162383573415),
        (11, 4, 20, 0.10361134965271834, -1.7805751614060874),
        (11, 4, 23, -0.1984646457280942, -3.670427629673026),
        (11, 4, 24, -0.45282310911630275, -6.778036797859775),
    ];
    let time: Vec<f64> = (0..25).map(|i| 0.05 * f64::from(i)).collect();
    let y: Vec<f64> = time
        .iter()
        .map(|t| (3.0 * t).sin() + 0.1 * (17.0 * t).cos())
        .collect();
    for (window, degree, k, value, slope) in expected {
        let out = SavitzkyGolay::new(window, degree)
            .unwrap()
            .apply(&time, &y)
            .unwrap();
        // Two least-squares routes to the same weights: rounding of values of order 1 and, divided
        // by the period, of order 20.
        assert!(
            (out.value[k] - value).abs() < 1e-12,
            "{window} {degree} {k}"
        );
        assert!(
            (out.derivative[k] - slope).abs() < 1e-11,
            "{window} {degree} {k}"
        );
    }
}

#[test]
fn prop_used_columns_give_the_same_bits() {
    let time: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
    let uneven: Vec<f64> = time.iter().map(|t| t + 0.03 * (3.0 * t).sin()).collect();
    let filter = SavitzkyGolay::new(7, 3).unwrap();
    for grid in [&time, &uneven] {
        let y: Vec<f64> = grid.iter().map(|t| t.sin()).collect();
        let mut used = Smoothed {
            value: vec![f64::NAN; 9],
            derivative: vec![f64::NAN; 90],
        };
        filter.apply_into(grid, &y, &mut used).unwrap();
        assert_eq!(used, filter.apply(grid, &y).unwrap());
    }
}

#[test]
fn prop_every_register_width_gives_the_same_bits() {
    let y: Vec<f64> = (0..1003).map(|i| (0.7 * f64::from(i)).sin()).collect();
    let (even, odd) = central_weights(5, 3);
    let mut narrow = [vec![0.0; 993], vec![0.0; 993]];
    let mut widest = narrow.clone();
    let [value, derivative] = &mut narrow;
    convolve(&y, &even, &odd, value, derivative); // no vector instructions beyond the target's
    let [value, derivative] = &mut widest;
    pulp::Arch::new().dispatch(Convolution {
        y: &y,
        even: &even,
        odd: &odd,
        value,
        derivative,
    });
    assert_eq!(narrow, widest);
}

#[test]
fn prop_bad_input_is_named() {
    let filter = SavitzkyGolay::new(5, 2).unwrap();
    assert!(matches!(
        SavitzkyGolay::new(4, 2),
        Err(SindyError::Setting { .. })
    ));
    assert!(matches!(
        SavitzkyGolay::new(5, 5),
        Err(SindyError::Setting { .. })
    ));
    let t = [0.0, 1.0, 2.0, 3.0, 4.0];
    assert!(matches!(
        filter.apply(&t[..3], &[0.0; 3]),
        Err(SindyError::TooShort { .. })
    ));
    let nan = [0.0, 1.0, f64::NAN, 3.0, 4.0];
    assert!(matches!(
        filter.apply(&t, &nan),
        Err(SindyError::NotFinite { index: 2, .. })
    ));
    let back = [0.0, 1.0, 1.0, 3.0, 4.0];
    assert!(matches!(
        filter.apply(&back, &t),
        Err(SindyError::TimeNotIncreasing { index: 2 })
    ));
}
