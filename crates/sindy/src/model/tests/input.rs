//! Inputs over time.

use crate::model::{Inputs, Interpolation};

pub(super) const TIME: [f64; 6] = [0.0, 0.4, 1.0, 1.5, 2.5, 3.0];
pub(super) const VALUE: [f64; 6] = [0.0, 1.0, -1.0, 2.0, 0.5, 0.0];

fn sampled(how: Interpolation, n: usize) -> Inputs {
    Inputs::sampled(&TIME[..n], &[&VALUE[..n]], how).unwrap()
}

fn at(inputs: &Inputs, t: f64) -> f64 {
    inputs.at(t).unwrap()[0]
}

/// Reference values: SciPy 1.17.1, `CubicSpline(t, u)` (not-a-knot, its default).
#[test]
fn xval_cubic_spline() {
    let check = |n, points: &[(f64, f64)]| {
        let inputs = sampled(Interpolation::Cubic, n);
        for &(t, expected) in points {
            // Two solutions of the same well-conditioned equations: roundings of numbers of about 10.
            assert!(
                (at(&inputs, t) - expected).abs() < 1e-13,
                "{n} samples at {t}"
            );
        }
    };
    check(3, &[(0.1, 0.425), (0.7, 0.5250000000000004)]);
    check(
        4,
        &[
            (0.1, 0.6827272727272726),
            (0.7, -0.07636363636363602),
            (1.2, -0.7672727272727277),
        ],
    );
    check(
        6,
        &[
            (0.1, 0.8220805921052631),
            (0.7, -0.40152138157894707),
            (1.2, -0.04882894736842147),
            (2.2, 1.6643684210526306),
            (2.9, -0.17478947368421066),
        ],
    );
}

#[test]
fn analytic_samples_are_met_and_lines_are_lines() {
    for how in [
        Interpolation::ZeroOrderHold,
        Interpolation::Linear,
        Interpolation::Cubic,
    ] {
        let inputs = sampled(how, 6);
        for (t, u) in TIME.into_iter().zip(VALUE) {
            // The end of an interval is reached by one rounded division and multiplication.
            assert!((at(&inputs, t) - u).abs() < 1e-14, "{how:?} at {t}");
        }
    }
    assert_eq!(at(&sampled(Interpolation::ZeroOrderHold, 6), 0.99), 1.0);
    // Halfway down from 1 to -1, and a spline through two samples.
    assert!(at(&sampled(Interpolation::Linear, 6), 0.7).abs() < 1e-15);
    assert!((at(&sampled(Interpolation::Cubic, 2), 0.1) - 0.25).abs() < 1e-15);
}

#[test]
fn bad_inputs_are_refused() {
    let text = |time: &[f64], column: &[f64]| {
        Inputs::sampled(time, &[column], Interpolation::Cubic)
            .unwrap_err()
            .to_string()
    };
    assert!(text(&[], &[]).contains("at least 2, found 0"));
    assert!(text(&[1.0], &[1.0]).contains("at least 2, found 1"));
    assert!(text(&[0.0, 0.0], &[1.0, 1.0]).contains("sample 1"));
    assert!(text(&[0.0, f64::NAN], &[1.0, 1.0]).contains("input time: sample 1"));
    assert!(text(&[0.0, 1.0], &[1.0]).contains("expected 2, found 1"));
    assert!(text(&[0.0, 1.0], &[1.0, f64::INFINITY]).contains("input 0: sample 1"));
    assert!(Inputs::constant(&[f64::NAN]).is_err());
    assert!(
        Inputs::formulas(&["sin(x)"])
            .unwrap_err()
            .to_string()
            .contains("unknown name `x`")
    );
    let outside = sampled(Interpolation::Linear, 6)
        .at(3.5)
        .unwrap_err()
        .to_string();
    assert!(outside.contains("0 to 3, found 3.5"), "{outside}");
}
