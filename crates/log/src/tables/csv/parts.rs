//! Text tables part by part, in bounded memory.

use super::layout::{layout, not_text, rows};
use super::read::{TablePart, TableReader};
use crate::hashing::Hashing;
use crate::limits::RECORD_BYTES as LONGEST;
use crate::{Findings, LogError};
use std::io::{self, Read};

/// Passes the rows on in parts of `part` bytes, and returns the SHA-256 of the file.
pub(crate) fn each_part(
    path: &str,
    input: impl Read,
    part: usize,
    visit: &mut dyn FnMut(TablePart),
) -> Result<(String, Findings), LogError> {
    let mut input = Hashing::new(input, true);
    let of_read = |source: io::Error| LogError::Read {
        path: path.to_owned(),
        source,
    };
    let mut bytes: Vec<u8> = Vec::new();
    let mut reading: Option<(TableReader, usize)> = None;
    loop {
        let read = input.by_ref().take(part as u64).read_to_end(&mut bytes);
        let read = read.map_err(of_read)?;
        let ends = read < part;
        // The last line waits for the next part, because only the file's last line may be incomplete.
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
                let mut first = TableReader::of(&layout);
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
        input.finish().map_err(of_read)?,
        findings.transpose()?.unwrap_or_default(),
    ))
}
