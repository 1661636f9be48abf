//! Kalman smoother with constant-velocity or constant-acceleration motion, on any increasing grid.
//!
//! The signal is the first entry of a state whose highest derivative wanders as white noise of density `q`;
//! the samples carry white noise of variance `σ²`:
//!
//! ```text
//! constant velocity      ẍ = w        y_i = x(t_i) + v_i,   E[w w'] = q δ(t - t'),   E[v_i²] = σ²
//! constant acceleration  x⃛ = w
//! ```
//!
//! Only `q/σ²` matters (unit: time⁻³ or time⁻⁵); it is given, or maximises the likelihood of the innovations
//! with `σ²` concentrated out. A forward filter and a backward pass over the stored innovations give
//! the mean of the Rauch–Tung–Striebel smoother without inverting a covariance (Bryson–Frazier form). The
//! start is diffuse. With constant velocity this is the cubic smoothing spline of `λ = σ²/q`.
//!
//! Sources: H. E. Rauch, F. Tung, C. T. Striebel, "Maximum likelihood estimates of linear dynamic systems",
//! AIAA Journal 3 (1965); G. J. Bierman, "Fixed interval smoothing with discrete measurements",
//! International Journal of Control 18 (1973); G. Wahba, JRSS B 40 (1978) for the equivalence.

use nalgebra::{SMatrix, SVector};

use crate::data::grid;
use crate::derivative::savgol::Smoothed;
use crate::error::SindyError;
use crate::numerics::minimum_on_grid;

/// Variance of the unknown start, in units of `σ²`: large against anything a filter then learns, small enough
/// to lose no more than half of the digits.
const DIFFUSE: f64 = 1e8;

/// The motion of an undisturbed signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The velocity wanders.
    ConstantVelocity,
    /// The acceleration wanders.
    ConstantAcceleration,
}

/// Settings of a Kalman smoother, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KalmanSmoother {
    motion: Motion,
    ratio: Option<f64>,
}

/// A smoothed signal and the noise that it was smoothed with.
#[derive(Clone, Debug, PartialEq)]
pub struct KalmanFit {
    /// Value and slope at the samples.
    pub smoothed: Smoothed,
    /// `q/σ²`, in time⁻³ (constant velocity) or time⁻⁵ (constant acceleration).
    pub ratio: f64,
    /// Standard deviation `σ` of the samples' noise, in the signal's unit.
    pub noise: f64,
    /// Log-likelihood of the innovations after the start.
    pub log_likelihood: f64,
}

impl KalmanSmoother {
    /// A smoother with a given `ratio = q/σ²`, in time⁻³ or time⁻⁵.
    ///
    /// # Errors
    /// A ratio that is not positive and finite.
    pub fn new(motion: Motion, ratio: f64) -> Result<Self, SindyError> {
        if ratio > 0.0 && ratio.is_finite() {
            Ok(Self {
                motion,
                ratio: Some(ratio),
            })
        } else {
            Err(SindyError::setting("ratio", "positive and finite", ratio))
        }
    }

    /// A smoother whose process noise is chosen by maximum likelihood.
    #[must_use]
    pub fn maximum_likelihood(motion: Motion) -> Self {
        Self {
            motion,
            ratio: None,
        }
    }

    /// The motion of an undisturbed signal.
    #[must_use]
    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// `q/σ²`, `None` where it is chosen from the data.
    #[must_use]
    pub fn ratio(&self) -> Option<f64> {
        self.ratio
    }

    /// Smooths `y` sampled at `time` and differentiates it.
    ///
    /// # Errors
    /// As [`KalmanSmoother::fit`].
    pub fn apply(&self, time: &[f64], y: &[f64]) -> Result<Smoothed, SindyError> {
        Ok(self.fit(time, y)?.smoothed)
    }

    /// Smooths, and returns the noise that it used.
    ///
    /// # Errors
    /// Fewer than 5 samples, lengths that differ, non-finite values, times that do not increase.
    pub fn fit(&self, time: &[f64], y: &[f64]) -> Result<KalmanFit, SindyError> {
        grid::check(time, y, 5)?;
        match self.motion {
            Motion::ConstantVelocity => self.run::<2>(time, y),
            Motion::ConstantAcceleration => self.run::<3>(time, y),
        }
    }

