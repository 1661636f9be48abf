//! Tests of all methods, and signals for the tests of each.

pub(crate) mod signals;

use super::*;
use proptest::prelude::*;

fn methods() -> Vec<Differentiator> {
    vec![
        FiniteDifference::new(6).unwrap().into(),
        SavitzkyGolay::new(7, 3).unwrap().into(),
        SmoothingSpline::cross_validated().into(),
        SmoothingSpline::new(1e-3).unwrap().into(),
        KalmanSmoother::maximum_likelihood(Motion::ConstantVelocity).into(),
        KalmanSmoother::maximum_likelihood(Motion::ConstantAcceleration).into(),
        Spectral::new(Ends::Reflected, Cutoff::CrossValidated)
            .unwrap()
            .into(),
    ]
}

proptest! {
    #[test]
    fn prop_every_method_commutes_with_shift_and_scale_and_never_yields_nan(
        y in proptest::collection::vec(-1.0..1.0f64, 12..60),
        scale in prop_oneof![Just(1.0), Just(1e-6), Just(1e9)],
    ) {
        let time: Vec<f64> = (0..y.len()).map(|i| 100.0 + 0.01 * i as f64).collect();
        let moved: Vec<f64> = y.iter().map(|y| scale * y).collect();
        for method in methods() {
            let (a, b) = (method.apply(&time, &y).unwrap(), method.apply(&time, &moved).unwrap());
            for (a, b) in a.derivative.iter().zip(&b.derivative) {
                // Slopes of order 100; searches may stop at points that differ by a thousandth of a step.
                prop_assert!(a.is_finite() && (b / scale - a).abs() < 1.0, "{:?}", method);
            }
        }
    }
}

#[test]
fn prop_every_method_refuses_bad_input() {
    let t: Vec<f64> = (0..20).map(f64::from).collect();
    let mut nan = t.clone();
    nan[3] = f64::NAN;
    let mut back = t.clone();
    back[5] = back[4];
    for m in methods() {
        for short in 0..3 {
            assert!(matches!(
                m.apply(&t[..short], &t[..short]),
                Err(SindyError::TooShort { .. })
            ));
        }
        assert!(matches!(
            m.apply(&t, &nan),
            Err(SindyError::NotFinite { index: 3, .. })
        ));
        assert!(matches!(
            m.apply(&nan, &t),
            Err(SindyError::NotFinite { index: 3, .. })
        ));
        assert!(matches!(
            m.apply(&back, &t),
            Err(SindyError::TimeNotIncreasing { index: 5 })
        ));
        assert!(matches!(
            m.apply(&t, &t[..9]),
            Err(SindyError::Shape { .. })
        ));
    }
}
