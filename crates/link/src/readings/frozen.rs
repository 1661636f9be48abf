//! Values that do not change any more, under stamps that do: of a sensor or a program that hangs, while another one goes on sending.
//!
//! Noise moves the last digits of every reading, so values that stay the same to the bit are those of one reading. A range comes in
//! whole centimetres and may well stay the same in a steady hover, so it counts as frozen only where the position of the deck shows
//! another distance. Nobody can tell a deck that reports the same place again and again from one that rests.

/// Time for which the same values may come, µs. Half of it is two frames of a slow camera; twice of it is a third of a second's fall.
const SAME_US: i64 = 200_000;
/// Readings with the same values, at least: of a source at 10 Hz, two may be alike.
const SAME_COUNT: u32 = 3;
/// Change of the distance to the deck with which a range cannot stay the same, m: ten steps of the sensor; and the standard
/// deviations of the position that come on top, two for the least and two for the greatest distance.
const MOVED_M: f64 = 0.1;
const DEVIATIONS: f64 = 4.0;

/// Values of a source that came again and again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Same {
    values: [f64; 4],
    since_us: i64,
    count: u32,
}

impl Same {
    /// Whether the values of a reading, the newest one, have come for too long.
    pub(super) fn lasts(&mut self, values: [f64; 4], at_us: i64) -> bool {
        if self.count == 0 || self.values != values {
            *self = Self {
                values,
                since_us: at_us,
                count: 0,
            };
        }
        self.count = self.count.saturating_add(1);
        self.count >= SAME_COUNT && at_us.saturating_sub(self.since_us) >= SAME_US
    }
}

/// A range that came again and again, and the distances of the deck since its first time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SameRange {
    range_m: f64,
    distance_m: Option<[f64; 2]>,
    sd_m: f64,
}

impl SameRange {
    /// The deck's position shows this distance along the vertical, with this standard deviation.
    pub(super) fn sees(&mut self, distance_m: f64, sd_m: f64) {
        let [least, greatest] = self.distance_m.unwrap_or([distance_m; 2]);
        self.distance_m = Some([least.min(distance_m), greatest.max(distance_m)]);
        self.sd_m = self.sd_m.max(sd_m);
    }

    /// Whether a range, the newest one, stays the same while the distance has changed.
    pub(super) fn lasts(&mut self, range_m: f64) -> bool {
        if self.range_m != range_m {
            *self = Self {
                range_m,
                ..Self::default()
            };
        }
        self.distance_m
            .is_some_and(|[least, greatest]| greatest - least > MOVED_M + DEVIATIONS * self.sd_m)
    }
}
