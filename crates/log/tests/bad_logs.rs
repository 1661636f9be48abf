//! Logs that are cut, damaged, empty, or that lie about their sizes.

use crate::common;
#[path = "../fuzz/src/lib.rs"]
#[allow(unreachable_pub, dead_code)]
mod fuzz;

use common::{dataflash, fixture, good_ulog};
use proptest::prelude::*;
use touchdown_log::{
    ErrorKind, Findings, Log, LogError, LogFormat, Survey, UlogWriter, read_parquet, read_trial,
};

fn every_format() -> [(&'static str, Vec<u8>); 6] {
    [
        ("ulog", good_ulog()),
        ("dataflash", dataflash()),
        ("zstd.mcap", fixture("ros2.mcap")),
        ("lz4.mcap", fixture("json.mcap")),
        ("plain.bag", fixture("plain.bag")),
        ("bz2.bag", fixture("bz2.bag")),
    ]
}

/// All that can be done with bytes; whatever they are, it ends, and without a panic.
fn survey(name: &str, bytes: Vec<u8>) -> Result<(Survey, Findings), LogError> {
    if LogFormat::of(&bytes).is_none() {
        return Err(LogError::Empty {
            path: name.to_owned(),
        });
    }
    fuzz::any_log(&bytes);
    Log::from_bytes(name, bytes).unwrap().survey()
}

#[test]
fn prop_a_cut_file_gives_its_prefix_and_says_so() {
    for (name, bytes) in every_format() {
        let (whole, findings) = survey(name, bytes.clone()).unwrap();
        assert!(!findings.is_lossy(), "{name}: {findings:?}");
        // The data end before the index does.
        let mut before = 0;
        let mut lossy = 0;
        for cut in (0..bytes.len()).step_by(bytes.len() / 97) {
            match survey(name, bytes[..cut].to_vec()) {
                Ok((part, findings)) => {
                    assert!(part.messages() >= before && part.messages() <= whole.messages());
                    assert!(findings.corrupt_rows == 0, "{name} at {cut}: {findings:?}");
                    before = part.messages();
                    lossy += usize::from(findings.is_lossy());
                    // The same numbers as far as they go.
                    for topic in part.topics.iter().filter(|topic| topic.messages > 0) {
                        let same = whole.topic(&topic.key).unwrap();
                        // Where an autopilot's own clock lies shows in the least delay of all
                        // messages that are there; in the file these are of 0 to 3 ms.
                        let own = topic.kind.as_ref().is_some_and(|k| k.starts_with("px4"));
                        let slack_s = if own { 0.003 } else { 0.0 };
                        let [first_s, whole_s] =
                            [topic, same].map(|t| t.first_s.unwrap_or(f64::MIN));
                        let off_s = first_s - whole_s;
                        assert!((0.0..=slack_s).contains(&off_s), "{name} {}", topic.key);
                    }
                }
                Err(error) => {
                    assert_eq!(error.kind(), ErrorKind::Unreadable, "{error}");
                    assert_eq!(before, 0, "{name} at {cut}: {error}");
                }
            }
        }
        assert!(before > whole.messages() / 2, "{name}: {before}");
        // Hardly any cut falls between two records; of a chunk of one block all is lost or nothing.
        let fewest = if name == "bz2.bag" { 1 } else { 20 };
        assert!(lossy > fewest, "{name}: {lossy}");
    }
}

#[test]
fn analytic_a_cut_inside_of_the_last_message_costs_that_message() {
    let bytes = good_ulog();
    let (part, findings) = survey("cut", bytes[..bytes.len() - 3].to_vec()).unwrap();
    assert_eq!(part.messages(), 139, "of 140");
    assert!(findings.truncated && findings.is_lossy());
    let bytes = dataflash();
    let (part, findings) = survey("cut", bytes[..bytes.len() - 3].to_vec()).unwrap();
    // The last is the 60th of the accelerometer, of instance 1.
    assert_eq!(part.topic("IMU#1").unwrap().messages, 29);
    assert_eq!(part.topic("IMU").unwrap().messages, 30);
    assert_eq!(
        part.topic("IMU#1").unwrap().field("AccZ").unwrap().max,
        Some(f64::from(-10.81_f32))
    );
    assert!(findings.truncated);
}

#[test]
fn analytic_reading_goes_on_after_damage() {
    let bytes = good_ulog();
    // A length and a type in the middle.
    let place = bytes.len() / 2;
    let at = (place..)
        .find(|&i| bytes[i + 2] == b'D' && bytes[i + 1] == 0)
        .unwrap();
    let mut damaged = bytes.clone();
    damaged[at..at + 3].fill(0xee);
    let (part, findings) = survey("damaged", damaged).unwrap();
    assert_eq!(part.messages(), 139);
    assert_eq!((findings.corrupt_rows, findings.truncated), (1, false));
    assert!(
        findings.loss().unwrap().contains("1 corrupt"),
        "{findings:?}"
    );
    // A definition turned by one bit into a mark that says how to read: that is for the start only.
    let mut marked = bytes.clone();
    let text = b"never:uint64_t timestamp;float x;";
    let head = bytes.windows(text.len()).position(|w| w == text).unwrap() - 3;
    marked[head + 2] ^= b'F' ^ b'B';
    let (part, findings) = survey("marked", marked).unwrap();
    assert_eq!(part.messages(), 140);
    assert!(findings.is_lossy());
    // A topic without a usable format costs no other.
    let mut unknown = bytes.clone();
    unknown[head + 3] = b'N';
    let (part, findings) = survey("unknown", unknown).unwrap();
    assert_eq!((part.messages(), findings.corrupt_rows), (140, 1));
    // Bytes in between, as after a write that failed.
    let noise: Vec<u8> = (0..5000_u32).map(|i| ((i * i) >> 3) as u8).collect();
    let mut longer = bytes[..at].to_vec();
    longer.extend(&noise);
    longer.extend(&bytes[at..]);
    let (part, findings) = survey("longer", longer).unwrap();
    assert_eq!((part.messages(), findings.corrupt_rows), (140, 1));

    let bytes = dataflash();
    let mut longer = bytes[..bytes.len() - 24].to_vec();
    longer.extend([0x5a; 500]);
    longer.extend(&bytes[bytes.len() - 24..]);
    let (part, findings) = survey("longer", longer).unwrap();
    assert_eq!(part.topic("IMU#1").unwrap().messages, 30);
    assert_eq!(findings.corrupt_rows, 1);
    // Zeros at the end are room that was not used.
    let mut roomy = bytes;
    roomy.extend([0; 4096]);
    assert!(!survey("roomy", roomy).unwrap().1.is_lossy());
}

#[test]
fn analytic_a_chunk_whose_checksum_is_wrong_is_left_out() {
    let bytes = fixture("json.mcap");
    let (whole, _) = survey("whole", bytes.clone()).unwrap();
    let mut left_out = 0;
    // The first chunk tells the channels; without it nothing is left.
    for at in (2000..bytes.len() / 2).step_by(61) {
        let mut bytes = bytes.clone();
        bytes[at] ^= 0x10;
        let (part, findings) = survey("flipped", bytes).unwrap();
        if findings.is_lossy() {
            assert!(part.messages() < whole.messages(), "{at}");
            left_out += 1;
        } else {
            // A place between the chunks.
            assert_eq!(part.topics, whole.topics, "{at}");
        }
    }
    assert!(left_out > 50, "{left_out}");
}

#[test]
fn regress_what_a_damaged_chunk_takes_along_is_told() {
    let bytes = fixture("ros2.mcap");
    let (whole, _) = survey("whole", bytes.clone()).unwrap();
    let mut told = 0;
    for at in (0..bytes.len() / 2).step_by(97) {
        let mut bytes = bytes.clone();
        bytes[at] ^= 0x10;
        // The first chunk tells the channels; without it nothing is left.
        let Ok((part, findings)) = survey("flipped", bytes) else {
            continue;
        };
        let is_of_chunk = |w: &&String| w.starts_with("a damaged chunk of ");
        let Some(text) = findings.warnings.iter().find(is_of_chunk) else {
            continue;
        };
        let missing = whole.messages() - part.messages();
        assert!(
            text.contains(&format!("bytes was skipped, with {missing} messages of ")),
            "{missing}: {text}"
        );
        // Within the record, which the recorder's own times outlast by up to 3 ms; to the three digits that are told.
        let numbers: Vec<f64> = text
            .rsplit_once("messages of ")
            .map(|(_, span)| {
                span.split(' ')
                    .filter_map(|word| word.parse().ok())
                    .collect()
            })
            .unwrap();
        let last_s = whole.duration_s + 0.5e-3 + 0.003;
        assert!(
            numbers.len() == 2 && numbers[0] < numbers[1] && numbers[1] <= last_s,
            "{text}, {last_s}"
        );
        told += 1;
    }
    assert!(told > 10, "{told}");
}

#[test]
fn regress_bytes_after_the_end_of_a_recording_are_told() {
    let mut bytes = fixture("ros2.mcap");
    let (whole, findings) = survey("whole", bytes.clone()).unwrap();
    assert!(!findings.is_lossy());
    bytes.extend([0x5a; 1234]);
    let (same, findings) = survey("longer", bytes).unwrap();
    assert_eq!(same.topics, whole.topics);
    let told = "1234 bytes follow the end of the recording";
    assert!(
        findings.is_lossy() && findings.warnings.iter().any(|w| w == told),
        "{findings:?}"
    );
}

#[test]
fn prop_sizes_of_gigabytes_are_not_believed() {
    let (mut mcap, mut bag) = (fixture("ros2.mcap"), fixture("plain.bag"));
    // The length of the first record behind the header's, and that of the first head.
    mcap[9..17].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    assert!(survey("huge.mcap", mcap).is_err());
    bag[13..17].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(survey("huge.bag", bag).is_err());
    let mut log = UlogWriter::new(Vec::new(), 0).unwrap();
    assert!(log.format("a", "float[70000] x").is_err());
    log.format("a", "b[60000] x").unwrap();
    log.format("b", "a[60000] y").unwrap();
    assert!(log.topic("a", 0).is_err());
}

#[test]
fn prop_empty_files_and_logs_without_a_message() {
    for (name, bytes) in every_format() {
        let error = survey(name, bytes[..20.min(bytes.len())].to_vec()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Unreadable, "{name}: {error}");
    }
    let log = UlogWriter::new(Vec::new(), 0).unwrap().finish().unwrap();
    let error = survey("never.ulg", log).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("a PX4 ULog without a whole message"),
        "{error}"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.ulg");
    std::fs::write(&path, "").unwrap();
    assert!(matches!(
        read_trial(&path, None),
        Err(LogError::Empty { .. })
    ));
    // A table by the name of a log is a table.
    std::fs::write(&path, "time_s,x\n0,1\n1,2\n").unwrap();
    assert_eq!(read_trial(&path, None).unwrap().0.len(), 2);
}

#[test]
fn analytic_data_that_were_appended_after_a_crash() {
    // The mark of appended data and where they start: behind half of a message.
    let bytes = good_ulog();
    let mut log = bytes[..bytes.len() - 5].to_vec();
    let offset = log.len() as u64;
    log[16 + 3 + 8] = 1;
    log[16 + 3 + 16..16 + 3 + 24].copy_from_slice(&offset.to_le_bytes());
    let text = b"5\x00\x00\x00\x00\x00\x00\x00\x00crash";
    log.extend([text.len() as u8, 0, b'L']);
    log.extend(text);
    let (survey, findings) = survey("appended", log.clone()).unwrap();
    assert_eq!(survey.messages(), 139);
    assert!(
        !findings.truncated && findings.corrupt_rows == 0,
        "{findings:?}"
    );
    // A mark that is not known.
    log[16 + 3 + 8] = 2;
    let error = Log::from_bytes("unknown", log)
        .unwrap()
        .survey()
        .unwrap_err();
    assert!(
        error.to_string().contains("unknown incompatibility flag"),
        "{error}"
    );
}

#[test]
fn prop_parquet_files_that_are_cut_or_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    let bytes = fixture("table.parquet");
    std::fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    let error = read_parquet(&path, None).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unreadable, "{error}");
    assert!(error.to_string().contains("log.parquet"), "{error}");
    let mut damaged = bytes.clone();
    // Well inside of the first row group.
    damaged[200..260].fill(0xff);
    std::fs::write(&path, &damaged).unwrap();
    let (table, findings) = read_parquet(&path, None).unwrap();
    assert_eq!(
        (table.len(), findings.rows_read, findings.corrupt_rows),
        (700, 1000, 300)
    );
    assert!(findings.is_lossy());
    assert_eq!(table.row_numbers()[0], 300);
}

