//! State of the vehicle in six degrees of freedom.

use crate::contact::{Body, ContactState};
use crate::rotors::RotorsState;
use crate::vector::{Axes, axes_of};

/// State of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidState {
    /// Rotors and air.
    pub rotors: RotorsState,
    /// Place of the reference point (the centre of mass), m.
    pub position_m: [f64; 3],
    /// Its velocity, m/s.
    pub velocity_mps: [f64; 3],
    /// Attitude, unit quaternion w, x, y, z from body to world.
    pub attitude: [f64; 4],
    /// Angular velocity in body axes ω, rad/s.
    pub rates: [f64; 3],
    /// Where feet stick to the deck.
    pub contact: ContactState,
}

impl Default for RigidState {
    fn default() -> Self {
        Self {
            rotors: RotorsState::default(),
            position_m: [0.0; 3],
            velocity_mps: [0.0; 3],
            attitude: [1.0, 0.0, 0.0, 0.0],
            rates: [0.0; 3],
            contact: ContactState::default(),
        }
    }
}

/// Numbers that are integrated.
const SIZE: usize = 22;

impl RigidState {
    #[inline]
    pub(super) fn to_array(self) -> [f64; SIZE] {
        let mut y = [0.0; SIZE];
        y[0..4].copy_from_slice(&self.rotors.root_thrust);
        y[4..8].copy_from_slice(&self.rotors.inflow);
        y[8] = self.rotors.fountain;
        y[9..12].copy_from_slice(&self.position_m);
        y[12..15].copy_from_slice(&self.velocity_mps);
        y[15..19].copy_from_slice(&self.attitude);
        y[19..22].copy_from_slice(&self.rates);
        y
    }

    #[inline]
    pub(super) fn from_array(y: &[f64; SIZE], contact: ContactState) -> Self {
        Self {
            rotors: RotorsState {
                root_thrust: [y[0], y[1], y[2], y[3]],
                inflow: [y[4], y[5], y[6], y[7]],
                fountain: y[8],
            },
            position_m: [y[9], y[10], y[11]],
            velocity_mps: [y[12], y[13], y[14]],
            attitude: [y[15], y[16], y[17], y[18]],
            rates: [y[19], y[20], y[21]],
            contact,
        }
    }

    #[inline]
    pub(super) fn body<'a>(&self, axes: &'a Axes) -> Body<'a> {
        Body {
            position_m: self.position_m,
            velocity_mps: self.velocity_mps,
            axes,
            rates: self.rates,
        }
    }

    /// Every value is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.to_array().iter().all(|value| value.is_finite())
    }

    /// The body's axes in world coordinates: forward, left, up.
    #[inline]
    #[must_use]
    pub fn axes(&self) -> [[f64; 3]; 3] {
        axes_of(self.attitude)
    }
}
