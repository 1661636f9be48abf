//! Distribution of short times, counted without allocation.

use serde::Serialize;

/// Width of a bin, µs. It is the resolution of the quantiles: half of it halves their error and doubles the memory.
const BIN_US: u64 = 10;
/// Number of bins: they reach to 50 ms, half of the age at which attitude is not used any more.
const BINS: usize = 5000;

/// Counts of times in bins of 10 µs, up to 50 ms; longer ones count as the last bin.
#[derive(Clone, Debug)]
pub struct Distribution {
    counts: Vec<u32>,
    total: u64,
    greatest_us: u64,
}

impl Default for Distribution {
    fn default() -> Self {
        Self {
            counts: vec![0; BINS],
            total: 0,
            greatest_us: 0,
        }
    }
}

/// Quantiles of a [`Distribution`], ms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantiles {
    /// Number of times.
    pub count: u64,
    /// Median, ms.
    pub p50_ms: f64,
    /// 99th percentile, ms.
    pub p99_ms: f64,
    /// 99.9th percentile, ms.
    pub p999_ms: f64,
    /// Greatest, ms.
    pub greatest_ms: f64,
}

impl Distribution {
    /// Counts a time.
    pub fn add(&mut self, us: u64) {
        let bin = usize::try_from(us / BIN_US).unwrap_or(BINS).min(BINS - 1);
        self.counts[bin] = self.counts[bin].saturating_add(1);
        self.total += 1;
        self.greatest_us = self.greatest_us.max(us);
    }

    /// The quantiles; none without times. Each is the upper end of its bin, so at most 10 µs too large.
    #[must_use]
    pub fn quantiles(&self) -> Option<Quantiles> {
        (self.total > 0).then(|| Quantiles {
            count: self.total,
            p50_ms: self.quantile_ms(0.5),
            p99_ms: self.quantile_ms(0.99),
            p999_ms: self.quantile_ms(0.999),
            greatest_ms: self.greatest_us as f64 * 1e-3,
        })
    }

    fn quantile_ms(&self, share: f64) -> f64 {
        let rank = (share * self.total as f64).ceil() as u64;
        let mut below = 0;
        let reaches = |count: &u32| {
            below += u64::from(*count);
            below >= rank
        };
        let bin = self.counts.iter().position(reaches).unwrap_or(BINS - 1);
        let end_us = ((bin as u64 + 1) * BIN_US).min(self.greatest_us);
        let last = bin == BINS - 1;
        (if last { self.greatest_us } else { end_us }) as f64 * 1e-3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_quantiles_are_those_of_the_sorted_times() {
        let mut times = Distribution::default();
        assert_eq!(times.quantiles(), None);
        for us in 1..=1000 {
            times.add(us * 10 - 1);
        }
        let expected = Quantiles {
            count: 1000,
            p50_ms: 5.0,
            p99_ms: 9.9,
            p999_ms: 9.99,
            greatest_ms: 9.999,
        };
        let found = times.quantiles().unwrap();
        // Bins end at whole multiples of 10 µs, up to rounding of f64.
        assert!((found.p50_ms - expected.p50_ms).abs() < 1e-9);
        assert!((found.p99_ms - expected.p99_ms).abs() < 1e-9);
        assert!((found.p999_ms - expected.p999_ms).abs() < 1e-9);
        assert_eq!((found.count, found.greatest_ms), (1000, 9.999));
        times.add(3_000_000);
        assert_eq!(times.quantiles().unwrap().greatest_ms, 3000.0);
    }
}
