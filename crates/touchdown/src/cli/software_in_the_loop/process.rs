//! The process of an autopilot: started in a scratch folder, and stopped with all that it left.

use std::fs::File;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use touchdown::{Error, Result};

/// File of what the autopilot prints.
const CONSOLE: &str = "console.log";
/// Lines of it that an error shows.
const SHOWN: usize = 12;
/// How long a process may take from the end of its connections to its own: a peer in Python was seen to close its link before it
/// had ended. Whoever reads the error waits no longer.
const LAST_BREATH: Duration = Duration::from_secs(2);
/// A shell that waits until its input ends, which it does when this command is gone however it ended. Then it kills the
/// autopilot's process group `$1` and removes what follows at once: the next command may soon have files of the same names. Only
/// of the scratch folder `$2`, whose name no other has (empty: none), it removes what a dying process still writes.
const GUARD: &str = r#"
read -r _
kill -s KILL -- "-$1"
shift
scratch=$1
rm -rf -- "$@"
for _ in 1 2 3 4 5; do
  [ -n "$scratch" ] && [ -e "$scratch" ] || break
  sleep 0.2
  rm -rf -- "$scratch"
done
"#;

/// Distinguishes the scratch folders of one process.
static NEXT: AtomicU32 = AtomicU32::new(0);

/// How to start an autopilot.
pub(super) struct Launch {
    pub(super) program: PathBuf,
    pub(super) arguments: Vec<String>,
    pub(super) environment: Vec<(String, String)>,
    /// Files outside of the scratch folder that the autopilot leaves when it is killed.
    pub(super) leftovers: Vec<PathBuf>,
    /// Files of the scratch folder: names and contents.
    pub(super) files: Vec<(&'static str, String)>,
    pub(super) keep: bool,
}

/// A scratch folder, removed at the end.
struct Scratch {
    path: PathBuf,
    keep: bool,
}

impl Scratch {
    fn remove(&self) {
        if !self.keep {
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        self.remove();
    }
}

/// A process and its folder. The end of the value kills the one and removes the other.
struct Running {
    child: Child,
    guard: Option<Child>,
    scratch: Scratch,
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
        self.scratch.remove();
        // The guard ends last. It removes the rest if the command is killed before this line.
        if let Some(guard) = &mut self.guard {
            let _ = guard.kill();
            let _ = guard.wait();
        }
    }
}

/// An autopilot that this command has started. Clones share it.
#[derive(Clone)]
pub(super) struct AutopilotProcess {
    running: Arc<Mutex<Option<Running>>>,
    folder: PathBuf,
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
        let mut running = Running {
            child,
            guard: None,
            scratch,
            leftovers: launch.leftovers,
        };
        // Without a shell, only a killed command leaves its autopilot behind.
        running.guard = guard(&running).ok();
        Ok(Self {
            running: Arc::new(Mutex::new(Some(running))),
            folder,
        })
    }

    /// Stops it and removes what it left. Whoever asks second waits until that is done.
    pub(super) fn stop(&self) {
        drop(self.running().take());
    }

    /// Its folder, if that is kept.
    pub(super) fn kept(&self) -> Option<&Path> {
        let running = self.running();
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

    /// How it has ended, if it ends within [`LAST_BREATH`]: a process that ends closes its connections first.
    pub(super) fn ends(&self) -> Option<String> {
        let until = Instant::now() + LAST_BREATH;
        loop {
            let ended = self.ended();
            if ended.is_some() || Instant::now() >= until {
                return ended;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// How it has ended, if it has.
    pub(super) fn ended(&self) -> Option<String> {
        match self
            .running()
            .as_mut()
            .map(|running| running.child.try_wait())
        {
            Some(Ok(None)) => None,
            Some(Ok(Some(status))) => Some(status.to_string()),
            Some(Err(error)) => Some(error.to_string()),
            None => Some("stopped".to_owned()),
        }
    }

    fn running(&self) -> MutexGuard<'_, Option<Running>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Starts the shell that cleans up after this command is killed.
fn guard(running: &Running) -> std::io::Result<Child> {
    let mut guard = Command::new("sh");
    guard.args(["-c", GUARD, "sh", &running.child.id().to_string()]);
    guard.arg(if running.scratch.keep {
        Path::new("")
    } else {
        &running.scratch.path
    });
    guard
        .args(&running.leftovers)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .process_group(0)
        .spawn()
}
