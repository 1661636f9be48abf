//! MCAP recordings and bags of ROS 1, written byte by byte.

use std::io::Write as _;

/// The records of an MCAP file, or of one of its chunks.
#[derive(Default)]
pub(crate) struct Mcap(pub(crate) Vec<u8>);

fn sized(text: &[u8]) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text].concat()
}

impl Mcap {
    fn record(&mut self, opcode: u8, parts: &[&[u8]]) {
        let length: usize = parts.iter().map(|part| part.len()).sum();
        self.0.push(opcode);
        self.0.extend((length as u64).to_le_bytes());
        parts.iter().for_each(|part| self.0.extend(*part));
    }

    /// A topic with its definition: `[topic, type, encoding of the definition, definition, encoding]`.
    pub(crate) fn topic(&mut self, id: u16, [topic, kind, of, definition, encoding]: [&str; 5]) {
        let id = id.to_le_bytes();
        let [kind, of, definition] = [kind, of, definition].map(|text| sized(text.as_bytes()));
        self.record(3, &[&id, &kind, &of, &definition]);
        let [topic, encoding] = [topic, encoding].map(|text| sized(text.as_bytes()));
        self.record(4, &[&id, &id, &topic, &encoding, &[0; 4]]);
    }

    pub(crate) fn message(&mut self, id: u16, stamp_ns: u64, data: &[u8]) {
        let stamps = [stamp_ns.to_le_bytes(); 2].concat();
        self.record(5, &[&id.to_le_bytes(), &[0; 4], &stamps, data]);
    }

    /// A record that a reader passes over.
    pub(crate) fn attachment(&mut self, bytes: &[u8]) {
        self.record(9, &[bytes]);
    }

    /// A chunk of records that are compressed by zstd.
    pub(crate) fn chunk(&mut self, records: &[u8]) {
        let packed = zstd::encode_all(records, 3).unwrap();
        let head = [&[0; 28][..], &sized(b"zstd"), &[0; 8]].concat();
        self.record(6, &[&head, &packed]);
    }

    pub(crate) fn file(mut self) -> Vec<u8> {
        self.record(0x0f, &[&[0; 4]]);
        [b"\x89MCAP0\r\n", &self.0[..]].concat()
    }
}

/// The records of a bag, or of one of its chunks.
#[derive(Default)]
pub(crate) struct Bag(pub(crate) Vec<u8>);

impl Bag {
    pub(crate) fn record(&mut self, op: u8, fields: &[(&str, &[u8])], data: &[u8]) {
        let mut head = sized(&[b"op=", &[op][..]].concat());
        for (name, value) in fields {
            head.extend(sized(&[name.as_bytes(), b"=", value].concat()));
        }
        self.0.extend(sized(&head));
        self.0.extend(sized(data));
    }

    pub(crate) fn connection(&mut self, topic: &str, kind: &str, definition: &str) {
        let mut data = sized(format!("type={kind}").as_bytes());
        data.extend(sized(format!("message_definition={definition}").as_bytes()));
        self.record(7, &[("conn", &[0; 4]), ("topic", topic.as_bytes())], &data);
    }

    pub(crate) fn message(&mut self, stamp_ns: u64, data: &[u8]) {
        let second = 1_000_000_000;
        let parts = [stamp_ns / second, stamp_ns % second].map(|part| (part as u32).to_le_bytes());
        self.record(2, &[("conn", &[0; 4]), ("time", &parts.concat())], data);
    }

    /// A chunk of records that are compressed by bzip2, in blocks of 100 kB: blocks of 900 kB are read at random places of a
    /// table that no cache of a small machine holds, and take six times as long.
    pub(crate) fn chunk(&mut self, records: &[u8]) {
        let mut packer = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        packer.write_all(records).unwrap();
        let packed = packer.finish().unwrap();
        self.record(5, &[("compression", b"bz2")], &packed);
    }

    pub(crate) fn file(self) -> Vec<u8> {
        [b"#ROSBAG V2.0\n", &self.0[..]].concat()
    }
}
