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
    /// Climb rate, per sample (m/s); infinite where that is a filter's and counts for nothing.
    pub climb_mps: f64,
    /// Turbulence (gravities).
    pub gust: f64,
    /// Its correlation time (s).
    pub gust_s: f64,
    /// Motion of the ground; absent where it rests.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground: Option<GroundMotion>,
}

/// Heave of the ground below a range finder, as that of a deck: white noise through an oscillator of one frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GroundMotion {
    /// Its speed, standard deviation (m/s).
    pub speed_mps: f64,
    /// Its period (s).
    pub period_s: f64,
    /// Its damping over the critical one: how wide its spectrum is.
    pub damping: f64,
}

/// Numbers of the noise of sensors and air, and of that with a moving ground.
const AT_REST: usize = 5;
const ALL: usize = 8;

/// Least and greatest of each noise, in the order of [`Noise`].
/// From below the last digit of any sensor to the size of the motion itself; decks from a sine to a sea of all periods.
const BOUNDS: [[f64; 2]; ALL] = [
    [1e-4, 1.0],
    [1e-5, 0.3],
    [1e-4, 2.0],
    [1e-4, 0.5],
    [0.03, 3.0],
    [1e-3, 5.0],
    [0.3, 30.0],
    [0.01, 1.0],
];
/// Heaves from which the search starts: decks have 0.1 m/s or so, periods of 1 to 12 s, spectra of half an octave.
const GROUND_MPS: f64 = 0.1;
const GROUND_S: [f64; 4] = [1.5, 3.0, 6.0, 12.0];
const GROUND_DAMPING: f64 = 0.3;
/// Steps of the search in logarithms, first and last: a noise known to 3 % moves no number by a tenth of its standard error.
/// Later rounds start from a quarter, for the model has hardly moved.
const FIRST: f64 = 0.4;
const LATER: f64 = 0.1;
const LAST: f64 = 0.03;
/// Decrease of minus twice the log-likelihood below which the steps are halved.
const LITTLE: f64 = 0.5;

/// An oscillator over one step: what its speed and its acceleration keep of one another, and the covariance that they gain.
pub(super) struct Oscillation {
    pub(super) keep: [[f64; 2]; 2],
    pub(super) gain: [[f64; 2]; 2],
}

impl GroundMotion {
    /// Angular frequency (rad/s).
    pub(super) fn frequency(self) -> f64 {
        std::f64::consts::TAU / self.period_s
    }

