//! A campaign's folder: the sweep, and a file for each block of landings.

use std::path::{Path, PathBuf};

use touchdown_log::TEMPORARY_PREFIX;

use super::points::{SERIES, Sweep};
use super::row::{Row, decode, encode};
use crate::error::{Error, Result};
use crate::files::{folder, write};
use crate::settings::to_toml;

/// Name of the sweep in a campaign's folder.
const SWEEP: &str = "sweep.toml";
/// Folder of the blocks.
const LANDINGS: &str = "landings";

/// The folder of one campaign.
#[derive(Debug)]
pub struct Store {
    out: PathBuf,
}

impl Store {
    /// Opens the folder of a campaign, or begins it; `resume` allows for landings that are there.
    ///
    /// # Errors
    /// A folder with landings of other settings, or with any where `resume` was not asked for.
    pub fn open(out: &Path, sweep: &Sweep, resume: bool) -> Result<Self> {
        let store = Self {
            out: out.to_owned(),
        };
        let at = out.join(SWEEP);
        if at.exists() {
            let there = Sweep::read(&at, None, None)?;
            if there.sha256() != sweep.sha256() {
                return Err(Error::Arguments(format!(
                    "{}: holds a campaign of other settings (SHA-256 {}, these are {}); choose another folder",
                    out.display(),
                    there.sha256(),
                    sweep.sha256()
                )));
            }
        }
        if !resume && !store.present()?.is_empty() {
            return Err(Error::Arguments(format!(
                "{}: holds landings of this campaign already; --resume completes it",
                out.display()
            )));
        }
        folder(&out.join(LANDINGS))?;
        store.sweep_up()?;
        if let Some(series) = &sweep.series {
            write(&out.join(SERIES), series)?;
        }
        write(&at, to_toml(sweep.settings())?.as_bytes())?;
        Ok(store)
    }

    /// Takes away what a killed run left half-written.
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

    fn path(&self, block: u64) -> PathBuf {
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
    pub fn write(&self, sweep: &Sweep, block: u64, rows: &[Row]) -> Result<()> {
        write(&self.path(block), &encode(sweep, rows)?)
    }

    /// Reads a block and checks that it is whole.
    ///
    /// # Errors
    /// A file that cannot be read, is of another sweep or lacks landings.
    pub fn read(&self, sweep: &Sweep, block: u64) -> Result<Vec<Row>> {
        decode(sweep, &self.path(block), sweep.range(block))
    }

    /// Reads all landings.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_all(&self, sweep: &Sweep) -> Result<Vec<Row>> {
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
/// Folders of different campaigns; blocks that are missing, or there twice; an `out` that holds landings.
pub fn merge(shards: &[PathBuf], out: &Path) -> Result<(Sweep, Store)> {
    let mut first: Option<(Sweep, &PathBuf)> = None;
    let mut places: Vec<Option<&PathBuf>> = Vec::new();
    for shard in shards {
        let sweep = Sweep::read(&shard.join(SWEEP), None, None)?;
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
        let store = Store { out: shard.clone() };
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
            "{} of {} blocks are missing: {shown}{}; fly them with --shard or --resume",
            holes.len(),
            sweep.blocks(),
            if holes.len() > 10 { ", …" } else { "" }
        )));
    }
    let store = Store::open(out, &sweep, false)?;
    for (block, shard) in places.iter().enumerate() {
        let Some(shard) = shard else { continue };
        let from = Store {
            out: (*shard).clone(),
        };
        from.read(&sweep, block as u64)?;
        let path = from.path(block as u64);
        let bytes = std::fs::read(&path).map_err(|e| Error::file(&path, e))?;
        write(&store.path(block as u64), &bytes)?;
    }
    Ok((sweep, store))
}
