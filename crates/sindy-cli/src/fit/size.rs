//! Tables that are large for the way that they are to be read.

use std::path::PathBuf;

use crate::table;

/// Rows above which reading everything into memory is worth a word.
const ROWS: u64 = 5_000_000;

/// A word on `--stream`, if the files are larger than half of the free memory or have more than 5 million rows.
pub(super) fn hint(paths: &[PathBuf], columns: &[String]) -> Option<String> {
    let sizes = || paths.iter().map(|path| table::size(path, columns));
    let bytes: u64 = sizes().map(|s| s.bytes).sum();
    let rows: u64 = sizes().map(|s| s.rows).sum();
    of(bytes, rows, free_memory())
}

fn of(bytes: u64, rows: u64, free: Option<u64>) -> Option<String> {
    let large = free.is_some_and(|free| bytes > free / 2);
    (large || rows > ROWS).then(|| {
        format!(
            "the data have about {rows} rows in {} MB, which are read into memory: --stream fits them in one pass with \
             tens of MB, by regression",
            bytes >> 20
        )
    })
}

/// Memory that can be had without swapping, in bytes, where the system reports it.
fn free_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    available(&text)
}

fn available(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_large_files_get_a_word_on_streaming() {
        let gigabyte = 1 << 30;
        assert!(of(3 * gigabyte, 1000, Some(4 * gigabyte)).is_some_and(|h| h.contains("--stream")));
        assert!(of(gigabyte, 6_000_000, None).is_some_and(|h| h.contains("6000000 rows")));
        assert_eq!(of(gigabyte, 4_000_000, Some(4 * gigabyte)), None);
        assert_eq!(of(gigabyte, 1000, None), None);
    }

    #[test]
    fn analytic_free_memory_of_the_kernel() {
        let text = "MemTotal:       24000000 kB\nMemAvailable:   11000000 kB\nBuffers: 3 kB\n";
        assert_eq!(available(text), Some(11_264_000_000));
        assert_eq!(available("MemTotal: 24000000 kB\n"), None);
    }
}
