//! Figures of a landing, as in Section IV-D of the paper.

use crate::kernel::Sum;
use crate::real::{Real, r};
use crate::touchdown::{TouchdownDetector, TouchdownState};

/// Accumulates the figures of a landing, up to touchdown:
///
/// - `T_L`, the time of touchdown, s;
/// - `V_L = |v(T_L)|`, the relative velocity there, m/s;
/// - `S_L = ∫ |v| dt`, the relative path, m (trapezoid rule; a descent without
///   reversal has the height descended).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LandingMetrics<R: Real> {
    /// Detector of the touchdown.
    pub detector: TouchdownDetector<R>,
}

/// State of [`LandingMetrics`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LandingMetricsState<R> {
    touchdown: TouchdownState<R>,
    path: Sum<R>,
    /// Time and speed of the last sample.
    last: Option<(R, R)>,
}

/// The figures so far.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LandingFigures<R> {
    /// T_L, s; `None` before touchdown.
    pub t_l_s: Option<R>,
    /// V_L, m/s; `None` before touchdown.
    pub v_l_mps: Option<R>,
    /// S_L until touchdown or, before it, until now, m.
    pub s_l_m: R,
}

impl<R: Real> LandingMetrics<R> {
    /// Adds the sample `dt` seconds after the previous one; see
    /// [`TouchdownDetector::step`].
    pub fn step(
        &self,
        state: &mut LandingMetricsState<R>,
        height_m: R,
        relative_velocity_mps: R,
        dt: R,
    ) -> LandingFigures<R> {
        let landed = state.touchdown.touchdown().is_some();
        let touchdown =
            self.detector
                .step(&mut state.touchdown, height_m, relative_velocity_mps, dt);
        if !landed && height_m.is_finite() && relative_velocity_mps.is_finite() {
            let (time_s, speed) = match touchdown {
                Some(t) => (t.time_s, t.relative_velocity_mps.abs()),
                None => (state.touchdown.time_s(), relative_velocity_mps.abs()),
            };
            if let Some((last_time_s, last_speed)) = state.last {
                state
                    .path
                    .add(r::<R>(0.5) * (speed + last_speed) * (time_s - last_time_s));
            }
            state.last = Some((time_s, speed));
        }
        Self::figures(state)
    }

    /// The figures so far.
    #[must_use]
    pub fn figures(state: &LandingMetricsState<R>) -> LandingFigures<R> {
        let touchdown = state.touchdown.touchdown();
        LandingFigures {
            t_l_s: touchdown.map(|t| t.time_s),
            v_l_mps: touchdown.map(|t| t.relative_velocity_mps.abs()),
            s_l_m: state.path.value(),
        }
    }
}
