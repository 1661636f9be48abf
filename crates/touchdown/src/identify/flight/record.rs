//! One log of a flight, with its channels on one clock.

use nalgebra::{Matrix3, Vector3};
use touchdown_trial::Trial;

use super::FlightSettings;
use crate::error::{Error, Result};
use crate::identify::thrust::{plateau::median, throttle};

/// Longest hole in a channel that is filled from its neighbours (s).
const LONGEST_HOLE_S: f64 = 0.5;
/// Finest step that is kept; faster logs are averaged (s). Motors and wakes take several such steps.
const FINEST_STEP_S: f64 = 0.008;
/// Half of the window that climb rates are smoothed over (s).
const HALF_WINDOW_S: f64 = 0.1;
/// What the specific force of a vehicle in flight is around, in gravities.
const IN_FLIGHT: [f64; 2] = [0.7, 1.4];

/// A log of a flight.
#[derive(Clone, Debug)]
pub struct Flight {
    /// Its name.
    pub name: String,
    /// Stamps (s).
    pub time_s: Vec<f64>,
    /// Mean throttle of the motors, in [0, 1].
    pub throttle: Vec<f64>,
    /// Specific force along the rotor axis in gravities: 1 in hover. Empty where it was not measured.
    pub force: Vec<f64>,
    /// Height as logged (m); empty where it was not measured, NaN in long holes.
    pub height_m: Vec<f64>,
    /// Climb rate (m/s), measured or from the height; empty where neither was.
    pub climb_mps: Vec<f64>,
    /// Battery voltage (V); empty where it was not measured.
    pub battery_v: Vec<f64>,
    /// Tilt of the rotor axis (rad); empty where it was not measured.
    pub tilt_rad: Vec<f64>,
    /// Median time between two values of the throttle while the motors run (s).
    pub throttle_period_s: f64,
}

impl Flight {
    /// Takes the channels of a trial: `throttle` (or `throttle_1` …), and what there is of `specific_force_mps2`,
    /// `height_m`, `vehicle_velocity_mps`, `battery_v` and `tilt_rad`.
    ///
    /// # Errors
    /// A trial without throttle, or whose specific force is not one.
    pub fn of(trial: &Trial, settings: &FlightSettings) -> Result<Self> {
        let throttle = throttle(trial)?;
        let running = |i: &usize| throttle[*i] > settings.idle_throttle;
        let rows: Vec<usize> = (0..trial.len())
            .filter(|&i| throttle[i].is_finite())
            .collect();
        if rows.len() < 20 {
            return Err(Error::data(
                trial.name(),
                "at least 20 rows with a throttle",
                rows.len().to_string(),
            ));
        }
        let time = trial.time_s();
        let changes: Vec<f64> = rows
            .iter()
            .zip(rows.iter().skip(1))
            .filter(|(a, b)| running(a) && running(b) && throttle[**a] != throttle[**b])
            .map(|(_, b)| time[*b])
            .collect();
        let step = |t: &[f64]| median(t.windows(2).map(|p| p[1] - p[0])).unwrap_or(f64::INFINITY);
        let stamps: Vec<f64> = rows.iter().map(|&i| time[i]).collect();
        let throttle_period_s = step(&stamps).max(step(&changes));
        let linear = |name: &str| -> Vec<f64> {
            let Some(values) = trial.channel(name) else {
                return Vec::new();
            };
            if values.iter().any(|v| v.is_finite()) {
                filled(time, values, false)
            } else {
                Vec::new()
            }
        };
        let height_m = linear("height_m");
        let mut climb_mps = linear("vehicle_velocity_mps");
        // Noise of a regressor would pull its coefficient to zero, and with it what goes along with it.
        if !climb_mps.is_empty() {
            climb_mps = local_parabola(time, &climb_mps, 0);
        } else if !height_m.is_empty() {
            climb_mps = local_parabola(time, &height_m, 1);
        }
        let gravity = settings.gravity_mps2;
        // The force is measured where it stands: what is between is not made up.
        let force: Vec<f64> = trial
            .channel("specific_force_mps2")
            .map(|c| c.iter().map(|f| f / gravity).collect())
            .unwrap_or_default();
        let whole = Self {
            name: trial.name().to_string(),
            time_s: time.to_vec(),
            throttle: filled(time, &throttle, true),
            force,
            height_m,
            climb_mps,
            battery_v: linear("battery_v"),
            tilt_rad: linear("tilt_rad"),
            throttle_period_s,
        };
        whole.check_force(settings)?;
        Ok(whole.thinned())
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
            force: mean(&self.force),
            height_m: mean(&self.height_m),
            climb_mps: mean(&self.climb_mps),
            battery_v: mean(&self.battery_v),
            tilt_rad: mean(&self.tilt_rad),
            name: self.name,
            throttle_period_s: self.throttle_period_s,
        }
    }

    /// Median step of the clock (s).
    #[must_use]
    pub fn step_s(&self) -> f64 {
        median(self.time_s.windows(2).map(|p| p[1] - p[0])).unwrap_or(f64::INFINITY)
    }
}

