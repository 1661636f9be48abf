//! The seam for a camera that renders images and detects tags in them.
//!
//! This crate has neither renderer nor detector. Who has both implements [`CameraPipeline`] and
//! gives the landings a [`PipelineFactory`].

use std::fmt;
use std::sync::Arc;

use crate::error::SimError;
use crate::random::Stream;
use crate::sensors::TagSettings;
use crate::sensors::camera::fast::CameraFix;
use crate::sensors::camera::view::View;

/// Finds the deck in the image that the camera takes.
pub trait CameraPipeline: Send {
    /// The pose of the deck found in the image that is exposed from the view `open` to the view `shut`;
    /// `None` where nothing is found. `up` is the deck's normal in camera axes, as far as the vehicle
    /// knows its attitude; the image's noise comes from `stream`.
    ///
    /// # Errors
    /// A view is no pose ([`View::validate`]).
    fn locate(
        &mut self,
        open: &View,
        shut: &View,
        up: [f64; 3],
        stream: &mut Stream,
    ) -> Result<Option<CameraFix>, SimError>;
}

type Build =
    dyn Fn(&TagSettings, Option<f64>) -> Result<Box<dyn CameraPipeline>, SimError> + Send + Sync;

/// Builds a [`CameraPipeline`] for every landing.
#[derive(Clone)]
pub struct PipelineFactory(Arc<Build>);

impl PipelineFactory {
    /// A factory that calls `build` with camera and tags, and with the side of the square deck (m)
    /// where it has an edge.
    pub fn new(
        build: impl Fn(&TagSettings, Option<f64>) -> Result<Box<dyn CameraPipeline>, SimError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self(Arc::new(build))
    }

    /// The pipeline of a camera over a square deck of the side `side_m`, or over one without an edge.
    ///
    /// # Errors
    /// Settings that the detector cannot work with.
    pub fn build(
        &self,
        settings: &TagSettings,
        side_m: Option<f64>,
    ) -> Result<Box<dyn CameraPipeline>, SimError> {
        (self.0)(settings, side_m)
    }
}

impl fmt::Debug for PipelineFactory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("PipelineFactory")
    }
}
