//! What reaches the companion from its camera, and stands in the recording.

use serde::{Deserialize, Serialize};

/// News of the camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraReport {
    /// A frame was looked at.
    Frame(FrameReport),
    /// No frame will come any more, and why.
    Gone(String),
}

/// What was found in a frame. Times are of the companion's clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameReport {
    /// Middle of the exposure, µs; none if nobody stamped it.
    pub exposed_us: Option<i64>,
    /// When the whole frame had arrived, µs.
    pub arrived_us: i64,
    /// Width and height, px.
    pub size_px: [usize; 2],
    /// Frames so far that were dropped because a newer one came before they were looked at.
    pub dropped: u64,
    /// Images so far that could not be read.
    pub unreadable: u64,
    /// The deck, if a tag of its pad was found.
    pub deck: Option<DeckFix>,
}

/// The deck as it was found in a frame, in body axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeckFix {
    /// The deck's centre from the vehicle's reference point, m.
    pub position_m: [f64; 3],
    /// Covariance of this position, m².
    pub covariance_m2: [[f64; 3]; 3],
    /// The deck's normal.
    pub normal: [f64; 3],
    /// Tags that had a part in it.
    pub tags: usize,
    /// Root mean square of the residuals of the tags' corners, px.
    pub residual_px: f64,
}

impl CameraReport {
    /// The report as a line of JSON, from which it comes back bit for bit.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Numbers that are not finite become null: the pipeline makes none.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// The report of a line of JSON.
    #[must_use]
    pub fn from_json(bytes: &[u8]) -> Option<Self> {
        serde_json::from_slice(bytes).ok()
    }
}
