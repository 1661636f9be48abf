//! Text tables part by part, in memory that does not grow with the file.

use crate::csv_read::{Part, Reading, hex};
use crate::inspect::Looking;
use crate::layout::{layout, not_text, rows};
use crate::{Findings, Inspection, LogError};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Bytes of a part, about.
const PART: usize = 4 << 20;
/// Bytes of a line at most.
const LONGEST: usize = 64 << 20;

/// Tells what a text table holds, in memory that does not grow with the file.
///
/// # Errors
/// Those of [`read_csv`](crate::read_csv), and [`LogError::NotText`] for a line of more than 64 MB.
pub(crate) fn inspect_csv(path: &Path) -> Result<(Inspection, Findings), LogError> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|source| LogError::Read {
        path: name.clone(),
        source,
    })?;
    let mut looking = Looking::new(None);
    let mut visit = |part: Part| looking.part(&part.columns, &part.row_numbers);
    let (sha256, findings) = read_parts(&name, file, PART, &mut visit)?;
    Ok((looking.finish(&name, Some(sha256)), findings))
}

/// Hands over the rows of parts of so many bytes, and tells the SHA-256 of all.
fn read_parts(
    path: &str,
    mut input: impl Read,
    part: usize,
    visit: &mut dyn FnMut(Part),
) -> Result<(String, Findings), LogError> {
    let mut digest = Sha256::new();
    let mut bytes: Vec<u8> = Vec::new();
    let mut reading: Option<(Reading, usize)> = None;
    loop {
        let before = bytes.len();
        let read = input.by_ref().take(part as u64).read_to_end(&mut bytes);
        let read = read.map_err(|source: io::Error| LogError::Read {
            path: path.to_owned(),
            source,
        })?;
        digest.update(&bytes[before..]);
        let ends = read < part;
        // The last line waits for what follows it, for the file's last one may break off.
        let inner = &bytes[..bytes.len().saturating_sub(1)];
        let end = |byte: u8| inner.iter().rposition(|&b| b == byte);
        let length = match end(b'\n').or_else(|| end(b'\r')) {
            _ if ends => bytes.len(),
            Some(end) => end + 1,
            None if bytes.len() > LONGEST => {
                return Err(not_text(path, "a line of more than 64 MB"));
            }
            None => continue,
        };
        let whole = &bytes[..length];
        match &mut reading {
            None => {
                let layout = layout(path, whole)?;
                let mut first = Reading::of(&layout);
                visit(first.part(&layout.rows, ends));
                reading = Some((first, layout.next_number));
            }
            Some((reading, number)) => {
                let (lines, next_number) = rows(whole, *number);
                *number = next_number;
                visit(reading.part(&lines, ends));
            }
        }
        bytes.drain(..length);
        if ends {
            break;
        }
    }
    let findings = reading.map(|(reading, _)| reading.conclude(path));
    Ok((
        hex(&digest.finalize()),
        findings.transpose()?.unwrap_or_default(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{inspect, parse_csv};
    use proptest::prelude::*;

    fn in_parts(bytes: &[u8], part: usize) -> Result<(Inspection, Findings), LogError> {
        let mut looking = Looking::new(None);
        let mut visit = |part: Part| looking.part(&part.columns, &part.row_numbers);
        let (sha256, findings) = read_parts("t.csv", bytes, part, &mut visit)?;
        Ok((looking.finish("t.csv", Some(sha256)), findings))
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
            let (parts, found) = in_parts(text.as_bytes(), part).unwrap();
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
            if let Ok((seen, findings)) = in_parts(text.as_bytes(), part) {
                prop_assert_eq!(seen.rows, findings.rows_used);
                let gone = findings.corrupt_rows + findings.empty_rows + usize::from(findings.truncated);
                prop_assert_eq!(findings.rows_used + gone, findings.rows_read);
            }
        }
    }
}
