//! Inspects files in memory that does not grow with them.

use super::inspect::Inspector;
use crate::tables::{self, TablePart};
use crate::{Findings, Inspection, LogError};
use std::path::Path;

/// Summarises the table in a file as [`inspect`](crate::inspect()) does, in bounded memory.
///
/// The type of a column in a text table is that of the first 4 MB in which it has values.
#[cfg_attr(
    feature = "parquet",
    doc = "",
    doc = "Of a Parquet file one row group is held at a time."
)]
///
/// # Errors
/// Those of [`read_table`](crate::read_table), and [`LogError::NotText`] for a line of more than 64 MB.
pub fn inspect_file(path: impl AsRef<Path>) -> Result<(Inspection, Findings), LogError> {
    let path = path.as_ref();
    let mut looking = Inspector::new(None);
    let mut visit = |part: TablePart| looking.part(&part.columns, &part.row_numbers);
    let (sha256, findings) = tables::each_part(path, None, &mut visit)?;
    let name = path.display().to_string();
    Ok((looking.finish(&name, Some(sha256)), findings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::csv::each_part;
    use crate::{inspect, parse_csv};
    use proptest::prelude::*;
    use std::io::Read;

    /// Inspects a text table part by part, `part` bytes at once.
    fn inspect_parts(
        path: &str,
        input: impl Read,
        part: usize,
    ) -> Result<(Inspection, Findings), LogError> {
        let mut looking = Inspector::new(None);
        let mut visit = |part: TablePart| looking.part(&part.columns, &part.row_numbers);
        let (sha256, findings) = each_part(path, input, part, &mut visit)?;
        Ok((looking.finish(path, Some(sha256)), findings))
    }

    fn at_once(bytes: &[u8]) -> Result<(Inspection, Findings), LogError> {
        let (table, findings) = parse_csv("t.csv", bytes)?;
        Ok((inspect(&table, None), findings))
    }

    #[test]
    fn prop_parts_of_any_size_tell_what_the_whole_tells() {
        // Stamps, gaps, text, comments, a corrupt row, a jump back, and a last row that breaks off.
        let mut text = "# made\nTimestamp,a,b,who\ns,V,A,name\n".to_owned();
        for i in 0..60 {
            let minute = if i < 40 { i } else { i - 20 };
            let b = if i % 3 == 0 { "" } else { "1.5" };
            text += &format!("2020-01-01 00:{minute:02}:00,{i},{b},x\n");
            text += match i {
                7 => "# a comment\n\n",
                11 => "2020-01-01 00:00:00,1\n",
                23 => "2020-01-01 00:00:00,word,1,x\n",
                _ => "",
            };
        }
        text += "2020-01-01 00:59:00,6";
        let (whole, findings) = at_once(text.as_bytes()).unwrap();
        assert!(
            findings.truncated && findings.corrupt_rows == 2,
            "{findings:?}"
        );
        for part in [200, 333, 512, 1000, 1 << 20] {
            let (parts, found) = inspect_parts("t.csv", text.as_bytes(), part).unwrap();
            assert_eq!(parts, whole, "{part}");
            let mut told = [&findings, &found].map(|findings| findings.warnings.clone());
            told.iter_mut().for_each(|told| told.sort());
            assert_eq!(told[0], told[1], "{part}");
            assert_eq!(found.rows_read, findings.rows_read);
            assert_eq!(found.rows_used, findings.rows_used);
            assert_eq!(found.empty_cells, findings.empty_cells);
            assert_eq!(found.text_columns, findings.text_columns);
        }
    }

    proptest! {
        #[test]
        fn prop_any_likely_text_in_parts_is_a_table_or_an_error(
            text in "t,x[\n][a-c\"#,;\t|\r\n0-9.eE+: nµ-]{0,200}",
            part in 16_usize..100,
        ) {
            if let Ok((seen, findings)) = inspect_parts("t.csv", text.as_bytes(), part) {
                prop_assert_eq!(seen.rows, findings.rows_used);
                let gone = findings.corrupt_rows + findings.empty_rows + usize::from(findings.truncated);
                prop_assert_eq!(findings.rows_used + gone, findings.rows_read);
            }
        }
    }
}