    fn run<const N: usize>(&self, time: &[f64], y: &[f64]) -> Result<KalmanFit, SindyError> {
        let n = y.len();
        let dt = grid::mean_period(time);
        let unit = dt.powi(2 * N as i32 - 1);
        let step: Vec<f64> = (1..n).map(|i| (time[i] - time[i - 1]) / dt).collect();
        let ratio = match self.ratio {
            Some(ratio) => ratio * unit,
            None => {
                // In mean periods the smoother passes angular frequencies up to about ratio^(1/2N): from
                // less than a turn in the record to beyond the Nyquist frequency.
                let power = 2.0 * N as f64;
                let points = 2 * (n as f64).ln() as usize + 12;
                let (best, _) = minimum_on_grid(-(n as f64).ln(), 2.0, points, |log_omega| {
                    -filter::<N>(&step, y, (power * log_omega).exp(), None).log_likelihood
                });
                (power * best).exp()
            }
        };
        let mut record = Vec::with_capacity(n);
        let end = filter::<N>(&step, y, ratio, Some(&mut record));
        let mut smoothed = Smoothed {
            value: vec![0.0; n],
            derivative: vec![0.0; n],
        };
        // r_{i-1} = Hᵀ e/S + (I - K H)ᵀ Fᵀ r_i, x̂_i = x_i + P_i r_{i-1}.
        let mut r = SVector::<f64, N>::zeros();
        for (i, s) in record.iter().enumerate().rev() {
            if i + 1 < n {
                r = transition::<N>(step[i]).tr_mul(&r);
            }
            let gain = s.covariance.column(0) / s.variance;
            r[0] += s.innovation / s.variance - gain.dot(&r);
            let state = s.state + s.covariance * r;
            smoothed.value[i] = state[0];
            smoothed.derivative[i] = state[1] / dt;
        }
        Ok(KalmanFit {
            smoothed,
            ratio: ratio / unit,
            noise: end.variance.sqrt(),
            log_likelihood: end.log_likelihood,
        })
    }
}

/// The filter's prediction of one sample and what came.
struct Step<const N: usize> {
    state: SVector<f64, N>,
    covariance: SMatrix<f64, N, N>,
    innovation: f64,
    variance: f64,
}

struct End {
    /// The concentrated `σ²`.
    variance: f64,
    log_likelihood: f64,
}

/// The forward pass with unit measurement variance; `step` in mean periods.
fn filter<const N: usize>(
    step: &[f64],
    y: &[f64],
    ratio: f64,
    mut record: Option<&mut Vec<Step<N>>>,
) -> End {
    let mut state = SVector::<f64, N>::zeros();
    state[0] = y[0];
    state[1] = (y[1] - y[0]) / step[0];
    let mut covariance = SMatrix::<f64, N, N>::identity() * DIFFUSE;
    let (mut squares, mut logs) = (0.0, 0.0);
    for (i, &y_i) in y.iter().enumerate() {
        if i > 0 {
            let f = transition::<N>(step[i - 1]);
            state = f * state;
            covariance = f * covariance * f.transpose() + process::<N>(step[i - 1]) * ratio;
        }
        let innovation = y_i - state[0];
        let variance = covariance[(0, 0)] + 1.0;
        if let Some(record) = record.as_deref_mut() {
            record.push(Step {
                state,
                covariance,
                innovation,
                variance,
            });
        }
        // The first N innovations only locate the signal's start.
        if i >= N {
            squares += innovation * innovation / variance;
            logs += variance.ln();
        }
        let gain: SVector<f64, N> = covariance.column(0) / variance;
        state += gain * innovation;
        covariance -= gain * gain.transpose() * variance;
        // Row and column 0 without cancellation: P H / S times the unit measurement variance.
        for k in 0..N {
            covariance[(0, k)] = gain[k];
            covariance[(k, 0)] = gain[k];
        }
    }
    let count = (y.len() - N) as f64;
    let variance = squares / count;
    let log_likelihood =
        -0.5 * (count * ((2.0 * std::f64::consts::PI * variance).ln() + 1.0) + logs);
    End {
        variance,
        log_likelihood,
    }
}

