//! The fast camera against the geometry of a square seen at right angles.

use touchdown_sim::body::rigid::RigidState;
use touchdown_sim::deck::rigid::DeckPose;
use touchdown_sim::random::{Purpose, Stream};
use touchdown_sim::sensors::camera::CameraSettings;
use touchdown_sim::sensors::camera::errors::ErrorModel;
use touchdown_sim::sensors::camera::fast::{CameraFix, DeckTag, FastCamera, LocationSettings};
use touchdown_sim::sensors::camera::view::View;

/// A tag of 0.2 m; seen from 1 m its side is 80 px.
const SIDE_PX: f64 = 80.0;

/// The same errors for all sizes and motions.
fn model(found: f64, numbers: [f64; 6]) -> ErrorModel {
    let mut text = "nested,cell_px,motion_px,found,scale_mean_px,shift_px,scale_px,turn_px,\
                    stretch_px,keystone_px\n"
        .to_owned();
    for (nested, cell, motion) in (0..8).map(|i| (i / 4, 1 + i / 2 % 2, i % 2)) {
        let numbers = numbers.map(|x| x.to_string()).join(",");
        text += &format!("{nested},{cell},{motion},{found},{numbers}\n");
    }
    ErrorModel::from_csv(&text).unwrap()
}

fn camera(errors: &ErrorModel) -> FastCamera {
    let camera = CameraSettings {
        place_m: [0.0; 3],
        ..CameraSettings::default()
    };
    let tag = DeckTag {
        size_m: 0.2,
        centre_m: [0.0; 2],
        yaw_rad: 0.0,
        nested: false,
    };
    FastCamera::new(&camera, &[tag], &LocationSettings::default(), errors).unwrap()
}

fn view(position_m: [f64; 3]) -> View {
    let camera = CameraSettings {
        place_m: [0.0; 3],
        ..CameraSettings::default()
    };
    let vehicle = RigidState {
        position_m,
        ..RigidState::default()
    };
    View::of(&camera, &vehicle, &DeckPose::default())
}

fn looks(errors: &ErrorModel, n: u64) -> Vec<Option<CameraFix>> {
    let (camera, above) = (camera(errors), view([0.0, 0.0, 1.0]));
    let look = |i| camera.look(&above, &above, &mut Stream::new(1, i, Purpose::Camera));
    (0..n).map(|i| look(i).unwrap()).collect()
}

#[test]
fn analytic_without_errors_the_pose_is_exact_and_its_covariance_the_geometry() {
    let fix = looks(&model(1.0, [0.0; 6]), 1)[0].unwrap();
    let truth = view([0.0, 0.0, 1.0]);
    assert_eq!(fix.view, truth);
    // Four corners at 40 px to each side: the range moves all eight coordinates
    // by 40 px/m, a turn all corners by 56.6 px/rad: sd = σ/(√2 side).
    let expected = (0.03 / (2.0_f64.sqrt() * SIDE_PX)).powi(2);
    // Rounding only.
    assert!((fix.covariance[2][2] / expected - 1.0).abs() < 1e-9);
    assert!((fix.covariance[5][5] / expected - 1.0).abs() < 1e-9);
    for i in 0..6 {
        for j in 0..6 {
            let skew = fix.covariance[i][j] - fix.covariance[j][i];
            assert!(skew.abs() < 1e-9 * fix.covariance[0][0]);
        }
    }
}

#[test]
fn analytic_a_larger_image_is_a_nearer_deck() {
    // The mode's length is that of eight coordinates: half of it per corner,
    // over a half diagonal of side/√2.
    let fix = looks(&model(1.0, [0.4, 0.0, 0.0, 0.0, 0.0, 0.0]), 1)[0].unwrap();
    let nearer = 0.4 / (2.0_f64.sqrt() * SIDE_PX);
    let found = 1.0 - fix.view.translation_m[2];
    // First order: 0.35 % of a change of 0.35 %.
    assert!((found / nearer - 1.0).abs() < 0.005, "{found}");
    assert!(fix.view.translation_m[0].abs() < 1e-12);
}

