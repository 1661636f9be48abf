//! A campaign's files: the sweep, and a file for each block of landings.

use std::fs::File;
use std::path::{Path, PathBuf};

use touchdown_files::TEMPORARY_PREFIX;

use super::part::CampaignPart;
use super::points::Sweep;
use super::row::{LandingRow, decode, encode};
use crate::error::{Error, Result};
use crate::files::folder;
use crate::place::Place;
use crate::settings_file::to_toml;

/// Name of the sweep in a campaign's folder.
pub const SWEEP: &str = "sweep.toml";
/// Folder of the blocks.
const LANDINGS: &str = "landings";

/// The files of one campaign.
#[derive(Debug)]
pub struct Store {
    place: Place,
    /// While it is held, no other run takes half-written files for left ones.
    _in_use: Option<File>,
}

impl Store {
    /// Opens the place of a campaign, or begins it; `resume` allows for landings that are there. Runs of parts of a
    /// campaign may share a place.
    ///
    /// # Errors
    /// A place with landings of other settings, or with any where `resume` was not asked for.
    pub fn open(place: &Place, sweep: &Sweep, part: CampaignPart, resume: bool) -> Result<Self> {
        let mut store = Self::of(place);
        let begun = place.has(SWEEP)?;
        if begun {
            let there = Sweep::of(place)?;
            if there.sha256() != sweep.sha256() {
                return Err(Error::Arguments(format!(
                    "{place}: contains a campaign of other settings (SHA-256 {}, these are {}); choose another folder",
                    there.sha256(),
                    sweep.sha256()
                )));
            }
        }
        if !resume && !store.present()?.is_empty() {
            return Err(Error::Arguments(format!(
                "{place}: contains landings of this campaign already; --resume completes it"
            )));
        }
        if let Place::Folder(out) = place {
            store._in_use = in_use(out, part)?;
        }
        // The present file has the same content, perhaps in another form.
        if !begun {
            for (name, bytes) in sweep.files() {
                place.write(name, bytes.to_vec())?;
            }
            place.write(SWEEP, to_toml(sweep.settings())?.into_bytes())?;
        }
        Ok(store)
    }

    /// The place of a campaign as it is, for reading.
    #[must_use]
    pub fn of(place: &Place) -> Self {
        Self {
            place: place.clone(),
            _in_use: None,
        }
    }

    /// Where the files are.
    #[must_use]
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The path or the address of a block.
    pub(super) fn path(&self, block: u64) -> PathBuf {
        self.place.path(&name(block))
    }

