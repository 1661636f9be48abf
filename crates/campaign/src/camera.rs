//! The camera pipeline of landings with rendered images: renderer, detector, and the pose of the deck.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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

/// The poses of an exposure.
fn exposure(
    open: &View,
    shut: &View,
    camera: &touchdown_sim::sensors::camera::CameraSettings,
) -> Result<Vec<Pose>, SimError> {
    Ok(open.exposure(shut, camera)?.iter().map(pose).collect())
}

/// Lens, pad and renderer of the simulation's camera.
fn renderer(
    settings: &TagSettings,
    side_m: Option<f64>,
) -> Result<(CameraSettings, Pad, Renderer), SimError> {
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
    let renderer = Renderer::new(&intrinsics, &image, &print).map_err(unfit)?;
    Ok((intrinsics, pad, renderer))
}

impl RenderedCamera {
    fn new(settings: &TagSettings, side_m: Option<f64>) -> Result<Self, SimError> {
        let (intrinsics, pad, renderer) = renderer(settings, side_m)?;
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
            renderer,
            detector: Detector::new(&DetectorSettings::default()).map_err(unfit)?,
            locator: Locator::new(&intrinsics, &pad, &location).map_err(unfit)?,
            camera: settings.camera,
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
        let poses = exposure(open, shut, &self.camera)?;
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

/// Frames that are kept at most: those on their way at 100 Hz and the longest latency.
const KEPT_FRAMES: usize = 64;

/// A rendered frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilmFrame {
    /// Its number, from zero: that of the sighting with which it arrives.
    pub number: u64,
    /// Grey pixels, row by row from the top.
    pub pixels: Vec<u8>,
    /// Width and height, px.
    pub size_px: [usize; 2],
}

/// The frames of a simulated camera, for whoever looks for the deck in them. The simulation itself then looks for
/// nothing: each of its sightings only says that a frame has arrived, and how old it is known to be.
#[derive(Clone, Debug, Default)]
pub struct Film(Arc<Mutex<VecDeque<FilmFrame>>>);

impl Film {
    fn frames(&self) -> MutexGuard<'_, VecDeque<FilmFrame>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Pipelines that put their frames onto this film: for one landing.
    #[must_use]
    pub fn pipelines(&self) -> PipelineFactory {
        let film = self.clone();
        PipelineFactory::new(move |settings, side_m| {
            let (_, _, renderer) = renderer(settings, side_m)?;
            Ok(Box::new(FilmingCamera {
                renderer,
                camera: settings.camera,
                film: film.clone(),
                next: 0,
            }))
        })
    }

    /// The frame of a number. Older ones, which were lost on their way, are forgotten.
    #[must_use]
    pub fn take(&self, number: u64) -> Option<FilmFrame> {
        let mut frames = self.frames();
        while let Some(frame) = frames.pop_front() {
            if frame.number == number {
                return Some(frame);
            }
            if frame.number > number {
                frames.push_front(frame);
                return None;
            }
        }
        None
    }
}

/// A camera that keeps its frames and looks for nothing in them.
struct FilmingCamera {
    renderer: Renderer,
    camera: touchdown_sim::sensors::camera::CameraSettings,
    film: Film,
    next: u64,
}

impl CameraPipeline for FilmingCamera {
    fn locate(
        &mut self,
        open: &View,
        shut: &View,
        _up: [f64; 3],
        stream: &mut Stream,
    ) -> Result<Option<CameraFix>, SimError> {
        let poses = exposure(open, shut, &self.camera)?;
        let pixels = self.renderer.expose(&poses, || stream.normal());
        let mut frames = self.film.frames();
        if frames.len() == KEPT_FRAMES {
            frames.pop_front();
        }
        frames.push_back(FilmFrame {
            number: self.next,
            pixels: pixels.to_vec(),
            size_px: [self.camera.width_px, self.camera.height_px],
        });
        self.next += 1;
        // Every frame arrives, whatever it shows.
        Ok(Some(CameraFix {
            view: open.towards(shut, 0.5),
            covariance: [[0.0; 6]; 6],
            tags: 0,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_film_gives_each_frame_once_and_forgets_lost_ones() {
        let film = Film::default();
        let factory = film.pipelines();
        let mut camera = factory.build(&TagSettings::default(), None).unwrap();
        let view = View {
            rotation: [[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
            translation_m: [0.0, 0.0, 1.0],
        };
        let mut stream = Stream::new(1, 0, touchdown_sim::random::Purpose::Camera);
        for _ in 0..KEPT_FRAMES + 3 {
            let fix = camera.locate(&view, &view, [0.0; 3], &mut stream).unwrap();
            assert_eq!(fix.unwrap().view, view);
        }
        // The first three had no place.
        assert!(film.take(2).is_none());
        let frame = film.take(5).expect("a frame");
        assert_eq!((frame.number, frame.size_px), (5, [640, 480]));
        // A pad in the middle: black, white and the grey of the deck.
        let darkest = frame.pixels.iter().min().unwrap();
        let brightest = frame.pixels.iter().max().unwrap();
        assert!(brightest - darkest > 100);
        assert!(film.take(4).is_none() && film.take(5).is_none());
        assert_eq!(film.take(6).unwrap().number, 6);
    }
}
