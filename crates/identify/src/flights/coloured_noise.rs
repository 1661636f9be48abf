//! Slow disturbances: turbulence that outlasts a sample, beside the white noise of the accelerometer.
//!
//! A pilot answers a disturbance with the throttle. While it lasts, throttle and disturbance go together, and least
//! squares take one for the other. Errors of prediction one step ahead do not: the residual of the disturbance then is
//! new. So residuals and their slopes pass through the innovations filter of
//!
//! ```text
//! e = d + white noise,    d an Ornstein–Uhlenbeck process of correlation time t_d
//! ```
//!
//! L. Ljung, "System Identification: Theory for the User" (1999), chapter 13 on data from closed loops.

use rayon::prelude::*;

use super::model::Segment;

/// Correlations are looked at up to this lag (s).
/// Longer ones are drifts, which the model has. Half or twice moves a lag by 0.1 % (measured).
const LONGEST_S: f64 = 0.6;
/// Shortest correlation time (s).
/// The finest step of the clock: shorter is white.
const SHORTEST_S: f64 = 0.01;
/// Least variance of the disturbance over that of the white noise.
/// Below it the noise is white to the last digit shown.
const LEAST_RATIO: f64 = 1e-4;
/// Steps of the search in the logarithms of time and ratios.
/// About the spacing of the grid that it starts from.
const FIRST_STEP: f64 = 0.3;
/// One per cent, well below the standard error of a correlation time.
const LAST_STEP: f64 = 0.01;
/// A disturbance with less than this share of the residual's power is left in the noise.
/// The standard error of a correlation over ten thousand rows; a smaller one is not significant in a few flights.
const LEAST_SHARE: f64 = 0.01;
/// Fewest rows from which the disturbance at some heights is taken.
/// Gives a variance to 6 %; fewer take the ratio of all heights.
const FEWEST_ROWS: f64 = 500.0;

/// Disturbances are stronger near the ground: heights (in R) between which they are distinguished.
/// Doubling heights: turbulence near the ground changes with height relative to the radius.
const EDGES: [f64; 3] = [1.0, 2.0, 4.0];

/// Power of disturbance and white noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColouredNoise {
    /// Correlation time of the disturbance (s).
    pub time_s: f64,
    /// Variance of the disturbance over that of the white noise, below each of 1, 2, 4 rotor radii and above.
    pub ratio: [f64; 4],
}

/// Sums of products of residuals some rows apart, and their counts.
type Products = Vec<(f64, f64)>;

fn band(height: Option<f64>) -> usize {
    height.map_or(EDGES.len(), |z| EDGES.iter().filter(|e| z >= **e).count())
}

impl ColouredNoise {
    /// From residuals of all runs at the rows that count; `None` where they are as good as white.
    pub(super) fn of(pieces: &[Segment], residuals: &[Vec<f64>], step_s: f64) -> Option<Self> {
        let many = (LONGEST_S / step_s) as usize;
        if many < 8 {
            return None;
        }
        let mut sums: [Products; 4] = std::array::from_fn(|_| vec![(0.0, 0.0); many + 1]);
        for (piece, residual) in pieces.iter().zip(residuals) {
            for (k, &row) in piece.rows.iter().enumerate() {
                let sums = &mut sums[band(piece.height.get(row).copied())];
                for (lag, (sum, count)) in sums.iter_mut().enumerate().take(k + 1) {
                    // Only over rows without a hole in between.
                    if row - piece.rows[k - lag] == lag {
                        *sum += residual[k] * residual[k - lag];
                        *count += 1.0;
                    }
                }
            }
        }
        let mean = |of: &[&Products]| -> Vec<f64> {
            (0..=many)
                .map(|lag| {
                    let (sum, n) = of
                        .iter()
                        .fold((0.0, 0.0), |(s, n), p| (s + p[lag].0, n + p[lag].1));
                    sum / f64::max(n, 1.0)
                })
                .collect()
        };
        let all = mean(&sums.each_ref());
        let power = all[0];
        if !(power > 0.0) {
            return None;
        }
        // Least squares of a decaying exponential, over a grid of its time; the first lags are left to the filters of
        // accelerometers.
        let height = |mean: &[f64], time_s: f64| -> (f64, f64) {
            let shape = |lag: usize| (-(lag as f64) * step_s / time_s).exp();
            let lags = || 2..=many;
            let up: f64 = lags().map(|l| shape(l) * mean[l]).sum();
            let down: f64 = lags().map(|l| shape(l).powi(2)).sum();
            let height = up / down;
            (
                height,
                lags().map(|l| (mean[l] - height * shape(l)).powi(2)).sum(),
            )
        };
        let (time_s, (disturbance, _)) = (0..40)
            .map(|k| 0.02 * 1.1f64.powi(k))
            .map(|time_s| (time_s, height(&all, time_s)))
            .min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
        if disturbance < LEAST_SHARE * power {
            return None;
        }
        let white = (power - disturbance).max(0.05 * power);
        let ratio = sums.each_ref().map(|p| {
            if p[0].1 < FEWEST_ROWS {
                return disturbance / white;
            }
            height(&mean(&[p]), time_s).0.max(0.0) / white
        });
        Some(Self { time_s, ratio }.likeliest(pieces, residuals))
    }

