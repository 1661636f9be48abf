//! The downward camera over the landing pad of a moving, tilted deck.
//!
//! [`fast`] needs no images: it gives the pose that a detector would find, with errors measured
//! with a detector on rendered images ([`errors`]). [`pipeline`] is the seam through which a
//! renderer with a detector is plugged in; neither is part of this crate.
//!
//! Camera axes are x to the right of the image, y down, z ahead. Pixel (i, j)
//! covers the square from (i, j) to (i + 1, j + 1), so pixel centres are at +½.

pub mod errors;
pub mod fast;
mod normal_equations;
pub mod pipeline;
pub(super) mod sensor;
pub(super) mod tags;
pub mod view;

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;

/// The camera and its lens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSettings {
    /// Width of the image, px.
    pub width_px: usize,
    /// Height of the image, px.
    pub height_px: usize,
    /// Focal lengths, px.
    pub focal_px: [f64; 2],
    /// Principal point, px; pixel centres are at +½.
    pub principal_px: [f64; 2],
    /// Place of the lens in body axes, m.
    pub place_m: [f64; 3],
    /// Turn of the image's top from forward, to port, rad.
    pub turn_rad: f64,
    /// Time that the shutter is open, s.
    pub exposure_s: f64,
    /// Blur of the lens: standard deviation of its point spread, px.
    pub lens_sd_px: f64,
    /// Grey level of a perfectly white surface in the image's middle, 0..255.
    pub white_level: f64,
    /// How much brighter the right and the lower edge of the image are than the
    /// left and the upper one, as a share.
    pub gradient: [f64; 2],
    /// Noise of a pixel, standard deviation, grey levels.
    pub noise_sd: f64,
}

impl Default for CameraSettings {
    /// 640 × 480 pixels, 77° × 62°, 4 ms of exposure.
    fn default() -> Self {
        Self {
            width_px: 640,
            height_px: 480,
            focal_px: [400.0, 400.0],
            principal_px: [320.0, 240.0],
            place_m: [0.0, 0.0, -0.02],
            turn_rad: 0.0,
            exposure_s: 0.004,
            lens_sd_px: 0.6,
            white_level: 220.0,
            gradient: [0.0, 0.0],
            noise_sd: 2.0,
        }
    }
}

impl CameraSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Sides are 1..16384 px, focal lengths are positive, the principal point
    /// lies within the image, times, blur and noise are not negative, the lens
    /// blurs by 20 px at most and gradients are within ±1.
    pub fn validate(&self) -> Result<(), SimError> {
        let sides = [self.width_px, self.height_px];
        for (key, side) in ["width_px", "height_px"].into_iter().zip(sides) {
            check::within(key, side as f64, 1.0, 16_384.0)?;
        }
        for k in 0..2 {
            check::positive("focal_px", self.focal_px[k])?;
            check::within("principal_px", self.principal_px[k], 0.0, sides[k] as f64)?;
            check::within("gradient", self.gradient[k], -1.0, 1.0)?;
        }
        for x in self.place_m {
            check::finite("place_m", x)?;
        }
        check::finite("turn_rad", self.turn_rad)?;
        check::within("exposure_s", self.exposure_s, 0.0, 1.0)?;
        check::within("lens_sd_px", self.lens_sd_px, 0.0, 20.0)?;
        check::within("white_level", self.white_level, 1.0, 1e4)?;
        check::not_negative("noise_sd", self.noise_sd)
    }

    /// Where a point in camera axes is seen, px; `None` for one that is not
    /// ahead of the lens.
    #[inline]
    #[must_use]
    pub fn project(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        (z > 0.0).then(|| {
            [
                self.focal_px[0] * x / z + self.principal_px[0],
                self.focal_px[1] * y / z + self.principal_px[1],
            ]
        })
    }
}
