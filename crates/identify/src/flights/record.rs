//! One log of a flight, with its channels on one clock.

use serde::Serialize;
use touchdown_trial::Trial;

use super::channels::{
    effort, heights, held, measured, median_step, throttle_period_s, without_gaps,
};
use super::ground::label;
use super::smooth::{bump, filled, local_parabola};
use super::{FlightSettings, motion};
use crate::error::{Error, Result};
use crate::thrust::plateau::median;
use crate::warning::Warning;

/// Finest step that is kept; faster logs are averaged (s). Motors and wakes take several such steps.
/// An eighth of the motors' lag. Half changes nothing at 100 Hz; twice moves lags by 4 % (measured).
const FINEST_STEP_S: f64 = 0.008;
/// Half of the window that climb rates are smoothed over (s).
/// Noise of a slope goes with the window to the power -1.5, the smoothing of the motors' lag with its square.
pub(super) const HALF_WINDOW_S: f64 = 0.1;
/// Noise of an acceleration from poses beyond which it is none (gravities).
/// Ground effect at one radius is about 0.1 g: noisier accelerations hide it.
const NOISIEST: f64 = 0.1;
/// What the specific force of a vehicle in flight is around, in gravities.
/// The median over a flight is 1 within a few per cent; 0 (gravity removed), 0.1 (in g) and -1 (downwards) are not.
const IN_FLIGHT: [f64; 2] = [0.7, 1.4];
/// What the mean of a vertical specific force over a flight is between, in gravities: accelerometers err by 0.02. Half would
/// name biases that are usual; twice would pass a scale that is a tenth off.
const ON_AVERAGE: [f64; 2] = [0.95, 1.05];
/// The upper bound where the tilt is not known: a lean of 20° is 1.06.
const ON_AVERAGE_LEANING: f64 = 1.08;

/// What a specific force is from.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ForceFrom {
    /// There is none.
    #[default]
    Nothing,
    /// The accelerometer.
    Accelerometer,
    /// Derivatives of climb rate or height.
    Poses,
}

/// What the specific forces of flights are from: the accelerometer, poses in all of them, or nothing.
///
/// # Errors
/// Some flights with an accelerometer and some without.
pub(super) fn forces_from(flights: &[Flight]) -> Result<ForceFrom> {
    let all = |from: ForceFrom| flights.iter().all(|f| f.force_from == from);
    let accelerometer = |f: &Flight| f.force_from == ForceFrom::Accelerometer;
    if all(ForceFrom::Accelerometer) {
        Ok(ForceFrom::Accelerometer)
    } else if flights.iter().any(accelerometer) {
        Err(Error::data(
            label(flights),
            "values of `specific_force_mps2` in all logs or in none",
            "some with and some without: identify them separately",
        ))
    } else if all(ForceFrom::Poses) {
        Ok(ForceFrom::Poses)
    } else {
        Ok(ForceFrom::Nothing)
    }
}

/// A log of a flight.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// Its name.
    pub name: String,
    /// Stamps (s).
    pub time_s: Vec<f64>,
    /// Mean throttle of the motors, in [0, 1].
    pub throttle: Vec<f64>,
    /// The throttle as it acts on `force`: smoothed alike, where that is from poses. Empty where it is the throttle.
    pub command: Vec<f64>,
    /// Whether that is the speed of the rotors over its greatest value, for no throttle was logged.
    pub throttle_is_speed: bool,
    /// Speed of the rotors (1/min); empty where it was not measured.
    pub rotor_rpm: Vec<f64>,
    /// Specific force along the rotor axis in gravities: 1 in hover. Empty where there is none.
    pub force: Vec<f64>,
    /// What it is from.
    pub force_from: ForceFrom,
    /// Height as logged (m); empty where it was not measured, NaN in long holes.
    pub height_m: Vec<f64>,
    /// Height where it was measured (m), NaN elsewhere: without filled gaps and repeated values.
    pub range_m: Vec<f64>,
    /// Climb rate where it was measured (m/s), NaN elsewhere; empty where it was not.
    pub climb_measured_mps: Vec<f64>,
    /// Climb rate (m/s), measured or from the height; empty where neither was.
    pub climb_mps: Vec<f64>,
    /// Battery voltage (V); empty where it was not measured.
    pub battery_v: Vec<f64>,
    /// Tilt of the rotor axis (rad); empty where it was not measured.
    pub tilt_rad: Vec<f64>,
    /// Median time between two values of the throttle while the motors run (s).
    pub throttle_period_s: f64,
    /// What was done to the log that its reader should know.
    pub notes: Vec<Warning>,
}

