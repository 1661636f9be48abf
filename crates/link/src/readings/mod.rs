//! Readings of the sensors, from messages to the landing computer.
//!
//! | message | becomes | its age by |
//! | --- | --- | --- |
//! | `ATTITUDE_QUATERNION` | attitude | `time_boot_ms` |
//! | `HIGHRES_IMU`, `SCALED_IMU` | specific force, mean over a tick | `time_usec`, `time_boot_ms` |
//! | `DISTANCE_SENSOR` that looks down | range | `time_boot_ms` |
//! | `LANDING_TARGET` in `MAV_FRAME_BODY_FRD` or `MAV_FRAME_LOCAL_NED` with a valid position | position of the deck | `time_usec`; if 0, the settings |
//! | frames of the companion's own camera | position and normal of the deck | the camera's stamps; without them, the settings |
//! | positions of vehicle and deck | position of the deck | see `deck.rs` |
//! | `LOCAL_POSITION_NED` | velocity | `time_boot_ms` |
//!
//! ArduCopter reads its range finder at 20 Hz and stamps what it sends with the time of sending. So a range that it repeats is no
//! new reading: it would count several times, and each time as if it were new.
//!
//! Stamps are of the autopilot's clock. A reading is ignored and counted if it is not finite, older than
//! `sensors.greatest_age_s`, stamped in the future, repeated, frozen (see `frozen.rs`), or of another frame; so is every stamped
//! reading before the clocks are synchronised. Beside a camera, positions of the deck that others report are ignored and counted.

mod camera;
mod deck;
mod frozen;
mod queue;
mod repeats;
mod source;
mod target;
#[cfg(test)]
mod tests;

pub use source::Source;

use deck::Positions;
use frozen::{Same, SameBeside};
use queue::values;
use repeats::RangeRepeats;
use target::TargetError;

use mavlink::dialects::common::{
    LANDING_TARGET_DATA, LOCAL_POSITION_NED_DATA, MavFrame, MavMessage, MavSensorOrientation,
};
use serde::Serialize;
use touchdown_flight::{Attitude, Vector};
use touchdown_lander::estimate::relative::{
    GnssVelocity, ImuSample, RangeReading, Reading, TagReading,
};

use crate::autopilot::Autopilot;
use crate::axes;
use crate::clock::ClockSync;
use crate::settings::FlightSettings;

/// How far a stamp may lie in the future, µs: the error of the synchronisation.
const FUTURE_US: i64 = 20_000;

/// Readings that wait for the next tick; more are dropped.
const MOST_PENDING: usize = 32;

/// Greatest turn between two attitudes that no vehicle makes, rad, and rad/s: a multirotor turns at most at about 10 rad/s. Half
/// of them would take a fast manoeuvre for a reset of the autopilot's estimator; with twice of them, resets of the heading
/// by 20 degrees pass.
const TURN_RAD: f64 = 0.2;
const TURN_RAD_PER_S: f64 = 12.0;

