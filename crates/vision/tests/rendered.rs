//! Detection and pose on rendered images, whose truth is known.

mod common;

use common::{Pipeline, errors, intrinsics, noise, normal, up, vehicle, view_from};
use touchdown_sim::deck::rigid::{Axis, DeckPose, RigidMotion, Tone};
use touchdown_sim::sensors::camera::CameraSettings;
use touchdown_sim::sensors::camera::view::View;
use touchdown_vision::detect::DetectorSettings;
use touchdown_vision::family;
use touchdown_vision::locate::LocatorSettings;
use touchdown_vision::pad::{Pad, PadTag};
use touchdown_vision::render::print::DeckPrint;
use touchdown_vision::{Detector, GrayImage, Hints, Locator};

/// Sharp enough for an exact comparison: the lens's blur, but no noise.
fn still_camera() -> CameraSettings {
    CameraSettings {
        noise_sd: 0.0,
        ..CameraSettings::default()
    }
}

fn single(id: u32, size_m: f64) -> Pad {
    Pad {
        tags: vec![PadTag {
            id,
            size_m,
            centre_m: [0.0; 2],
            yaw_rad: 0.0,
        }],
    }
}

/// A deck with a roll and a pitch.
fn tilted(roll: f64, pitch: f64) -> DeckPose {
    let tone = |axis, angle: f64| Tone {
        axis,
        amplitude: angle.abs(),
        frequency_hz: 0.1,
        phase_rad: std::f64::consts::FRAC_PI_2.copysign(angle),
    };
    let tones = vec![tone(Axis::Roll, roll), tone(Axis::Pitch, pitch)];
    let motion = RigidMotion::Sines { tones };
    motion.build(9.81, 1, 0).expect("a motion").at(0.0)
}

#[test]
fn xval_every_print_is_read_as_its_id_the_right_way_up() {
    let camera = still_camera();
    for (i, id) in family::drawable().enumerate() {
        let pad = single(id, 0.3);
        let mut pipeline = Pipeline::new(&camera, &pad);
        let yaw = 0.37 * i as f64;
        let view = view_from(&camera, [0.05, -0.02, 1.0], [yaw, 0.05, -0.08]);
        let (tags, _) = pipeline.look(&view, &mut noise(1, 0));
        assert_eq!(tags.len(), 1, "id {id}");
        assert_eq!((tags[0].id, tags[0].hamming), (id, 0));
        for (seen, place) in tags[0].corners_px.iter().zip(pad.tags[0].corners_m()) {
            let expected = camera.project(view.point(place)).unwrap();
            let off = (seen[0] - expected[0]).hypot(seen[1] - expected[1]);
            // Cells of 15 px without noise: what the detector's interpolation of
            // a rounded image leaves; half a pixel would be the wrong convention.
            assert!(off < 0.06, "id {id}: {off} px");
        }
    }
}

#[test]
fn analytic_pose_of_a_tilted_deck() {
    let camera = still_camera();
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    for (roll, pitch, place, angles) in [
        (0.0, 0.0, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]),
        (0.15, -0.1, [0.1, 0.05, 0.9], [0.3, 0.05, -0.04]),
        (-0.2, 0.2, [-0.1, 0.1, 1.1], [-2.0, -0.1, 0.1]),
        (0.05, 0.25, [0.0, 0.01, 0.2], [1.2, 0.0, 0.1]),
    ] {
        let deck = tilted(roll, pitch);
        let view = View::of(&camera, &vehicle(place, angles), &deck);
        let (_, fix) = pipeline.look(&view, &mut noise(1, 0));
        let fix = fix.expect("a pad in view");
        let (moved, turned) = errors(&fix, &view);
        let height = place[2];
        for k in 0..3 {
            // A corner error of 0.02 px over tags of 80 px and more: 1/4000 of
            // the range, and 1/300 rad of tilt, for lateral error is tilt times range.
            assert!(moved[k].abs() < 0.003 * height, "{moved:?} at {height} m");
            assert!(turned[k].abs() < 0.003, "{turned:?}");
        }
        assert!((fix.normal()[2] - normal(&view)[2]).abs() < 0.001);
    }
}

