//! The surface below the rotors: finite-plate factor, upwash, solid angle.

use serde::{Deserialize, Serialize};

use super::{LEAST_ROTOR_HEIGHT_M, STANDARD_RADIUS_M, WakeSettings};
use crate::check;
use crate::error::SimError;
use crate::number::{Number, angles};

/// The surface below the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// A finite square plate.
    #[default]
    Plate,
    /// Unbounded ground: E = 1 and P = 1.
    Ground,
    /// No surface: free air.
    Absent,
}

/// Geometry of the surface below the rotors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckSurface {
    pub(super) surface: Surface,
    pub(super) radius_m: f64,
    half_side_m: f64,
    pub(super) least_m: f64,
}

impl DeckSurface {
    /// The deck of the settings. A disc of the same area replaces a square plate.
    ///
    /// # Errors
    /// The plate's side must be positive.
    pub fn new(settings: &WakeSettings) -> Result<Self, SimError> {
        check::positive("plate_side_m", settings.plate_side_m)?;
        Ok(Self {
            surface: settings.surface,
            radius_m: settings.plate_side_m / std::f64::consts::PI.sqrt(),
            half_side_m: 0.5 * settings.plate_side_m,
            least_m: LEAST_ROTOR_HEIGHT_M * (settings.rotor_radius_m / STANDARD_RADIUS_M).min(1.0),
        })
    }

    /// Least height of the rotor plane in the laws, m.
    #[inline(always)]
    #[must_use]
    pub fn least_rotor_height_m(&self) -> f64 {
        self.least_m
    }

    /// E(z): 1 above unbounded ground, 0 without a surface.
    #[inline(always)]
    #[must_use]
    pub fn finite_plate<N: Number>(&self, rotor_height_m: N) -> N {
        let z = rotor_height_m;
        match self.surface {
            Surface::Plate => {
                let k = self.radius_m / z;
                let s = 1.0 + k * k;
                1.0 - 1.0 / (s * s.sqrt())
            }
            Surface::Ground => z.splat(1.0),
            Surface::Absent => z.splat(0.0),
        }
    }

    /// P(z): velocity of the air at rotor height over that of the deck.
    #[inline]
    #[must_use]
    pub fn upwash(&self, rotor_height_m: f64) -> f64 {
        match self.surface {
            Surface::Plate => {
                let k = rotor_height_m.max(self.least_m) / self.radius_m;
                std::f64::consts::FRAC_2_PI * ((1.0 / k).atan() - k / (1.0 + k * k))
            }
            Surface::Ground => 1.0,
            Surface::Absent => 0.0,
        }
    }

    /// Half the side of a plate, m; none for a surface without edge.
    #[must_use]
    pub fn half_side_m(&self) -> Option<f64> {
        (self.surface == Surface::Plate).then_some(self.half_side_m)
    }

    /// Solid angle of the square plate of half side l seen from (x, y, z), z
    /// above 0: the sum of `atan(XY/(z √(X² + Y² + z²)))` over X in {l - x, l + x}
    /// and Y in {l - y, l + y}. The four angles are added as the argument of a
    /// product of complex numbers.
    #[inline(always)]
    #[must_use]
    pub fn solid_angle<N: Number>(&self, place_m: [N; 3]) -> N {
        let [angle] = self.solid_angles(&[place_m]);
        angle
    }

    /// [`Self::solid_angle`] of several places.
    #[inline(always)]
    #[must_use]
    pub fn solid_angles<N: Number, const K: usize>(&self, places_m: &[[N; 3]; K]) -> [N; K] {
        let l = self.half_side_m;
        let (mut re, mut im) = (
            places_m.map(|p| p[2].splat(1.0)),
            places_m.map(|p| p[2].splat(0.0)),
        );
        for (a_sign, b_sign) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            for i in 0..K {
                let [x, y, z] = places_m[i];
                let (a, b) = (x * a_sign + l, y * b_sign + l);
                let (c, d) = (z * (a * a + b * b + z * z).sqrt(), a * b);
                (re[i], im[i]) = (re[i] * c - im[i] * d, re[i] * d + im[i] * c);
            }
        }
        let mut angles = angles(re, im);
        for i in 0..K {
            let ([x, y, _], angle) = (places_m[i], angles[i]);
            let beside = x.abs().above(l) | y.abs().above(l);
            // Beside the plate the angle is near 0. Rounding may make it slightly negative,
            // which must not become a full circle.
            let raised = N::select(angle.below(0.0), angle + std::f64::consts::TAU, angle);
            angles[i] = N::select(beside, angle.at_least(0.0), raised);
        }
        angles
    }

    /// ρ of a rotor at (x, y, z) in the deck's axes: the plate's solid angle
    /// seen from there over that at `(offset, offset, z)`, the rotor's place when
    /// the vehicle is centred. 1 at the centre, about a half over the edge.
    #[inline]
    #[must_use]
    pub fn edge_share(&self, place_m: [f64; 3], offset_m: f64) -> f64 {
        match self.surface {
            Surface::Plate => {
                let centred = [offset_m, offset_m, place_m[2]];
                self.solid_angle(place_m) / self.solid_angle(centred)
            }
            Surface::Ground | Surface::Absent => 1.0,
        }
    }
}
