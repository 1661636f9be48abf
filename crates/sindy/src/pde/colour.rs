//! The noise of a field as it is: its variance with the tails, and how much neighbouring samples share.
//!
//! Differences of a high enough order along one axis hold noise alone: their level, over the root of the sum of their squared
//! weights, no longer changes with the order. Their correlation along another axis is that of the noise,
//!
//! ```text
//! ρ(τ) = sin(π/2 · mean sign(e_i) sign(e_(i + τ)))
//! ```
//!
//! which outliers do not bend. Noise with memory along all axes of a grid cannot be separated from the field in this way: it is taken
//! as white along those of which no other axis tells.
//!
//! Source: W. H. Kruskal, "Ordinal measures of association", Journal of the American Statistical Association 53 (1958), for
//! the quadrant correlation.

use std::f64::consts::FRAC_PI_2;

use super::data::{Axis, FieldData};
use super::fit::SURE;
use crate::numerics::upper_median;

/// Orders of difference, at most: weights of higher ones look alike, so that they say no more.
const ORDERS: usize = 10;
/// Differences of which the median is taken, about: it scatters by 1 %.
const SAMPLED: usize = 1 << 15;

/// The noise of a field.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NoiseColour {
    pub(super) variance: f64,
    /// By axis, the correlation of samples 0, 1, 2, ... apart.
    pub(super) correlations: Vec<Vec<f64>>,
}

impl NoiseColour {
    /// Of a field, whose noise has the variance `white` if it is white and normal.
    pub(super) fn new(data: &FieldData, field: usize, white: f64) -> Self {
        let axes = data.axes().len();
        let plateaus: Vec<Option<Differences>> = (0..axes)
            .map(|axis| Differences::of_noise(data, field, axis))
            .collect();
        let mut correlations = vec![vec![1.0]; axes];
        for (axis, correlation) in correlations.iter_mut().enumerate() {
            let others = plateaus.iter().enumerate().filter(|(b, _)| *b != axis);
            let others = others.filter_map(|(_, d)| d.as_ref());
            if let Some(differences) = others.min_by_key(|d| d.order) {
                *correlation = differences.correlation(data, axis);
            }
        }
        let of_axis = |(axis, d): (usize, &Option<Differences>)| {
            let d = d.as_ref()?;
            // What differences along this axis leave of noise with memory along it.
            let share = 1.0 + 2.0 * d.overlap(&correlations[axis]);
            Some((share, d.level * d.level / share))
        };
        let known = plateaus.iter().enumerate().filter_map(of_axis);
        let coloured = correlations.iter().any(|c| c.len() > 1);
        let best = known.max_by(|a, b| a.0.total_cmp(&b.0));
        // Outliers of noise have the same share along all axes; a front has not.
        let tails = plateaus.iter().flatten().map(|d| d.tails);
        let tails = tails.fold(f64::INFINITY, f64::min);
        let tails = if tails.is_finite() { tails } else { 1.0 };
        let variance = match best.filter(|_| coloured || tails > 1.0) {
            Some((_, variance)) => tails * variance.max(white),
            None => white,
        };
        Self {
            variance,
            correlations,
        }
    }
}

/// Differences along an axis, of unit noise gain, in the place of their first sample; NaN where they do not fit.
struct Differences {
    values: Vec<f64>,
    order: usize,
    /// Their robust standard deviation.
    level: f64,
    /// Their mean square over the square of that, where it is significantly more than 1.
    tails: f64,
}

impl Differences {
    /// Those of the last of three orders between which the level stays; `None` where it never does. The first of them may
    /// hold a remainder of the field, within the scatter, which would pass for memory.
    fn of_noise(data: &FieldData, field: usize, axis: usize) -> Option<Self> {
        let most = ORDERS.min(data.axes()[axis].points() / 4);
        let all: Vec<Self> = (1..=most)
            .filter_map(|order| Self::new(data, field, axis, order))
            .collect();
        let place = all.windows(3).position(|w| {
            let levels = w.iter().map(|d| d.level);
            let (least, most) =
                levels.fold((f64::INFINITY, 0.0_f64), |(a, b), l| (a.min(l), b.max(l)));
            most <= least * (1.0 + w[0].scatter())
        });
        all.into_iter().nth(place? + 2)
    }

    fn new(data: &FieldData, field: usize, axis: usize, order: usize) -> Option<Self> {
        let (values, points) = (data.values(field), data.axes()[axis].points());
        let inner = stride(data, axis);
        let weights = contrast(order);
        let at = |i: usize| {
            if i / inner % points + order >= points {
                return f64::NAN;
            }
            let all = weights.iter().enumerate();
            all.map(|(k, w)| w * values[i + k * inner]).sum()
        };
        let values: Vec<f64> = (0..values.len()).map(at).collect();
        // Odd strides do not follow the lines of grids of even sizes.
        let every = (values.len() / SAMPLED) | 1;
        let sampled = values.iter().step_by(every).filter(|v| v.is_finite());
        let mut sizes: Vec<f64> = sampled.map(|v| v.abs()).collect();
        let count = sizes.len() as f64;
        let square = sizes.iter().map(|v| v * v).sum::<f64>() / count;
        // 0.6745 is the median of |N(0, 1)|.
        let level = upper_median(&mut sizes)? / 0.674_489_750_196_081_7;
        let mut out = Self {
            values,
            order,
            level,
            tails: 1.0,
        };
        let tails = square / (level * level);
        if tails > (1.0 + out.scatter()).powi(2) {
            out.tails = tails;
        }
        (level > 0.0).then_some(out)
    }

