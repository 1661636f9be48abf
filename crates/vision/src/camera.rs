//! The camera: a pinhole, and the distortion of its lens.
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
//! principal point; forgetting it costs half a pixel.
//!
//! A lens moves these points. With `x/z`, `y/z` as x, y and `r² = x² + y²`, they are seen at (Brown 1971, as in OpenCV)
//!
//! ```text
//! x (1 + k₁ r² + k₂ r⁴ + k₃ r⁶) + 2 p₁ x y + p₂ (r² + 2 x²)
//! y (1 + k₁ r² + k₂ r⁴ + k₃ r⁶) + p₁ (r² + 2 y²) + 2 p₂ x y
//! ```
//!
//! Corners of tags are moved back before a pose is fitted. The detector looks for straight sides of tags, so lenses that
//! bend the side of a tag by more than a pixel need images that are rectified before.

use serde::{Deserialize, Serialize};

use crate::error::{VisionError, ensure, finite, positive};

/// Smallest side of an image that the detector is given, px.
pub const MIN_SIDE_PX: usize = 32;

/// Steps of undistortion at most: lenses of 100° take 20.
const UNDISTORTING_STEPS: usize = 100;

/// Error that undistortion leaves, px: a thirtieth of what corners of tags err by at best.
const UNDISTORTED_PX: f64 = 1e-3;

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
    /// Distortion k₁, k₂, p₁, p₂, k₃; zeros for a pinhole.
    pub distortion: [f64; 5],
}

impl Default for CameraSettings {
    /// 640 × 480 pixels, 77° × 62°.
    fn default() -> Self {
        Self {
            width_px: 640,
            height_px: 480,
            focal_px: [400.0, 400.0],
            principal_px: [320.0, 240.0],
            distortion: [0.0; 5],
        }
    }
}

impl CameraSettings {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Sides are 32..16384 px, focal lengths are positive, the principal
    /// point lies within the image, and the distortion can be undone in the
    /// image's corners.
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
        for number in self.distortion {
            finite("distortion", number)?;
        }
        let [width, height] = sides.map(|side| side as f64);
        for corner in [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]] {
            let undone = self.undistorted(corner).is_some();
            let expected = "a lens that shows each place once, k1, k2, p1, p2, k3";
            let found = format!("{:?}", self.distortion);
            ensure(undone, "distortion", expected, &found)?;
        }
        Ok(())
    }

    /// Where a pinhole would see what this lens shows at a place in the image, px; `None` beyond what the lens shows.
    ///
    /// The distortion is undone by iteration, to a thousandth of a pixel.
    #[must_use]
    pub fn undistorted(&self, seen_px: [f64; 2]) -> Option<[f64; 2]> {
        let [k1, k2, p1, p2, k3] = self.distortion;
        if self.distortion == [0.0; 5] {
            return Some(seen_px);
        }
        let seen: [f64; 2] = [0, 1].map(|i| (seen_px[i] - self.principal_px[i]) / self.focal_px[i]);
        let [mut x, mut y] = seen;
        for _ in 0..UNDISTORTING_STEPS {
            let r2 = x * x + y * y;
            let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
            let shift = [
                2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            ];
            let off = [0, 1].map(|i| [x, y][i] * radial + shift[i] - seen[i]);
            if !(radial > 0.0) {
                return None;
            }
            if off[0].hypot(off[1]) * self.focal_px[0].max(self.focal_px[1]) < UNDISTORTED_PX {
                return Some([0, 1].map(|i| self.focal_px[i] * [x, y][i] + self.principal_px[i]));
            }
            (x, y) = ((seen[0] - shift[0]) / radial, (seen[1] - shift[1]) / radial);
        }
        None
    }

    /// Where a pinhole sees a point in camera axes, px; `None` for one that is not
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a lens shows a point of a pinhole's image.
    fn distorted(camera: &CameraSettings, px: [f64; 2]) -> [f64; 2] {
        let [k1, k2, p1, p2, k3] = camera.distortion;
        let [x, y] = [0, 1].map(|i| (px[i] - camera.principal_px[i]) / camera.focal_px[i]);
        let r2 = x * x + y * y;
        let radial = 1.0 + k1 * r2 + k2 * r2.powi(2) + k3 * r2.powi(3);
        let moved = [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        [0, 1].map(|i| camera.focal_px[i] * moved[i] + camera.principal_px[i])
    }

    #[test]
    fn analytic_distortion_is_undone_to_a_thousandth_of_a_pixel() {
        // A wide lens as calibrations give them: 20 px in the corners.
        let camera = CameraSettings {
            focal_px: [405.0, 400.0],
            distortion: [-0.12, 0.02, 0.001, -0.0007, -0.001],
            ..CameraSettings::default()
        };
        camera.validate().unwrap();
        for u in (0..=640).step_by(40) {
            for v in (0..=480).step_by(40) {
                let there = [f64::from(u), f64::from(v)];
                let seen = distorted(&camera, there);
                let back = camera.undistorted(seen).unwrap();
                let off = (back[0] - there[0]).hypot(back[1] - there[1]);
                // The bound on the image's side is up to 1.5 times as much on the pinhole's.
                assert!(off < 2.0 * UNDISTORTED_PX, "{off} px at {there:?}");
            }
        }
        let corner = distorted(&camera, [0.0, 0.0]);
        assert!(corner[0].hypot(corner[1]) > 15.0, "{corner:?}");
    }

    #[test]
    fn prop_a_lens_that_folds_the_image_is_refused() {
        let camera = CameraSettings {
            distortion: [-2.0, 0.0, 0.0, 0.0, 0.0],
            ..CameraSettings::default()
        };
        let said = camera.validate().unwrap_err().to_string();
        assert!(
            said.contains("`distortion`") && said.contains("-2.0"),
            "{said}"
        );
        let camera = CameraSettings {
            distortion: [0.0, f64::NAN, 0.0, 0.0, 0.0],
            ..CameraSettings::default()
        };
        assert!(camera.validate().is_err());
    }
}
