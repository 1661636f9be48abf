//! The rendered image against projection and photometry in closed form.

mod common;

use common::{expose, image, intrinsics, renderer};
use touchdown_sim::body::rigid::RigidState;
use touchdown_sim::deck::rigid::DeckPose;
use touchdown_sim::random::{Purpose, Stream};
use touchdown_sim::sensors::camera::CameraSettings;
use touchdown_sim::sensors::camera::view::View;
use touchdown_vision::family::CELLS;
use touchdown_vision::render::Renderer;
use touchdown_vision::render::print::{DeckPrint, PrintedTag};

fn view(camera: &CameraSettings, position_m: [f64; 3], attitude: [f64; 4]) -> View {
    let vehicle = RigidState {
        position_m,
        attitude,
        ..RigidState::default()
    };
    View::of(camera, &vehicle, &DeckPose::default())
}

/// Turned by small angles about x and y and by one about z.
fn attitude(roll: f64, pitch: f64, yaw: f64) -> [f64; 4] {
    let (s, c) = (0.5 * yaw).sin_cos();
    let q = [
        c,
        0.5 * (roll * c - pitch * s),
        0.5 * (pitch * c + roll * s),
        s,
    ];
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / norm)
}

fn bare() -> CameraSettings {
    CameraSettings {
        place_m: [0.0; 3],
        noise_sd: 0.0,
        lens_sd_px: 0.0,
        ..CameraSettings::default()
    }
}

/// A square that is all black on a deck so large that it fills the image.
fn black_square(size_m: f64) -> DeckPrint {
    let tag = PrintedTag {
        cells: [[false; CELLS]; CELLS],
        size_m,
        centre_m: [0.03, -0.02],
        yaw_rad: 0.2,
    };
    DeckPrint {
        side_m: 100.0,
        white: 0.9,
        deck: 0.9, // no edge between margin and deck
        ..DeckPrint::new(vec![tag])
    }
}

fn stream() -> Stream {
    Stream::new(1, 0, Purpose::Camera)
}

#[test]
fn analytic_a_square_has_its_area_and_its_place() {
    let camera = CameraSettings {
        // White is level 234 and black level 13: even areas are not rounded.
        white_level: 260.0,
        ..bare()
    };
    let print = black_square(0.1);
    for (lens, turned) in [
        (0.0, attitude(0.0, 0.0, 0.0)),
        (0.8, attitude(0.0, 0.0, 0.7)),
        (0.8, attitude(0.15, -0.1, 0.7)),
    ] {
        let camera = CameraSettings {
            lens_sd_px: lens,
            ..camera
        };
        let view = view(&camera, [0.0, 0.0, 0.5], turned);
        let mut renderer = renderer(&camera, &print);
        let pixels = expose(&mut renderer, &camera, [&view, &view], &mut stream());
        // Light that is missing, and its first moments.
        let (white, black) = (234.0, 13.0);
        let (mut sum, mut at) = (0.0, [0.0; 2]);
        for (i, &pixel) in pixels.iter().enumerate() {
            let missing = (white - f64::from(pixel)) / (white - black);
            sum += missing;
            at[0] += missing * ((i % 640) as f64 + 0.5);
            at[1] += missing * ((i / 640) as f64 + 0.5);
        }
        // Area and centroid of the projected quadrangle, by the shoelace formula.
        let corners = print.tags[0]
            .corners_m(0.0)
            .map(|corner| camera.project(view.point(corner)).unwrap());
        let (mut area, mut centre) = (0.0, [0.0; 2]);
        for (k, a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % 4];
            let part = 0.5 * (a[0] * b[1] - a[1] * b[0]);
            area += part;
            for axis in 0..2 {
                centre[axis] += part * (a[axis] + b[axis]) / 3.0;
            }
        }
        // Rounding by up to half of 221 levels over the edge's pixels (320, or
        // 2000 with the lens): 0.0013 √n, five times.
        assert!((sum - area).abs() < 0.3, "{sum} and {area}");
        for axis in 0..2 {
            let found = at[axis] / sum;
            let off = found - centre[axis] / area;
            // 0.06 px² of rounding at 40 px from the middle, over 6400 px²: 4e-4; five times.
            assert!(off.abs() < 2e-3, "{off} px");
        }
    }
}

