//! The autopilot's process: started in a scratch folder, and stopped with all that it left.

use std::fs::File;
use std::net::UdpSocket;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use touchdown::{Error, Result};

/// File of what the autopilot prints.
const CONSOLE: &str = "console.log";
/// Lines of it that an error shows.
const SHOWN: usize = 12;

/// Distinguishes the scratch folders of one process.
static NEXT: AtomicU32 = AtomicU32::new(0);

/// A scratch folder, removed at the end.
struct Scratch {
    path: PathBuf,
    keep: bool,
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if !self.keep {
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}

/// A process and its folder. The end of the value kills the one and removes the other.
struct Running {
    child: Child,
    scratch: Scratch,
    /// Files outside of the folder that the autopilot leaves when it is killed.
    leftovers: Vec<PathBuf>,
}

impl Drop for Running {
    fn drop(&mut self) {
        // The start-up script of PX4 has children of its own: the whole group ends.
        let group = format!("-{}", self.child.id());
        let killed = Command::new("kill").args(["-KILL", "--", &group]).output();
        if !killed.is_ok_and(|output| output.status.success()) {
            let _ = self.child.kill();
        }
        let _ = self.child.wait();
        for path in &self.leftovers {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// An autopilot that this command has started. Clones share it.
#[derive(Clone)]
pub(super) struct AutopilotProcess {
    running: Arc<Mutex<Option<Running>>>,
    interrupted: Arc<AtomicBool>,
    folder: PathBuf,
}

/// How to start an autopilot.
pub(super) struct Launch {
    pub(super) program: PathBuf,
    pub(super) arguments: Vec<String>,
    pub(super) environment: Vec<(String, String)>,
    pub(super) leftovers: Vec<PathBuf>,
    /// Files of the scratch folder: names and contents.
    pub(super) files: Vec<(&'static str, String)>,
    pub(super) keep: bool,
}

impl AutopilotProcess {
    /// Starts it.
    pub(super) fn start(launch: Launch) -> Result<Self> {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("touchdown-simulator-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir(&folder).map_err(|e| Error::file(&folder, e))?;
        let scratch = Scratch {
            path: folder.clone(),
            keep: launch.keep,
        };
        for (name, text) in &launch.files {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(|e| Error::file(&path, e))?;
        }
        let path = folder.join(CONSOLE);
        let console = File::create(&path).map_err(|e| Error::file(&path, e))?;
        let errors = console.try_clone().map_err(|e| Error::file(&path, e))?;
        let child = Command::new(&launch.program)
            .args(&launch.arguments)
            .envs(launch.environment)
            .current_dir(&folder)
            .stdin(Stdio::null())
            .stdout(console)
            .stderr(errors)
            .process_group(0)
            .spawn()
            .map_err(|e| Error::file(&launch.program, e))?;
        let running = Running {
            child,
            scratch,
            leftovers: launch.leftovers,
        };
        Ok(Self {
            running: Arc::new(Mutex::new(Some(running))),
            interrupted: Arc::default(),
            folder,
        })
    }

    /// Stops it and removes what it left. Whoever asks second waits until that is done.
    pub(super) fn stop(&self) {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        drop(running.take());
    }

    /// Stops it because of Ctrl-C, whose handler ends this process then.
    pub(super) fn interrupt(&self) {
        self.interrupted.store(true, Ordering::SeqCst);
        self.stop();
    }

    /// After Ctrl-C, waits for the end of this process: the autopilot's end is no error to report.
    pub(super) fn wait_if_interrupted(&self) {
        while self.interrupted.load(Ordering::SeqCst) {
            std::thread::park();
        }
    }

    /// Its folder, if that is kept.
    pub(super) fn kept(&self) -> Option<&Path> {
        let running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        let keep = running.as_ref().is_some_and(|running| running.scratch.keep);
        keep.then_some(self.folder.as_path())
    }

    /// The end of what it printed.
    pub(super) fn last_words(&self) -> String {
        let bytes = std::fs::read(self.folder.join(CONSOLE)).unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes);
        let lines: Vec<&str> = text.lines().collect();
        lines[lines.len().saturating_sub(SHOWN)..].join("\n")
    }

    /// Whether it has ended by itself.
    pub(super) fn has_ended(&self) -> bool {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        running
            .as_mut()
            .is_none_or(|running| !matches!(running.child.try_wait(), Ok(None)))
    }
}

/// Whether nobody has a UDP port of this machine.
pub(super) fn udp_is_free(port: u16) -> bool {
    UdpSocket::bind(("127.0.0.1", port)).is_ok()
}

/// A free UDP port.
pub(super) fn free_udp() -> Result<u16> {
    let free = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
    free.map(|address| address.port())
        .map_err(|e| Error::Arguments(format!("no free UDP port: {e}")))
}
