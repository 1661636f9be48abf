//! The Kalman filter along one run: innovations of range, climb rate and accelerometer.

use super::Noise;
use super::kalman::{AT_REST, Filter, MOVING, Modelled, Pass, Seen, Sensor, Step, padded, unit};
use crate::flights::model::{ModelValues, Segment, WakeState};

/// Rows that do not count for longer than this start the motion anew (s).
/// Vibration drops single rows; a touch of the ground takes longer.
const LONGEST_HOLE_S: f64 = 0.1;
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
