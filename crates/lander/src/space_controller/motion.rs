//! Input and output of the controller in space.

use crate::estimate::relative::RelativeEstimate;
use touchdown_flight::real::Real;
use touchdown_flight::reference::ReferencePoint;
use touchdown_flight::space::{Attitude, Vector};
use touchdown_flight::types::Measurement;

/// Position and motion of the vehicle, in world axes. The position is relative to the
/// deck's landing point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion<R: Real> {
    /// Position relative to the deck, m; z is the height.
    pub position_m: Vector<R>,
    /// Velocity relative to the deck, m/s.
    pub relative_velocity_mps: Vector<R>,
    /// Velocity of the vehicle, m/s.
    pub vehicle_velocity_mps: Vector<R>,
    /// Acceleration of the vehicle (gravity removed), m/s².
    pub acceleration_mps2: Vector<R>,
    /// Attitude of the vehicle.
    pub attitude: Attitude<R>,
    /// The deck's normal. A zero vector means unknown and counts as level.
    pub deck_normal: Vector<R>,
}

/// Target of the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target<R> {
    /// Height above the deck, and its motion.
    pub vertical: ReferencePoint<R>,
    /// Horizontal position relative to the deck, m; z is not used.
    pub position_m: Vector<R>,
    /// Velocity of that position, m/s.
    pub velocity_mps: Vector<R>,
    /// Acceleration of the deck, predicted to the time when the thrust acts, m/s².
    pub deck_acceleration_mps2: Vector<R>,
    /// Heading, rad.
    pub yaw_rad: R,
    /// The horizontal law has the gains of a descent.
    pub descending: bool,
    /// Share by which the poles of the horizontal law are at least faster than in a calm hover.
    pub haste: R,
    /// In the last decimetre above the deck, of a vehicle that leans into the wind: the slope of its trim, by which the tilt is
    /// limited. Otherwise 0.
    pub low_slope: R,
    /// Time constant with which the command counts a rising lift of the ground effect, s; at 0 it counts all lift at once.
    pub lift_rise_s: R,
    /// The vertical observer and the adaptation pause, because the legs may touch.
    pub hold_estimates: bool,
}

/// Command of a [`SpaceController`](super::SpaceController).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: Real + serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct SpaceCommand<R: Real> {
    /// Collective free-air thrust along the rotors' axis, N.
    pub thrust_n: R,
    /// Throttle that gives this thrust in the steady state.
    pub throttle: R,
    /// Commanded attitude.
    pub attitude: Attitude<R>,
    /// Present ground-effect force that the law uses, N.
    pub ground_effect_n: R,
    /// The demanded thrust exceeds that of the rotors.
    pub saturated: bool,
    /// A limit has reduced the horizontal force.
    pub limited: bool,
}

impl<R: Real> Motion<R> {
    /// The motion of an estimate, with an attitude and the deck's normal.
    #[must_use]
    pub fn from_estimate(
        estimate: &RelativeEstimate<R>,
        attitude: Attitude<R>,
        deck_normal: Vector<R>,
    ) -> Self {
        Self {
            position_m: estimate.position_m,
            relative_velocity_mps: estimate.relative_velocity_mps(),
            vehicle_velocity_mps: estimate.velocity_mps,
            acceleration_mps2: estimate.acceleration_mps2,
            attitude,
            deck_normal,
        }
    }

    /// `self` with every vector that is not finite taken from `previous`.
    pub(super) fn or_previous(&self, previous: &Self) -> Self {
        let attitude = if self.attitude.is_finite() {
            self.attitude
        } else {
            previous.attitude
        };
        Self {
            position_m: self.position_m.finite_or(previous.position_m),
            relative_velocity_mps: self
                .relative_velocity_mps
                .finite_or(previous.relative_velocity_mps),
            vehicle_velocity_mps: self
                .vehicle_velocity_mps
                .finite_or(previous.vehicle_velocity_mps),
            acceleration_mps2: self.acceleration_mps2.finite_or(previous.acceleration_mps2),
            attitude,
            deck_normal: self.deck_normal.direction().unwrap_or(Vector::UP),
        }
    }

    pub(super) fn vertical(&self) -> Measurement<R> {
        Measurement {
            height_m: self.position_m.z,
            relative_velocity_mps: self.relative_velocity_mps.z,
            vehicle_velocity_mps: self.vehicle_velocity_mps.z,
            acceleration_mps2: self.acceleration_mps2.z,
        }
    }
}

impl<R: Real> Target<R> {
    /// `self` with every value that is not finite taken from `previous`.
    pub(super) fn or_previous(&self, previous: &Self) -> Self {
        let (new, old) = (&self.vertical, &previous.vertical);
        let vertical = ReferencePoint {
            height_m: new.height_m.finite_or(old.height_m),
            velocity_mps: new.velocity_mps.finite_or(old.velocity_mps),
            acceleration_mps2: new.acceleration_mps2.finite_or(old.acceleration_mps2),
        };
        Self {
            vertical,
            position_m: self.position_m.finite_or(previous.position_m),
            velocity_mps: self.velocity_mps.finite_or(previous.velocity_mps),
            deck_acceleration_mps2: self
                .deck_acceleration_mps2
                .finite_or(previous.deck_acceleration_mps2),
            yaw_rad: self.yaw_rad.finite_or(previous.yaw_rad),
            descending: self.descending,
            haste: self.haste.finite_or(R::ZERO),
            low_slope: self.low_slope.finite_or(R::ZERO),
            lift_rise_s: self.lift_rise_s.finite_or(R::ZERO),
            hold_estimates: self.hold_estimates,
        }
    }
}
