//! Unpacked sizes of pages, read from their heads before anything is unpacked.
//!
//! A page of a few bytes may unpack to 2 GiB, and the table of contents may state another size. Heads are
//! structures of Thrift's compact protocol; of each, only the two sizes are read.

use super::bounded::Bounded;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::ChunkReader;
use std::io::Read;

/// Places of the two sizes in a page's head.
const UNPACKED: i32 = 2;
const PACKED: i32 = 3;
/// Deepest structure in a head; statistics are the deepest known, at 3.
const DEEPEST: usize = 8;
/// Longest head, bytes. Statistics hold two values of the column, which may be texts.
const LONGEST: u64 = 16 << 20;

/// Bytes to which the pages of a column of a row group unpack, heads included.
pub(super) fn unpacked(file: &Bounded, chunk: &ColumnChunkMetaData) -> Result<u64> {
    let outside = || ParquetError::General("a column outside of its file".to_owned());
    let dictionary = chunk.dictionary_page_offset();
    // The crate's reader ends the program there.
    let sizes = [chunk.data_page_offset(), chunk.compressed_size()];
    if sizes.into_iter().chain(dictionary).any(|size| size < 0) {
        return Err(outside());
    }
    let first = dictionary.unwrap_or(i64::MAX);
    let first = first.min(chunk.data_page_offset());
    // Some writers state a dictionary at 0 where there is none.
    let first = if first <= 0 {
        chunk.data_page_offset()
    } else {
        first
    };
    let mut at = u64::try_from(first).map_err(|_| outside())?;
    let length = u64::try_from(chunk.compressed_size()).map_err(|_| outside())?;
    let end = at.checked_add(length).ok_or_else(outside)?;
    let mut sum = 0_u64;
    while at < end {
        let mut head = Head {
            input: file.get_read(at)?.take(LONGEST),
            taken: 0,
        };
        let (mut unpacked, mut packed) = (0, 0);
        head.structure(DEEPEST, &mut |field, value| match field {
            UNPACKED => unpacked = value,
            PACKED => packed = value,
            _ => {}
        })?;
        let packed = u64::try_from(packed).map_err(|_| outside())?;
        let unpacked = u64::try_from(unpacked).map_err(|_| outside())?;
        let step = head.taken + packed;
        sum = sum.saturating_add(head.taken + unpacked.max(packed));
        at = at.checked_add(step).ok_or_else(outside)?;
    }
    Ok(sum)
}

/// The head of a page.
struct Head<R> {
    input: R,
    taken: u64,
}

impl<R: Read> Head<R> {
    fn byte(&mut self) -> Result<u8> {
        let mut byte = [0];
        self.input.read_exact(&mut byte)?;
        self.taken += 1;
        Ok(byte[0])
    }

    fn varint(&mut self) -> Result<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(broken())
    }

    /// Reads a structure, and reports its whole numbers of 16 to 64 bits by their fields.
    fn structure(&mut self, depth: usize, tell: &mut dyn FnMut(i32, i64)) -> Result<()> {
        let depth = depth.checked_sub(1).ok_or_else(broken)?;
        let mut field = 0_i32;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Ok(());
            }
            field = match head >> 4 {
                0 => zigzag(self.varint()?) as i32,
                step => field.saturating_add(step.into()),
            };
            match head & 0xf {
                // Truth values are in their type.
                1 | 2 => {}
                4..=6 => tell(field, zigzag(self.varint()?)),
                kind => self.skip(kind, depth)?,
            }
        }
    }

    /// Passes over a value of this type.
    fn skip(&mut self, kind: u8, depth: usize) -> Result<()> {
        match kind {
            1..=3 => self.pass(1),
            4..=6 => self.varint().map(drop),
            7 => self.pass(8),
            8 => {
                let length = self.varint()?;
                self.pass(length)
            }
            9 | 10 => {
                let head = self.byte()?;
                let count = match head >> 4 {
                    15 => self.varint()?,
                    count => count.into(),
                };
                let depth = depth.checked_sub(1).ok_or_else(broken)?;
                (0..count).try_for_each(|_| self.skip(head & 0xf, depth))
            }
            12 => self.structure(depth, &mut |_, _| {}),
            _ => Err(broken()),
        }
    }

    fn pass(&mut self, bytes: u64) -> Result<()> {
        let passed = std::io::copy(&mut self.input.by_ref().take(bytes), &mut std::io::sink())?;
        self.taken += passed;
        if passed == bytes {
            Ok(())
        } else {
            Err(broken())
        }
    }
}

fn broken() -> ParquetError {
    ParquetError::General("a page whose head cannot be read".to_owned())
}

fn zigzag(value: u64) -> i64 {
    (value >> 1).cast_signed() ^ -(value & 1).cast_signed()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the head of a page states, and its length.
    fn read(bytes: &[u8]) -> Result<(Vec<(i32, i64)>, u64)> {
        let mut head = Head {
            input: bytes,
            taken: 0,
        };
        let mut told = Vec::new();
        head.structure(DEEPEST, &mut |field, value| told.push((field, value)))?;
        Ok((told, head.taken))
    }

    #[test]
    fn analytic_sizes_of_a_page_by_the_compact_protocol() {
        // Type 0, 300 unpacked, 7 packed, then field 5: a structure of 1, a text of two bytes, a list of two
        // truth values, and a number of 64 bits.
        let head = [
            0x15, 0x00, 0x15, 0xd8, 0x04, 0x15, 0x0e, 0x2c, 0x15, 0x02, 0x18, 0x02, b'a', b'b',
            0x19, 0x21, 1, 2, 0x16, 0x01, 0x00, 0x00, 0xff,
        ];
        let (told, length) = read(&head).unwrap();
        assert_eq!(told, [(1, 0), (UNPACKED, 300), (PACKED, 7)]);
        assert_eq!(length, head.len() as u64 - 1);
        for cut in 0..head.len() - 1 {
            assert!(read(&head[..cut]).is_err(), "{cut}");
        }
        // Structures in structures without end.
        assert!(read(&[0x1c; 100]).is_err());
        assert_eq!([0, 1, 2, 3].map(zigzag), [0, -1, 1, -2]);
    }
}
