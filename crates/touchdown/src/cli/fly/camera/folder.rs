//! A folder of images, played at their times.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

use touchdown::Result;
use touchdown_link::LinkError;
use touchdown_link::camera::files::{self, LARGEST_FILE};
use touchdown_link::camera::folder::{TimedImage, Times, images};
use touchdown_link::camera::settings::CameraError;
use touchdown_link::camera::{Frame, FrameError};

use super::Shared;
use super::clock::CameraClock;

/// Longest sleep, µs: the end of the flight is noticed within it.
const SLEEP_US: i64 = 50_000;

/// The images of a folder.
pub(super) struct Images {
    folder: PathBuf,
    images: Vec<TimedImage>,
    size_px: [usize; 2],
}

fn bad(reason: &dyn std::fmt::Display) -> LinkError {
    CameraError::new("folder", reason).into()
}

impl Images {
    /// Reads the names and times. The first image must be readable.
    pub(super) fn open(folder: &Path, times: &Times, size_px: [usize; 2]) -> Result<Self> {
        let at = |path: &Path, reason: &dyn std::fmt::Display| {
            bad(&format!("{}: {reason}", path.display()))
        };
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(|e| at(folder, &e))? {
            let name = entry.map_err(|e| at(folder, &e))?.file_name();
            names.extend(name.into_string());
        }
        let table = match times {
            Times::Names => None,
            Times::Table(file) => {
                let path = folder.join(file);
                Some(std::fs::read_to_string(&path).map_err(|e| at(&path, &e))?)
            }
        };
        let images = Self {
            images: images(&names, table.as_deref()).map_err(|e| at(folder, &e))?,
            folder: folder.to_owned(),
            size_px,
        };
        if let Some(first) = images.images.first() {
            let path = images.folder.join(&first.name);
            images.read(&first.name).map_err(|e| at(&path, &e))?;
        }
        Ok(images)
    }

    /// Reads an image.
    fn read(&self, name: &str) -> std::result::Result<Frame, FrameError> {
        let read = || {
            let mut bytes = Vec::new();
            let file = touchdown_files::open(&self.folder.join(name))?;
            file.take(LARGEST_FILE + 1).read_to_end(&mut bytes)?;
            Ok::<_, std::io::Error>(bytes)
        };
        let of = |found: String| FrameError::Format {
            expected: format!("an image file of at most {LARGEST_FILE} bytes"),
            found,
        };
        let bytes = read().map_err(|e| of(e.to_string()))?;
        if bytes.len() as u64 > LARGEST_FILE {
            return Err(of("more".to_string()));
        }
        files::decode(&bytes, self.size_px)
    }

    /// Gives each image at its time, the first one now. One that cannot be read is counted.
    pub(super) fn play(self, shared: &Shared, clock: CameraClock) {
        let start_us = clock.now_us();
        for image in &self.images {
            let exposed_us = start_us + image.time_us;
            loop {
                if shared.stopped.load(Ordering::Relaxed) {
                    return;
                }
                let left_us = (exposed_us - clock.now_us()).min(SLEEP_US);
                match u64::try_from(left_us) {
                    Ok(left_us) if left_us > 0 => {
                        std::thread::sleep(Duration::from_micros(left_us));
                    }
                    _ => break,
                }
            }
            match self.read(&image.name) {
                Ok(frame) => {
                    let stamp_us = Some(exposed_us);
                    shared.slot.put(Frame { stamp_us, ..frame }, clock.now_us());
                }
                Err(_) => shared.slot.count_unreadable(),
            }
        }
        shared.slot.end("the folder has no more images");
    }
}
