//! Logs whose time jumps, whose values are no numbers, and maps that do not fit.

use crate::common;

use common::{dataflash, format, good_ulog, ulog};
use touchdown_log::{ErrorKind, Log, Map, UlogWriter};

#[test]
fn analytic_time_that_jumps() {
    // Forward by two hours in the middle: a gap that is told, no row lost.
    let jumps = |i: u64| 1_000_000 + 4000 * i + if i >= 50 { 7_200_000_000 } else { 0 };
    let log = Log::from_bytes("forward", ulog(jumps, |_| 1.0)).unwrap();
    let jump = "time jumps once by more than a minute, by up to 7200 s";
    let (_, findings) = log.survey().unwrap();
    assert!(findings.warnings.iter().any(|w| w == jump), "{findings:?}");
    let (trial, findings) = log.trial(None).unwrap();
    assert_eq!((trial.len(), findings.rows_dropped()), (100, 0));
    assert!(findings.warnings.iter().any(|w| w == jump), "{findings:?}");
    // Back by two hours: time goes on.
    let back = |i: u64| 8_000_000_000 + 4000 * i - if i >= 50 { 7_200_000_000 } else { 0 };
    let log = Log::from_bytes("back", ulog(back, |_| 1.0)).unwrap();
    let (trial, findings) = log.trial(None).unwrap();
    assert_eq!((trial.len(), findings.rows_dropped()), (100, 0));
    assert!((trial.duration_s() - 0.396).abs() < 1e-9);
    assert!(
        findings.warnings.iter().any(|w| w.contains("set back")),
        "{findings:?}"
    );
    // One stray stamp costs its own row.
    let stray = |i: u64| {
        if i == 30 {
            9_000_000_000
        } else {
            1_000_000 + 4000 * i
        }
    };
    let (trial, findings) = Log::from_bytes("stray", ulog(stray, |_| 1.0))
        .unwrap()
        .trial(None)
        .unwrap();
    assert_eq!((trial.len(), findings.rows_dropped()), (99, 1));
}

#[test]
fn analytic_topics_stay_together_where_a_clock_is_set_back() {
    let mut log = UlogWriter::new(Vec::new(), 1_000_000).unwrap();
    let [acceleration, height] = [
        "float[3] accelerometer_m_s2",
        "float dist_bottom;float vz;bool dist_bottom_valid",
    ];
    log.format("sensor_combined", acceleration).unwrap();
    log.format("vehicle_local_position", height).unwrap();
    log.format("vehicle_attitude", "float[4] q").unwrap();
    let imu = log.topic("sensor_combined", 0).unwrap();
    let attitude = log.topic("vehicle_attitude", 0).unwrap();
    let position = log.topic("vehicle_local_position", 0).unwrap();
    // 100 Hz for 8 s; heights every 0.2 s, climbing by 0.1 m/s. At 4 s the clock goes back by two
    // hours, and heights come at another phase from there on.
    for i in 0..800_u64 {
        let is_before = i < 400;
        let stamp = 8_000_000_000 + 10_000 * i - if is_before { 0 } else { 7_200_000_000 };
        log.message(imu, stamp, &[0.0, 0.0, -9.81]).unwrap();
        log.message(attitude, stamp, &[1.0, 0.0, 0.0, 0.0]).unwrap();
        if i % 20 == if is_before { 13 } else { 2 } {
            let height = 1.0 + 0.001 * i as f64;
            log.message(position, stamp, &[height, -0.1, 1.0]).unwrap();
        }
    }
    let log = Log::from_bytes("back.ulg", log.finish().unwrap()).unwrap();
    let (trial, findings) = log.trial(None).unwrap();
    assert_eq!((trial.len(), findings.rows_dropped()), (800, 0));
    let from_s = trial.time_s()[0];
    let heights = trial.require("height_m").unwrap();
    let known = trial
        .time_s()
        .iter()
        .zip(heights)
        .filter(|(_, h)| h.is_finite());
    let mut count = 0;
    for (t, height) in known {
        // Rounding of single precision.
        let off = height - 1.0 - 0.1 * (t - from_s);
        assert!(off.abs() < 1e-6, "{t} s: {height} m");
        count += 1;
    }
    assert!(count > 750, "{count}");
    let told = findings.warnings.iter().filter(|w| w.contains("set back"));
    assert_eq!(told.count(), 1, "{findings:?}");
}

#[test]
fn analytic_heights_that_are_no_numbers_are_gaps() {
    let height = |i: u64| {
        if i.is_multiple_of(10) {
            f64::NAN
        } else {
            f64::INFINITY
        }
    };
    let log = Log::from_bytes("nan", ulog(|i| 1_000_000 + 4000 * i, height)).unwrap();
    let (trial, findings) = log.trial(None).unwrap();
    assert!(trial.channel("height_m").is_none());
    assert!(
        findings
            .warnings
            .iter()
            .any(|w| w == "height_m: omitted, because it has no value")
    );
    assert!(trial.channel("throttle").is_none(), "it never flew");
    let (survey, _) = log.survey().unwrap();
    let field = survey
        .topic("vehicle_local_position")
        .unwrap()
        .field("dist_bottom")
        .unwrap();
    assert_eq!((field.count, field.min), (0, None));
    assert_eq!(survey.topic("never").unwrap().messages, 0);
}

