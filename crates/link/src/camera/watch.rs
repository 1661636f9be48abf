//! What the camera gives, counted for the checklist and the summary.

use serde::Serialize;

use super::report::FrameReport;
use crate::timing::{Distribution, Quantiles};

/// The camera so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct CameraWatch {
    total: Counts,
    /// Since the last count.
    recent: Counts,
    /// The last count, a second: frames, and frames with a tag.
    pub(crate) rates_hz: Option<[f64; 2]>,
    pub(crate) newest: Option<FrameReport>,
    pub(crate) gone: Option<String>,
    /// Time from the exposure to the companion, of frames with a stamp.
    latency: Distribution,
    /// The newest of them, s.
    pub(crate) latency_s: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    frames: u64,
    with_tag: u64,
}

/// Summary of the camera at the end of a flight.
#[derive(Clone, Debug, Serialize)]
pub struct CameraSummary {
    /// Frames that were looked at.
    pub frames: u64,
    /// Frames with a tag of the pad.
    pub with_tag: u64,
    /// Frames that were dropped because a newer one came before they were looked at.
    pub dropped: u64,
    /// Images that could not be read.
    pub unreadable: u64,
    /// Time from the exposure to the companion, of frames with a stamp.
    pub latency: Option<Quantiles>,
    /// Why no frame came any more.
    pub gone: Option<String>,
}

impl CameraWatch {
    /// Counts a frame that reached the companion at `now_us`.
    pub(crate) fn take(&mut self, frame: &FrameReport, now_us: i64) {
        for counts in [&mut self.total, &mut self.recent] {
            counts.frames += 1;
            counts.with_tag += u64::from(frame.deck.is_some());
        }
        self.newest = Some(*frame);
        if let Some(exposed_us) = frame.exposed_us {
            let latency_us = now_us.saturating_sub(exposed_us);
            self.latency_s = Some(latency_us as f64 * 1e-6);
            self.latency.add(u64::try_from(latency_us).unwrap_or(0));
        }
    }

    /// Counts the frames of the last `elapsed_s`.
    pub(crate) fn count(&mut self, elapsed_s: f64) {
        let recent = std::mem::take(&mut self.recent);
        let rates = [recent.frames, recent.with_tag].map(|count| count as f64 / elapsed_s);
        self.rates_hz = Some(rates);
    }

    pub(crate) fn summary(&self) -> CameraSummary {
        let newest = |of: fn(&FrameReport) -> u64| self.newest.as_ref().map_or(0, of);
        CameraSummary {
            frames: self.total.frames,
            with_tag: self.total.with_tag,
            dropped: newest(|frame| frame.dropped),
            unreadable: newest(|frame| frame.unreadable),
            latency: self.latency.quantiles(),
            gone: self.gone.clone(),
        }
    }
}
