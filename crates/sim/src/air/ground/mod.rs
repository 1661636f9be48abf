//! Ground effect of one rotor among four above a finite, moving deck.
//!
//! The law is written once, for one rotor. Every rotor and its image below the
//! deck is a source (Cheeseman & Bennett 1955 for a rotor's own image;
//! Sanchez-Cuevas, Heredia & Ollero 2017 for the images of its neighbours and
//! the fountain between four rotors). A level vehicle over the centre of the
//! deck is the case in which the four rotors are equal, [`WakeLag::level_target`].
//!
//! * Image sources, rotor i at height z_i, horizontal distance s_ij,
//!   h_ij = z_i + z_j and induced speeds v_i:
//!   `q_ij = (R²/4) h_ij / (s_ij² + h_ij²)^1.5 · v_j/v_i`.
//! * Finite plate of equal area to a disc of radius a (solid-angle share):
//!   `E = 1 - (1 + (a/z)²)^-1.5`.
//! * Upwash of a disc that moves broadside, on its axis (exact potential flow):
//!   `P = (2/π) (atan(a/z) - (z/a)/(1 + (z/a)²))`.
//! * Fountain: `q_ftn = 2 R² K_b z / (b² + 4 z²)^1.5`.
//! * Lags: the rotor's own images settle fast, the fountain slowly; both with
//!   the height and with the induced speed (√T).
//!
//! Heights are those of the rotor plane, and at least 0.05 m. This least height, the lengths
//! in the lags and the least √T of the lags belong to rotors of 0.12 m and a vehicle of
//! 1.37 kg. They scale with the vehicle; the least values never increase.

mod four_rotors;
mod surface;

use crate::check;
use crate::error::SimError;
use crate::number::Number;

pub use surface::{DeckSurface, Surface};

/// Rotor radius of the paper's quadrotor, to which the lengths below belong, m.
const STANDARD_RADIUS_M: f64 = 0.12;
/// Least height of the rotor plane in the laws, m: that of the default vehicle whose
/// reference point is on the deck. Landed vehicles are higher by their legs of 0.1 m, so
/// the value matters only in the vertical plant.
const LEAST_ROTOR_HEIGHT_M: f64 = 0.05;
/// Lengths l, L of the lag `τ (z + l)/L` of the rotor's own images, m. The lag grows with
/// the wake's length z; l is about the distance over which the wake turns. L makes τ the
/// lag at z = 0.2 m, as it does for the fountain. An assumption.
const ROTOR_LAG_M: [f64; 2] = [0.2, 0.4];
/// Lengths l, L of the lag of the fountain, m. l is the longer way from four rotors to the
/// middle and up, so this lag depends less on the height. An assumption.
const FOUNTAIN_LAG_M: [f64; 2] = [0.6, 0.8];
/// Least √T in the lags, √N. It keeps the lags finite while the rotors stand still, and
/// matters only below 7 % of the hover thrust.
const LEAST_LAG_ROOT: f64 = 1.0;
/// Largest ratio of that least value to √T in hover: exactly 1 √N for 1.37 kg, less for
/// lighter vehicles.
const LEAST_LAG_SHARE: f64 = 0.2728;
/// Largest reduction of the induced speed by the image sources, because Cheeseman and
/// Bennett's formula diverges at the ground. The default vehicle reaches 0.38 at the least
/// height, so the limit acts only for rotors closer to the ground or to each other.
const IMAGE_LIMIT: f64 = 0.5;
/// Largest reduction by image sources and fountain together: the thrust in ground effect is
/// at most 2.5 times that in free air. The default vehicle reaches 0.41 at the least height.
const TOTAL_LIMIT: f64 = 0.6;

/// Settings of the wake law: rotors, surface, weight, gains and lags of the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WakeSettings {
    /// The surface below.
    pub surface: Surface,
    /// Side of the square plate, m.
    pub plate_side_m: f64,
    /// Rotor radius R, m.
    pub rotor_radius_m: f64,
    /// Distance of neighbouring rotor axes d, m.
    pub rotor_spacing_m: f64,
    /// Weight of the vehicle W, N.
    pub weight_n: f64,
    /// Scale of the ground effect γ.
    pub scale: f64,
    /// Gain of the fountain K_b.
    pub fountain_gain: f64,
    /// Time constant of a rotor's own inflow at hover and z_r = 5/3 R, s.
    pub rotor_lag_s: f64,
    /// Time constant of the fountain at hover and z_r = 5/3 R, s.
    pub fountain_lag_s: f64,
}

/// Ground effect with image sources, fountain, finite plate and two lags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WakeLag {
    radius_m: f64,
    /// Squares of the horizontal distances between rotors i and j.
    distance2_m2: [[f64; 4]; 4],
    /// Square of the distance b of opposite rotor axes.
    diagonal2_m2: f64,
    fountain_gain: f64,
    scale: f64,
    /// Of the lags: l of both, 1/τ of both in units of L/√W, least √T.
    lag_m: [f64; 2],
    lag_pace: [f64; 2],
    least_root: f64,
    deck: DeckSurface,
}

