//! Readings of the sensors, from messages to the landing computer.
//!
//! | message | becomes | its age by |
//! | --- | --- | --- |
//! | `ATTITUDE_QUATERNION` | attitude | `time_boot_ms` |
//! | `HIGHRES_IMU`, `SCALED_IMU` | specific force, mean over a tick | `time_usec`, `time_boot_ms` |
//! | `DISTANCE_SENSOR` that looks down | range | `time_boot_ms` |
//! | `LANDING_TARGET` in `MAV_FRAME_BODY_FRD` with a valid position | position of the deck | `time_usec`; if 0, the settings |
//! | `LOCAL_POSITION_NED` | velocity | `time_boot_ms` |
//!
//! Stamps are of the autopilot's clock. A reading is ignored and counted if it is not finite, older than
//! `sensors.greatest_age_s`, stamped in the future, repeated, or of another frame; so is every stamped reading before the clocks are
//! synchronised.

use mavlink::dialects::common::{LANDING_TARGET_DATA, MavFrame, MavMessage, MavSensorOrientation};
use serde::Serialize;
use touchdown_flight::{Attitude, Vector};
use touchdown_lander::estimate::relative::{
    GnssVelocity, ImuSample, RangeReading, Reading, TagReading,
};

use crate::axes;
use crate::clock::ClockSync;
use crate::settings::FlightSettings;

/// How far a stamp may lie in the future, µs: the error of the synchronisation.
const FUTURE_US: i64 = 20_000;

/// Readings that wait for the next tick; more are dropped.
const MOST_PENDING: usize = 32;

/// Kinds of readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Attitude.
    Attitude,
    /// Specific force.
    Imu,
    /// Range finder.
    Range,
    /// Velocity.
    Velocity,
    /// Position of the deck.
    Target,
}

impl Source {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Attitude,
        Self::Imu,
        Self::Range,
        Self::Velocity,
        Self::Target,
    ];

    /// The name of its message.
    #[must_use]
    pub fn message(self) -> &'static str {
        match self {
            Self::Attitude => "ATTITUDE_QUATERNION",
            Self::Imu => "HIGHRES_IMU or SCALED_IMU",
            Self::Range => "DISTANCE_SENSOR",
            Self::Velocity => "LOCAL_POSITION_NED",
            Self::Target => "LANDING_TARGET",
        }
    }
}

/// Readings that were not used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct IgnoredReadings {
    /// Not finite, or outside of what the sensor says that it measures.
    pub unusable: u64,
    /// Older than `sensors.greatest_age_s`.
    pub too_old: u64,
    /// Stamped in the future.
    pub from_the_future: u64,
    /// Stamped no later than the one before: a packet that came twice or too late.
    pub repeated: u64,
    /// In a frame that is not supported.
    pub other_frame: u64,
    /// Before the clocks were synchronised.
    pub unsynchronised: u64,
}

/// What arrived since the last tick, and the newest attitude and force.
#[derive(Clone, Debug)]
pub struct Inbox {
    greatest_age_us: i64,
    imu_gap_us: i64,
    target_latency_us: i64,
    velocity_period_us: i64,
    target_variance_m2: f64,
    attitude: Option<(i64, Attitude<f64>)>,
    force: Option<(i64, Vector<f64>)>,
    sum: Vector<f64>,
    summed: u32,
    velocity_us: Option<i64>,
    pending: Vec<(i64, Reading<f64>)>,
    /// Arrivals since the last look, by [`Source`].
    arrivals: [u32; 5],
    /// Newest usable reading of each source, our time, µs.
    newest_us: [Option<i64>; 5],
    /// Newest stamp of each source, the autopilot's time, µs.
    stamps_us: [Option<i64>; 5],
    /// Readings that were not used.
    pub ignored: IgnoredReadings,
}

/// Readings for one step of the landing computer.
#[derive(Clone, Debug)]
pub struct Sensing {
    /// Specific force and attitude; not finite where they are missing.
    pub imu: ImuSample<f64>,
    /// The other readings.
    pub readings: Vec<Reading<f64>>,
}

fn micros(seconds: f64) -> i64 {
    (seconds * 1e6).round() as i64
}

fn boot(milliseconds: u32) -> i64 {
    i64::from(milliseconds) * 1000
}

