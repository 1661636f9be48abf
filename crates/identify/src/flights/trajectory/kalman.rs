//! A Kalman filter of height, climb rate, turbulence and errors, with its innovations; over a ground that moves, of that motion, too.

use std::ops::SubAssign as _;

use nalgebra::{RowSVector, SMatrix, SVector};

use super::Noise;
use super::noise::Oscillation;
use crate::flights::fit::SegmentOffsets;
use crate::flights::model::Segment;
use crate::flights::normal::HUBER;

/// Height above the ground (m), climb rate (m/s), turbulence (g), accelerometer's error (g), thrust scale, height error (R), error
/// of the lagged ground effect.
pub(super) const AT_REST: usize = 7;
/// The same, the ground's climb rate (m/s) and acceleration (m/s²), and how late the range is (s).
pub(super) const MOVING: usize = 10;
pub(super) type State<const N: usize> = SVector<f64, N>;
type RowState<const N: usize> = RowSVector<f64, N>;
type Covariance<const N: usize> = SMatrix<f64, N, N>;

/// What is known of a thrust scale beforehand, standard deviation: the throttle of hover gives it to a few per cent.
const SCALE_SD: f64 = 0.3;
/// What is known of an accelerometer's error beforehand, standard deviation (gravities): a calibrated one errs by 0.2 m/s².
const ERROR_SD: f64 = 0.02;
/// How late a range is beforehand, standard deviation (s): range finders and their links take 0.01 to 0.04 s.
const LATE_SD_S: f64 = 0.02;
/// Climb rate where a motion starts, standard deviation (m/s).
const START_MPS: f64 = 1.0;
/// Height where a motion starts, standard deviation beside three times that of the range (m).
const START_M: f64 = 0.02;
/// Asymmetry of the covariance, over the standard deviations, from which it is taken away.
/// Rounding makes one of 1e-16. Where the ground effect follows the height late, the motion is unstable: over the small rotors of
/// a vehicle of 30 g, 50 s make a variance negative. Below this bound no figure moves in its first five digits.
const ASYMMETRIC: f64 = 1e-6;

/// What is measured.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(super) enum Sensor {
    Range,
    ClimbRate,
    Accelerometer,
}

/// One innovation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Innovation {
    /// Of what.
    pub(super) sensor: Sensor,
    /// When (s).
    pub(super) time_s: f64,
    /// Its value over its standard deviation; that of a blow counts less.
    pub(super) value: f64,
    /// Its part of minus twice the log-likelihood.
    pub(super) cost: f64,
}

/// What the filter gives along one run.
pub(super) struct Pass {
    /// All innovations, in the order of their rows.
    pub(super) innovations: Vec<Innovation>,
    /// Minus twice the log-likelihood.
    pub(super) cost: f64,
    /// Scale and height error of the run as known at its end.
    pub(super) local: SegmentOffsets,
    /// Latency of the range as known at its end, and its standard error (s); absent over a ground at rest.
    pub(super) range_latency_s: Option<[f64; 2]>,
}

/// Specific force over the scale, and its slopes by climb rate (s/m) and ground effect.
pub(super) struct Modelled {
    pub(super) force: f64,
    pub(super) by_climb: f64,
    pub(super) by_lift: f64,
}

pub(super) fn unit<const N: usize>(k: usize) -> State<N> {
    let mut out = State::zeros();
    out[k] = 1.0;
    out
}

/// A vector of all states from that of a ground at rest.
pub(super) fn padded<const N: usize>(of: [f64; AT_REST]) -> State<N> {
    State::from_fn(|k, _| of.get(k).copied().unwrap_or(0.0))
}

/// One step of the filter.
pub(super) struct Step {
    pub(super) dt: f64,
    /// Vertical acceleration of a specific force of one gravity (m/s²).
    pub(super) up: f64,
    pub(super) gravity: f64,
    /// Share of the way to its rest that the ground effect goes in the step.
    pub(super) follows: f64,
    /// Slope of the ground effect at rest by height (1/R).
    pub(super) bend: f64,
    pub(super) radius_m: f64,
}

/// A measurement beside what the filter expected.
pub(super) struct Seen {
    pub(super) sensor: Sensor,
    pub(super) time_s: f64,
    pub(super) miss: f64,
    pub(super) sd: f64,
}

impl Seen {
    pub(super) fn of(sensor: Sensor, time_s: f64, miss: f64, sd: f64) -> Self {
        Self {
            sensor,
            time_s,
            miss,
            sd,
        }
    }
}

/// A Kalman filter with its innovations.
pub(super) struct Filter<const N: usize> {
    pub(super) mean: State<N>,
    pub(super) covariance: Covariance<N>,
    pub(super) innovations: Vec<Innovation>,
    pub(super) cost: f64,
    /// The vehicle's acceleration over the last step (m/s²).
    acceleration_mps2: f64,
}

