//! Images with a known pose, rendered and written to files: what the camera's pipeline finds in them.

use touchdown_flight::{Attitude, Vector};
use touchdown_link::camera::report::{CameraReport, DeckFix, FrameReport};
use touchdown_link::camera::{CameraSettings, Frame, FrameError, Pipeline, files};
use touchdown_vision::camera::Pose;
use touchdown_vision::render::print::DeckPrint;
use touchdown_vision::render::{ImageSettings, Renderer};

/// Lens blur and noise of the images on which the detector's errors were measured.
const IMAGE: ImageSettings = ImageSettings {
    lens_sd_px: 0.6,
    white_level: 220.0,
    gradient: [0.0; 2],
    noise_sd: 2.0,
};

/// Numbers of the distribution N(0, 1), near enough: the sum of twelve uniform ones less six.
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    }
}

/// The image that a vehicle of an attitude takes at a place above a level deck.
fn image(
    settings: &CameraSettings,
    place_m: [f64; 3],
    attitude: Attitude<f64>,
    seed: u64,
) -> Frame {
    let axes = settings.axes().map(|axis| attitude.rotate(axis));
    let lens =
        attitude.rotate(Vector::from_array(settings.position_m)) + Vector::from_array(place_m);
    let pose = Pose {
        rotation: axes.map(Vector::to_array),
        translation_m: axes.map(|axis| -axis.dot(lens)),
    };
    let print = DeckPrint::of(&settings.pad).unwrap();
    let mut renderer = Renderer::new(&settings.intrinsics(), &IMAGE, &print).unwrap();
    Frame {
        pixels: renderer.expose(&[pose], normal(seed)).to_vec(),
        size_px: settings.size_px(),
        stamp_us: None,
    }
}

/// The error of a fix, m: along the body's axes.
fn error(fix: &DeckFix, place_m: [f64; 3], attitude: Attitude<f64>) -> Vector<f64> {
    let truth = attitude.unrotate(Vector::from_array(place_m)) * -1.0;
    Vector::from_array(fix.position_m) - truth
}

/// Cameras: that of the simulation, one beside the vehicle's middle with its top to the left, and one that leans.
fn cameras() -> [CameraSettings; 3] {
    let standard = CameraSettings::default();
    [
        standard.clone(),
        CameraSettings {
            position_m: [0.08, -0.05, -0.03],
            turn_rad: std::f64::consts::FRAC_PI_2,
            ..standard.clone()
        },
        CameraSettings {
            lean_rad: [0.2, -0.1],
            focal_px: [350.0, 360.0],
            principal_px: [310.0, 250.0],
            ..standard
        },
    ]
}

#[test]
fn analytic_the_deck_is_where_it_was_rendered_for_every_mounting_and_file_format() {
    for (k, settings) in cameras().iter().enumerate() {
        let mut pipeline = Pipeline::new(settings).unwrap();
        for height_m in [2.0, 1.0, 0.5, 0.2] {
            let tilt = Vector::new(0.04, -0.03, 0.0);
            let attitude = Attitude::from_rotation_vector(tilt) * Attitude::from_yaw(0.7);
            let place_m = [0.02 * height_m, -0.03 * height_m, height_m + 0.03];
            let frame = image(settings, place_m, attitude, k as u64);
            let png = files::encode_png(&frame).unwrap();
            let pgm = files::encode_pgm(&frame);
            let mut fixes = [png, pgm].map(|bytes| {
                let folder = tempfile::tempdir().unwrap();
                let path = folder.path().join("image");
                std::fs::write(&path, bytes).unwrap();
                let read =
                    files::decode(&std::fs::read(&path).unwrap(), settings.size_px()).unwrap();
                assert_eq!(read.pixels, frame.pixels);
                pipeline
                    .locate(&read, 0, Some(attitude))
                    .unwrap()
                    .expect("a pad in view")
            });
            assert_eq!(fixes[0], fixes[1]);
            let fix = &mut fixes[0];
            let off = error(fix, place_m, attitude);
            // The bounds of the detector's own test from three metres to contact: 1 % of the range, 3 % to the side.
            let up = attitude.unrotate(Vector::UP);
            let along = off.dot(up);
            assert!(
                along.abs() < 0.01 * height_m,
                "camera {k}, {height_m} m: {off:?}"
            );
            assert!(
                (off - up * along).norm() < 0.03 * height_m,
                "camera {k}, {height_m} m: {off:?}"
            );
            // Five standard deviations as the fix states them, whose model is right within a factor of two.
            let variance: f64 = (0..3).map(|i| fix.covariance_m2[i][i]).sum();
            assert!(
                off.norm() < 10.0 * variance.sqrt(),
                "{off:?}, {}",
                variance.sqrt()
            );
            assert!(
                Vector::from_array(fix.normal).dot(up) > 0.99,
                "{:?}",
                fix.normal
            );
        }
    }
}

