//! Readings of every kind, and those that are ignored.

use super::*;
use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, DISTANCE_SENSOR_DATA, FOLLOW_TARGET_DATA, GLOBAL_POSITION_INT_DATA,
    HIGHRES_IMU_DATA, MavBool, ODOMETRY_DATA, SCALED_IMU_DATA, VISION_POSITION_ESTIMATE_DATA,
};

/// A clock of the autopilot that is 5 s ahead of ours.
fn synchronised() -> ClockSync {
    let mut clock = ClockSync::default();
    clock.asks(0);
    clock.answered(0, 5_000_000, 0);
    clock
}

fn range(centimetres: u16, time_boot_ms: u32) -> MavMessage {
    MavMessage::DISTANCE_SENSOR(DISTANCE_SENSOR_DATA {
        time_boot_ms,
        min_distance: 2,
        max_distance: 1200,
        current_distance: centimetres,
        orientation: MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270,
        ..DISTANCE_SENSOR_DATA::default()
    })
}

#[test]
fn analytic_the_age_of_a_range_is_that_of_its_stamp_and_its_latency() {
    let mut inbox = Inbox::new(&FlightSettings::default());
    inbox.take(&range(80, 6_000), &synchronised(), 1_030_000);
    let imu = inbox.sense(1_040_000);
    let Reading::Range(reading) = inbox.ready()[0] else {
        panic!("{:?}", inbox.ready());
    };
    assert_eq!(reading.distance_m, 0.8);
    assert!((reading.age_s - 0.06).abs() < 1e-12);
    assert!(!imu.specific_force_mps2.is_finite(), "no sample has come");
}

#[test]
fn analytic_ranges_that_ardupilot_repeats_are_one_reading() {
    // Messages at 50 Hz of a range finder that is read at 20 Hz: readings at 0, 50, 100, 150 ms.
    let read_cm = |ms: u32| [80, 79, 79, 78][(ms / 50) as usize];
    for (autopilot, expected) in [
        // A change is new at once, an equal value after 50 ms.
        (Autopilot::ArduPilot, vec![0, 60, 120, 160]),
        (Autopilot::Px4, (0..200).step_by(20).collect()),
    ] {
        let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
        inbox.hears(autopilot);
        let mut new_at = Vec::new();
        for ms in (0..200).step_by(20) {
            let now_us = 1_000_000 + 1000 * i64::from(ms);
            inbox.take(&range(read_cm(ms), 6_000 + ms), &clock, now_us);
            inbox.sense(now_us);
            if !inbox.ready().is_empty() {
                new_at.push(ms);
            }
            // The range finder is alive all the time.
            assert_eq!(inbox.age_s(Source::Range, now_us), 0.0);
        }
        assert_eq!(new_at, expected);
        assert_eq!(inbox.ignored, IgnoredReadings::default());
    }
}

#[test]
fn prop_old_future_repeated_and_absurd_readings_are_ignored_and_counted() {
    let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
    inbox.take(&range(80, 6_000), &ClockSync::default(), 1_000_000);
    inbox.take(&range(80, 5_000), &clock, 1_000_000);
    inbox.take(&range(80, 7_000), &clock, 1_000_000);
    inbox.take(&range(1, 6_000), &clock, 1_000_000);
    inbox.take(&range(65_535, 6_000), &clock, 1_000_000);
    inbox.sense(1_000_000);
    assert!(inbox.ready().is_empty());
    inbox.take(&range(80, 6_000), &clock, 1_000_000);
    inbox.take(&range(80, 5_900), &clock, 1_000_000);
    inbox.sense(1_000_000);
    assert_eq!(inbox.ready().len(), 1);
    let expected = IgnoredReadings {
        unusable: 2,
        too_old: 1,
        from_the_future: 1,
        repeated: 1,
        other_frame: 0,
        without_position: 0,
        unsynchronised: 1,
        beside_camera: 0,
        frozen: 0,
    };
    assert_eq!(inbox.ignored, expected);
}

/// The deck seen straight below, this far.
fn target(down_m: f32, time_boot_ms: u32) -> MavMessage {
    MavMessage::LANDING_TARGET(LANDING_TARGET_DATA {
        time_usec: u64::from(time_boot_ms) * 1000,
        frame: MavFrame::MAV_FRAME_BODY_FRD,
        z: down_m,
        position_valid: MavBool::MAV_BOOL_TRUE,
        ..LANDING_TARGET_DATA::default()
    })
}

