//! The autopilots that run side by side: their instance numbers and ports, and their common end at Ctrl-C.

use std::collections::BTreeMap;
use std::net::{TcpListener, UdpSocket};
use std::ops::Range;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use touchdown::{Error, Result};
use touchdown_link::LinkError;
use touchdown_link::simulator::px4;

use super::process::{AutopilotProcess, Launch};

/// Instance numbers of PX4 whose MAVLink ports differ.
pub(crate) const PX4_INSTANCES: Range<u16> = 0..10;
/// Instance numbers of ArduPilot, each with its own system id.
const ARDUPILOT_INSTANCES: Range<u16> = 0..200;
/// PX4's own UDP ports, and the one to which it sends, of instance 0.
const PX4_OWN: [u16; 2] = [14_580, 18_570];
const PX4_MAVLINK: u16 = 14_540;

/// The instances that are in use, with the process of each once it runs.
#[derive(Default)]
struct Used {
    instances: BTreeMap<u16, Option<AutopilotProcess>>,
    interrupted: bool,
}

/// All autopilots of this command. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct Autopilots {
    used: Arc<Mutex<Used>>,
    freed: Arc<Condvar>,
}

/// An instance number in use, and the process that runs as it. Its end stops the process and frees the number.
pub(super) struct Instance {
    pub(super) number: u16,
    autopilots: Autopilots,
    process: Option<AutopilotProcess>,
}

/// The ports of a PX4, which are held open.
pub(super) struct Px4Ports {
    pub(super) simulator: TcpListener,
    pub(super) mavlink: UdpSocket,
}

impl Autopilots {
    /// The first PX4 instance whose ports are free. Where all are in use by this command, waits for one.
    pub(super) fn px4(&self) -> Result<(Instance, Px4Ports)> {
        self.reserve(PX4_INSTANCES, |i| {
            let own = PX4_OWN.into_iter().all(|port| udp_is_free(port + i));
            let mavlink = mavlink_port(PX4_MAVLINK + i).ok().filter(|_| own)?;
            let simulator = px4::listen(i).ok()?;
            Some(Px4Ports { simulator, mavlink })
        })
    }

    /// An instance of ArduPilot, whose ports are any free ones.
    pub(super) fn ardupilot(&self) -> Result<Instance> {
        Ok(self.reserve(ARDUPILOT_INSTANCES, |_| Some(()))?.0)
    }

    fn reserve<T>(
        &self,
        numbers: Range<u16>,
        open: impl Fn(u16) -> Option<T>,
    ) -> Result<(Instance, T)> {
        let mut used = self.lock();
        loop {
            let free = |i: &u16| !used.instances.contains_key(i);
            let opened = numbers
                .clone()
                .filter(free)
                .find_map(|i| Some((i, open(i)?)));
            if let Some((number, opened)) = opened {
                used.instances.insert(number, None);
                let instance = Instance {
                    number,
                    autopilots: self.clone(),
                    process: None,
                };
                return Ok((instance, opened));
            }
            if used.instances.is_empty() {
                return Err(Error::Arguments(
                    "no free PX4 instance: the ports 4560, 14540, 14580 and 18570 plus 0 to 9 are taken".to_string(),
                ));
            }
            used = self
                .freed
                .wait(used)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Stops all of them because of Ctrl-C, whose handler ends this command then. None is started from now on.
    pub(crate) fn interrupt(&self) {
        let mut used = self.lock();
        used.interrupted = true;
        for process in used.instances.values().flatten() {
            process.stop();
        }
    }

    /// After Ctrl-C, waits for the end of this command: the autopilot's end is no error to report.
    pub(super) fn wait_if_interrupted(&self) {
        drop(self.lock_unless_interrupted());
    }

    fn lock_unless_interrupted(&self) -> MutexGuard<'_, Used> {
        loop {
            let used = self.lock();
            if !used.interrupted {
                return used;
            }
            drop(used);
            std::thread::park();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Used> {
        self.used.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Instance {
    /// Starts the autopilot.
    pub(super) fn start(&mut self, launch: Launch) -> Result<()> {
        // Ctrl-C waits for this lock, so that it finds every process that runs.
        let mut used = self.autopilots.lock_unless_interrupted();
        let process = AutopilotProcess::start(launch)?;
        used.instances.insert(self.number, Some(process.clone()));
        self.process = Some(process);
        Ok(())
    }

    /// The process, once it is started.
    pub(super) fn process(&self) -> Option<&AutopilotProcess> {
        self.process.as_ref()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some(process) = &self.process {
            process.stop();
        }
        self.autopilots.lock().instances.remove(&self.number);
        self.autopilots.freed.notify_all();
    }
}

/// Opens the port to which the autopilot sends MAVLink; 0 for a free one.
pub(super) fn mavlink_port(port: u16) -> Result<UdpSocket> {
    let opened = UdpSocket::bind(("127.0.0.1", port)).and_then(|socket| {
        socket.set_nonblocking(true)?;
        Ok(socket)
    });
    opened.map_err(|source| {
        LinkError::Link {
            address: format!("udp port {port}"),
            source,
        }
        .into()
    })
}

/// Whether nobody has a UDP port of this machine.
fn udp_is_free(port: u16) -> bool {
    UdpSocket::bind(("127.0.0.1", port)).is_ok()
}

/// The number of a free UDP port.
pub(super) fn free_udp() -> Result<u16> {
    let free = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
    free.map(|address| address.port())
        .map_err(|e| Error::Arguments(format!("no free UDP port: {e}")))
}
