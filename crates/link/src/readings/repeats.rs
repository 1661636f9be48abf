//! Ranges that an autopilot sends more often than it reads its range finder.

use crate::autopilot::Autopilot;

/// Time between two readings of ArduCopter's range finder, µs: the 20 Hz of `read_rangefinder` in its table of tasks. Half of
/// it takes repeats for readings; with twice of it, every other reading of a hover is dropped.
const ARDUPILOT_RANGE_US: i64 = 50_000;

/// Ranges that an autopilot sends again without a new reading.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RangeRepeats {
    /// Time between two readings of the range finder, µs; 0 if every message has its own.
    period_us: i64,
    /// The last reading, cm, and its stamp, µs.
    last: Option<(u16, i64)>,
}

impl RangeRepeats {
    /// Those of an autopilot.
    pub(super) fn of(autopilot: Autopilot) -> Self {
        Self {
            period_us: match autopilot {
                Autopilot::Px4 => 0,
                Autopilot::ArduPilot => ARDUPILOT_RANGE_US,
            },
            last: None,
        }
    }

    /// Forgets the last reading.
    pub(super) fn forget(&mut self) {
        self.last = None;
    }

    /// Whether a range repeats the last reading. An equal one after the period is a reading of its own.
    pub(super) fn is_repeat(&mut self, centimetres: u16, stamp_us: i64) -> bool {
        let repeats = self.last.is_some_and(|(last, at)| {
            last == centimetres && (0..self.period_us).contains(&stamp_us.saturating_sub(at))
        });
        if !repeats {
            self.last = Some((centimetres, stamp_us));
        }
        repeats
    }
}
