//! The camera of a flight: two threads beside the flight's loop.
//!
//! | thread | does |
//! | --- | --- |
//! | source | waits for frames of a device, a program or a folder, and puts the newest one into a slot |
//! | pipeline | takes the frame from the slot, looks for the deck, and sends what it found to the flight's loop |
//!
//! A frame that is replaced in the slot before the pipeline takes it is dropped and counted. The loop waits for neither.

mod clock;
mod folder;
mod program;
mod slot;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use touchdown::Result;
use touchdown_flight::Attitude;
use touchdown_link::LinkError;
use touchdown_link::camera::report::FrameReport;
use touchdown_link::camera::settings::Source;
use touchdown_link::camera::{CameraReport, Pipeline, files};
use touchdown_link::settings::FlightSettings;

use super::flight::Arrival;
use super::recorder::Images;
use clock::CameraClock;
use program::Program;
use slot::{Arrived, Slot};

/// What the threads share with the flight's loop.
struct Shared {
    slot: Slot,
    /// The vehicle's newest attitude.
    attitude: Mutex<Option<Attitude<f64>>>,
    stopped: AtomicBool,
}

/// A camera that runs. It ends when it is dropped.
pub(super) struct Camera {
    shared: Arc<Shared>,
    program: Option<Program>,
    clock: CameraClock,
    record_us: Option<i64>,
    waiting: Option<Pipeline>,
    pipeline: Option<JoinHandle<()>>,
}

impl Camera {
    /// Starts the camera that the settings name, if they do. Times count from `start`.
    pub(super) fn start(settings: &FlightSettings, start: Instant) -> Result<Option<Self>> {
        let camera = &settings.camera;
        let Some(source) = camera.source().map_err(LinkError::from)? else {
            return Ok(None);
        };
        let pipeline = Pipeline::new(camera).map_err(LinkError::from)?;
        let shared = Arc::new(Shared {
            slot: Slot::default(),
            attitude: Mutex::new(None),
            stopped: AtomicBool::new(false),
        });
        let clock = CameraClock::since(start);
        let program = match source {
            Source::Folder(folder, times) => {
                let images = folder::Images::open(folder, times, camera.size_px())?;
                let shared = Arc::clone(&shared);
                std::thread::spawn(move || images.play(&shared, clock));
                None
            }
            Source::Device(device) => Some(Program::of_device(
                device,
                camera,
                clock,
                Arc::clone(&shared),
            )?),
            Source::Command(command) => Some(Program::of_command(
                command,
                camera,
                clock,
                Arc::clone(&shared),
            )?),
        };
        Ok(Some(Self {
            shared,
            program,
            clock,
            record_us: (camera.record_hz > 0.0).then(|| (1e6 / camera.record_hz) as i64),
            waiting: Some(pipeline),
            pipeline: None,
        }))
    }

    /// Looks for the deck from now on.
    pub(super) fn look(&mut self, arriving: SyncSender<Arrival>, images: Images) {
        let Some(pipeline) = self.waiting.take() else {
            return;
        };
        let look = Look {
            shared: Arc::clone(&self.shared),
            pipeline,
            clock: self.clock,
            record_us: self.record_us,
            recorded_us: i64::MIN,
            arriving: Goodbye(arriving),
            images,
        };
        self.pipeline = Some(std::thread::spawn(move || look.run()));
    }

    /// Tells the pipeline the vehicle's attitude. It never waits.
    pub(super) fn tell(&self, attitude: Option<Attitude<f64>>) {
        if let Ok(mut newest) = self.shared.attitude.try_lock() {
            *newest = attitude;
        }
    }
}

impl Drop for Camera {
    fn drop(&mut self) {
        self.shared.stopped.store(true, Ordering::Relaxed);
        self.shared.slot.end("the flight has ended");
        self.program.take();
        if let Some(pipeline) = self.pipeline.take() {
            // A panic of it was reported as a camera that is gone.
            let _ = pipeline.join();
        }
    }
}

/// Where reports go. If the pipeline ends by a panic, it reports that the camera is gone.
struct Goodbye(SyncSender<Arrival>);

impl Goodbye {
    fn send(&self, report: CameraReport) {
        // A loop that is that far behind has long handed over.
        let _ = self
            .0
            .try_send(Arrival::Camera(Instant::now(), Box::new(report)));
    }
}

impl Drop for Goodbye {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.send(CameraReport::Gone("its pipeline panicked".to_string()));
        }
    }
}

/// The pipeline's thread.
struct Look {
    shared: Arc<Shared>,
    pipeline: Pipeline,
    clock: CameraClock,
    /// Least time between two recorded images, µs; none if images are not recorded.
    record_us: Option<i64>,
    recorded_us: i64,
    arriving: Goodbye,
    images: Images,
}

impl Look {
    fn run(mut self) {
        let gone = loop {
            match self.shared.slot.take() {
                Ok(arrived) => {
                    if let Err(error) = self.look(&arrived) {
                        break error.to_string();
                    }
                }
                Err(gone) => break gone,
            }
        };
        if !self.shared.stopped.load(Ordering::Relaxed) {
            self.arriving.send(CameraReport::Gone(gone));
        }
    }

    fn look(
        &mut self,
        arrived: &Arrived,
    ) -> std::result::Result<(), touchdown_link::camera::FrameError> {
        let attitude = *self
            .shared
            .attitude
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let frame = &arrived.frame;
        let exposed_us = frame.stamp_us;
        let at_us = exposed_us.unwrap_or(arrived.at_us);
        let deck = self.pipeline.locate(frame, at_us, attitude)?;
        self.arriving.send(CameraReport::Frame(FrameReport {
            exposed_us,
            arrived_us: arrived.at_us,
            size_px: frame.size_px,
            dropped: arrived.dropped,
            unreadable: arrived.unreadable,
            deck,
        }));
        let due = |period_us: i64| arrived.at_us.saturating_sub(self.recorded_us) >= period_us;
        if self.record_us.is_some_and(due) {
            self.recorded_us = arrived.at_us;
            let at_us = u64::try_from(self.clock.now_us()).unwrap_or(0);
            self.images.write(at_us, files::encode_png(frame)?);
        }
        Ok(())
    }
}
