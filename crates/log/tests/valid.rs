//! Which messages of a topic count, as maps say it by `valid`.

use crate::common;

use common::{dataflash, format};
use touchdown_log::{Findings, Log, Map, UlogWriter};
use touchdown_trial::Trial;

/// An accelerometer at 100 Hz and a range finder at 50 Hz for a second; every fifth reading of it
/// lies beyond its range.
fn log() -> Log {
    let mut log = UlogWriter::new(Vec::new(), 1_000_000).unwrap();
    log.parameter("FARTHEST", 8.0).unwrap();
    log.format("imu", "float z").unwrap();
    log.format("range", "float farthest;float distance")
        .unwrap();
    let [imu, range] = ["imu", "range"].map(|name| log.topic(name, 0).unwrap());
    for i in 0..100_u64 {
        let stamp_us = 1_000_000 + 10_000 * i;
        log.message(imu, stamp_us, &[-9.81]).unwrap();
        if i % 2 == 0 {
            let distance = if i % 10 == 4 { 40.0 } else { 1.0 };
            log.message(range, stamp_us, &[8.0, distance]).unwrap();
        }
    }
    Log::from_bytes("range.ulg", log.finish().unwrap()).unwrap()
}

fn trial(clock: &str, valid: &str) -> (Trial, Findings) {
    let text = format!(
        "schema = 1\nclock = '{clock}'\n\
         [define]\nread = 'range.distance'\nfar = 'param.FARTHEST'\n\
         [channels]\ntime_s = 'time_s'\nheight_m = 'range.distance'\n\
         [topics.range]\nvalid = {valid}\n"
    );
    let map = Map::parse("m.toml", &text).unwrap();
    log().trial(Some(&map)).unwrap()
}

fn highest(trial: &Trial) -> f64 {
    let heights = trial.require("height_m").unwrap();
    heights.iter().copied().fold(0.0, f64::max)
}

#[test]
fn regress_the_clocks_own_messages_count_by_valid_as_well() {
    let (all, _) = trial("range", "'1'");
    assert_eq!((all.len(), highest(&all)), (50, 40.0));
    let (some, findings) = trial("range", "'range.distance <= range.farthest'");
    assert_eq!((some.len(), highest(&some)), (40, 1.0));
    let told = "range: 10 messages that `valid` excludes make no row";
    assert!(
        findings.warnings.iter().any(|w| w == told) && !findings.is_lossy(),
        "{findings:?}"
    );
}

#[test]
fn regress_valid_knows_parameters_and_definitions() {
    for valid in [
        "'range.distance <= range.farthest'",
        "'range.distance <= param.FARTHEST'",
        "'read <= far'",
        // The first whose names are all there.
        "['range.quality > 0', 'read <= far']",
    ] {
        let (trial, findings) = trial("imu", valid);
        assert_eq!(highest(&trial), 1.0, "{valid}");
        assert_eq!(findings.warnings, [""; 0], "{valid}");
    }
}

#[test]
fn regress_names_that_valid_cannot_have_are_told() {
    for (valid, name) in [
        (
            "'range.distence < 8'",
            "\"range.distence\" is neither a field of range nor a parameter (did you mean \"range.distance\"?)",
        ),
        (
            "'read < param.NEAREST'",
            "\"param.NEAREST\" is neither a field of range nor a parameter",
        ),
        // Another topic's.
        (
            "'imu.z < 0'",
            "\"imu.z\" is neither a field of range nor a parameter",
        ),
    ] {
        let (trial, findings) = trial("imu", valid);
        assert_eq!(highest(&trial), 40.0, "{valid}");
        let told =
            format!("m.toml, line 10, topics.range.valid: {name}; all its messages are used");
        assert_eq!(findings.warnings, [told], "{valid}");
    }
}

/// A range finder of ArduPilot at 100 Hz, good (4) and beyond its range (3) by turns, in the records
/// of three firmwares: beside status and orientation, with orientation only, with neither.
#[test]
fn regress_ardupilots_readings_that_are_none_make_no_height() {
    for (letters, labels, highest) in [
        ("QCBB", "TimeUS,Dist,Stat,Orient", 2.0),
        (
            "QCBBCBB",
            "TimeUS,Dist1,Stat1,Orient1,Dist2,Stat2,Orient2",
            2.0,
        ),
        ("QCBCB", "TimeUS,Dist1,Orient1,Dist2,Orient2", 7.0),
        ("QCC", "TimeUS,Dist1,Dist2", 7.0),
    ] {
        let (has_status, many) = (labels.contains("Stat"), labels.contains('2'));
        let length = 3 + letters.bytes().fold(0, |sum, letter| match letter {
            b'Q' => sum + 8,
            b'C' => sum + 2,
            _ => sum + 1,
        });
        let mut bytes = dataflash();
        bytes.extend(format(140, length, "RFND", letters, labels));
        bytes.extend(format(141, 15, "ATT", "Qcc", "TimeUS,Roll,Pitch"));
        for i in 0..16_u64 {
            let stamp = (10_000_000 + 10_000 * i).to_le_bytes();
            bytes.extend([0xa3, 0x95, 141]);
            bytes.extend(stamp);
            bytes.extend([0; 4]);
            bytes.extend([0xa3, 0x95, 140]);
            bytes.extend(stamp);
            let good = i % 2 == 0;
            for _ in 0..=usize::from(many) {
                bytes.extend(if good { 200_u16 } else { 700 }.to_le_bytes());
                if has_status {
                    bytes.push(if good { 4 } else { 3 });
                }
                if labels.contains("Orient") {
                    bytes.push(25);
                }
            }
        }
        let log = Log::from_bytes("range.bin", bytes).unwrap();
        let (trial, findings) = log.trial(None).unwrap();
        let heights = trial.require("height_m").unwrap();
        let known = heights.iter().filter(|height| height.is_finite());
        let most = known.clone().copied().fold(0.0, f64::max);
        // Levels of the records, which are whole centimetres.
        assert!((most - highest).abs() < 1e-9, "{labels}: {most}");
        // A reading makes one row, up to the accelerometer's last row. With a status only good readings do.
        let readings = if has_status { 8 } else { 15 };
        assert_eq!(known.count(), readings, "{labels}: {heights:?}");
        assert!(
            !findings.warnings.iter().any(|w| w.contains("neither")),
            "{findings:?}"
        );
    }
}
