//! The model of a flight: throttle to specific force, through motors, drift, climb and ground.
//!
//! ```text
//! (1 + ρ) T_m x' = u - (1 - ρ) x - ρ x²                                    motors; x is √T relative to hover
//! u = 1 + (1 + ρ) (e/2 r + c r²), r = s(t - d)/s0 - 1                      their drive; e the elasticity dlnT/dlns at s0
//! F = k (1 + q e^(-(t - t_on)/t_q)) (1 + w (V - V0)) (x² (1 + G) - x κ(z) v)  specific force in gravities
//! τ G' = h(z + b) - G                                                     or G = h(z + b); images: two lags of q, G of q
//! ```
//!
//! ρ is the share of the motors' load in hover that goes with the square of their speed, the drag of the rotors; the rest
//! goes with the speed itself. Motors with drag are quicker at speed, and thrust rises less steeply with throttle there.
//!
//! Thrust scale `k` and height error `b` belong to one armed interval, all other parameters to the vehicle.

mod wake;

pub use super::curve::{Curve, LENGTHS};
pub use super::shape::{ModelTerms, Parameter};

pub(super) use self::wake::{WakeState, follow};

use super::curve::{MOST, psi};
use super::drift::Drift;
use crate::delayed::DelayedSignal;
use crate::thrust::plateau::median;

/// Least and greatest √T relative to hover that a command gives.
/// Far outside flight: they keep a wild first guess finite. Half or twice moves nothing but last digits (measured).
const ROOT: [f64; 2] = [0.05, 2.5];

/// Values by name, zero where the shape has no such number.
#[derive(Clone, Copy, Debug)]
pub struct ModelValues {
    elasticity: f64,
    t_m_s: f64,
    dead_time_s: f64,
    drag: f64,
    curvature: f64,
    settling: f64,
    settling_s: f64,
    battery: f64,
    damping: f64,
    near_damping: f64,
    curve: Curve,
    of_curve: [f64; MOST],
    tau_s: f64,
    fountain_tau_s: f64,
    paced: bool,
    /// `None` in models without one: its trajectories need no other order of measurements.
    pub(super) accelerometer_latency_s: Option<f64>,
}

impl ModelValues {
    /// Reads the values of a shape.
    #[must_use]
    pub fn of(shape: &ModelTerms, theta: &[f64]) -> Self {
        let mut next = theta.iter().copied();
        let mut take = |has: bool| if has { next.next().unwrap_or(0.0) } else { 0.0 };
        let elasticity = take(true);
        let (t_m_s, dead_time_s) = (take(shape.motor_lag), take(shape.motor_lag));
        let drag = take(shape.drag);
        let curvature = take(shape.curvature);
        let (settling, settling_s) = (take(shape.settling), take(shape.settling));
        let battery = take(shape.battery);
        let damping = take(shape.damping);
        let near_damping = take(shape.near_damping);
        let many = shape.curve.many();
        let of_curve = std::array::from_fn(|i| take(i < many));
        let tau_s = take(shape.wake_lag);
        let fountain_tau_s = take(shape.fountain_lag);
        let latency_s = take(shape.accelerometer_latency);
        Self {
            elasticity,
            t_m_s,
            dead_time_s,
            drag,
            curvature,
            settling,
            settling_s,
            battery,
            damping,
            near_damping,
            curve: shape.curve,
            of_curve,
            tau_s,
            fountain_tau_s,
            paced: shape.fountain_lag && shape.curve == Curve::Images,
            accelerometer_latency_s: shape.accelerometer_latency.then_some(latency_s),
        }
    }

    /// Steady √T relative to hover, for a throttle relative to that of hover.
    #[must_use]
    pub fn root(&self, throttle: f64) -> f64 {
        let r = throttle - 1.0;
        let drive = (1.0
            + (1.0 + self.drag) * (0.5 * self.elasticity * r + self.curvature * r * r))
            .max(0.0);
        // The positive root of (1 - ρ) x + ρ x² = u, also for ρ = 0.
        let linear = 1.0 - self.drag;
        let root =
            2.0 * drive / (linear + (linear * linear + 4.0 * self.drag * drive).sqrt()).max(1e-9);
        root.clamp(ROOT[0], ROOT[1])
    }

    /// √T after a time at a constant steady value; exact. Without a lag, that value.
    fn motors(&self, root: f64, target: f64, dt: f64) -> f64 {
        if !(self.t_m_s > 0.0) {
            return target;
        }
        // y = x - target: (1 + ρ) T_m y' = -(a + ρ y) y.
        let (y, a) = (root - target, 1.0 - self.drag + 2.0 * self.drag * target);
        let keep = (-a * dt / ((1.0 + self.drag) * self.t_m_s)).exp();
        target + a * y * keep / (a + self.drag * y * (1.0 - keep))
    }

