//! The camera pipeline of landings with rendered images: renderer, detector, and the pose of the deck.

use touchdown_sim::SimError;
use touchdown_sim::random::Stream;
use touchdown_sim::sensors::TagSettings;
use touchdown_sim::sensors::camera::fast::CameraFix;
use touchdown_sim::sensors::camera::pipeline::{CameraPipeline, PipelineFactory};
use touchdown_sim::sensors::camera::view::View;
use touchdown_vision::camera::{CameraSettings, Pose};
use touchdown_vision::detect::DetectorSettings;
use touchdown_vision::locate::LocatorSettings;
use touchdown_vision::pad::{Pad, PadTag};
use touchdown_vision::render::print::DeckPrint;
use touchdown_vision::render::{ImageSettings, Renderer};
use touchdown_vision::{Detector, GrayImage, Hints, Locator, VisionError};

/// Renders images, detects tags in them and locates the deck.
struct RenderedCamera {
    renderer: Renderer,
    detector: Detector,
    locator: Locator,
    camera: touchdown_sim::sensors::camera::CameraSettings,
}

/// Pipelines with the renderer and the detector of `touchdown-vision`.
#[must_use]
pub fn pipelines() -> PipelineFactory {
    PipelineFactory::new(|settings, side_m| Ok(Box::new(RenderedCamera::new(settings, side_m)?)))
}

/// An error of detection, as one of the simulation's settings.
fn unfit(error: VisionError) -> SimError {
    match error {
        VisionError::Setting {
            key,
            expected,
            found,
        } => SimError::Setting {
            key,
            expected,
            found,
        },
        other => SimError::Setting {
            key: "camera".to_owned(),
            expected: "images of a size in which tags can be detected".to_owned(),
            found: other.to_string(),
        },
    }
}

/// The same pose for the renderer.
fn pose(view: &View) -> Pose {
    Pose {
        rotation: view.rotation,
        translation_m: view.translation_m,
    }
}

impl RenderedCamera {
    fn new(settings: &TagSettings, side_m: Option<f64>) -> Result<Self, SimError> {
        let bad = |expected: String, found: String| SimError::Setting {
            key: "sizes_m".to_owned(),
            expected,
            found,
        };
        // The ids of the standard pad, whose prints hold one another.
        let ids: Vec<u32> = Pad::default().tags.iter().map(|tag| tag.id).collect();
        if settings.sizes_m.len() > ids.len() {
            return Err(bad(
                format!("at most {} tags in rendered images", ids.len()),
                settings.sizes_m.len().to_string(),
            ));
        }
        let tag = |(&id, &size_m): (&u32, &f64)| PadTag {
            id,
            size_m,
            centre_m: [0.0; 2],
            yaw_rad: 0.0,
        };
        let pad = Pad {
            tags: ids.iter().zip(&settings.sizes_m).map(tag).collect(),
        };
        let mut print = DeckPrint::of(&pad).map_err(unfit)?;
        if let Some(side_m) = side_m {
            print.side_m = side_m;
        }
        let camera = &settings.camera;
        let intrinsics = CameraSettings {
            width_px: camera.width_px,
            height_px: camera.height_px,
            focal_px: camera.focal_px,
            principal_px: camera.principal_px,
            distortion: [0.0; 5],
        };
        let image = ImageSettings {
            lens_sd_px: camera.lens_sd_px,
            white_level: camera.white_level,
            gradient: camera.gradient,
            noise_sd: camera.noise_sd,
        };
        let of = &settings.location;
        let location = LocatorSettings {
            fine_sd_px: of.fine_sd_px,
            coarse_sd_px: of.coarse_sd_px,
            fine_cell_px: of.fine_cell_px,
            motion_free_px: of.motion_free_px,
            motion_gain: of.motion_gain,
            border_px: of.border_px,
            gate_px: of.gate_px,
        };
        Ok(Self {
            renderer: Renderer::new(&intrinsics, &image, &print).map_err(unfit)?,
            detector: Detector::new(&DetectorSettings::default()).map_err(unfit)?,
            locator: Locator::new(&intrinsics, &pad, &location).map_err(unfit)?,
            camera: *camera,
        })
    }
}

impl CameraPipeline for RenderedCamera {
    fn locate(
        &mut self,
        open: &View,
        shut: &View,
        up: [f64; 3],
        stream: &mut Stream,
    ) -> Result<Option<CameraFix>, SimError> {
        let (width, height) = (self.camera.width_px, self.camera.height_px);
        let instants = open.exposure(shut, &self.camera)?;
        let poses: Vec<Pose> = instants.iter().map(pose).collect();
        let pixels = self.renderer.expose(&poses, || stream.normal());
        let image = GrayImage::new(pixels, width, height, width).map_err(unfit)?;
        let tags = self.detector.detect(&image).map_err(unfit)?;
        let hints = Hints {
            up: Some(up),
            motion_px: open.motion_px(shut, &self.camera),
        };
        let fix = self.locator.locate(&tags, &hints);
        Ok(fix.map(|fix| CameraFix {
            view: View {
                rotation: fix.rotation,
                translation_m: fix.translation_m,
            },
            covariance: fix.covariance,
            tags: fix.tags,
        }))
    }
}
