//! A flight of `touchdown fly` against the peer, as two processes.

use std::io::{BufRead, BufReader, PipeWriter, Read, Write as _, pipe};
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Condvar, Mutex, PoisonError, mpsc};
use std::time::Duration;

use serde_json::Value;

use crate::common::{PATIENT, json, root, text};

/// More settings of the table `control`, and the thrust model, for the peer's vehicle: its root of thrust follows 7.4 times
/// the motors' signal with a lag of 0.05 s.
const SETTINGS: &str = r#"
terminal_s = 3.0
watch_s = 2.0
[control.lander]
imu_age_s = 0.3
[models.thrust.library]
one = 0.0
x = -20.0
s = 148.0
s2 = 0.0
x3 = 0.0
s3 = 0.0
exp_neg_x_s = 0.0
sin_x_s = 0.0
"#;

/// A thrust card of the user's own: motors a little stronger than those of the peer's vehicle.
pub(super) const CARD: &str = r#"
schema = 1
name = "own"
kind = "thrust"
form = "library"
status = "fitted"
equation = "x' = 20 (7.6 s - x), x = √T [√N], s throttle in [0, 1]"
description = "Motors a little stronger than those of the peer's vehicle."
warnings = []
[vehicle]
name = "peer"
mass_kg = 1.37
[validity]
outside = "clamp"
[validity.inputs]
s = [0.05, 0.95]
x = [0.3, 7.2]
[provenance]
source = "a test"
inputs = []
[[terms]]
of = "x'"
expression = "x"
value = -20.0
unit = "1/s"
[[terms]]
of = "x'"
expression = "s"
value = 152.0
unit = "√N/s"
"#;

/// A flight against the peer.
#[derive(Clone, Copy, Default)]
pub(super) struct Case<'a> {
    /// Arguments of the peer.
    pub(super) peer: &'a [&'a str],
    /// Arguments of `fly`.
    pub(super) ours: &'a [&'a str],
    /// Lines of settings before the tables.
    pub(super) first: &'a str,
    /// Tables of settings.
    pub(super) tables: &'a str,
    /// Most bytes of the recording, in units of 1024.
    pub(super) disk: Option<u32>,
    /// Whether the command is started with ignored interrupts, as a job in the background of a script is.
    pub(super) ignores_interrupts: bool,
    /// Whether our standard error stops to take anything after its first line, as a stopped terminal does.
    pub(super) unread: bool,
    /// Gets every line of our standard error as it comes.
    pub(super) lines: Option<&'a mpsc::Sender<String>>,
}

/// What came of a flight: our exit status, the objects that both printed last, and what we said.
pub(super) struct Flown {
    pub(super) status: Option<i32>,
    pub(super) ours: Value,
    pub(super) theirs: Value,
    pub(super) said: String,
    pub(super) objects: usize,
}

/// Flights at once: each is three busy processes, and machines have two cores.
const AT_ONCE: u32 = 2;

static FLYING: (Mutex<u32>, Condvar) = (Mutex::new(0), Condvar::new());

/// Longest time in which the peer may have been stopped by the machine, s; after 0.8 s `fly` rightly calls it silent.
const STOPPED_MAX_S: f64 = 0.3;

/// Flights at most until one in which the machine did not stop the peer.
const FLIGHTS_MAX: u32 = 4;

/// A flight's permission to begin.
struct Permission;

impl Permission {
    fn wait() -> Self {
        let count = FLYING.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut count = FLYING
            .1
            .wait_while(count, |count| *count >= AT_ONCE)
            .unwrap_or_else(PoisonError::into_inner);
        *count += 1;
        Self
    }
}

impl Drop for Permission {
    fn drop(&mut self) {
        *FLYING.0.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
        FLYING.1.notify_one();
    }
}

