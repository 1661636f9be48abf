//! Recordings of ROS by the built-in maps: topics found by their types, and clocks brought together.

use crate::mcap;

use mcap::{Cdr, Mcap};
use touchdown_log::{Log, Map, Survey};
use touchdown_trial::Trial;

const EPOCH_NS: u64 = 1_700_000_000_000_000_000;
const STEP_NS: u64 = 4_000_000;
const HEADER: &str = "std_msgs/Header header\n";
const PARTS: &str = "===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
    ===\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n\
    ===\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n\
    ===\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n\
    ===\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n";

fn definition(fields: &str) -> String {
    format!("{HEADER}{fields}\n{PARTS}")
}

/// Half a second at 250 Hz of a vehicle that leans by 0.2 rad.
struct Flight {
    imus: usize,
    motors: [f64; 4],
    range_m: f64,
    poses: usize,
}

const WHOLE: Flight = Flight {
    imus: 1,
    motors: [0.5, 0.6, 0.7, 0.6],
    range_m: 2.0,
    poses: 1,
};

impl Flight {
    fn log(&self) -> Log {
        let mut file = Mcap::new();
        let imu_kind = definition(
            "geometry_msgs/Quaternion orientation\ngeometry_msgs/Vector3 linear_acceleration",
        );
        let imus: Vec<u16> = (0..self.imus)
            .map(|k| file.topic(&format!("/imu_{k}"), "sensor_msgs/msg/Imu", &imu_kind))
            .collect();
        let range = definition("float32 min_range\nfloat32 max_range\nfloat32 range");
        let range = file.topic("/down", "sensor_msgs/msg/Range", &range);
        let battery = definition("float32 voltage");
        let battery = file.topic("/power", "sensor_msgs/msg/BatteryState", &battery);
        let motors = "std_msgs/MultiArrayLayout layout\nfloat64[] data\n===\n\
            MSG: std_msgs/MultiArrayLayout\nuint32 data_offset\n";
        let motors = file.topic("/cmd", "std_msgs/msg/Float64MultiArray", motors);
        let pose = definition("geometry_msgs/Pose pose");
        let poses: Vec<u16> = (0..self.poses)
            .map(|k| {
                file.topic(
                    &format!("/pose_{k}"),
                    "geometry_msgs/msg/PoseStamped",
                    &pose,
                )
            })
            .collect();
        let (sin, cos) = 0.1_f64.sin_cos();
        for k in 0..125 {
            let at = EPOCH_NS + STEP_NS * k;
            // The recorder is late by up to 3 ms.
            let late = at + k % 4 * 1_000_000;
            let lean = [sin, 0.0, 0.0, cos];
            for &imu in &imus {
                let message = Cdr::new().header(at).f64s(&lean).f64s(&[0.0, 0.0, 9.81]);
                file.message(imu, late, &message);
            }
            if k % 5 == 0 {
                let message = Cdr::new()
                    .header(at)
                    .f32s(&[0.05, 10.0, self.range_m as f32]);
                file.message(range, late, &message);
                file.message(battery, late, &Cdr::new().header(at).f32s(&[12.5]));
            }
            let message = Cdr::new().u32(0).u32(4).f64s(&self.motors);
            file.message(motors, at, &message);
            for &pose in &poses {
                let message = Cdr::new().header(at).f64s(&[1.0, 2.0, 3.0]).f64s(&lean);
                file.message(pose, late, &message);
            }
        }
        Log::from_bytes("ros.mcap", file.finish()).unwrap()
    }

    fn survey(&self) -> Survey {
        self.log().survey().unwrap().0
    }

    fn trial(&self) -> Trial {
        let (trial, findings) = self.log().trial(None).unwrap();
        assert!(!findings.is_lossy(), "{findings:?}");
        trial
    }
}

/// The middle of a channel, where all topics have begun.
fn middle(trial: &Trial, channel: &str) -> f64 {
    trial.require(channel).unwrap()[60]
}

