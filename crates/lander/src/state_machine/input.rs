//! Input of the state machine.

/// Request of the operator; it holds as long as it is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum OperatorRequest {
    /// No request: land.
    #[default]
    None,
    /// Do not land: climb away and hold.
    Abort,
    /// Start again after a landing or after giving up. It acts only in the step in which
    /// it is set, so that a request that stays set cannot start the rotors after a
    /// touchdown.
    Restart,
    /// Stop the rotors now, wherever the vehicle is.
    Disarm,
}

/// Input of a step. A NaN counts as a violated condition.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MachineInput<R> {
    /// Time since the last tag detection that was used arrived, s. A negative one means a wrong clock
    /// and counts as stale.
    pub tag_age_s: R,
    /// Age of the last range that was used, s.
    pub range_age_s: R,
    /// Age of the last IMU sample, s.
    pub imu_age_s: R,
    /// The relative estimator has diverged.
    pub diverged: bool,
    /// Height of the vehicle above the deck, m.
    pub height_m: R,
    /// How much lower the lowest foot is, by the tilts of vehicle and deck, than that of a
    /// level vehicle over a level deck, m.
    pub foot_drop_m: R,
    /// Uncertainty of that height, standard deviation, m. It decides only while neither range nor tag is fresh; NaN counts
    /// as uncertain.
    pub height_sd_m: R,
    /// Velocity relative to the deck along the vertical, up, m/s.
    pub relative_velocity_mps: R,
    /// Horizontal distance from the axis above the pad, m.
    pub lateral_error_m: R,
    /// Horizontal speed relative to the deck, m/s.
    pub lateral_speed_mps: R,
    /// Tilt of the vehicle beyond that of its trim in the wind, rad.
    pub tilt_rad: R,
    /// The demanded thrust or attitude exceeds what the rotors give.
    pub saturated: bool,
    /// Greatest expected tilt of the deck, rad.
    pub deck_tilt_rad: R,
    /// Greatest expected vertical speed of the deck, m/s.
    pub deck_speed_mps: R,
    /// Slope of the trim: horizontal over vertical thrust that holds the vehicle in the wind.
    pub wind_slope: R,
    /// The wind pushes harder than feet hold that just touch, in a gust that is worth waiting out.
    pub gusty: bool,
    /// How much higher than `hold_height_m` the vehicle holds over this deck, m.
    pub hold_extra_m: R,
    /// Remaining energy of the battery, in [0, 1].
    pub battery_share: R,
    /// Last commanded thrust, over the weight.
    pub thrust_share: R,
    /// Measured specific force along the body's z axis, over gravity: 1 at rest, 0 in
    /// free fall.
    pub load_factor: R,
    /// Estimated force of the deck on the legs, over the weight: what the IMU measures
    /// beyond thrust, ground effect and the disturbance of the flight before. NaN counts
    /// as none.
    pub support_share: R,
    /// Contact switch in the legs, if there is one.
    pub contact: Option<bool>,
    /// The planner decides to descend now.
    pub go: bool,
    /// The operator's request.
    pub request: OperatorRequest,
}
