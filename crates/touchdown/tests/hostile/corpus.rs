//! Files that a reader must refuse or read with bounded work: each is small, and what it asks for is not.

use std::fmt::Write as _;

use super::parquet::{Column, file as parquet, page_head};
use super::recordings::{Bag, Mcap};

/// A chunk of the size that readers unpack at most.
const CHUNK: usize = 64 << 20;

/// A message definition of ROS in which arrays of messages nest, so that one text has 8⁸ names.
pub(crate) fn nested_definition() -> Vec<u8> {
    let mut text = "M0[8] inner_messages_of_a_long_name\n".to_owned();
    for depth in 0..7 {
        let inner = depth + 1;
        write!(
            text,
            "===\nMSG: a/M{depth}\nM{inner}[8] inner_messages_of_a_long_name\n"
        )
        .unwrap();
    }
    text.push_str("===\nMSG: a/M7\nstring text\n");
    let mut file = Mcap::default();
    file.topic(1, ["/a", "a/A", "ros2msg", &text, "cdr"]);
    file.message(1, 1, &[0, 1, 0, 0, 0, 0, 0, 0]);
    file.file()
}

/// Many topics with a definition of a kilobyte each, which has thousands of parts.
pub(crate) fn wide_definitions() -> Vec<u8> {
    let mut text = "M0 a\nM0 b\nM0 c\nM0 d\n".to_owned();
    for depth in 0..6 {
        let fields: String = ["a", "b", "c", "d"]
            .map(|field| format!("M{} {field}\n", depth + 1))
            .concat();
        write!(text, "===\nMSG: a/M{depth}\n{fields}").unwrap();
    }
    text.push_str("===\nMSG: a/M6\n");
    let mut file = Mcap::default();
    let mut records = Mcap::default();
    for id in 0..4000 {
        records.topic(id, [&format!("/{id}"), "a/A", "ros2msg", &text, "cdr"]);
    }
    records.message(1, 1, &[0, 1, 0, 0, 1]);
    file.chunk(&records.0);
    file.file()
}

/// An object of JSON in which a long name stands before many short ones.
pub(crate) fn nested_json() -> Vec<u8> {
    let inner: Vec<String> = (0..4000).map(|k| format!("\"{k}\":1")).collect();
    let text = format!("{{\"{}\":{{{}}}}}", "n".repeat(1 << 20), inner.join(","));
    let mut file = Mcap::default();
    file.topic(1, ["/a", "a/A", "jsonschema", "{}", "json"]);
    let mut records = Mcap::default();
    (0..20).for_each(|stamp| records.message(1, stamp, text.as_bytes()));
    file.chunk(&records.0);
    file.file()
}

/// Messages of JSON that name 1024 fields, first one by one from the last to the first, and then all.
pub(crate) fn many_json_fields() -> Vec<u8> {
    let mut file = Mcap::default();
    file.topic(1, ["/a", "a/A", "jsonschema", "{}", "json"]);
    let mut records = Mcap::default();
    let field = |k: u64| format!("\"k{k:04}\":1");
    (0..1024).for_each(|k| records.message(1, k, format!("{{{}}}", field(1023 - k)).as_bytes()));
    let all: Vec<String> = (0..1024).map(field).collect();
    let all = format!("{{{}}}", all.join(","));
    (1024..6000).for_each(|stamp| records.message(1, stamp, all.as_bytes()));
    file.chunk(&records.0);
    file.file()
}

/// A bag of chunks of zeros.
pub(crate) fn bzip2_zeros() -> Vec<u8> {
    let mut chunk = Bag::default();
    let zeros = vec![0; CHUNK - 64];
    chunk.record(9, &[], &zeros);
    let mut one = Bag::default();
    one.chunk(&chunk.0);
    let mut file = Bag::default();
    file.connection("/a", "a/A", "uint8 x");
    file.message(1, &[1]);
    let mut bytes = file.file();
    (0..1000).for_each(|_| bytes.extend(&one.0));
    bytes
}