impl Inbox {
    /// An empty inbox.
    #[must_use]
    pub fn new(settings: &FlightSettings) -> Self {
        let sensors = &settings.sensors;
        Self {
            greatest_age_us: micros(sensors.greatest_age_s),
            imu_gap_us: micros(sensors.imu_gap_s),
            target_latency_us: micros(sensors.target_latency_s),
            velocity_period_us: micros(sensors.velocity_period_s),
            target_variance_m2: sensors.target_sd_m * sensors.target_sd_m,
            attitude: None,
            force: None,
            sum: Vector::ZERO,
            summed: 0,
            velocity_us: None,
            pending: Vec::with_capacity(MOST_PENDING),
            arrivals: [0; 5],
            newest_us: [None; 5],
            stamps_us: [None; 5],
            ignored: IgnoredReadings::default(),
        }
    }

    /// Takes a message that arrived at `now_us`, our time.
    pub fn take(&mut self, message: &MavMessage, clock: &ClockSync, now_us: i64) {
        match message {
            MavMessage::ATTITUDE_QUATERNION(m) => {
                let quaternion = [m.q1, m.q2, m.q3, m.q4].map(f64::from);
                if let Some(attitude) = axes::attitude(quaternion) {
                    let stamp = boot(m.time_boot_ms);
                    if let Some(at) = self.dated(Source::Attitude, stamp, clock, now_us) {
                        self.attitude = Some((at, attitude));
                    }
                } else {
                    self.ignored.unusable += 1;
                }
            }
            MavMessage::HIGHRES_IMU(m) => {
                let force = Vector::new(m.xacc, m.yacc, m.zacc);
                let stamp = i64::try_from(m.time_usec).unwrap_or(i64::MAX);
                self.take_force(force.to_array().map(f64::from), stamp, clock, now_us);
            }
            MavMessage::SCALED_IMU(m) => {
                // Thousandths of the standard gravity.
                let force = [m.xacc, m.yacc, m.zacc].map(|a| f64::from(a) * 9.80665e-3);
                self.take_force(force, boot(m.time_boot_ms), clock, now_us);
            }
            MavMessage::DISTANCE_SENSOR(m) => {
                if m.orientation != MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270 {
                    return;
                }
                let usable = m.signal_quality != 1
                    && (m.min_distance..=m.max_distance).contains(&m.current_distance);
                let distance_m = f64::from(m.current_distance) * 0.01;
                let reading = Reading::Range(RangeReading::level(distance_m, 0.0));
                self.queue(
                    Source::Range,
                    reading,
                    usable,
                    boot(m.time_boot_ms),
                    clock,
                    now_us,
                );
            }
            MavMessage::LANDING_TARGET(m) => self.take_target(m, clock, now_us),
            MavMessage::LOCAL_POSITION_NED(m) => {
                let velocity = Vector::new(f64::from(m.vx), f64::from(m.vy), f64::from(m.vz));
                let reading = Reading::Gnss(GnssVelocity {
                    velocity_mps: axes::world(velocity),
                    age_s: 0.0,
                });
                self.queue(
                    Source::Velocity,
                    reading,
                    true,
                    boot(m.time_boot_ms),
                    clock,
                    now_us,
                );
            }
            _ => {}
        }
    }

    fn take_target(&mut self, m: &LANDING_TARGET_DATA, clock: &ClockSync, now_us: i64) {
        if m.frame != MavFrame::MAV_FRAME_BODY_FRD || m.position_valid.bits() == 0 {
            self.ignored.other_frame += 1;
            return;
        }
        let seen = Vector::new(f64::from(m.x), f64::from(m.y), f64::from(m.z));
        let variance = self.target_variance_m2;
        let reading = Reading::Tag(TagReading {
            position_m: axes::body(seen),
            covariance_m2: [
                [variance, 0.0, 0.0],
                [0.0, variance, 0.0],
                [0.0, 0.0, variance],
            ],
            age_s: 0.0,
        });
        if m.time_usec == 0 {
            let at = now_us - self.target_latency_us;
            self.queue_at(Source::Target, reading, at);
        } else {
            let stamp = i64::try_from(m.time_usec).unwrap_or(i64::MAX);
            self.queue(Source::Target, reading, true, stamp, clock, now_us);
        }
    }

