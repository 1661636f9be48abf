//! Pages that are packed with Zstandard, where the Parquet reader has no library in C that unpacks them.
//!
//! For the reader the pages count as not compressed. It checks their checksums, which are those of the packed bytes, and hands
//! them over as they are.

use super::bounded::Bounded;
use crate::zstd;
use parquet::basic::Compression;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::reader::RowGroupReader;
use parquet::file::serialized_reader::SerializedPageReader;
use std::io::Read;
use std::sync::Arc;

/// Unpacks pages in order.
pub(super) struct PackedPages {
    pages: Box<dyn PageReader>,
    /// Bytes to which the pages that follow unpack at most.
    left: u64,
}

impl PackedPages {
    /// The pages of a column of a row group, by its place in the file, which unpack to `most` bytes at most.
    pub(super) fn of_column(
        file: &Bounded,
        group: &dyn RowGroupReader,
        leaf: usize,
        most: u64,
    ) -> Result<Self> {
        let chunk = group.metadata().column(leaf).clone();
        let plain = chunk
            .into_builder()
            .set_compression(Compression::UNCOMPRESSED)
            .build()?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let pages = SerializedPageReader::new(Arc::new(file.clone()), &plain, rows, None)?;
        Ok(Self {
            pages: Box::new(pages),
            left: most,
        })
    }

    /// The page's first bytes as they are, and the others unpacked.
    fn unpack(&mut self, page: &[u8], plain: usize) -> Result<Vec<u8>> {
        let broken = || ParquetError::General("a page that cannot be unpacked".to_owned());
        let (head, packed) = page.split_at_checked(plain).ok_or_else(broken)?;
        let mut bytes = head.to_vec();
        let mut read = |input: &mut dyn Read| {
            let room = self
                .left
                .saturating_add(1)
                .saturating_sub(bytes.len() as u64);
            let read = input.take(room).read_to_end(&mut bytes);
            read.is_ok() && bytes.len() as u64 <= self.left
        };
        // A page without values may have no packed bytes.
        if !packed.is_empty() && !zstd::unpack(packed, &mut read) {
            return Err(broken());
        }
        self.left = self.left.saturating_sub(bytes.len() as u64);
        Ok(bytes)
    }
}

impl Iterator for PackedPages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for PackedPages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        let Some(mut page) = self.pages.get_next_page()? else {
            return Ok(None);
        };
        match &mut page {
            Page::DataPage { buf, .. } | Page::DictionaryPage { buf, .. } => {
                *buf = self.unpack(buf, 0)?.into();
            }
            Page::DataPageV2 {
                buf,
                def_levels_byte_len,
                rep_levels_byte_len,
                is_compressed,
                ..
            } => {
                if std::mem::take(is_compressed) {
                    // Levels are never packed.
                    let levels = def_levels_byte_len.saturating_add(*rep_levels_byte_len);
                    *buf = self.unpack(buf, levels as usize)?.into();
                }
            }
        }
        Ok(Some(page))
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.pages.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.pages.skip_next_page()
    }

    fn at_record_boundary(&mut self) -> Result<bool> {
        self.pages.at_record_boundary()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::parquet::sizes::unpacked;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use std::path::Path;

    fn open(name: &str) -> (Bounded, SerializedFileReader<Bounded>) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/fixtures");
        let file = Bounded::new(std::fs::File::open(path.join(name)).unwrap()).unwrap();
        (file.clone(), SerializedFileReader::new(file).unwrap())
    }

    /// What a page holds but its compression, which is gone.
    fn text(page: &Page) -> String {
        format!("{page:?}").replace("is_compressed: true", "is_compressed: false")
    }

    #[test]
    fn xval_pages_are_those_that_the_reader_with_the_library_in_c_unpacks() {
        for name in ["table.parquet", "zstd_v2.parquet"] {
            let (file, reader) = open(name);
            let mut count = 0;
            for place in 0..reader.num_row_groups() {
                let group = reader.get_row_group(place).unwrap();
                for leaf in 0..group.num_columns() {
                    let most = unpacked(&file, group.metadata().column(leaf)).unwrap();
                    let ours = PackedPages::of_column(&file, group.as_ref(), leaf, most).unwrap();
                    let theirs = group.get_column_page_reader(leaf).unwrap();
                    let [ours, theirs]: [Vec<String>; 2] =
                        [Box::new(ours) as Box<dyn PageReader>, theirs]
                            .map(|pages| pages.map(|page| text(&page.unwrap())).collect());
                    assert_eq!(ours, theirs, "{name}, column {leaf}");
                    count += ours.len();
                }
            }
            assert!(count > 20, "{name}: {count} pages");
        }
    }

    #[test]
    fn prop_a_page_beyond_its_size_is_refused() {
        let (file, reader) = open("table.parquet");
        let group = reader.get_row_group(0).unwrap();
        let most = unpacked(&file, group.metadata().column(0)).unwrap();
        for (most, is_whole) in [(most, true), (most / 2, false), (0, false)] {
            let pages = PackedPages::of_column(&file, group.as_ref(), 0, most).unwrap();
            let read: Result<Vec<Page>> = pages.collect();
            assert_eq!(read.is_ok(), is_whole, "{most}");
        }
    }
}
