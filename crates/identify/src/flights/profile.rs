//! Error of a fit as a function of one of its lags (profile): how well the data identify it.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::fit::{Fit, fit, settle};
use super::ground::{Basis, GroundEffect};
use super::model::ModelTerms;
use super::resampling::prior;

/// Lags that are tried.
const POINTS: usize = 31;
/// The least and the greatest of them, over the fitted one.
/// Wide enough to show both walls of the valley for lags that are resolved; it only scales a figure.
const FACTORS: [f64; 2] = [0.25, 3.0];
/// Errors are limited to this number of standard deviations.
/// As in the choice of the model, which it explains.
const CLIP: f64 = 4.0;

/// Error over a lag.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Profile {
    /// The lag.
    pub name: &'static str,
    /// Its values (s).
    pub lag_s: Vec<f64>,
    /// Root mean square error of the specific force (gravities), with all else fitted to that lag.
    pub rmse: Vec<f64>,
    /// Whether the model has this lag.
    pub taken: bool,
}

impl GroundEffect {
    /// Errors over the lag of the motors and over that of the wake, where there can be one.
    #[must_use]
    pub fn lag_profiles(&self) -> Vec<Profile> {
        if self.basis != Basis::Accelerometer || !self.fit.shape.motor_lag {
            return Vec::new();
        }
        let mut out = Vec::new();
        out.extend(self.profile(&self.fit, "T_m", "motors", true));
        let shape = self.fit.shape;
        if shape.wake_lag {
            out.extend(self.profile(&self.fit, "tau", "wake", true));
        } else if shape.curve != super::model::Curve::Free {
            let with = ModelTerms {
                wake_lag: true,
                ..shape
            };
            let with = fit(&self.pieces, with, Some(&self.fit)).settled(&self.pieces);
            out.extend(self.profile(&with, "tau", "wake", false));
        }
        out
    }

    fn profile(&self, fit: &Fit, key: &str, name: &'static str, taken: bool) -> Option<Profile> {
        let at = fit.index(key)?;
        let parameters = fit.shape.parameters();
        let (matrix, _) = prior(fit);
        let matrix = fit.reduced.iter().fold(matrix, |sum, r| sum + &r.matrix);
        // The other numbers follow the lag along the valley of the squares, but those at their bound.
        let free = |i: &usize| *i != at && !fit.held.contains(i);
        let others: Vec<usize> = (0..fit.theta.len()).filter(free).collect();
        let n = others.len();
        let inner = DMatrix::from_fn(n, n, |i, k| matrix[(others[i], others[k])]);
        let along = DVector::from_fn(n, |i, _| matrix[(others[i], at)]);
        let follow = inner.cholesky()?.solve(&along);
        let [low, high] = FACTORS.map(|f| (f * fit.theta[at]).max(parameters[at].min));
        let mut out = Profile {
            name,
            lag_s: Vec::new(),
            rmse: Vec::new(),
            taken,
        };
        for k in 0..POINTS {
            let lag = low * (high / low).powf(k as f64 / (POINTS - 1) as f64);
            let mut theta = fit.theta.clone();
            theta[at] = lag;
            for (i, &other) in others.iter().enumerate() {
                let p = parameters[other];
                theta[other] =
                    (theta[other] - follow[i] * (lag - fit.theta[at])).clamp(p.min, p.max);
            }
            let (sum, rows) = self.pieces.iter().zip(&fit.locals).fold(
                (0.0, 0.0),
                |(sum, rows), (piece, local)| {
                    let (_, of) = settle(piece, fit, &theta, *local, CLIP * fit.sigma, &|_| true);
                    (sum + of.plain, rows + of.rows)
                },
            );
            out.lag_s.push(lag);
            out.rmse.push((sum / f64::max(rows, 1.0)).sqrt());
        }
        Some(out)
    }
}
