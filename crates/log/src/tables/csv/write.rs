use crate::LogError;
use std::io;
use std::path::Path;
use touchdown_files::write_whole;
use touchdown_trial::{TIME_CHANNEL, Trial};

/// Writes a trial: `time_s`, then its channels in order. Gaps are empty cells. Numbers are the
/// shortest text that reads back to the same bits.
///
/// The file appears whole or not at all: it is written under a temporary name in the same folder,
/// which must exist, and then renamed.
///
/// # Errors
/// [`LogError::Write`]; what was at `path` before is then still there.
pub fn write_csv(trial: &Trial, path: impl AsRef<Path>) -> Result<(), LogError> {
    let path = path.as_ref();
    write_whole(path, &to_csv(trial)).map_err(|source| LogError::Write {
        path: path.display().to_string(),
        source,
    })
}

/// The text that [`write_csv`] writes.
#[must_use]
pub fn to_csv(trial: &Trial) -> Vec<u8> {
    let mut text = Vec::new();
    // Writing into a vector cannot fail.
    let _ = rows(trial, &mut text);
    text
}

fn rows(trial: &Trial, to: &mut dyn io::Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(to);
    let names = std::iter::once(TIME_CHANNEL).chain(trial.channels().map(|(name, _)| name));
    writer.write_record(names)?;
    let columns: Vec<&[f64]> = trial.channels().map(|(_, values)| values).collect();
    for (row, &stamp) in trial.time_s().iter().enumerate() {
        writer.write_field(shortest(stamp))?;
        for values in &columns {
            writer.write_field(shortest(values[row]))?;
        }
        writer.write_record(None::<&[u8]>)?;
    }
    writer.flush()
}

fn shortest(value: f64) -> String {
    let size = value.abs();
    if value.is_nan() {
        String::new()
    } else if size == 0.0 || (1e-5..1e16).contains(&size) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
