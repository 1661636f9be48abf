//! Histogram of the steps between stamps, in constant memory.

/// Bins to a doubling.
const FINE: f64 = 8.0;
/// Shorter steps share the first bin, in ns.
const SHORTEST_NS: f64 = 64.0;
/// Bins: from 64 ns to 64 ns · 2⁴⁶, a month and a half.
const BINS: usize = 46 * 8;
/// Least length of a gap, in median steps. It equals the limit of interpolation in `join.rs`.
const GAP_STEPS: f64 = 10.0;
/// Least length of a gap, s, as in `join.rs`.
const SHORTEST_GAP_S: f64 = 0.05;

/// Counts and sums of steps by their size.
#[derive(Debug, Clone)]
pub(crate) struct Steps {
    count: Vec<u32>,
    sum_s: Vec<f64>,
    longest_s: f64,
    total: u64,
    /// Number of stamps that are not after the previous one.
    pub(crate) backward: usize,
    last_ns: Option<i64>,
}

impl Default for Steps {
    fn default() -> Self {
        Self {
            count: vec![0; BINS],
            sum_s: vec![0.0; BINS],
            longest_s: 0.0,
            total: 0,
            backward: 0,
            last_ns: None,
        }
    }
}

/// Rate and gaps of a topic's stamps.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct StepsSummary {
    /// Messages per second, without the gaps.
    pub(crate) rate_hz: Option<f64>,
    pub(crate) longest_s: Option<f64>,
    pub(crate) gaps: usize,
    pub(crate) gaps_s: f64,
}

impl Steps {
    #[inline]
    pub(crate) fn push(&mut self, stamp_ns: i64) {
        let Some(last) = self.last_ns else {
            self.last_ns = Some(stamp_ns);
            return;
        };
        let step_ns = stamp_ns.saturating_sub(last);
        if step_ns <= 0 {
            self.backward += 1;
            // After a single stray stamp far ahead, later stamps must not count as backward.
            self.last_ns = Some(stamp_ns);
            return;
        }
        self.last_ns = Some(stamp_ns);
        let bin = ((step_ns as f64 / SHORTEST_NS).log2() * FINE).clamp(0.0, BINS as f64 - 1.0);
        let step_s = step_ns as f64 * 1e-9;
        self.count[bin as usize] = self.count[bin as usize].saturating_add(1);
        self.sum_s[bin as usize] += step_s;
        self.longest_s = self.longest_s.max(step_s);
        self.total += 1;
    }

    pub(crate) fn summary(&self) -> StepsSummary {
        let mut below = 0;
        let median = (0..BINS).find(|&bin| {
            below += u64::from(self.count[bin]);
            2 * below >= self.total.max(1)
        });
        let Some(median_s) = median.map(|bin| self.sum_s[bin] / f64::from(self.count[bin])) else {
            return StepsSummary::default();
        };
        let gap_s = (GAP_STEPS * median_s).max(SHORTEST_GAP_S);
        let (mut steps, mut sum_s, mut gaps, mut gaps_s) = (0.0, 0.0, 0, 0.0);
        for (&count, &bin_s) in self.count.iter().zip(&self.sum_s) {
            if count > 0 && bin_s / f64::from(count) < gap_s {
                steps += f64::from(count);
                sum_s += bin_s;
            } else {
                gaps += count as usize;
                gaps_s += bin_s;
            }
        }
        StepsSummary {
            rate_hz: (sum_s > 0.0).then(|| steps / sum_s),
            longest_s: Some(self.longest_s),
            gaps,
            gaps_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_rate_and_gaps() {
        let mut steps = Steps::default();
        for i in 0..1000 {
            // 250 Hz with a hole of 2 s after 500.
            steps.push(4_000_000 * i + if i > 500 { 2_000_000_000 } else { 0 });
        }
        let found = steps.summary();
        assert!((found.rate_hz.unwrap() - 250.0).abs() < 1e-6);
        assert_eq!(found.gaps, 1);
        assert!((found.longest_s.unwrap() - 2.004).abs() < 1e-12);
        assert_eq!(Steps::default().summary(), StepsSummary::default());
        steps.push(0);
        steps.push(0);
        assert_eq!(steps.backward, 2);
    }
}
