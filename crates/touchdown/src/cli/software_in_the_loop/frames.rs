//! Rendered frames of the simulated camera: to the companion, to a folder, or to a named pipe.
//!
//! A folder gets an image `000012.png` for each frame and the table `times.csv`, which `[camera]` of `touchdown fly` reads.
//! A named pipe gets PGM images, which a `touchdown fly` beside the simulation reads by `command = ["cat", PIPE]`.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use touchdown::{Error, Result};
use touchdown_campaign::camera::Film;
use touchdown_link::camera::{Frame, files};
use touchdown_sim::landing::space::DeckSighting;

use super::session::LandedBy;
use super::world;

/// Where frames are written.
enum Output {
    /// A folder, and the table of its times.
    Folder(PathBuf, File),
    Pipe(PathBuf, File),
}

/// The frames of a landing's camera.
pub(super) struct RenderedFrames {
    film: Film,
    output: Option<Output>,
}

fn failed(path: &Path) -> impl Fn(std::io::Error) -> Error + '_ {
    move |e| Error::Arguments(format!("--frames: {}: {e}", path.display()))
}

/// Whether a path is that of a named pipe.
#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    std::fs::metadata(path).is_ok_and(|found| found.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_path: &Path) -> bool {
    false
}

impl Output {
    /// Opens a named pipe, or makes a folder for a landing.
    fn open(path: &Path, landing: u64) -> Result<Self> {
        if is_pipe(path) {
            // This waits for the reader.
            let pipe = File::options().write(true).open(path);
            return Ok(Self::Pipe(path.to_owned(), pipe.map_err(failed(path))?));
        }
        let folder = path.join(landing.to_string());
        std::fs::create_dir_all(&folder).map_err(failed(&folder))?;
        let table = folder.join("times.csv");
        let mut file = File::create(&table).map_err(failed(&table))?;
        writeln!(file, "file,time_s").map_err(failed(&table))?;
        Ok(Self::Folder(folder, file))
    }

    fn write(&mut self, number: u64, frame: &Frame, exposed_us: u64) -> Result<()> {
        match self {
            Self::Folder(folder, table) => {
                let name = format!("{number:06}.png");
                let png = files::encode_png(frame);
                let png = png.map_err(|e| Error::Arguments(format!("--frames: {e}")))?;
                let path = folder.join(&name);
                std::fs::write(&path, png).map_err(failed(&path))?;
                let time_s = exposed_us as f64 * 1e-6;
                writeln!(table, "{name},{time_s:.6}").map_err(failed(folder))
            }
            Self::Pipe(path, pipe) => {
                let image = files::encode_pgm(frame);
                pipe.write_all(&image).map_err(failed(path))
            }
        }
    }
}

impl RenderedFrames {
    /// The frames on a film, which are also written if a folder or a named pipe is given.
    pub(super) fn new(film: Film, output: Option<&Path>, landing: u64) -> Result<Self> {
        let output = output.map(|path| Output::open(path, landing)).transpose()?;
        Ok(Self { film, output })
    }

    /// The frame of a sighting has arrived.
    pub(super) fn frame(
        &mut self,
        sighting: &DeckSighting,
        now_us: u64,
        landed_by: &mut LandedBy,
    ) -> Result<()> {
        let Some(frame) = self.film.take(sighting.frame) else {
            return Ok(());
        };
        let frame = Frame {
            pixels: frame.pixels,
            size_px: frame.size_px,
            stamp_us: None,
        };
        let age_us = world::microseconds(sighting.age_s);
        if let Some(output) = &mut self.output {
            output.write(sighting.frame, &frame, now_us.saturating_sub(age_us))?;
        }
        match landed_by {
            LandedBy::Companion(companion) => companion.films(now_us, &frame, age_us),
            LandedBy::GroundStation | LandedBy::AutopilotMode => Ok(()),
        }
    }
}
