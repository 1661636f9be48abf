//! A sample of any number of values in bounded memory, for medians and percentiles.

/// Reservoir sample: all values up to a number, and then a uniform random sample of that size. The
/// generator is seeded, so the sample is reproducible.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    values: Vec<f64>,
    most: usize,
    seen: u64,
    state: u64,
}

impl Sample {
    pub(crate) fn new(most: usize) -> Self {
        Self {
            values: Vec::new(),
            most,
            seen: 0,
            state: 0,
        }
    }

    #[inline]
    pub(crate) fn push(&mut self, value: f64) {
        self.seen += 1;
        if self.values.len() < self.most {
            self.values.push(value);
            return;
        }
        // Knuth's MMIX generator; its high bits are scaled to the number of values so far.
        let state = self.state.wrapping_mul(6_364_136_223_846_793_005);
        self.state = state.wrapping_add(1_442_695_040_888_963_407);
        let at = (u128::from(self.state) * u128::from(self.seen)) >> 64;
        let place = usize::try_from(at).ok();
        if let Some(kept) = place.and_then(|place| self.values.get_mut(place)) {
            *kept = value;
        }
    }

    /// The values in order of size.
    pub(crate) fn sorted(&self) -> Vec<f64> {
        let mut sorted = self.values.clone();
        sorted.sort_by(f64::total_cmp);
        sorted
    }
}

/// Median of sorted values.
pub(crate) fn median(sorted: &[f64]) -> Option<f64> {
    let upper = *sorted.get(sorted.len() / 2)?;
    if sorted.len().is_multiple_of(2) {
        let lower = sorted[sorted.len() / 2 - 1];
        return Some(lower / 2.0 + upper / 2.0);
    }
    Some(upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_few_values_are_all_kept_and_many_are_drawn_from_evenly() {
        let mut few = Sample::new(10);
        [3.0, 1.0, 2.0].into_iter().for_each(|v| few.push(v));
        assert_eq!(few.sorted(), [1.0, 2.0, 3.0]);
        assert_eq!(median(&few.sorted()), Some(2.0));
        let mut many = Sample::new(4096);
        (0..1_000_000).for_each(|i| many.push(f64::from(i)));
        let sorted = many.sorted();
        assert_eq!(sorted.len(), 4096);
        // Quantiles of 4096 draws scatter by at most 0.5 / sqrt(4096) = 0.8 % of all; five times that.
        for part in [0.1, 0.5, 0.9] {
            let found = sorted[(part * 4096.0) as usize];
            assert!((found - 1e6 * part).abs() < 0.04 * 1e6, "{part}: {found}");
        }
    }
}