    /// Whether its motors are those of another.
    pub(super) fn has_motors_of(&self, other: &Self) -> bool {
        let of = |v: &Self| [v.elasticity, v.t_m_s, v.dead_time_s, v.drag, v.curvature];
        of(self) == of(other)
    }

    /// Whether its ground effect is that of another, where the motors are.
    pub(super) fn has_wake_of(&self, other: &Self) -> bool {
        let of = |v: &Self| (v.curve, v.of_curve, v.tau_s, v.fountain_tau_s, v.paced);
        of(self) == of(other) && (!self.paced || self.has_motors_of(other))
    }

    /// The steady ratio `h` at a height in R.
    #[must_use]
    pub fn at_rest(&self, height: f64) -> f64 {
        self.curve.lift(self.parts(height))
    }

    /// Climb damping at a height in R (s/m).
    pub(super) fn damping_at(&self, height: f64) -> f64 {
        self.damping + self.near_damping * psi(2, height)
    }

    /// The factor of drift of a row of a segment.
    fn drift(&self, segment: &Segment, row: usize) -> f64 {
        let mut drift = 1.0;
        if self.settling != 0.0
            && let Some(on) = segment.on_s
        {
            drift += self.settling * (-(segment.time_s[row] - on) / self.settling_s).exp();
        }
        if self.battery != 0.0
            && let Some(along) = segment.drift.at(row)
        {
            drift *= 1.0 + self.battery * along;
        }
        drift
    }

    fn parts(&self, height: f64) -> [f64; 2] {
        self.curve.parts(self.of_curve, height)
    }

    /// Lag of the ground effect at a height in R and a √T relative to hover (s), that of its first part.
    pub(super) fn lag_s(&self, height: f64, root: f64) -> f64 {
        self.lags_s(height, root)[0]
    }

    /// Lags of the two parts at a height in R and a √T relative to hover (s). With lags of their own they are the times
    /// that the air takes at the speed of the rotors' wake, which goes with √T: down by ζ and out by R for images, out by c, up by ζ and back by c for the fountain; `tau` and `fountain_tau` are those at ζ = R and ζ = 0.
    fn lags_s(&self, height: f64, root: f64) -> [f64; 2] {
        if !self.paced {
            return [self.tau_s; 2];
        }
        let [_, _, distance, offset] = self.of_curve;
        let rotor = (height + offset).max(0.0);
        let root = root.max(ROOT[0]);
        [
            self.tau_s * (rotor + 1.0) / (2.0 * root),
            self.fountain_tau_s * (rotor + 2.0 * distance) / (2.0 * distance * root),
        ]
    }
}

/// One armed interval, prepared for simulation.
#[derive(Clone, Debug)]
pub struct Segment {
    /// Index of the flight that it is of.
    pub flight: usize,
    /// Index of the run in the flight.
    pub run: usize,
    /// Stamps (s).
    pub time_s: Vec<f64>,
    /// Throttle over that of hover; smoothed as the force where that is from poses.
    pub throttle: Vec<f64>,
    /// Throttle as logged over that of hover, where `throttle` is smoothed; empty elsewhere.
    pub logged_throttle: Vec<f64>,
    /// Height in R; empty where it was not measured.
    pub height: Vec<f64>,
    /// Climb rate (m/s); empty where it was not measured.
    pub climb_mps: Vec<f64>,
    /// What thrust may drift with.
    pub drift: Drift,
    /// Start of the motors (s), if the log contains it.
    pub on_s: Option<f64>,
    /// Specific force in gravities.
    pub force: Vec<f64>,
    /// Whether that is the accelerometer's.
    pub accelerometer: bool,
    /// Height where it was measured (m), NaN elsewhere.
    pub range_m: Vec<f64>,
    /// Climb rate where it was measured (m/s), NaN elsewhere; empty where it was not.
    pub climb_measured_mps: Vec<f64>,
    /// Tilt of the rotor axis (rad); empty where it was not measured.
    pub tilt_rad: Vec<f64>,
    /// Rows that count.
    pub rows: Vec<usize>,
    /// Standard deviation of the height's constant error, in R.
    pub bias_sd: f64,
}

impl Segment {
    /// Median step of the clock (s).
    #[must_use]
    pub fn step_s(&self) -> f64 {
        median(self.time_s.windows(2).map(|p| p[1] - p[0])).unwrap_or(1.0)
    }

