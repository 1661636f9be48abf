//! Times of the camera's threads, in the companion's clock.

use std::time::Instant;

/// Moves times of this computer's clocks to the companion's.
#[derive(Clone, Copy)]
pub(super) struct CameraClock {
    start: Instant,
    /// `CLOCK_MONOTONIC` at the companion's time zero, µs; none on systems without it.
    monotonic_us: Option<i64>,
}

impl CameraClock {
    /// The clock of a companion that started at `start`.
    pub(super) fn since(start: Instant) -> Self {
        let mut clock = Self {
            start,
            monotonic_us: None,
        };
        clock.monotonic_us = monotonic_us().map(|now_us| now_us - clock.now_us());
        clock
    }

    /// Time now, µs.
    pub(super) fn now_us(&self) -> i64 {
        self.of(Instant::now())
    }

    fn of(&self, at: Instant) -> i64 {
        i64::try_from(at.saturating_duration_since(self.start).as_micros()).unwrap_or(i64::MAX)
    }

    /// The companion's time of a stamp of `CLOCK_MONOTONIC`, µs.
    pub(super) fn of_monotonic(&self, stamp_us: i64) -> Option<i64> {
        Some(stamp_us - self.monotonic_us?)
    }
}

#[cfg(unix)]
fn monotonic_us() -> Option<i64> {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    Some(now.tv_sec * 1_000_000 + now.tv_nsec / 1000)
}

#[cfg(not(unix))]
fn monotonic_us() -> Option<i64> {
    None
}
