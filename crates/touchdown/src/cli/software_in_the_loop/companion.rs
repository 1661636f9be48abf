//! The companion of `touchdown fly` in simulated time, with its recording and its sightings of the deck.

use std::path::Path;

use touchdown::Result;
use touchdown_flight::Vector;
use touchdown_lander::state_machine::{Phase, Reason};
use touchdown_link::LinkError;
use touchdown_link::camera::report::FrameReport;
use touchdown_link::camera::settings::CameraError;
use touchdown_link::camera::{CameraReport, Frame, Pipeline};
use touchdown_link::checklist::Verdict;
use touchdown_link::companion::{Companion, Event, Publication, Session, Stage, Summary};
use touchdown_link::recording::Recorder;
use touchdown_link::settings::FlightSettings;
use touchdown_link::simulator::sighting::Sightings;

/// State of the companion after a tick.
pub(super) struct CompanionState {
    pub(super) stage: Stage,
    pub(super) phase: Option<Phase>,
    pub(super) reason: Option<Reason>,
    pub(super) waits_for: Option<Reason>,
    pub(super) notes: Vec<String>,
}

/// The companion and its recording.
pub(super) struct SimulatedCompanion {
    companion: Companion,
    recorder: Option<Recorder>,
    publication: Publication,
    sightings: Sightings,
    /// Looks for the deck in frames, if the companion has a camera.
    pipeline: Option<Pipeline>,
    /// Nothing is given to it before its first tick.
    awake: bool,
}

impl SimulatedCompanion {
    /// A companion that takes control by itself, and records into a file if one is given.
    ///
    /// The simulated camera takes the place of the one that the settings name. It gives `images`, or the deck's positions.
    pub(super) fn new(
        settings: &FlightSettings,
        recording: Option<&Path>,
        images: bool,
    ) -> Result<Self> {
        let session = Session {
            take_control: true,
            ..Session::default()
        };
        let source = images.then(|| vec!["touchdown".to_string(), "simulator".to_string()]);
        let settings = &settings.with_camera_command(source);
        let companion = Companion::new(settings, &session);
        Ok(Self {
            companion: companion.map_err(touchdown_link::LinkError::from)?,
            recorder: recording
                .map(|path| Recorder::create(path, settings, &session))
                .transpose()?,
            publication: Publication::default(),
            sightings: Sightings::default(),
            pipeline: images
                .then(|| Pipeline::new(&settings.camera))
                .transpose()
                .map_err(touchdown_link::LinkError::from)?,
            awake: false,
        })
    }

    /// Bytes of the autopilot.
    pub(super) fn receives(&mut self, now_us: u64, bytes: &[u8], out: &mut Vec<u8>) -> Result<()> {
        if self.awake {
            self.handle(now_us, Event::Received(bytes), out)?;
        }
        Ok(())
    }

    /// A frame of the camera, which is `age_us` old as far as the camera knows.
    pub(super) fn films(&mut self, now_us: u64, frame: &Frame, age_us: u64) -> Result<()> {
        let (Some(pipeline), true) = (&mut self.pipeline, self.awake) else {
            return Ok(());
        };
        let now = i64::try_from(now_us).unwrap_or(i64::MAX);
        let exposed_us = now.saturating_sub_unsigned(age_us);
        let located = pipeline.locate(frame, exposed_us, self.companion.attitude());
        let deck = located.map_err(|e| LinkError::from(CameraError::new("width_px", &e)))?;
        let report = CameraReport::Frame(FrameReport {
            exposed_us: Some(exposed_us),
            arrived_us: now,
            size_px: frame.size_px,
            dropped: 0,
            unreadable: 0,
            deck,
        });
        // A reading alone is answered by nothing.
        self.handle(now_us, Event::Camera(&report), &mut Vec::new())
    }

    /// The deck in the camera, from the vehicle, body axes, m; when the image was taken by the autopilot's clock.
    pub(super) fn sees(
        &mut self,
        now_us: u64,
        system: u8,
        position_m: [f64; 3],
        taken_us: Option<u64>,
    ) -> Result<()> {
        let (Some(taken_us), true) = (taken_us, self.awake) else {
            return Ok(());
        };
        let bytes = self
            .sightings
            .message(system, Vector::from_array(position_m), taken_us);
        // A reading alone is answered by nothing.
        self.handle(now_us, Event::Received(&bytes), &mut Vec::new())
    }

    /// A tick.
    pub(super) fn tick(&mut self, now_us: u64, out: &mut Vec<u8>) -> Result<CompanionState> {
        self.awake = true;
        self.handle(now_us, Event::Tick, out)?;
        self.publish()?;
        Ok(CompanionState {
            stage: self.companion.stage(),
            phase: match self.companion.stage() {
                Stage::InControl | Stage::Landed => self.companion.summary().phase,
                _ => None,
            },
            reason: self.companion.reason(),
            waits_for: self.companion.waits_for(),
            notes: self.companion.take_notes(),
        })
    }

    /// What of the checklist refuses control, a line each.
    pub(super) fn refusals(&self) -> Vec<String> {
        let items = self.companion.checklist().items.iter();
        items
            .filter(|item| item.verdict == Verdict::Refused)
            .map(|item| format!("REFUSED {}: {}", item.name, item.sentence))
            .collect()
    }

    /// Records the state of the flight.
    fn publish(&mut self) -> Result<()> {
        let state = self.companion.state();
        if let (true, Some(recorder)) = (self.publication.includes(&state), &mut self.recorder) {
            recorder.write_state(&state)?;
        }
        Ok(())
    }

    /// Ends the recording.
    pub(super) fn finish(mut self) -> Result<Summary> {
        if let Some(recorder) = self.recorder.take() {
            recorder.finish()?;
        }
        Ok(self.companion.summary())
    }

    fn handle(&mut self, now_us: u64, event: Event<'_>, out: &mut Vec<u8>) -> Result<()> {
        let before = out.len();
        self.companion.handle(now_us, event, out);
        if let Some(recorder) = &mut self.recorder {
            recorder.write(now_us, event, &out[before..])?;
        }
        Ok(())
    }
}
