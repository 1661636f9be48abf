//! The course of a flight with known truth: levels between high and low, tones of height, dither of the throttle.

use rand_pcg::Pcg64;

use super::uniform;

/// Heights over time.
pub(super) struct Course {
    knots: Vec<[f64; 2]>,
    tones: Vec<[f64; 3]>,
    dither: Vec<[f64; 3]>,
    radius_m: f64,
}

impl Course {
    pub(super) fn draw(random: &mut Pcg64, radius_m: f64) -> Self {
        let mut knots = vec![[0.0, 6.0], [4.0, 6.0]];
        let mut t = 4.0;
        for level in [
            2.5, 1.5, 0.9, 0.6, 1.2, 0.7, 3.0, 0.6, 6.0, 6.0, 1.0, 0.6, 5.0,
        ] {
            let level = level * uniform(random, 0.85, 1.15);
            let before: f64 = knots[knots.len() - 1][1];
            t += uniform(random, 0.5, 1.5) + 0.3 * (level - before).abs();
            knots.push([t, level]);
            t += uniform(random, 1.5, 2.5);
            knots.push([t, level]);
        }
        let mut tone = |amplitude: f64, rates: [f64; 2]| {
            [
                amplitude,
                uniform(random, rates[0], rates[1]),
                uniform(random, 0.0, std::f64::consts::TAU),
            ]
        };
        Self {
            tones: (0..3).map(|_| tone(0.08, [2.0, 7.0])).collect(),
            dither: (0..4).map(|_| tone(0.008, [15.0, 40.0])).collect(),
            knots,
            radius_m,
        }
    }

    pub(super) fn end_s(&self) -> f64 {
        self.knots[self.knots.len() - 1][0] + 2.0
    }

    /// Height (m), climb rate (m/s), dither of the throttle.
    pub(super) fn at(&self, t: f64) -> [f64; 3] {
        let k = self
            .knots
            .partition_point(|k| k[0] <= t)
            .clamp(1, self.knots.len() - 1);
        let ([ta, a], [tb, b]) = (self.knots[k - 1], self.knots[k]);
        let share = ((t - ta) / (tb - ta).max(1e-9)).clamp(0.0, 1.0);
        let slope = if (0.0..1.0).contains(&share) {
            (b - a) / (tb - ta).max(1e-9)
        } else {
            0.0
        };
        let level = a + share * (b - a);
        let sum = |all: &[[f64; 3]]| {
            all.iter()
                .map(|[a, w, p]| a * (w * t + p).sin())
                .sum::<f64>()
        };
        let rate: f64 = self
            .tones
            .iter()
            .map(|[a, w, p]| a * w * (w * t + p).cos())
            .sum();
        [
            (level + sum(&self.tones)).max(0.55) * self.radius_m,
            (slope + rate) * self.radius_m,
            sum(&self.dither),
        ]
    }
}
