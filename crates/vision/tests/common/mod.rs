//! Where rendered images and detection meet.
#![allow(dead_code)] // Not everything is used by every test and example.

pub(crate) mod compare;

use touchdown_sim::body::rigid::RigidState;
use touchdown_sim::deck::rigid::DeckPose;
use touchdown_sim::random::{Purpose, Stream};
use touchdown_sim::sensors::camera::CameraSettings as RenderCamera;
use touchdown_sim::sensors::camera::fast::DeckTag;
use touchdown_sim::sensors::camera::view::View;
use touchdown_vision::camera::{CameraSettings, Pose};
use touchdown_vision::detect::DetectorSettings;
use touchdown_vision::locate::LocatorSettings;
use touchdown_vision::pad::Pad;
use touchdown_vision::render::print::DeckPrint;
use touchdown_vision::render::{ImageSettings, Renderer};
use touchdown_vision::{Detection, Detector, Fix, GrayImage, Hints, Locator};

/// The tags of a pad whose tags stand in one another, for the camera without images.
pub(crate) fn deck_tags(pad: &Pad) -> Vec<DeckTag> {
    let tags = pad.tags.iter().enumerate().map(|(i, tag)| DeckTag {
        size_m: tag.size_m,
        centre_m: tag.centre_m,
        yaw_rad: tag.yaw_rad,
        nested: i > 0,
    });
    tags.collect()
}

/// Lens, light and noise.
pub(crate) fn image(camera: &RenderCamera) -> ImageSettings {
    ImageSettings {
        lens_sd_px: camera.lens_sd_px,
        white_level: camera.white_level,
        gradient: camera.gradient,
        noise_sd: camera.noise_sd,
    }
}

/// A camera that renders a print.
pub(crate) fn renderer(camera: &RenderCamera, print: &DeckPrint) -> Renderer {
    Renderer::new(&intrinsics(camera), &image(camera), print).expect("a camera and a print")
}

/// The image of an exposure between two views.
pub(crate) fn expose<'a>(
    renderer: &'a mut Renderer,
    camera: &RenderCamera,
    [open, shut]: [&View; 2],
    stream: &mut Stream,
) -> &'a [u8] {
    let instants = open.exposure(shut, camera).expect("poses");
    let poses: Vec<Pose> = (instants.iter())
        .map(|view| Pose {
            rotation: view.rotation,
            translation_m: view.translation_m,
        })
        .collect();
    renderer.expose(&poses, || stream.normal())
}

/// The intrinsic parameters, as detection is told them.
pub(crate) fn intrinsics(camera: &RenderCamera) -> CameraSettings {
    CameraSettings {
        width_px: camera.width_px,
        height_px: camera.height_px,
        focal_px: camera.focal_px,
        principal_px: camera.principal_px,
        distortion: [0.0; 5],
    }
}

/// A camera over a pad, and the detection in its images.
pub(crate) struct Pipeline {
    pub(crate) camera: RenderCamera,
    pub(crate) renderer: Renderer,
    pub(crate) detector: Detector,
    pub(crate) locator: Locator,
}

impl Pipeline {
    pub(crate) fn new(camera: &RenderCamera, pad: &Pad) -> Self {
        Self::with(camera, pad, &DetectorSettings::default())
    }

    pub(crate) fn with(camera: &RenderCamera, pad: &Pad, detector: &DetectorSettings) -> Self {
        let settings = LocatorSettings::default();
        Self {
            camera: *camera,
            renderer: renderer(camera, &DeckPrint::of(pad).expect("a print")),
            detector: Detector::new(detector).expect("valid settings"),
            locator: Locator::new(&intrinsics(camera), pad, &settings).expect("a pad"),
        }
    }

    /// Tags seen in an exposure between two views.
    pub(crate) fn detect(
        &mut self,
        open: &View,
        shut: &View,
        stream: &mut Stream,
    ) -> Vec<Detection> {
        let camera = self.camera;
        let pixels = expose(&mut self.renderer, &camera, [open, shut], stream);
        let (width, height) = (camera.width_px, camera.height_px);
        let image = GrayImage::new(pixels, width, height, width).expect("an image");
        self.detector.detect(&image).expect("a detection")
    }

    /// Looks for a moment; `up` is the deck's normal, exactly.
    pub(crate) fn look(
        &mut self,
        view: &View,
        stream: &mut Stream,
    ) -> (Vec<Detection>, Option<Fix>) {
        let tags = self.detect(view, view, stream);
        let fix = self.locator.locate(&tags, &up(normal(view)));
        (tags, fix)
    }
}

/// A hint of where up is.
pub(crate) fn up(normal: [f64; 3]) -> Hints {
    Hints {
        up: Some(normal),
        ..Hints::default()
    }
}

/// The deck's normal in camera axes.
pub(crate) fn normal(view: &View) -> [f64; 3] {
    view.rotation.map(|row| row[2])
}

/// A vehicle at a place over the deck, turned by Euler angles (yaw, pitch, roll).
pub(crate) fn vehicle(position_m: [f64; 3], [yaw, pitch, roll]: [f64; 3]) -> RigidState {
    let half = |angle: f64| (0.5 * angle).sin_cos();
    let ((sy, cy), (sp, cp), (sr, cr)) = (half(yaw), half(pitch), half(roll));
    RigidState {
        position_m,
        attitude: [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        ..RigidState::default()
    }
}

/// The view of a level deck from there.
pub(crate) fn view_from(camera: &RenderCamera, position_m: [f64; 3], angles: [f64; 3]) -> View {
    View::of(camera, &vehicle(position_m, angles), &DeckPose::default())
}

/// The noise of a frame.
pub(crate) fn noise(seed: u64, frame: u64) -> Stream {
    Stream::new(seed, frame, Purpose::Camera)
}

/// Errors of a fix: of the camera's place in deck axes, m, and the turn from
/// the true attitude, in camera axes, rad.
pub(crate) fn errors(fix: &Fix, view: &View) -> ([f64; 3], [f64; 3]) {
    let (found, truth) = (fix.camera_in_deck_m(), view.camera_in_deck_m());
    // R_found R_trueᵀ is a small turn: its skew part.
    let (f, t) = (fix.rotation, view.rotation);
    let at = |i: usize, j: usize| (0..3).map(|k| f[i][k] * t[j][k]).sum::<f64>();
    let turn = [
        0.5 * (at(2, 1) - at(1, 2)),
        0.5 * (at(0, 2) - at(2, 0)),
        0.5 * (at(1, 0) - at(0, 1)),
    ];
    (std::array::from_fn(|k| found[k] - truth[k]), turn)
}
