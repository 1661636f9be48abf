//! What finds the deck in the camera's images, given by those who have a detector.

use std::fmt;
use std::sync::Arc;

use crate::error::SimError;
use crate::random::Stream;
use crate::sensors::TagSettings;
use crate::sensors::camera::fast::CameraFix;
use crate::sensors::camera::view::View;

/// Looks at the deck through the camera and says where it is.
pub trait Eye: Send {
    /// The pose of the deck found in the image that is exposed between two views; `None` where nothing
    /// is found. `up` is the deck's normal in camera axes as far as the vehicle knows its attitude;
    /// the image's noise comes from `stream`.
    ///
    /// # Errors
    /// Views that are no poses.
    fn look(
        &mut self,
        open: &View,
        shut: &View,
        up: [f64; 3],
        stream: &mut Stream,
    ) -> Result<Option<CameraFix>, SimError>;
}

type Open = dyn Fn(&TagSettings, Option<f64>) -> Result<Box<dyn Eye>, SimError> + Send + Sync;

/// Opens an eye for every landing.
#[derive(Clone)]
pub struct Eyes(Arc<Open>);

impl Eyes {
    /// Eyes that are opened by `open`, which is told the camera and the tags, and the side of the square deck (m)
    /// where it has an edge.
    pub fn new(
        open: impl Fn(&TagSettings, Option<f64>) -> Result<Box<dyn Eye>, SimError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self(Arc::new(open))
    }

    /// An eye behind this camera, over a square deck of the side `side_m` or one without an edge.
    ///
    /// # Errors
    /// Settings that the detector cannot work with.
    pub fn open(
        &self,
        settings: &TagSettings,
        side_m: Option<f64>,
    ) -> Result<Box<dyn Eye>, SimError> {
        (self.0)(settings, side_m)
    }
}

impl fmt::Debug for Eyes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Eyes")
    }
}
