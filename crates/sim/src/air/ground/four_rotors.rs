//! The wake law for four rotors together, with few divisions.

use super::{IMAGE_LIMIT, Surface, TOTAL_LIMIT, WakeLag};
use crate::number::{Number, inverses};

/// Steady inflow of the four rotors, without the factor of the plate, and the rates of its
/// lags.
pub(crate) struct RotorInflow<N> {
    pub(crate) target: [N; 4],
    pub(crate) pace: [N; 4],
}

impl WakeLag {
    /// `Σ h_ij/(s_ij² + h_ij²)^1.5 v_j` over the images of the other rotors.
    #[inline(always)]
    fn neighbours<N: Number>(places_m: &[[N; 3]; 4], speeds: &[N; 4]) -> [N; 4] {
        let zero = speeds[0].splat(0.0);
        let (mut height, mut cube) = ([[zero; 4]; 4], [[zero; 4]; 4]);
        for i in 0..4 {
            for j in 0..i {
                let ([xi, yi, zi], [xj, yj, zj]) = (places_m[i], places_m[j]);
                let (dx, dy, h) = (xi - xj, yi - yj, zi + zj);
                let r2 = dx * dx + dy * dy + h * h;
                (height[i][j], cube[i][j]) = (h, r2 * r2.sqrt());
            }
        }
        let [a, b, c] = inverses([cube[1][0], cube[2][0], cube[3][0]]);
        let [d, e, f] = inverses([cube[2][1], cube[3][1], cube[3][2]]);
        let mut sums = [zero; 4];
        for (i, j, inverse) in [
            (1, 0, a),
            (2, 0, b),
            (3, 0, c),
            (2, 1, d),
            (3, 1, e),
            (3, 2, f),
        ] {
            let kernel = height[i][j] * inverse;
            sums[i] = sums[i] + kernel * speeds[j];
            sums[j] = sums[j] + kernel * speeds[i];
        }
        sums
    }

    /// `(a² + z²)^1.5` of a plate, from which E(z) follows; 1 for other surfaces.
    #[inline(always)]
    fn plate_cube<N: Number>(&self, z: N) -> N {
        match self.deck.surface {
            Surface::Plate => {
                let r2 = z * z + self.deck.radius_m * self.deck.radius_m;
                r2 * r2.sqrt()
            }
            Surface::Ground | Surface::Absent => z.splat(1.0),
        }
    }

    /// E(z) with the inverse of [`Self::plate_cube`].
    #[inline(always)]
    fn plate<N: Number>(&self, z: N, inverse_cube: N) -> N {
        match self.deck.surface {
            Surface::Plate => 1.0 - z * z * z * inverse_cube,
            Surface::Ground => z.splat(1.0),
            Surface::Absent => z.splat(0.0),
        }
    }

    /// Steady inflow of four rotors whose heights are at least the least height of the laws.
    #[inline(always)]
    pub(crate) fn rotors_at<N: Number>(
        &self,
        scale: N,
        places_m: &[[N; 3]; 4],
        speeds: &[N; 4],
    ) -> RotorInflow<N> {
        let mut target = Self::neighbours(places_m, speeds);
        let mut pace = target;
        let quarter = 0.25 * self.radius_m * self.radius_m;
        for i in 0..4 {
            let z = places_m[i][2];
            let cube = self.plate_cube(z);
            let [own, part, cube, lag] =
                inverses([z * z * 4.0, speeds[i], cube, z + self.lag_m[0]]);
            let sum = (own + target[i] * part) * quarter;
            target[i] = scale * self.plate(z, cube) * sum.at_most(IMAGE_LIMIT);
            pace[i] = lag * self.lag_pace[0];
        }
        RotorInflow { target, pace }
    }

    /// Steady fountain at the mean height of the rotors, without the factor of the plate, and
    /// the rate of its lag.
    #[inline(always)]
    pub(crate) fn fountain_at<N: Number>(&self, scale: N, mean_height_m: N) -> (N, N) {
        let z = mean_height_m.at_least(self.deck.least_m);
        let r2 = z * z * 4.0 + self.diagonal2_m2;
        let [cube, far, lag] = inverses([self.plate_cube(z), r2 * r2.sqrt(), z + self.lag_m[1]]);
        let gain = 2.0 * self.radius_m * self.radius_m * self.fountain_gain;
        (
            scale * self.plate(z, cube) * (z * gain * far),
            lag * self.lag_pace[1],
        )
    }

    /// [`Self::lift_ratio`] of several rotors over one fountain.
    #[inline(always)]
    pub(crate) fn lift_ratios<N: Number, const K: usize>(inflow: &[N; K], fountain: N) -> [N; K] {
        let (mut q, mut rest) = (*inflow, *inflow);
        for i in 0..K {
            q[i] = (inflow[i] + fountain).at_most(TOTAL_LIMIT);
            rest[i] = 1.0 - q[i];
        }
        let inverse = inverses(rest);
        for i in 0..K {
            q[i] = q[i] * inverse[i];
        }
        q
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::plant::PlantSettings;

    #[test]
    fn analytic_four_rotors_at_once_are_the_law_of_one() {
        for surface in [Surface::Plate, Surface::Ground, Surface::Absent] {
            let settings = PlantSettings {
                surface,
                fountain_gain: 1.3,
                ..PlantSettings::default()
            };
            let law = WakeLag::new(&settings.wake()).expect("valid settings");
            let half = 0.5 * settings.rotor_spacing_m;
            let corners = [[half, half], [-half, half], [-half, -half], [half, -half]];
            let scale = 1.2;
            let one = law.with_scale(scale);
            // At first a rotor hardly turns at the least height: its images are beyond their limit.
            for (heights_m, speeds) in [
                ([0.05; 4], [0.3, 3.5, 4.0, 3.2]),
                ([0.2; 4], [3.0, 3.5, 4.0, 3.2]),
                ([0.12, 0.15, 0.18, 0.15], [3.0; 4]),
                ([1.5; 4], [3.0, 3.5, 4.0, 3.2]),
            ] {
                let places = std::array::from_fn(|i| [corners[i][0], corners[i][1], heights_m[i]]);
                let four = law.rotors_at(scale, &places, &speeds);
                // Shares are at most 1.2; a dozen roundings of 1.1e-16 of 1, for E(z) is taken from it.
                let near = |a: f64, b: f64| (a - b).abs() < 2e-15;
                // Paces are some tens, with as many roundings.
                let close = |a: f64, b: f64| (a / b - 1.0).abs() < 2e-15;
                for i in 0..4 {
                    let sum = law.image_sum(i, &heights_m, &speeds);
                    let target = one.rotor_target(heights_m[i], sum);
                    let found = four.target[i];
                    assert!(near(found, target), "{surface:?} {i}: {found} {target}");
                    assert!(close(four.pace[i], law.rotor_pace(heights_m[i])), "{i}");
                }
                // Below the least height as well.
                for mean_m in [0.02, heights_m.iter().sum::<f64>() / 4.0] {
                    let (target, pace) = law.fountain_at(scale, mean_m);
                    let expected = one.fountain_target(mean_m.max(law.deck.least_m));
                    assert!(near(target, expected), "{surface:?}: {target} {expected}");
                    assert!(close(pace, law.fountain_pace(mean_m)), "{mean_m}");
                }
            }
        }
    }
}