#[test]
fn analytic_spread_of_every_mode() {
    let n = 4000;
    let spread = |mode: usize| {
        let mut numbers = [0.0; 6];
        numbers[1 + mode] = 0.1;
        let fixes = looks(&model(1.0, numbers), n);
        let mut squares = [0.0; 6];
        for fix in fixes.iter().flatten() {
            let [x, y, z] = fix.view.translation_m;
            let r = fix.view.rotation;
            let truth = view([0.0, 0.0, 1.0]).rotation;
            // Turn about the camera's axes, from R Rᵀ_true.
            let at = |i: usize, j: usize| (0..3).map(|k| r[i][k] * truth[j][k]).sum::<f64>();
            let errors = [x, y, z - 1.0, at(2, 1), at(0, 2), at(1, 0)];
            for (sum, error) in squares.iter_mut().zip(errors) {
                *sum += error * error;
            }
        }
        squares.map(|sum| (sum / n as f64).sqrt())
    };
    // The sd of an sd over 4000 draws is 1.1 %: four of them.
    let close = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.045;
    // Second order: (0.05 px over 56 px)², far below the 1e-4 and more of the rest.
    let nothing = |found: f64| found < 5e-6;
    let by_length = 0.1 / (2.0_f64.sqrt() * SIDE_PX);
    let [x, y, z, about_x, about_y, about_z] = spread(0);
    // All corners by 0.1/2 px at 400 px/m, and nothing else.
    assert!(close(x, 0.05 / 400.0) && close(y, 0.05 / 400.0), "{x} {y}");
    assert!([z, about_x, about_y, about_z].into_iter().all(nothing));
    let [x, y, z, about_x, about_y, about_z] = spread(1);
    assert!(close(z, by_length), "{z}");
    assert!([x, y, about_x, about_y, about_z].into_iter().all(nothing));
    let [x, y, z, about_x, about_y, about_z] = spread(2);
    assert!(close(about_z, by_length), "{about_z}");
    assert!([x, y, z, about_x, about_y].into_iter().all(nothing));
    assert!(spread(3).into_iter().all(nothing));
    let [x, y, z, about_x, about_y, about_z] = spread(4);
    // A tilt θ moves corners by 400 θ (0.1 m)² = 4 px/rad along one axis in the
    // keystone pattern (and all alike, which a shift takes back).
    assert!(
        close(about_x, 0.05 / 4.0) && close(about_y, 0.05 / 4.0),
        "{about_x} {about_y}"
    );
    assert!(x > 0.0 && y > 0.0 && [z, about_z].into_iter().all(|e| e < 1e-3));
}

#[test]
fn analytic_share_that_is_found_and_the_gate() {
    let n = 10_000;
    let fixes = looks(&model(0.3, [0.0; 6]), n);
    let share = fixes.iter().flatten().count() as f64 / n as f64;
    // Binomial: 0.0046; four of it.
    assert!((share - 0.3).abs() < 0.019, "{share}");
    // Stretch is all residual: 2 px root mean square over four corners is
    // passed by two of N(0, 4 px) with probability exp(-16/32).
    let fixes = looks(&model(1.0, [0.0, 0.0, 0.0, 0.0, 4.0, 0.0]), n);
    let share = fixes.iter().flatten().count() as f64 / n as f64;
    assert!((share - (1.0 - (-0.5_f64).exp())).abs() < 0.02, "{share}");
    // What passes says by its covariance that it fits badly.
    let still = (0.03 / (2.0_f64.sqrt() * SIDE_PX)).powi(2);
    let stated = fixes.iter().flatten().map(|fix| fix.covariance[2][2]);
    assert!(stated.sum::<f64>() / (share * n as f64) > 100.0 * still);
}

#[test]
fn prop_what_is_not_in_view_is_not_found_and_takes_as_many_draws() {
    let camera = camera(&ErrorModel::fitted().unwrap());
    let after = |position: [f64; 3]| {
        let mut stream = Stream::new(4, 0, Purpose::Camera);
        let view = view(position);
        let fix = camera.look(&view, &view, &mut stream).unwrap();
        (fix.is_some(), stream.uniform())
    };
    let (seen, next) = after([0.0, 0.0, 1.0]);
    assert!(seen);
    // Cut by the border, beside it, below the deck, too far away.
    for position in [
        [0.52, 0.0, 1.0],
        [5.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        [0.0, 0.0, 30.0],
    ] {
        assert_eq!(after(position), (false, next), "{position:?}");
    }
    let nan = view([f64::NAN, 0.0, 1.0]);
    let mut stream = Stream::new(4, 0, Purpose::Camera);
    assert!(camera.look(&nan, &nan, &mut stream).is_err());
    let location = LocationSettings {
        gate_px: 0.0,
        ..LocationSettings::default()
    };
    let error = location.validate().unwrap_err().to_string();
    assert!(error.contains("gate_px"), "{error}");
}
