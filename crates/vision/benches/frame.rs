//! Time of a frame: rendering, detection, location; and the fast camera's.
//!
//! ```text
//! cargo bench -p touchdown-vision
//! ```
#![allow(missing_docs)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Pipeline, deck_tags, expose, noise, normal, up, view_from};
use touchdown_sim::sensors::camera::CameraSettings;
use touchdown_sim::sensors::camera::errors::ErrorModel;
use touchdown_sim::sensors::camera::fast::{FastCamera, LocationSettings};
use touchdown_vision::GrayImage;
use touchdown_vision::detect::DetectorSettings;
use touchdown_vision::pad::Pad;

fn main() {
    divan::main();
}

const HEIGHTS_M: [f64; 4] = [3.0, 1.0, 0.3, 0.1];

#[divan::bench(args = HEIGHTS_M)]
fn render(bencher: divan::Bencher<'_, '_>, height_m: f64) {
    let camera = CameraSettings::default();
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    let view = view_from(&camera, [0.0, 0.0, height_m + 0.02], [0.3, 0.03, 0.02]);
    let mut stream = noise(1, 0);
    bencher
        .bench_local(|| expose(&mut pipeline.renderer, &camera, [&view, &view], &mut stream).len());
}

#[divan::bench(args = HEIGHTS_M, consts = [1, 2])]
fn detect<const DECIMATION: usize>(bencher: divan::Bencher<'_, '_>, height_m: f64) {
    let camera = CameraSettings::default();
    let settings = DetectorSettings {
        decimation: DECIMATION,
        ..DetectorSettings::default()
    };
    let mut pipeline = Pipeline::with(&camera, &Pad::default(), &settings);
    let view = view_from(&camera, [0.0, 0.0, height_m + 0.02], [0.3, 0.03, 0.02]);
    let shot = [&view, &view];
    let pixels = expose(&mut pipeline.renderer, &camera, shot, &mut noise(1, 0)).to_vec();
    let image = GrayImage::new(&pixels, 640, 480, 640).expect("an image");
    bencher.bench_local(|| pipeline.detector.detect(&image).map(|tags| tags.len()));
}

#[divan::bench(args = HEIGHTS_M)]
fn locate(bencher: divan::Bencher<'_, '_>, height_m: f64) {
    let camera = CameraSettings::default();
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    let view = view_from(&camera, [0.0, 0.0, height_m + 0.02], [0.3, 0.03, 0.02]);
    let tags = pipeline.detect(&view, &view, &mut noise(1, 0));
    let hints = up(normal(&view));
    bencher.bench_local(|| pipeline.locator.locate(&tags, &hints));
}

#[divan::bench(args = HEIGHTS_M)]
fn fast(bencher: divan::Bencher<'_, '_>, height_m: f64) {
    let camera = CameraSettings::default();
    let tags = deck_tags(&Pad::default());
    let model = ErrorModel::fitted().expect("the model's file");
    let location = LocationSettings::default();
    let quick = FastCamera::new(&camera, &tags, &location, &model).expect("a camera");
    let view = view_from(&camera, [0.0, 0.0, height_m + 0.02], [0.3, 0.03, 0.02]);
    let mut stream = noise(1, 0);
    bencher.bench_local(|| quick.look(&view, &view, &mut stream));
}
