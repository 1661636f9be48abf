//! Time of a frame: rendering, detection, location; and the fast camera's.
//!
//! ```text
//! cargo bench -p touchdown-vision
//! ```
#![allow(missing_docs)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Eye, noise, normal, print_of, up, view_from};
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
    let mut eye = Eye::new(&camera, &Pad::default());
    let view = view_from(&camera, [0.0, 0.0, height_m + 0.02], [0.3, 0.03, 0.02]);
    let mut stream = noise(1, 0);
    bencher.bench_local(|| {
        eye.renderer
            .expose(&view, &view, &mut stream)
            .map(<[u8]>::len)
    });
}

#[divan::bench(args = HEIGHTS_M, consts = [1, 2])]
fn detect<const DECIMATION: usize>(bencher: divan::Bencher<'_, '_>, height_m: f64) {
    let camera = CameraSettings::default();
    let settings = DetectorSettings {
        decimation: DECIMATION,
        ..DetectorSettings::default()
    };
    let mut eye = Eye::with(&camera, &Pad::default(), &settings);
    let view = view_from(&camera, [0.0, 0.0, height_m + 0.02], [0.3, 0.03, 0.02]);
    let pixels = eye.renderer.expose(&view, &view, &mut noise(1, 0));
    let pixels = pixels.expect("a view").to_vec();
    let image = GrayImage::new(&pixels, 640, 480, 640).expect("an image");
    bencher.bench_local(|| eye.detector.detect(&image).map(|tags| tags.len()));
}

#[divan::bench(args = HEIGHTS_M)]
fn locate(bencher: divan::Bencher<'_, '_>, height_m: f64) {
    let camera = CameraSettings::default();
    let mut eye = Eye::new(&camera, &Pad::default());
    let view = view_from(&camera, [0.0, 0.0, height_m + 0.02], [0.3, 0.03, 0.02]);
    let tags = eye.detect(&view, &view, &mut noise(1, 0));
    let hints = up(normal(&view));
    bencher.bench_local(|| eye.locator.locate(&tags, &hints));
}

#[divan::bench(args = HEIGHTS_M)]
fn fast(bencher: divan::Bencher<'_, '_>, height_m: f64) {
    let camera = CameraSettings::default();
    let print = print_of(&Pad::default());
    let model = ErrorModel::fitted().expect("the model's file");
    let location = LocationSettings::default();
    let quick = FastCamera::new(&camera, &print, &location, &model).expect("a camera");
    let view = view_from(&camera, [0.0, 0.0, height_m + 0.02], [0.3, 0.03, 0.02]);
    let mut stream = noise(1, 0);
    bencher.bench_local(|| quick.look(&view, &view, &mut stream));
}
