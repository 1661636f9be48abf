//! A recording comes back, whole or cut off.

use super::*;
use crate::companion::{Event, Session};
use crate::settings::FlightSettings;
use crate::wire::Encoder;
use mavlink::dialects::common::{ATTITUDE_QUATERNION_DATA, HIGHRES_IMU_DATA, MavMessage};

/// Bytes of a reading of the inertial unit and an attitude.
fn bytes() -> Vec<u8> {
    let (mut encoder, mut bytes) = (Encoder::new(7, 1), Vec::new());
    let attitude = ATTITUDE_QUATERNION_DATA {
        q1: 1.0,
        ..ATTITUDE_QUATERNION_DATA::default()
    };
    encoder.write(&MavMessage::ATTITUDE_QUATERNION(attitude), &mut bytes);
    let imu = HIGHRES_IMU_DATA {
        zacc: -9.75,
        ..HIGHRES_IMU_DATA::default()
    };
    encoder.write(&MavMessage::HIGHRES_IMU(imu), &mut bytes);
    bytes
}

#[test]
fn prop_a_recording_comes_back_and_says_what_its_bytes_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.mcap");
    let session = Session {
        set_parameters: true,
        ..Session::default()
    };
    let settings = FlightSettings::default();
    let mut recorder = Recorder::create(&path, &settings, &session).unwrap();
    let bytes = bytes();
    recorder
        .write(10, Event::Received(&bytes), b"answer")
        .unwrap();
    recorder.write(20, Event::Tick, &[]).unwrap();
    recorder.write(30, Event::Stop, &[]).unwrap();
    recorder.finish().unwrap();
    let read = Recording::read(&path).unwrap();
    let expected = vec![
        (10, Entry::Received(bytes)),
        (10, Entry::Sent(b"answer".to_vec())),
        (20, Entry::Tick),
        (30, Entry::Stop),
    ];
    assert_eq!((read.entries, read.cut_off), (expected, false));
    assert_eq!((read.settings, read.unsigned), (settings, session));
    let whole = std::fs::read(&path).unwrap();
    let force = br#""specific_force_z_mps2":-9.75"#;
    assert!(whole.windows(force.len()).any(|part| part == force));
}

#[test]
fn prop_two_flights_do_not_write_one_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.mcap");
    let settings = FlightSettings::default();
    let create = || Recorder::create(&path, &settings, &Session::default());
    let mut first = create().unwrap();
    first.write(20, Event::Tick, &[]).unwrap();
    let error = create().err().expect("the first flight writes it");
    assert!(error.to_string().contains("another flight"), "{error}");
    first.finish().unwrap();
    let read = Recording::read(&path).unwrap();
    assert_eq!(read.entries, [(20, Entry::Tick)]);
    // A flight that has ended is replaced.
    create().unwrap();
}

/// Writes forty messages; returns the bytes of the file, and how many of them came before the first message.
fn forty(path: &std::path::Path) -> (Vec<u8>, usize) {
    let settings = FlightSettings::default();
    let mut recorder = Recorder::create(path, &settings, &Session::default()).unwrap();
    let begins = std::fs::metadata(path).unwrap().len() as usize;
    for tick in 0..40 {
        recorder
            .write(tick, Event::Received(&bytes()), &[])
            .unwrap();
    }
    recorder.finish().unwrap();
    (std::fs::read(path).unwrap(), begins)
}

#[test]
fn prop_a_recording_that_is_cut_anywhere_is_read_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.mcap");
    let (whole, begins) = forty(&path);
    let mut before = 0;
    for length in (begins..whole.len()).step_by(97) {
        std::fs::write(&path, &whole[..length]).unwrap();
        let read = Recording::read(&path).unwrap();
        assert!(read.entries.len() >= before && read.entries.len() <= 40);
        before = read.entries.len();
    }
    assert_eq!(before, 40);
}

#[test]
fn prop_a_flipped_bit_is_damage_and_no_kill() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.mcap");
    let (whole, _) = forty(&path);
    let read = Recording::read(&path).unwrap();
    let (mut damaged, mut tried) = (0, 0);
    // A step without a common factor with the length of a record, and another bit each time.
    for place in (0..whole.len()).step_by(61) {
        let mut bytes = whole.clone();
        bytes[place] ^= 1 << (place % 8);
        std::fs::write(&path, &bytes).unwrap();
        tried += 1;
        match Recording::read(&path) {
            // In the index: the data are whole.
            Ok(again) => assert_eq!(
                (again.entries, again.cut_off),
                (read.entries.clone(), false)
            ),
            Err(error) => {
                damaged += 1;
                let text = error.to_string();
                assert!(text.contains("a damaged file"), "{text}");
            }
        }
    }
    assert!(damaged > tried / 2, "{damaged} of {tried}");
}