    /// Speed `w` and acceleration `a` over a step, exact: `w' = a`, `a' = -ω² w - 2 ζ ω a + noise`. In the mean of all times they are
    /// independent, with standard deviations σ and ω σ; what a step takes from that, noise gives back.
    pub(super) fn over(self, dt: f64) -> Oscillation {
        let (w, damping) = (self.frequency(), self.damping);
        let fading = (-damping * w * dt).exp();
        let turning = w * (1.0 - damping * damping).max(0.0).sqrt();
        let (sine, cosine) = (turning * dt).sin_cos();
        // sin(x)/x of an oscillator that is critically damped is 1.
        let share = if turning > 0.0 { sine / turning } else { dt };
        let keep = [
            [fading * (cosine + damping * w * share), fading * share],
            [
                -fading * w * w * share,
                fading * (cosine - damping * w * share),
            ],
        ];
        let steady = [self.speed_mps.powi(2), (w * self.speed_mps).powi(2)];
        let gain = [0, 1].map(|i| {
            [0, 1].map(|j| {
                let of = |k: usize| keep[i][k] * steady[k] * keep[j][k];
                f64::from(u8::from(i == j)) * steady[i] - of(0) - of(1)
            })
        });
        Oscillation { keep, gain }
    }
}

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
            ground: None,
        }
    }

    /// What it says of the ground and of the logged climb rate, by key; nothing where the ground rests and climb rates count.
    pub(in crate::flights) fn in_words(self) -> Vec<(String, String)> {
        let ground = self.ground.map(|g| {
            let words = format!(
                "moves, as found with the model: {:.3} m/s (standard deviation of its speed), period {:.2} s",
                g.speed_mps, g.period_s
            );
            ("ground".to_string(), words)
        });
        let climb = self.climb_mps.is_infinite().then(|| {
            let words = "left out: its errors go on from one to the next, as those of a filter do";
            ("climb rate".to_string(), words.to_string())
        });
        ground.into_iter().chain(climb).collect()
    }

    /// Whether it is of a ground that moves, or of climb rates that count for nothing.
    pub(in crate::flights) fn is_of_others(self) -> bool {
        self.ground.is_some() || self.climb_mps.is_infinite()
    }

    /// The same, where climb rates count for nothing.
    pub(super) fn without_climb_rate(self) -> Self {
        Self {
            climb_mps: f64::INFINITY,
            ..self
        }
    }

    /// The same above a ground that moves, for each period from which a search starts.
    pub(super) fn above_moving_ground(self) -> [Self; GROUND_S.len()] {
        GROUND_S.map(|period_s| Self {
            ground: Some(GroundMotion {
                speed_mps: GROUND_MPS,
                period_s,
                damping: GROUND_DAMPING,
            }),
            ..self
        })
    }

    fn many(self) -> usize {
        if self.ground.is_some() { ALL } else { AT_REST }
    }

    /// All values; those of a ground at rest are not used.
    fn values(self) -> [f64; ALL] {
        let ground = self
            .ground
            .map_or([0.0; 3], |g| [g.speed_mps, g.period_s, g.damping]);
        [
            self.force,
            self.range_m,
            self.climb_mps,
            self.gust,
            self.gust_s,
            ground[0],
            ground[1],
            ground[2],
        ]
    }

    fn scaled(self, k: usize, by: f64) -> Self {
        let mut values = self.values();
        if values[k].is_infinite() {
            return self;
        }
        values[k] = (values[k] * by).clamp(BOUNDS[k][0], BOUNDS[k][1]);
        let [
            force,
            range_m,
            climb_mps,
            gust,
            gust_s,
            speed_mps,
            period_s,
            damping,
        ] = values;
        Self {
            force,
            range_m,
            climb_mps,
            gust,
            gust_s,
            ground: self.ground.map(|_| GroundMotion {
                speed_mps,
                period_s,
                damping,
            }),
        }
    }

    /// The noise of least cost, one after the other by steps in its logarithm.
    pub(super) fn likeliest(self, cost: f64, anew: bool, of: impl Fn(Self) -> f64) -> (Self, f64) {
        let (mut noise, mut best) = (self, cost);
        let mut step = if anew { FIRST } else { LATER };
        while step > LAST {
            let before = best;
            for k in 0..self.many() {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_the_ground_swings_with_its_period_and_keeps_its_variance() {
        let ground = GroundMotion {
            speed_mps: 0.2,
            period_s: 2.0,
            damping: 0.01,
        };
        // After a quarter of a period speed has become acceleration, but for what damping takes: 1 - e^(-0.01 π/2).
        let Oscillation { keep, .. } = ground.over(0.5);
        let w = std::f64::consts::PI;
        assert!(keep[0][0].abs() < 0.02 && (keep[1][0] / w + 1.0).abs() < 0.02);
        // From rest the noise brings it to its variances; after 60 s all but e^(-2·0.01·60 π) = 0.02 of them are there.
        let Oscillation { keep, gain } = ground.over(0.01);
        let mut p = [[0.0; 2]; 2];
        for _ in 0..6000 {
            let half: [[f64; 2]; 2] =
                [0, 1].map(|i| [0, 1].map(|j| keep[i][0] * p[0][j] + keep[i][1] * p[1][j]));
            p = [0, 1].map(|i| {
                [0, 1].map(|j| half[i][0] * keep[j][0] + half[i][1] * keep[j][1] + gain[i][j])
            });
        }
        assert!((p[0][0] / 0.04 - 1.0).abs() < 0.03, "{p:?}");
        assert!((p[1][1] / (0.04 * w * w) - 1.0).abs() < 0.03, "{p:?}");
        assert!(p[0][1].abs() < 1e-3 * w * 0.04, "{p:?}");
    }
}