impl<const N: usize> Filter<N> {
    pub(super) fn of(piece: &Segment) -> Self {
        let known = [
            0.0,
            0.0,
            0.0,
            ERROR_SD.powi(2),
            SCALE_SD.powi(2),
            piece.bias_sd.powi(2),
            0.0,
        ];
        let mut known: State<N> = padded(known);
        if let Some(late) = known.get_mut(9) {
            *late = LATE_SD_S * LATE_SD_S;
        }
        Self {
            mean: unit(4),
            covariance: Covariance::from_diagonal(&known),
            innovations: Vec::with_capacity(2 * piece.rows.len()),
            cost: 0.0,
            acceleration_mps2: 0.0,
        }
    }

    /// A motion starts: height as measured, climb rate and turbulence unknown; scale and errors go on.
    pub(super) fn start(&mut self, height_m: f64, noise: Noise) {
        let known = [
            (0, height_m, 3.0 * noise.range_m + START_M),
            (1, 0.0, START_MPS),
            (2, 0.0, noise.gust),
        ];
        let ground = noise
            .ground
            .map(|g| [(7, 0.0, g.speed_mps), (8, 0.0, g.speed_mps * g.frequency())]);
        self.acceleration_mps2 = 0.0;
        for (k, mean, sd) in known.into_iter().chain(ground.into_iter().flatten()) {
            self.mean[k] = mean;
            self.covariance.row_mut(k).fill(0.0);
            self.covariance.column_mut(k).fill(0.0);
            self.covariance[(k, k)] = sd * sd;
        }
    }

    /// Climb rate over the ground.
    pub(super) fn closing_mps(&self) -> f64 {
        self.mean[1] - self.mean.get(7).copied().unwrap_or(0.0)
    }

    /// Height over the ground at the time of a range that is late (m), by the motion now, and its slopes by the states.
    ///
    /// To the second order of the latency: at 0.1 s the first alone errs by a centimetre where a vehicle accelerates by 2 m/s², which
    /// passes for a ground that moves.
    pub(super) fn height_of_range(&self) -> (f64, State<N>) {
        let mut along = unit(0);
        let Some(&late_s) = self.mean.get(9) else {
            return (self.mean[0], along);
        };
        let closing = self.closing_mps();
        let acceleration = self.acceleration_mps2 - self.mean[8];
        (along[1], along[7], along[8]) = (-late_s, late_s, -0.5 * late_s * late_s);
        along[9] = late_s * acceleration - closing;
        let height = self.mean[0] - late_s * (closing - 0.5 * late_s * acceleration);
        (height, along)
    }

    /// The ground effect is that at rest, as uncertain as the height makes it.
    pub(super) fn lift_at_rest(&mut self, bend: f64, radius_m: f64) {
        self.transform(&[(6, &[(0, bend / radius_m), (5, bend)])]);
        self.mean[6] = 0.0;
    }

    /// One row on.
    pub(super) fn predict(&mut self, model: &Modelled, step: &Step, noise: Noise) {
        let Step { dt, up, .. } = *step;
        let scale = self.mean[4];
        let acceleration = up * (scale * model.force + self.mean[2]) - step.gravity;
        self.acceleration_mps2 = acceleration;
        self.mean[0] += dt * (self.mean[1] + 0.5 * dt * acceleration);
        self.mean[1] += dt * acceleration;
        let keep = (-dt / noise.gust_s).exp();
        self.mean[2] *= keep;
        let by = [
            (1, scale * model.by_climb),
            (2, 1.0),
            (4, model.force),
            (6, scale * model.by_lift),
        ];
        let mut climb = by.map(|(k, by)| (k, dt * up * by));
        climb[0].1 += 1.0;
        let [mut height_by_climb, turbulence, force, of_lift] =
            by.map(|(k, by)| (k, 0.5 * dt * dt * up * by));
        height_by_climb.1 += dt;
        let height = [(0, 1.0), height_by_climb, turbulence, force, of_lift];
        let bend = step.follows * step.bend;
        let lift = [
            (0, bend / step.radius_m),
            (5, bend),
            (6, 1.0 - step.follows),
        ];
        self.transform(&[(0, &height), (1, &climb), (2, &[(2, keep)]), (6, &lift)]);
        self.covariance[(2, 2)] += noise.gust.powi(2) * (1.0 - keep * keep);
        if let Some(ground) = noise.ground {
            self.move_ground(&ground.over(dt), dt);
        }
    }

    /// The ground goes on by a step, and the height over it falls by the mean of its climb rates at both ends.
    fn move_ground(&mut self, over: &Oscillation, dt: f64) {
        let Oscillation { keep, gain } = over;
        let [speed, acceleration] = [self.mean[7], self.mean[8]];
        let [after, faster] = keep.map(|[a, b]| a * speed + b * acceleration);
        self.mean[0] -= 0.5 * dt * (speed + after);
        (self.mean[7], self.mean[8]) = (after, faster);
        let [of_speed, of_acceleration] = keep.map(|[a, b]| [(7, a), (8, b)]);
        let height = [
            (0, 1.0),
            (7, -0.5 * dt * (1.0 + keep[0][0])),
            (8, -0.5 * dt * keep[0][1]),
        ];
        self.transform(&[(0, &height), (7, &of_speed), (8, &of_acceleration)]);
        for (i, row) in gain.iter().enumerate() {
            for (j, more) in row.iter().enumerate() {
                self.covariance[(7 + i, 7 + j)] += more;
            }
        }
    }