#[test]
fn prop_a_tag_is_in_view_from_three_metres_to_contact() {
    let camera = CameraSettings::default();
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    let mut height = 3.0;
    let mut frame = 0;
    while height > 0.08 {
        let mut stream = noise(3, frame);
        // Up to 2 cm and 3 % of the height to the side, and 5 degrees of tilt.
        let mut uniform = |most: f64| most * (2.0 * stream.uniform() - 1.0);
        let side = 0.01_f64.max(0.03 * height);
        let place = [uniform(side), uniform(side), height + 0.02];
        let angles = [uniform(3.0), uniform(0.06), uniform(0.06)];
        let view = view_from(&camera, place, angles);
        let (tags, fix) = pipeline.look(&view, &mut stream);
        let fix = fix.unwrap_or_else(|| panic!("nothing seen at {height} m"));
        assert!(
            fix.tags == tags.len() && !fix.ambiguous,
            "{height} m: {tags:?}"
        );
        let (moved, _) = errors(&fix, &view);
        // 1 % of the range and 3 % to the side: five standard deviations at 3 m,
        // far more below.
        assert!(moved[2].abs() < 0.01 * height, "{moved:?} at {height} m");
        assert!(
            moved[0].hypot(moved[1]) < 0.03 * height,
            "{moved:?} at {height} m"
        );
        height *= 0.97;
        frame += 1;
    }
}

#[test]
fn prop_covariance_says_how_wrong_it_is() {
    let camera = CameraSettings::default();
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    for height in [2.0, 1.0, 0.5, 0.2] {
        let mut sum = 0.0;
        let frames = 60;
        for frame in 0..frames {
            let mut stream = noise(5, frame);
            let place = [
                0.03 * height * stream.normal(),
                0.03 * height * stream.normal(),
                height + 0.02,
            ];
            let angles = [
                6.0 * stream.uniform(),
                0.05 * stream.normal(),
                0.05 * stream.normal(),
            ];
            let view = view_from(&camera, place, angles);
            let (_, fix) = pipeline.look(&view, &mut stream);
            let fix = fix.expect("a pad in view");
            let (moved, _) = errors(&fix, &view);
            let covariance = nalgebra::Matrix3::from(fix.camera_covariance_m2());
            let error = nalgebra::Vector3::from(moved);
            let factor = covariance.cholesky().expect("a covariance");
            sum += error.dot(&factor.solve(&error)) / 3.0;
        }
        let mean = sum / frames as f64;
        // 1 when it is right. The corners' model has two numbers for all sizes
        // and blurs, so a factor of two in standard deviation, five down.
        assert!((0.04..4.0).contains(&mean), "{mean} at {height} m");
    }
}

#[test]
fn prop_a_tag_cut_by_the_image_is_left_out() {
    let camera = CameraSettings::default();
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    // The large tag reaches over the image's upper edge, the middle one is whole.
    let view = view_from(&camera, [-0.25, 0.0, 0.62], [0.0; 3]);
    let (tags, fix) = pipeline.look(&view, &mut noise(1, 0));
    let ids: Vec<u32> = tags.iter().map(|tag| tag.id).collect();
    assert!(ids.contains(&323) && !ids.contains(&77), "{ids:?}");
    let (moved, _) = errors(&fix.expect("the middle tag"), &view);
    // A tag of 53 px at 0.6 m: about a twentieth of a pixel, 1e-3 of the range;
    // to the side through the tilt, 1 degree. Five times that.
    assert!(
        moved[2].abs() < 3e-3 && moved[0].hypot(moved[1]) < 0.05,
        "{moved:?}"
    );
}

