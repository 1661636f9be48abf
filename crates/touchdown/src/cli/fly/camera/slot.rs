//! The newest frame, between the camera's two threads.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use touchdown_link::camera::Frame;

/// A frame that has arrived.
#[derive(Clone, Debug, Default)]
pub(super) struct Arrived {
    pub(super) frame: Frame,
    /// When it was whole, µs of the companion's clock.
    pub(super) at_us: i64,
    /// Frames before it that nobody took.
    pub(super) dropped: u64,
    /// Images before it that could not be read.
    pub(super) unreadable: u64,
}

#[derive(Default)]
struct State {
    newest: Option<(Frame, i64)>,
    dropped: u64,
    unreadable: u64,
    ended: Option<String>,
}

/// Holds the newest frame only.
#[derive(Default)]
pub(super) struct Slot {
    state: Mutex<State>,
    news: Condvar,
}

impl Slot {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the frame, which is then the newest.
    pub(super) fn put(&self, frame: Frame, at_us: i64) {
        let mut state = self.state();
        state.dropped += u64::from(state.newest.is_some());
        state.newest = Some((frame, at_us));
        self.news.notify_one();
    }

    /// Counts an image that could not be read.
    pub(super) fn count_unreadable(&self) {
        self.state().unreadable += 1;
    }

    /// No frame will come any more. The first reason stays.
    pub(super) fn end(&self, why: &str) {
        self.state().ended.get_or_insert_with(|| why.to_string());
        self.news.notify_one();
    }

    /// Waits for a frame; an error says why none will come any more.
    pub(super) fn take(&self) -> Result<Arrived, String> {
        let mut state = self.state();
        loop {
            if let Some((frame, at_us)) = state.newest.take() {
                return Ok(Arrived {
                    frame,
                    at_us,
                    dropped: state.dropped,
                    unreadable: state.unreadable,
                });
            }
            if let Some(why) = &state.ended {
                return Err(why.clone());
            }
            state = self
                .news
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(k: u8) -> Frame {
        Frame {
            pixels: vec![k],
            size_px: [1, 1],
            stamp_us: None,
        }
    }

    #[test]
    fn prop_the_newest_frame_is_taken_and_older_ones_are_counted() {
        let slot = Slot::default();
        for k in 0..4 {
            slot.put(frame(k), i64::from(k));
        }
        slot.count_unreadable();
        let taken = slot.take().unwrap();
        assert_eq!((taken.frame, taken.at_us), (frame(3), 3));
        assert_eq!((taken.dropped, taken.unreadable), (3, 1));
        slot.put(frame(4), 4);
        slot.end("unplugged");
        slot.end("later");
        // What came before the end is still looked at.
        assert_eq!(slot.take().unwrap().dropped, 3);
        assert_eq!(slot.take().unwrap_err(), "unplugged");
    }
}
