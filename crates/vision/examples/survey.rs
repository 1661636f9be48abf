//! Detection rate, errors and time over the height of the camera above the pad.
//!
//! ```text
//! cargo run --release -p touchdown-vision --example survey [FRAMES]
//! ```
#![allow(clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{Pipeline, errors, noise, view_from};
use touchdown_sim::sensors::camera::CameraSettings;
use touchdown_vision::pad::Pad;

fn main() {
    let frames: u64 = std::env::args()
        .nth(1)
        .map_or(200, |n| n.parse().expect("a number of frames"));
    let camera = CameraSettings::default();
    let pad = Pad::default();
    let mut pipeline = Pipeline::new(&camera, &pad);
    println!(
        "{frames} frames each; tilt sd 3 deg, lateral error sd 4 % of the height, at least 1 cm"
    );
    println!(
        "{:>7} {:>6} | {:>17} | {:>20} {:>20} {:>16} | {:>6} | {:>7} {:>7}",
        "height",
        "fix",
        "seen of each tag",
        "lateral mean sd mm",
        "range mean sd mm",
        "tilt sd max deg",
        "NEES/6",
        "render",
        "detect"
    );
    for height in [
        5.0, 4.0, 3.0, 2.5, 2.0, 1.5, 1.2, 1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2, 0.15, 0.12,
        0.1, 0.08,
    ] {
        let mut seen = vec![0_u64; pad.tags.len()];
        let (mut lateral, mut range, mut tilt, mut nees) = (vec![], vec![], vec![], vec![]);
        let (mut render_s, mut detect_s) = (0.0, 0.0);
        for frame in 0..frames {
            let mut stream = noise(1, frame);
            let spread = 0.04 * f64::min(height, 0.3_f64.max(0.0) + height.min(0.7) * 0.0 + height);
            let spread = if height < 0.3 {
                spread.min(0.01)
            } else {
                spread
            };
            let place = [
                spread * stream.normal(),
                spread * stream.normal(),
                height - camera.place_m[2],
            ];
            let degrees = std::f64::consts::PI / 180.0;
            let angles = [
                std::f64::consts::TAU * stream.uniform(),
                3.0 * degrees * stream.normal(),
                3.0 * degrees * stream.normal(),
            ];
            let view = view_from(&camera, place, angles);
            let start = Instant::now();
            let pixels =
                common::expose(&mut pipeline.renderer, &camera, [&view, &view], &mut stream)
                    .to_vec();
            render_s += start.elapsed().as_secs_f64();
            let start = Instant::now();
            let image = touchdown_vision::GrayImage::new(&pixels, 640, 480, 640).expect("an image");
            let tags = pipeline.detector.detect(&image).expect("a detection");
            let fix = pipeline
                .locator
                .locate(&tags, &common::up(common::normal(&view)));
            detect_s += start.elapsed().as_secs_f64();
            for (count, tag) in seen.iter_mut().zip(&pad.tags) {
                *count += u64::from(tags.iter().any(|found| found.id == tag.id));
            }
            let Some(fix) = fix else { continue };
            let (moved, turned) = errors(&fix, &view);
            lateral.extend([1e3 * moved[0], 1e3 * moved[1]]);
            range.push(1e3 * moved[2]);
            tilt.extend([turned[0] / degrees, turned[1] / degrees]);
            nees.push(consistency(&fix, &view));
        }
        let share = |n: u64| 100.0 * n as f64 / frames as f64;
        let each: Vec<String> = seen.iter().map(|&n| format!("{:5.1}", share(n))).collect();
        let (lm, ls) = moments(&lateral);
        let (rm, rs) = moments(&range);
        let (_, ts) = moments(&tilt);
        let worst = tilt.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let (nm, _) = moments(&nees);
        println!(
            "{height:7.2} {:6.1} | {} | {lm:+9.3} {ls:9.3}   {rm:+9.3} {rs:9.3}   {ts:7.3} {worst:7.2} | {:6.2} | {:7.2} {:7.2}",
            share(range.len() as u64),
            each.join(" "),
            nm / 6.0,
            1e3 * render_s / frames as f64,
            1e3 * detect_s / frames as f64,
        );
    }
}

fn moments(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let var = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (mean, var.sqrt())
}

/// Squared error of the whole pose over its covariance: 6 on average when the
/// covariance is right.
fn consistency(
    fix: &touchdown_vision::Fix,
    view: &touchdown_sim::sensors::camera::view::View,
) -> f64 {
    let (_, turned) = errors(fix, view);
    let mut error = nalgebra::Vector6::zeros();
    for k in 0..3 {
        error[k] = fix.translation_m[k] - view.translation_m[k];
        error[k + 3] = turned[k];
    }
    let covariance = nalgebra::Matrix6::from(fix.covariance);
    covariance
        .cholesky()
        .map_or(f64::NAN, |c| error.dot(&c.solve(&error)))
}
