//! The clocks of a recording: those of the recorder, of message headers and of an autopilot.

use crate::topics::sink::{Loss, Sink};

/// Largest difference between a header's stamp and the recorder's for the header's stamp to be used,
/// ns. An autopilot's clock that changes by more has been restarted.
const PLAUSIBLE_NS: i64 = 10_000_000_000;

/// Most restarts of an autopilot's clock that are followed. After them the recorder's stamps are used: a
/// clock that never settles, or two autopilots in turn, would cost time for each message. A flight has none.
const MOST_RESTARTS: usize = 1000;

/// Stamps of messages in ns since the first message that was recorded.
#[derive(Debug, Default)]
pub(super) struct Clocks {
    zero_ns: Option<u64>,
    own: Option<AutopilotClock>,
    /// Topics that are stamped by the autopilot's clock, and whether each topic is one.
    owned: Vec<usize>,
    is_owned: Vec<bool>,
    /// Number of restarts of that clock.
    restarts: usize,
}

/// Difference of the recorder's clock to the autopilot's since its last restart, ns: at the first
/// message, and the smallest so far.
#[derive(Debug, Clone, Copy)]
struct AutopilotClock {
    first_ns: i64,
    least_ns: i64,
}

impl Clocks {
    /// The stamp of the recorder's clock.
    pub(super) fn recorded(&mut self, recorded_ns: u64) -> i64 {
        let zero_ns = *self.zero_ns.get_or_insert(recorded_ns);
        recorded_ns.wrapping_sub(zero_ns).cast_signed()
    }

    /// The stamp in a header, if it has the same zero as the recorder's clock, or else the recorder's.
    pub(super) fn header(&mut self, recorded_ns: u64, header_ns: u64) -> i64 {
        let recorded = self.recorded(recorded_ns);
        let header = self.recorded(header_ns);
        if header.saturating_sub(recorded).saturating_abs() < PLAUSIBLE_NS {
            header
        } else {
            recorded
        }
    }

    /// The stamp of an autopilot's clock, which counts from the autopilot's start. The message with the
    /// least delay aligns this clock with the recorder's. After a restart, the messages before it are
    /// aligned first.
    pub(super) fn own(
        &mut self,
        id: usize,
        recorded_ns: u64,
        own_ns: u64,
        sink: &mut dyn Sink,
    ) -> i64 {
        let recorded = self.recorded(recorded_ns);
        let Ok(own_ns) = i64::try_from(own_ns) else {
            return recorded;
        };
        if own_ns == 0 || self.restarts == MOST_RESTARTS {
            return recorded;
        }
        let beyond_ns = recorded.saturating_sub(own_ns);
        let is_anew = |own: &AutopilotClock| {
            beyond_ns.saturating_sub(own.first_ns).saturating_abs() > PLAUSIBLE_NS
        };
        if self.own.as_ref().is_some_and(is_anew) {
            self.settle(sink);
            self.own = None;
            self.restarts += 1;
        }
        let own = self.own.get_or_insert(AutopilotClock {
            first_ns: beyond_ns,
            least_ns: beyond_ns,
        });
        own.least_ns = own.least_ns.min(beyond_ns);
        if self.is_owned.len() <= id {
            self.is_owned.resize(id + 1, false);
        }
        if !std::mem::replace(&mut self.is_owned[id], true) {
            self.owned.push(id);
        }
        own_ns.saturating_add(own.first_ns)
    }

    /// Shifts the messages with stamps of the autopilot's clock since its last restart, by the least
    /// delay.
    fn settle(&self, sink: &mut dyn Sink) {
        if let Some(own) = self.own {
            sink.shift(&self.owned, own.least_ns.saturating_sub(own.first_ns));
        }
    }

    /// Aligns the remaining messages, and reports the alignment.
    pub(super) fn finish(&self, sink: &mut dyn Sink, loss: &mut Loss) {
        if self.own.is_none() {
            return;
        }
        self.settle(sink);
        let anew = match self.restarts {
            0 => String::new(),
            1 => ", again after its restart".to_owned(),
            restarts => format!(", again after each of its {restarts} restarts"),
        };
        loss.notes.push(format!(
            "{} topics are stamped by the autopilot's own clock; it was aligned with the recorder's clock by the message with the least delay{anew}",
            self.owned.len()
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topics::sink::{Layout, Wanted};

    struct Shifts(Vec<(usize, i64)>);

    impl Sink for Shifts {
        fn topic(&mut self, _: usize, _: &Layout) -> Wanted {
            Wanted::Stamps
        }
        fn message(&mut self, _: usize, _: Option<i64>, _: &[f64]) {}
        fn shift(&mut self, ids: &[usize], by_ns: i64) {
            self.0.extend(ids.iter().map(|&id| (id, by_ns)));
        }
        fn parameter(&mut self, _: &str, _: f64) {}
    }

    #[test]
    fn analytic_the_least_delay_tells_where_a_clock_lies() {
        let mut clocks = Clocks::default();
        let (mut shifts, mut loss) = (Shifts(Vec::new()), Loss::default());
        let epoch = 1_700_000_000_000_000_000;
        assert_eq!(clocks.recorded(epoch), 0);
        // Sampled at 5.00 s, 5.01 s, 5.02 s of the autopilot; 30 ms, 2 ms and 9 ms late.
        let stamps: Vec<i64> = [(30, 0), (12, 10), (29, 20)]
            .map(|(at, since)| {
                let own_ns = 5_000_000_000 + since * 1_000_000;
                clocks.own(7, epoch + at * 1_000_000, own_ns, &mut shifts)
            })
            .into();
        assert_eq!(stamps, [30_000_000, 40_000_000, 50_000_000]);
        assert_eq!(shifts.0, []);
        // Started anew: the clock begins again, time does not. The second comes 3 ms quicker.
        let stamps: Vec<i64> = [(60_000, 1), (60_007, 11)]
            .map(|(at, own)| clocks.own(7, epoch + at * 1_000_000, own * 1_000_000, &mut shifts))
            .into();
        assert_eq!(stamps, [60_000_000_000, 60_010_000_000]);
        // By then what came before is settled, and in the end what came after.
        assert_eq!(shifts.0, [(7, -28_000_000)]);
        clocks.finish(&mut shifts, &mut loss);
        assert_eq!(shifts.0, [(7, -28_000_000), (7, -3_000_000)]);
        assert!(loss.notes[0].ends_with("least delay, again after its restart"));
        // No stamp, and one out of this world.
        assert_eq!(clocks.own(7, epoch + 1000, 0, &mut shifts), 1000);
        assert_eq!(clocks.own(7, epoch + 1000, u64::MAX, &mut shifts), 1000);
        assert_eq!(clocks.header(epoch + 1000, epoch + 900), 900);
        assert_eq!(clocks.header(epoch + 1000, 900), 1000);
    }
}