#[test]
fn prop_covariances_turn_with_the_camera() {
    // The error along the view is not that across it: a camera that looks to another side has it along other axes.
    let trace = |settings: &CameraSettings| {
        let frame = image(settings, [0.0, 0.0, 1.0], Attitude::default(), 3);
        let fix = Pipeline::new(settings)
            .unwrap()
            .locate(&frame, 0, None)
            .unwrap()
            .unwrap();
        fix.covariance_m2
    };
    let [standard, turned, _] = cameras();
    let same_place = CameraSettings {
        position_m: standard.position_m,
        ..turned
    };
    let (a, b) = (trace(&standard), trace(&same_place));
    // Other pixels see the tag, so equal within a few per cent.
    assert!((a[0][0] / b[1][1] - 1.0).abs() < 0.2, "{a:?} {b:?}");
    assert!((a[2][2] / b[2][2] - 1.0).abs() < 0.2, "{a:?} {b:?}");
    assert!(a[0][1].abs() < a[0][0] && (a[0][2] - a[2][0]).abs() < 1e-15);
}

#[test]
fn prop_motion_between_frames_lowers_the_confidence_and_a_gap_does_not() {
    let settings = CameraSettings::default();
    let here = image(&settings, [0.0, 0.0, 1.0], Attitude::default(), 1);
    let there = image(&settings, [0.12, 0.0, 1.0], Attitude::default(), 2);
    let after = |gap_us: i64| {
        let mut pipeline = Pipeline::new(&settings).unwrap();
        pipeline.locate(&here, 1_000_000, None).unwrap();
        let fix = pipeline.locate(&there, 1_000_000 + gap_us, None).unwrap();
        fix.expect("a pad in view").covariance_m2[0][0]
    };
    // 48 px within 30 ms are 6.4 px in an exposure of 4 ms; after 2 s nobody knows the speed.
    assert!(after(30_000) > 4.0 * after(2_000_000));
    assert_eq!(
        after(0),
        after(-5),
        "stamps that do not increase give no motion"
    );
}

#[test]
fn prop_images_without_a_pad_of_another_size_or_without_pixels_make_no_panic() {
    let settings = CameraSettings::default();
    let mut pipeline = Pipeline::new(&settings).unwrap();
    let frame = |pixels, size_px| Frame {
        pixels,
        size_px,
        stamp_us: None,
    };
    let empty = frame(vec![128; 640 * 480], [640, 480]);
    assert_eq!(pipeline.locate(&empty, 0, None), Ok(None));
    let dot = frame(vec![1], [1, 1]);
    assert!(matches!(
        pipeline.locate(&dot, 0, None),
        Err(FrameError::Size { .. })
    ));
    let short = frame(vec![128; 7], [640, 480]);
    assert!(pipeline.locate(&short, 0, None).is_err());
    let mut noise = normal(9);
    let pixels = (0..640 * 480)
        .map(|_| (128.0 + 60.0 * noise()) as u8)
        .collect();
    assert_eq!(
        pipeline.locate(&frame(pixels, [640, 480]), 0, None),
        Ok(None)
    );
}

#[test]
fn prop_reports_come_back_from_the_recording_bit_for_bit() {
    let mut noise = normal(4);
    let mut number = || noise() * 1e-3 / 3.0;
    for k in 0..200 {
        let deck = DeckFix {
            position_m: [number(), number(), number()],
            covariance_m2: [[number(); 3]; 3],
            normal: [number(); 3],
            tags: k,
            residual_px: number(),
        };
        let frame = FrameReport {
            exposed_us: (k % 2 == 0).then_some(-5),
            arrived_us: i64::MAX,
            size_px: [640, 480],
            dropped: u64::MAX,
            unreadable: 0,
            deck: (k % 3 != 0).then_some(deck),
        };
        let report = CameraReport::Frame(frame);
        assert_eq!(
            CameraReport::from_json(report.to_json().as_bytes()),
            Some(report)
        );
    }
    let gone = CameraReport::Gone("`v4l2-ctl`: it ended \u{1F4F7}".to_string());
    assert_eq!(
        CameraReport::from_json(gone.to_json().as_bytes()),
        Some(gone)
    );
    assert_eq!(CameraReport::from_json(b"{\"frame\": {}}"), None);
}
