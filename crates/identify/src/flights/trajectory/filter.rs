//! The Kalman filter along one run: innovations of range, climb rate and accelerometer.

use std::ops::SubAssign as _;

use nalgebra::{RowSVector, SMatrix, SVector};

use super::Noise;
use super::noise::Oscillation;
use crate::flights::fit::SegmentOffsets;
use crate::flights::model::{ModelValues, Segment, WakeState};
use crate::flights::normal::HUBER;

/// Height above the ground (m), climb rate (m/s), turbulence (g), accelerometer's error (g), thrust scale, height error (R), error
/// of the lagged ground effect.
const AT_REST: usize = 7;
/// The same, the ground's climb rate (m/s) and acceleration (m/s²), and how late the range is (s).
const MOVING: usize = 10;
type State<const N: usize> = SVector<f64, N>;
type RowState<const N: usize> = RowSVector<f64, N>;
type Covariance<const N: usize> = SMatrix<f64, N, N>;

/// Rows that do not count for longer than this start the motion anew (s).
/// Vibration drops single rows; a touch of the ground takes longer.
const LONGEST_HOLE_S: f64 = 0.1;
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
/// Step of the height error for slopes, in R: the curve bends over a radius.
const HEIGHT_STEP: f64 = 1e-4;

/// What all runs share.
#[derive(Clone, Copy, Debug)]
pub(in crate::flights) struct Settings {
    /// Rotor radius R (m).
    pub(in crate::flights) radius_m: f64,
    /// Acceleration of gravity (m/s²).
    pub(in crate::flights) gravity_mps2: f64,
}

/// What is measured.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
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
    /// All innovations, in the order in which they came.
    pub(super) innovations: Vec<Innovation>,
    /// Minus twice the log-likelihood.
    pub(super) cost: f64,
    /// Scale and height error of the run as known at its end.
    pub(super) local: SegmentOffsets,
}

/// The filter over one run.
pub(super) fn pass(
    piece: &Segment,
    values: &ModelValues,
    noise: Noise,
    settings: Settings,
) -> Pass {
    match noise.ground {
        None => pass_of::<AT_REST>(piece, values, noise, settings),
        Some(_) => pass_of::<MOVING>(piece, values, noise, settings),
    }
}

fn pass_of<const N: usize>(
    piece: &Segment,
    values: &ModelValues,
    noise: Noise,
    settings: Settings,
) -> Pass {
    let mut run: Run<'_, N> = Run {
        piece,
        values,
        noise,
        settings,
        drive: piece.drive(values),
        filter: Filter::of(piece),
        wake: WakeState::default(),
    };
    let mut counts = vec![false; piece.time_s.len()];
    for &i in &piece.rows {
        counts[i] = true;
    }
    let ends = piece.rows.first().zip(piece.rows.last());
    let mut last: Option<usize> = None;
    for i in ends.map_or(0..0, |(a, b)| *a..b + 1) {
        let hole_s = last.map_or(f64::INFINITY, |l| piece.time_s[i] - piece.time_s[l]);
        if hole_s <= LONGEST_HOLE_S {
            run.predict(i);
        } else if counts[i] {
            let Some(height_m) = piece.range_after(i) else {
                break;
            };
            run.start(i, height_m);
        } else {
            continue;
        }
        if counts[i] {
            last = Some(i);
            run.correct(i);
        }
    }
    run.filter.done()
}

/// One run on its way through the filter.
struct Run<'a, const N: usize> {
    piece: &'a Segment,
    values: &'a ModelValues,
    noise: Noise,
    settings: Settings,
    /// √T relative to hover and drift, row by row.
    drive: Vec<[f64; 2]>,
    filter: Filter<N>,
    wake: WakeState,
}

/// Specific force over the scale, and its slopes by climb rate (s/m) and ground effect.
struct Modelled {
    force: f64,
    by_climb: f64,
    by_lift: f64,
}