#[test]
fn prop_names_that_are_not_there_are_told_with_a_near_one() {
    let log = Log::from_bytes("flight.ulg", good_ulog()).unwrap();
    let trial = |text: &str| {
        log.trial(Some(&Map::parse("m.toml", text).unwrap()))
            .unwrap_err()
            .to_string()
    };
    let head = "schema = 1\nclock = 'sensor_combined'\n[channels]\ntime_s = 'time_s'\n";
    let error = trial(&format!("{head}x = 'vehicle_local_position.vs'\n"));
    assert!(
        error.contains("m.toml, line 5, channels.x")
            && error.contains("did you mean \"vehicle_local_position.vz\""),
        "{error}"
    );
    let error = trial(&format!("{head}x = 'vehicle_local_positions.vz'\n"));
    assert!(
        error.contains("did you mean \"vehicle_local_position\""),
        "{error}"
    );
    let error = trial(&format!("{head}x = 'param.THR_MDL_FAK'\n"));
    assert!(
        error.contains("did you mean \"param.THR_MDL_FAC\""),
        "{error}"
    );
    let error = trial(&head.replace("sensor_combined", "sensor_combine"));
    assert!(
        error.contains("line 2, clock") && error.contains("did you mean \"sensor_combined\""),
        "{error}"
    );
    for bad in [
        "schema = 1\noptional = ['y']\n[channels]\ntime_s = 'time_s'\n",
        "schema = 1\nclock = []\n[channels]\ntime_s = 'time_s'\n",
        "schema = 1\n[channels]\ntime_s = ['time_s', 2]\n",
        "schema = 1\n[channels]\ntime_s = 'time_s'\n[topics.a]\njoin = 'cubic'\n",
        "schema = 1\n[channels]\ntime_s = 'time_s'\n[topics.a]\nlimit_s = -1.0\n",
        "schema = 1\n[channels]\ntime_s = 'time_s'\n[topics.a]\nlimits_s = 1.0\n",
    ] {
        let error = Map::parse("m.toml", bad).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::BadInput, "{bad}");
        assert!(error.to_string().contains("m.toml, line"), "{error}");
    }
}

#[test]
fn analytic_rotor_speeds_of_older_firmware() {
    // One topic a motor; their speeds are hundredths.
    let mut bytes = dataflash();
    for motor in 1..=4_u8 {
        let kind = 140 + motor;
        let name = ["ESC1", "ESC2", "ESC3", "ESC4"][usize::from(motor) - 1];
        bytes.extend(format(kind, 15, name, "Qe", "TimeUS,RPM"));
        for i in 0..16_u64 {
            bytes.extend([0xa3, 0x95, kind]);
            bytes.extend((10_000_000 + 10_000 * i).to_le_bytes());
            bytes.extend((100_000 * i32::from(motor)).to_le_bytes());
        }
    }
    let log = Log::from_bytes("old.bin", bytes).unwrap();
    let (trial, _) = log.trial(None).unwrap();
    let rpm = trial.require("rotor_rpm").unwrap();
    assert!(rpm.iter().all(|rpm| *rpm == 2500.0), "{rpm:?}");
}

#[test]
fn analytic_records_of_firmware_that_stamps_in_ms() {
    let parameters = |letters: &str, labels: &str, before: &[u8], after: &[u8]| {
        let mut bytes = dataflash();
        let length = 3 + before.len() + 16 + 4 + after.len();
        bytes.extend(format(140, length as u8, "PARM", letters, labels));
        bytes.extend([0xa3, 0x95, 140]);
        bytes.extend(before);
        bytes.extend(b"MOT_THST_EXPO\0\0\0");
        bytes.extend(0.25_f32.to_le_bytes());
        bytes.extend(after);
        let (survey, _) = Log::from_bytes("old.bin", bytes).unwrap().survey().unwrap();
        survey.parameters.get("MOT_THST_EXPO").copied()
    };
    let stamp = 5000_u32.to_le_bytes();
    for (letters, labels, before, after) in [
        ("Nf", "Name,Value", &[][..], &[][..]),
        ("INf", "TimeMS,Name,Value", &stamp, &[]),
        ("NfI", "Name,Value,TimeMS", &[], &stamp),
        ("QNff", "TimeUS,Name,Value,Default", &[0; 8], &stamp),
    ] {
        let found = parameters(letters, labels, before, after);
        assert_eq!(found, Some(0.25), "{labels}");
    }
}

