//! Whether innovations are white, as those of a true model are.

use super::kalman::{Innovation, Pass, Sensor};

/// Delays at which innovations are compared, in samples of their sensor.
const DELAYS: usize = 10;

/// Root of the sum of squared autocorrelations of the innovations at the delays of one to ten samples, of each sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whiteness {
    pub(crate) range: f64,
    pub(crate) climb_rate: f64,
    pub(crate) accelerometer: f64,
}

/// Greatest colour of innovations that count as white: a vehicle whose sensors have white noise has 0.02, heights that an
/// estimator has smoothed 2.2. Half and twice decide those alike.
const WHITE: f64 = 0.25;

impl Whiteness {
    /// Whether all sensors' innovations are nearly white.
    pub(super) fn is_white(self) -> bool {
        self.greatest() < WHITE
    }

    /// Whether a few rounds more may make them white.
    pub(super) fn may_become_white(self) -> bool {
        self.greatest() < 4.0 * WHITE
    }

    fn greatest(self) -> f64 {
        self.range.max(self.climb_rate).max(self.accelerometer)
    }

    pub(super) fn of(passes: &[Pass]) -> Self {
        let of = |sensor| colour(passes, sensor);
        Self {
            range: of(Sensor::Range),
            climb_rate: of(Sensor::ClimbRate),
            accelerometer: of(Sensor::Accelerometer),
        }
    }
}

fn colour(passes: &[Pass], sensor: Sensor) -> f64 {
    let mut products = [0.0; DELAYS + 1];
    for pass in passes {
        let ours = |i: &&Innovation| i.sensor == sensor;
        let values: Vec<f64> = pass
            .innovations
            .iter()
            .filter(ours)
            .map(|i| i.value)
            .collect();
        for (delay, sum) in products.iter_mut().enumerate() {
            *sum += values
                .iter()
                .zip(values.iter().skip(delay))
                .map(|(a, b)| a * b)
                .sum::<f64>();
        }
    }
    if !(products[0] > 0.0) {
        return 0.0;
    }
    products[1..]
        .iter()
        .map(|p| (p / products[0]).powi(2))
        .sum::<f64>()
        .sqrt()
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution as _, StandardNormal};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::SeedableRng as _;

    use super::*;
    use crate::flights::fit::SegmentOffsets;

    /// Innovations of a range, each `keep` times the one before and new noise.
    fn run(keep: f64) -> Vec<Pass> {
        let mut random = Pcg64::seed_from_u64(1);
        let mut value = 0.0;
        let innovations = (0..4000).map(|i| {
            let new: f64 = StandardNormal.sample(&mut random);
            value = keep * value + new;
            Innovation {
                sensor: Sensor::Range,
                time_s: 0.01 * f64::from(i),
                value,
                cost: 0.0,
            }
        });
        vec![Pass {
            innovations: innovations.collect(),
            cost: 0.0,
            local: SegmentOffsets {
                scale: 1.0,
                bias: 0.0,
            },
            range_latency_s: None,
        }]
    }

    #[test]
    fn analytic_colour_of_white_and_of_filtered_noise() {
        let white = Whiteness::of(&run(0.0));
        // Ten autocorrelations of 4000 samples: root of 10/4000 = 0.05, known to a fifth.
        assert!((0.02..0.08).contains(&white.range), "{white:?}");
        assert!(white.is_white());
        assert_eq!([white.climb_rate, white.accelerometer], [0.0; 2]);
        let coloured = Whiteness::of(&run(0.8));
        // Σ 0.8^2k over k from 1 to 10 is 1.757; its root is known to a tenth.
        assert!((coloured.range - 1.326).abs() < 0.13, "{coloured:?}");
        assert!(!coloured.is_white());
    }
}
