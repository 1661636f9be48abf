//! Readings of the sensors.

use touchdown_flight::real::Real;
use touchdown_flight::space::{Attitude, Vector};

/// A sample of the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: Real + serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct ImuSample<R> {
    /// Specific force in body axes, mean over the step, m/s². At rest it is g, upwards.
    pub specific_force_mps2: Vector<R>,
    /// Attitude at the end of the step.
    pub attitude: Attitude<R>,
}

/// A reading, with its age at the end of the step that uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading<R> {
    /// Reading of the range finder.
    Range(RangeReading<R>),
    /// Reading of the camera.
    Tag(TagReading<R>),
    /// Velocity by satellite navigation.
    Gnss(GnssVelocity<R>),
    /// Reading of the barometer.
    Barometer(BarometerReading<R>),
    /// Broadcast of the deck.
    Beacon(BeaconReading<R>),
}

/// The distance along the range finder's beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeReading<R> {
    /// Slant range, m.
    pub distance_m: R,
    /// Normal of the deck, world axes ([`Vector::UP`] for a level deck).
    pub deck_normal: Vector<R>,
    /// Age, s.
    pub age_s: R,
}

impl<R: Real> RangeReading<R> {
    /// A reading above a level deck.
    #[must_use]
    pub fn level(distance_m: R, age_s: R) -> Self {
        Self {
            distance_m,
            deck_normal: Vector::UP,
            age_s,
        }
    }
}

/// The position of the deck's reference point, measured by the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagReading<R> {
    /// The deck's reference point in camera axes, m.
    pub position_m: Vector<R>,
    /// Covariance of the position in camera axes, m².
    pub covariance_m2: [[R; 3]; 3],
    /// Age, s.
    pub age_s: R,
}

/// Velocity of the vehicle by satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GnssVelocity<R> {
    /// Velocity, world axes, m/s.
    pub velocity_mps: Vector<R>,
    /// Age, s.
    pub age_s: R,
}

/// Altitude by air pressure, above an arbitrary zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarometerReading<R> {
    /// Altitude, m.
    pub altitude_m: R,
    /// Age, s.
    pub age_s: R,
}

/// Place and velocity of the deck by satellite navigation, as it broadcasts them, less the vehicle's own place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeaconReading<R> {
    /// Vehicle relative to the deck, world axes, m.
    pub position_m: Vector<R>,
    /// Velocity of the deck, world axes, m/s; z is not used.
    pub deck_velocity_mps: Vector<R>,
    /// Age, s.
    pub age_s: R,
}

/// The sensors of [`super::Health`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sensor {
    /// Inertial unit.
    Imu,
    /// Range finder.
    Range,
    /// Camera and tag.
    Tag,
    /// Satellite navigation.
    Gnss,
    /// Barometer.
    Barometer,
    /// Broadcast of the deck.
    Beacon,
}

impl<R: Real> ImuSample<R> {
    pub(super) fn is_finite(&self) -> bool {
        self.specific_force_mps2.is_finite() && self.attitude.is_finite()
    }
}

impl<R: Real> Reading<R> {
    /// The sensor that made the reading.
    #[must_use]
    pub fn sensor(&self) -> Sensor {
        match self {
            Self::Range(_) => Sensor::Range,
            Self::Tag(_) => Sensor::Tag,
            Self::Gnss(_) => Sensor::Gnss,
            Self::Barometer(_) => Sensor::Barometer,
            Self::Beacon(_) => Sensor::Beacon,
        }
    }

    /// Age of the reading, s.
    #[must_use]
    pub fn age_s(&self) -> R {
        match self {
            Self::Range(reading) => reading.age_s,
            Self::Tag(reading) => reading.age_s,
            Self::Gnss(reading) => reading.age_s,
            Self::Barometer(reading) => reading.age_s,
            Self::Beacon(reading) => reading.age_s,
        }
    }

    /// The same reading with `latency_s` added to its age. Readings of barometer and beacon do not change,
    /// because they do not come by the path of the others.
    #[must_use]
    pub fn older_by(self, latency_s: R) -> Self {
        match self {
            Self::Range(reading) => Self::Range(RangeReading {
                age_s: reading.age_s + latency_s,
                ..reading
            }),
            Self::Tag(reading) => Self::Tag(TagReading {
                age_s: reading.age_s + latency_s,
                ..reading
            }),
            Self::Gnss(reading) => Self::Gnss(GnssVelocity {
                age_s: reading.age_s + latency_s,
                ..reading
            }),
            Self::Barometer(_) | Self::Beacon(_) => self,
        }
    }

    /// Whether all numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.age_s().is_finite()
            && match self {
                Self::Range(reading) => {
                    reading.distance_m.is_finite() && reading.deck_normal.is_finite()
                }
                Self::Tag(reading) => {
                    let mut covariance = reading.covariance_m2.iter().flatten();
                    reading.position_m.is_finite() && covariance.all(|c| c.is_finite())
                }
                Self::Gnss(reading) => reading.velocity_mps.is_finite(),
                Self::Barometer(reading) => reading.altitude_m.is_finite(),
                Self::Beacon(reading) => {
                    reading.position_m.is_finite() && reading.deck_velocity_mps.is_finite()
                }
            }
    }
}