    fn take_force(&mut self, force: [f64; 3], stamp_us: i64, clock: &ClockSync, now_us: i64) {
        let force = axes::body(Vector::from_array(force));
        if !force.is_finite() {
            self.ignored.unusable += 1;
            return;
        }
        if let Some(at) = self.dated(Source::Imu, stamp_us, clock, now_us) {
            self.force = Some((at, force));
            self.sum += force;
            self.summed += 1;
        }
    }

    /// Our time of a stamp that is neither too old nor in the future, and newer than the last one of its source.
    fn dated(
        &mut self,
        source: Source,
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
        self.arrivals[index] += 1;
        self.newest_us[index] = Some(at);
        Some(at)
    }

    fn queue(
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
        } else if let Some(at) = self.dated(source, stamp_us, clock, now_us) {
            self.push(source, reading, at);
        }
    }

    /// Queues a reading that has no stamp.
    fn queue_at(&mut self, source: Source, reading: Reading<f64>, at: i64) {
        if !reading.is_finite() {
            self.ignored.unusable += 1;
            return;
        }
        self.arrivals[source as usize] += 1;
        self.newest_us[source as usize] = Some(at);
        self.push(source, reading, at);
    }

    fn push(&mut self, source: Source, reading: Reading<f64>, at: i64) {
        if source == Source::Velocity {
            let last = self.velocity_us;
            if last.is_some_and(|last| at - last < self.velocity_period_us) {
                return;
            }
            self.velocity_us = Some(at);
        }
        if self.pending.len() < MOST_PENDING {
            self.pending.push((at, reading));
        }
    }

    /// The readings for a step that ends at `now_us`.
    pub fn sense(&mut self, now_us: i64) -> Sensing {
        let missing = Vector::new(f64::NAN, f64::NAN, f64::NAN);
        let fresh = |at: i64| now_us - at <= self.imu_gap_us;
        let attitude = self.attitude.filter(|(at, _)| fresh(*at));
        let force = self.force.filter(|(at, _)| fresh(*at));
        let specific_force_mps2 = match (attitude, force) {
            (Some(_), Some(_)) if self.summed > 0 => self.sum * (1.0 / f64::from(self.summed)),
            (Some(_), Some((_, last))) => last,
            _ => missing,
        };
        (self.sum, self.summed) = (Vector::ZERO, 0);
        let readings = self
            .pending
            .drain(..)
            .map(|(at, reading)| aged(reading, ((now_us - at).max(0)) as f64 * 1e-6))
            .collect();
        Sensing {
            imu: ImuSample {
                specific_force_mps2,
                attitude: attitude.map(|(_, attitude)| attitude).unwrap_or_default(),
            },
            readings,
        }
    }

    /// Age of the newest usable reading of a source, s; infinite before the first.
    #[must_use]
    pub fn age_s(&self, source: Source, now_us: i64) -> f64 {
        self.newest_us[source as usize].map_or(f64::INFINITY, |at| (now_us - at) as f64 * 1e-6)
    }

    /// Level at the newest heading.
    #[must_use]
    pub fn level(&self) -> Attitude<f64> {
        let yaw_rad = self
            .attitude
            .map_or(0.0, |(_, attitude)| attitude.yaw_rad());
        Attitude::from_yaw(yaw_rad)
    }

    /// Usable readings of every source since the last call, in the order of [`Source::ALL`].
    pub fn take_arrivals(&mut self) -> [u32; 5] {
        std::mem::take(&mut self.arrivals)
    }

    /// Forgets everything that is dated: the clocks are synchronised anew.
    pub fn forget(&mut self) {
        self.attitude = None;
        self.force = None;
        (self.sum, self.summed) = (Vector::ZERO, 0);
        self.velocity_us = None;
        self.pending.clear();
        self.newest_us = [None; 5];
        self.stamps_us = [None; 5];
    }
}

