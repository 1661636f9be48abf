//! A program that writes frames to its standard output. A V4L2 device is read by `v4l2-ctl`.

use std::collections::VecDeque;
use std::io::{BufRead as _, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use touchdown::Result;
use touchdown_link::LinkError;
use touchdown_link::camera::settings::CameraError;
use touchdown_link::camera::stamps::{BufferStamp, buffer_stamp};
use touchdown_link::camera::stream::{FrameParser, StreamFormat};
use touchdown_link::camera::{CameraSettings, Frame};

use super::Shared;
use super::clock::CameraClock;

/// Bytes that are read at once.
const PIECE: usize = 1 << 16;
/// Lines of the program's messages that are kept.
const LINES: usize = 4;
/// Longest time between an image and the line with its stamp: v4l2-ctl prints it right after the image. Without any
/// line in this time the frame counts as unstamped.
const STAMP_WAIT: Duration = Duration::from_millis(20);

/// A program that runs; it is killed when this is dropped.
pub(super) struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What the program writes beside the frames.
#[derive(Default)]
struct Messages {
    state: Mutex<MessageState>,
    news: Condvar,
}

#[derive(Default)]
struct MessageState {
    /// Stamps of images that have not been read yet; none for programs that print none.
    stamps: VecDeque<BufferStamp>,
    last: VecDeque<String>,
    ended: bool,
}

impl Messages {
    fn state(&self) -> MutexGuard<'_, MessageState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads until the program closes its messages.
    fn read(&self, from: ChildStderr, stamps: bool) {
        for line in BufReader::new(from)
            .split(b'\n')
            .map_while(std::io::Result::ok)
        {
            let line = String::from_utf8_lossy(&line);
            let mut state = self.state();
            match buffer_stamp(&line).filter(|_| stamps) {
                Some(stamp) => state.stamps.push_back(stamp),
                None if line.trim().is_empty() => {}
                None => {
                    if state.last.len() == LINES {
                        state.last.pop_front();
                    }
                    state.last.push_back(line.trim().to_string());
                }
            }
            self.news.notify_all();
        }
        self.state().ended = true;
        self.news.notify_all();
    }

    /// The stamp of the next image.
    fn stamp(&self) -> Option<BufferStamp> {
        let waits = |state: &mut MessageState| state.stamps.is_empty() && !state.ended;
        let state = self.state();
        let (mut state, _) = self
            .news
            .wait_timeout_while(state, STAMP_WAIT, waits)
            .unwrap_or_else(PoisonError::into_inner);
        state.stamps.pop_front()
    }

    /// The last lines, once the program has closed its messages, which it does when it ends.
    fn last(&self) -> String {
        let patience = Duration::from_millis(200);
        let (state, _) = self
            .news
            .wait_timeout_while(self.state(), patience, |state| !state.ended)
            .unwrap_or_else(PoisonError::into_inner);
        state.last.iter().cloned().collect::<Vec<_>>().join(" | ")
    }
}

/// What the source's thread needs.
struct Reader {
    from: ChildStdout,
    parser: FrameParser,
    messages: Arc<Messages>,
    /// Half of the exposure, µs, for stamps of a device; none for programs that stamp their frames themselves.
    half_exposure_us: Option<i64>,
    clock: CameraClock,
    shared: Arc<Shared>,
    name: String,
}

impl Program {
    /// Reads a V4L2 device as raw grey frames, with the driver's stamps.
    pub(super) fn of_device(
        device: &Path,
        camera: &CameraSettings,
        clock: CameraClock,
        shared: Arc<Shared>,
    ) -> Result<Self> {
        let [width, height] = camera.size_px();
        // Without `stdbuf` the end of an image would wait in a buffer for the next image.
        let mut command = Command::new("stdbuf");
        command.args(["-o0", "v4l2-ctl", "--device"]).arg(device);
        let pixels = match camera.format {
            StreamFormat::Yuyv => "YUYV",
            _ => "GREY",
        };
        command.arg(format!(
            "--set-fmt-video=width={width},height={height},pixelformat={pixels}"
        ));
        command.arg(format!("--set-parm={}", camera.rate_hz));
        command.args(["--stream-mmap=4", "--stream-to=-", "--verbose"]);
        let half_exposure_us = Some((0.5e6 * camera.exposure_s) as i64);
        let parser = FrameParser::new(camera.format, camera.size_px());
        Self::start(
            &mut command,
            "device",
            parser,
            half_exposure_us,
            clock,
            shared,
        )
    }

    /// Reads the frames of a program.
    pub(super) fn of_command(
        command: &[String],
        camera: &CameraSettings,
        clock: CameraClock,
        shared: Arc<Shared>,
    ) -> Result<Self> {
        let mut program = Command::new(&command[0]);
        program.args(&command[1..]);
        let parser = FrameParser::new(camera.format, camera.size_px());
        Self::start(&mut program, "command", parser, None, clock, shared)
    }

    fn start(
        command: &mut Command,
        key: &str,
        parser: FrameParser,
        half_exposure_us: Option<i64>,
        clock: CameraClock,
        shared: Arc<Shared>,
    ) -> Result<Self> {
        let name = command.get_program().to_string_lossy().into_owned();
        command.stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        // Ctrl-C is for the flight, which needs its camera until the vehicle is handed over.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        let mut child = command.spawn().map_err(|e| {
            LinkError::from(CameraError::new(
                key,
                &format!("cannot start `{name}`: {e}"),
            ))
        })?;
        let messages = Arc::new(Messages::default());
        if let Some(from) = child.stderr.take() {
            let messages = Arc::clone(&messages);
            let stamps = half_exposure_us.is_some();
            std::thread::spawn(move || messages.read(from, stamps));
        }
        if let Some(from) = child.stdout.take() {
            let reader = Reader {
                from,
                parser,
                messages,
                half_exposure_us,
                clock,
                shared,
                name,
            };
            std::thread::spawn(move || reader.run());
        }
        Ok(Self(child))
    }
}