#[test]
fn prop_no_tag_is_no_fix_and_no_error() {
    let camera = CameraSettings::default();
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    for (place, angles) in [
        // Beside the pad, upside down, much too far away, below the deck.
        ([3.0, 0.0, 1.0], [0.0; 3]),
        ([0.0, 0.0, 1.0], [0.0, 0.0, 3.1]),
        ([0.0, 0.0, 40.0], [0.0; 3]),
        ([0.0, 0.0, -1.0], [0.0; 3]),
    ] {
        let view = view_from(&camera, place, angles);
        let (tags, fix) = pipeline.look(&view, &mut noise(1, 0));
        assert!(tags.is_empty() && fix.is_none(), "{place:?}");
    }
}

#[test]
fn prop_heavy_noise_and_uneven_light_are_withstood() {
    let camera = CameraSettings {
        noise_sd: 12.0,
        white_level: 140.0,
        gradient: [0.6, -0.4],
        ..CameraSettings::default()
    };
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    for frame in 0..20 {
        let view = view_from(&camera, [0.02, 0.01, 1.0], [0.3 * frame as f64, 0.03, 0.02]);
        let (_, fix) = pipeline.look(&view, &mut noise(2, frame));
        let (moved, _) = errors(&fix.expect("a pad in view"), &view);
        // Noise of a tenth of the contrast: a fifth of a pixel over 160 px.
        assert!(moved[2].abs() < 0.005, "{moved:?}");
    }
}

#[test]
fn analytic_a_moving_tag_is_where_it_is_in_the_middle_of_the_exposure() {
    let camera = still_camera();
    let mut pipeline = Pipeline::new(&camera, &single(77, 0.4));
    // 1 m/s for 8 ms at 1 m: 3.2 px along the image.
    let at = |s: f64| view_from(&camera, [0.008 * (s - 0.5), 0.0, 1.0], [0.4, 0.0, 0.0]);
    let tags = pipeline.detect(&at(0.0), &at(1.0), &mut noise(1, 0));
    assert_eq!(tags.len(), 1);
    for (seen, place) in tags[0]
        .corners_px
        .iter()
        .zip(pipeline.locator.pad().tags[0].corners_m())
    {
        let expected = camera.project(at(0.5).point(place)).unwrap();
        let off = (seen[0] - expected[0]).hypot(seen[1] - expected[1]);
        // A tenth of the blur.
        assert!(off < 0.3, "{off} px");
    }
}

#[test]
fn prop_same_seed_same_answer_for_any_number_of_threads() {
    let camera = CameraSettings::default();
    let view = view_from(&camera, [0.02, 0.01, 0.7], [0.5, 0.03, 0.02]);
    let look = |seed, threads| {
        let settings = DetectorSettings {
            threads,
            ..DetectorSettings::default()
        };
        Pipeline::with(&camera, &Pad::default(), &settings).look(&view, &mut noise(seed, 0))
    };
    let first = look(1, 1);
    assert_eq!(first, look(1, 1));
    assert_eq!(first, look(1, 2));
    assert_ne!(first, look(2, 1));
}

#[test]
fn analytic_two_poses_of_a_far_tag() {
    // Corners exactly as a small tilted tag shows them: rounding decides nothing,
    // but a hundredth of a pixel does not either.
    let camera = still_camera();
    let pad = single(77, 0.1);
    let settings = LocatorSettings::default();
    let locator = Locator::new(&intrinsics(&camera), &pad, &settings).unwrap();
    let view = view_from(&camera, [0.5, 0.4, 3.0], [0.0, 0.1, -0.1]);
    let tag = touchdown_vision::Detection {
        id: 77,
        corners_px: pad.tags[0]
            .corners_m()
            .map(|place| camera.project(view.point(place)).unwrap()),
        hamming: 0,
    };
    let alone = locator.locate(&[tag], &Hints::default()).unwrap();
    assert!(alone.ambiguous);
    // The covariance then holds the mirrored pose: half of (2 × 0.22 rad)².
    let tilt = alone.covariance[3][3] + alone.covariance[4][4];
    assert!(tilt > 0.3 * 0.44 * 0.44, "{tilt}");
    // Told roughly where up is (6 degrees off), it takes the right one of both.
    for [dx, dy] in [[0.0, 0.0], [0.1, 0.0], [-0.1, 0.0], [0.0, 0.1], [0.0, -0.1]] {
        let [x, y, z] = normal(&view);
        let told = locator.locate(&[tag], &up([x + dx, y + dy, z])).unwrap();
        assert!(!told.ambiguous);
        let (_, turned) = errors(&told, &view);
        // Corners are exact: rounding, amplified by the flat valley between the poses.
        assert!(turned.iter().all(|angle| angle.abs() < 1e-3), "{turned:?}");
    }
    let nan = locator.locate(&[tag], &up([f64::NAN, 0.0, 1.0])).unwrap();
    assert!(nan.ambiguous);
}