    /// Median of the steps of all segments (s).
    pub(in crate::flights) fn median_step_s(segments: &[Self]) -> f64 {
        median(segments.iter().map(Self::step_s)).unwrap_or(1.0)
    }

    /// √T relative to hover and the factor of drift, for every row.
    ///
    /// A command acts from its stamp plus the dead time on, until the next one does, as actuators hold it. A command never
    /// moves what was measured before it: it answers the noise of the very row that it is logged with, and an
    /// interpolation would take that answer for a cause. So would a throttle that is smoothed over what comes after.
    pub(super) fn drive(&self, v: &ModelValues) -> Vec<[f64; 2]> {
        self.drive_before(v, 0.0)
    }

    /// The same, so long before every row (s).
    pub(super) fn drive_before(&self, v: &ModelValues, before_s: f64) -> Vec<[f64; 2]> {
        let command = if self.logged_throttle.is_empty() {
            &self.throttle
        } else {
            &self.logged_throttle
        };
        let targets: Vec<f64> = command.iter().map(|u| v.root(*u)).collect();
        let time = &self.time_s;
        let mut x = targets[0];
        // The command that acts, and until when the motors are known.
        let (mut acts, mut until) = (0, time[0]);
        (0..time.len())
            .map(|i| {
                if !(v.t_m_s > 0.0) {
                    return [targets[i], v.drift(self, i)];
                }
                let at_s = time[i] - before_s;
                while until < at_s {
                    let next = time
                        .get(acts + 1)
                        .map_or(f64::INFINITY, |t| t + v.dead_time_s);
                    let end = next.min(at_s);
                    x = v.motors(x, targets[acts], (end - until).max(0.0));
                    until = end.max(until);
                    if next <= at_s {
                        acts += 1;
                    }
                }
                [x, v.drift(self, i)]
            })
            .collect()
    }

    /// Height where it is next measured from a row on (m).
    pub(super) fn range_after(&self, row: usize) -> Option<f64> {
        self.range_m[row..].iter().copied().find(|z| z.is_finite())
    }

    /// Cosine of the tilt; level where that was not measured.
    pub(super) fn lean(&self, row: usize) -> f64 {
        let tilt = self.tilt_rad.get(row).filter(|t| t.is_finite());
        tilt.map_or(1.0, |t| t.cos())
    }

    /// √T relative to hover, for every row. The throttle goes along a line between its samples.
    pub(super) fn roots(&self, v: &ModelValues) -> Vec<f64> {
        let mut late = DelayedSignal::new(&self.time_s, &self.throttle);
        let mut x = v.root(self.throttle[0]);
        let mut before = x;
        let mut last_s = self.time_s[0];
        self.time_s
            .iter()
            .map(|&time_s| {
                let target = v.root(late.at(time_s - v.dead_time_s));
                // Exact for a constant command, otherwise of second order.
                let mean = match v.t_m_s > 0.0 {
                    true => 0.5 * (before + target),
                    false => target,
                };
                x = v.motors(x, mean, time_s - last_s);
                (before, last_s) = (target, time_s);
                x
            })
            .collect()
    }

    /// The ratio of thrusts minus one at given √T, for every row that counts.
    pub(super) fn lifts(&self, v: &ModelValues, bias: f64, roots: &[f64]) -> Vec<f64> {
        if v.curve == Curve::Free || self.height.is_empty() {
            return vec![0.0; self.rows.len()];
        }
        let mut out = Vec::with_capacity(self.rows.len());
        let mut wake = WakeState::default();
        let mut from = 0;
        for &row in &self.rows {
            for i in from..=row {
                let dt = self.time_s[i] - self.time_s[i.saturating_sub(1)];
                wake.step(v, self.height[i] + bias, dt, roots[i]);
            }
            from = row + 1;
            out.push(wake.lift(v));
        }
        out
    }

    /// The specific force over the scale `k` at given √T and ratios of thrusts, for every row that counts.
    pub(super) fn forces(
        &self,
        v: &ModelValues,
        bias: f64,
        roots: &[f64],
        lifts: &[f64],
    ) -> Vec<f64> {
        let of_row = |(&i, lift): (&usize, &f64)| {
            let x = roots[i];
            let damping = if v.near_damping == 0.0 {
                v.damping
            } else {
                v.damping_at(self.height[i] + bias)
            };
            let climb = if damping == 0.0 {
                0.0
            } else {
                damping * self.climb_mps[i]
            };
            v.drift(self, i) * x * (x * (1.0 + lift) - climb)
        };
        self.rows.iter().zip(lifts).map(of_row).collect()
    }