    /// The blocks that are there, in their order.
    ///
    /// # Errors
    /// A folder that cannot be read, or a file in it that is no block.
    pub fn present(&self) -> Result<Vec<u64>> {
        let mut blocks = Vec::new();
        for file in self.place.names(LANDINGS)? {
            if file.starts_with(TEMPORARY_PREFIX) {
                continue;
            }
            let number = file
                .strip_prefix("block-")
                .and_then(|n| n.strip_suffix(".parquet"));
            let path = format!("{LANDINGS}/{file}");
            let block = number
                .and_then(|n| n.parse().ok())
                .filter(|b| name(*b) == path);
            blocks.push(block.ok_or_else(|| {
                Error::data(
                    self.place.path(&path).display().to_string(),
                    "a block of landings, `block-000000.parquet`",
                    file,
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
        self.place.write(&name(block), encode(sweep, rows)?)
    }

    /// Reads a block and checks that it is whole.
    ///
    /// # Errors
    /// A file that cannot be read, is of another sweep or lacks landings.
    pub fn read(&self, sweep: &Sweep, block: u64) -> Result<Vec<LandingRow>> {
        decode(sweep, (&self.place, &name(block)), sweep.range(block))
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

/// Refuses a folder of a campaign, whole or not, to commands that would write other results beside its landings.
///
/// # Errors
/// A folder with a sweep and a folder of blocks.
pub fn must_not_be_a_campaign(out: &Path) -> Result<()> {
    if out.join(SWEEP).is_file() && out.join(LANDINGS).is_dir() {
        return Err(Error::Arguments(format!(
            "{}: contains a campaign ({SWEEP} and {LANDINGS}/); choose another folder",
            out.display()
        )));
    }
    Ok(())
}

/// Name of a block in a campaign's place.
fn name(block: u64) -> String {
    format!("{LANDINGS}/block-{block:06}.parquet")
}

/// Makes the folder of the blocks and takes part in its use.
fn in_use(out: &Path, part: CampaignPart) -> Result<Option<File>> {
    let landings = out.join(LANDINGS);
    folder(&landings)?;
    // Where folders cannot be locked, nothing is taken away: what a killed run left is in nobody's way.
    let lock = File::open(&landings).ok();
    if let Some(lock) = &lock {
        // Other parts may run on other machines, and not every shared disk shows their locks.
        if part == CampaignPart::Whole && lock.try_lock().is_ok() {
            for folder in [out, &landings] {
                sweep_up(folder)?;
            }
            let _ = lock.unlock();
        }
        // One of several runs, if there are any.
        let _ = lock.lock_shared();
    }
    Ok(lock)
}

/// Takes away what a killed run left half-written in a folder; other runs may be in the middle of it.
fn sweep_up(folder: &Path) -> Result<()> {
    for entry in std::fs::read_dir(folder).map_err(|e| Error::file(folder, e))? {
        let entry = entry.map_err(|e| Error::file(folder, e))?;
        let name = entry.file_name();
        if name.to_string_lossy().starts_with(TEMPORARY_PREFIX) {
            std::fs::remove_file(entry.path()).map_err(|e| Error::file(&entry.path(), e))?;
        }
    }
    Ok(())
}

/// Puts the shards of a campaign together in the place `out`, and gives the sweep.
///
/// # Errors
/// Parts of different campaigns; blocks that are missing, broken, or there twice; an `out` that holds other landings.
/// Nothing is written then. A merge that was killed is completed by the next one.
pub fn merge(shards: &[Place], out: &Place) -> Result<(Sweep, Store)> {
    let mut first: Option<(Sweep, &Place)> = None;
    let mut places: Vec<Option<&Place>> = Vec::new();
    for shard in shards {
        let sweep = Sweep::of(shard)?;
        let (of, at) = first.get_or_insert_with(|| (sweep.clone(), shard));
        if of.sha256() != sweep.sha256() {
            return Err(Error::Arguments(format!(
                "{at} and {shard}: campaigns of different settings (SHA-256 {} and {})",
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
                    "block {block} is there twice: in {other} and in {shard}"
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
    let mut shards = Vec::with_capacity(places.len());
    for (block, shard) in (0_u64..).zip(places.into_iter().flatten()) {
        Store::of(shard).read(&sweep, block)?;
        let name = name(block);
        if present.binary_search(&block).is_ok() && out.read(&name)? != shard.read(&name)? {
            return Err(Error::Arguments(format!(
                "{out}: contains another block {block} than {shard}; choose another folder"
            )));
        }
        shards.push(shard);
    }
    let store = Store::open(out, &sweep, CampaignPart::Whole, true)?;
    for (block, shard) in (0_u64..).zip(shards) {
        if present.binary_search(&block).is_err() {
            let name = name(block);
            out.write(&name, shard.read(&name)?)?;
        }
    }
    Ok((sweep, store))
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
        Store::open(&folder.path().into(), &sweep, CampaignPart::Whole, false).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), words);
        // In another one it is written out.
        let out = folder.path().join("out");
        Store::open(
            &Place::Folder(out.clone()),
            &sweep,
            CampaignPart::Whole,
            false,
        )
        .unwrap();
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
        let place = Place::Folder(out.clone());
        let one = Store::open(&place, &sweep, CampaignPart::Whole, false).unwrap();
        // As the one is in the middle of a write.
        let writing = out.join(LANDINGS).join(format!("{TEMPORARY_PREFIX}x"));
        std::fs::write(&writing, "PAR1").unwrap();
        let two = Store::open(&place, &sweep, CampaignPart::Whole, true).unwrap();
        assert!(writing.exists());
        drop(one);
        let three = Store::open(&place, &sweep, CampaignPart::Whole, true).unwrap();
        assert!(writing.exists());
        drop((two, three));
        // A part may have neighbours on machines whose locks are not seen here.
        let part = CampaignPart::Shard("1/2".parse().unwrap());
        drop(Store::open(&place, &sweep, part, true).unwrap());
        assert!(writing.exists());
        Store::open(&place, &sweep, CampaignPart::Whole, true).unwrap();
        assert!(!writing.exists());
    }
}
