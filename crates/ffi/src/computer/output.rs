//! What a step of the landing computer returns.

use touchdown_lander::computer::ComputerOutput;
use touchdown_lander::state_machine::{Phase, Reason};

/// Phase of a landing.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_phase {
    /// Flying to the position above the pad.
    Approach = 0,
    /// Hovering above the pad until the vehicle is ready.
    Hold = 1,
    /// Ready; waiting for a good moment.
    Wait = 2,
    /// Descending, ready to abort.
    Descend = 3,
    /// Too low to abort for a lost tag.
    Commit = 4,
    /// Probably on the deck; the thrust decreases.
    Touchdown = 5,
    /// Rotors off.
    Disarmed = 6,
    /// Climbing away.
    GoAround = 7,
    /// The landing is given up; the vehicle holds its position.
    GivenUp = 8,
}

/// Why a landing was interrupted.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_reason {
    /// It was not.
    None = 0,
    /// The operator's request.
    Operator = 1,
    /// A number is not finite.
    NotFinite = 2,
    /// The estimator has diverged.
    Diverged = 3,
    /// The inertial unit's last sample is too old.
    ImuStale = 4,
    /// The range finder's last reading is too old.
    RangeStale = 5,
    /// The last detection of the tag is too old.
    TagLost = 6,
    /// Tilted too far.
    Tilt = 7,
    /// Too far from the axis above the pad.
    LateralError = 8,
    /// The closing speed to the deck is too high.
    ClosingSpeed = 9,
    /// The demand exceeds what the rotors give.
    Saturated = 10,
    /// The deck moves or tilts too much, or its motion is not known.
    Deck = 11,
    /// The wind pushes harder than friction holds on the deck.
    Wind = 12,
    /// The battery is low.
    BatteryLow = 13,
    /// Not at the hold height.
    Height = 14,
    /// Moving too fast relative to the deck to begin a descent.
    Unsteady = 15,
    /// A time limit is exceeded.
    Late = 16,
    /// The thrust was reduced, but nothing carries the vehicle.
    NotSupported = 17,
    /// The vehicle left the deck again.
    Bounce = 18,
    /// A reason that this header does not know.
    Other = 19,
}

/// Output of a step of the landing computer.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct td_computer_output {
    /// 1: fly thrust and attitude; 0: stop the rotors.
    pub rotors: u32,
    /// Free-air thrust along the rotors' axis, N.
    pub thrust_n: f32,
    /// Throttle that gives this thrust in the steady state.
    pub throttle: f32,
    /// Commanded rotation from body to world axes, quaternion w, x, y, z.
    pub attitude: [f32; 4],
    /// A `td_phase`.
    pub phase: u32,
    /// A `td_reason`: why the landing was interrupted.
    pub reason: u32,
    /// A `td_reason`: what keeps the vehicle in Approach or Hold.
    pub waits_for: u32,
    /// Number of go-arounds, without those that the operator ordered.
    pub go_arounds: u32,
    /// Vehicle relative to the deck, m; z is the height.
    pub position_m: [f32; 3],
    /// Its standard deviation, m.
    pub position_sd_m: [f32; 3],
    /// Velocity of the vehicle, m/s.
    pub velocity_mps: [f32; 3],
    /// Velocity of the deck, m/s.
    pub deck_velocity_mps: [f32; 3],
    /// Estimated latency of the readings beyond their stamped ages, s.
    pub latency_s: f32,
    /// Force that no model explains, N.
    pub disturbance_n: [f32; 3],
}

fn phase(phase: Phase) -> td_phase {
    match phase {
        Phase::Approach => td_phase::Approach,
        Phase::Hold => td_phase::Hold,
        Phase::Wait => td_phase::Wait,
        Phase::Descend => td_phase::Descend,
        Phase::Commit => td_phase::Commit,
        Phase::Touchdown => td_phase::Touchdown,
        Phase::Disarmed => td_phase::Disarmed,
        Phase::GoAround => td_phase::GoAround,
        Phase::GivenUp => td_phase::GivenUp,
    }
}

fn reason(reason: Option<Reason>) -> td_reason {
    match reason {
        None => td_reason::None,
        Some(Reason::Operator) => td_reason::Operator,
        Some(Reason::NotFinite) => td_reason::NotFinite,
        Some(Reason::Diverged) => td_reason::Diverged,
        Some(Reason::ImuStale) => td_reason::ImuStale,
        Some(Reason::RangeStale) => td_reason::RangeStale,
        Some(Reason::TagLost) => td_reason::TagLost,
        Some(Reason::Tilt) => td_reason::Tilt,
        Some(Reason::LateralError) => td_reason::LateralError,
        Some(Reason::ClosingSpeed) => td_reason::ClosingSpeed,
        Some(Reason::Saturated) => td_reason::Saturated,
        Some(Reason::Deck) => td_reason::Deck,
        Some(Reason::Wind) => td_reason::Wind,
        Some(Reason::BatteryLow) => td_reason::BatteryLow,
        Some(Reason::Height) => td_reason::Height,
        Some(Reason::Unsteady) => td_reason::Unsteady,
        Some(Reason::Late) => td_reason::Late,
        Some(Reason::NotSupported) => td_reason::NotSupported,
        Some(Reason::Bounce) => td_reason::Bounce,
        Some(_) => td_reason::Other,
    }
}

impl td_computer_output {
    pub(super) fn new(output: &ComputerOutput<f32>) -> Self {
        let command = output.command.unwrap_or_default();
        let machine = &output.state_machine;
        let estimate = &output.estimate;
        Self {
            rotors: u32::from(output.command.is_some()),
            thrust_n: command.thrust_n,
            throttle: command.throttle,
            attitude: command.attitude.to_quaternion(),
            phase: phase(machine.phase) as u32,
            reason: reason(machine.reason) as u32,
            waits_for: reason(machine.waits_for) as u32,
            go_arounds: u32::from(machine.go_arounds),
            position_m: estimate.position_m.to_array(),
            position_sd_m: estimate.position_sd_m.to_array(),
            velocity_mps: estimate.velocity_mps.to_array(),
            deck_velocity_mps: estimate.deck_velocity_mps.to_array(),
            latency_s: output.latency_s,
            disturbance_n: output.disturbance_n.to_array(),
        }
    }
}
