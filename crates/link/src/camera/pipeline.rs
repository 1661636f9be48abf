//! A frame to the position of the deck.

use touchdown_flight::{Attitude, Vector};
use touchdown_vision::{Detection, Detector, GrayImage, Hints, Locator};

use super::report::DeckFix;
use super::settings::{CameraError, CameraSettings};
use super::{Frame, FrameError};

/// Time between two frames from which their motion is measured, µs: with longer gaps the motion has changed. Half of it
/// leaves out cameras of 5 Hz.
const MOTION_GAP_US: i64 = 400_000;

/// Finds the deck in frames. Holds the memory that it works in, and the corners of the frame before.
#[derive(Debug)]
pub struct Pipeline {
    size_px: [usize; 2],
    exposure_s: f64,
    detector: Detector,
    locator: Locator,
    position_m: Vector<f64>,
    /// Directions of the camera's axes in body axes.
    axes: [Vector<f64>; 3],
    before: Option<(i64, Vec<Detection>)>,
}

impl Pipeline {
    /// Checks the settings and builds the detector.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn new(settings: &CameraSettings) -> Result<Self, CameraError> {
        settings.check()?;
        let unfit = |e| CameraError::of_vision("", &e);
        let intrinsics = settings.intrinsics();
        Ok(Self {
            size_px: settings.size_px(),
            exposure_s: settings.exposure_s,
            detector: Detector::new(&settings.detector).map_err(unfit)?,
            locator: Locator::new(&intrinsics, &settings.pad, &settings.locator).map_err(unfit)?,
            position_m: Vector::from_array(settings.position_m),
            axes: settings.axes(),
            before: None,
        })
    }

    /// The deck in a frame of the time `at_us`, if a tag of its pad is found. The vehicle's attitude decides between two
    /// poses that explain the tags about as well; without one the vehicle counts as level.
    ///
    /// # Errors
    /// A frame of another size than that of the settings.
    pub fn locate(
        &mut self,
        frame: &Frame,
        at_us: i64,
        attitude: Option<Attitude<f64>>,
    ) -> Result<Option<DeckFix>, FrameError> {
        if frame.size_px != self.size_px {
            return Err(FrameError::Size {
                expected: self.size_px,
                found: frame.size_px,
            });
        }
        let [width, height] = self.size_px;
        let refused = |e: touchdown_vision::VisionError| {
            FrameError::format("an image in which tags can be looked for", e.to_string())
        };
        let image = GrayImage::new(&frame.pixels, width, height, width).map_err(refused)?;
        let tags = self.detector.detect(&image).map_err(refused)?;
        let up = attitude.unwrap_or_default().unrotate(Vector::UP);
        let hints = Hints {
            up: Some(self.axes.map(|axis| axis.dot(up))),
            motion_px: self.motion_px(&tags, at_us),
        };
        let fix = self.locator.locate(&tags, &hints);
        self.before = Some((at_us, tags));
        Ok(fix.map(|fix| {
            let covariance = [0, 1, 2].map(|i| [0, 1, 2].map(|j| fix.covariance[i][j]));
            DeckFix {
                position_m: (self.position_m + self.to_body(fix.translation_m)).to_array(),
                covariance_m2: self.covariance_to_body(&covariance),
                normal: self.to_body(fix.normal()).to_array(),
                tags: fix.tags,
                residual_px: fix.residual_px,
            }
        }))
    }

    /// A vector in camera axes, in body axes.
    fn to_body(&self, [right, down, ahead]: [f64; 3]) -> Vector<f64> {
        self.axes[0] * right + self.axes[1] * down + self.axes[2] * ahead
    }

    /// A covariance in camera axes, in body axes: `A C Aᵀ`.
    fn covariance_to_body(&self, covariance: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let axes = self.axes.map(Vector::to_array);
        let term = |i: usize, j: usize| {
            let mut sum = 0.0;
            for k in 0..3 {
                for l in 0..3 {
                    sum += axes[k][i] * covariance[k][l] * axes[l][j];
                }
            }
            sum
        };
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| term(i, j)))
    }

    /// How far the image moves during an exposure, px, by the tags that this frame and the one before show.
    fn motion_px(&self, tags: &[Detection], at_us: i64) -> f64 {
        let Some((before_us, before)) = &self.before else {
            return 0.0;
        };
        let gap_us = at_us.saturating_sub(*before_us);
        if !(1..=MOTION_GAP_US).contains(&gap_us) {
            return 0.0;
        }
        let moved = tags.iter().filter_map(|tag| {
            let was = before.iter().find(|was| was.id == tag.id)?;
            let corners = tag.corners_px.iter().zip(was.corners_px);
            let moved = corners.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
            Some(moved.sum::<f64>() / 4.0)
        });
        moved.fold(0.0, f64::max) * self.exposure_s / (gap_us as f64 * 1e-6)
    }
}
