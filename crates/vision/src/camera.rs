//! The camera: a pinhole without distortion.
//!
//! Camera axes: x to the right of the image, y down, z ahead. A point (x, y, z)
//! in camera axes is seen at
//!
//! ```text
//! u = f_x x/z + c_x,   v = f_y y/z + c_y
//! ```
//!
//! in pixels from the *corner* of the image's first pixel: pixel (i, j) covers
//! the square from (i, j) to (i + 1, j + 1) and its centre is at (i + ½, j + ½).
//! The middle of an image of 640 × 480 pixels is (320, 240). A calibration that
//! counts from the first pixel's centre (OpenCV's) has to have ½ added to its
//! principal point; forgetting it costs half a pixel. Images of other lenses
//! have to be rectified before.

use serde::{Deserialize, Serialize};

use crate::error::{VisionError, ensure, positive};

/// Smallest side of an image that the detector is given, px.
pub const MIN_SIDE_PX: usize = 32;

/// Intrinsic parameters of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSettings {
    /// Width of the image, px.
    pub width_px: usize,
    /// Height of the image, px.
    pub height_px: usize,
    /// Focal lengths f_x, f_y, px.
    pub focal_px: [f64; 2],
    /// Principal point c_x, c_y, px; pixel centres are at +½.
    pub principal_px: [f64; 2],
}

impl Default for CameraSettings {
    /// 640 × 480 pixels, 77° × 62°.
    fn default() -> Self {
        Self {
            width_px: 640,
            height_px: 480,
            focal_px: [400.0, 400.0],
            principal_px: [320.0, 240.0],
        }
    }
}

impl CameraSettings {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Sides are 32..16384 px, focal lengths are positive, and the principal
    /// point lies within the image.
    pub fn validate(&self) -> Result<(), VisionError> {
        let sides = [self.width_px, self.height_px];
        for (key, side) in ["width_px", "height_px"].into_iter().zip(sides) {
            ensure(
                (MIN_SIDE_PX..=16_384).contains(&side),
                key,
                "32 to 16384 pixels",
                &side,
            )?;
        }
        for focal in self.focal_px {
            positive("focal_px", focal)?;
        }
        for (centre, side) in self.principal_px.into_iter().zip(sides) {
            ensure(
                centre > 0.0 && centre < side as f64,
                "principal_px",
                "a point within the image",
                &centre,
            )?;
        }
        Ok(())
    }

    /// Where a point in camera axes is seen, px; `None` for one that is not
    /// ahead of the camera.
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

/// Pose of the deck in camera axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation from deck to camera axes, row by row.
    pub rotation: [[f64; 3]; 3],
    /// The deck's origin in camera axes, m.
    pub translation_m: [f64; 3],
}

impl Pose {
    /// A point of the deck's plane in camera axes, m.
    #[inline]
    #[must_use]
    pub fn point(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let at =
            |k: usize| self.rotation[k][0] * x + self.rotation[k][1] * y + self.translation_m[k];
        [at(0), at(1), at(2)]
    }

    /// Height of the camera over the deck's plane, m: `-(Rᵀ t)_z`.
    #[must_use]
    pub fn height_m(&self) -> f64 {
        let [x, y, z] = self.translation_m;
        let normal = self.rotation.map(|row| row[2]);
        -(normal[0] * x + normal[1] * y + normal[2] * z)
    }
}
