//! The memory of this process, as Linux tells it.

use std::io;

/// Of the resident memory, in MB: `VmRSS` is that of now, `VmHWM` the most since [`reset_peak`].
pub(crate) fn megabytes(field: &str) -> io::Result<f64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|line| line.starts_with(field));
    let value = line.and_then(|line| line.split_whitespace().nth(1));
    let kilobytes: Option<f64> = value.and_then(|value| value.parse().ok());
    Ok(kilobytes.ok_or_else(|| io::Error::other("no such field"))? / 1024.0)
}

/// The most counts from here on.
pub(crate) fn reset_peak() -> io::Result<()> {
    std::fs::write("/proc/self/clear_refs", "5")
}