/// Ranges and targets that are used and frozen in a second in which the range stays the same, and the target goes by `goes_m`.
fn in_a_steady_second(armed: bool, goes_m: f32) -> ([usize; 2], u64) {
    let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
    inbox.arms(armed);
    let mut used = [0, 0];
    for ms in (0..1000).step_by(20) {
        let now_us = 1_000_000 + 1000 * i64::from(ms);
        let level = ATTITUDE_QUATERNION_DATA {
            time_boot_ms: 6_000 + ms,
            q1: 1.0,
            q2: 1e-4 * (ms as f32).sin(),
            ..Default::default()
        };
        let down_m = 0.8 + goes_m * ms as f32 / 1000.0;
        for message in [
            MavMessage::ATTITUDE_QUATERNION(level),
            range(80, 6_000 + ms),
            target(down_m, 6_000 + ms),
        ] {
            inbox.take(&message, &clock, now_us);
        }
        inbox.sense(now_us);
        for reading in inbox.ready() {
            used[usize::from(matches!(reading, Reading::Tag(_)))] += 1;
        }
    }
    (used, inbox.ignored.frozen)
}

#[test]
fn analytic_values_that_stay_the_same_are_frozen_after_their_time() {
    // The target counts for 0.2 s, ten messages at 50 Hz; a range may be the same for as long as nothing says otherwise.
    assert_eq!(in_a_steady_second(true, 0.0), ([50, 10], 40));
    // On the ground nothing is frozen.
    assert_eq!(in_a_steady_second(false, 0.0), ([50, 50], 0));
    // The target goes by 0.3 m: a range that stays the same counts until the target has gone by 0.1 m and four standard deviations of
    // its own, √(3² + (10 · 0.95)²) mm each.
    let sensors = FlightSettings::default().sensors;
    let sd_m = sensors.target_sd_m.hypot(0.95 * sensors.target_sd_share);
    let until = (50.0 * (0.1 + 4.0 * sd_m) / 0.3).ceil() as usize;
    let ([ranges, targets], frozen) = in_a_steady_second(true, 0.3);
    // The deviation at its end is a little smaller or greater than at 0.95 m: two messages.
    assert!(
        ranges.abs_diff(until) <= 2 && targets == 50,
        "{ranges}, {until}; {targets}"
    );
    assert_eq!(frozen as usize, 50 - ranges);
}

#[test]
fn regress_a_vehicle_that_was_carried_and_is_armed_again_has_its_range() {
    let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
    let level = |time_boot_ms| ATTITUDE_QUATERNION_DATA {
        time_boot_ms,
        q1: 1.0,
        ..Default::default()
    };
    // Armed, disarmed and carried, armed again: the range is that of the legs each time.
    for (ms, armed, down_m) in [
        (0, true, 0.1),
        (20, false, 0.1),
        (40, false, 0.9),
        (60, true, 0.1),
    ] {
        let now_us = 1_000_000 + 1000 * i64::from(ms);
        inbox.arms(armed);
        inbox.take(
            &MavMessage::ATTITUDE_QUATERNION(level(6_000 + ms)),
            &clock,
            now_us,
        );
        inbox.take(&range(10, 6_000 + ms), &clock, now_us);
        inbox.take(&target(down_m, 6_000 + ms), &clock, now_us);
        inbox.sense(now_us);
        assert_eq!(inbox.ready().len(), 2, "{ms}");
    }
}

/// Specific forces in thousandths of g that are used in a second of hover in which the velocity goes by `goes_mps`.
fn coarse_forces_used(goes_mps: f32) -> u32 {
    let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
    inbox.arms(true);
    for ms in (0..1000).step_by(20) {
        let now_us = 1_000_000 + 1000 * i64::from(ms);
        let time_boot_ms = 6_000 + ms;
        let force = SCALED_IMU_DATA {
            time_boot_ms,
            zacc: -1000,
            ..SCALED_IMU_DATA::default()
        };
        let velocity = LOCAL_POSITION_NED_DATA {
            time_boot_ms,
            vx: 1e-4 * (ms as f32).sin(),
            vz: goes_mps * ms as f32 / 1000.0,
            ..LOCAL_POSITION_NED_DATA::default()
        };
        inbox.take(&MavMessage::SCALED_IMU(force), &clock, now_us);
        inbox.take(&MavMessage::LOCAL_POSITION_NED(velocity), &clock, now_us);
    }
    inbox.take_arrivals()[Source::Imu as usize]
}

#[test]
fn analytic_forces_in_thousandths_of_g_are_frozen_where_the_velocity_changes() {
    // A quiet hover: nothing says otherwise.
    assert_eq!(coarse_forces_used(0.1), 50);
    // A fall at 4 m/s²: the velocity has changed by 0.24 m/s after 60 ms, three messages, and the one after them is not used.
    assert_eq!(coarse_forces_used(4.0), 4);
}

