//! Where the deck is, from positions of vehicle and deck in a common frame.
//!
//! | deck | vehicle | frame |
//! | --- | --- | --- |
//! | `VISION_POSITION_ESTIMATE`, `ODOMETRY`, `LOCAL_POSITION_NED` of `deck.system_id` | the same messages of the vehicle's system | local, north-east-down |
//! | `GLOBAL_POSITION_INT`, `FOLLOW_TARGET` of `deck.system_id` | `GLOBAL_POSITION_INT` | globe |
//! | `LANDING_TARGET` in `MAV_FRAME_LOCAL_NED` | `LOCAL_POSITION_NED` | local, north-east-down |
//!
//! A pose that another component of the vehicle reports (a motion capture, say) goes before the autopilot's own, because
//! it shares the deck's frame. The vehicle's position is moved to the time of the deck's by its velocity, and the
//! difference is turned into body axes by the attitude of that time. Nobody synchronises clocks with the deck: its
//! positions are as old at their arrival as `deck.latency_s` says.

use mavlink::dialects::common::{LANDING_TARGET_DATA, MavFrame, MavMessage};
use touchdown_flight::{Attitude, Vector};
use touchdown_lander::estimate::relative::Reading;

use super::{Inbox, Source, target};
use crate::axes;

/// Mean radius of the Earth, m. Over the tens of metres between vehicle and deck its variation is below a millimetre a metre.
const EARTH_M: f64 = 6_371_009.0;
/// Longest time by which a position is moved, µs. Half of it drops every third fix at 5 Hz; over twice of it an
/// acceleration of 2 m/s² moves the vehicle by 0.36 m.
const MOVED_US: i64 = 300_000;
/// Attitudes that are kept: 0.6 s at 100 Hz.
const KEPT: usize = 64;

/// A position on the globe: latitude and longitude in 1e-7 degrees, altitude in m.
#[derive(Clone, Copy, Debug)]
struct Globe {
    latitude: i32,
    longitude: i32,
    altitude_m: f64,
}

/// The vehicle's positions, with their times.
#[derive(Clone, Debug, Default)]
pub(super) struct Positions {
    /// By the autopilot, north-east-down, m.
    own: Option<(i64, Vector<f64>)>,
    /// By another component of the vehicle.
    external: Option<(i64, Vector<f64>)>,
    globe: Option<(i64, Globe)>,
    /// Velocity, north-east-down, m/s.
    velocity: Vector<f64>,
    attitudes: Vec<(i64, Attitude<f64>)>,
    next: usize,
}

impl Positions {
    pub(super) fn new() -> Self {
        Self {
            attitudes: Vec::with_capacity(KEPT),
            ..Self::default()
        }
    }

    /// The attitude of this time.
    pub(super) fn turns(&mut self, at: i64, attitude: Attitude<f64>) {
        if self.attitudes.len() < KEPT {
            self.attitudes.push((at, attitude));
        } else {
            self.attitudes[self.next] = (at, attitude);
        }
        self.next = (self.next + 1) % KEPT;
    }

    /// The autopilot's own position and velocity.
    pub(super) fn moves(&mut self, at: i64, position: Vector<f64>, velocity: Vector<f64>) {
        self.own = Some((at, position));
        self.velocity = velocity;
    }

    pub(super) fn forget(&mut self) {
        (self.own, self.external, self.globe) = (None, None, None);
        self.attitudes.clear();
        self.next = 0;
    }

    /// The vehicle's local position at a time.
    fn local(&self, at: i64) -> Option<Vector<f64>> {
        let near = |fix: &(i64, Vector<f64>)| (at - fix.0).abs() <= MOVED_US;
        let (of, position) = self.external.filter(near).or(self.own.filter(near))?;
        Some(position + self.velocity * ((at - of) as f64 * 1e-6))
    }

    /// The way from the vehicle to a place on the globe at a time, north-east-down.
    fn to(&self, place: Globe, at: i64) -> Option<Vector<f64>> {
        let (of, here) = self.globe.filter(|(of, _)| (at - of).abs() <= MOVED_US)?;
        let radians = |difference: i64| difference as f64 * 1e-7_f64.to_radians();
        let north = radians(i64::from(place.latitude) - i64::from(here.latitude));
        let mut east = i64::from(place.longitude) - i64::from(here.longitude);
        // Across the date line the short way is the other one.
        let turn = 3_600_000_000;
        if east.abs() > turn / 2 {
            east -= turn * east.signum();
        }
        let level = radians(i64::from(here.latitude)).cos();
        let way = Vector::new(
            EARTH_M * north,
            EARTH_M * radians(east) * level,
            here.altitude_m - place.altitude_m,
        );
        Some(way - self.velocity * ((at - of) as f64 * 1e-6))
    }

