//! A campaign's folder: the sweep, and a file for each block of landings.

use std::fs::File;
use std::path::{Path, PathBuf};

use touchdown_files::TEMPORARY_PREFIX;

use super::part::CampaignPart;
use super::points::Sweep;
use super::row::{LandingRow, decode, encode};
use crate::error::{Error, Result};
use crate::files::{folder, write};
use crate::measured_deck::SERIES;
use crate::settings_file::to_toml;

/// Name of the sweep in a campaign's folder.
pub(super) const SWEEP: &str = "sweep.toml";
/// Folder of the blocks.
const LANDINGS: &str = "landings";

/// The folder of one campaign.
#[derive(Debug)]
pub struct Store {
    out: PathBuf,
    /// While it is held, no other run takes half-written files for left ones.
    _in_use: Option<File>,
}

impl Store {
    /// Opens the folder of a campaign, or begins it; `resume` allows for landings that are there. Runs of parts of a
    /// campaign may share a folder.
    ///
    /// # Errors
    /// A folder with landings of other settings, or with any where `resume` was not asked for.
    pub fn open(out: &Path, sweep: &Sweep, part: CampaignPart, resume: bool) -> Result<Self> {
        let store = Self::of(out);
        let at = out.join(SWEEP);
        if at.exists() {
            let there = Sweep::load(&at, None, None)?;
            if there.sha256() != sweep.sha256() {
                return Err(Error::Arguments(format!(
                    "{}: contains a campaign of other settings (SHA-256 {}, these are {}); choose another folder",
                    out.display(),
                    there.sha256(),
                    sweep.sha256()
                )));
            }
        }
        if !resume && !store.present()?.is_empty() {
            return Err(Error::Arguments(format!(
                "{}: contains landings of this campaign already; --resume completes it",
                out.display()
            )));
        }
        let landings = out.join(LANDINGS);
        folder(&landings)?;
        // Where folders cannot be locked, nothing is taken away: what a killed run left is
        // in nobody's way.
        let lock = File::open(&landings).ok();
        if let Some(lock) = &lock {
            // Other parts may run on other machines, and not every shared disk shows their locks.
            if part == CampaignPart::Whole && lock.try_lock().is_ok() {
                store.sweep_up()?;
                let _ = lock.unlock();
            }
            // One of several runs, if there are any.
            let _ = lock.lock_shared();
        }
        // The present file has the same content, perhaps in another form.
        if !at.exists() {
            if let Some(series) = &sweep.series {
                write(&out.join(SERIES), series)?;
            }
            write(&at, to_toml(sweep.settings())?.as_bytes())?;
        }
        Ok(Self {
            _in_use: lock,
            ..store
        })
    }

    /// The folder of a campaign as it is, for reading.
    #[must_use]
    pub fn of(out: &Path) -> Self {
        Self {
            out: out.to_owned(),
            _in_use: None,
        }
    }

    /// Takes away what a killed run left half-written; other runs may be in the middle of it.
    fn sweep_up(&self) -> Result<()> {
        for folder in [self.out.clone(), self.out.join(LANDINGS)] {
            for entry in std::fs::read_dir(&folder).map_err(|e| Error::file(&folder, e))? {
                let entry = entry.map_err(|e| Error::file(&folder, e))?;
                if entry
                    .file_name()
                    .to_string_lossy()
                    .starts_with(TEMPORARY_PREFIX)
                {
                    std::fs::remove_file(entry.path())
                        .map_err(|e| Error::file(&entry.path(), e))?;
                }
            }
        }
        Ok(())
    }

    pub(super) fn path(&self, block: u64) -> PathBuf {
        self.out
            .join(LANDINGS)
            .join(format!("block-{block:06}.parquet"))
    }

    /// The blocks that are there, in their order.
    ///
    /// # Errors
    /// A folder that cannot be read, or a file in it that is no block.
    pub fn present(&self) -> Result<Vec<u64>> {
        let landings = self.out.join(LANDINGS);
        let mut blocks = Vec::new();
        if !landings.exists() {
            return Ok(blocks);
        }
        for entry in std::fs::read_dir(&landings).map_err(|e| Error::file(&landings, e))? {
            let entry = entry.map_err(|e| Error::file(&landings, e))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with(TEMPORARY_PREFIX) {
                continue;
            }
            let number = name
                .strip_prefix("block-")
                .and_then(|n| n.strip_suffix(".parquet"));
            let block = number
                .and_then(|n| n.parse().ok())
                .filter(|b| self.path(*b) == entry.path());
            blocks.push(block.ok_or_else(|| {
                Error::data(
                    entry.path().display().to_string(),
                    "a block of landings, `block-000000.parquet`",
                    name,
                )
            })?);
        }
        blocks.sort_unstable();
        Ok(blocks)
    }

    /// Writes a block.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, sweep: &Sweep, block: u64, rows: &[LandingRow]) -> Result<()> {
        write(&self.path(block), &encode(sweep, rows)?)
    }

    /// Reads a block and checks that it is whole.
    ///
    /// # Errors
    /// A file that cannot be read, is of another sweep or lacks landings.
    pub fn read(&self, sweep: &Sweep, block: u64) -> Result<Vec<LandingRow>> {
        decode(sweep, &self.path(block), sweep.range(block))
    }

    /// Reads all landings.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_all(&self, sweep: &Sweep) -> Result<Vec<LandingRow>> {
        let mut rows = Vec::new();
        for block in 0..sweep.blocks() {
            rows.extend(self.read(sweep, block)?);
        }
        Ok(rows)
    }
}

