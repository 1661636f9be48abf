//! The height at which a landing that timed out hovered.

use super::steps_of;
use crate::STEP_S;

/// Averaging time of the hover height at the end of a landing, s: 33 correlation times of
/// the turbulence, so that it averages out. The value does not affect the landing itself.
pub const HOVER_WINDOW_S: f64 = 5.0;
/// Greatest mean climb or sink rate of a hover over the deck, m/s, from the first half of the window to the second. Hovers by `feedback` over the
/// default deck have up to 0.0044 after 20 and 40 s (`touchdown land --trials 6`), descents that are not over at least 0.025 after 2, 5 and 8 s.
const STEADY_MPS: f64 = 0.01;

/// The heights of the last [`HOVER_WINDOW_S`] before the timeout, or of the whole landing where that is shorter.
pub(super) struct HoverWindow {
    first: usize,
    middle: usize,
    end: usize,
    sum_m: f64,
    /// Of the second half.
    late_sum_m: f64,
}

impl HoverWindow {
    /// Of a landing that may take so many steps.
    pub(super) fn of(steps: usize) -> Self {
        let first = steps.saturating_sub(steps_of(HOVER_WINDOW_S));
        Self {
            first,
            middle: first + (steps - first) / 2,
            end: steps,
            sum_m: 0.0,
            late_sum_m: 0.0,
        }
    }

    /// Takes the height above the deck after a step, m.
    pub(super) fn push(&mut self, step: usize, height_m: f64) {
        if step >= self.first {
            self.sum_m += height_m;
        }
        if step >= self.middle {
            self.late_sum_m += height_m;
        }
    }

    /// The mean height of a landing that took all steps, m; absent where it still came down or climbed.
    pub(super) fn height_m(&self) -> Option<f64> {
        let rows = [self.middle - self.first, self.end - self.middle].map(|n| n as f64);
        let [early_m, late_m] = [
            (self.sum_m - self.late_sum_m) / rows[0],
            self.late_sum_m / rows[1],
        ];
        // The middles of both halves are half of the window apart.
        let rate_mps = (late_m - early_m) / (0.5 * (rows[0] + rows[1]) * STEP_S);
        (rate_mps.abs() <= STEADY_MPS).then_some(self.sum_m / (rows[0] + rows[1]))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// The hover height of a landing of the given duration with heights over time.
    fn hover(duration_s: f64, height_m: impl Fn(f64) -> f64) -> Option<f64> {
        let mut window = HoverWindow::of(steps_of(duration_s));
        for step in 0..steps_of(duration_s) {
            window.push(step, height_m((step + 1) as f64 * STEP_S));
        }
        window.height_m()
    }

    #[test]
    fn analytic_a_hover_has_a_height_and_a_descent_has_none() {
        // A descent of 0.1 m/s that ends in a hover at 0.2 m after 4 s, over a heave of 2 cm and 2 s.
        let height = |t: f64| (0.6 - 0.1 * t).max(0.2) + 0.02 * (TAU * t / 2.0).sin();
        for duration_s in [0.5, 2.0, 4.0, 6.0] {
            assert_eq!(hover(duration_s, height), None, "{duration_s} s");
        }
        // 5 s are 2.5 periods of the heave: half a period is left, with a mean of 0.02 m · 2/π, for a fifth of the time. Sums of steps of 1 ms err by less than 1e-6.
        let settled_m = hover(12.0, height).expect("it hovers");
        assert!(
            (settled_m - 0.2).abs() < 0.02 * 4.0 / TAU / 5.0 + 1e-6,
            "{settled_m}"
        );
        // A climb is no hover either.
        assert_eq!(hover(12.0, |t| 0.2 + 0.05 * t), None);
        // Landings of one step and of none have no rate.
        assert_eq!([hover(STEP_S, |_| 0.2), hover(0.0, |_| 0.2)], [None; 2]);
    }
}