/// Readings that were not used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct IgnoredReadings {
    /// Not finite, or outside of the range that the sensor reports for itself.
    pub unusable: u64,
    /// Older than `sensors.greatest_age_s`.
    pub too_old: u64,
    /// Stamped in the future.
    pub from_the_future: u64,
    /// Stamped no later than the one before: a packet that came twice or too late.
    pub repeated: u64,
    /// With new stamps and the values of before, for too long.
    pub frozen: u64,
    /// In a frame that is not supported.
    pub other_frame: u64,
    /// Positions of the deck while the vehicle's own position or attitude was not known.
    pub without_position: u64,
    /// Positions of the deck that others report, beside the companion's own camera.
    pub beside_camera: u64,
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
    target_error: TargetError,
    deck_latency_us: i64,
    deck_variance_m2: f64,
    has_camera: bool,
    camera_latency_us: i64,
    /// The newest normal of the deck, and its time.
    normal: Option<(i64, Vector<f64>)>,
    positions: Positions,
    attitude: Option<(i64, Attitude<f64>)>,
    /// The newest attitude's time by the autopilot's clock, µs.
    attitude_stamp_us: i64,
    force: Option<(i64, Vector<f64>)>,
    sum: Vector<f64>,
    summed: u32,
    velocity_us: Option<i64>,
    range_m: Option<f64>,
    range_latency_us: i64,
    range_repeats: RangeRepeats,
    /// Whether the vehicle is armed: on the ground, sensors without noise may stay the same.
    armed: bool,
    /// Values that stay the same, by [`Source`], and those of positions.
    same: [Same; 5],
    same_globe: Same,
    same_external: Same,
    same_range: SameBeside,
    same_force: SameBeside,
    /// Whether specific forces come in thousandths of g.
    coarse_force: bool,
    pending: Vec<(i64, Reading<f64>)>,
    /// The readings of the present step.
    ready: Vec<Reading<f64>>,
    /// Whether the attitude has jumped.
    jumped: bool,
    /// Arrivals since the last look, by [`Source`].
    arrivals: [u32; 5],
    /// Newest usable reading of each source, our time, µs.
    newest_us: [Option<i64>; 5],
    /// Newest stamp of each source, the autopilot's time, µs.
    stamps_us: [Option<i64>; 5],
    /// Readings that were not used.
    pub ignored: IgnoredReadings,
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
            target_error: TargetError {
                sd_m: sensors.target_sd_m,
                share: sensors.target_sd_share,
            },
            deck_latency_us: micros(settings.deck.latency_s),
            deck_variance_m2: settings.deck.sd_m * settings.deck.sd_m,
            has_camera: settings.has_camera(),
            camera_latency_us: micros(settings.camera.latency_s),
            normal: None,
            positions: Positions::new(),
            attitude: None,
            attitude_stamp_us: 0,
            force: None,
            sum: Vector::ZERO,
            summed: 0,
            velocity_us: None,
            range_m: None,
            range_latency_us: micros(sensors.range_latency_s),
            range_repeats: RangeRepeats::default(),
            armed: false,
            same: [Same::default(); 5],
            same_globe: Same::default(),
            same_external: Same::default(),
            same_range: SameBeside::default(),
            same_force: SameBeside::default(),
            coarse_force: false,
            pending: Vec::with_capacity(MOST_PENDING),
            ready: Vec::with_capacity(MOST_PENDING),
            jumped: false,
            arrivals: [0; 5],
            newest_us: [None; 5],
            stamps_us: [None; 5],
            ignored: IgnoredReadings::default(),
        }
    }

    /// The autopilot is known: how it repeats ranges.
    pub fn hears(&mut self, autopilot: Autopilot) {
        self.range_repeats = RangeRepeats::of(autopilot);
    }

    /// Whether the vehicle is armed. What happened to it on the ground says nothing of readings in flight.
    pub fn arms(&mut self, armed: bool) {
        if armed && !self.armed {
            self.same = [Same::default(); 5];
            (self.same_globe, self.same_external) = (Same::default(), Same::default());
            (self.same_range, self.same_force) = (SameBeside::default(), SameBeside::default());
        }
        self.armed = armed;
    }

    /// Takes a message that arrived at `now_us`, our time.
    pub fn take(&mut self, message: &MavMessage, clock: &ClockSync, now_us: i64) {
        match message {
            MavMessage::ATTITUDE_QUATERNION(m) => {
                let quaternion = [m.q1, m.q2, m.q3, m.q4].map(f64::from);
                if let Some(attitude) = axes::attitude(quaternion) {
                    let stamp = boot(m.time_boot_ms);
                    if let Some(at) = self.dated(Source::Attitude, quaternion, stamp, clock, now_us)
                    {
                        // By the autopilot's own clock: what is known of its offset may change between the two.
                        let elapsed_us = stamp.saturating_sub(self.attitude_stamp_us);
                        self.jumped |= self
                            .attitude
                            .is_some_and(|(_, before)| jumps(before, attitude, elapsed_us));
                        self.attitude = Some((at, attitude));
                        self.attitude_stamp_us = stamp;
                        self.positions.turns(at, attitude);
                    }
                } else {
                    self.ignored.unusable += 1;
                }
            }
            MavMessage::HIGHRES_IMU(m) => {
                let force = Vector::new(m.xacc, m.yacc, m.zacc);
                let stamp = i64::try_from(m.time_usec).unwrap_or(i64::MAX);
                self.coarse_force = false;
                self.take_force(force.to_array().map(f64::from), stamp, clock, now_us);
            }
            MavMessage::SCALED_IMU(m) => {
                // Thousandths of the standard gravity.
                let force = [m.xacc, m.yacc, m.zacc].map(|a| f64::from(a) * 9.80665e-3);
                self.coarse_force = true;
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
                self.range_m = usable.then_some(distance_m);
                let stamp_us = boot(m.time_boot_ms);
                if usable && self.range_repeats.is_repeat(m.current_distance, stamp_us) {
                    // It is alive, and nothing is new.
                    self.dated(Source::Range, values(&reading), stamp_us, clock, now_us);
                    return;
                }
                self.queue(Source::Range, reading, usable, stamp_us, clock, now_us);
            }
            MavMessage::LANDING_TARGET(m) => self.take_target(m, clock, now_us),
            MavMessage::LOCAL_POSITION_NED(m) => self.take_velocity(m, clock, now_us),
            MavMessage::GLOBAL_POSITION_INT(m) => {
                let at = clock.ours_us(boot(m.time_boot_ms));
                let place = [m.lat, m.lon, m.alt, 0].map(f64::from);
                let at = at.filter(|at| self.is_recent(*at, now_us));
                if let Some(at) = at
                    && !self.is_frozen(|inbox| inbox.same_globe.lasts(place, at))
                {
                    self.take_globe(at, [m.lat, m.lon], f64::from(m.alt) * 1e-3);
                }
            }
            _ => {}
        }
    }

    fn take_target(&mut self, m: &LANDING_TARGET_DATA, clock: &ClockSync, now_us: i64) {
        if self.has_camera {
            self.ignored.beside_camera += 1;
            return;
        }
        let local = m.frame == MavFrame::MAV_FRAME_LOCAL_NED;
        if !(local || m.frame == MavFrame::MAV_FRAME_BODY_FRD) || m.position_valid.bits() == 0 {
            self.ignored.other_frame += 1;
            return;
        }
        let stamp = i64::try_from(m.time_usec).unwrap_or(i64::MAX);
        if local {
            // Its place in the body follows from the vehicle's own place at its time.
            let unstamped = m.time_usec == 0;
            let at = if unstamped {
                Some(now_us - self.target_latency_us)
            } else {
                clock.ours_us(stamp)
            };
            let at = at.filter(|at| self.is_recent(*at, now_us));
            match at.and_then(|at| Some((at, self.local_target(m, at)?))) {
                Some((at, reading)) if unstamped => {
                    self.queue_at(Source::Target, reading, at);
                }
                Some((_, reading)) => {
                    self.queue(Source::Target, reading, true, stamp, clock, now_us);
                }
                None => {}
            }
            return;
        }
        let seen = Vector::new(f64::from(m.x), f64::from(m.y), f64::from(m.z));
        let position_m = axes::body(seen);
        let reading = target::reading(position_m, self.target_error.variance_m2(position_m));
        if m.time_usec == 0 {
            let at = now_us - self.target_latency_us;
            self.queue_at(Source::Target, reading, at);
        } else {
            self.queue(Source::Target, reading, true, stamp, clock, now_us);
        }
    }

    fn take_velocity(&mut self, m: &LOCAL_POSITION_NED_DATA, clock: &ClockSync, now_us: i64) {
        let of = |[x, y, z]: [f32; 3]| Vector::new(f64::from(x), f64::from(y), f64::from(z));
        let (position, velocity) = (of([m.x, m.y, m.z]), of([m.vx, m.vy, m.vz]));
        let reading = Reading::Gnss(GnssVelocity {
            velocity_mps: axes::world(velocity),
            age_s: 0.0,
        });
        if !position.is_finite() || !velocity.is_finite() {
            self.ignored.unusable += 1;
            return;
        }
        let stamp = boot(m.time_boot_ms);
        if let Some(at) = self.dated(Source::Velocity, values(&reading), stamp, clock, now_us) {
            self.positions.moves(at, position, velocity);
            self.same_force.shows(velocity.z, 0.0);
            self.push(Source::Velocity, reading, at);
        }
    }

    /// Whether a time is neither too old nor in the future.
    fn is_recent(&self, at: i64, now_us: i64) -> bool {
        (-FUTURE_US..=self.greatest_age_us).contains(&now_us.saturating_sub(at))
    }

    fn take_force(&mut self, force: [f64; 3], stamp_us: i64, clock: &ClockSync, now_us: i64) {
        let force = axes::body(Vector::from_array(force));
        if !force.is_finite() {
            self.ignored.unusable += 1;
            return;
        }
        let [x, y, z] = force.to_array();
        if let Some(at) = self.dated(Source::Imu, [x, y, z, 0.0], stamp_us, clock, now_us) {
            self.force = Some((at, force));
            self.sum += force;
            self.summed += 1;
        }
    }

    /// Prepares a step that ends at `now_us`: specific force and attitude, not finite where they are missing. The other
    /// readings are then in [`Self::ready`].
    pub fn sense(&mut self, now_us: i64) -> ImuSample<f64> {
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
        self.ready.clear();
        let dated = self.pending.drain(..);
        let age_s = |at: i64| (now_us - at).max(0) as f64 * 1e-6;
        self.ready
            .extend(dated.map(|(at, reading)| aged(reading, age_s(at))));
        ImuSample {
            specific_force_mps2,
            attitude: attitude.map(|(_, attitude)| attitude).unwrap_or_default(),
        }
    }

    /// The readings of the step that [`Self::sense`] prepared.
    #[must_use]
    pub fn ready(&self) -> &[Reading<f64>] {
        &self.ready
    }

    /// Whether the attitude has jumped since the last call, as by a reset of the autopilot's estimator.
    pub fn take_jump(&mut self) -> bool {
        std::mem::take(&mut self.jumped)
    }

    /// Age of the newest usable reading of any source, µs.
    #[must_use]
    pub fn newest_age_us(&self, now_us: i64) -> Option<i64> {
        let newest = self.newest_us.iter().flatten().max();
        newest.map(|at| (now_us - at).max(0))
    }

    /// Age of the newest usable reading of a source, s; infinite before the first.
    #[must_use]
    pub fn age_s(&self, source: Source, now_us: i64) -> f64 {
        self.newest_us[source as usize].map_or(f64::INFINITY, |at| (now_us - at) as f64 * 1e-6)
    }

    /// The newest range, m.
    #[must_use]
    pub fn range_m(&self) -> Option<f64> {
        self.range_m
    }

    /// Size of the newest specific force, m/s²; zero before the first.
    #[must_use]
    pub fn force_mps2(&self) -> f64 {
        self.force.map_or(0.0, |(_, force)| force.norm())
    }

    /// The newest attitude.
    #[must_use]
    pub fn attitude(&self) -> Option<Attitude<f64>> {
        self.attitude.map(|(_, attitude)| attitude)
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

    /// Forgets all dated readings, because the clocks are synchronised again.
    pub fn forget(&mut self) {
        self.attitude = None;
        self.force = None;
        (self.sum, self.summed) = (Vector::ZERO, 0);
        self.velocity_us = None;
        self.range_repeats.forget();
        self.same_range = SameBeside::default();
        self.same_force = SameBeside::default();
        self.pending.clear();
        self.normal = None;
        self.jumped = false;
        self.positions.forget();
        self.newest_us = [None; 5];
        self.stamps_us = [None; 5];
    }
}

fn aged(reading: Reading<f64>, age_s: f64) -> Reading<f64> {
    match reading {
        Reading::Range(reading) => Reading::Range(RangeReading { age_s, ..reading }),
        Reading::Tag(reading) => Reading::Tag(TagReading { age_s, ..reading }),
        Reading::Gnss(reading) => Reading::Gnss(GnssVelocity { age_s, ..reading }),
        other @ (Reading::Barometer(_) | Reading::Beacon(_)) => other,
    }
}

/// Whether no vehicle turns that far in a time.
fn jumps(before: Attitude<f64>, after: Attitude<f64>, elapsed_us: i64) -> bool {
    let (a, b) = (before.to_quaternion(), after.to_quaternion());
    let cosine: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let turn_rad = 2.0 * cosine.abs().min(1.0).acos();
    turn_rad > TURN_RAD + TURN_RAD_PER_S * elapsed_us as f64 * 1e-6
}