    /// A way from the vehicle, north-east-down, in body axes of that time.
    fn in_body(&self, way: Vector<f64>, at: i64) -> Option<Vector<f64>> {
        let nearest = self
            .attitudes
            .iter()
            .min_by_key(|(of, _)| (at - of).abs())?;
        if (at - nearest.0).abs() > MOVED_US {
            return None;
        }
        Some(nearest.1.inverse().rotate(axes::world(way)))
    }
}

impl Inbox {
    /// Takes a message of another component of the vehicle: where it sees the vehicle.
    pub fn take_external(&mut self, message: &MavMessage, now_us: i64) {
        if let Some(position) = local_position(message) {
            if !position.is_finite() {
                self.ignored.unusable += 1;
                return;
            }
            let at = now_us - self.deck_latency_us;
            let values = [position.x, position.y, position.z, 0.0];
            if !self.is_frozen(|inbox| inbox.same_external.lasts(values, at)) {
                self.positions.external = Some((at, position));
            }
        }
    }

    /// Takes a message of the deck: where it is.
    pub fn take_deck(&mut self, message: &MavMessage, now_us: i64) {
        if self.has_camera {
            self.ignored.beside_camera += 1;
            return;
        }
        let at = now_us - self.deck_latency_us;
        let way = match message {
            MavMessage::GLOBAL_POSITION_INT(m) => {
                let place = Globe {
                    latitude: m.lat,
                    longitude: m.lon,
                    altitude_m: f64::from(m.alt) * 1e-3,
                };
                self.positions.to(place, at)
            }
            MavMessage::FOLLOW_TARGET(m) => {
                let place = Globe {
                    latitude: m.lat,
                    longitude: m.lon,
                    altitude_m: f64::from(m.alt),
                };
                self.positions.to(place, at)
            }
            message => {
                let Some(there) = local_position(message) else {
                    return;
                };
                self.positions.local(at).map(|here| there - here)
            }
        };
        if let Some(reading) = self.deck_at(way, self.deck_variance_m2, at) {
            self.queue_at(Source::Target, reading, at);
        }
    }

    /// Takes the vehicle's own position on the globe.
    pub(super) fn take_globe(&mut self, at: i64, [latitude, longitude]: [i32; 2], altitude_m: f64) {
        let globe = Globe {
            latitude,
            longitude,
            altitude_m,
        };
        self.positions.globe = Some((at, globe));
    }

    /// The reading of a `LANDING_TARGET` in the local frame.
    pub(super) fn local_target(
        &mut self,
        m: &LANDING_TARGET_DATA,
        at: i64,
    ) -> Option<Reading<f64>> {
        let there = Vector::new(f64::from(m.x), f64::from(m.y), f64::from(m.z));
        let own = self
            .positions
            .own
            .filter(|(of, _)| (at - of).abs() <= MOVED_US);
        let here = own
            .map(|(of, position)| position + self.positions.velocity * ((at - of) as f64 * 1e-6));
        let way = here.map(|here| there - here);
        let variance_m2 = way.map_or(0.0, |way| self.target_error.variance_m2(way));
        self.deck_at(way, variance_m2, at)
    }

    /// The reading of a way to the deck, north-east-down, if it is known.
    fn deck_at(
        &mut self,
        way: Option<Vector<f64>>,
        variance_m2: f64,
        at: i64,
    ) -> Option<Reading<f64>> {
        let Some(position_m) = way.and_then(|way| self.positions.in_body(way, at)) else {
            self.ignored.without_position += 1;
            return None;
        };
        Some(target::reading(position_m, variance_m2))
    }
}

/// The position in a message, north-east-down.
fn local_position(message: &MavMessage) -> Option<Vector<f64>> {
    let [x, y, z] = match message {
        MavMessage::VISION_POSITION_ESTIMATE(m) => [m.x, m.y, m.z],
        MavMessage::LOCAL_POSITION_NED(m) => [m.x, m.y, m.z],
        MavMessage::ODOMETRY(m) => match m.frame_id {
            MavFrame::MAV_FRAME_LOCAL_NED => [m.x, m.y, m.z],
            MavFrame::MAV_FRAME_LOCAL_ENU => [m.y, m.x, -m.z],
            _ => return None,
        },
        _ => return None,
    };
    Some(Vector::new(f64::from(x), f64::from(y), f64::from(z)))
}