#[test]
fn analytic_forces_are_averaged_and_a_gap_is_bridged_once() {
    let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
    let level = ATTITUDE_QUATERNION_DATA {
        time_boot_ms: 6_000,
        q1: 1.0,
        ..Default::default()
    };
    inbox.take(&MavMessage::ATTITUDE_QUATERNION(level), &clock, 1_000_000);
    for (time_usec, zacc) in [(5_999_000, -9.0), (6_000_000, -11.0)] {
        let sample = HIGHRES_IMU_DATA {
            time_usec,
            zacc,
            ..HIGHRES_IMU_DATA::default()
        };
        inbox.take(&MavMessage::HIGHRES_IMU(sample), &clock, 1_000_000);
    }
    assert_eq!(inbox.sense(1_000_000).specific_force_mps2.z, 10.0);
    assert_eq!(inbox.sense(1_010_000).specific_force_mps2.z, 11.0);
    assert!(inbox.sense(1_060_000).specific_force_mps2.z.is_nan());
}

#[test]
fn prop_a_target_in_another_frame_is_ignored() {
    let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
    let mut target = LANDING_TARGET_DATA {
        frame: MavFrame::MAV_FRAME_GLOBAL,
        z: 1.0,
        position_valid: MavBool::MAV_BOOL_TRUE,
        ..LANDING_TARGET_DATA::default()
    };
    inbox.take(
        &MavMessage::LANDING_TARGET(target.clone()),
        &clock,
        1_000_000,
    );
    assert_eq!(inbox.ignored.other_frame, 1);
    target.frame = MavFrame::MAV_FRAME_BODY_FRD;
    inbox.take(&MavMessage::LANDING_TARGET(target), &clock, 1_000_000);
    inbox.sense(1_000_000);
    let Reading::Tag(reading) = inbox.ready()[0] else {
        panic!("{:?}", inbox.ready());
    };
    assert_eq!(reading.position_m, Vector::new(0.0, -0.0, -1.0));
    assert!(
        (reading.age_s - 0.05).abs() < 1e-12,
        "the age that the settings give"
    );
}
#[test]
fn prop_only_a_turn_that_no_vehicle_makes_is_a_jump() {
    let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
    let mut turned = |time_boot_ms, yaw_rad: f32| {
        let attitude = ATTITUDE_QUATERNION_DATA {
            time_boot_ms,
            q1: (0.5 * yaw_rad).cos(),
            q4: (0.5 * yaw_rad).sin(),
            ..Default::default()
        };
        inbox.take(
            &MavMessage::ATTITUDE_QUATERNION(attitude),
            &clock,
            1_050_000,
        );
        inbox.take_jump()
    };
    assert!(!turned(6_000, 0.0), "the first");
    assert!(!turned(6_010, 0.1), "10 rad/s");
    assert!(turned(6_020, 0.5), "40 rad/s");
    assert!(!turned(6_030, 0.5), "it rests");
}

#[test]
fn regress_a_clock_that_slips_turns_no_vehicle() {
    let (mut inbox, mut clock) = (Inbox::new(&FlightSettings::default()), synchronised());
    let level = |time_boot_ms| {
        MavMessage::ATTITUDE_QUATERNION(ATTITUDE_QUATERNION_DATA {
            time_boot_ms,
            q1: 1.0,
            ..Default::default()
        })
    };
    inbox.take(&level(6_000), &clock, 1_050_000);
    // An answer shows that the autopilot's clock is 40 ms further ahead than was known.
    clock.asks(1_060_000);
    clock.answered(1_060_000, 6_100_000, 1_060_000);
    inbox.take(&level(6_010), &clock, 1_070_000);
    assert!(
        !inbox.take_jump(),
        "the same attitude, 10 ms later by its own clock"
    );
}

/// An inbox whose vehicle is at (10, 20, -5) north-east-down, moves north at 1 m/s and points east.
fn placed(clock: &ClockSync) -> Inbox {
    let mut settings = FlightSettings::default();
    (settings.deck.system_id, settings.deck.latency_s) = (9, 0.04);
    let mut inbox = Inbox::new(&settings);
    let half = std::f32::consts::FRAC_PI_4;
    let attitude = ATTITUDE_QUATERNION_DATA {
        time_boot_ms: 6_000,
        q1: half.cos(),
        q4: half.sin(),
        ..ATTITUDE_QUATERNION_DATA::default()
    };
    inbox.take(&MavMessage::ATTITUDE_QUATERNION(attitude), clock, 1_000_000);
    let local = LOCAL_POSITION_NED_DATA {
        time_boot_ms: 6_000,
        x: 10.0,
        y: 20.0,
        z: -5.0,
        vx: 1.0,
        ..LOCAL_POSITION_NED_DATA::default()
    };
    inbox.take(&MavMessage::LOCAL_POSITION_NED(local), clock, 1_000_000);
    let globe = GLOBAL_POSITION_INT_DATA {
        time_boot_ms: 6_000,
        lat: 473_000_000,
        lon: 85_000_000,
        alt: 500_000,
        ..GLOBAL_POSITION_INT_DATA::default()
    };
    inbox.take(&MavMessage::GLOBAL_POSITION_INT(globe), clock, 1_000_000);
    inbox.sense(1_000_000);
    inbox
}

