//! State of the vehicle in six degrees of freedom.

use crate::body::contact::{Body, ContactState};
use crate::body::rotors::RotorsState;
use crate::number::Number;
use crate::number::vector::{Axes, axes_of};

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
pub(crate) const SIZE: usize = 22;

/// What is integrated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionState<N> {
    pub(crate) rotors: RotorsState<N>,
    pub(crate) position_m: [N; 3],
    pub(crate) velocity_mps: [N; 3],
    pub(crate) attitude: [N; 4],
    pub(crate) rates: [N; 3],
}

impl<N: Number> MotionState<N> {
    #[inline(always)]
    pub(crate) fn to_array(self) -> [N; SIZE] {
        let [x0, x1, x2, x3] = self.rotors.root_thrust;
        let [q0, q1, q2, q3] = self.rotors.inflow;
        let [x, y, z] = self.position_m;
        let [u, v, w] = self.velocity_mps;
        let [a, b, c, d] = self.attitude;
        let [p, q, r] = self.rates;
        let f = self.rotors.fountain;
        [
            x0, x1, x2, x3, q0, q1, q2, q3, f, x, y, z, u, v, w, a, b, c, d, p, q, r,
        ]
    }

    #[inline(always)]
    pub(crate) fn from_array(y: &[N; SIZE]) -> Self {
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
        }
    }

    /// `self + rate · time_s`.
    #[inline(always)]
    pub(crate) fn after(&self, rate: &Self, time_s: f64) -> Self {
        let mut next = *self;
        for i in 0..4 {
            let (rotors, by) = (&mut next.rotors, &rate.rotors);
            rotors.root_thrust[i] = rotors.root_thrust[i] + by.root_thrust[i] * time_s;
            rotors.inflow[i] = rotors.inflow[i] + by.inflow[i] * time_s;
            next.attitude[i] = next.attitude[i] + rate.attitude[i] * time_s;
        }
        next.rotors.fountain = next.rotors.fountain + rate.rotors.fountain * time_s;
        for k in 0..3 {
            next.position_m[k] = next.position_m[k] + rate.position_m[k] * time_s;
            next.velocity_mps[k] = next.velocity_mps[k] + rate.velocity_mps[k] * time_s;
            next.rates[k] = next.rates[k] + rate.rates[k] * time_s;
        }
        next
    }

    #[inline(always)]
    pub(crate) fn body<'a>(&self, axes: &'a Axes<N>) -> Body<'a, N> {
        Body {
            position_m: self.position_m,
            velocity_mps: self.velocity_mps,
            axes,
            rates: self.rates,
        }
    }
}

impl RigidState {
    #[inline]
    pub(crate) fn moving(&self) -> MotionState<f64> {
        MotionState {
            rotors: self.rotors,
            position_m: self.position_m,
            velocity_mps: self.velocity_mps,
            attitude: self.attitude,
            rates: self.rates,
        }
    }

    #[inline]
    pub(crate) fn take(&mut self, moving: &MotionState<f64>) {
        self.rotors = moving.rotors;
        self.position_m = moving.position_m;
        self.velocity_mps = moving.velocity_mps;
        self.attitude = moving.attitude;
        self.rates = moving.rates;
    }

    #[inline]
    pub(super) fn body<'a>(&self, axes: &'a Axes) -> Body<'a> {
        self.moving().body(axes)
    }

    /// Every value is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        // A sum is finite only if its parts are; none is near the largest number.
        self.moving().to_array().iter().sum::<f64>().is_finite()
    }

    /// The body's axes in world coordinates: forward, left, up.
    #[inline]
    #[must_use]
    pub fn axes(&self) -> [[f64; 3]; 3] {
        axes_of(self.attitude)
    }
}