impl Flight {
    /// Takes the channels of a trial: `throttle` (or `throttle_1` …; or `rotor_rpm`), and what there is of
    /// `specific_force_mps2`, `height_m`, `vehicle_velocity_mps`, `battery_v` and `tilt_rad`. Without specific force, it
    /// is derived from climb rate or height where they are quick and clean enough.
    ///
    /// # Errors
    /// A trial without throttle and rotor speed, or whose specific force is not one.
    pub fn of(trial: &Trial, settings: &FlightSettings) -> Result<Self> {
        let (throttle, rotor_rpm, by_speed) = effort(trial)?;
        let throttle_period_s = throttle_period_s(trial, &throttle, settings)?;
        let time = trial.time_s();
        let mut notes = Vec::new();
        if by_speed {
            notes.push(Warning::SpeedForThrottle);
        }
        let [height_m, range_m] = heights(trial, settings.height_offset_m, &mut notes);
        let climb_measured_mps = trial
            .channel("vehicle_velocity_mps")
            .map_or_else(Vec::new, |c| measured(time, c));
        let velocity = without_gaps(trial, "vehicle_velocity_mps");
        let clock_s = median_step(time);
        let gravity = settings.gravity_mps2;
        // The force is measured where it stands: what is between is not made up.
        let force: Vec<f64> = trial
            .channel("specific_force_mps2")
            .map(|c| c.iter().map(|f| f / gravity).collect())
            .unwrap_or_default();
        let known = force.iter().any(|f| f.is_finite());
        // Slow clocks need a longer window for a slope.
        let half_s = HALF_WINDOW_S.max(2.1 * clock_s);
        let climb_mps = if known && !(velocity.is_empty() && height_m.is_empty()) {
            let up: Vec<f64> = force.iter().map(|f| (f - 1.0) * gravity).collect();
            motion::climb(time, [&height_m, &velocity], &up)
        } else if !velocity.is_empty() {
            local_parabola(time, &velocity, half_s, 0)
        } else if !height_m.is_empty() {
            local_parabola(time, &height_m, half_s, 1)
        } else {
            Vec::new()
        };
        let mut whole = Self {
            name: trial.name().to_string(),
            time_s: time.to_vec(),
            throttle: filled(time, &throttle, true),
            command: Vec::new(),
            throttle_is_speed: by_speed,
            rotor_rpm,
            force: if known { force } else { Vec::new() },
            force_from: if known {
                ForceFrom::Accelerometer
            } else {
                ForceFrom::Nothing
            },
            height_m,
            range_m,
            climb_measured_mps,
            climb_mps,
            battery_v: trial.channel("battery_v").map_or_else(Vec::new, held),
            tilt_rad: without_gaps(trial, "tilt_rad"),
            throttle_period_s,
            notes,
        };
        if known {
            whole.check_force(settings)?;
            let mean = whole.mean_vertical_force(settings);
            whole.notes.extend(mean.and_then(|m| whole.off_weight(m)));
        } else if clock_s.max(throttle_period_s) * settings.least_rate_hz <= 1.0 {
            whole.derive_force(&velocity, gravity);
        }
        Ok(whole.thinned())
    }

    /// Specific force from the climb rate or, without it, from the height, with the throttle smoothed alike. Where the
    /// noise is too strong there is none.
    fn derive_force(&mut self, velocity: &[f64], gravity: f64) {
        let (source, derivative) = if velocity.is_empty() {
            (&self.height_m[..], 2)
        } else {
            (velocity, 1)
        };
        if source.is_empty() {
            return;
        }
        let time = &self.time_s;
        let rise = local_parabola(time, source, HALF_WINDOW_S, derivative);
        // White noise of a signal shows in its third differences, 20-fold in variance.
        let rough = median(
            source
                .windows(4)
                .map(|w| (w[3] - 3.0 * (w[2] - w[1]) - w[0]).abs()),
        );
        let sd = rough.unwrap_or(f64::INFINITY) * 1.4826 / 20.0_f64.sqrt();
        // That of a parabola's slope and curvature over n evenly spaced values.
        let n = 2.0 * HALF_WINDOW_S / self.step_s() + 1.0;
        let noise = match derivative {
            1 => sd * (3.0 / n).sqrt() / HALF_WINDOW_S,
            _ => sd * (180.0 / (4.0 * n)).sqrt() / (HALF_WINDOW_S * HALF_WINDOW_S),
        } / gravity;
        if !(noise <= NOISIEST) {
            self.notes.push(Warning::NoisyPoses {
                noise_g: noise,
                most_g: NOISIEST,
            });
            return;
        }
        self.force = rise
            .iter()
            .enumerate()
            .map(|(i, a)| {
                let lean = self.tilt_rad.get(i).map_or(1.0, |t| t.cos().max(0.5));
                (1.0 + a / gravity) / lean
            })
            .collect();
        self.command = bump(time, &self.throttle, HALF_WINDOW_S, derivative as i32);
        self.force_from = ForceFrom::Poses;
    }