/// Holes up to [`LONGEST_HOLE_S`] filled: held at the value before, or on a line between neighbours.
fn filled(time: &[f64], values: &[f64], hold: bool) -> Vec<f64> {
    let mut out = values.to_vec();
    let mut last: Option<usize> = None;
    for i in 0..values.len() {
        if !values[i].is_finite() {
            continue;
        }
        if let Some(k) = last.filter(|&k| k + 1 < i && time[i] - time[k] <= LONGEST_HOLE_S) {
            for j in k + 1..i {
                let share = if hold {
                    0.0
                } else {
                    (time[j] - time[k]) / (time[i] - time[k])
                };
                out[j] = values[k] + share * (values[i] - values[k]);
            }
        }
        last = Some(i);
    }
    out
}

/// Value (0) or slope (1) of the parabola through the values within [`HALF_WINDOW_S`], by least squares.
fn local_parabola(time: &[f64], values: &[f64], derivative: usize) -> Vec<f64> {
    let (mut a, mut b) = (0, 0);
    (0..time.len())
        .map(|i| {
            while time[i] - time[a] > HALF_WINDOW_S {
                a += 1;
            }
            while b + 1 < time.len() && time[b + 1] - time[i] <= HALF_WINDOW_S {
                b += 1;
            }
            let (mut gram, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for k in (a..=b).filter(|&k| values[k].is_finite()) {
                let t = (time[k] - time[i]) / HALF_WINDOW_S;
                let powers = Vector3::new(1.0, t, t * t);
                gram += powers * powers.transpose();
                right += values[k] * powers;
            }
            // Fewer than three values have no parabola, and where there is none there is none around it.
            match gram.try_inverse() {
                Some(inverse) if values[i].is_finite() => {
                    let fitted = inverse * right;
                    if derivative == 0 {
                        fitted.x
                    } else {
                        fitted.y / HALF_WINDOW_S
                    }
                }
                _ => f64::NAN,
            }
        })
        .collect()
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

    #[test]
    fn analytic_a_parabola_is_smoothed_to_itself() {
        let time: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
        let course: Vec<f64> = time.iter().map(|t| 1.0 + 2.0 * t - 3.0 * t * t).collect();
        let (value, slope) = (
            local_parabola(&time, &course, 0),
            local_parabola(&time, &course, 1),
        );
        for i in 0..100 {
            // Normal equations of three well-scaled columns lose a few digits.
            assert!((value[i] - course[i]).abs() < 1e-9);
            assert!((slope[i] - (2.0 - 6.0 * time[i])).abs() < 1e-7);
        }
    }

    #[test]
    fn analytic_short_holes_are_filled_and_long_ones_are_not() {
        let time = [0.0, 0.1, 0.2, 0.3, 1.0, 2.0];
        let values = [1.0, f64::NAN, f64::NAN, 4.0, f64::NAN, 5.0];
        assert_eq!(filled(&time, &values, true)[..4], [1.0, 1.0, 1.0, 4.0]);
        let line = filled(&time, &values, false);
        assert!((line[1] - 2.0).abs() < 1e-12 && line[4].is_nan());
    }
}