    /// The covariance of states of which some become sums of others, with these factors.
    fn transform(&mut self, sums: &[(usize, &[(usize, f64)])]) {
        let before = self.covariance;
        for (k, sum) in sums {
            let mut column = State::<N>::zeros();
            for (j, by) in *sum {
                column.axpy(*by, &before.column(*j), 1.0);
            }
            self.covariance.set_column(*k, &column);
        }
        let across = self.covariance;
        for (k, sum) in sums {
            let mut row = RowState::<N>::zeros();
            for (j, by) in *sum {
                row += across.row(*j) * *by;
            }
            self.covariance.set_row(*k, &row);
        }
    }

    /// Corrects by one measurement of a state.
    pub(super) fn update_by_state(&mut self, seen: &Seen, k: usize) {
        let shared = self.covariance.column(k).into_owned();
        self.update(seen, &shared, shared[k]);
    }

    /// Corrects by one measurement with slopes `along`.
    pub(super) fn update_along(&mut self, seen: &Seen, along: &State<N>) {
        let shared = self.covariance * along;
        self.update(seen, &shared, along.dot(&shared));
    }

    /// Corrects by one measurement, from its covariance with the states and its variance but for the sensor's.
    fn update(&mut self, seen: &Seen, shared: &State<N>, of_states: f64) {
        let &Seen { miss, sd, .. } = seen;
        let variance = of_states + sd * sd;
        let e = miss / variance.sqrt();
        // Huber: a blow counts as four standard deviations.
        let weight = (HUBER / e.abs()).min(1.0);
        let cost = weight * e * e + variance.ln();
        self.cost += cost;
        self.innovations.push(Innovation {
            sensor: seen.sensor,
            time_s: seen.time_s,
            value: weight.sqrt() * e,
            cost,
        });
        self.mean += shared * (weight * miss / variance);
        let precision = variance.recip();
        for (j, of) in shared.iter().enumerate() {
            let column = shared * *of * precision;
            self.covariance.column_mut(j).sub_assign(column);
        }
    }

    /// Takes the mean of the covariance and its transpose where rounding has made them two.
    pub(super) fn keep_symmetric(&mut self) {
        let p = &self.covariance;
        let differ = |i: usize, j: usize| {
            (p[(i, j)] - p[(j, i)]).powi(2) > ASYMMETRIC.powi(2) * (p[(i, i)] * p[(j, j)]).abs()
        };
        if (0..N).any(|i| (0..i).any(|j| differ(i, j))) {
            self.covariance = 0.5 * (p + p.transpose());
        }
    }

    pub(super) fn done(mut self) -> Pass {
        // A latency moves the order in which they came. Differences compare each with itself.
        let row = |i: &Innovation| (i.time_s, i.sensor);
        self.innovations.sort_by(|a, b| {
            let ((a_s, a), (b_s, b)) = (row(a), row(b));
            a_s.total_cmp(&b_s).then(a.cmp(&b))
        });
        Pass {
            innovations: self.innovations,
            cost: self.cost,
            local: SegmentOffsets {
                scale: self.mean[4],
                bias: self.mean[5],
            },
            range_latency_s: (N > AT_REST).then(|| [self.mean[9], self.covariance[(9, 9)].sqrt()]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_late_range_shows_the_height_of_its_time() {
        let mut filter = Filter::<MOVING> {
            mean: unit(4),
            covariance: Covariance::identity(),
            innovations: Vec::new(),
            cost: 0.0,
            acceleration_mps2: 2.0,
        };
        // The vehicle climbs by 0.5 m/s and accelerates by 2 m/s²; the ground by 0.1 m/s and 0.4 m/s².
        let late_s = 0.1;
        (filter.mean[0], filter.mean[1]) = (1.0, 0.5);
        (filter.mean[7], filter.mean[8], filter.mean[9]) = (0.1, 0.4, late_s);
        let (height_m, along) = filter.height_of_range();
        // Constant acceleration: exact, but for rounding.
        let truth_m = 1.0 - 0.4 * late_s + 0.5 * 1.6 * late_s * late_s;
        assert!((height_m - truth_m).abs() < 1e-12, "{height_m}");
        // Two-sided differences of a parabola are exact; rounding over their width is 1e-11.
        for k in [0, 1, 7, 8, 9] {
            let at = |by: f64| {
                let mut mean = filter.mean;
                mean[k] += by;
                let moved = Filter::<MOVING> {
                    mean,
                    innovations: Vec::new(),
                    ..filter
                };
                moved.height_of_range().0
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((slope - along[k]).abs() < 1e-9, "{k}: {slope} {}", along[k]);
        }
    }
}
