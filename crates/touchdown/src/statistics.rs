//! Mean, spread and confidence interval over trials.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF as _, StudentsT};

/// Mean, standard deviation over trials, and the 95 % confidence interval of the mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Mean.
    pub mean: f64,
    /// Standard deviation over trials; absent for a single one.
    pub sd: Option<f64>,
    /// 95 % confidence interval of the mean (Student's t); absent for a single trial.
    pub ci95: Option<[f64; 2]>,
}

impl Summary {
    /// Summarises; `None` without values.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        let mean = values.iter().sum::<f64>() / n;
        if values.len() == 1 {
            return Some(Self {
                mean,
                sd: None,
                ci95: None,
            });
        }
        let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let half = StudentsT::new(0.0, 1.0, n - 1.0).ok()?.inverse_cdf(0.975) * sd / n.sqrt();
        Some(Self {
            mean,
            sd: Some(sd),
            ci95: Some([mean - half, mean + half]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_summary_of_five() {
        let s = Summary::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        // Student's t with 4 degrees of freedom at 97.5 %: 2.776445 (tables), four decimals of which count.
        let half = 2.776_445 * 2.5_f64.sqrt() / 5.0_f64.sqrt();
        assert!((s.mean - 3.0).abs() < 1e-12 && (s.sd.unwrap() - 2.5_f64.sqrt()).abs() < 1e-12);
        assert!((s.ci95.unwrap()[1] - 3.0 - half).abs() < 1e-5);
        assert!(Summary::of(&[]).is_none());
        assert_eq!(Summary::of(&[2.0]).unwrap().sd, None);
    }
}
