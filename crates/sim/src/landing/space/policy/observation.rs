//! What a policy sees.

/// Position and motion of a vehicle above its deck: the true ones in an environment for learning, estimates in a landing
/// with sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Place relative to the deck's centre, world axes, m.
    pub place_m: [f64; 3],
    /// Velocity relative to the deck's centre, world axes, m/s.
    pub relative_mps: [f64; 3],
    /// Velocity, world axes, m/s.
    pub velocity_mps: [f64; 3],
    /// Attitude w, x, y, z, from body to world.
    pub attitude: [f64; 4],
    /// Rates about body axes, rad/s.
    pub rates: [f64; 3],
    /// The deck's normal, world axes.
    pub normal: [f64; 3],
}

impl Observation {
    /// How many numbers it has.
    pub const NUMBERS: usize = 19;

    /// The numbers, in the order of the fields.
    #[must_use]
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let [[px, py, pz], [rx, ry, rz], [vx, vy, vz]] =
            [self.place_m, self.relative_mps, self.velocity_mps];
        let [qw, qx, qy, qz] = self.attitude;
        let [[p, q, r], [nx, ny, nz]] = [self.rates, self.normal];
        [
            px, py, pz, rx, ry, rz, vx, vy, vz, qw, qx, qy, qz, p, q, r, nx, ny, nz,
        ]
    }
}
