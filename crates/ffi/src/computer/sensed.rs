//! What enters a step of the landing computer.

use touchdown_flight::{Attitude, Vector};
use touchdown_lander::computer::{NormalReading, Sensed};
use touchdown_lander::estimate::relative::{
    BarometerReading, BeaconReading, GnssVelocity, ImuSample, RangeReading, Reading, TagReading,
};
use touchdown_lander::state_machine::OperatorRequest;

use super::TD_READINGS_MAX;
use super::settings::vector;
use crate::error::td_error;
use crate::memory::{check, read};
use crate::numbers::numbered;

/// Which sensor a reading is of.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_reading_kind {
    /// Range finder.
    Range = 0,
    /// Camera that sees the tag on the deck.
    Tag = 1,
    /// Satellite navigation.
    Gnss = 2,
    /// Barometer.
    Barometer = 3,
    /// Broadcast of the deck.
    Beacon = 4,
}

/// Distance along the range finder's beam.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_range {
    /// Slant range, m.
    pub distance_m: f32,
}

/// Position of the deck's reference point by the camera.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_tag {
    /// Position in camera axes, m.
    pub position_m: [f32; 3],
    /// Its covariance in camera axes, row by row, m^2.
    pub covariance_m2: [f32; 9],
}

/// Velocity of the vehicle by satellite navigation.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_gnss {
    /// Velocity, world axes, m/s.
    pub velocity_mps: [f32; 3],
}

/// Altitude by air pressure.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_barometer {
    /// Altitude above an arbitrary zero, m.
    pub altitude_m: f32,
}

/// Place and velocity that the deck broadcasts, less the vehicle's own place.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_beacon {
    /// Vehicle relative to the deck, world axes, m.
    pub position_m: [f32; 3],
    /// Velocity of the deck, world axes, m/s; z is not used.
    pub deck_velocity_mps: [f32; 3],
}

/// The reading of one sensor: the member of its kind.
#[repr(C)]
#[derive(Clone, Copy)]
pub union td_reading_data {
    /// Of `TD_READING_KIND_RANGE`.
    pub range: td_range,
    /// Of `TD_READING_KIND_TAG`.
    pub tag: td_tag,
    /// Of `TD_READING_KIND_GNSS`.
    pub gnss: td_gnss,
    /// Of `TD_READING_KIND_BAROMETER`.
    pub barometer: td_barometer,
    /// Of `TD_READING_KIND_BEACON`.
    pub beacon: td_beacon,
}

/// A reading.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct td_reading {
    /// A `td_reading_kind`.
    pub kind: u32,
    /// Age of the reading at the end of the step, s.
    pub age_s: f32,
    /// The reading.
    pub data: td_reading_data,
}

/// Request of the operator; it holds as long as it is set.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_request {
    /// Land.
    None = 0,
    /// Do not land: climb away and hold.
    Abort = 1,
    /// Start again after a landing or after giving up.
    Restart = 2,
    /// Stop the rotors now, wherever the vehicle is.
    Disarm = 3,
}

/// What has been sensed since the last step. World and body axes: x forward, y left, z up.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct td_sensed {
    /// Specific force, body axes, m/s^2: +9.8 along z at rest.
    pub specific_force_mps2: [f32; 3],
    /// Rotation from body to world axes, quaternion w, x, y, z of any length.
    pub attitude: [f32; 4],
    /// The readings that have arrived; may be null without any.
    pub readings: *const td_reading,
    /// How many readings.
    pub readings_count: usize,
    /// The deck's normal by the camera, camera axes.
    pub deck_normal: [f32; 3],
    /// Age of that normal, s; below 0 for none.
    pub deck_normal_age_s: f32,
    /// Remaining energy of the battery, in [0, 1].
    pub battery_share: f32,
    /// Contact switch in the legs: 1 closed, 0 open, -1 for none.
    pub contact: i32,
    /// A `td_request`.
    pub request: u32,
}

numbered!(td_reading_kind: Range, Tag, Gnss, Barometer, Beacon);
numbered!(td_request: None, Abort, Restart, Disarm);