fn aged(reading: Reading<f64>, age_s: f64) -> Reading<f64> {
    match reading {
        Reading::Range(reading) => Reading::Range(RangeReading { age_s, ..reading }),
        Reading::Tag(reading) => Reading::Tag(TagReading { age_s, ..reading }),
        Reading::Gnss(reading) => Reading::Gnss(GnssVelocity { age_s, ..reading }),
        other @ Reading::Barometer(_) => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::dialects::common::{DISTANCE_SENSOR_DATA, HIGHRES_IMU_DATA, MavBool};

    /// A clock of the autopilot that is 5 s ahead of ours.
    fn synchronised() -> ClockSync {
        let mut clock = ClockSync::default();
        clock.asks(0);
        clock.answered(0, 5_000_000, 0);
        clock
    }

    fn range(centimetres: u16, time_boot_ms: u32) -> MavMessage {
        MavMessage::DISTANCE_SENSOR(DISTANCE_SENSOR_DATA {
            time_boot_ms,
            min_distance: 2,
            max_distance: 1200,
            current_distance: centimetres,
            orientation: MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270,
            ..DISTANCE_SENSOR_DATA::default()
        })
    }

    #[test]
    fn analytic_the_age_of_a_reading_is_that_of_its_stamp() {
        let mut inbox = Inbox::new(&FlightSettings::default());
        inbox.take(&range(80, 6_000), &synchronised(), 1_030_000);
        let sensing = inbox.sense(1_040_000);
        let Reading::Range(reading) = sensing.readings[0] else {
            panic!("{sensing:?}");
        };
        assert_eq!(reading.distance_m, 0.8);
        assert!((reading.age_s - 0.04).abs() < 1e-12);
        assert!(
            !sensing.imu.specific_force_mps2.is_finite(),
            "no sample has come"
        );
    }

    #[test]
    fn prop_old_future_repeated_and_absurd_readings_are_ignored_and_counted() {
        let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
        inbox.take(&range(80, 6_000), &ClockSync::default(), 1_000_000);
        inbox.take(&range(80, 5_000), &clock, 1_000_000);
        inbox.take(&range(80, 7_000), &clock, 1_000_000);
        inbox.take(&range(1, 6_000), &clock, 1_000_000);
        inbox.take(&range(65_535, 6_000), &clock, 1_000_000);
        assert!(inbox.sense(1_000_000).readings.is_empty());
        inbox.take(&range(80, 6_000), &clock, 1_000_000);
        inbox.take(&range(80, 5_900), &clock, 1_000_000);
        assert_eq!(inbox.sense(1_000_000).readings.len(), 1);
        let expected = IgnoredReadings {
            unusable: 2,
            too_old: 1,
            from_the_future: 1,
            repeated: 1,
            other_frame: 0,
            unsynchronised: 1,
        };
        assert_eq!(inbox.ignored, expected);
    }

    #[test]
    fn analytic_forces_are_averaged_and_a_gap_is_bridged_once() {
        let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
        let level = mavlink::dialects::common::ATTITUDE_QUATERNION_DATA {
            time_boot_ms: 6_000,
            q1: 1.0,
            ..Default::default()
        };
        inbox.take(&MavMessage::ATTITUDE_QUATERNION(level), &clock, 1_000_000);
        for (time_usec, zacc) in [(5_999_000, -9.0), (6_000_000, -11.0)] {
            let sample = HIGHRES_IMU_DATA {
                time_usec,
                zacc,
                ..HIGHRES_IMU_DATA::default()
            };
            inbox.take(&MavMessage::HIGHRES_IMU(sample), &clock, 1_000_000);
        }
        assert_eq!(inbox.sense(1_000_000).imu.specific_force_mps2.z, 10.0);
        assert_eq!(inbox.sense(1_010_000).imu.specific_force_mps2.z, 11.0);
        assert!(inbox.sense(1_060_000).imu.specific_force_mps2.z.is_nan());
    }

    #[test]
    fn prop_a_target_in_another_frame_is_ignored() {
        let (mut inbox, clock) = (Inbox::new(&FlightSettings::default()), synchronised());
        let mut target = LANDING_TARGET_DATA {
            frame: MavFrame::MAV_FRAME_LOCAL_NED,
            z: 1.0,
            position_valid: MavBool::MAV_BOOL_TRUE,
            ..LANDING_TARGET_DATA::default()
        };
        inbox.take(
            &MavMessage::LANDING_TARGET(target.clone()),
            &clock,
            1_000_000,
        );
        assert_eq!(inbox.ignored.other_frame, 1);
        target.frame = MavFrame::MAV_FRAME_BODY_FRD;
        inbox.take(&MavMessage::LANDING_TARGET(target), &clock, 1_000_000);
        let sensing = inbox.sense(1_000_000);
        let Reading::Tag(reading) = sensing.readings[0] else {
            panic!("{sensing:?}");
        };
        assert_eq!(reading.position_m, Vector::new(0.0, -0.0, -1.0));
        assert!(
            (reading.age_s - 0.05).abs() < 1e-12,
            "the age that the settings give"
        );
    }
}
