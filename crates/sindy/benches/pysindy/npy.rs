//! Arrays of NumPy, little-endian doubles in C order, as columns.

use std::error::Error;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Groups of columns of an array of shape (rows), (rows, columns) or (groups, rows, columns); at most `limit` rows of
/// each group.
pub(crate) fn columns(path: &Path, limit: usize) -> Result<Vec<Vec<Vec<f64>>>, Box<dyn Error>> {
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut start = [0; 10];
    file.read_exact(&mut start)?;
    if start[..7] != *b"\x93NUMPY\x01" {
        return Err(format!("{}: not an array of format 1", path.display()).into());
    }
    let mut header = vec![0; usize::from(u16::from_le_bytes([start[8], start[9]]))];
    file.read_exact(&mut header)?;
    let header = String::from_utf8(header)?;
    if !header.contains("'<f8'") || !header.contains("'fortran_order': False") {
        return Err(format!(
            "{}: expected <f8 in C order, found {header}",
            path.display()
        )
        .into());
    }
    let inside = |text: &str| Some(text.split_once('(')?.1.split_once(')')?.0.to_owned());
    let shape = inside(&header)
        .ok_or("no shape")?
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .map(str::parse)
        .collect::<Result<Vec<usize>, _>>()?;
    let [groups, rows, width] = match *shape.as_slice() {
        [rows] => [1, rows, 1],
        [rows, width] => [1, rows, width],
        [groups, rows, width] => [groups, rows, width],
        _ => return Err(format!("{}: {} dimensions", path.display(), shape.len()).into()),
    };
    let mut out = Vec::with_capacity(groups);
    let mut row = vec![0; 8 * width];
    for _ in 0..groups {
        let mut columns = vec![Vec::with_capacity(rows.min(limit)); width];
        for r in 0..rows {
            file.read_exact(&mut row)?;
            if r < limit {
                for (column, bytes) in columns.iter_mut().zip(row.chunks_exact(8)) {
                    column.push(f64::from_le_bytes(bytes.try_into()?));
                }
            }
        }
        out.push(columns);
    }
    Ok(out)
}
