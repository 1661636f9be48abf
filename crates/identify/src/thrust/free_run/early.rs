//! Thrust that answers before its command: a throttle that was logged after it acted, or by another clock.
//!
//! A dead time below zero is no property of a motor. But a lag that is fitted without it takes in a part of it, and is wrong
//! beyond its interval.

use sindy::numerics::golden_section;

use super::interval::{Resolved, STEPS, Threshold};
use super::solve::{Free, LONGEST_DEAD_TIME_S, Problem, Solution};

/// Times by which thrust is tried to be early, in periods of the log. Half of one is that of a logger that writes the last
/// command of each period, long ones are those of two clocks.
const PERIODS: [f64; 8] = [0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0, 13.0];
/// Share of a period that the time is sought to: less than the periods of a logger vary.
const NEAR: f64 = 0.05;

/// An answer before its command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Early {
    /// How much sooner the thrust answers (s).
    pub early_s: f64,
    /// The lag then.
    pub lag: Resolved,
    /// Whether a log of this period may show it though nothing is wrong: a row has the last command of its period, which may
    /// have come at any time within it.
    pub within_period: bool,
}

impl Problem<'_> {
    /// By how much the thrust answers early, where that fits better than noise explains and the lag is outside of the interval
    /// that was found without.
    pub(super) fn early(
        &self,
        at: &Solution,
        free: Free,
        lag: Resolved,
        threshold: &Threshold,
    ) -> Option<Early> {
        let within = match lag {
            Resolved::Within(estimate) => estimate.ci95,
            Resolved::Below { bound, .. } => [0.0, bound],
            Resolved::AtBound { .. } => return None,
        };
        let answers = |early_s: f64| {
            let start = Solution {
                dead_time_s: -early_s,
                // Slow commands show the sum of both.
                lag_s: at.lag_s + early_s,
                ..at.clone()
            };
            self.refine(start, free, None, STEPS)
        };
        let tried: Vec<f64> = PERIODS
            .iter()
            .map(|periods| periods * self.period_s)
            .take_while(|early_s| *early_s <= LONGEST_DEAD_TIME_S)
            .collect();
        let found: Vec<f64> = tried.iter().map(|t| answers(*t).squares).collect();
        let best = (0..tried.len()).min_by(|a, b| found[*a].total_cmp(&found[*b]))?;
        if at.squares - found[best] <= threshold.squares {
            return None;
        }
        let low = best.checked_sub(1).map_or(0.0, |k| tried[k]);
        let high = tried.get(best + 1).copied().unwrap_or(tried[best]);
        let wide = |low: f64, high: f64| high - low > NEAR * self.period_s;
        let [low, high] = golden_section([low, high], wide, |early_s| answers(early_s).squares);
        let early_s = 0.5 * (low + high);
        let best = answers(early_s);
        let other = !(within[0]..=within[1]).contains(&best.lag_s);
        other.then(|| Early {
            early_s,
            lag: self.lag(&best, free, threshold),
            within_period: early_s <= self.period_s,
        })
    }
}
