//! Values that do not change any more, under stamps that do: of a sensor or a program that hangs, while another one goes on sending.
//!
//! Noise moves the last digits of every reading, so values that stay the same to the bit are those of one reading. Ranges in whole
//! centimetres and specific forces in thousandths of g may well stay the same in a steady hover, so they count as frozen only where
//! another sensor shows a motion: the position of the deck, or the velocity. Nobody can tell a deck that reports the same place again
//! and again from one that rests.

/// Time for which the same values may come, µs. Half of it is one period of a source at 10 Hz; twice of it lengthens the flight on an
/// inertial unit that hangs by 0.2 s.
const SAME_US: i64 = 200_000;
/// Readings with the same values, at least: of a source at 10 Hz, two may be alike.
const SAME_COUNT: u32 = 3;
/// Change of the distance to the deck with which a range cannot stay the same, m: ten steps of the sensor.
pub(super) const MOVED_M: f64 = 0.1;
/// Change of the vertical velocity with which a specific force cannot stay the same, m/s: a force that is off by a hundredth of g
/// takes two seconds to it.
pub(super) const CHANGED_MPS: f64 = 0.2;
/// Standard deviations of what another sensor shows that come on top, two for its least and two for its greatest value.
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

/// Coarse values that came again and again, and what another sensor has shown since their first time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SameBeside {
    values: [f64; 4],
    shown: Option<[f64; 2]>,
    sd: f64,
}

impl SameBeside {
    /// The other sensor shows a value with this standard deviation.
    pub(super) fn shows(&mut self, value: f64, sd: f64) {
        let [least, greatest] = self.shown.unwrap_or([value; 2]);
        self.shown = Some([least.min(value), greatest.max(value)]);
        self.sd = self.sd.max(sd);
    }

    /// Whether the values of a reading, the newest one, stay the same while the other sensor shows a change beyond `most`.
    pub(super) fn lasts(&mut self, values: [f64; 4], most: f64) -> bool {
        if self.values != values {
            *self = Self {
                values,
                ..Self::default()
            };
        }
        self.shown
            .is_some_and(|[least, greatest]| greatest - least > most + DEVIATIONS * self.sd)
    }
}
