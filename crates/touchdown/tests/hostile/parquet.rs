//! Parquet files written byte by byte, so that they may state anything.

/// A structure in the compact protocol of Thrift, which Parquet's tables of contents use.
#[derive(Default)]
pub(crate) struct Thrift {
    bytes: Vec<u8>,
    last: u8,
}

fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value > 0x7f {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

impl Thrift {
    fn head(&mut self, field: u8, kind: u8) {
        self.bytes.push((field - self.last) << 4 | kind);
        self.last = field;
    }

    pub(crate) fn i32(mut self, field: u8, value: i64) -> Self {
        self.head(field, 5);
        varint(&mut self.bytes, zigzag(value));
        self
    }

    pub(crate) fn i64(mut self, field: u8, value: i64) -> Self {
        self.head(field, 6);
        varint(&mut self.bytes, zigzag(value));
        self
    }

    fn text(mut self, field: u8, text: &str) -> Self {
        self.head(field, 8);
        varint(&mut self.bytes, text.len() as u64);
        self.bytes.extend(text.as_bytes());
        self
    }

    pub(crate) fn structure(mut self, field: u8, inner: Self) -> Self {
        self.head(field, 12);
        self.bytes.extend(inner.finish());
        self
    }

    fn list(mut self, field: u8, kind: u8, elements: &[Vec<u8>]) -> Self {
        self.head(field, 9);
        self.bytes.push(0xf0 | kind);
        varint(&mut self.bytes, elements.len() as u64);
        self.bytes.extend(elements.concat());
        self
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }
}

/// A column of one page: its name, the codec, the page with its head, and the bytes that it says to unpack to.
pub(crate) struct Column {
    pub(crate) name: String,
    /// 6 for bytes of any length, 5 for a number of 64 bits.
    pub(crate) kind: i64,
    /// 0 for none, 6 for zstd.
    pub(crate) codec: i64,
    pub(crate) page: Vec<u8>,
    pub(crate) unpacked: i64,
}

/// The head of a page of plain values, without levels.
pub(crate) fn page_head(values: i64, unpacked: i64, packed: usize) -> Vec<u8> {
    let data = Thrift::default()
        .i32(1, values)
        .i32(2, 0)
        .i32(3, 3)
        .i32(4, 3);
    Thrift::default()
        .i32(1, 0)
        .i32(2, unpacked)
        .i32(3, packed as i64)
        .structure(5, data)
        .finish()
}

/// A file of one row group.
pub(crate) fn file(rows: i64, columns: &[Column]) -> Vec<u8> {
    let mut bytes = b"PAR1".to_vec();
    let root = Thrift::default()
        .text(4, "schema")
        .i32(5, columns.len() as i64);
    let (mut schema, mut chunks) = (vec![root.finish()], Vec::new());
    for column in columns {
        let element = Thrift::default().i32(1, column.kind).i32(3, 0);
        schema.push(element.text(4, &column.name).finish());
        let mut name = Vec::new();
        varint(&mut name, column.name.len() as u64);
        name.extend(column.name.as_bytes());
        let at = bytes.len() as i64;
        let content = Thrift::default()
            .i32(1, column.kind)
            .list(2, 5, &[vec![0]])
            .list(3, 8, &[name])
            .i32(4, column.codec)
            .i64(5, rows)
            .i64(6, column.unpacked)
            .i64(7, column.page.len() as i64)
            .i64(9, at);
        bytes.extend(&column.page);
        chunks.push(Thrift::default().i64(2, at).structure(3, content).finish());
    }
    let group = Thrift::default()
        .list(1, 12, &chunks)
        .i64(2, bytes.len() as i64)
        .i64(3, rows)
        .finish();
    let footer = Thrift::default()
        .i32(1, 1)
        .list(2, 12, &schema)
        .i64(3, rows)
        .list(4, 12, &[group])
        .finish();
    bytes.extend(&footer);
    bytes.extend((footer.len() as u32).to_le_bytes());
    bytes.extend(b"PAR1");
    bytes
}