/// Puts the shards of a campaign together in the folder `out`, and gives the sweep.
///
/// # Errors
/// Folders of different campaigns; blocks that are missing, broken, or there twice; an `out` that holds other landings.
/// Nothing is written then. A merge that was killed is completed by the next one.
pub fn merge(shards: &[PathBuf], out: &Path) -> Result<(Sweep, Store)> {
    let mut first: Option<(Sweep, &PathBuf)> = None;
    let mut places: Vec<Option<&PathBuf>> = Vec::new();
    for shard in shards {
        let sweep = Sweep::of_folder(shard)?;
        let (of, at) = first.get_or_insert_with(|| (sweep.clone(), shard));
        if of.sha256() != sweep.sha256() {
            return Err(Error::Arguments(format!(
                "{} and {}: campaigns of different settings (SHA-256 {} and {})",
                at.display(),
                shard.display(),
                of.sha256(),
                sweep.sha256()
            )));
        }
        places.resize(of.blocks() as usize, None);
        let store = Store::of(shard);
        for block in store.present()? {
            let Some(place) = places.get_mut(block as usize) else {
                return Err(Error::data(
                    store.path(block).display().to_string(),
                    format!("blocks 0 to {}", of.blocks() - 1),
                    format!("block {block}"),
                ));
            };
            if let Some(other) = place {
                return Err(Error::Arguments(format!(
                    "block {block} is there twice: in {} and in {}",
                    other.display(),
                    shard.display()
                )));
            }
            *place = Some(shard);
        }
    }
    let Some((sweep, _)) = first else {
        return Err(Error::Arguments(
            "expected folders of shards, found none".into(),
        ));
    };
    let holes: Vec<String> = (0..sweep.blocks())
        .filter(|b| places[*b as usize].is_none())
        .map(|b| b.to_string())
        .collect();
    if !holes.is_empty() {
        let shown = holes[..holes.len().min(10)].join(", ");
        return Err(Error::Arguments(format!(
            "{} of {} blocks are missing: {shown}{}; run them with --shard or --resume",
            holes.len(),
            sweep.blocks(),
            if holes.len() > 10 { ", …" } else { "" }
        )));
    }
    let there = Store::of(out);
    let present = there.present()?;
    let mut blocks = Vec::with_capacity(places.len());
    for (block, shard) in (0_u64..).zip(places.into_iter().flatten()) {
        let from = Store::of(shard);
        from.read(&sweep, block)?;
        let path = from.path(block);
        if present.binary_search(&block).is_ok() && bytes(&there.path(block))? != bytes(&path)? {
            return Err(Error::Arguments(format!(
                "{}: contains another block {block} than {}; choose another folder",
                out.display(),
                shard.display()
            )));
        }
        blocks.push(path);
    }
    let store = Store::open(out, &sweep, CampaignPart::Whole, true)?;
    for (block, path) in (0_u64..).zip(&blocks) {
        if present.binary_search(&block).is_err() {
            write(&store.path(block), &bytes(path)?)?;
        }
    }
    Ok((sweep, store))
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| Error::file(path, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_sweep_in_its_own_folder_stays_as_its_author_wrote_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(SWEEP);
        let words = "# Mine.\ntrials = 1\n";
        std::fs::write(&file, words).unwrap();
        let sweep = Sweep::read(&file, None, None).unwrap();
        Store::open(folder.path(), &sweep, CampaignPart::Whole, false).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), words);
        // In another one it is written out.
        let out = folder.path().join("out");
        Store::open(&out, &sweep, CampaignPart::Whole, false).unwrap();
        let there = Sweep::load(&out.join(SWEEP), None, None).unwrap();
        assert_eq!(there.sha256(), sweep.sha256());
    }

    #[test]
    fn prop_only_the_last_run_in_a_folder_takes_left_files_away() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("sweep.toml");
        std::fs::write(&file, "trials = 1\n").unwrap();
        let sweep = Sweep::read(&file, None, None).unwrap();
        let out = folder.path().join("out");
        let one = Store::open(&out, &sweep, CampaignPart::Whole, false).unwrap();
        // As the one is in the middle of a write.
        let writing = out.join(LANDINGS).join(format!("{TEMPORARY_PREFIX}x"));
        std::fs::write(&writing, "PAR1").unwrap();
        let two = Store::open(&out, &sweep, CampaignPart::Whole, true).unwrap();
        assert!(writing.exists());
        drop(one);
        let three = Store::open(&out, &sweep, CampaignPart::Whole, true).unwrap();
        assert!(writing.exists());
        drop((two, three));
        // A part may have neighbours on machines whose locks are not seen here.
        let part = CampaignPart::Shard("1/2".parse().unwrap());
        drop(Store::open(&out, &sweep, part, true).unwrap());
        assert!(writing.exists());
        Store::open(&out, &sweep, CampaignPart::Whole, true).unwrap();
        assert!(!writing.exists());
    }
}
