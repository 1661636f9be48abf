//! Recordings of ROS 2, record by record.

/// An MCAP file without chunks.
pub(crate) struct Mcap {
    bytes: Vec<u8>,
    channels: u16,
}

fn text(body: &mut Vec<u8>, text: &str) {
    body.extend((text.len() as u32).to_le_bytes());
    body.extend(text.as_bytes());
}

impl Mcap {
    pub(crate) fn new() -> Self {
        let mut file = Self {
            bytes: b"\x89MCAP0\r\n".to_vec(),
            channels: 0,
        };
        let mut head = Vec::new();
        text(&mut head, "ros2");
        text(&mut head, "test");
        file.record(1, &head);
        file
    }

    fn record(&mut self, opcode: u8, body: &[u8]) {
        self.bytes.push(opcode);
        self.bytes.extend((body.len() as u64).to_le_bytes());
        self.bytes.extend(body);
    }

    /// A topic of messages of this type, and its definition.
    pub(crate) fn topic(&mut self, topic: &str, kind: &str, definition: &str) -> u16 {
        self.channel(topic, kind, ["ros2msg", definition, "cdr"])
    }

    /// A topic of JSON of this type.
    pub(crate) fn json(&mut self, topic: &str, kind: &str) -> u16 {
        self.channel(topic, kind, ["jsonschema", "{}", "json"])
    }

    fn channel(&mut self, topic: &str, kind: &str, [schemas, of, encoding]: [&str; 3]) -> u16 {
        self.channels += 1;
        let mut schema = self.channels.to_le_bytes().to_vec();
        text(&mut schema, kind);
        text(&mut schema, schemas);
        text(&mut schema, of);
        self.record(3, &schema);
        let mut channel = [self.channels.to_le_bytes(); 2].concat();
        text(&mut channel, topic);
        text(&mut channel, encoding);
        channel.extend([0; 4]);
        self.record(4, &channel);
        self.channels
    }

    pub(crate) fn message(&mut self, channel: u16, recorded_ns: u64, data: &[u8]) {
        let mut body = channel.to_le_bytes().to_vec();
        body.extend([0; 4]);
        body.extend(recorded_ns.to_le_bytes());
        body.extend(recorded_ns.to_le_bytes());
        body.extend(data);
        self.record(5, &body);
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.record(0x0f, &[0; 4]);
        self.record(2, &[0; 20]);
        self.bytes.extend(b"\x89MCAP0\r\n");
        self.bytes
    }
}

/// A message in little-endian CDR.
pub(crate) struct Cdr(Vec<u8>);

impl std::ops::Deref for Cdr {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}

impl Cdr {
    pub(crate) fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    fn put(mut self, bytes: &[u8]) -> Self {
        while !(self.0.len() - 4).is_multiple_of(bytes.len()) {
            self.0.push(0);
        }
        self.0.extend(bytes);
        self
    }

    pub(crate) fn u32(self, value: u32) -> Self {
        self.put(&value.to_le_bytes())
    }

    pub(crate) fn u64(self, value: u64) -> Self {
        self.put(&value.to_le_bytes())
    }

    pub(crate) fn f32s(self, values: &[f32]) -> Self {
        values.iter().fold(self, |cdr, v| cdr.put(&v.to_le_bytes()))
    }

    pub(crate) fn f64s(self, values: &[f64]) -> Self {
        values.iter().fold(self, |cdr, v| cdr.put(&v.to_le_bytes()))
    }

    /// A header with an empty name of its frame.
    pub(crate) fn header(self, stamp_ns: u64) -> Self {
        self.u32((stamp_ns / 1_000_000_000) as u32)
            .u32((stamp_ns % 1_000_000_000) as u32)
            .u32(1)
            .put(&[0])
    }
}
