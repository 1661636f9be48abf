//! A sweep and landings of it as bytes, for another process.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use super::part::CampaignPart;
use super::points::Sweep;
use super::row::{LandingRow, decode, encode};
use super::store::Store;
use crate::error::Result;
use crate::place::{ObjectStorage, Place};

/// Name of the landings.
const ROWS: &str = "landings.parquet";

/// The files of a campaign in memory.
#[derive(Debug, Default)]
struct Memory(Mutex<BTreeMap<String, Vec<u8>>>);

impl ObjectStorage for Memory {
    fn address(&self) -> &'static str {
        "memory"
    }

    fn names(&self, folder: &str) -> io::Result<Vec<String>> {
        let files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let names = files
            .keys()
            .filter_map(|name| name.strip_prefix(folder)?.strip_prefix('/'))
            .filter(|name| !name.contains('/'));
        Ok(names.map(str::to_owned).collect())
    }

    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes = files.get(name).cloned();
        bytes.ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn write(&self, name: &str, bytes: Vec<u8>) -> io::Result<()> {
        let mut files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        files.insert(name.to_owned(), bytes);
        Ok(())
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        let mut files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        files.remove(name);
        Ok(())
    }
}

/// A sweep and landings of it, which follow one another, as files by name.
///
/// # Errors
/// Landings that Parquet cannot hold.
pub fn pack(sweep: &Sweep, rows: &[LandingRow]) -> Result<BTreeMap<String, Vec<u8>>> {
    let memory = Arc::new(Memory::default());
    let place = Place::Storage(memory.clone());
    Store::open(&place, sweep, CampaignPart::Whole, false)?;
    // Parquet has no table without rows.
    if !rows.is_empty() {
        place.write(ROWS, encode(sweep, rows)?)?;
    }
    let files = memory.0.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(files.clone())
}

/// The sweep and the landings of [`pack`]; `first` is the place of the first landing in the sweep.
///
/// # Errors
/// Files that are not those of [`pack`].
pub fn unpack(
    files: BTreeMap<String, Vec<u8>>,
    first: u64,
    landings: u64,
) -> Result<(Sweep, Vec<LandingRow>)> {
    let place = Place::Storage(Arc::new(Memory(Mutex::new(files))));
    let sweep = Sweep::of(&place)?;
    let rows = match landings {
        0 => Vec::new(),
        _ => decode(&sweep, (&place, ROWS), first..first + landings)?,
    };
    Ok((sweep, rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::sweep::{SweepSettings, rows};
    use std::path::Path;

    #[test]
    fn prop_what_was_packed_is_what_is_unpacked() {
        let text = "trials = 3\n[grid]\n\"control.controller\" = [\"observer\", \"feedback\"]\n[scenario]\ntimeout_s = 30.0\n";
        let settings = SweepSettings::parse(text, "sweep").unwrap();
        let sweep = Sweep::new(settings, Path::new("."), "sweep".to_owned()).unwrap();
        for range in [0..6, 2..4, 5..5] {
            let flown = rows(&sweep, range.clone(), &Silent).unwrap();
            let files = pack(&sweep, &flown).unwrap();
            let (first, landings) = (range.start, range.end - range.start);
            let (again, there) = unpack(files.clone(), first, landings).unwrap();
            assert_eq!(again.sha256(), sweep.sha256());
            assert_eq!(there, flown);
            assert!(unpack(files, first + 1, landings).is_err() || landings == 0);
        }
    }
}