#[test]
fn analytic_a_flight_of_ros_by_the_types_of_its_topics() {
    let survey = WHOLE.survey();
    assert_eq!(survey.recommended_map(), Some("ros"));
    assert_eq!(survey.lacks(), [""; 0]);
    let imu = survey.topic("/imu_0").unwrap();
    assert_eq!(imu.kind.as_deref(), Some("sensor_msgs/Imu"));
    let trial = WHOLE.trial();
    assert_eq!(trial.len(), 125);
    // By the headers and not by the recorder, whose stamps jump.
    assert!(
        trial
            .time_s()
            .windows(2)
            .all(|t| (t[1] - t[0] - 0.004).abs() < 1e-9)
    );
    for (channel, value) in [
        ("throttle", 0.6),
        ("specific_force_mps2", 9.81),
        ("tilt_rad", 0.2),
        ("height_m", 2.0 * 0.2_f64.cos()),
        ("battery_v", 12.5),
    ] {
        let found = middle(&trial, channel);
        // Some roundings of numbers up to 12.5, and of an arc cosine far from 1.
        assert!((found - value).abs() < 1e-12, "{channel}: {found}");
    }
}

#[test]
fn analytic_numbers_that_cannot_be_throttles_or_ranges_are_none() {
    let odd = Flight {
        motors: [350.0, 360.0, 340.0, 0.5],
        range_m: f64::INFINITY,
        ..WHOLE
    };
    let (trial, findings) = odd.log().trial(None).unwrap();
    assert!(trial.channel("throttle").is_none() && trial.channel("height_m").is_none());
    for channel in ["throttle", "height_m"] {
        let told = format!("{channel}: omitted, because it has no value");
        assert!(findings.warnings.contains(&told), "{findings:?}");
    }
}

#[test]
fn analytic_what_is_there_twice_is_not_guessed() {
    let twice = Flight { imus: 2, ..WHOLE };
    let survey = twice.survey();
    // The poses carry the trial; which accelerometer it is nobody knows.
    assert_eq!(survey.recommended_map(), Some("ros"));
    assert!(twice.trial().channel("specific_force_mps2").is_none());
    let [lacks] = &survey.lacks()[..] else {
        panic!("{:?}", survey.lacks())
    };
    assert!(
        lacks.contains("specific force") && lacks.contains("/imu_0, /imu_1"),
        "{lacks}"
    );
    let none = Flight {
        imus: 0,
        poses: 0,
        ..WHOLE
    };
    let lacks = none.survey().lacks();
    assert!(
        lacks[0].contains("there is no topic of") && lacks[0].contains("sensor_msgs/Imu"),
        "{lacks:?}"
    );
}