    /// Differences of noise that are independent, about.
    fn independent(&self) -> f64 {
        let all = self.values.iter().filter(|v| v.is_finite()).count();
        let alike: f64 = (1..=self.order).map(|k| own(self.order, k).powi(2)).sum();
        all.min(SAMPLED) as f64 / (1.0 + 2.0 * alike)
    }

    /// Levels closer than this are alike: a median scatters by 1.17 of the level over √n, and this is four times that.
    fn scatter(&self) -> f64 {
        4.7 / self.independent().max(1.0).sqrt()
    }

    /// The correlation of samples 0, 1, 2, ... apart along another axis, as far as it is significant.
    fn correlation(&self, data: &FieldData, axis: usize) -> Vec<f64> {
        let (inner, points) = (stride(data, axis), data.axes()[axis].points());
        // Signs of independent samples: each product is 1 or -1.
        let least = SURE * FRAC_PI_2 / self.independent().max(1.0).sqrt();
        let mut out = vec![1.0];
        for lag in 1..points / 2 {
            let (mut sum, mut count) = (0.0, 0_usize);
            for i in (0..self.values.len()).filter(|i| i / inner % points + lag < points) {
                let product = self.values[i] * self.values[i + lag * inner];
                if product.is_finite() {
                    sum += product.signum();
                    count += 1;
                }
            }
            let found = (FRAC_PI_2 * sum / count.max(1) as f64).sin();
            if found < least {
                break;
            }
            out.push(found);
        }
        out
    }

    /// `Σ_k>0` of the correlation of the weights with themselves times that of noise along the same axis.
    fn overlap(&self, correlation: &[f64]) -> f64 {
        let lags = correlation.iter().enumerate().skip(1).take(self.order);
        lags.map(|(k, c)| c * own(self.order, k)).sum()
    }
}

/// Samples between neighbours along an axis.
fn stride(data: &FieldData, axis: usize) -> usize {
    data.axes()[axis + 1..].iter().map(Axis::points).product()
}

/// Weights of a difference, of which the squares sum to 1.
fn contrast(order: usize) -> Vec<f64> {
    let mut weights = vec![1.0];
    for k in 0..order {
        weights.push(-weights[k] * (order - k) as f64 / (k + 1) as f64);
    }
    let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.iter().map(|w| w / size).collect()
}

/// The correlation of differences of white noise `lag` apart along their axis: `(-1)^k C(2 p, p + k)/C(2 p, p)`.
fn own(order: usize, lag: usize) -> f64 {
    (0..lag)
        .map(|k| -((order - k) as f64) / (order + k + 1) as f64)
        .product()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal, StudentT};

    use super::*;

    /// A travelling wave over 150 times and 120 places, with noise by place of the last axis.
    fn wave(mut noise: impl FnMut(usize) -> f64) -> FieldData {
        let axes = [Axis::even("t", 0.05, 150), Axis::even("x", 0.1, 120)];
        let value = |i: usize| {
            let (t, x) = (0.05 * (i / 120) as f64, 0.1 * (i % 120) as f64);
            (x - t).sin() + noise(i % 120)
        };
        let values = (0..150 * 120).map(value).collect();
        FieldData::new(
            axes.map(Result::unwrap).to_vec(),
            vec![("u".to_owned(), values)],
        )
        .unwrap()
    }

    #[test]
    fn analytic_memory_in_time_and_its_variance_are_found() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut last: Vec<f64> = (0..120).map(|_| normal()).collect();
        let data = wave(|x| {
            last[x] = 0.8 * last[x] + 0.6 * normal();
            0.02 * last[x]
        });
        let found = NoiseColour::new(&data, 0, 1e-4);
        // 2000 independent samples: 0.03 of the variance, 0.02 of a correlation.
        assert!(
            (found.variance / 4e-4 - 1.0).abs() < 0.12,
            "{}",
            found.variance
        );
        for (lag, c) in found.correlations[0].iter().enumerate().take(6) {
            assert!((c - 0.8_f64.powi(lag as i32)).abs() < 0.08, "{lag}: {c}");
        }
        assert!(found.correlations[0].len() > 6 && found.correlations[1].len() < 3);
    }

    #[test]
    fn analytic_white_noise_stays_and_tails_count() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(2);
        let data = wave(|_| {
            let z: f64 = StandardNormal.sample(&mut rng);
            0.02 * z
        });
        let found = NoiseColour::new(&data, 0, 4e-4);
        let short = found.correlations.iter().all(|c| c.len() < 3);
        assert!(short && (found.variance / 4e-4 - 1.0).abs() < 0.1);
        // Student's t with five degrees of freedom has the variance 5/3; the median of its size tells 1.16.
        let tails = StudentT::new(5.0).unwrap();
        let data = wave(|_| 0.02 * tails.sample(&mut rng));
        let median = 1.16 * 4e-4;
        let found = NoiseColour::new(&data, 0, median).variance / 4e-4;
        assert!((found - 5.0 / 3.0).abs() < 0.25, "{found}");
    }
}
