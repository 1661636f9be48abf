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
//! Heights here are those of the rotor plane and are held at 0.05 m or more.

use crate::check;
use crate::error::SimError;
use crate::plant::{PlantSettings, Surface};

/// Least height of the rotor plane in the laws, m.
pub const LEAST_ROTOR_HEIGHT_M: f64 = 0.05;
/// Greatest share of the image sources.
const IMAGE_LIMIT: f64 = 0.5;
/// Greatest share of image sources and fountain together.
const TOTAL_LIMIT: f64 = 0.6;

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
    rotor_lag_s: f64,
    fountain_lag_s: f64,
    hover_root: f64,
    deck: Deck,
}

impl WakeLag {
    /// Builds the law for a square of four rotors.
    ///
    /// # Errors
    /// Lengths and lags must be positive, gain and scale not negative.
    pub fn new(settings: &PlantSettings) -> Result<Self, SimError> {
        check::positive("rotor_radius_m", settings.rotor_radius_m)?;
        check::positive("rotor_spacing_m", settings.rotor_spacing_m)?;
        check::that(
            settings.rotor_spacing_m >= 2.0 * settings.rotor_radius_m,
            "rotor_spacing_m",
            "at least two rotor radii",
            settings.rotor_spacing_m,
        )?;
        check::not_negative("fountain_gain", settings.fountain_gain)?;
        check::not_negative("ground_effect_scale", settings.ground_effect_scale)?;
        check::positive("rotor_lag_s", settings.rotor_lag_s)?;
        check::positive("fountain_lag_s", settings.fountain_lag_s)?;
        let half = 0.5 * settings.rotor_spacing_m;
        let places = [[half, half], [-half, half], [-half, -half], [half, -half]];
        let distance2 = |i: usize, j: usize| {
            let (dx, dy): (f64, f64) = (places[i][0] - places[j][0], places[i][1] - places[j][1]);
            dx * dx + dy * dy
        };
        Ok(Self {
            radius_m: settings.rotor_radius_m,
            distance2_m2: std::array::from_fn(|i| std::array::from_fn(|j| distance2(i, j))),
            diagonal2_m2: distance2(0, 2),
            fountain_gain: settings.fountain_gain,
            scale: settings.ground_effect_scale,
            rotor_lag_s: settings.rotor_lag_s,
            fountain_lag_s: settings.fountain_lag_s,
            hover_root: settings.weight_n().sqrt(),
            deck: Deck::new(settings)?,
        })
    }

    /// Sum over all images j of q_ij, the share of rotor i's induced speed that
    /// the images take away. `heights_m` are rotor-plane heights, `speeds` the
    /// induced speeds in any common unit (for example √T_i).
    #[inline]
    #[must_use]
    pub fn image_sum(&self, rotor: usize, heights_m: &[f64; 4], speeds: &[f64; 4]) -> f64 {
        let mut sum = 0.0;
        for other in 0..4 {
            let h = heights_m[rotor] + heights_m[other];
            let r2 = self.distance2_m2[rotor][other] + h * h;
            sum += h / (r2 * r2.sqrt()) * (speeds[other] / speeds[rotor]);
        }
        0.25 * self.radius_m * self.radius_m * sum
    }

    /// Static target of a rotor's own inflow, `γ E(z_i) min(Σ q_ij, 0.5)`.
    #[inline]
    #[must_use]
    pub fn rotor_target(&self, height_m: f64, image_sum: f64) -> f64 {
        self.scale * self.deck.finite_plate(height_m) * image_sum.min(IMAGE_LIMIT)
    }

    /// Share of the fountain, q_ftn, before plate and scale.
    #[inline]
    #[must_use]
    pub fn fountain_share(&self, mean_height_m: f64) -> f64 {
        let r2 = self.diagonal2_m2 + 4.0 * mean_height_m * mean_height_m;
        2.0 * self.radius_m * self.radius_m * self.fountain_gain * mean_height_m / (r2 * r2.sqrt())
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
        let z = rotor_height_m.max(LEAST_ROTOR_HEIGHT_M);
        let images = self.image_sum(0, &[z; 4], &[1.0; 4]);
        [self.rotor_target(z, images), self.fountain_target(z)]
    }

    /// Rates of the two lags; `root_thrust` is √T on the scale of the whole
    /// vehicle (for one rotor √(4 T_i)).
    #[inline]
    #[must_use]
    pub fn derivative(
        &self,
        inflow: [f64; 2],
        target: [f64; 2],
        rotor_height_m: f64,
        root_thrust: f64,
    ) -> [f64; 2] {
        let z = rotor_height_m.max(LEAST_ROTOR_HEIGHT_M);
        let pace = root_thrust.max(1.0) / self.hover_root;
        [
            (target[0] - inflow[0]) * pace / (self.rotor_lag_s * (z + 0.2) / 0.4),
            (target[1] - inflow[1]) * pace / (self.fountain_lag_s * (z + 0.6) / 0.8),
        ]
    }

    /// G - 1, where `G = 1/(1 - min(q1 + q2, 0.6))` is thrust in ground effect
    /// over thrust in free air.
    #[inline]
    #[must_use]
    pub fn lift_ratio(inflow: [f64; 2]) -> f64 {
        let q = (inflow[0] + inflow[1]).min(TOTAL_LIMIT);
        q / (1.0 - q)
    }
}

/// Force on one rotor beyond its free-air thrust T_i, N, for any lift ratio:
/// `T_i (G_i - 1) - (k_v/4) (x_i/√W) (w_i - P u_i)`.
///
/// `root_thrust` is x_i = √(4 T_i), the rotor's share on the scale of the whole
/// vehicle; `damping_per_root` is k_v/√W; `air_speed_mps` is the rotor's climb
/// speed w_i less the upwash P u_i of the deck below it.
#[inline]
#[must_use]
pub fn rotor_force(
    root_thrust: f64,
    lift_ratio: f64,
    damping_per_root: f64,
    air_speed_mps: f64,
) -> f64 {
    0.25 * root_thrust * (root_thrust * lift_ratio - damping_per_root * air_speed_mps)
}

/// The surface below: how much of an unbounded plane it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deck {
    surface: Surface,
    radius_m: f64,
}

impl Deck {
    /// The deck of the settings; a square plate counts as the disc of its area.
    ///
    /// # Errors
    /// The plate's side must be positive.
    pub fn new(settings: &PlantSettings) -> Result<Self, SimError> {
        check::positive("plate_side_m", settings.plate_side_m)?;
        Ok(Self {
            surface: settings.surface,
            radius_m: settings.plate_side_m / std::f64::consts::PI.sqrt(),
        })
    }

    /// E(z): 1 above unbounded ground, 0 where there is no surface.
    #[inline]
    #[must_use]
    pub fn finite_plate(&self, rotor_height_m: f64) -> f64 {
        match self.surface {
            Surface::Plate => {
                let k = self.radius_m / rotor_height_m;
                let s = 1.0 + k * k;
                1.0 - 1.0 / (s * s.sqrt())
            }
            Surface::Ground => 1.0,
            Surface::Absent => 0.0,
        }
    }

    /// P(z): the share of the deck's velocity that the air at rotor height has.
    #[inline]
    #[must_use]
    pub fn upwash(&self, rotor_height_m: f64) -> f64 {
        match self.surface {
            Surface::Plate => {
                let k = rotor_height_m.max(LEAST_ROTOR_HEIGHT_M) / self.radius_m;
                std::f64::consts::FRAC_2_PI * ((1.0 / k).atan() - k / (1.0 + k * k))
            }
            Surface::Ground => 1.0,
            Surface::Absent => 0.0,
        }
    }
}