#[test]
fn prop_a_tag_that_contradicts_the_others_is_left_out() {
    let camera = CameraSettings::default();
    let mut pipeline = Pipeline::new(&camera, &Pad::default());
    let view = view_from(&camera, [0.0, 0.0, 0.8], [0.0; 3]);
    let (mut tags, fix) = pipeline.look(&view, &mut noise(1, 0));
    assert!(fix.is_some_and(|fix| fix.tags == 2));
    // The middle tag somewhere else, as another's pad would show it.
    let moved = tags.iter_mut().find(|tag| tag.id == 323).unwrap();
    for corner in &mut moved.corners_px {
        corner[0] += 90.0;
    }
    let fix = pipeline.locator.locate(&tags, &up(normal(&view))).unwrap();
    assert_eq!(fix.tags, 1);
    let (moved, _) = errors(&fix, &view);
    assert!(moved[2].abs() < 0.005, "{moved:?}");
    // Corners that are no quadrangle's, or no numbers, are no fix.
    tags.retain(|tag| tag.id == 77);
    tags[0].corners_px[2] = [f64::NAN, 1.0];
    assert!(pipeline.locator.locate(&tags, &Hints::default()).is_none());
    tags[0].corners_px = [[10.0, 10.0]; 4];
    assert!(pipeline.locator.locate(&tags, &Hints::default()).is_none());
    tags[0].corners_px = [[10.0, 10.0], [20.0, 10.0], [30.0, 10.0], [40.0, 10.0]];
    assert!(pipeline.locator.locate(&tags, &Hints::default()).is_none());
}

#[test]
fn prop_what_cannot_be_is_refused() {
    let camera = CameraSettings::default();
    let view = view_from(&camera, [0.0, f64::NAN, 1.0], [0.0; 3]);
    let fine = view_from(&camera, [0.0, 0.0, 1.0], [0.0; 3]);
    let refused = |open: &View, shut: &View| {
        let error = open.exposure(shut, &camera).unwrap_err();
        error.to_string()
    };
    assert!(refused(&view, &fine).contains("NaN") && refused(&fine, &view).contains("NaN"));
    assert!(GrayImage::new(&[], 0, 0, 0).is_err());
    let settings = DetectorSettings {
        max_hamming: 6,
        ..DetectorSettings::default()
    };
    let error = Detector::new(&settings).unwrap_err().to_string();
    assert!(
        error.contains("max_hamming") && error.contains('6'),
        "{error}"
    );
    let mut bad = intrinsics(&camera);
    bad.focal_px[1] = 0.0;
    let settings = LocatorSettings::default();
    let error = Locator::new(&bad, &Pad::default(), &settings)
        .unwrap_err()
        .to_string();
    assert!(error.contains("focal_px"), "{error}");
    // The smallest image there is, and a print for it.
    let small = CameraSettings {
        width_px: 32,
        height_px: 32,
        principal_px: [16.0, 16.0],
        ..camera
    };
    assert!(
        DeckPrint::of(&Pad::default())
            .and_then(|print| print.validate())
            .is_ok()
    );
    let mut pipeline = Pipeline::new(&small, &Pad::default());
    assert!(pipeline.look(&fine, &mut noise(1, 0)).1.is_none());
}
