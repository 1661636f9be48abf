//! How far the estimate can be trusted.

use super::reading::Sensor;
use super::settings::Gate;
use touchdown_flight::real::{Real, r};

/// What is known of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorHealth<R> {
    /// Time since the newest reading that was used had been taken, s; infinite
    /// before the first.
    pub age_s: R,
    /// The age is below the sensor's limit.
    pub fresh: bool,
    /// Running mean of the normalised innovation squared: 1 where readings come
    /// as expected.
    pub nis: R,
    /// Readings left out in a row for being too far from what was expected.
    pub rejected_in_a_row: u32,
    /// Readings that were used.
    pub used: u32,
    /// Readings too far from what was expected.
    pub rejected: u32,
    /// Readings with a number that is not finite.
    pub not_finite: u32,
    /// Readings older than the filter's memory.
    pub too_old: u32,
    /// Readings that found no room in the filter's memory.
    pub no_room: u32,
    /// Readings outside the range in which the sensor is believed, and those that
    /// say to be of the future.
    pub unusable: u32,
}

/// What is known of the sensors and of the filter's consistency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Health<R> {
    /// Inertial unit. Its NIS is not used.
    pub imu: SensorHealth<R>,
    /// Range finder.
    pub range: SensorHealth<R>,
    /// Camera and tag.
    pub tag: SensorHealth<R>,
    /// Satellite navigation.
    pub gnss: SensorHealth<R>,
    /// Barometer.
    pub barometer: SensorHealth<R>,
    /// Readings and expectations have parted: the mean NIS of range, tag or
    /// GNSS is beyond its limit, or too many readings in a row were left out.
    pub diverged: bool,
}

/// What became of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fate<R> {
    /// Used, with its normalised innovation squared.
    Used(R),
    /// Too far from what was expected.
    Rejected,
    /// Outside the range in which the sensor is believed.
    Unusable,
}

/// The running account of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Monitor<R> {
    health: SensorHealth<R>,
}

impl<R: Real> Default for Monitor<R> {
    fn default() -> Self {
        Self {
            health: SensorHealth {
                age_s: r(f64::INFINITY),
                fresh: false,
                nis: R::ONE,
                rejected_in_a_row: 0,
                used: 0,
                rejected: 0,
                not_finite: 0,
                too_old: 0,
                no_room: 0,
                unusable: 0,
            },
        }
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl<R: Real> Monitor<R> {
    pub(super) fn grow(&mut self, dt: R) {
        self.health.age_s += dt;
    }

    pub(super) fn not_finite(&mut self) {
        count(&mut self.health.not_finite);
    }

    pub(super) fn too_old(&mut self) {
        count(&mut self.health.too_old);
    }

    pub(super) fn no_room(&mut self) {
        count(&mut self.health.no_room);
    }

    pub(super) fn unusable(&mut self) {
        count(&mut self.health.unusable);
    }

    /// A reading of the age `age_s` was used or not.
    pub(super) fn note(&mut self, fate: Fate<R>, age_s: R, gate: &Gate<R>) {
        let health = &mut self.health;
        let nis = match fate {
            Fate::Used(nis) => {
                count(&mut health.used);
                health.rejected_in_a_row = 0;
                health.age_s = health.age_s.min(age_s);
                nis
            }
            Fate::Rejected => {
                count(&mut health.rejected);
                count(&mut health.rejected_in_a_row);
                // Counted as at the gate: one that is far off is as bad as ten.
                gate.gate_sd * gate.gate_sd
            }
            Fate::Unusable => return self.unusable(),
        };
        health.nis += (nis - health.nis) / gate.memory;
    }

    /// Forgets that readings and expectations had parted.
    pub(super) fn forgive(&mut self) {
        self.health.nis = R::ONE;
        self.health.rejected_in_a_row = 0;
    }

    pub(super) fn parted(&self, gate: &Gate<R>) -> bool {
        self.health.nis > gate.nis_limit || self.health.rejected_in_a_row >= gate.rejections
    }

    pub(super) fn health(&self, stale_s: R) -> SensorHealth<R> {
        SensorHealth {
            fresh: self.health.age_s < stale_s,
            ..self.health
        }
    }
}

/// The accounts of all sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Monitors<R: Real> {
    pub(super) imu: Monitor<R>,
    pub(super) range: Monitor<R>,
    pub(super) tag: Monitor<R>,
    pub(super) gnss: Monitor<R>,
    pub(super) barometer: Monitor<R>,
}

impl<R: Real> Monitors<R> {
    pub(super) fn of(&mut self, sensor: Sensor) -> &mut Monitor<R> {
        match sensor {
            Sensor::Imu => &mut self.imu,
            Sensor::Range => &mut self.range,
            Sensor::Tag => &mut self.tag,
            Sensor::Gnss => &mut self.gnss,
            Sensor::Barometer => &mut self.barometer,
        }
    }

    pub(super) fn each(&mut self) -> [&mut Monitor<R>; 5] {
        [
            &mut self.imu,
            &mut self.range,
            &mut self.tag,
            &mut self.gnss,
            &mut self.barometer,
        ]
    }
}