    /// The specific force over the scale `k`, for every row that counts.
    #[must_use]
    pub fn simulate(&self, values: &ModelValues, bias: f64) -> Vec<f64> {
        let roots = self.roots(values);
        self.forces(values, bias, &roots, &self.lifts(values, bias, &roots))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step_piece() -> Segment {
        let time_s: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
        Segment {
            flight: 0,
            run: 0,
            throttle: time_s
                .iter()
                .map(|t| if *t < 0.5 { 1.0 } else { 1.2 })
                .collect(),
            logged_throttle: Vec::new(),
            height: vec![1.0; 200],
            climb_mps: vec![0.5; 200],
            drift: Drift::Unknown,
            on_s: Some(0.0),
            force: vec![1.0; 200],
            accelerometer: true,
            range_m: vec![1.0; 200],
            climb_measured_mps: Vec::new(),
            tilt_rad: Vec::new(),
            rows: (0..200).collect(),
            bias_sd: 0.1,
            time_s,
        }
    }

    #[test]
    fn analytic_step_of_throttle_through_lag_and_dead_time() {
        let shape = ModelTerms::plain(Curve::Free, false, true);
        let run = step_piece().simulate(&ModelValues::of(&shape, &[1.5, 0.1, 0.03]), 0.0);
        // √T goes from 1 to 1 + 0.75 × 0.2, from 0.53 s on (the line between two samples ends there).
        let x = 1.0 + 0.15 * (1.0 - (-(1.0f64 - 0.53) / 0.1).exp());
        // A command that rises over one sample of 0.01 s instead of at its end: at most 0.15 × 0.1 × e^-4.7.
        assert!((run[100] - x * x).abs() < 3e-4, "{} {}", run[100], x * x);
        assert!((run[50] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn analytic_step_of_throttle_of_motors_with_drag() {
        let shape = ModelTerms {
            drag: true,
            ..ModelTerms::plain(Curve::Free, false, true)
        };
        let run = step_piece().simulate(&ModelValues::of(&shape, &[1.5, 0.1, 0.03, 0.6]), 0.0);
        // Drive 1 + 1.6 × 0.75 × 0.2 = 1.24 = 0.4 x + 0.6 x² at rest; roots of opposite sign, (x - end)/(x - other) decays at
        // the rate 0.6 (end - other)/(1.6 × 0.1 s).
        let root = (0.16f64 + 4.0 * 0.6 * 1.24).sqrt();
        let (end, other) = ((root - 0.4) / 1.2, (-root - 0.4) / 1.2);
        let left = (1.0 - end) / (1.0 - other) * (-0.6 * (end - other) / 0.16 * 0.47).exp();
        let x = (end - other * left) / (1.0 - left);
        // As above.
        assert!((run[100] - x * x).abs() < 3e-4, "{} {}", run[100], x * x);
        // Elasticity 1.5 at hover: a hundredth of throttle less is 1.5 hundredths of thrust, to second order 1e-4.
        let slow = ModelValues::of(&shape, &[1.5, 0.1, 0.03, 0.6]).root(0.99);
        assert!((slow * slow - 0.985).abs() < 1e-4);
    }

    #[test]
    fn analytic_drift_damping_and_curve_multiply() {
        let mut shape = ModelTerms::plain(Curve::Exponential, true, false);
        shape.settling = true;
        let run = step_piece().simulate(
            &ModelValues::of(&shape, &[2.0, -0.1, 0.5, 0.04, 0.2, 2.0]),
            0.5,
        );
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
            Curve::Images,
        ] {
            for bits in 0..=1023u16 {
                let on = |k: u16| bits >> k & 1 == 1;
                let shape = ModelTerms {
                    exponent: [1.5, 1.0],
                    motor_lag: on(0),
                    logged_late: false,
                    drag: on(8),
                    curvature: on(1),
                    settling: on(2),
                    battery: on(3),
                    damping: on(4),
                    near_damping: on(6),
                    curve,
                    wake_lag: on(5),
                    fountain_lag: on(7),
                    accelerometer_latency: on(9),
                };
                let theta: Vec<f64> = (1..=shape.parameters().len()).map(|i| i as f64).collect();
                let read = ModelValues::of(&shape, &theta);
                let last = theta.len() as f64;
                let of_last = if shape.accelerometer_latency {
                    read.accelerometer_latency_s.unwrap()
                } else if shape.fountain_lag {
                    read.fountain_tau_s
                } else if shape.wake_lag {
                    read.tau_s
                } else {
                    last
                };
                assert_eq!(of_last, last);
            }
        }
    }
}
