//! Noise of sensors and air, and the search for its likeliest values.

use serde::Serialize;

use crate::flights::fit::Fit;

/// Noise of the sensors and of the air, standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Noise {
    /// Accelerometer, per sample (gravities).
    pub force: f64,
    /// Range, per sample (m).
    pub range_m: f64,
    /// Climb rate, per sample (m/s).
    pub climb_mps: f64,
    /// Turbulence (gravities).
    pub gust: f64,
    /// Its correlation time (s).
    pub gust_s: f64,
}

/// Least and greatest of each noise, in the order of [`Noise`].
/// From below the last digit of any sensor to the size of the motion itself.
const BOUNDS: [[f64; 2]; 5] = [
    [1e-4, 1.0],
    [1e-5, 0.3],
    [1e-4, 2.0],
    [1e-4, 0.5],
    [0.03, 3.0],
];
/// Steps of the search in logarithms, first and last: a noise known to 3 % moves no number by a tenth of its standard error.
/// Later rounds start from a quarter, for the model has hardly moved.
const FIRST: f64 = 0.4;
const LATER: f64 = 0.1;
const LAST: f64 = 0.03;
/// Decrease of minus twice the log-likelihood below which the steps are halved.
const LITTLE: f64 = 0.5;

impl Noise {
    /// Where the search starts: usual range finders and calm air.
    pub(super) fn first(start: &Fit) -> Self {
        Self {
            force: start.sigma.clamp(1e-3, 0.3),
            range_m: 0.003,
            climb_mps: 0.05,
            gust: 0.01,
            gust_s: start
                .colour
                .map_or(0.3, |c| c.time_s)
                .clamp(BOUNDS[4][0], BOUNDS[4][1]),
        }
    }

    fn values(self) -> [f64; 5] {
        [
            self.force,
            self.range_m,
            self.climb_mps,
            self.gust,
            self.gust_s,
        ]
    }

    fn of([force, range_m, climb_mps, gust, gust_s]: [f64; 5]) -> Self {
        Self {
            force,
            range_m,
            climb_mps,
            gust,
            gust_s,
        }
    }

    fn scaled(self, k: usize, by: f64) -> Self {
        let mut values = self.values();
        values[k] = (values[k] * by).clamp(BOUNDS[k][0], BOUNDS[k][1]);
        Self::of(values)
    }

    /// The noise of least cost, one after the other by steps in its logarithm.
    pub(super) fn likeliest(self, cost: f64, anew: bool, of: impl Fn(Self) -> f64) -> (Self, f64) {
        let (mut noise, mut best) = (self, cost);
        let mut step = if anew { FIRST } else { LATER };
        while step > LAST {
            let before = best;
            for k in 0..BOUNDS.len() {
                for by in [step.exp(), (-step).exp()] {
                    let tried = noise.scaled(k, by);
                    if tried == noise {
                        continue;
                    }
                    let cost = of(tried);
                    if cost < best {
                        (noise, best) = (tried, cost);
                        break;
                    }
                    // The noise of a sensor that was not logged moves nothing, in either direction.
                    if cost.to_bits() == best.to_bits() {
                        break;
                    }
                }
            }
            if before - best < LITTLE {
                step *= 0.5;
            }
        }
        (noise, best)
    }
}
