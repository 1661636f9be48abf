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

/// A count of trials as a share of all, with its 95 % interval after Wilson (1927).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Trials that count.
    pub count: u64,
    /// Their share of all.
    pub share: f64,
    /// 95 % interval of the share.
    pub ci95: [f64; 2],
}

impl Share {
    /// `count` of `all`; `None` of none.
    #[must_use]
    pub fn of(count: u64, all: u64) -> Option<Self> {
        if all == 0 {
            return None;
        }
        // The normal distribution's 97.5 % point.
        const Z: f64 = 1.959_963_984_540_054;
        let (n, p) = (all as f64, count as f64 / all as f64);
        let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
        let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        Some(Self {
            count,
            share: p,
            // At the ends the interval closes exactly; rounding may miss that.
            ci95: [
                if count == 0 { 0.0 } else { middle - half },
                if count == all { 1.0 } else { middle + half },
            ],
        })
    }
}

/// The value that a share of the sorted values lies below, interpolated between neighbours; `None` without values.
#[must_use]
pub fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    Some(sorted[low] + (place - place.floor()) * (sorted[high] - sorted[low]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn xval_wilson_intervals() {
        // Reference values: Wilson 1927 without continuity correction, 15 of 20 and 1000 of 1000.
        let some = Share::of(15, 20).unwrap();
        // Printed to four decimals in tables.
        assert!(
            (some.ci95[0] - 0.5313).abs() < 1e-4 && (some.ci95[1] - 0.8881).abs() < 1e-4,
            "{some:?}"
        );
        let all = Share::of(1000, 1000).unwrap();
        // n / (n + z²).
        assert!((all.ci95[0] - 1000.0 / 1_003.841_459).abs() < 1e-8 && all.ci95[1] == 1.0);
        assert_eq!(Share::of(0, 3).unwrap().ci95[0], 0.0);
        assert!(Share::of(0, 0).is_none());
    }

    #[test]
    fn analytic_percentiles() {
        assert_eq!(percentile(&[1.0, 2.0, 4.0], 0.5), Some(2.0));
        assert_eq!(percentile(&[1.0, 2.0, 4.0], 0.75), Some(3.0));
        assert_eq!(percentile(&[1.0, 2.0, 4.0], 1.0), Some(4.0));
        assert_eq!(percentile(&[], 0.5), None);
    }

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