fn transition<const N: usize>(h: f64) -> SMatrix<f64, N, N> {
    let power = [1.0, h, h * h / 2.0];
    SMatrix::from_fn(|i, j| if j >= i { power[j - i] } else { 0.0 })
}

/// Covariance that white noise of unit density in the last derivative builds up over `h`:
/// `∫ s^(a+b) / (a! b!) ds` with `a`, `b` the integrations down to each entry.
fn process<const N: usize>(h: f64) -> SMatrix<f64, N, N> {
    let factorial = [1.0, 1.0, 2.0];
    SMatrix::from_fn(|i, j| {
        let (a, b) = (N - 1 - i, N - 1 - j);
        let power = (a + b + 1) as i32;
        h.powi(power) / (f64::from(power) * factorial[a] * factorial[b])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derivative::SmoothingSpline;
    use crate::derivative::tests::signals::{gauss, lorenz};

    fn rms(a: &[f64], b: &[f64]) -> f64 {
        (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
    }

    #[test]
    fn analytic_constant_velocity_is_the_cubic_smoothing_spline() {
        let time: Vec<f64> = (0..200)
            .map(|i| 0.1 * f64::from(i) + 0.04 * (2.0 * f64::from(i)).sin())
            .collect();
        let y: Vec<f64> = time
            .iter()
            .zip(gauss(1, 200))
            .map(|(t, e)| 3.0 * t.sin() + 0.3 * e)
            .collect();
        for ratio in [1e-2, 1.0, 1e3] {
            let ours = KalmanSmoother::new(Motion::ConstantVelocity, ratio).unwrap();
            let ours = ours.apply(&time, &y).unwrap();
            let spline = SmoothingSpline::new(1.0 / ratio)
                .unwrap()
                .apply(&time, &y)
                .unwrap();
            // The start is diffuse to 1e-8, and a covariance of 1e8 leaves rounding of 1e-8.
            assert!(rms(&ours.value, &spline.value) < 1e-6);
            assert!(rms(&ours.derivative, &spline.derivative) < 1e-5);
        }
    }

    #[test]
    fn prop_likelihood_finds_the_noise_and_smooths() {
        let (t, x, dx) = lorenz(3000, 0.004);
        let y: Vec<f64> = x
            .iter()
            .zip(gauss(3, 3000))
            .map(|(x, e)| x + 0.4 * e)
            .collect();
        // Differences err by 70; the bars are a third above what was measured for each motion.
        for (motion, bar) in [
            (Motion::ConstantVelocity, 6.5),
            (Motion::ConstantAcceleration, 4.5),
        ] {
            let fit = KalmanSmoother::maximum_likelihood(motion)
                .fit(&t, &y)
                .unwrap();
            // Scatter of a standard deviation over 3000 samples: 1.3 %.
            assert!(
                (fit.noise / 0.4 - 1.0).abs() < 0.06,
                "{motion:?} {}",
                fit.noise
            );
            let error = rms(&fit.smoothed.derivative, &dx);
            assert!(error < bar, "{motion:?} {error}");
        }
    }

    #[test]
    fn prop_bad_input_and_flat_signals() {
        let s = KalmanSmoother::maximum_likelihood(Motion::ConstantAcceleration);
        assert!(KalmanSmoother::new(Motion::ConstantVelocity, -1.0).is_err());
        assert!(matches!(
            s.apply(&[0.0, 1.0], &[0.0, 1.0]),
            Err(SindyError::TooShort { .. })
        ));
        let t: Vec<f64> = (0..40).map(f64::from).collect();
        for y in [vec![2.0; 40], t.iter().map(|t| 2.0 * t).collect()] {
            let out = s.fit(&t, &y).unwrap();
            let slope = y[1] - y[0];
            assert!(
                out.smoothed
                    .derivative
                    .iter()
                    .all(|d| (d - slope).abs() < 1e-9)
            );
        }
    }
}