/// A recording of chunks of zeros.
pub(crate) fn zstd_zeros() -> Vec<u8> {
    let mut chunk = Mcap::default();
    chunk.attachment(&vec![0; CHUNK - 64]);
    let mut one = Mcap::default();
    one.chunk(&chunk.0);
    let mut file = Mcap::default();
    file.topic(1, ["/a", "a/A", "ros2msg", "uint8 x", "cdr"]);
    file.message(1, 1, &[0, 1, 0, 0, 1]);
    (0..1_000_000 / one.0.len()).for_each(|_| file.0.extend(&one.0));
    file.file()
}

/// Tiny messages, which compress a hundredfold and more.
pub(crate) fn tiny_messages_mcap() -> Vec<u8> {
    let mut records = Mcap::default();
    for stamp in 0..1_800_000 {
        records.message(1, stamp, &[0, 1, 0, 0, 1]);
    }
    let mut file = Mcap::default();
    file.topic(1, ["/a", "a/A", "ros2msg", "uint8 x", "cdr"]);
    let mut one = Mcap::default();
    one.chunk(&records.0);
    (0..4).for_each(|_| file.0.extend(&one.0));
    file.file()
}

/// Tiny messages of a bag.
pub(crate) fn tiny_messages_bag() -> Vec<u8> {
    let mut records = Bag::default();
    for stamp in 0..1_000_000_u64 {
        records.message(stamp * 1000, &[1]);
    }
    let mut file = Bag::default();
    file.connection("/a", "a/A", "uint8 x");
    let mut one = Bag::default();
    one.chunk(&records.0);
    (0..4).for_each(|_| file.0.extend(&one.0));
    file.file()
}

/// A map that makes many channels of the one field of these messages.
pub(crate) fn wide_map() -> Vec<u8> {
    let mut text = "schema = 1\nclock = '/a'\n[channels]\ntime_s = 'time_s'\n".to_owned();
    for k in 0..40 {
        writeln!(text, "throttle_{k} = '\"/a.x\" + {k}'").unwrap();
    }
    text.into_bytes()
}

/// A map of more channels than any vehicle has.
pub(crate) fn endless_map(channels: usize) -> Vec<u8> {
    let mut text = "schema = 1\n[channels]\ntime_s = 'time_s'\n".to_owned();
    for k in 0..channels {
        writeln!(text, "c{k} = 'x + {k}'").unwrap();
    }
    text.into_bytes()
}

/// A Parquet file with one cell of 1 GiB. The page's head is honest, or states less than there is.
pub(crate) fn parquet_cell(stated: i64) -> Vec<u8> {
    let length: u32 = 1 << 30;
    let mut packer = zstd::Encoder::new(Vec::new(), 3).unwrap();
    std::io::copy(&mut &length.to_le_bytes()[..], &mut packer).unwrap();
    std::io::copy(
        &mut std::io::Read::take(std::io::repeat(b'a'), length.into()),
        &mut packer,
    )
    .unwrap();
    let packed = packer.finish().unwrap();
    let head = page_head(1, i64::from(length) + 4, packed.len());
    let column = Column {
        name: "text".to_owned(),
        kind: 6,
        codec: 6,
        page: [head, packed].concat(),
        unpacked: stated,
    };
    parquet(1, &[column])
}

/// A Parquet file of so many columns, each with one number.
pub(crate) fn parquet_columns(columns: usize) -> Vec<u8> {
    let column = |k: usize| {
        let page = [&page_head(1, 8, 8)[..], &1.0_f64.to_le_bytes()].concat();
        Column {
            name: format!("c{k}"),
            kind: 5,
            codec: 0,
            unpacked: page.len() as i64,
            page,
        }
    };
    let columns: Vec<Column> = (0..columns).map(column).collect();
    parquet(1, &columns)
}

/// A text table of so many columns, with names that suggest as much as names can.
pub(crate) fn csv_columns(columns: usize) -> Vec<u8> {
    let names: Vec<String> = (0..columns).map(|k| format!("m{k}")).collect();
    let rows = ["1", "2", "3"].map(|cell| vec![cell; columns].join(","));
    format!("{}\n{}\n", names.join(","), rows.join("\n")).into_bytes()
}

/// A text table whose header has only delimiters.
pub(crate) fn csv_without_names(columns: usize) -> Vec<u8> {
    let delimiters = ",".repeat(columns);
    format!("a{delimiters}b\n1{delimiters}2\n").into_bytes()
}

