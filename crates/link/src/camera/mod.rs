//! The camera of a companion: from the bytes of images to the position of the deck.
//!
//! ```text
//! device, program ── bytes ──> stream ──┐
//!                                       ├─> Frame ──> pipeline ──> CameraReport ──> companion
//! folder ── files ──────────> files ────┘            (touchdown-vision)
//! ```
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`settings`] | source, intrinsics, mounting and pad, as they stand in `[camera]` |
//! | [`stream`] | frames in a stream of bytes: raw grey, PGM, Y4M |
//! | [`files`] | images in files: PNG, JPEG, PGM |
//! | [`folder`] | names and times of a folder of images |
//! | [`stamps`] | times of exposure as `v4l2-ctl` prints them |
//! | [`pipeline`] | a frame to the position of the deck, by `touchdown-vision` |
//! | [`report`] | what reaches the companion, and the recording |
//!
//! Nothing here reads a clock, opens a device or starts a thread: the caller does.

pub mod files;
pub mod folder;
pub mod pipeline;
pub mod report;
pub mod settings;
pub mod stamps;
pub mod stream;
mod watch;

pub use pipeline::Pipeline;
pub use report::CameraReport;
pub use settings::CameraSettings;
pub use watch::CameraSummary;
pub(crate) use watch::CameraWatch;

/// A grey image, one byte a pixel, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Frame {
    /// The bytes: width times height.
    pub pixels: Vec<u8>,
    /// Width and height, px.
    pub size_px: [usize; 2],
    /// Middle of the exposure, µs, of the clock that the source names; none for a source without stamps.
    pub stamp_us: Option<i64>,
}

/// What is wrong with an image, or with a stream of them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// An image of another size than the settings say.
    #[error(
        "expected {} x {} pixels (`camera.width_px`, `camera.height_px`), found {} x {}",
        expected[0], expected[1], found[0], found[1]
    )]
    Size {
        /// Width and height of the settings, px.
        expected: [usize; 2],
        /// Those of the image, px.
        found: [usize; 2],
    },
    /// Bytes that are no image.
    #[error("expected {expected}, found {found}")]
    Format {
        /// What a reader looks for.
        expected: String,
        /// What is there.
        found: String,
    },
}

impl FrameError {
    fn format(expected: &str, found: impl Into<String>) -> Self {
        Self::Format {
            expected: expected.to_string(),
            found: found.into(),
        }
    }
}

/// The beginning of bytes that were not expected, as text.
fn excerpt(bytes: &[u8]) -> String {
    const SHOWN: usize = 32;
    if bytes.is_empty() {
        return "nothing".to_string();
    }
    let shown = &bytes[..bytes.len().min(SHOWN)];
    format!("`{}`", shown.escape_ascii())
}