#[test]
fn analytic_levels_gradient_and_what_is_beside() {
    let camera = CameraSettings {
        gradient: [0.4, -0.2],
        ..bare()
    };
    let print = DeckPrint {
        side_m: 100.0,
        ..DeckPrint::new(vec![])
    };
    let mut renderer = renderer(&camera, &print);
    let above = view(&camera, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]);
    let pixels = expose(&mut renderer, &camera, [&above, &above], &mut stream());
    for (x, y) in [(0, 0), (639, 0), (320, 240), (100, 479)] {
        let lit =
            1.0 + 0.4 * ((x as f64 + 0.5) / 640.0 - 0.5) - 0.2 * ((y as f64 + 0.5) / 480.0 - 0.5);
        let expected = 220.0 * 0.45 * lit;
        // Rounding to whole levels.
        assert!((f64::from(pixels[640 * y + x]) - expected).abs() <= 0.51);
    }
    let below = view(&camera, [0.0, 0.0, -1.0], [1.0, 0.0, 0.0, 0.0]);
    let pixels = expose(&mut renderer, &camera, [&below, &below], &mut stream());
    let middle = f64::from(pixels[640 * 240 + 320]);
    assert!((middle - 220.0 * 0.25).abs() <= 0.51, "{middle}");
}

#[test]
fn analytic_motion_smears_an_edge_evenly() {
    let camera = bare();
    let mut renderer = renderer(&camera, &black_square(0.4));
    // 20 mm along x at 1 m: 8 px up or down in the image; the square turned back level.
    let at = |x: f64| view(&camera, [x, 0.0, 1.0], attitude(0.0, 0.0, 0.2));
    let (open, shut) = (at(0.0), at(0.02));
    let motion = open.motion_px(&shut, &camera);
    // Of a plane seen at right angles everything moves alike.
    assert!((motion - 8.0).abs() < 1e-6, "{motion}");
    let pixels = expose(&mut renderer, &camera, [&open, &shut], &mut stream());
    // Across the edges that are at right angles to most of the motion: the sum
    // of what is missing along a column stays that of the unmoved square.
    let column: Vec<f64> = (0..480).map(|y| f64::from(pixels[640 * y + 325])).collect();
    let partly = column
        .iter()
        .filter(|&&grey| grey > 12.0 && grey < 197.0)
        .count();
    // Two edges of 8 cos(0.2) = 7.8 px, each touching up to 9 pixels.
    assert!((14..=18).contains(&partly), "{partly}");
    let missing: f64 = column.iter().map(|grey| (198.0 - grey) / 187.0).sum();
    // 160 px; rounding of even levels is 0.5/187 of it.
    assert!((missing - 160.0).abs() < 0.6, "{missing}");
}

#[test]
fn analytic_noise_has_its_standard_deviation_and_seed() {
    let camera = CameraSettings {
        noise_sd: 3.0,
        ..bare()
    };
    let print = DeckPrint {
        side_m: 100.0,
        ..DeckPrint::new(vec![])
    };
    let mut renderer = renderer(&camera, &print);
    let above = view(&camera, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]);
    let mut shoot = |seed| {
        let mut stream = Stream::new(seed, 0, Purpose::Camera);
        expose(&mut renderer, &camera, [&above, &above], &mut stream).to_vec()
    };
    let pixels = shoot(1);
    let n = pixels.len() as f64;
    let mean = pixels.iter().map(|&p| f64::from(p)).sum::<f64>() / n;
    let variance = pixels
        .iter()
        .map(|&p| (f64::from(p) - mean).powi(2))
        .sum::<f64>()
        / n;
    // 307 200 pixels: the mean's error is 0.0054, the variance's 0.023; rounding
    // adds 1/12. Five of each.
    assert!((mean - 99.0).abs() < 0.03, "{mean}");
    assert!((variance - 9.0 - 1.0 / 12.0).abs() < 0.12, "{variance}");
    assert_eq!(pixels, shoot(1));
    assert_ne!(pixels, shoot(2));
}

#[test]
fn prop_cameras_that_cannot_be_are_refused() {
    let print = DeckPrint::new(vec![]);
    let refused = |change: fn(&mut CameraSettings)| {
        let mut camera = CameraSettings::default();
        change(&mut camera);
        let error = Renderer::new(&intrinsics(&camera), &image(&camera), &print);
        error.map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(|c| c.width_px = 0).contains("width_px"));
    assert!(refused(|c| c.height_px = 0).contains("height_px"));
    assert!(refused(|c| c.focal_px[0] = -400.0).contains("-400"));
    assert!(refused(|c| c.principal_px[1] = 481.0).contains("481"));
    assert!(refused(|c| c.noise_sd = f64::NAN).contains("NaN"));
    assert!(refused(|c| c.lens_sd_px = 1e9).contains("lens_sd_px"));
    let exposure = CameraSettings {
        exposure_s: -1.0,
        ..CameraSettings::default()
    };
    let error = exposure.validate().unwrap_err().to_string();
    assert!(error.contains("exposure_s"), "{error}");
}
