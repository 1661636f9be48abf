//! The two autopilots: names, modes, parameters.

use std::fmt;

use mavlink::dialects::common::{MavAutopilot, MavType};
use serde::Serialize;

/// The firmware of an autopilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Autopilot {
    /// PX4.
    Px4,
    /// ArduPilot.
    ArduPilot,
}

/// Version of a firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Firmware {
    /// Major version.
    pub major: u8,
    /// Minor version.
    pub minor: u8,
    /// Patch.
    pub patch: u8,
}

impl Firmware {
    /// The version that `AUTOPILOT_VERSION.flight_sw_version` holds: major, minor, patch and type, a byte each.
    pub(crate) fn of(flight_sw_version: u32) -> Self {
        let [major, minor, patch, _] = flight_sw_version.to_be_bytes();
        Self {
            major,
            minor,
            patch,
        }
    }
}

impl fmt::Display for Firmware {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// A flight mode of an autopilot: custom main mode and sub-mode, as `MAV_CMD_DO_SET_MODE` has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mode {
    pub(crate) main: u8,
    pub(crate) sub: u8,
}

/// The modes of an autopilot that this program sets or expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Modes {
    /// Follows the setpoints of a companion.
    pub(crate) following: Mode,
    /// Takes off.
    pub(crate) take_off: Mode,
    /// Holds its position on its own at the end of a take-off.
    pub(crate) hold: Mode,
    /// Lands on its own.
    pub(crate) landing: Mode,
    /// Hold the position, then only the altitude, after a companion has given the vehicle back.
    pub(crate) given_back: [Mode; 2],
}

const fn mode(main: u8, sub: u8) -> Mode {
    Mode { main, sub }
}

/// OFFBOARD; AUTO.TAKEOFF; AUTO.LOITER; AUTO.LAND; AUTO.LOITER and ALTCTL.
const PX4: Modes = Modes {
    following: mode(6, 0),
    take_off: mode(4, 2),
    hold: mode(4, 3),
    landing: mode(4, 6),
    given_back: [mode(4, 3), mode(2, 0)],
};

/// GUIDED; GUIDED; LOITER; LAND; BRAKE and ALT_HOLD.
const ARDUPILOT: Modes = Modes {
    following: mode(4, 0),
    take_off: mode(4, 0),
    hold: mode(5, 0),
    landing: mode(9, 0),
    given_back: [mode(17, 0), mode(2, 0)],
};

impl Autopilot {
    /// The firmware of a heartbeat, if it is one of the two and flies a multirotor.
    pub(crate) fn of(autopilot: MavAutopilot, vehicle: MavType) -> Option<Self> {
        let multirotor = matches!(
            vehicle,
            MavType::MAV_TYPE_QUADROTOR
                | MavType::MAV_TYPE_COAXIAL
                | MavType::MAV_TYPE_HEXAROTOR
                | MavType::MAV_TYPE_OCTOROTOR
                | MavType::MAV_TYPE_TRICOPTER
                | MavType::MAV_TYPE_DODECAROTOR
                | MavType::MAV_TYPE_DECAROTOR
                | MavType::MAV_TYPE_GENERIC_MULTIROTOR
        );
        match autopilot {
            MavAutopilot::MAV_AUTOPILOT_PX4 if multirotor => Some(Self::Px4),
            MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA if multirotor => Some(Self::ArduPilot),
            _ => None,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Px4 => "PX4",
            Self::ArduPilot => "ArduPilot",
        }
    }

    /// The oldest version for which parameters and modes were compared with this program.
    pub(crate) fn oldest(self) -> Firmware {
        let (major, minor) = match self {
            Self::Px4 => (1, 17),
            Self::ArduPilot => (4, 7),
        };
        Firmware {
            major,
            minor,
            patch: 0,
        }
    }

    /// The mode in which it follows a companion.
    #[must_use]
    pub fn follows_in(self) -> &'static str {
        match self {
            Self::Px4 => "OFFBOARD",
            Self::ArduPilot => "GUIDED",
        }
    }

    /// Its modes.
    pub(crate) fn modes(self) -> &'static Modes {
        match self {
            Self::Px4 => &PX4,
            Self::ArduPilot => &ARDUPILOT,
        }
    }

    /// The mode that a heartbeat's custom mode is. PX4 has the main mode in bits 16 to 23 and the sub-mode above.
    fn mode(self, custom_mode: u32) -> Option<Mode> {
        let [low, high, main, sub] = custom_mode.to_le_bytes();
        match self {
            Self::Px4 => Some(Mode { main, sub }),
            Self::ArduPilot => ([high, main, sub] == [0; 3]).then_some(mode(low, 0)),
        }
    }

    /// Whether a heartbeat's custom mode is a mode.
    pub(crate) fn in_mode(self, custom_mode: u32, wanted: Mode) -> bool {
        self.mode(custom_mode) == Some(wanted)
    }

    /// Whether a heartbeat's custom mode is the one in which it follows a companion, with any sub-mode.
    pub(crate) fn follows(self, custom_mode: u32) -> bool {
        let main = self.modes().following.main;
        self.mode(custom_mode).is_some_and(|mode| mode.main == main)
    }

    /// The parameters that are read before control.
    pub(crate) fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Px4 => &[
                "THR_MDL_FAC",
                "MPC_THR_HOVER",
                "COM_OF_LOSS_T",
                "COM_OBL_RC_ACT",
                "EKF2_RNG_CTRL",
                "MPC_LAND_SPEED",
                "LNDMC_Z_VEL_MAX",
                "MC_BAT_SCALE_EN",
            ],
            Self::ArduPilot => &[
                "GUID_OPTIONS",
                "GUID_TIMEOUT",
                "MOT_THST_EXPO",
                "MOT_THST_HOVER",
                "MOT_SPIN_MIN",
                "MOT_SPIN_MAX",
                "PLND_ENABLED",
                "ATC_ANGLE_BOOST",
                "MOT_BAT_VOLT_MAX",
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_custom_modes_are_those_of_the_autopilots_documentation() {
        // PX4: `px4_custom_mode.h`, main mode in the third byte and sub-mode in the fourth one.
        let px4 = Autopilot::Px4;
        assert!(px4.follows(0x0006_0000) && px4.follows(0x0106_0000));
        assert!(!px4.follows(0x0304_0000) && !px4.follows(6));
        assert!(px4.in_mode(0x0604_0000, px4.modes().landing));
        assert!(!px4.in_mode(0x0604_0000, px4.modes().hold));
        // ArduCopter: the number of the mode itself.
        let ardupilot = Autopilot::ArduPilot;
        assert!(ardupilot.follows(4) && !ardupilot.follows(0x0004_0000));
        assert!(!ardupilot.follows(4 + 256));
        assert!(ardupilot.in_mode(9, ardupilot.modes().landing));
        assert!(!ardupilot.in_mode(5, ardupilot.modes().landing));
    }
}