impl<const N: usize> Run<'_, N> {
    /// Height above the ground in R.
    fn height(&self) -> f64 {
        self.filter.mean[0] / self.settings.radius_m + self.filter.mean[5]
    }

    /// Slope of the ground effect at rest by height (1/R).
    fn bend(&self) -> f64 {
        let height = self.height();
        let rest = |z: f64| self.values.at_rest(z);
        (rest(height + HEIGHT_STEP) - rest(height)) / HEIGHT_STEP
    }

    /// A motion starts in a row: the wake is that at rest.
    fn start(&mut self, i: usize, height_m: f64) {
        self.filter.start(height_m, self.noise);
        self.wake = WakeState::default();
        self.wake
            .step(self.values, self.height(), 0.0, self.drive[i][0]);
        self.filter
            .lift_at_rest(self.bend(), self.settings.radius_m);
    }

    /// From the row before to a row.
    fn predict(&mut self, i: usize) {
        let dt = self.piece.time_s[i] - self.piece.time_s[i - 1];
        let [x, drift] = [0, 1].map(|k| 0.5 * (self.drive[i - 1][k] + self.drive[i][k]));
        // The wake goes first: the force over the step is that of its middle. That of its start would be half a step late, and a
        // lag of the wake short by as much.
        let before = self.wake.lift(self.values);
        let ahead = self.height() + dt * self.filter.closing_mps() / self.settings.radius_m;
        let lag_s = self.values.lag_s(self.height(), x);
        let bend = self.bend();
        self.wake.step(self.values, ahead, dt, self.drive[i][0]);
        let model = self.model(x, drift, 0.5 * (before + self.wake.lift(self.values)));
        let up = self.settings.gravity_mps2 * self.piece.lean(i);
        let follows = if lag_s > 0.0 {
            1.0 - (-dt / lag_s).exp()
        } else {
            1.0
        };
        let step = Step {
            dt,
            up,
            gravity: self.settings.gravity_mps2,
            follows,
            bend,
            radius_m: self.settings.radius_m,
        };
        self.filter.predict(&model, &step, self.noise);
    }

    /// Corrects by what was measured in a row.
    fn correct(&mut self, i: usize) {
        self.correct_by_sensors(i);
        self.filter.keep_symmetric();
        // The wake takes its error over.
        self.wake
            .shift(self.values, self.height(), self.filter.mean[6]);
        self.filter.mean[6] = 0.0;
    }

    fn correct_by_sensors(&mut self, i: usize) {
        let measured = |all: &[f64]| all.get(i).copied().filter(|v| v.is_finite());
        let time_s = self.piece.time_s[i];
        if let Some(range_m) = measured(&self.piece.range_m) {
            let late_s = self.filter.mean.get(9).copied().unwrap_or(0.0);
            let closing = self.filter.closing_mps();
            let miss = range_m - (self.filter.mean[0] - late_s * closing);
            let seen = Seen::of(Sensor::Range, time_s, miss, self.noise.range_m);
            if self.noise.ground.is_some() {
                let mut along = unit(0);
                (along[1], along[7], along[9]) = (-late_s, late_s, -closing);
                self.filter.update_along(&seen, &along);
            } else {
                self.filter.update_by_state(&seen, 0);
            }
        }
        let counts = self.noise.climb_mps.is_finite();
        if let Some(climb) = measured(&self.piece.climb_measured_mps).filter(|_| counts) {
            let miss = climb - self.filter.mean[1];
            let seen = Seen::of(Sensor::ClimbRate, time_s, miss, self.noise.climb_mps);
            self.filter.update_by_state(&seen, 1);
        }
        if !self.piece.accelerometer {
            return;
        }
        if let Some(force) = measured(&self.piece.force) {
            let [x, drift] = self.drive[i];
            let m = self.model(x, drift, self.wake.lift(self.values));
            let s = &self.filter.mean;
            let modelled = s[4] * (m.force + m.by_lift * s[6]);
            let miss = force - (modelled + s[2] + s[3]);
            let along = [
                0.0,
                s[4] * m.by_climb,
                1.0,
                1.0,
                m.force,
                0.0,
                s[4] * m.by_lift,
            ];
            let seen = Seen::of(Sensor::Accelerometer, time_s, miss, self.noise.force);
            self.filter.update_along(&seen, &padded(along));
        }
    }

    /// The specific force at a √T, a drift and a ground effect.
    fn model(&self, x: f64, drift: f64, lift: f64) -> Modelled {
        let damping = self.values.damping_at(self.height());
        Modelled {
            force: drift * x * (x * (1.0 + lift) - damping * self.filter.mean[1]),
            by_climb: -drift * x * damping,
            by_lift: drift * x * x,
        }
    }
}