impl WakeLag {
    /// Builds the law for a square of four rotors.
    ///
    /// # Errors
    /// Lengths and lags must be positive, gain and scale not negative.
    pub fn new(settings: &WakeSettings) -> Result<Self, SimError> {
        check::positive("rotor_radius_m", settings.rotor_radius_m)?;
        check::positive("rotor_spacing_m", settings.rotor_spacing_m)?;
        check::that(
            settings.rotor_spacing_m >= 2.0 * settings.rotor_radius_m,
            "rotor_spacing_m",
            "at least two rotor radii",
            settings.rotor_spacing_m,
        )?;
        check::not_negative("fountain_gain", settings.fountain_gain)?;
        check::not_negative("ground_effect_scale", settings.scale)?;
        check::positive("rotor_lag_s", settings.rotor_lag_s)?;
        check::positive("fountain_lag_s", settings.fountain_lag_s)?;
        let half = 0.5 * settings.rotor_spacing_m;
        let places = [[half, half], [-half, half], [-half, -half], [half, -half]];
        let size = settings.rotor_radius_m / STANDARD_RADIUS_M;
        let hover_root = settings.weight_n.sqrt();
        let [(rotor_m, rotor_pace), (fountain_m, fountain_pace)] = [
            (ROTOR_LAG_M, settings.rotor_lag_s),
            (FOUNTAIN_LAG_M, settings.fountain_lag_s),
        ]
        .map(|([l, long], lag_s)| (l * size, long * size / (lag_s * hover_root)));
        let distance2 = |i: usize, j: usize| {
            let (dx, dy): (f64, f64) = (places[i][0] - places[j][0], places[i][1] - places[j][1]);
            dx * dx + dy * dy
        };
        Ok(Self {
            radius_m: settings.rotor_radius_m,
            distance2_m2: std::array::from_fn(|i| std::array::from_fn(|j| distance2(i, j))),
            diagonal2_m2: distance2(0, 2),
            fountain_gain: settings.fountain_gain,
            scale: settings.scale,
            lag_m: [rotor_m, fountain_m],
            lag_pace: [rotor_pace, fountain_pace],
            least_root: LEAST_LAG_ROOT.min(LEAST_LAG_SHARE * hover_root),
            deck: DeckSurface::new(settings)?,
        })
    }

    /// Sum over all images j of q_ij, the share of rotor i's induced speed that
    /// the images take away, for a vehicle parallel to the deck. `heights_m` are
    /// rotor-plane heights, `speeds` the induced speeds in any common unit (for
    /// example √T_i).
    #[inline]
    #[must_use]
    pub fn image_sum(&self, rotor: usize, heights_m: &[f64; 4], speeds: &[f64; 4]) -> f64 {
        let mut sum = 0.0;
        for other in 0..4 {
            let h = heights_m[rotor] + heights_m[other];
            let kernel = image_kernel(self.distance2_m2[rotor][other], h);
            sum += kernel * (speeds[other] / speeds[rotor]);
        }
        0.25 * self.radius_m * self.radius_m * sum
    }