/// Topics of PX4 as its bridge hands them to ROS 2: stamped since the autopilot's start, recorded late.
#[test]
fn analytic_px4_in_ros_2_by_its_own_clock() {
    let mut file = Mcap::new();
    let kind = |name: &str| format!("px4_msgs/msg/{name}");
    let combined = file.topic(
        "/fmu/out/sensor_combined",
        &kind("SensorCombined"),
        "uint64 timestamp\nfloat32[3] accelerometer_m_s2\n",
    );
    let attitude = file.topic(
        "/fmu/out/vehicle_attitude_v1",
        &kind("VehicleAttitude"),
        "uint64 timestamp\nuint64 timestamp_sample\nfloat32[4] q\n",
    );
    let motors = file.topic(
        "/fmu/out/actuator_motors",
        &kind("ActuatorMotors"),
        "uint64 timestamp\nuint64 timestamp_sample\nuint16 reversible_flags\nfloat32[12] control\n",
    );
    let imu = definition("geometry_msgs/Vector3 linear_acceleration");
    let ros = file.topic("/camera/imu", "sensor_msgs/msg/Imu", &imu);
    for k in 0..250_u64 {
        let own_us = 7_000_000 + 4000 * k;
        // The first message waits for half a second, the others for 2 to 20 ms.
        let late_ns = if k == 0 {
            500_000_000
        } else {
            2_000_000 + k * 7 % 19 * 1_000_000
        };
        let at = EPOCH_NS + STEP_NS * k;
        let throttle = 0.5 + 0.001 * k as f32;
        let gone = f32::NAN;
        let mut controls = [gone; 12];
        controls[..4].fill(throttle);
        file.message(
            combined,
            at + late_ns,
            &Cdr::new().u64(own_us).f32s(&[0.0, 0.0, -9.5]),
        );
        file.message(
            attitude,
            at + late_ns,
            &Cdr::new()
                .u64(own_us)
                .u64(own_us)
                .f32s(&[1.0, 0.0, 0.0, 0.0]),
        );
        let message = Cdr::new().u64(own_us).u64(own_us).u32(0).f32s(&controls);
        file.message(motors, at + late_ns, &message);
        file.message(ros, at, &Cdr::new().header(at).f64s(&[0.0, 0.0, 1.0]));
    }
    let log = Log::from_bytes("px4.mcap", file.finish()).unwrap();
    let (survey, findings) = log.survey().unwrap();
    assert_eq!(survey.recommended_map(), Some("px4"));
    assert!(
        findings
            .warnings
            .iter()
            .any(|w| w.contains("autopilot's own clock"))
    );
    // The first record lies 500 ms after its sample, and is the zero of the log; the least delay is 2 ms.
    let begins = survey
        .topic("/fmu/out/sensor_combined")
        .unwrap()
        .first_s
        .unwrap();
    assert!((begins + 0.498).abs() < 1e-9, "{begins}");
    let camera = survey.topic("/camera/imu").unwrap().first_s.unwrap();
    assert!((camera + 0.5).abs() < 1e-9, "{camera}");
    let (trial, _) = log.trial(None).unwrap();
    assert_eq!(trial.len(), 250);
    assert!(
        trial
            .time_s()
            .windows(2)
            .all(|t| (t[1] - t[0] - 0.004).abs() < 1e-9)
    );
    let throttle = trial.require("throttle").unwrap();
    for k in [0, 1, 100, 249] {
        // Single precision.
        assert!(
            (throttle[k] - 0.5 - 0.001 * k as f64).abs() < 1e-6,
            "{k}: {}",
            throttle[k]
        );
    }
    assert!((middle(&trial, "specific_force_mps2") - 9.5).abs() < 1e-9);
    // A map reaches a topic that is named otherwise than in the map.
    let map = "schema = 1\nclock = 'sensor_combined'\n[channels]\ntime_s = 'time_s'\nthrottle = '\"actuator_motors.control[0]\"'\n[topics.actuator_motors]\noffset_s = 10.0\njoin = 'hold'\nlimit_s = 1.0\n";
    let (late, _) = log
        .trial(Some(&Map::parse("m.toml", map).unwrap()))
        .unwrap();
    assert!(late.require("throttle").unwrap().iter().all(|v| v.is_nan()));
}

