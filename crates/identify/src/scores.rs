//! Error figures of a prediction against a reference.

use serde::Serialize;

/// Mean absolute, root mean square and largest absolute error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Mean absolute error.
    pub mae: f64,
    /// Root mean square error.
    pub rmse: f64,
    /// Largest absolute error.
    pub worst: f64,
    /// Samples that were compared.
    pub samples: usize,
}

impl Errors {
    /// Compares where both are finite. A prediction that is not finite where the reference is counts as
    /// infinitely wrong; `None` where nothing can be compared.
    #[must_use]
    pub fn of(predicted: &[f64], reference: &[f64]) -> Option<Self> {
        let (mut sum, mut squares, mut worst, mut samples) = (0.0, 0.0, 0.0_f64, 0);
        for (p, r) in predicted.iter().zip(reference) {
            if !r.is_finite() {
                continue;
            }
            let e = if p.is_finite() {
                (p - r).abs()
            } else {
                f64::INFINITY
            };
            sum += e;
            squares += e * e;
            worst = worst.max(e);
            samples += 1;
        }
        let n = samples as f64;
        (samples > 0).then(|| Self {
            mae: sum / n,
            rmse: (squares / n).sqrt(),
            worst,
            samples,
        })
    }

    /// The errors of several comparisons taken together.
    #[must_use]
    pub fn pool(all: &[Self]) -> Option<Self> {
        let samples: usize = all.iter().map(|e| e.samples).sum();
        let n = samples as f64;
        let weighted =
            |f: fn(&Self) -> f64| all.iter().map(|e| f(e) * e.samples as f64).sum::<f64>() / n;
        (samples > 0).then(|| Self {
            mae: weighted(|e| e.mae),
            rmse: weighted(|e| e.rmse * e.rmse).sqrt(),
            worst: all.iter().map(|e| e.worst).fold(0.0, f64::max),
            samples,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_figures() {
        let e = Errors::of(&[1.0, 2.0, 5.0], &[1.0, f64::NAN, 2.0]).unwrap();
        assert_eq!((e.mae, e.worst, e.samples), (1.5, 3.0, 2));
        // √((0² + 3²)/2), and with two errors of one: √((9 + 2)/4).
        assert!((e.rmse - 4.5_f64.sqrt()).abs() < 1e-15);
        assert!(Errors::of(&[1.0], &[f64::NAN]).is_none());
        assert_eq!(
            Errors::of(&[f64::NAN], &[0.0]).unwrap().worst,
            f64::INFINITY
        );
        let both = Errors::pool(&[e, Errors::of(&[0.0, 0.0], &[1.0, 1.0]).unwrap()]).unwrap();
        assert_eq!((both.mae, both.worst, both.samples), (1.25, 3.0, 4));
        assert!((both.rmse - 2.75_f64.sqrt()).abs() < 1e-15);
    }
}