impl Reader {
    fn run(mut self) {
        let why = self.read();
        let last = self.messages.last();
        let last = if last.is_empty() {
            String::new()
        } else {
            format!("; it said: {last}")
        };
        self.shared
            .slot
            .end(&format!("`{}`: {why}{last}", self.name));
    }

    /// Reads frames until there are no more, and says why.
    fn read(&mut self) -> String {
        let mut piece = vec![0; PIECE];
        loop {
            match self.from.read(&mut piece) {
                Ok(0) if self.parser.waiting() > 0 => {
                    return format!(
                        "it ended in the middle of a frame, after {} bytes of it",
                        self.parser.waiting()
                    );
                }
                Ok(0) => return "it ended".to_string(),
                Ok(length) => self.parser.push(&piece[..length]),
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => continue,
                Err(e) => return e.to_string(),
            }
            loop {
                match self.parser.next_frame() {
                    Ok(Some(frame)) => {
                        if let Err(why) = self.put(frame) {
                            return why;
                        }
                    }
                    Ok(None) => break,
                    Err(e) => return e.to_string(),
                }
            }
        }
    }

    /// Hands a frame on. The driver of a device may choose another size than it is asked for.
    fn put(&self, frame: Frame) -> std::result::Result<(), String> {
        let at_us = self.clock.now_us();
        let monotonic_us = match self.half_exposure_us {
            None => frame.stamp_us,
            Some(half_us) => {
                let stamp = self.messages.stamp();
                let expected = self.parser.frame_bytes();
                let bytes = stamp.and_then(|stamp| stamp.bytes);
                if let Some(found) = bytes.filter(|bytes| *bytes != expected) {
                    return Err(format!(
                        "expected images of {expected} bytes by `camera.width_px`, `camera.height_px` and `camera.format`, found {found}; `v4l2-ctl --list-formats-ext` names what the device has"
                    ));
                }
                stamp.and_then(|stamp| {
                    let middle_us = if stamp.starts { half_us } else { -half_us };
                    Some(stamp.stamp_us? + middle_us)
                })
            }
        };
        let stamp_us = monotonic_us.and_then(|us| self.clock.of_monotonic(us));
        self.shared.slot.put(Frame { stamp_us, ..frame }, at_us);
        Ok(())
    }
}
