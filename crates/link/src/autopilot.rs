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

/// A mode as `MAV_CMD_DO_SET_MODE` has it: custom main mode and sub-mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mode {
    pub(crate) main: f32,
    pub(crate) sub: f32,
}

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

    /// Whether a heartbeat's custom mode is the one in which it follows a companion.
    pub(crate) fn follows(self, custom_mode: u32) -> bool {
        match self {
            // Bits 16 to 23 are the main mode.
            Self::Px4 => (custom_mode >> 16) & 0xff == 6,
            Self::ArduPilot => custom_mode == 4,
        }
    }

    /// The mode in which it follows a companion.
    pub(crate) fn following_mode(self) -> Mode {
        match self {
            Self::Px4 => Mode {
                main: 6.0,
                sub: 0.0,
            },
            Self::ArduPilot => Mode {
                main: 4.0,
                sub: 0.0,
            },
        }
    }

    /// The modes that hold the position, then the altitude: hold and altitude control of PX4, brake and altitude hold of
    /// ArduPilot.
    pub(crate) fn holding_modes(self) -> [Mode; 2] {
        match self {
            Self::Px4 => [
                Mode {
                    main: 4.0,
                    sub: 3.0,
                },
                Mode {
                    main: 2.0,
                    sub: 0.0,
                },
            ],
            Self::ArduPilot => [
                Mode {
                    main: 17.0,
                    sub: 0.0,
                },
                Mode {
                    main: 2.0,
                    sub: 0.0,
                },
            ],
        }
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
