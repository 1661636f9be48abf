//! State of the sensors and consistency of the filter.

use super::reading::Sensor;
use super::settings::Gate;
use touchdown_flight::real::{Real, r};

/// Difference in time up to which two readings are the same one that came twice, s: above the rounding of ages in `f32`, below the
/// period of any sensor.
const SAME_S: f64 = 1e-4;

/// State of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorHealth<R> {
    /// Age of the newest reading that was used, s; infinite before the first.
    pub age_s: R,
    /// The age is below the sensor's limit.
    pub fresh: bool,
    /// Running mean of the normalised innovation squared: 1 for a consistent filter.
    pub nis: R,
    /// Number of successive readings outside the gate.
    pub rejected_in_a_row: u32,
    /// Number of readings that were used.
    pub used: u32,
    /// Number of readings outside the gate.
    pub rejected: u32,
    /// Number of readings with a value that is not finite.
    pub not_finite: u32,
    /// Number of readings older than the filter's memory.
    pub too_old: u32,
    /// Number of readings that found no room in the filter's memory.
    pub no_room: u32,
    /// Number of readings outside the sensor's usable range, and of readings stamped in
    /// the future.
    pub unusable: u32,
}

/// State of the sensors and consistency of the filter.
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
    /// Broadcast of the deck.
    pub beacon: SensorHealth<R>,
    /// The filter has diverged: the mean NIS of range, tag or GNSS exceeds its limit, or
    /// too many successive readings were rejected.
    pub diverged: bool,
}

/// Result of a correction by a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fate<R> {
    /// Used, with its normalised innovation squared.
    Used(R),
    /// Ignored: its innovation is outside the gate.
    Rejected,
    /// Ignored: it is outside the sensor's usable range.
    Unusable,
}

/// Monitor of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Monitor<R> {
    health: SensorHealth<R>,
    /// Age of the newest reading that was used when it arrived, s.
    late_s: R,
}

impl<R: Real> Default for Monitor<R> {
    fn default() -> Self {
        Self {
            health: SensorHealth {
                age_s: r(f64::INFINITY),
                nis: R::ONE,
                ..Self::BLANK.health
            },
            late_s: R::ZERO,
        }
    }
}

impl<R: Real> Monitor<R> {
    const BLANK: Self = Self {
        health: SensorHealth {
            age_s: R::ZERO,
            fresh: false,
            nis: R::ZERO,
            rejected_in_a_row: 0,
            used: 0,
            rejected: 0,
            not_finite: 0,
            too_old: 0,
            no_room: 0,
            unusable: 0,
        },
        late_s: R::ZERO,
    };
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

    /// Counts a reading of the age `age_s` and updates the mean NIS.
    pub(super) fn note(&mut self, fate: Fate<R>, age_s: R, gate: &Gate<R>) {
        let health = &mut self.health;
        let nis = match fate {
            Fate::Used(nis) => {
                count(&mut health.used);
                health.rejected_in_a_row = 0;
                if age_s < health.age_s - r(SAME_S) {
                    (health.age_s, self.late_s) = (age_s, age_s);
                }
                nis
            }
            Fate::Rejected => {
                count(&mut health.rejected);
                count(&mut health.rejected_in_a_row);
                // It counts as if at the gate, so that one outlier cannot decide.
                gate.gate_sd * gate.gate_sd
            }
            Fate::Unusable => return self.unusable(),
        };
        health.nis += (nis - health.nis) / gate.memory;
    }

    /// Forgets the inconsistency, after a restart of the filter.
    pub(super) fn reset(&mut self) {
        self.health.nis = R::ONE;
        self.health.rejected_in_a_row = 0;
    }

    pub(super) fn has_diverged(&self, gate: &Gate<R>) -> bool {
        self.health.nis > gate.nis_limit || self.health.rejected_in_a_row >= gate.rejections
    }

    /// Time since the newest reading that was used arrived, s; infinite before the first.
    pub(super) fn silent_s(&self) -> R {
        self.health.age_s - self.late_s
    }

    pub(super) fn health(&self, stale_s: R) -> SensorHealth<R> {
        SensorHealth {
            fresh: self.health.age_s < stale_s,
            ..self.health
        }
    }
}

/// Monitors of all sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Monitors<R: Real> {
    pub(super) imu: Monitor<R>,
    pub(super) range: Monitor<R>,
    pub(super) tag: Monitor<R>,
    pub(super) gnss: Monitor<R>,
    pub(super) barometer: Monitor<R>,
    pub(super) beacon: Monitor<R>,
}

impl<R: Real> Monitors<R> {
    /// Zeros, for memory that monitors are written to later.
    pub(super) const BLANK: Self = Self {
        imu: Monitor::BLANK,
        range: Monitor::BLANK,
        tag: Monitor::BLANK,
        gnss: Monitor::BLANK,
        barometer: Monitor::BLANK,
        beacon: Monitor::BLANK,
    };

    pub(super) fn of(&mut self, sensor: Sensor) -> &mut Monitor<R> {
        match sensor {
            Sensor::Imu => &mut self.imu,
            Sensor::Range => &mut self.range,
            Sensor::Tag => &mut self.tag,
            Sensor::Gnss => &mut self.gnss,
            Sensor::Barometer => &mut self.barometer,
            Sensor::Beacon => &mut self.beacon,
        }
    }

    pub(super) fn each(&mut self) -> [&mut Monitor<R>; 6] {
        [
            &mut self.imu,
            &mut self.range,
            &mut self.tag,
            &mut self.gnss,
            &mut self.barometer,
            &mut self.beacon,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_an_image_that_comes_again_is_no_new_one() {
        let gate = Gate::<f32>::default();
        let mut camera = Monitor::<f32>::default();
        assert_eq!(camera.silent_s(), f32::INFINITY);
        camera.note(Fate::Used(1.0), 0.2, &gate);
        assert_eq!(camera.silent_s(), 0.0);
        for step in 1..30_u8 {
            camera.grow(0.01);
            // The same image, whose stamp makes its age by another rounding.
            let again_s = 0.2 + 0.01 * f32::from(step) - 1e-5;
            camera.note(Fate::Used(1.0), again_s, &gate);
        }
        // Sums of 30 steps of 0.01 s, less the rounding of the stamps.
        assert!((camera.silent_s() - 0.29).abs() < 1e-4);
        camera.note(Fate::Used(1.0), 0.19, &gate);
        assert_eq!(camera.silent_s(), 0.0);
    }
}
