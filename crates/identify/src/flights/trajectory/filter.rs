//! The Kalman filter along one run: innovations of range, climb rate and accelerometer.

use super::Noise;
use super::kalman::{AT_REST, Filter, MOVING, Modelled, Pass, Seen, Sensor, Step, padded};
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
        late: Late::of(piece, values),
        now: (f64::NAN, [0.0; 2]),
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

/// Readings of an accelerometer with a latency: each belongs to a time before its row.
struct Late {
    latency_s: f64,
    /// √T relative to hover and drift at the times of the readings, row by row.
    drive: Vec<[f64; 2]>,
    /// The next reading, as an index of the rows that count.
    next: usize,
}

impl Late {
    /// `None` where the model has no latency, or the run no accelerometer.
    fn of(piece: &Segment, values: &ModelValues) -> Option<Self> {
        let latency_s = values
            .accelerometer_latency_s
            .filter(|_| piece.accelerometer)?;
        Some(Self {
            latency_s,
            drive: piece.drive_before(values, latency_s),
            next: 0,
        })
    }

    /// The row of the next reading and its time (s), where that is not after `until_s` in the motion of the reading before.
    fn due(&self, piece: &Segment, until_s: f64) -> Option<(usize, f64)> {
        let row = *piece.rows.get(self.next)?;
        let before = *piece.rows.get(self.next.checked_sub(1)?)?;
        let time_s = piece.time_s[row] - self.latency_s;
        let same = piece.time_s[row] - piece.time_s[before] <= LONGEST_HOLE_S;
        (same && time_s <= until_s).then_some((row, time_s))
    }
}

/// One run on its way through the filter.
struct Run<'a, const N: usize> {
    piece: &'a Segment,
    values: &'a ModelValues,
    noise: Noise,
    settings: Settings,
    /// √T relative to hover and drift, row by row.
    drive: Vec<[f64; 2]>,
    /// The accelerometer's readings, where they have a latency.
    late: Option<Late>,
    /// Time (s) of the state, √T relative to hover and drift then.
    now: (f64, [f64; 2]),
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
        self.now = (self.piece.time_s[i], self.drive[i]);
        // Of the motion before all readings are there.
        if let Some(late) = &mut self.late {
            late.next += 1;
            let drive = late.drive[i];
            self.correct_by_accelerometer(i, drive);
            self.hand_lift_over();
        }
    }

    /// From the row before to a row, by the readings of a late accelerometer in between.
    ///
    /// One that felt the force before the motion started is taken there: whatever the latency, the same readings count.
    fn predict(&mut self, i: usize) {
        let to_s = self.piece.time_s[i];
        while let Some((row, time_s)) = self.late.as_ref().and_then(|l| l.due(self.piece, to_s)) {
            let Some(late) = &mut self.late else { break };
            late.next += 1;
            let drive = late.drive[row];
            if time_s > self.now.0 {
                self.advance(time_s, drive, i);
            }
            self.correct_by_accelerometer(row, drive);
            self.hand_lift_over();
        }
        if to_s > self.now.0 {
            self.advance(to_s, self.drive[i], i);
        }
    }

    /// On to a time, where √T and drift are `to`; the tilt is that of a row.
    fn advance(&mut self, to_s: f64, to: [f64; 2], i: usize) {
        let (now_s, from) = self.now;
        self.now = (to_s, to);
        let dt = to_s - now_s;
        let [x, drift] = [0, 1].map(|k| 0.5 * (from[k] + to[k]));
        // The wake goes first: the force over the step is that of its middle. That of its start would be half a step late, and a
        // lag of the wake short by as much.
        let before = self.wake.lift(self.values);
        let ahead = self.height() + dt * self.filter.closing_mps() / self.settings.radius_m;
        let lag_s = self.values.lag_s(self.height(), x);
        let bend = self.bend();
        self.wake.step(self.values, ahead, dt, to[0]);
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
        self.correct_by_motion(i);
        if self.late.is_none() {
            self.correct_by_accelerometer(i, self.drive[i]);
        }
        self.filter.keep_symmetric();
        self.hand_lift_over();
    }

    /// The wake takes over what the filter found of its error.
    fn hand_lift_over(&mut self) {
        self.wake
            .shift(self.values, self.height(), self.filter.mean[6]);
        self.filter.mean[6] = 0.0;
    }

    /// By range and climb rate.
    fn correct_by_motion(&mut self, i: usize) {
        let measured = |all: &[f64]| all.get(i).copied().filter(|v| v.is_finite());
        let time_s = self.piece.time_s[i];
        if let Some(range_m) = measured(&self.piece.range_m) {
            let (height_m, along) = self.filter.height_of_range();
            let seen = Seen::of(
                Sensor::Range,
                time_s,
                range_m - height_m,
                self.noise.range_m,
            );
            if self.noise.ground.is_some() {
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
    }

    /// By the specific force of a row, felt where √T and drift were these.
    fn correct_by_accelerometer(&mut self, i: usize, [x, drift]: [f64; 2]) {
        if !self.piece.accelerometer {
            return;
        }
        let force = self.piece.force.get(i).copied();
        if let Some(force) = force.filter(|v| v.is_finite()) {
            let time_s = self.piece.time_s[i];
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
