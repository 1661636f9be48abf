//! Recordings and Parquet files that the usual tools wrote (`tests/reference/fixtures.py`).

use crate::mcap;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use touchdown_log::{Log, LogFormat, Map, Survey, inspect, inspect_file, read_table, read_trial};

fn fixture(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/reference/fixtures")
        .join(file)
}

fn survey(file: &str) -> Survey {
    let log = Log::open(fixture(file))
        .unwrap()
        .expect("a log with topics");
    let (survey, findings) = log.survey().unwrap();
    assert!(!findings.is_lossy(), "{findings:?}");
    survey
}

/// Counts equal and sums within 1e-12 of those of `mcap` 1.6.0 and `rosbags` 0.11.9, which add
/// the same numbers, up to 720 of them, exactly.
#[test]
fn xval_counts_and_sums_of_every_field() {
    let mut surveys: BTreeMap<&str, Survey> = BTreeMap::new();
    let mut compared: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for line in include_str!("reference/fields.tsv").lines() {
        let cells: Vec<&str> = line.split('\t').collect();
        let [file, topic, field, count, sum] = cells[..] else {
            panic!("{line}")
        };
        if topic.is_empty() {
            continue;
        }
        let survey = surveys.entry(file).or_insert_with(|| survey(file));
        let found = survey.topic(topic).unwrap_or_else(|| panic!("{line}"));
        let found = found.field(field).unwrap_or_else(|| panic!("{line}"));
        let (count, sum): (usize, f64) = (count.parse().unwrap(), sum.parse().unwrap());
        assert_eq!(found.count, count, "{line}");
        assert!(
            (found.sum - sum).abs() <= 1e-12 * sum.abs().max(100.0),
            "{line}: {}",
            found.sum
        );
        *compared.entry((file, topic)).or_default() += 1;
    }
    for ((file, topic), compared) in compared {
        let fields = &surveys[file].topic(topic).unwrap().fields;
        // The rest are elements that no message has.
        let filled = fields.iter().filter(|field| field.count > 0).count();
        assert!(compared >= filled, "{file} {topic}: {compared} of {filled}");
    }
}

#[test]
fn analytic_stamps_of_headers_where_they_agree_with_the_recorder() {
    let survey = survey("ros2.mcap");
    assert_eq!(survey.format, LogFormat::Mcap);
    let imu = survey.topic("/imu/data").unwrap();
    // Stamped every 4 ms; the recorder is late by up to 3 ms, also on the first message.
    assert!((imu.rate_hz.unwrap() - 250.0).abs() < 1e-6);
    assert!((imu.longest_step_s.unwrap() - 0.004).abs() < 1e-12);
    assert!((-0.003..=0.0).contains(&imu.first_s.unwrap()));
    assert_eq!(imu.texts, ["header.frame_id"]);
    // Stamps from another clock are passed over for the recorder's.
    let range = survey.topic("/range").unwrap();
    assert_eq!(range.messages, 6);
    assert!(range.first_s.unwrap().abs() < 1e-6 && range.last_s.unwrap() < 0.21);
}

#[test]
fn prop_topics_of_ros_2_by_the_map_of_px4_and_by_a_map() {
    let map = Map::parse(
        "m.toml",
        r#"
schema = 1
clock = "/imu/data"
[channels]
time_s = 'time_s'
up = '"/imu/data.linear_acceleration.z"'
range = '"/range.range"'
motor = '"actuator_motors.control[3]"'
[topics."/range"]
join = "hold"
"#,
    )
    .unwrap();
    let (trial, findings) = read_trial(fixture("ros2.mcap"), Some(&map)).unwrap();
    assert!(!findings.is_lossy());
    assert_eq!(trial.len(), 60);
    let known = |name: &str| {
        trial
            .channel(name)
            .unwrap()
            .iter()
            .filter(|v| v.is_finite())
            .count()
    };
    assert_eq!(known("up"), 60);
    // Held for ten steps of 40 ms; the first sample may be stamped before it came.
    assert!(known("range") >= 59);
    // Between the first and the last command.
    assert!((56..=60).contains(&known("motor")));
}

#[test]
fn analytic_json_with_fields_that_come_late() {
    let survey = survey("json.mcap");
    let vehicle = survey.topic("/vehicle").unwrap();
    assert_eq!(vehicle.field("height_m").unwrap().count, 29);
    assert_eq!(vehicle.field("landed").unwrap().sum, 9.0);
    assert_eq!(vehicle.texts, ["phase"]);
    assert_eq!(survey.topic("/note").unwrap().messages, 60);
    let map = Map::parse(
        "m.toml",
        "schema = 1\nclock = '/vehicle'\n[channels]\ntime_s = 'time_s'\nheight_m = '\"/vehicle.height_m\"'\nx = '\"/vehicle.throttle[3]\"'\n",
    );
    let (trial, _) = read_trial(fixture("json.mcap"), Some(&map.unwrap())).unwrap();
    let height = trial.channel("height_m").unwrap();
    assert_eq!(height.iter().filter(|v| v.is_nan()).count(), 31);
    assert!(height[30].is_nan() && height[31].is_finite());
    assert_eq!(trial.len(), 60);
    assert!((trial.duration_s() - 0.59).abs() < 1e-9);
}

