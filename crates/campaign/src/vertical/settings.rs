//! Settings of a vertical landing and its controllers.

use serde::{Deserialize, Serialize};
use touchdown_flight::control::{Gains, Imbc, Ssc};
use touchdown_flight::types::Limits;
use touchdown_sim::landing::vertical::LandingScenario;

/// Rate of the descent at which the reference itself reaches 0.1 m at the published 5.1 s on the ground (1/s): calibrated.
pub const C_GROUND_PER_S: f64 = 0.7073;
/// Rate of the descent at which the reference itself reaches 0.1 m at the published 5.38 s on the deck (1/s): calibrated.
pub const C_DECK_PER_S: f64 = 0.5566;

/// A landing: what is landed on, and the controllers.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandSettings {
    /// Vehicle, air, deck, sensors and spreads.
    pub scenario: LandingScenario,
    /// The controllers.
    pub control: ControlSettings,
}

impl Default for LandSettings {
    fn default() -> Self {
        Self::ground()
    }
}

impl LandSettings {
    /// The landing on the ground (IV-C).
    #[must_use]
    pub fn ground() -> Self {
        Self {
            scenario: LandingScenario::default(),
            control: ControlSettings::default(),
        }
    }

    /// The landing on the oscillating deck (IV-D).
    #[must_use]
    pub fn deck() -> Self {
        Self {
            scenario: LandingScenario::oscillating_deck(),
            control: ControlSettings {
                c_per_s: C_DECK_PER_S,
                ..ControlSettings::default()
            },
        }
    }
}

/// The controllers' settings.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ControlSettings {
    /// Rate C of the descent, eq. (13) (1/s).
    pub c_per_s: f64,
    /// Height that the descent ends at (m).
    pub end_height_m: f64,
    /// Gains of eq. (10).
    pub gains: Gains<f64>,
    /// Poles of the internal model (1/s) (`imbc`, reconstructed).
    pub imbc_poles_per_s: [f64; 3],
    /// Amplitude of the sliding term (N) (`ssc`, reconstructed).
    pub ssc_rho_n: f64,
    /// Width of the sliding term (m/s).
    pub ssc_phi_mps: f64,
    /// Time constant of the smoothing filter (s).
    pub ssc_filter_s: f64,
    /// Seconds by which the deck's motion is predicted ahead: sensing, command and rotor delays.
    pub deck_lead_s: f64,
    /// Limits of the actuators.
    pub limits: Limits<f64>,
}

impl Default for ControlSettings {
    fn default() -> Self {
        let (imbc, ssc) = (
            Imbc::<f64>::new(std::f64::consts::PI),
            Ssc::<f64>::default(),
        );
        Self {
            c_per_s: C_GROUND_PER_S,
            end_height_m: 0.0,
            gains: Gains::default(),
            imbc_poles_per_s: imbc.poles_per_s,
            ssc_rho_n: ssc.rho_n,
            ssc_phi_mps: ssc.phi_mps,
            ssc_filter_s: ssc.filter_s,
            deck_lead_s: 0.09,
            limits: Limits::default(),
        }
    }
}
