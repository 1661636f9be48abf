//! Files that a reader must refuse or read with bounded work: each is small, and what it asks for is not.

use std::fmt::Write as _;

use crate::parquet::{Column, file as parquet, page_head};
use crate::recordings::{Bag, Mcap};

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
        writeln!(text, "c{k}_m = '\"/a.x\" + {k}'").unwrap();
    }
    text.into_bytes()
}

/// A map of more channels than any vehicle has.
pub(crate) fn endless_map() -> Vec<u8> {
    let mut text = "schema = 1\n[channels]\ntime_s = 'time_s'\n".to_owned();
    for k in 0..100_000 {
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

/// A ULog in which nested names multiply.
pub(crate) fn ulog_names() -> Vec<u8> {
    let mut bytes = b"\x55\x4c\x6f\x67\x01\x12\x35\x01".to_vec();
    bytes.extend(1_000_000_u64.to_le_bytes());
    let mut message = |kind: u8, body: &[u8]| {
        bytes.extend((body.len() as u16).to_le_bytes());
        bytes.push(kind);
        bytes.extend(body);
    };
    let long = "n".repeat(60_000);
    message(b'F', format!("a:uint64_t timestamp;b {long};").as_bytes());
    message(b'F', b"b:int8_t[65000] x;");
    for number in 0..2000_u16 {
        message(b'A', &[&[0][..], &number.to_le_bytes(), b"a"].concat());
    }
    message(
        b'D',
        &[&[0, 0][..], &1_u64.to_le_bytes(), &[0; 65_000]].concat(),
    );
    bytes
}