#[test]
fn regress_a_list_without_end_in_a_page_of_a_parquet_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    let mut bytes = fixture("table.parquet");
    // The head of the first page: a field that is not known, 2³¹ − 1 numbers of 8 bytes.
    bytes[4..11].copy_from_slice(&[0xf9, 0xf7, 0xff, 0xff, 0xff, 0xff, 0x07]);
    std::fs::write(&path, &bytes).unwrap();
    let (table, findings) = read_parquet(&path, None).unwrap();
    assert_eq!((table.len(), findings.corrupt_rows), (700, 300));
}

#[test]
fn regress_offsets_below_zero_in_a_parquet_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    let bytes = fixture("table.parquet");
    let end = bytes.len() - 8;
    let length = u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap()) as usize;
    let mut refused = 0;
    // The lowest bit of a number in the table of contents is its sign.
    for at in end - length..end {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        std::fs::write(&path, &damaged).unwrap();
        refused += usize::from(match read_parquet(&path, None) {
            Ok((_, findings)) => findings.is_lossy(),
            Err(error) => error.kind() == ErrorKind::Unreadable,
        });
    }
    assert!(refused > 100, "{refused} of {length}");
}

#[test]
fn prop_rows_that_a_parquet_file_only_claims() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    // A whole number of 64 bits in the table of contents: 300 rows, and as many as can be claimed.
    let told = [0x16, 0xd8, 0x04];
    let claims = [&[0x16][..], &[0xfe; 9], &[0x01]].concat();
    let bytes = fixture("table.parquet");
    let end = bytes.len() - 8;
    let length = u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap()) as usize;
    let (data, contents) = bytes[..end].split_at(end - length);
    let places: Vec<usize> = (0..length - 3)
        .filter(|&at| contents[at..].starts_with(&told))
        .collect();
    // Three are those of row groups, others are of their columns.
    let each = places.chunks(1).chain([places.as_slice()]);
    let mut lost = 0;
    for forged in each {
        let (mut new, mut from) = (data.to_vec(), 0);
        for &at in forged {
            new.extend(&contents[from..at]);
            new.extend(&claims);
            from = at + told.len();
        }
        new.extend(&contents[from..]);
        let length = (new.len() - data.len()) as u32;
        new.extend(length.to_le_bytes());
        new.extend(b"PAR1");
        std::fs::write(&path, &new).unwrap();
        let (table, findings) = read_parquet(&path, None).unwrap();
        assert!([1000, 700, 100].contains(&table.len()), "{findings:?}");
        assert_eq!(table.len() < 1000, findings.is_lossy(), "{findings:?}");
        lost += usize::from(findings.is_lossy());
    }
    // By each of the row groups, and by all of them.
    assert_eq!(lost, 4, "{places:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn prop_flipped_bits_never_panic(
        which in 0_usize..6,
        flips in prop::collection::vec((0.0..1.0_f64, 0_u8..8), 1..20),
    ) {
        let (name, mut bytes) = every_format()[which].clone();
        for (place, bit) in flips {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] ^= 1 << bit;
        }
        if let Err(error) = survey(name, bytes) {
            prop_assert_eq!(error.kind(), ErrorKind::Unreadable);
        }
    }

    #[test]
    fn prop_any_bytes_after_the_start_of_a_log_never_panic(
        which in 0_usize..4,
        bytes in prop::collection::vec(any::<u8>(), 0..600),
    ) {
        let start = [0, 1, 2, 4].map(|format| every_format()[format].1[..16].to_vec());
        let log = [start[which].as_slice(), bytes.as_slice()].concat();
        if let Err(error) = survey("bytes", log) {
            prop_assert_eq!(error.kind(), ErrorKind::Unreadable);
        }
    }
}
