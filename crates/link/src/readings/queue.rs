//! Readings on their way to the next step: judged by their stamps and values, then queued.

use touchdown_flight::Vector;
use touchdown_lander::estimate::relative::Reading;

use super::frozen::{CHANGED_MPS, MOVED_M};
use super::{FUTURE_US, Inbox, MOST_PENDING, Source};
use crate::clock::ClockSync;

impl Inbox {
    /// Whether values that stay the same count as frozen.
    pub(super) fn is_frozen(&mut self, lasts: impl FnOnce(&mut Self) -> bool) -> bool {
        let frozen = self.armed && lasts(self);
        self.ignored.frozen += u64::from(frozen);
        frozen
    }

    pub(super) fn is_source_frozen(&mut self, source: Source, values: [f64; 4], at: i64) -> bool {
        self.is_frozen(|inbox| match source {
            Source::Range => inbox.same_range.lasts(values, MOVED_M),
            Source::Imu if inbox.coarse_force => inbox.same_force.lasts(values, CHANGED_MPS),
            _ => inbox.same[source as usize].lasts(values, at),
        })
    }

    /// Our time of a stamp that is neither too old nor in the future, newer than the last one of its source, and of values that are
    /// not frozen.
    pub(super) fn dated(
        &mut self,
        source: Source,
        values: [f64; 4],
        stamp_us: i64,
        clock: &ClockSync,
        now_us: i64,
    ) -> Option<i64> {
        let Some(at) = clock.ours_us(stamp_us) else {
            self.ignored.unsynchronised += 1;
            return None;
        };
        let age = now_us.saturating_sub(at);
        if age > self.greatest_age_us {
            self.ignored.too_old += 1;
            return None;
        }
        if age < -FUTURE_US {
            self.ignored.from_the_future += 1;
            return None;
        }
        let index = source as usize;
        if self.stamps_us[index].is_some_and(|newest| stamp_us <= newest) {
            self.ignored.repeated += 1;
            return None;
        }
        self.stamps_us[index] = Some(stamp_us);
        if self.is_source_frozen(source, values, at) {
            return None;
        }
        self.arrivals[index] += 1;
        self.newest_us[index] = Some(at);
        Some(at)
    }

    pub(super) fn queue(
        &mut self,
        source: Source,
        reading: Reading<f64>,
        usable: bool,
        stamp_us: i64,
        clock: &ClockSync,
        now_us: i64,
    ) {
        if !usable || !reading.is_finite() {
            self.ignored.unusable += 1;
        } else if let Some(at) = self.dated(source, values(&reading), stamp_us, clock, now_us) {
            let latency_us = match source {
                Source::Range => self.range_latency_us,
                _ => 0,
            };
            self.push(source, reading, at - latency_us);
        }
    }

    /// Queues a reading that has no stamp; returns whether it is one.
    pub(super) fn queue_at(&mut self, source: Source, reading: Reading<f64>, at: i64) -> bool {
        if !reading.is_finite() {
            self.ignored.unusable += 1;
            return false;
        }
        if self.is_source_frozen(source, values(&reading), at) {
            return false;
        }
        self.arrivals[source as usize] += 1;
        self.newest_us[source as usize] = Some(at);
        self.push(source, reading, at);
        true
    }

    pub(super) fn push(&mut self, source: Source, reading: Reading<f64>, at: i64) {
        if source == Source::Velocity {
            let last = self.velocity_us;
            if last.is_some_and(|last| at - last < self.velocity_period_us) {
                return;
            }
            self.velocity_us = Some(at);
        }
        if let (Reading::Tag(tag), Some((_, attitude))) = (&reading, self.attitude) {
            let down_m = -attitude.rotate(tag.position_m).z;
            let variance_m2 = tag.covariance_m2[2][2];
            self.same_range.shows(down_m, variance_m2.max(0.0).sqrt());
        }
        if self.pending.len() < MOST_PENDING {
            self.pending.push((at, reading));
        }
    }
}

/// What a reading says, without its age.
pub(super) fn values(reading: &Reading<f64>) -> [f64; 4] {
    let of = |v: Vector<f64>| [v.x, v.y, v.z, 0.0];
    match reading {
        Reading::Range(reading) => [reading.distance_m, 0.0, 0.0, 0.0],
        Reading::Tag(reading) => of(reading.position_m),
        Reading::Gnss(reading) => of(reading.velocity_mps),
        Reading::Barometer(_) | Reading::Beacon(_) => [0.0; 4],
    }
}
