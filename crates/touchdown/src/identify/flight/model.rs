//! The model of a flight: throttle to specific force, through motors, drift, climb and ground.
//!
//! ```text
//! T_m x' = 1 + e/2 (s(t - d)/s0 - 1) + c (s(t - d)/s0 - 1)² - x          motors; e the elasticity dlnT/dlns at s0
//! F = k (1 + q e^(-(t - t_on)/t_q)) (1 + u (V - V0)) x² (1 + G - κ(z) v)  specific force in gravities
//! τ G' = h(z + b) - G                                                    or G = h(z + b)
//! ```
//!
//! Thrust scale `k` and height error `b` belong to one run of the motors, all else to the vehicle.

pub use super::shape::{Curve, Parameter, Shape};

use crate::identify::thrust::plateau::median;

/// Least and greatest √T relative to hover that a command gives.
const ROOT: [f64; 2] = [0.05, 2.5];
/// Greatest q of eq. (2).
const Q_MAX: f64 = 0.6;
/// Least rotor height that eq. (2) is used at, in R.
const LEAST_HEIGHT: f64 = 0.3;
/// Lengths of the bounded rationals, in R.
pub const LENGTHS: [f64; 3] = [0.6, 1.5, 3.5];

/// Values by name, zero where the shape has no such number.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    elasticity: f64,
    t_m_s: f64,
    dead_time_s: f64,
    curvature: f64,
    settling: f64,
    settling_s: f64,
    battery: f64,
    damping: f64,
    near_damping: f64,
    curve: Curve,
    of_curve: [f64; 3],
    tau_s: f64,
}

impl Values {
    /// Reads the values of a shape.
    #[must_use]
    pub fn of(shape: &Shape, theta: &[f64]) -> Self {
        let mut next = theta.iter().copied();
        let mut take = |has: bool| if has { next.next().unwrap_or(0.0) } else { 0.0 };
        let elasticity = take(true);
        let (t_m_s, dead_time_s) = (take(shape.motor_lag), take(shape.motor_lag));
        let curvature = take(shape.curvature);
        let (settling, settling_s) = (take(shape.settling), take(shape.settling));
        let battery = take(shape.battery);
        let damping = take(shape.damping);
        let near_damping = take(shape.near_damping);
        let many = match shape.curve {
            Curve::Free => 0,
            Curve::Exponential | Curve::Empirical => 2,
            Curve::Rational => 3,
        };
        let of_curve = std::array::from_fn(|i| take(i < many));
        Self {
            elasticity,
            t_m_s,
            dead_time_s,
            curvature,
            settling,
            settling_s,
            battery,
            damping,
            near_damping,
            curve: shape.curve,
            of_curve,
            tau_s: take(shape.wake_lag),
        }
    }

    /// The ratio at rest `h`, at a height in R.
    #[must_use]
    pub fn at_rest(&self, height: f64) -> f64 {
        let [a, b, c] = self.of_curve;
        match self.curve {
            Curve::Free => 0.0,
            Curve::Exponential => a * (-height.max(0.0) / b).exp(),
            Curve::Empirical => {
                let rotor = (height + b).max(LEAST_HEIGHT);
                let q = (a / (16.0 * rotor * rotor)).clamp(-Q_MAX, Q_MAX);
                q / (1.0 - q)
            }
            Curve::Rational => (0..)
                .zip([a, b, c])
                .map(|(i, h)| h * self.psi(i, height))
                .sum(),
        }
    }

    /// `ψ = 1/(1 + (z/l)²)` of a length, at a height in R.
    fn psi(&self, of: usize, height: f64) -> f64 {
        1.0 / (1.0 + (height / LENGTHS[of]).powi(2))
    }
}

/// One run of the motors, ready to be simulated.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Index of the flight that it is of.
    pub flight: usize,
    /// Index of the run in the flight.
    pub run: usize,
    /// Stamps (s).
    pub time_s: Vec<f64>,
    /// Throttle over that of hover.
    pub throttle: Vec<f64>,
    /// Height in R; empty where it was not measured.
    pub height: Vec<f64>,
    /// Climb rate (m/s); empty where it was not measured.
    pub climb_mps: Vec<f64>,
    /// Voltage relative to the mean (V); empty where it was not measured.
    pub battery_v: Vec<f64>,
    /// Start of the motors (s), where it was seen.
    pub on_s: Option<f64>,
    /// Specific force in gravities.
    pub force: Vec<f64>,
    /// Rows that count.
    pub rows: Vec<usize>,
    /// Standard deviation of the height's constant error, in R.
    pub bias_sd: f64,
}

impl Piece {
    /// Median step of the clock (s).
    #[must_use]
    pub fn step_s(&self) -> f64 {
        median(self.time_s.windows(2).map(|p| p[1] - p[0])).unwrap_or(1.0)
    }

