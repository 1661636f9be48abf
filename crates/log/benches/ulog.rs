//! A ULog of 13 MB to a trial, beside the crate `px4-ulog` reading the same file.
//!
//! Times are those on the processor, so that other work on the machine counts for little:
//! `cargo bench -p touchdown-log`.
#![allow(clippy::print_stdout)]

use px4_ulog::full_parser;
use px4_ulog::stream_parser::file_reader::{
    Message, SimpleCallbackResult, read_file_with_simple_callback,
};
use std::path::Path;
use touchdown_log::{Log, UlogWriter, read_trial};

const RUNS: usize = 40;
/// Messages of the accelerometer; the rest follows.
const SAMPLES: u64 = 72_000;

/// A flight of 288 s with the topics of a usual log and those of high rate.
fn write(path: &Path) {
    let mut log = UlogWriter::new(Vec::new(), 1_000_000).unwrap();
    log.parameter("THR_MDL_FAC", 0.3).unwrap();
    // Name, fields, numbers beside the stamp, and every how many samples.
    let topics: [(&str, &str, usize, u64); 9] = [
        (
            "sensor_combined",
            "float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;uint8_t accelerometer_clipping;uint8_t gyro_clipping;uint8_t accel_calibration_count;uint8_t gyro_calibration_count",
            13,
            1,
        ),
        (
            "vehicle_angular_velocity",
            "uint64_t timestamp_sample;float[3] xyz;float[3] xyz_derivative",
            7,
            1,
        ),
        (
            "actuator_motors",
            "uint64_t timestamp_sample;float[12] control;uint16_t reversible_flags",
            14,
            2,
        ),
        (
            "vehicle_attitude",
            "uint64_t timestamp_sample;float[4] q;float[4] delta_q_reset;uint8_t quat_reset_counter",
            10,
            5,
        ),
        (
            "vehicle_local_position",
            "float x;float y;float z;float vx;float vy;float vz;float[20] more;float dist_bottom;bool dist_bottom_valid",
            28,
            10,
        ),
        (
            "distance_sensor",
            "uint32_t device_id;float min_distance;float max_distance;float current_distance;float variance;int8_t signal_quality;uint8_t type;float h_fov;float v_fov;float[4] q;uint8_t orientation",
            14,
            10,
        ),
        (
            "battery_status",
            "float voltage_v;float voltage_filtered_v;float current_a;float[20] more",
            23,
            50,
        ),
        (
            "esc_status",
            "uint16_t counter;uint8_t esc_count;float[40] esc",
            42,
            25,
        ),
        (
            "estimator_states",
            "float[24] states;uint8_t n_states;float[24] covariances",
            49,
            5,
        ),
    ];
    for (name, fields, ..) in topics {
        log.format(name, fields).unwrap();
    }
    let ids: Vec<_> = topics
        .iter()
        .map(|topic| log.topic(topic.0, 0).unwrap())
        .collect();
    for i in 0..SAMPLES {
        for (k, &(_, _, numbers, every)) in topics.iter().enumerate() {
            if i % every == 0 {
                let values: Vec<f64> = (0..numbers)
                    .map(|n| ((i + n as u64) % 97) as f64 * 0.01)
                    .collect();
                log.message(ids[k], 1_000_000 + 4000 * i, &values).unwrap();
            }
        }
    }
    std::fs::write(path, log.finish().unwrap()).unwrap();
}

/// Time of this thread on the processor, in ms; by the clock where the system does not tell.
fn now_ms(start: std::time::Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let ns = told.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    ns.map_or_else(|| start.elapsed().as_secs_f64() * 1e3, |ns| ns * 1e-6)
}

/// The mean of some runs, for the system tells times in ticks of some ms.
fn mean_ms(mut run: impl FnMut()) -> f64 {
    let start = std::time::Instant::now();
    let before = now_ms(start);
    (0..RUNS).for_each(|_| run());
    (now_ms(start) - before) / RUNS as f64
}

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.ulg");
    write(&path);
    let text = path.display().to_string();
    println!(
        "{:.1} MB",
        std::fs::metadata(&path).unwrap().len() as f64 / 1e6
    );
    let full = mean_ms(|| drop(full_parser::read_file(&text).unwrap()));
    let mut messages = 0;
    let passing = mean_ms(|| {
        messages = 0;
        let mut count = |message: &Message<'_>| {
            messages += usize::from(matches!(message, Message::Data(_)));
            SimpleCallbackResult::KeepReading
        };
        read_file_with_simple_callback(&text, &mut count).unwrap();
    });
    let mut rows = 0;
    let trial = mean_ms(|| rows = read_trial(&path, None).unwrap().0.len());
    let log = Log::open(&path).unwrap().unwrap();
    let survey = mean_ms(|| drop(log.survey().unwrap()));
    println!("px4-ulog, all columns     {full:8.1} ms");
    println!("px4-ulog, messages only   {passing:8.1} ms, {messages} messages");
    println!("trial of seven channels   {trial:8.1} ms, {rows} rows");
    println!("survey of every value     {survey:8.1} ms");
    println!("trial / px4-ulog          {:8.2}", trial / full);
}