fn unit<const N: usize>(k: usize) -> State<N> {
    let mut out = State::zeros();
    out[k] = 1.0;
    out
}

/// A vector of all states from that of a ground at rest.
fn padded<const N: usize>(of: [f64; AT_REST]) -> State<N> {
    State::from_fn(|k, _| of.get(k).copied().unwrap_or(0.0))
}

/// One step of the filter.
struct Step {
    dt: f64,
    /// Vertical acceleration of a specific force of one gravity (m/s²).
    up: f64,
    gravity: f64,
    /// Share of the way to its rest that the ground effect goes in the step.
    follows: f64,
    /// Slope of the ground effect at rest by height (1/R).
    bend: f64,
    radius_m: f64,
}

/// A measurement beside what the filter expected.
struct Seen {
    sensor: Sensor,
    time_s: f64,
    miss: f64,
    sd: f64,
}

impl Seen {
    fn of(sensor: Sensor, time_s: f64, miss: f64, sd: f64) -> Self {
        Self {
            sensor,
            time_s,
            miss,
            sd,
        }
    }
}

/// A Kalman filter with its innovations.
struct Filter<const N: usize> {
    mean: State<N>,
    covariance: Covariance<N>,
    innovations: Vec<Innovation>,
    cost: f64,
}

impl<const N: usize> Filter<N> {
    fn of(piece: &Segment) -> Self {
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
        }
    }

    /// A motion starts: height as measured, climb rate and turbulence unknown; scale and errors go on.
    fn start(&mut self, height_m: f64, noise: Noise) {
        let known = [
            (0, height_m, 3.0 * noise.range_m + START_M),
            (1, 0.0, START_MPS),
            (2, 0.0, noise.gust),
        ];
        let ground = noise
            .ground
            .map(|g| [(7, 0.0, g.speed_mps), (8, 0.0, g.speed_mps * g.frequency())]);
        for (k, mean, sd) in known.into_iter().chain(ground.into_iter().flatten()) {
            self.mean[k] = mean;
            self.covariance.row_mut(k).fill(0.0);
            self.covariance.column_mut(k).fill(0.0);
            self.covariance[(k, k)] = sd * sd;
        }
    }

    /// Climb rate over the ground.
    fn closing_mps(&self) -> f64 {
        self.mean[1] - self.mean.get(7).copied().unwrap_or(0.0)
    }

    /// The ground effect is that at rest, as uncertain as the height makes it.
    fn lift_at_rest(&mut self, bend: f64, radius_m: f64) {
        self.transform(&[(6, &[(0, bend / radius_m), (5, bend)])]);
        self.mean[6] = 0.0;
    }

    /// One row on.
    fn predict(&mut self, model: &Modelled, step: &Step, noise: Noise) {
        let Step { dt, up, .. } = *step;
        let scale = self.mean[4];
        let acceleration = up * (scale * model.force + self.mean[2]) - step.gravity;
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
    fn update_by_state(&mut self, seen: &Seen, k: usize) {
        let shared = self.covariance.column(k).into_owned();
        self.update(seen, &shared, shared[k]);
    }

    /// Corrects by one measurement with slopes `along`.
    fn update_along(&mut self, seen: &Seen, along: &State<N>) {
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
    fn keep_symmetric(&mut self) {
        let p = &self.covariance;
        let differ = |i: usize, j: usize| {
            (p[(i, j)] - p[(j, i)]).powi(2) > ASYMMETRIC.powi(2) * (p[(i, i)] * p[(j, j)]).abs()
        };
        if (0..N).any(|i| (0..i).any(|j| differ(i, j))) {
            self.covariance = 0.5 * (p + p.transpose());
        }
    }

    fn done(self) -> Pass {
        Pass {
            innovations: self.innovations,
            cost: self.cost,
            local: SegmentOffsets {
                scale: self.mean[4],
                bias: self.mean[5],
            },
        }
    }
}
