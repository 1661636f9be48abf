//! The accelerometer of the vertical vehicle: late by its stamps, or behind low-pass filters.

use super::{STEP_S, Vehicle};

/// Specific force (gravities) as the accelerometer's electronics give it, without its noise.
pub(super) struct Accelerometer {
    late_s: f64,
    /// Angular frequency of the cutoff (rad/s); 0 without a filter.
    cutoff: f64,
    /// Share of the difference that a filter of first order keeps over a step; 0 without one.
    keep: f64,
    past: Vec<f64>,
    filtered: [f64; 2],
    smooth: f64,
}

impl Accelerometer {
    pub(super) fn of(v: &Vehicle) -> Self {
        Self {
            late_s: v.accelerometer_late_s,
            cutoff: std::f64::consts::TAU * v.accelerometer_cutoff_hz,
            keep: (-STEP_S / v.accelerometer_lag_s).exp(),
            past: Vec::new(),
            filtered: [1.0, 0.0],
            smooth: 1.0,
        }
    }

    /// One step of the simulation: the force that the accelerometer shows.
    pub(super) fn step(&mut self, force: f64) -> f64 {
        self.past.push(force);
        let steps = self.late_s / STEP_S;
        let (whole, share) = (steps.floor() as usize, steps.fract());
        let at = |ago: usize| self.past[(self.past.len() - 1).saturating_sub(ago)];
        let late = if share > 0.0 {
            (1.0 - share) * at(whole) + share * at(whole + 1)
        } else {
            at(whole)
        };
        self.smooth = late + self.keep * (self.smooth - late);
        if self.cutoff == 0.0 {
            return self.smooth;
        }
        // Butterworth's of second order, semi-implicit: y'' = ω² (x - y) - √2 ω y'.
        let [y, rate] = &mut self.filtered;
        let w = self.cutoff;
        *rate = (*rate + STEP_S * w * w * (self.smooth - *y)) / (1.0 + STEP_S * 2f64.sqrt() * w);
        *y += STEP_S * *rate;
        *y
    }
}
