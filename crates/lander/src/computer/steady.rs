//! What a vehicle remembers of the air for the time when it no longer knows its velocity.

use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// Least time over which a mean is taken before it is used, s: ten values. With 1 s one more of 10 000 vehicles with failing senses crashes.
const LEARNED_S: f64 = 0.5;
/// Time constant of the error in a flight without a velocity, s. With drag κ per mass, the drift obeys s² + κ s + κ/T = 0:
/// of the default airframe κ is 0.4 s⁻¹, and its damping 0.77.
const DRIFT_S: f64 = 6.0;

/// Means over the time in which the vehicle knew its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Steady<R> {
    /// Observed disturbance, with the errors of accelerometer and attitude, N.
    pub(super) disturbance_n: Vector<R>,
    /// Those errors, m/s².
    pub(super) error_mps2: Vector<R>,
    /// Slope of the trim.
    pub(super) wind_slope: R,
    /// Time over which the means were taken, s.
    pub(super) learned_s: R,
    /// Velocity at the last value, m/s, where it was known.
    pub(super) velocity_mps: Option<Vector<R>>,
}

impl<R: Real> Steady<R> {
    /// Nothing.
    pub(super) const NONE: Self = Self {
        disturbance_n: Vector::ZERO,
        error_mps2: Vector::ZERO,
        wind_slope: R::ZERO,
        learned_s: R::ZERO,
        velocity_mps: None,
    };

    /// The mean disturbance, N, if it was taken long enough.
    pub(super) fn learned_n(&self, mass_kg: R) -> Option<Vector<R>> {
        (self.learned_s >= r(LEARNED_S)).then_some(self.disturbance_n - self.error_mps2 * mass_kg)
    }

    /// Corrects the horizontal error in a flight that balances the mean disturbance. The measured acceleration is there the error less
    /// κ times the drift. The error follows it, and so the drift ends.
    pub(super) fn drift(&mut self, felt_mps2: Vector<R>, dt: R) {
        let error_mps2 = (felt_mps2 - self.error_mps2).horizontal();
        self.error_mps2 += error_mps2 * (dt * r(1.0 / DRIFT_S));
    }
}