#[test]
fn prop_a_type_of_field_that_is_not_known_costs_no_other_topic() {
    // Eight bytes of a kind to come, between records of others.
    let mut bytes = dataflash();
    let good = Log::from_bytes("good.bin", bytes.clone()).unwrap();
    let (good, _) = good.survey().unwrap();
    bytes.extend(format(140, 3 + 8 + 2 + 8, "NEW", "QHx", "TimeUS,A,B"));
    let rows = dataflash().split_off(bytes.len() - 89 - 60 * 24 - 30 * 19);
    for i in 0..3_u16 {
        bytes.extend([0xa3, 0x95, 140]);
        bytes.extend((11_000_000 + u64::from(i)).to_le_bytes());
        bytes.extend(i.to_le_bytes());
        bytes.extend([0xa3; 8]);
    }
    bytes.extend(rows);
    let (survey, findings) = Log::from_bytes("new.bin", bytes).unwrap().survey().unwrap();
    assert!(!findings.is_lossy(), "{findings:?}");
    let new = survey.topic("NEW").unwrap();
    assert_eq!((new.messages, new.fields.len()), (3, 2));
    assert_eq!(new.field("A").unwrap().sum, 3.0);
    for topic in ["IMU", "IMU#1", "RCOU"] {
        let twice = 2 * good.topic(topic).unwrap().messages;
        assert_eq!(survey.topic(topic).unwrap().messages, twice, "{topic}");
    }
    let note = "NEW: fields from number 3 on are omitted, because the type 'x' is not known";
    assert!(findings.warnings.iter().any(|w| w == note), "{findings:?}");
}

/// PX4 at 100 Hz for 4 s: a range finder that drops out, motors that stop at 2 s.
fn dropouts() -> Log {
    let mut log = UlogWriter::new(Vec::new(), 1_000_000).unwrap();
    for (name, fields) in [
        ("sensor_combined", "float[3] accelerometer_m_s2"),
        ("vehicle_attitude", "float[4] q"),
        ("actuator_motors", "float[12] control"),
        (
            "distance_sensor",
            "float min_distance;float max_distance;float current_distance;int8_t signal_quality;uint8_t orientation",
        ),
    ] {
        log.format(name, fields).unwrap();
    }
    let names = [
        "sensor_combined",
        "vehicle_attitude",
        "actuator_motors",
        "distance_sensor",
    ];
    let [imu, attitude, motors, range] = names.map(|name| log.topic(name, 0).unwrap());
    for i in 0..400_u64 {
        let stamp = 1_000_000 + 10_000 * i;
        log.message(imu, stamp, &[0.0, 0.0, -9.81]).unwrap();
        log.message(attitude, stamp, &[1.0, 0.0, 0.0, 0.0]).unwrap();
        if i % 10 == 0 {
            let mut controls = [f64::NAN; 12];
            if i < 200 {
                controls[..4].fill(0.5);
            }
            log.message(motors, stamp, &controls).unwrap();
            // Every fourth reading is none, and says so.
            let reading = if i % 40 == 0 {
                [0.0, 0.0]
            } else {
                [1.0, 100.0]
            };
            let [distance, quality] = reading;
            log.message(range, stamp, &[0.1, 8.0, distance, quality, 25.0])
                .unwrap();
        }
    }
    Log::from_bytes("dropouts.ulg", log.finish().unwrap()).unwrap()
}

#[test]
fn analytic_no_height_is_made_of_a_reading_that_is_none() {
    let (trial, _) = dropouts().trial(None).unwrap();
    let heights = trial.require("height_m").unwrap();
    let known: Vec<f64> = heights.iter().copied().filter(|h| h.is_finite()).collect();
    // Each reading in the row of its stamp: 40, of which every fourth is none.
    assert!(
        known.len() == 30 && known.iter().all(|h| *h == 1.0),
        "{known:?}"
    );
}

#[test]
fn analytic_motors_that_stop_are_not_held() {
    let (trial, _) = dropouts().trial(None).unwrap();
    let throttle = trial.require("throttle").unwrap();
    for (t, throttle) in trial.time_s().iter().zip(throttle) {
        assert_eq!(*throttle == 0.5, *t < 2.0, "{t} s: {throttle}");
        assert_eq!(throttle.is_nan(), *t >= 2.0, "{t} s: {throttle}");
    }
}

#[test]
fn regress_a_format_with_one_label_twice_has_two_fields() {
    // The first format of the type is taken back by one that names two fields alike.
    let mut bytes = common::format(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    bytes.extend(common::format(129, 12, "ABC", "QB", "TimeUS,A"));
    for (row, length) in [(1_u64, 1), (2, 1), (3, 2), (4, 2), (5, 2)] {
        if row == 3 {
            bytes.extend(common::format(129, 13, "ABC", "QBB", "TimeUS,A,A"));
        }
        bytes.extend([0xa3, 0x95, 129]);
        bytes.extend(row.to_le_bytes());
        bytes.extend(&[row as u8, 10 * row as u8][..length]);
    }
    let log = Log::from_bytes("log.bin", bytes).unwrap();
    let (survey, _) = log.survey().unwrap();
    let fields = &survey.topic("ABC").unwrap().fields;
    let sums: Vec<_> = fields
        .iter()
        .map(|f| (f.name.as_str(), f.count, f.sum))
        .collect();
    assert_eq!(
        sums,
        [("TimeUS", 5, 15.0), ("A", 5, 15.0), ("A#2", 3, 120.0)]
    );
}
