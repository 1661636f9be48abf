//! The ground effect along a height: its parts follow their values at rest late.

use super::{Curve, ModelValues, Segment};

/// The parts of a ground effect, lagged and steady. Rows without a height are skipped.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::flights) struct WakeState {
    lagged: [f64; 2],
    at_rest: Option<[f64; 2]>,
    since_s: f64,
}

impl WakeState {
    /// The ratio of thrusts minus one.
    pub(in crate::flights) fn lift(&self, v: &ModelValues) -> f64 {
        v.curve.lift(self.lagged)
    }

    /// Corrects the height of this row, in R, and the ratio of thrusts by a small difference.
    pub(in crate::flights) fn shift(&mut self, v: &ModelValues, height: f64, by: f64) {
        self.at_rest = Some(v.parts(height));
        // Of q/(1 - q) the slope by q is (1 + ratio)².
        let slope = match v.curve {
            Curve::Empirical | Curve::Images => (1.0 + self.lift(v)).powi(2),
            _ => 1.0,
        };
        self.lagged[0] += by / slope;
    }

    /// One row on, at a height in R and a √T relative to hover.
    pub(in crate::flights) fn step(&mut self, v: &ModelValues, height: f64, dt: f64, root: f64) {
        self.since_s += dt;
        if !height.is_finite() {
            return;
        }
        let now = v.parts(height);
        match self.at_rest {
            None => self.lagged = now,
            Some(before) => {
                let lags_s = v.lags_s(height, root);
                for (k, lag_s) in lags_s.into_iter().enumerate() {
                    self.lagged[k] =
                        follow(self.lagged[k], [before[k], now[k]], self.since_s, lag_s);
                }
            }
        }
        (self.at_rest, self.since_s) = (Some(now), 0.0);
    }
}

/// A lag over one step with linearly changing input; without a lag, the input itself.
pub(in crate::flights) fn follow(state: f64, [from, to]: [f64; 2], dt: f64, lag_s: f64) -> f64 {
    if lag_s > 0.0 && dt > 0.0 {
        let behind = (to - from) / dt * lag_s;
        to - behind + (state - from + behind) * (-dt / lag_s).exp()
    } else {
        to
    }
}

impl Segment {
    /// The ratio of thrusts minus one along the rows with a height, at the √T of hover: time since the row before,
    /// the ratio at rest, the ratio.
    #[must_use]
    pub(in crate::flights) fn wake(&self, values: &ModelValues, bias: f64) -> Vec<[f64; 3]> {
        let mut wake = WakeState::default();
        let mut last_s = None;
        self.time_s
            .iter()
            .zip(&self.height)
            .filter(|(_, z)| z.is_finite())
            .map(|(&t, z)| {
                let dt = t - last_s.unwrap_or(t);
                last_s = Some(t);
                wake.step(values, z + bias, dt, 1.0);
                let lift = values.curve.lift(wake.lagged);
                [dt, values.at_rest(z + bias), lift]
            })
            .collect()
    }
}