/// An autopilot that starts anew: the first message of either run is late, by 500 ms and by 30 ms,
/// all others by 2 ms.
#[test]
fn regress_a_second_start_of_the_autopilot_is_brought_to_the_recorder_by_its_own_delays() {
    let mut file = Mcap::new();
    let combined = file.topic(
        "/fmu/out/sensor_combined",
        "px4_msgs/msg/SensorCombined",
        "uint64 timestamp\nfloat32[3] accelerometer_m_s2\n",
    );
    let other = file.topic("/fmu/out/other", "px4_msgs/msg/Other", "uint64 timestamp\n");
    for k in 0..200_u64 {
        let (own_us, late_ns) = match k {
            0 => (50_000_000, 500_000_000),
            1..100 => (50_000_000 + 4000 * k, 2_000_000),
            100 => (1_000_000, 30_000_000),
            _ => (1_000_000 + 4000 * (k - 100), 2_000_000),
        };
        let at = EPOCH_NS + STEP_NS * k + late_ns;
        let message = Cdr::new().u64(own_us).f32s(&[0.0, 0.0, -9.5]);
        file.message(combined, at, &message);
        // Falls silent with the restart.
        if k < 50 {
            file.message(other, at, &Cdr::new().u64(own_us));
        }
    }
    let log = Log::from_bytes("restart.mcap", file.finish()).unwrap();
    // Counted from the first record, 500 ms after its sample, less the least delay.
    let sampled = |k: i32| 0.004 * f64::from(k) - 0.498;
    let (survey, _) = log.survey().unwrap();
    for (topic, last) in [("sensor_combined", 199), ("other", 49)] {
        let topic = survey.topic(&format!("/fmu/out/{topic}")).unwrap();
        let ends = [topic.first_s.unwrap(), topic.last_s.unwrap()];
        for (found, k) in ends.into_iter().zip([0, last]) {
            // Whole nanoseconds.
            assert!((found - sampled(k)).abs() < 1e-9, "{}: {found}", topic.key);
        }
    }
    let map = "schema = 1\nclock = 'sensor_combined'\n[channels]\ntime_s = 'time_s'\n";
    let map = Map::parse("m.toml", map).unwrap();
    let (trial, _) = log.trial(Some(&map)).unwrap();
    assert_eq!(trial.len(), 200);
    for (k, found) in (0..).zip(trial.time_s()) {
        assert!((found - sampled(k)).abs() < 1e-9, "{k}: {found}");
    }
}

/// A landing as `touchdown land` records it: JSON, times from the start, motors that are off at first.
#[test]
fn analytic_a_landing_in_json() {
    let mut file = Mcap::new();
    let imu = file.json("/imu", "sensor_msgs/msg/Imu");
    let motors = file.json("/motors", "touchdown.Motors");
    let range = file.json("/range", "sensor_msgs/msg/Range");
    for k in 0..250_u64 {
        let at = STEP_NS * k;
        let header = format!(r#""header":{{"stamp":{{"sec":0,"nanosec":{at}}},"frame_id":"v"}}"#);
        let up = r#""orientation":{"x":0.0,"y":0.0,"z":0.0,"w":1.0},"linear_acceleration":{"x":0.0,"y":0.0,"z":9.8}"#;
        // Recorded 1 ms late.
        file.message(imu, at + 1_000_000, format!("{{{header},{up}}}").as_bytes());
        let throttle = if k < 50 {
            "null,\"1\":null,\"2\":null,\"3\":null"
        } else {
            "0.5,\"1\":0.5,\"2\":0.6,\"3\":0.4"
        };
        let text = format!("{{{header},\"throttle\":{{\"0\":{throttle}}}}}");
        file.message(motors, at + 1_000_000, text.as_bytes());
        if k % 5 == 0 {
            let text = format!(r#"{{{header},"min_range":0.05,"max_range":8.0,"range":1.5}}"#);
            file.message(range, at + 1_000_000, text.as_bytes());
        }
    }
    let log = Log::from_bytes("landing.mcap", file.finish()).unwrap();
    let (survey, _) = log.survey().unwrap();
    assert_eq!(
        (survey.recommended_map(), survey.lacks()),
        (Some("ros"), Vec::new())
    );
    // By its header, before what the recorder first saw.
    assert!((survey.topic("/imu").unwrap().first_s.unwrap() + 0.001).abs() < 1e-12);
    let (trial, _) = log.trial(None).unwrap();
    let throttle = trial.require("throttle").unwrap();
    assert!(throttle[..50].iter().all(|v| v.is_nan()));
    assert!(throttle[50..].iter().all(|v| (v - 0.5).abs() < 1e-12));
    assert_eq!(middle(&trial, "height_m"), 1.5);
    assert_eq!(middle(&trial, "specific_force_mps2"), 9.8);
}