    /// γ, the scale of the ground effect.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The same law with another γ.
    #[must_use]
    pub(crate) fn with_scale(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// Static target of a rotor's own inflow, `γ E(z_i) min(Σ q_ij, 0.5)`.
    #[inline]
    #[must_use]
    pub fn rotor_target(&self, height_m: f64, image_sum: f64) -> f64 {
        self.scale * self.deck.finite_plate(height_m) * image_sum.min(IMAGE_LIMIT)
    }

    /// Share of the fountain, q_ftn, before plate and scale.
    #[inline(always)]
    #[must_use]
    pub fn fountain_share<N: Number>(&self, mean_height_m: N) -> N {
        let z = mean_height_m;
        let r2 = z * z * 4.0 + self.diagonal2_m2;
        let gain = 2.0 * self.radius_m * self.radius_m * self.fountain_gain;
        gain * z / (r2 * r2.sqrt())
    }

    /// Static target of the fountain, `γ E(z_c) q_ftn(z_c)`, the same for all
    /// rotors; z_c is the mean of the four rotor heights.
    #[inline]
    #[must_use]
    pub fn fountain_target(&self, mean_height_m: f64) -> f64 {
        self.scale * self.deck.finite_plate(mean_height_m) * self.fountain_share(mean_height_m)
    }

    /// Targets (rotor, fountain) of a level vehicle over the deck's centre.
    #[inline]
    #[must_use]
    pub fn level_target(&self, rotor_height_m: f64) -> [f64; 2] {
        let z = rotor_height_m.max(self.deck.least_m);
        let images = self.image_sum(0, &[z; 4], &[1.0; 4]);
        [self.rotor_target(z, images), self.fountain_target(z)]
    }

    /// 1/t1 at a height for √T = 1.
    #[inline(always)]
    pub(crate) fn rotor_pace<N: Number>(&self, rotor_height_m: N) -> N {
        let z = rotor_height_m.at_least(self.deck.least_m);
        self.lag_pace[0] / (z + self.lag_m[0])
    }

    /// 1/t2 at a height for √T = 1.
    #[inline(always)]
    pub(crate) fn fountain_pace<N: Number>(&self, mean_height_m: N) -> N {
        let z = mean_height_m.at_least(self.deck.least_m);
        self.lag_pace[1] / (z + self.lag_m[1])
    }

    /// Rate of change of a lagged inflow, with `pace` from [`Self::rotor_pace`] or
    /// [`Self::fountain_pace`].
    #[inline(always)]
    pub(crate) fn lag_rate<N: Number>(&self, q: N, target: N, pace: N, root_thrust: N) -> N {
        (target - q) * (root_thrust.at_least(self.least_root) * pace)
    }

    /// G - 1, where `G = 1/(1 - min(q1 + q2, 0.6))` is thrust in ground effect
    /// over thrust in free air.
    #[inline(always)]
    #[must_use]
    pub fn lift_ratio<N: Number>(inflow: [N; 2]) -> N {
        let [ratio] = Self::lift_ratios(&[inflow[0]], inflow[1]);
        ratio
    }
}

/// `h/(s² + h²)^1.5`, the geometry of one image: `distance2_m2` is s².
#[inline(always)]
fn image_kernel<N: Number>(distance2_m2: N, h: N) -> N {
    let r2 = distance2_m2 + h * h;
    h / (r2 * r2.sqrt())
}

/// Force on one rotor beyond its free-air thrust T_i, N, for any lift ratio:
/// `T_i (G_i - 1) - (k_v/4) (x_i/√W) (w_i - P u_i)`.
///
/// `root_thrust` is x_i = √(4 T_i), the rotor's share on the scale of the whole
/// vehicle; `damping_per_root` is k_v/√W; `air_speed_mps` is the rotor's climb
/// speed w_i less the upwash P u_i of the deck below it.
#[inline(always)]
#[must_use]
pub fn rotor_force<N: Number>(
    root_thrust: N,
    lift_ratio: N,
    damping_per_root: f64,
    air_speed_mps: N,
) -> N {
    root_thrust * 0.25 * (root_thrust * lift_ratio - air_speed_mps * damping_per_root)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::plant::PlantSettings;

    #[test]
    fn analytic_laws_scale_with_the_rotor() {
        let standard = PlantSettings {
            surface: Surface::Ground,
            ..PlantSettings::default()
        };
        let law = WakeLag::new(&standard.wake()).expect("defaults are valid");
        for size in [0.19, 0.5, 0.9] {
            let small = WakeLag::new(&WakeSettings {
                rotor_radius_m: size * standard.rotor_radius_m,
                rotor_spacing_m: size * standard.rotor_spacing_m,
                ..standard.wake()
            })
            .expect("valid settings");
            // Below the least height as well.
            for radii in [0.2, 0.4, 0.5, 1.0, 3.0, 9.0] {
                let z = radii * standard.rotor_radius_m;
                let of = |law: &WakeLag, z: f64| {
                    let [images, fountain] = law.level_target(z);
                    let paces = [law.rotor_pace(z), law.fountain_pace(z)];
                    [images, fountain, paces[0], paces[1]]
                };
                for (a, b) in of(&law, z).into_iter().zip(of(&small, size * z)) {
                    // A dozen roundings of 1.1e-16.
                    assert!((a / b - 1.0).abs() < 2e-15, "{size}, {radii} R: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn analytic_least_thrust_of_the_lags_scales_with_the_weight() {
        let standard = PlantSettings::default();
        // The rate of a lag towards 1 at the pace 1, without thrust.
        let least = |mass_kg: f64| {
            let settings = PlantSettings {
                mass_kg,
                ..standard
            };
            let law = WakeLag::new(&settings.wake()).expect("valid settings");
            (law.lag_rate(0.0, 1.0, 1.0, 0.0), settings.weight_n().sqrt())
        };
        // The standard vehicle's is what it was before it had a share.
        assert_eq!(least(1.37).0, 1.0);
        let share = least(0.5 * 1.37).0 / least(0.5 * 1.37).1;
        // Rounded up in its fourth digit, for the standard vehicle's is not to be less than 1.
        assert!((share * least(1.37).1 - 1.0).abs() < 1e-4, "{share}");
        for size in [0.02, 0.1, 0.5, 0.9] {
            let (root, hover) = least(size * 1.37);
            // Two roundings of 1.1e-16.
            assert!((root / hover / share - 1.0).abs() < 1e-15, "{size}");
        }
        // Never larger.
        assert_eq!(least(10.0 * 1.37).0, 1.0);
    }
}