    /// The specific force over the scale `k`, for every row that counts.
    #[must_use]
    pub fn simulate(&self, values: &Values, bias: f64) -> Vec<f64> {
        let v = values;
        let n = self.time_s.len();
        let level = |s: f64| {
            let d = s - 1.0;
            (1.0 + 0.5 * v.elasticity * d + v.curvature * d * d).clamp(ROOT[0], ROOT[1])
        };
        let mut out = Vec::with_capacity(self.rows.len());
        let mut next = self.rows.iter().copied().peekable();
        let mut late = Late {
            time: &self.time_s,
            values: &self.throttle,
            at: 0,
        };
        let grounded = v.curve != Curve::Free && !self.height.is_empty();
        let ratio = |i: usize| {
            let z = self.height[i] + bias;
            if z.is_finite() {
                Some(v.at_rest(z))
            } else {
                None
            }
        };
        let mut x = level(self.throttle[0]);
        let mut g = if grounded {
            ratio(0).unwrap_or(0.0)
        } else {
            0.0
        };
        for i in 0..n {
            let dt = if i == 0 {
                0.0
            } else {
                self.time_s[i] - self.time_s[i - 1]
            };
            let target = level(late.at(self.time_s[i] - v.dead_time_s));
            x = relax(x, target, dt, v.t_m_s);
            if grounded && let Some(h) = ratio(i) {
                g = relax(g, h, dt, v.tau_s);
            }
            if next.peek() != Some(&i) {
                continue;
            }
            next.next();
            let mut drift = 1.0;
            if v.settling != 0.0
                && let Some(on) = self.on_s
            {
                drift += v.settling * (-(self.time_s[i] - on) / v.settling_s).exp();
            }
            if v.battery != 0.0 && !self.battery_v.is_empty() {
                drift *= 1.0 + v.battery * self.battery_v[i];
            }
            let mut damping = v.damping;
            if v.near_damping != 0.0 {
                damping += v.near_damping * v.psi(2, self.height[i] + bias);
            }
            let climb = if damping == 0.0 {
                0.0
            } else {
                damping * self.climb_mps[i]
            };
            out.push(drift * x * x * (1.0 + g - climb));
        }
        out
    }
}

/// A lag over one step at whose end the input is `target`; without a lag, the input itself.
fn relax(state: f64, target: f64, dt: f64, lag_s: f64) -> f64 {
    if lag_s > 0.0 {
        target + (state - target) * (-dt / lag_s).exp()
    } else {
        target
    }
}

/// A signal at earlier times, on lines between its samples; times must not fall.
struct Late<'a> {
    time: &'a [f64],
    values: &'a [f64],
    at: usize,
}

impl Late<'_> {
    fn at(&mut self, t: f64) -> f64 {
        let (time, values) = (self.time, self.values);
        while self.at + 1 < time.len() && time[self.at + 1] <= t {
            self.at += 1;
        }
        let k = self.at;
        if k + 1 >= time.len() || t <= time[k] {
            return values[k];
        }
        values[k] + (t - time[k]) / (time[k + 1] - time[k]) * (values[k + 1] - values[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step_piece() -> Piece {
        let time_s: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
        Piece {
            flight: 0,
            run: 0,
            throttle: time_s
                .iter()
                .map(|t| if *t < 0.5 { 1.0 } else { 1.2 })
                .collect(),
            height: vec![1.0; 200],
            climb_mps: vec![0.5; 200],
            battery_v: Vec::new(),
            on_s: Some(0.0),
            force: vec![1.0; 200],
            rows: (0..200).collect(),
            bias_sd: 0.1,
            time_s,
        }
    }

    #[test]
    fn analytic_step_of_throttle_through_lag_and_dead_time() {
        let shape = Shape::plain(Curve::Free, false, true);
        let run = step_piece().simulate(&Values::of(&shape, &[1.5, 0.1, 0.03]), 0.0);
        // √T goes from 1 to 1 + 0.75 × 0.2, from 0.53 s on (the line between two samples ends there).
        let x = 1.0 + 0.15 * (1.0 - (-(1.0f64 - 0.53) / 0.1).exp());
        // A command that rises over one sample of 0.01 s instead of at its end: at most 0.15 × 0.1 × e^-4.7.
        assert!((run[100] - x * x).abs() < 3e-4, "{} {}", run[100], x * x);
        assert!((run[50] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn analytic_drift_damping_and_curve_multiply() {
        let mut shape = Shape::plain(Curve::Exponential, true, false);
        shape.settling = true;
        let run =
            step_piece().simulate(&Values::of(&shape, &[2.0, -0.1, 0.5, 0.04, 0.2, 2.0]), 0.5);
        let drift = 1.0 - 0.1 * (-0.2f64 / 0.5).exp();
        let expected = drift * (1.0 + 0.2 * (-1.5f64 / 2.0).exp() - 0.04 * 0.5);
        // Closed form: rounding only.
        assert!((run[20] - expected).abs() < 1e-12);
    }

    #[test]
    fn prop_every_shape_reads_as_many_values_as_it_names() {
        for curve in [
            Curve::Free,
            Curve::Exponential,
            Curve::Empirical,
            Curve::Rational,
        ] {
            for bits in 0..128u8 {
                let on = |k: u8| bits >> k & 1 == 1;
                let shape = Shape {
                    exponent: [1.5, 1.0],
                    motor_lag: on(0),
                    curvature: on(1),
                    settling: on(2),
                    battery: on(3),
                    damping: on(4),
                    near_damping: on(6),
                    curve,
                    wake_lag: on(5),
                };
                let theta: Vec<f64> = (1..=shape.parameters().len()).map(|i| i as f64).collect();
                let read = Values::of(&shape, &theta);
                let last = theta.len() as f64;
                let of_last = if shape.wake_lag { read.tau_s } else { last };
                assert_eq!(of_last, last);
            }
        }
    }
}
