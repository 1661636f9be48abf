//! The same frames, rendered and detected, and by the fast camera.

use touchdown_sim::deck::rigid::DeckPose;
use touchdown_sim::sensors::camera::CameraSettings;
use touchdown_sim::sensors::camera::errors::ErrorModel;
use touchdown_sim::sensors::camera::fast::{FastCamera, LocationSettings};
use touchdown_sim::sensors::camera::view::View;
use touchdown_vision::locate::Hints;
use touchdown_vision::pad::Pad;

use super::{Pipeline, deck_tags, noise, normal, vehicle};

/// Heights (m) and how fast the vehicle moves, as a multiple of 0.4 m/s and
/// 1.2 rad/s (standard deviations).
pub(crate) const BANDS: [([f64; 2], f64); 8] = [
    ([0.08, 0.2], 0.2),
    ([0.2, 0.6], 0.2),
    ([0.6, 1.5], 0.2),
    ([1.5, 3.0], 0.2),
    ([3.0, 6.0], 0.2),
    ([0.1, 0.5], 2.0),
    ([0.5, 3.0], 2.0),
    ([8.0, 14.0], 0.2),
];

/// Looks of the fast camera at every frame.
pub(crate) const AGAIN: u64 = 5;

/// What errors are of.
pub(crate) const NAMES: [&str; 4] = ["lateral", "range", "tilt", "stated"];

/// Errors of fixes: lateral and in range, over the height; of tilt, rad; and
/// the standard deviation of tilt that the covariance states, rad.
#[derive(Debug, Default)]
pub(crate) struct Errors {
    pub(crate) fixes: u64,
    pub(crate) of: [Vec<f64>; 4],
}

impl Errors {
    fn take(&mut self, found: &View, covariance: &[[f64; 6]; 6], truth: &View) {
        let (a, b) = (found.camera_in_deck_m(), truth.camera_in_deck_m());
        let height = b[2];
        let at = |i: usize, j: usize| {
            let (f, t) = (found.rotation[i], truth.rotation[j]);
            f[0] * t[0] + f[1] * t[1] + f[2] * t[2]
        };
        self.fixes += 1;
        self.of[0].extend([(a[0] - b[0]) / height, (a[1] - b[1]) / height]);
        self.of[1].push((a[2] - b[2]) / height);
        self.of[2].extend([0.5 * (at(2, 1) - at(1, 2)), 0.5 * (at(0, 2) - at(2, 0))]);
        self.of[3].push((0.5 * (covariance[3][3] + covariance[4][4])).sqrt());
    }

    /// Mean and standard deviation, and the median and the 90 % quantile of the
    /// magnitude.
    pub(crate) fn figures(&self, of: usize) -> [f64; 4] {
        let values = &self.of[of];
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        let mut sorted: Vec<f64> = values.iter().map(|v| v.abs()).collect();
        sorted.sort_by(f64::total_cmp);
        let quantile = |p: f64| sorted[(p * (n - 1.0)).round() as usize];
        [mean, (squares / n).sqrt(), quantile(0.5), quantile(0.9)]
    }
}

/// A vehicle on its way down: views at the start and the end of the exposure.
fn descent(camera: &CameraSettings, frame: u64, heights_m: [f64; 2], fast: f64) -> [View; 2] {
    // Seeds of its own: not those that the tables were made with.
    let mut stream = noise(77, frame);
    let [low, high] = heights_m;
    let height = low * (high / low).powf(stream.uniform());
    let aside = f64::max(0.008, 0.06 * height);
    let mut normal = |sd: f64| sd * stream.normal();
    let place = [normal(aside), normal(aside), height - camera.place_m[2]];
    let angles = [normal(2.0), normal(0.05), normal(0.05)];
    let velocity = [normal(0.4 * fast), normal(0.4 * fast), normal(0.3 * fast)];
    let rates = [normal(0.5 * fast), normal(1.2 * fast), normal(1.2 * fast)];
    [-0.5, 0.5].map(|s| {
        let t = s * camera.exposure_s;
        let place = [0, 1, 2].map(|k| place[k] + t * velocity[k]);
        let angles = [0, 1, 2].map(|k| angles[k] + t * rates[k]);
        View::of(camera, &vehicle(place, angles), &DeckPose::default())
    })
}

/// Rendered and detected; by the fast camera, [`AGAIN`] times as often.
pub(crate) fn both(heights_m: [f64; 2], fast: f64, frames: u64) -> [Errors; 2] {
    let camera = CameraSettings {
        exposure_s: 0.008,
        ..CameraSettings::default()
    };
    let pad = Pad::default();
    let mut pipeline = Pipeline::new(&camera, &pad);
    let model = ErrorModel::fitted().expect("the model's file");
    let location = LocationSettings::default();
    let quick = FastCamera::new(&camera, &deck_tags(&pad), &location, &model).expect("a camera");
    let [mut seen, mut drawn] = [Errors::default(), Errors::default()];
    for frame in 0..frames {
        let [open, shut] = descent(&camera, frame, heights_m, fast);
        let truth = open.towards(&shut, 0.5);
        let tags = pipeline.detect(&open, &shut, &mut noise(78, frame));
        let hints = Hints {
            up: Some(normal(&truth)),
            motion_px: open.motion_px(&shut, &camera),
        };
        if let Some(fix) = pipeline.locator.locate(&tags, &hints) {
            let found = View {
                rotation: fix.rotation,
                translation_m: fix.translation_m,
            };
            seen.take(&found, &fix.covariance, &truth);
        }
        for again in 0..AGAIN {
            let mut stream = noise(79 + again, frame);
            if let Some(fix) = quick.look(&open, &shut, &mut stream).expect("views") {
                drawn.take(&fix.view, &fix.covariance, &truth);
            }
        }
    }
    [seen, drawn]
}