    /// A specific force is about one gravity over a flight; anything else is another quantity or another unit.
    fn check_force(&self, settings: &FlightSettings) -> Result<()> {
        if self.force.is_empty() {
            return Ok(());
        }
        let most = self.throttle.iter().copied().fold(0.0, f64::max);
        let flying = (0..self.force.len())
            .filter(|&i| self.throttle[i] > settings.idle_throttle.max(0.5 * most))
            .map(|i| self.force[i]);
        match median(flying) {
            Some(f) if (IN_FLIGHT[0]..=IN_FLIGHT[1]).contains(&f) => Ok(()),
            None => Ok(()),
            Some(f) => Err(Error::data(
                &self.name,
                format!(
                    "`specific_force_mps2` of about {} m/s² in flight (up positive, gravity not taken off)",
                    settings.gravity_mps2
                ),
                format!(
                    "a median of {:.3} m/s²: is it in g, without gravity, or down positive?",
                    f * settings.gravity_mps2
                ),
            )),
        }
    }

    /// Mean vertical specific force of the rows with motors (gravities): it is 1 over any flight that begins and ends at rest.
    fn mean_vertical_force(&self, settings: &FlightSettings) -> Option<f64> {
        let most = self.throttle.iter().copied().fold(0.0, f64::max);
        let least = settings.idle_throttle.max(0.5 * most);
        let rows = (0..self.force.len()).filter(|&i| self.throttle[i] > least);
        let lean = |i: usize| self.tilt_rad.get(i).map_or(1.0, |t| t.cos());
        let vertical = rows.map(|i| self.force[i] * lean(i));
        let (n, sum) = vertical
            .filter(|f| f.is_finite())
            .fold((0, 0.0), |(n, sum), f| (n + 1, sum + f));
        (n > 0).then(|| sum / f64::from(n))
    }

    /// The warning of a mean specific force that no flight has.
    fn off_weight(&self, mean_g: f64) -> Option<Warning> {
        let [low, high] = ON_AVERAGE;
        let high = if self.tilt_rad.is_empty() {
            ON_AVERAGE_LEANING
        } else {
            high
        };
        (!(low..=high).contains(&mean_g)).then_some(Warning::ForceOffWeight {
            mean_g,
            expected: [low, high],
        })
    }

    /// The same with neighbouring rows averaged to steps of at least [`FINEST_STEP_S`].
    fn thinned(self) -> Self {
        let step = median(self.time_s.windows(2).map(|p| p[1] - p[0])).unwrap_or(1.0);
        let many = (FINEST_STEP_S / step).round() as usize;
        if many < 2 {
            return self;
        }
        let mean = |c: &[f64]| -> Vec<f64> {
            c.chunks(many)
                .map(|c| {
                    let (n, sum) = c
                        .iter()
                        .filter(|v| v.is_finite())
                        .fold((0.0, 0.0), |(n, sum), v| (n + 1.0, sum + v));
                    sum / n
                })
                .collect()
        };
        Self {
            time_s: mean(&self.time_s),
            throttle: mean(&self.throttle),
            command: mean(&self.command),
            rotor_rpm: mean(&self.rotor_rpm),
            force: mean(&self.force),
            height_m: mean(&self.height_m),
            range_m: mean(&self.range_m),
            climb_measured_mps: mean(&self.climb_measured_mps),
            climb_mps: mean(&self.climb_mps),
            battery_v: mean(&self.battery_v),
            tilt_rad: mean(&self.tilt_rad),
            ..self
        }
    }

    /// Median step of the clock (s).
    #[must_use]
    pub fn step_s(&self) -> f64 {
        median_step(&self.time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(force: f64) -> Trial {
        let time: Vec<f64> = (0..1000).map(|i| 0.002 * f64::from(i)).collect();
        // A throttle that a slow logger wrote every 0.1 s, and that a reader held in between.
        let throttle = (0..1000)
            .map(|i| 0.5 + 0.001 * f64::from(i / 50 % 7))
            .collect();
        Trial::new("log", time)
            .unwrap()
            .with_channel("throttle", throttle)
            .unwrap()
            .with_channel("specific_force_mps2", vec![force; 1000])
            .unwrap()
    }

    #[test]
    fn analytic_a_held_throttle_keeps_its_own_period() {
        let flight = Flight::of(&trial(9.81), &FlightSettings::default()).unwrap();
        assert!(
            (flight.throttle_period_s - 0.1).abs() < 1e-9,
            "{}",
            flight.throttle_period_s
        );
        // 500 Hz averaged by fours.
        assert_eq!(flight.time_s.len(), 250);
        assert!((flight.force[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn analytic_force_in_g_is_refused_with_the_number() {
        let error = Flight::of(&trial(1.0), &FlightSettings::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("specific_force_mps2") && error.contains("1.000"),
            "{error}"
        );
    }
}
