//! What the state machine is told.

/// What the operator wants, for as long as it is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum OperatorRequest {
    /// Nothing: land.
    #[default]
    None,
    /// Do not land: climb away and hold.
    Abort,
    /// Begin anew after giving up or a landing. Taken once, when it is newly set:
    /// a request that stays set does not start the rotors after a touchdown.
    Restart,
    /// Stop the rotors now, wherever the vehicle is.
    Disarm,
}

/// What is seen in a step. Numbers may be NaN: they then count as bad.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MachineInput<R> {
    /// Age of the last tag detection that was used, s. An age below zero is a
    /// wrong clock and counts as stale.
    pub tag_age_s: R,
    /// Age of the last range that was used, s.
    pub range_age_s: R,
    /// Age of the last IMU sample, s.
    pub imu_age_s: R,
    /// The relative estimator no longer believes itself.
    pub diverged: bool,
    /// Height of the vehicle above the deck, m.
    pub height_m: R,
    /// Velocity relative to the deck along the vertical, up, m/s.
    pub relative_velocity_mps: R,
    /// Horizontal distance from the axis above the pad, m.
    pub lateral_error_m: R,
    /// Horizontal speed relative to the deck, m/s.
    pub lateral_speed_mps: R,
    /// Tilt of the vehicle, rad.
    pub tilt_rad: R,
    /// The rotors are being asked for more than they give (thrust or attitude).
    pub saturated: bool,
    /// Tilt of the deck, the greatest that is expected, rad.
    pub deck_tilt_rad: R,
    /// Vertical speed of the deck, the greatest that is expected, m/s.
    pub deck_speed_mps: R,
    /// Energy left in the battery, share of 1.
    pub battery_share: R,
    /// Thrust commanded last, share of the weight.
    pub thrust_share: R,
    /// Specific force along the body's z axis as felt by the IMU, over gravity:
    /// 1 at rest, 0 in free fall.
    pub load_factor: R,
    /// Contact switch in the legs, where there is one.
    pub contact: Option<bool>,
    /// The planner says that now is the moment to descend.
    pub go: bool,
    /// What the operator wants.
    pub request: OperatorRequest,
}
