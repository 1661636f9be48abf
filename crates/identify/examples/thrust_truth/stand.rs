//! A thrust stand: commands, rotors with one lag behind a dead time, a load cell.

use std::cell::RefCell;

use rand_pcg::Pcg64;
use touchdown_identify::settings::ThrustForm;
use touchdown_trial::Trial;

use super::{between, normal};

/// How long a log is (s).
const LENGTH_S: f64 = 30.0;
/// Step of the plant where the command moves at all times (s): a hundredth of the shortest lag.
const STEP_S: f64 = 2e-4;

/// How the throttle moves.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Command {
    /// Held steps of random height at times of the log's clock.
    Steps,
    /// The same at times between those of the log.
    FreeSteps,
    /// A sum of sines.
    Sines,
    /// Four motors, each with steps of its own.
    Motors,
    /// Slowly up and down again.
    Ramp,
}

/// Noise of the load cell.
#[derive(Clone, Copy)]
pub(crate) struct Noise {
    /// Standard deviation over the greatest thrust.
    pub(crate) sd_share: f64,
    /// Time over which it is correlated (s); 0 for white noise.
    pub(crate) memory_s: f64,
}

/// A stand with its vehicle.
pub(crate) struct Stand {
    /// Lag of the rotors (s).
    pub(crate) lag_s: f64,
    /// Dead time of the chain (s).
    pub(crate) dead_time_s: f64,
    /// Constant, slope and square of the curve.
    curve: [f64; 3],
    random: RefCell<Pcg64>,
}

type Truth = (&'static str, &'static str, f64);

impl Stand {
    pub(crate) fn draw(mut random: Pcg64, command: Command) -> Self {
        let size = between(&mut random, [1.5, 6.0]);
        let curve = match command {
            // Newtons for each motor.
            Command::Motors => [
                0.01 * size,
                0.3 * size,
                size * between(&mut random, [0.3, 0.9]),
            ],
            // √N.
            _ => [size * between(&mut random, [0.0, 0.15]), size, 0.0],
        };
        Self {
            lag_s: between(&mut random, [0.025, 0.12]),
            dead_time_s: between(&mut random, [0.002, 0.045]),
            curve,
            random: RefCell::new(random),
        }
    }

    /// Constant and slope of the curve, as the form names them.
    pub(crate) fn line(&self, form: ThrustForm) -> [Truth; 2] {
        let [constant, slope, _] = self.curve;
        match form {
            ThrustForm::LaggedMotors => [("T", "1", constant), ("T", "u", slope)],
            _ => [("c1", "1", constant), ("c0", "1", slope)],
        }
    }

    /// A log of this stand; none where its columns make no trial.
    pub(crate) fn log(&self, command: Command, rate_hz: f64, noise: Noise) -> Option<Trial> {
        let count = (LENGTH_S * rate_hz) as usize;
        let time: Vec<f64> = (0..count).map(|i| i as f64 / rate_hz).collect();
        let motors = if command == Command::Motors { 4 } else { 1 };
        let throttles: Vec<_> = (0..motors)
            .map(|_| self.throttle(command, rate_hz))
            .collect();
        let mut thrust = vec![0.0; count];
        for throttle in &throttles {
            let u = self.behind(throttle, &time);
            for (out, u) in thrust.iter_mut().zip(u) {
                let [a, b, c] = self.curve;
                let z = a + b * u + c * u * u;
                *out += if command == Command::Motors { z } else { z * z };
            }
        }
        self.measure(&mut thrust, rate_hz, noise);
        let mut trial = Trial::new("stand", time.clone()).ok()?;
        for (k, throttle) in throttles.iter().enumerate() {
            let name = match motors {
                1 => "throttle".to_string(),
                _ => format!("throttle_{}", k + 1),
            };
            let logged = time.iter().map(|t| throttle(*t)).collect();
            trial.insert(&name, logged).ok()?;
        }
        trial.insert("thrust_n", thrust).ok()?;
        Some(trial)
    }

    /// The command of a motor, at any time.
    fn throttle(&self, command: Command, rate_hz: f64) -> Box<dyn Fn(f64) -> f64> {
        let random = &mut *self.random.borrow_mut();
        match command {
            Command::Ramp => Box::new(|t| 0.15 + 0.8 * (1.0 - (1.0 - 2.0 * t / LENGTH_S).abs())),
            Command::Sines => {
                let waves: Vec<[f64; 3]> = (0..4)
                    .map(|_| {
                        let share = between(random, [0.06, 0.1]);
                        [
                            share,
                            between(random, [1.0, 18.0]),
                            between(random, [0.0, std::f64::consts::TAU]),
                        ]
                    })
                    .collect();
                Box::new(move |t| {
                    let sum: f64 = waves.iter().map(|[a, w, p]| a * (w * t + p).sin()).sum();
                    0.55 + sum
                })
            }
            Command::Steps | Command::FreeSteps | Command::Motors => {
                let mut steps = vec![(f64::NEG_INFINITY, between(random, [0.25, 0.9]))];
                let mut at = 0.0;
                while at < LENGTH_S {
                    at += between(random, [0.25, 1.0]);
                    let stamp = match command {
                        Command::FreeSteps => at,
                        // A hair before the sample, which then has the new value.
                        _ => (at * rate_hz).round() / rate_hz - 1e-9,
                    };
                    steps.push((stamp, between(random, [0.25, 0.9])));
                }
                Box::new(move |t| {
                    let k = steps.partition_point(|s| s.0 <= t);
                    steps[k - 1].1
                })
            }
        }
    }

    /// The command behind dead time and lag, at the log's times.
    fn behind(&self, throttle: &dyn Fn(f64) -> f64, time: &[f64]) -> Vec<f64> {
        let mut u = throttle(-self.dead_time_s);
        let mut now = 0.0;
        let decay = |dt: f64| (-dt / self.lag_s).exp();
        time.iter()
            .map(|&t| {
                while now < t {
                    let dt = STEP_S.min(t - now);
                    let held = throttle(now + 0.5 * dt - self.dead_time_s);
                    u = held + (u - held) * decay(dt);
                    now += dt;
                    if t - now < 1e-12 {
                        now = t;
                    }
                }
                u
            })
            .collect()
    }

    /// Adds noise and rounds to the load cell's resolution.
    fn measure(&self, thrust: &mut [f64], rate_hz: f64, noise: Noise) {
        let random = &mut *self.random.borrow_mut();
        let most = thrust.iter().copied().fold(0.0, f64::max);
        let sd = noise.sd_share * most;
        let keeps = match noise.memory_s {
            0.0 => 0.0,
            memory_s => (-1.0 / (rate_hz * memory_s)).exp(),
        };
        let fresh = sd * (1.0 - keeps * keeps).sqrt();
        let mut wander = normal(random, sd);
        let resolution = 1e-3 * most;
        for value in thrust {
            wander = keeps * wander + normal(random, fresh);
            *value = ((*value + wander) / resolution).round() * resolution;
        }
    }
}
