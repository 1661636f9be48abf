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

/// What standard errors of a fit rest on: independent groups of data, and the coefficients fitted to them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clusters {
    /// Groups (trials, stretches, points).
    pub groups: usize,
    /// Coefficients that were fitted together.
    pub coefficients: usize,
}

impl Clusters {
    /// The 95 % confidence interval of a coefficient from its standard error over groups (with the factor
    /// `G/(G - 1)` of a sandwich estimate over G groups):
    ///
    /// ```text
    /// value ± t_0.975(G - 1) · std_error · √((G - 1)/(G - k))
    /// ```
    ///
    /// with Student's t. The residuals of a fit of k coefficients are smaller than its errors, so the interval without
    /// the root covers too little where G is not much larger than k: 0.84 for 10 groups and 8 coefficients. Coverage with
    /// it, in simulations of noise that wanders inside each group (correlation 0.95 from row to row), G from 10 to 50 and k
    /// from 3 to 12: 0.93 to 0.95 where G is at least 2.5 k, up to 0.99 (too wide) where G is nearer to k. The choice of
    /// terms is not in it. `None` without a standard error, or unless G is larger than k.
    ///
    /// Source: A. C. Cameron, D. L. Miller, Journal of Human Resources 50 (2015), section VI.
    #[must_use]
    pub fn interval(self, value: f64, std_error: f64) -> Option<[f64; 2]> {
        let spare = self.groups.checked_sub(self.coefficients)?;
        let others = self.groups.saturating_sub(1) as f64;
        if spare == 0 || !(std_error.is_finite() && value.is_finite()) {
            return None;
        }
        let t = StudentsT::new(0.0, 1.0, others).ok()?.inverse_cdf(0.975);
        let half = t * std_error * (others / spare as f64).sqrt();
        Some([value - half, value + half])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindy::regression::{cluster_errors, least_squares};
    use sindy::{Gram, Library, Samples};

    /// Whether the intervals of `y = 0` on `terms` cover it, for each coefficient: noise that wanders inside each group.
    fn covered(seed: u64, groups: usize, terms: &[&str]) -> usize {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        // xorshift64*: sums of twelve uniform draws are as good as normal here.
        let mut uniform = || {
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut samples = Samples::new(&["a", "b", "c", "y"]);
        for _ in 0..groups {
            let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
            let mut noise = normal() / (1.0_f64 - 0.95 * 0.95).sqrt();
            let shape: Vec<f64> = (0..9).map(|_| normal()).collect();
            let column = |k: usize, i: usize| {
                let (mean, swing, w) = (shape[3 * k], shape[3 * k + 1], shape[3 * k + 2]);
                0.7 * mean + swing * (0.1 * (1.0 + w.abs()) * i as f64).sin()
            };
            let mut columns = vec![Vec::new(); 4];
            for i in 0..60 {
                noise = 0.95 * noise + normal();
                (0..3).for_each(|k| columns[k].push(column(k, i)));
                columns[3].push(noise);
            }
            samples.push_group(columns).unwrap();
        }
        let library = Library::parse(terms).unwrap();
        let grams = Gram::accumulate(&library, "y", &samples).unwrap();
        let all = vec![true; terms.len()];
        let xi = least_squares(&Gram::total(&grams), &all);
        let errors = cluster_errors(&grams, &xi, &all).unwrap();
        let clusters = Clusters {
            groups,
            coefficients: terms.len(),
        };
        let covers = |j: &usize| {
            let [low, high] = clusters.interval(xi[*j], errors[*j]).unwrap();
            low <= 0.0 && 0.0 <= high
        };
        (0..terms.len()).filter(covers).count()
    }

    #[test]
    fn analytic_intervals_cover_what_they_say() {
        let terms = ["1", "a", "b", "c", "a*b", "a^2", "b^2", "c^2"];
        for (groups, k) in [(10, 4), (10, 8), (12, 6), (37, 8)] {
            let draws = 400;
            let hits: usize = (0..draws)
                .map(|s| covered(s + 1, groups, &terms[..k]))
                .sum();
            let share = hits as f64 / (draws as usize * k) as f64;
            // 400 draws of a share of 0.95 scatter by 0.011 where all coefficients of a draw go together.
            assert!(
                (0.92..=0.995).contains(&share),
                "{groups} groups, {k} terms: {share}"
            );
        }
    }

    #[test]
    fn analytic_interval_by_the_tables() {
        let clusters = |groups, coefficients| Clusters {
            groups,
            coefficients,
        };
        // Student's t with 5 degrees of freedom at 97.5 %: 2.570582 (tables); √(5/4) for two coefficients.
        let [low, high] = clusters(6, 2).interval(1.0, 0.1).unwrap();
        let half = 0.257_058_2 * 1.25_f64.sqrt();
        assert!((high - 1.0 - half).abs() < 1e-6 && (1.0 - low - half).abs() < 1e-6);
        assert!(clusters(2, 2).interval(1.0, 0.1).is_none());
        assert!(clusters(1, 2).interval(1.0, 0.1).is_none());
        assert!(clusters(6, 2).interval(1.0, f64::NAN).is_none());
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