    /// The disturbance under which the residuals are likeliest, from this one on: a fit in its innovations and this go
    /// down the same likelihood in turn.
    fn likeliest(self, pieces: &[Segment], residuals: &[Vec<f64>]) -> Self {
        let mut best = self;
        let mut cost = best.cost(pieces, residuals);
        let mut step = FIRST_STEP;
        while step > LAST_STEP {
            let before = cost;
            for k in 0..=best.ratio.len() {
                for by in [step.exp(), (-step).exp()] {
                    let mut tried = best;
                    match k {
                        0 => tried.time_s = (tried.time_s * by).clamp(SHORTEST_S, LONGEST_S),
                        _ => tried.ratio[k - 1] = (tried.ratio[k - 1] * by).max(LEAST_RATIO),
                    }
                    let of_tried = tried.cost(pieces, residuals);
                    if of_tried < cost {
                        (best, cost) = (tried, of_tried);
                        break;
                    }
                }
            }
            if before - cost < 0.1 {
                step *= 0.5;
            }
        }
        best
    }

    /// `-2 ln L` of residuals, less what does not depend on the disturbance; the white noise at its likeliest power.
    fn cost(&self, pieces: &[Segment], residuals: &[Vec<f64>]) -> f64 {
        let (sum, logs, rows) = pieces
            .par_iter()
            .zip(residuals)
            .map(|(piece, residual)| {
                let mut state = 0.0;
                let (mut sum, mut logs) = (0.0, 0.0);
                let keep = self.keep(piece);
                for (value, step) in residual.iter().zip(self.steps(piece)) {
                    let new = step.innovation(&mut state, *value, keep);
                    sum += (step.scale * new).powi(2);
                    logs -= 2.0 * step.scale.ln();
                }
                (sum, logs, residual.len() as f64)
            })
            .reduce(|| (0.0, 0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
        rows * (sum / rows).ln() + logs
    }

    fn keep(&self, piece: &Segment) -> f64 {
        (-piece.step_s() / self.time_s).exp()
    }

    /// Gain and scale of each row: variance of the disturbance before a sample, relative to the white noise.
    fn steps<'a>(&'a self, piece: &'a Segment) -> impl Iterator<Item = FilterStep> + 'a {
        let keep = self.keep(piece);
        let mut before = 0.0;
        let mut last = usize::MAX;
        piece.rows.iter().map(move |&row| {
            let ratio = self.ratio[band(piece.height.get(row).copied())];
            let fresh = last == usize::MAX || last + 1 != row;
            last = row;
            if fresh {
                before = ratio;
            }
            let gain = before / (1.0 + before);
            let scale = (1.0 + before).sqrt().recip();
            before = keep * keep * before / (1.0 + before) + ratio * (1.0 - keep * keep);
            FilterStep { fresh, gain, scale }
        })
    }

    /// Filters columns of one run in place; their rows are those of the piece that count.
    pub(super) fn filter<'a>(
        &self,
        piece: &Segment,
        columns: impl IntoIterator<Item = &'a mut Vec<f64>>,
    ) {
        let keep = self.keep(piece);
        let steps: Vec<FilterStep> = self.steps(piece).collect();
        for column in columns {
            let mut state = 0.0;
            for (value, step) in column.iter_mut().zip(&steps) {
                *value = step.scale * step.innovation(&mut state, *value, keep);
            }
        }
    }
}

/// One step of the filter.
struct FilterStep {
    fresh: bool,
    gain: f64,
    scale: f64,
}

impl FilterStep {
    /// What is new in a value; the state is the disturbance to come.
    fn innovation(&self, state: &mut f64, value: f64, keep: f64) -> f64 {
        if self.fresh {
            *state = 0.0;
        }
        let new = value - *state;
        *state = keep * (*state + self.gain * new);
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution as _, StandardNormal};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::SeedableRng as _;

    #[test]
    fn analytic_a_known_disturbance_is_found_and_whitened() {
        let (step, time) = (0.01, 0.15);
        let keep = f64::exp(-step / time);
        let mut random = Pcg64::seed_from_u64(3);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let n = 100_000;
        let mut d = 0.0;
        let residual: Vec<f64> = (0..n)
            .map(|_| {
                d = keep * d + (1.0 - keep * keep).sqrt() * normal();
                d + normal()
            })
            .collect();
        let piece = Segment {
            flight: 0,
            run: 0,
            time_s: (0..n).map(|i| step * i as f64).collect(),
            throttle: Vec::new(),
            logged_throttle: Vec::new(),
            height: Vec::new(),
            climb_mps: Vec::new(),
            drift: crate::flights::drift::Drift::Unknown,
            on_s: None,
            force: Vec::new(),
            accelerometer: true,
            range_m: Vec::new(),
            climb_measured_mps: Vec::new(),
            tilt_rad: Vec::new(),
            rows: (0..n).collect(),
            bias_sd: 1.0,
        };
        let found = ColouredNoise::of(
            std::slice::from_ref(&piece),
            std::slice::from_ref(&residual),
            step,
        )
        .unwrap();
        // 6700 correlation times: some percent.
        assert!((found.time_s / time - 1.0).abs() < 0.15, "{found:?}");
        assert!((found.ratio[3] - 1.0).abs() < 0.15, "{found:?}");
        let mut white = residual;
        found.filter(&piece, [&mut white]);
        let product = |lag: usize| -> f64 {
            white
                .iter()
                .zip(&white[lag..])
                .map(|(a, b)| a * b)
                .sum::<f64>()
                / n as f64
        };
        // Standard error of a correlation of white noise: 0.003.
        for lag in 1..30 {
            assert!(
                (product(lag) / product(0)).abs() < 0.02,
                "{lag}: {}",
                product(lag)
            );
        }
        // In units of the white noise.
        assert!((product(0) - 1.0).abs() < 0.1, "{}", product(0));
    }
}
