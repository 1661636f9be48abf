//! Kinds of readings.

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
            Self::Target => "position of the deck",
        }
    }
}