/// The deck's position in body axes (forward-left-up), and its age, at 1.1 s.
fn deck(inbox: &mut Inbox) -> (Vector<f64>, f64) {
    inbox.sense(1_100_000);
    let Some(Reading::Tag(reading)) = inbox.ready().last() else {
        panic!("{:?} {:?}", inbox.ready(), inbox.ignored);
    };
    (reading.position_m, reading.age_s)
}

#[test]
fn analytic_the_deck_is_where_the_positions_differ() {
    let clock = synchronised();
    // 2 m north of where the vehicle is at 1.06 s: on its left, for it points east; 3 m below.
    let expected = Vector::new(0.0, 2.0, -3.0);
    let vision = VISION_POSITION_ESTIMATE_DATA {
        x: 12.06,
        y: 20.0,
        z: -2.0,
        ..VISION_POSITION_ESTIMATE_DATA::default()
    };
    let odometry = ODOMETRY_DATA {
        frame_id: MavFrame::MAV_FRAME_LOCAL_ENU,
        x: 20.0,
        y: 12.06,
        z: 2.0,
        ..ODOMETRY_DATA::default()
    };
    // A degree is 111.195 km.
    let globe = GLOBAL_POSITION_INT_DATA {
        lat: 473_000_000 + 185,
        lon: 85_000_000,
        alt: 497_000,
        ..GLOBAL_POSITION_INT_DATA::default()
    };
    let follow = FOLLOW_TARGET_DATA {
        lat: 473_000_000 + 185,
        lon: 85_000_000,
        alt: 497.0,
        ..FOLLOW_TARGET_DATA::default()
    };
    for (name, message) in [
        ("vision", MavMessage::VISION_POSITION_ESTIMATE(vision)),
        ("odometry", MavMessage::ODOMETRY(odometry)),
        ("globe", MavMessage::GLOBAL_POSITION_INT(globe)),
        ("follow", MavMessage::FOLLOW_TARGET(follow)),
    ] {
        let mut inbox = placed(&clock);
        inbox.take_deck(&message, 1_100_000);
        let (position, age_s) = deck(&mut inbox);
        // 1e-7 degrees are 11 mm, and 185 of them 2.057 m.
        assert!((position - expected).norm() < 0.012, "{name}: {position:?}");
        assert!((age_s - 0.04).abs() < 1e-9, "{name}: {age_s}");
    }
    let mut inbox = placed(&clock);
    let target = LANDING_TARGET_DATA {
        time_usec: 6_060_000,
        frame: MavFrame::MAV_FRAME_LOCAL_NED,
        x: 12.06,
        y: 20.0,
        z: -2.0,
        position_valid: MavBool::MAV_BOOL_TRUE,
        ..LANDING_TARGET_DATA::default()
    };
    inbox.take(&MavMessage::LANDING_TARGET(target), &clock, 1_100_000);
    let (position, age_s) = deck(&mut inbox);
    // f32 has 1 µm at 12 m.
    assert!((position - expected).norm() < 1e-5, "{position:?}");
    assert!((age_s - 0.04).abs() < 1e-9);
}

#[test]
fn prop_a_deck_is_not_placed_without_a_recent_place_of_the_vehicle() {
    let clock = synchronised();
    let vision = |x| {
        MavMessage::VISION_POSITION_ESTIMATE(VISION_POSITION_ESTIMATE_DATA {
            x,
            ..VISION_POSITION_ESTIMATE_DATA::default()
        })
    };
    let mut inbox = placed(&clock);
    inbox.take_deck(&vision(0.0), 1_400_000);
    inbox.take_deck(&vision(f32::NAN), 1_100_000);
    inbox.sense(1_400_000);
    assert!(inbox.ready().is_empty());
    assert_eq!(
        (inbox.ignored.without_position, inbox.ignored.unusable),
        (1, 1)
    );
    // Another component's pose of the vehicle goes before the autopilot's own.
    inbox.take_external(&vision(0.5), 1_100_000);
    inbox.take_deck(&vision(1.5), 1_100_000);
    let (position, _) = deck(&mut inbox);
    assert!(
        (position - Vector::new(0.0, 1.0, 0.0)).norm() < 1e-6,
        "{position:?}"
    );
}
