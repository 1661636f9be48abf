//! Long calls: without the interpreter's lock, with Ctrl-C, with a number of threads.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use sindy::SindyError;

use crate::error;

/// Time between two looks at Python's signals: a Ctrl-C is heard well within the 0.2 s that people take for at once, and
/// twenty looks a second cost nothing.
const LOOK: Duration = Duration::from_millis(50);

/// Whether the caller wants the call to end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cancel(Arc<AtomicBool>);

/// What a call that was cancelled unwinds with, so that no stack frame between has to know of it.
struct Cancelled;

impl Cancel {
    /// Whether the call is to end.
    pub(crate) fn asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Ends the call from within, if it is to end.
    pub(crate) fn heed(&self) {
        if self.asked() {
            resume_unwind(Box::new(Cancelled));
        }
    }
}

/// How a call ended.
type Ended<T> = thread::Result<Result<T, SindyError>>;

/// Runs `work` on a thread of its own, in a pool of `jobs` threads if a number is given, and waits for it with the
/// interpreter's lock released. After a Ctrl-C it returns at once, and the work ends where it next heeds `Cancel`.
pub(crate) fn owned<T: Send + 'static>(
    py: Python<'_>,
    jobs: Option<usize>,
    work: impl FnOnce(&Cancel) -> Result<T, SindyError> + Send + 'static,
) -> PyResult<T> {
    watched(py, jobs, |_| Ok(()), work)
}

/// As [`owned`], with a look of the caller's own at every look at Python's signals. An error of it ends the call as a
/// Ctrl-C does.
pub(crate) fn watched<T: Send + 'static>(
    py: Python<'_>,
    jobs: Option<usize>,
    look: impl FnMut(Python<'_>) -> PyResult<()>,
    work: impl FnOnce(&Cancel) -> Result<T, SindyError> + Send + 'static,
) -> PyResult<T> {
    let cancel = Cancel::default();
    let (send, receive) = channel();
    let inside = cancel.clone();
    thread::spawn(move || {
        // Nobody listens any more after a Ctrl-C.
        let _ = send.send(guarded(jobs, || work(&inside)));
    });
    wait(py, receive, &cancel, look)
}

/// As [`owned`], for work that borrows: after a Ctrl-C it waits until the work heeds `Cancel`.
pub(crate) fn borrowed<T: Send>(
    py: Python<'_>,
    jobs: Option<usize>,
    work: impl FnOnce(&Cancel) -> Result<T, SindyError> + Send,
) -> PyResult<T> {
    let cancel = Cancel::default();
    let (send, receive) = channel();
    let inside = cancel.clone();
    thread::scope(|scope| {
        scope.spawn(move || {
            let _ = send.send(guarded(jobs, || work(&inside)));
        });
        wait(py, receive, &cancel, |_| Ok(()))
    })
}

/// Runs a short call in place, with the interpreter's lock released.
pub(crate) fn short<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, SindyError> + Send,
) -> PyResult<T> {
    ended(py.detach(|| catch_unwind(AssertUnwindSafe(work))))
}

fn guarded<T: Send>(
    jobs: Option<usize>,
    work: impl FnOnce() -> Result<T, SindyError> + Send,
) -> Ended<T> {
    catch_unwind(AssertUnwindSafe(|| {
        let Some(jobs) = jobs else {
            return work();
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
        match pool {
            Ok(pool) => pool.install(work),
            Err(e) => Err(SindyError::Setting {
                key: "n_jobs",
                expected: "a number of threads that the machine can start".to_owned(),
                found: format!("{jobs} ({e})"),
            }),
        }
    }))
}

fn wait<T: Send>(
    py: Python<'_>,
    mut receive: Receiver<Ended<T>>,
    cancel: &Cancel,
    mut look: impl FnMut(Python<'_>) -> PyResult<()>,
) -> PyResult<T> {
    loop {
        let (back, got) = py.detach(move || {
            let got = receive.recv_timeout(LOOK);
            (receive, got)
        });
        receive = back;
        match got {
            Ok(found) => return ended(found),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(interrupt) = py.check_signals().and_then(|()| look(py)) {
                    cancel.0.store(true, Ordering::Relaxed);
                    return Err(interrupt);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(error::panic(&"its thread ended without a result"));
            }
        }
    }
}

fn ended<T>(found: Ended<T>) -> PyResult<T> {
    match found {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(fault)) => Err(error::of(&fault)),
        Err(payload) => Err(error::panic(payload.as_ref())),
    }
}