impl td_reading {
    fn reading(&self) -> Result<Reading<f32>, td_error> {
        let age_s = self.age_s;
        let kind = td_reading_kind::of(self.kind)?;
        // SAFETY: all members are numbers, for which every bit pattern is a value; the caller has
        // written the member of the kind.
        Ok(unsafe {
            match kind {
                td_reading_kind::Range => {
                    Reading::Range(RangeReading::level(self.data.range.distance_m, age_s))
                }
                td_reading_kind::Tag => {
                    let td_tag {
                        position_m,
                        covariance_m2: [a, b, c, d, e, f, g, h, i],
                    } = self.data.tag;
                    Reading::Tag(TagReading {
                        position_m: vector(position_m),
                        covariance_m2: [[a, b, c], [d, e, f], [g, h, i]],
                        age_s,
                    })
                }
                td_reading_kind::Gnss => Reading::Gnss(GnssVelocity {
                    velocity_mps: vector(self.data.gnss.velocity_mps),
                    age_s,
                }),
                td_reading_kind::Barometer => Reading::Barometer(BarometerReading {
                    altitude_m: self.data.barometer.altitude_m,
                    age_s,
                }),
                td_reading_kind::Beacon => Reading::Beacon(BeaconReading {
                    position_m: vector(self.data.beacon.position_m),
                    deck_velocity_mps: vector(self.data.beacon.deck_velocity_mps),
                    age_s,
                }),
            }
        })
    }
}

fn is_finite(reading: &Reading<f32>) -> bool {
    reading.age_s().is_finite()
        && match reading {
            Reading::Range(reading) => reading.distance_m.is_finite(),
            Reading::Tag(reading) => {
                reading.position_m.is_finite()
                    && reading
                        .covariance_m2
                        .as_flattened()
                        .iter()
                        .all(|x| x.is_finite())
            }
            Reading::Gnss(reading) => reading.velocity_mps.is_finite(),
            Reading::Barometer(reading) => reading.altitude_m.is_finite(),
            Reading::Beacon(reading) => {
                reading.position_m.is_finite() && reading.deck_velocity_mps.is_finite()
            }
        }
}

impl td_sensed {
    /// Reads the readings into `to`, and whether all their numbers are finite.
    ///
    /// # Safety
    /// `readings`, if it is neither null nor misaligned, points to `readings_count` readings.
    pub(super) unsafe fn readings(
        &self,
        to: &mut [Reading<f32>; TD_READINGS_MAX],
    ) -> Result<bool, td_error> {
        if self.readings_count > TD_READINGS_MAX {
            return Err(td_error::TooManyReadings);
        }
        if self.readings_count > 0 {
            check(self.readings)?;
        }
        let mut finite = true;
        for (i, place) in to.iter_mut().take(self.readings_count).enumerate() {
            // SAFETY: the caller's promise.
            *place = unsafe { read(self.readings.wrapping_add(i)) }?.reading()?;
            finite &= is_finite(place);
        }
        Ok(finite)
    }

    /// All numbers but those of the readings are finite.
    pub(super) fn is_finite(&self) -> bool {
        vector(self.specific_force_mps2).is_finite()
            && self.attitude.iter().all(|x| x.is_finite())
            && self.battery_share.is_finite()
            && (self.deck_normal_age_s < 0.0 || vector(self.deck_normal).is_finite())
    }

    pub(super) fn sensed<'a>(
        &self,
        readings: &'a [Reading<f32>],
    ) -> Result<Sensed<'a, f32>, td_error> {
        let none = Vector::new(f32::NAN, f32::NAN, f32::NAN);
        Ok(Sensed {
            imu: ImuSample {
                specific_force_mps2: vector(self.specific_force_mps2),
                // An attitude without numbers stays so: the computer knows what to do then.
                attitude: Attitude::from_quaternion(self.attitude)
                    .unwrap_or_else(|| Attitude::from_rotation_vector(none)),
            },
            readings,
            deck_normal: (self.deck_normal_age_s >= 0.0).then(|| NormalReading {
                normal: vector(self.deck_normal),
                age_s: self.deck_normal_age_s,
            }),
            battery_share: self.battery_share,
            contact: match self.contact {
                -1 => None,
                0 => Some(false),
                1 => Some(true),
                _ => return Err(td_error::UnknownValue),
            },
            request: match td_request::of(self.request)? {
                td_request::None => OperatorRequest::None,
                td_request::Abort => OperatorRequest::Abort,
                td_request::Restart => OperatorRequest::Restart,
                td_request::Disarm => OperatorRequest::Disarm,
            },
        })
    }
}