impl Case<'_> {
    /// Our side and the peer's, until both have ended. A flight in which a loaded machine stopped the peer is flown again.
    pub(super) fn fly(&self, python: &Path, folder: &Path) -> Flown {
        for _ in 1..FLIGHTS_MAX {
            let flown = self.fly_once(python, folder);
            let stopped = flown.theirs("stopped_s") > STOPPED_MAX_S;
            // Whoever reads our lines as they come reads those of one flight.
            if !stopped || self.lines.is_some() {
                return flown;
            }
            let _ = std::fs::remove_file(folder.join("flight.mcap"));
        }
        self.fly_once(python, folder)
    }

    fn fly_once(&self, python: &Path, folder: &Path) -> Flown {
        let _permission = Permission::wait();
        let over_udp = !self.peer.contains(&"--link");
        let mut theirs = Command::new(python);
        theirs.arg(root().join("crates/touchdown/tests/peer/autopilot.py"));
        theirs.args(self.peer);
        if over_udp {
            // Closed again at the end of the statement, so that ours can have the port.
            let free = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
            let port = free.unwrap().port();
            let link = format!("link = \"udpin:127.0.0.1:{port}\"\n");
            let ours = self.start(folder, &link);
            theirs.args(["--port", &port.to_string(), "--pid", &ours.id().to_string()]);
            let theirs = started(&mut theirs);
            return self.ended(ours, theirs, "");
        }
        let mut theirs = started(&mut theirs);
        let mut address = String::new();
        let mut lines = BufReader::new(theirs.stdout.take().unwrap());
        lines.read_line(&mut address).unwrap();
        let address: Value = serde_json::from_str(&address).unwrap();
        let ours = self.start(folder, &format!("link = {}\n", address["address"]));
        let mut rest = String::new();
        lines.read_to_string(&mut rest).unwrap();
        self.ended(ours, theirs, &rest)
    }

    fn start(&self, folder: &Path, link: &str) -> Child {
        let file = folder.join("flight.toml");
        let content = format!("{link}{}{PATIENT}{SETTINGS}{}", self.first, self.tables);
        std::fs::write(&file, content).unwrap();
        let command = env!("CARGO_BIN_EXE_touchdown");
        let before = match (self.disk, self.ignores_interrupts) {
            (None, false) => None,
            (Some(kib), _) => Some(format!("ulimit -f {kib}; trap '' XFSZ")),
            (None, true) => Some("trap '' INT".to_string()),
        };
        let mut ours = match before {
            None => Command::new(command),
            Some(before) => {
                let mut shell = Command::new("bash");
                shell.args(["-c", &format!("{before}; exec \"$@\""), "bash", command]);
                shell
            }
        };
        ours.args(["--json", "fly"]).arg(&file).args(self.ours);
        ours.arg("--out").arg(folder.join("flight.mcap"));
        if self.unread {
            return ours
                .stdout(Stdio::piped())
                .stderr(stopped_terminal())
                .spawn()
                .unwrap();
        }
        let mut ours = started(&mut ours);
        if let Some(lines) = self.lines {
            let (lines, printed) = (lines.clone(), ours.stderr.take().unwrap());
            std::thread::spawn(move || {
                for line in BufReader::new(printed).lines().map_while(Result::ok) {
                    // Nobody listens any more when the flight is over.
                    let _ = lines.send(line);
                }
            });
        }
        ours
    }

    fn ended(&self, ours: Child, theirs: Child, printed: &str) -> Flown {
        let theirs = theirs.wait_with_output().unwrap();
        assert!(theirs.status.success(), "{}", text(&theirs.stderr));
        let ours = output(ours);
        let (out, said) = (text(&ours.stdout), text(&ours.stderr));
        // Objects of the flight's progress come before the last line.
        let last = |text: &str| -> Value {
            let line = text.lines().last().unwrap_or_default();
            serde_json::from_str(line).unwrap_or(Value::Null)
        };
        Flown {
            status: ours.status.code(),
            ours: last(&out),
            theirs: last(&(text(&theirs.stdout) + printed)),
            said,
            objects: out.lines().count(),
        }
    }
}

impl Flown {
    pub(super) fn ending(&self) -> &Value {
        &self.ours["flight"]["ending"]
    }

    pub(super) fn theirs(&self, key: &str) -> f64 {
        self.theirs[key].as_f64().unwrap_or(f64::NAN)
    }

    /// For a failed assertion.
    pub(super) fn told(&self) -> String {
        format!("{:?}\n{}\n{:#}", self.status, self.said, self.theirs)
    }

    pub(super) fn landed(&self) {
        assert_eq!(self.ending(), "landed", "{}", self.told());
        assert_eq!(self.status, Some(0));
        assert_eq!(self.theirs["armed"], false);
        // Twice what the deck itself moves at: a touchdown, not a fall.
        assert!(self.theirs("touch_mps") < 0.3, "{}", self.told());
        assert!(self.theirs("offset_m") < 0.3, "{}", self.told());
    }
}

/// Time that a companion whose vehicle did not land gets before it is killed.
pub(super) const PATIENCE: Duration = Duration::from_secs(30);

/// What a process printed until its end.
pub(super) fn output(child: Child) -> Output {
    let pid = child.id().to_string();
    let (sender, ended) = mpsc::channel();
    std::thread::spawn(move || sender.send(child.wait_with_output().unwrap()));
    ended.recv_timeout(PATIENCE).unwrap_or_else(|_| {
        Command::new("kill").args(["-KILL", &pid]).status().unwrap();
        ended.recv().unwrap()
    })
}

/// The end of a pipe from which nobody reads after the first line, and which is full then.
fn stopped_terminal() -> PipeWriter {
    let (reader, mut writer) = pipe().unwrap();
    let end = writer.try_clone().unwrap();
    std::thread::spawn(move || {
        let mut reader = BufReader::new(reader);
        let _ = reader.read_line(&mut String::new());
        // More than any pipe holds: this waits for a reader until the end of the tests, for the reader is its own.
        let _ = writer.write_all(&[b' '; 1 << 22]);
        drop(reader);
    });
    end
}

pub(super) fn started(command: &mut Command) -> Child {
    let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    piped.spawn().unwrap()
}

pub(super) fn replay(folder: &Path) -> Value {
    let recording = folder.join("flight.mcap");
    json(
        0,
        ["fly".into(), "--replay".into(), recording.into_os_string()],
    )
}
