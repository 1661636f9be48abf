//! Logs for the tests of readers.
#![allow(dead_code)]

use std::path::Path;
use touchdown_log::UlogWriter;

pub(crate) fn fixture(file: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/fixtures");
    std::fs::read(folder.join(file)).unwrap()
}

/// A flight of 0.4 s as PX4 logs it.
pub(crate) fn ulog(stamp_us: impl Fn(u64) -> u64, height_m: impl Fn(u64) -> f64) -> Vec<u8> {
    let mut log = UlogWriter::new(Vec::new(), 1_000_000).unwrap();
    log.parameter("THR_MDL_FAC", 0.0).unwrap();
    log.info("sys_name", "PX4").unwrap();
    log.format("sensor_combined", "float[3] accelerometer_m_s2")
        .unwrap();
    log.format("vehicle_attitude", "float[4] q").unwrap();
    log.format(
        "vehicle_local_position",
        "float dist_bottom;float vz;bool dist_bottom_valid",
    )
    .unwrap();
    log.format("never", "float x").unwrap();
    let imu = log.topic("sensor_combined", 0).unwrap();
    let attitude = log.topic("vehicle_attitude", 0).unwrap();
    let position = log.topic("vehicle_local_position", 0).unwrap();
    log.topic("never", 0).unwrap();
    for i in 0..100 {
        let stamp = stamp_us(i);
        log.message(imu, stamp, &[0.0, 0.0, -9.81]).unwrap();
        if i % 5 == 0 {
            log.message(attitude, stamp, &[1.0, 0.0, 0.0, 0.0]).unwrap();
            log.message(position, stamp, &[height_m(i), 0.0, 1.0])
                .unwrap();
        }
    }
    log.finish().unwrap()
}

pub(crate) fn good_ulog() -> Vec<u8> {
    ulog(|i| 1_000_000 + 4000 * i, |_| 1.0)
}

/// A record of ArduPilot that defines a format.
pub(crate) fn format(kind: u8, length: u8, name: &str, letters: &str, labels: &str) -> Vec<u8> {
    let mut body = [0; 86];
    body[..2].copy_from_slice(&[kind, length]);
    body[2..2 + name.len()].copy_from_slice(name.as_bytes());
    body[6..6 + letters.len()].copy_from_slice(letters.as_bytes());
    body[22..22 + labels.len()].copy_from_slice(labels.as_bytes());
    [&[0xa3, 0x95, 128][..], &body].concat()
}

/// Records of ArduPilot: their formats, then 60 of an accelerometer and 30 of motors.
pub(crate) fn dataflash() -> Vec<u8> {
    let mut bytes = Vec::new();
    for (kind, length, name, letters, labels) in [
        (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        (130, 44, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
        (129, 24, "IMU", "QBfff", "TimeUS,I,AccX,AccY,AccZ"),
        (131, 19, "RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4"),
    ] {
        bytes.extend(format(kind, length, name, letters, labels));
    }
    // The second field of IMU numbers the instance.
    let mut units = [0; 41];
    units[8] = 129;
    units[9..14].copy_from_slice(b"s#ooo");
    bytes.extend([0xa3, 0x95, 130]);
    bytes.extend(units);
    for i in 0..60_u64 {
        bytes.extend([0xa3, 0x95, 129]);
        bytes.extend((10_000_000 + 2500 * i).to_le_bytes());
        bytes.push((i % 2) as u8);
        for value in [0.0_f32, 0.0, -9.81 - (i % 2) as f32] {
            bytes.extend(value.to_le_bytes());
        }
        if i % 2 == 0 {
            bytes.extend([0xa3, 0x95, 131]);
            bytes.extend((10_000_000 + 2500 * i).to_le_bytes());
            for _ in 0..4 {
                bytes.extend(1500_u16.to_le_bytes());
            }
        }
    }
    bytes
}
