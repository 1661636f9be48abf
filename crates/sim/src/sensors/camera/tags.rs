//! Settings of the camera that sees the tags.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::sensors::camera::CameraSettings;
use crate::sensors::camera::errors::ErrorModel;
use crate::sensors::camera::fast::{CELLS, DeckTag, FastCamera, LocationSettings};
use crate::sensors::{CameraMode, Schedule};

/// The camera and its detector in the fast mode of [`crate::sensors::camera::fast`]: the
/// deck's pose with the errors of a detector, measured on rendered images.
/// These images had the default blur, light and noise (`lens_sd_px`, `white_level`, `gradient`,
/// `noise_sd`). Other values are refused, except where images are rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TagSettings {
    /// When readings come: frames, and the time to find the tags in them.
    pub schedule: Schedule,
    /// The camera, looking against the body's z axis.
    pub camera: CameraSettings,
    /// Sides of the tags, each in the middle of the one before, m.
    pub sizes_m: Vec<f64>,
    /// How corners are weighted.
    pub location: LocationSettings,
    /// Whether the detector errs; else the pose is exact wherever the deck's centre
    /// is in the image.
    pub errors: bool,
}

impl Default for TagSettings {
    /// 30 Hz, 40 ms and 3 ms; the default camera over tags of 0.4 m, 80 mm and 16 mm.
    fn default() -> Self {
        Self {
            schedule: Schedule::new(30.0, 0.04, 0.003),
            camera: CameraSettings::default(),
            sizes_m: vec![0.4, 0.08, 0.016],
            location: LocationSettings::default(),
            errors: true,
        }
    }
}

impl TagSettings {
    pub(crate) fn validate(&self) -> Result<(), SimError> {
        self.schedule
            .validate()
            .map_err(|e| e.in_section("schedule"))?;
        self.camera.validate().map_err(|e| e.in_section("camera"))?;
        check::that(!self.sizes_m.is_empty(), "sizes_m", "at least one tag", 0.0)?;
        for (i, &size_m) in self.sizes_m.iter().enumerate() {
            check::positive("sizes_m", size_m)?;
            check::that(
                i == 0 || size_m < 0.25 * self.sizes_m[i - 1],
                "sizes_m",
                "less than a quarter of the one before",
                size_m,
            )?;
        }
        self.location
            .validate()
            .map_err(|e| e.in_section("location"))
    }

    /// Blur, light and noise are those of the images that errors were fitted to.
    fn check_image(&self) -> Result<(), SimError> {
        let (camera, fitted) = (&self.camera, CameraSettings::default());
        for (key, value, was) in [
            ("lens_sd_px", camera.lens_sd_px, fitted.lens_sd_px),
            ("white_level", camera.white_level, fitted.white_level),
            ("gradient", camera.gradient[0], fitted.gradient[0]),
            ("gradient", camera.gradient[1], fitted.gradient[1]),
            ("noise_sd", camera.noise_sd, fitted.noise_sd),
        ] {
            let expected = format!("{was}, for which the camera without images was fitted");
            // Exactly: there are tables for this one only.
            check::that((value - was).abs() <= 0.0, key, &expected, value)?;
        }
        Ok(())
    }

    /// The camera without images over a square deck of the side `side_m`, or over one
    /// without an edge.
    pub(crate) fn fast(
        &self,
        side_m: Option<f64>,
        mode: CameraMode,
    ) -> Result<FastCamera, SimError> {
        if mode == CameraMode::Fast {
            self.check_image().map_err(|e| e.in_section("camera"))?;
        }
        // The largest comes first; its white margin is a cell wide.
        let painted_m = self.sizes_m[0] * (1.0 + 2.0 / CELLS as f64);
        let side_m = side_m.unwrap_or(painted_m);
        check::that(
            painted_m <= side_m,
            "sizes_m",
            &format!("a tag that fits with its margin of a cell on the plate of {side_m} m"),
            self.sizes_m[0],
        )?;
        let tags: Vec<DeckTag> = (self.sizes_m.iter().enumerate())
            .map(|(i, &size_m)| DeckTag {
                size_m,
                centre_m: [0.0; 2],
                yaw_rad: 0.0,
                nested: i > 0,
            })
            .collect();
        FastCamera::new(&self.camera, &tags, &self.location, &ErrorModel::fitted()?)
    }
}