#[test]
fn xval_a_parquet_file() {
    let (table, findings) = read_table(fixture("table.parquet")).unwrap();
    assert_eq!((table.len(), findings.rows_used), (1000, 1000));
    for line in include_str!("reference/fields.tsv")
        .lines()
        .filter(|l| l.starts_with("table"))
    {
        let cells: Vec<&str> = line.split('\t').collect();
        let values = table.column(cells[2]).unwrap().values();
        let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        assert_eq!(known.len(), cells[3].parse::<usize>().unwrap(), "{line}");
        let sum: f64 = cells[4].parse().unwrap();
        // A thousand numbers in another order.
        assert!(
            (known.iter().sum::<f64>() - sum).abs() < 1e-10 * sum.abs().max(1.0),
            "{line}"
        );
    }
    let at = table.column("at").unwrap().values();
    assert!((at[999] - 9.99).abs() < 1e-12);
    assert!(table.column("name").unwrap().is_text() && table.column("pair.list.element").is_none());
    assert_eq!(findings.empty_cells["thrust_n"], 143);
    // As it is, for it has our names; and by a map, in other columns and rows.
    let (trial, _) = read_trial(fixture("table.parquet"), None).unwrap();
    assert_eq!(trial.len(), 1000);
    let map = Map::parse(
        "m.toml",
        "schema = 1\n[channels]\ntime_s = 'at'\nx = '2 * count'\n",
    )
    .unwrap();
    let (trial, findings) = read_trial(fixture("table.parquet"), Some(&map)).unwrap();
    assert_eq!(trial.channel("x").unwrap()[199], 398.0);
    assert!(findings.text_columns.is_empty(), "nothing else is read");
}

#[test]
fn xval_decimal_fractions_of_a_parquet_file_are_numbers() {
    // (i - 10)/8 with three digits after the point, from pyarrow's decimals of 4, 8 and 16 bytes.
    let (table, _) = read_table(fixture("decimal.parquet")).unwrap();
    for name in ["of_9", "of_18", "of_38"] {
        let values = table.column(name).unwrap().values();
        for (i, value) in values.iter().enumerate() {
            match i % 7 {
                0 => assert!(value.is_nan(), "{name}"),
                // Eighths are exact in three digits and in binary.
                _ => assert_eq!(*value, (i as f64 - 10.0) / 8.0, "{name}"),
            }
        }
    }
}

#[test]
fn analytic_parquet_files_without_rows_or_of_another_compression_are_named() {
    let error = |file: &str| read_table(fixture(file)).unwrap_err().to_string();
    let text = error("../refused/no_rows.parquet");
    assert!(
        text.ends_with("no usable rows: the file has none"),
        "{text}"
    );
    let text = error("../refused/brotli.parquet");
    assert!(
        text.contains("compressed by brotli, which is not read"),
        "{text}"
    );
}

#[test]
fn prop_a_file_in_parts_is_told_as_its_table_is() {
    // Row groups of 300 and 700 rows.
    let path = fixture("table.parquet");
    let (table, read) = read_table(&path).unwrap();
    let (seen, findings) = inspect_file(&path).unwrap();
    assert_eq!((seen.rows, findings), (1000, read));
    assert_eq!(seen, inspect(&table, None));
}

#[test]
fn analytic_stamps_in_json_and_stamps_out_of_this_world() {
    let span = |seconds: [&str; 2]| {
        let mut file = mcap::Mcap::new();
        let channel = file.json("/a", "Any");
        for (recorded_s, sec) in [1_700_000_005, 1_700_000_006].into_iter().zip(seconds) {
            let text =
                format!(r#"{{"header":{{"stamp":{{"sec":{sec},"nanosec":900000000}}}},"x":1}}"#);
            file.message(channel, recorded_s * 1_000_000_000, text.as_bytes());
        }
        let log = Log::from_bytes("log.mcap", file.finish()).unwrap();
        let (survey, _) = log.survey().unwrap();
        [survey.topics[0].first_s, survey.topics[0].last_s].map(Option::unwrap)
    };
    // 0.1 s before they were recorded.
    assert_eq!(span(["1700000004", "1700000005"]), [-0.1, 0.9]);
    for bad in ["1e300", "-1e300", "18446744073709551615", "1e10", "\"4\""] {
        assert_eq!(span([bad, bad]), [0.0, 1.0], "{bad}");
    }
}