/// A recording with a topic, a field and a parameter of this name.
pub(crate) fn named_mcap(name: &str) -> Vec<u8> {
    let mut file = Mcap::default();
    file.topic(1, [name, name, "jsonschema", "{}", "json"]);
    let field = name.replace('\u{1b}', "\\u001b").replace('\n', "\\n");
    for stamp in 0..3 {
        file.message(1, stamp, format!("{{\"{field}\":1}}").as_bytes());
    }
    // It cannot be decoded, which is told with its name.
    file.topic(2, [name, name, name, name, name]);
    file.file()
}

/// A log of ArduPilot with a field of this name, of 16 bytes at most.
pub(crate) fn named_dataflash(name: &str) -> Vec<u8> {
    let format = |kind: u8, length: u8, letters: &str, labels: &str| {
        let mut body = [0; 86];
        body[..2].copy_from_slice(&[kind, length]);
        body[2..5].copy_from_slice(if kind == 128 { b"FMT" } else { b"ABC" });
        body[6..6 + letters.len()].copy_from_slice(letters.as_bytes());
        body[22..22 + labels.len()].copy_from_slice(labels.as_bytes());
        [&[0xa3, 0x95, 128][..], &body].concat()
    };
    let mut bytes = format(128, 89, "BBnNZ", "Type,Length,Name,Format,Columns");
    bytes.extend(format(129, 12, "QB", &format!("TimeUS,{name}")));
    for stamp in 1..4_u64 {
        bytes.extend([&[0xa3, 0x95, 129][..], &stamp.to_le_bytes(), &[7]].concat());
    }
    bytes
}

/// The messages of a ULog, after its head.
fn ulog(messages: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = b"\x55\x4c\x6f\x67\x01\x12\x35\x01".to_vec();
    bytes.extend(1_000_000_u64.to_le_bytes());
    for (kind, body) in messages {
        bytes.extend((body.len() as u16).to_le_bytes());
        bytes.push(*kind);
        bytes.extend(body);
    }
    bytes
}

/// A ULog with a parameter and a topic of this name, and one of another.
pub(crate) fn named_ulog(name: &str) -> Vec<u8> {
    let key = format!("float {name}");
    let parameter = |value: f32| {
        let length = [key.len() as u8];
        let bytes = [&length[..], key.as_bytes(), &value.to_le_bytes()].concat();
        (b'P', bytes)
    };
    let subscribe = |number: u16, topic: &str| {
        let bytes = [&[0][..], &number.to_le_bytes(), topic.as_bytes()].concat();
        (b'A', bytes)
    };
    ulog(&[
        parameter(1.0),
        (b'F', b"a:uint64_t timestamp;float x;".to_vec()),
        (b'F', format!("abc{name}:uint64_t timestamp;").into_bytes()),
        subscribe(0, "a"),
        parameter(2.0),
        (b'D', [&[0, 0][..], &1_u64.to_le_bytes(), &[0; 4]].concat()),
    ])
}

/// A Parquet file with a column of this name.
pub(crate) fn named_parquet(name: &str) -> Vec<u8> {
    let page = [&page_head(1, 8, 8)[..], &1.0_f64.to_le_bytes()].concat();
    let column = Column {
        name: name.to_owned(),
        kind: 5,
        codec: 0,
        unpacked: page.len() as i64,
        page,
    };
    parquet(1, &[column])
}

/// A ULog in which nested names multiply.
pub(crate) fn ulog_names() -> Vec<u8> {
    let long = "n".repeat(60_000);
    let mut messages = vec![
        (b'F', format!("a:uint64_t timestamp;b {long};").into_bytes()),
        (b'F', b"b:int8_t[65000] x;".to_vec()),
    ];
    for number in 0..2000_u16 {
        let body = [&[0][..], &number.to_le_bytes(), b"a"].concat();
        messages.push((b'A', body));
    }
    let stamp = 1_u64.to_le_bytes();
    messages.push((b'D', [&[0, 0][..], &stamp, &[0; 65_000]].concat()));
    ulog(&messages)
}
