//! The landing as a state machine: conditions go in, a manoeuvre comes out.
//!
//! ```text
//!             ┌────────────────────────────────────────────┐
//!             v                                            │
//!  start ─> Approach ─> Hold <─> Wait ─> Descend <─> Commit │<─> Touchdown ─> Disarmed
//!             ^  │        │        │        │          │    │        │
//!             │  └────────┴────────┴─> GivenUp         │    │        │
//!             │                          ^  (too many) v    │        v
//!             └──────────────────────────┴──────────── GoAround <────┘
//! ```
//!
//! A hover that sinks onto the deck goes around as well.
//!
//! # Transitions
//!
//! In every step the first row that applies is taken; where none does, the
//! phase stays. [`StateMachine::step`] runs them in this order.
//!
//! | from | when | to |
//! | --- | --- | --- |
//! | any | operator disarms | `Disarmed` |
//! | `Approach` | sinking | `GoAround` |
//! | `Approach` | operator aborts | `Hold` |
//! | `Approach` | battery low | `GivenUp` |
//! | `Approach` | patience over | `GivenUp` |
//! | `Approach` | everything fresh, at the hold height and over the pad | `Hold` |
//! | `Hold`, `Wait` | sinking, at the commit height or below | `GoAround` |
//! | `Hold` | operator aborts | `Hold`, patience anew |
//! | `Hold` | battery low | `GivenUp` |
//! | `Hold` | patience over | `GivenUp` |
//! | `Hold` | ready for `settle_s` | `Wait` |
//! | `Wait` | operator aborts | `Hold` |
//! | `Wait` | battery low | `GivenUp` |
//! | `Wait` | not ready | `Hold` |
//! | `Wait` | planner says go | `Descend` |
//! | `Wait` | patience over | `GivenUp` |
//! | `Descend` | operator aborts | `GoAround` |
//! | `Descend` | blind, tag lost, astray, saturated, deck beyond limits, battery low, late | `GoAround` |
//! | `Descend` | at the commit height or below | `Commit` |
//! | `Commit` | operator aborts | `GoAround` |
//! | `Commit` | blind | `GoAround` |
//! | `Commit` | touching for `contact_s` | `Touchdown` |
//! | `Commit` | astray, saturated, late | `GoAround` |
//! | `Commit` | above the commit height by `commit_margin_m`, tag lost | `GoAround` |
//! | `Commit` | above the commit height by `commit_margin_m` | `Descend` |
//! | `Touchdown` | operator aborts | `GoAround` |
//! | `Touchdown` | evidence for `confirm_s` | `Disarmed` |
//! | `Touchdown` | not supported for `fall_s`, late | `GoAround` |
//! | `Touchdown` | not touching for `bounce_s`, and blind | `GoAround` |
//! | `Touchdown` | not touching for `bounce_s` | `Commit` |
//! | `GoAround` | climbed or late; battery critical, operator does not abort | `Approach` |
//! | `GoAround` | climbed or late; battery low | `GivenUp` |
//! | `GoAround` | climbed or late; more go-arounds than allowed | `GivenUp` |
//! | `GoAround` | climbed or late; operator aborts | `Hold` |
//! | `GoAround` | climbed or late | `Approach` |
//! | `GivenUp` | operator restarts | `Approach`, go-arounds forgotten |
//! | `GivenUp` | battery critical, everything fresh, operator does not abort | `Approach` |
//! | `Disarmed` | operator restarts | `Approach`, go-arounds forgotten |
//!
//! # Words
//!
//! - *blind*: the estimate is not finite or has diverged, or IMU or range
//!   finder are older than their limits. *Fresh*: not blind, and the tag is
//!   young enough as well.
//! - *astray*: tilt, lateral error or closing speed beyond its limit for
//!   `excess_s`. Lateral error and closing speed are limited by a [`Funnel`].
//!   *Sinking*: closing speed beyond its limit for `excess_s`, outside a descent.
//! - *saturated*: the rotors have been asked for more than they give for
//!   `saturation_s`.
//! - *ready*: fresh, every number finite, at the hold height and over the pad, slower
//!   than `hold_speed_mps` relative to the deck, nothing beyond its limit, the rotors not
//!   asked for more than they give, the battery not low, the deck within its limits
//!   (unless the battery is critical).
//! - *touching*: not blind, height, relative velocity and lateral speed in the
//!   deck's frame within those of a touchdown, and no contact switch that says
//!   no. *Evidence*: touching, and either the contact switch says yes, or the
//!   thrust is down to `idle_thrust_share` of the weight and the IMU still feels
//!   `supported_load_factor`: something else carries the vehicle. *Not
//!   supported*: thrust down and the IMU feels less.
//! - *battery low*: a landing is no longer begun, so that what is left can be
//!   used to go elsewhere. *Critical*: too little is left to go anywhere; then
//!   the count of go-arounds, the deck's limits and the planner's patience
//!   ([`MachineOutput::hurry`]) stop mattering. Critical is not low.
//! - *climbed*: fresh, and as high as the hover less its tolerance.
//! - *go-arounds* that are counted are those out of a descent. *Patience*: time in
//!   Approach, Hold and Wait together since the last one. *Late*: too long in
//!   Descend, Commit and Touchdown together, or in GoAround.
//!
//! Anything not finite fails the condition that would let the landing go on. A
//! step longer than `greatest_step_s` counts in full as delay, but not as time
//! for which something good has held.
//!
//! # Below the commit height
//!
//! The tag leaves the view of a camera near the deck, and a vehicle this low is
//! safer on the deck than climbing away from it: from there a lost tag is coasted
//! on IMU and range finder. Deck and battery no longer matter.
//!
//! # What lying sensors can still do
//!
//! The machine believes ages and values that are finite and plausible:
//!
//! - A range finder that is stuck below the touchdown height while the vehicle
//!   flies at that speed relative to the deck opens `Touchdown`, where the thrust
//!   is taken back. The IMU then feels the fall and the machine goes around after
//!   `fall_s`, having dropped by `g/2 · fall_s²` and what the climb takes: disarming
//!   needs IMU, range, velocity and thrust to agree.
//! - A range finder that reads too high lets the vehicle touch the deck at the
//!   speed of the descent; the touchdown is not recognised, the time limit of
//!   the descent runs out and it takes off again, up to the number of go-arounds.
//! - A tag at another place than the map says, or someone else's tag, is landed on.
//! - Stamps that are always "now" make old data fresh.
//! - A contact switch that is stuck closed replaces thrust and IMU as evidence:
//!   with a range finder stuck low as well, the rotors stop in the air. One that
//!   is stuck open prevents disarming; the landing ends given up, in the air.
//! - An IMU that reads 1 g whatever happens, with a stuck range finder, does the same.
//! - A battery gauge that reads too high ends in an unpowered fall; one that reads
//!   zero makes every deck acceptable.
//! - An estimator that is wrong but content (its innovations within their gates)
//!   is believed.
//! - Without ever seeing the deck the machine never lands: what an empty battery
//!   means then is for the flight stack's own failsafe.

mod conditions;
mod input;
mod machine;
mod settings;

pub use input::{MachineInput, OperatorRequest};
pub use machine::MachineState;
pub use settings::{Funnel, StateMachine};

/// Where a landing is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Phase {
    /// On the way to the place above the pad.
    #[default]
    Approach,
    /// Above the pad, until everything has been in order for a while.
    Hold,
    /// Ready, waiting for the planner's word.
    Wait,
    /// On the way down, ready to abort.
    Descend,
    /// Too low to abort for a lost tag.
    Commit,
    /// On the deck as far as can be told, thrust being taken back.
    Touchdown,
    /// Rotors off.
    Disarmed,
    /// Climbing away.
    GoAround,
    /// Holding above the deck (or the place), landing given up.
    GivenUp,
}

/// Why a landing did not simply go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Reason {
    /// The operator wanted it.
    Operator,
    /// A number is not finite.
    NotFinite,
    /// The estimator has diverged.
    Diverged,
    /// The IMU's last sample is too old.
    ImuStale,
    /// The range finder's last sample is too old.
    RangeStale,
    /// The tag has not been seen for too long.
    TagLost,
    /// Tilted too far.
    Tilt,
    /// Too far from the axis above the pad.
    LateralError,
    /// Nearing the deck too fast.
    ClosingSpeed,
    /// The rotors do not give what is asked for.
    Saturated,
    /// The deck moves or tilts too much.
    Deck,
    /// The battery is low.
    BatteryLow,
    /// Not at the hold height.
    Height,
    /// Moving too fast relative to the deck to begin a descent.
    Unsteady,
    /// It took too long.
    Late,
    /// The thrust was taken back and nothing carries the vehicle.
    NotSupported,
    /// The vehicle left the deck again.
    Bounce,
}

/// In which frame a hover is to be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Frame {
    /// Above the pad, following the deck.
    Deck,
    /// Where the vehicle is: what is known of the deck is not to be used.
    World,
}

/// A manoeuvre for the guidance to fly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Maneuver<R> {
    /// Hover over the pad.
    Hover {
        /// Height above the deck, m.
        height_m: R,
        /// Whether above the deck, or where the vehicle is.
        frame: Frame,
    },
    /// The planned descent.
    Descend,
    /// The planned descent, horizontally as well as is known.
    Commit,
    /// Up, away from the deck, by IMU alone if need be.
    ClimbAway,
    /// Take the thrust back.
    Idle,
    /// Leave the thrust as it is.
    Rest,
    /// Rotors off.
    Disarm,
}

/// What a step of a [`StateMachine`] gives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MachineOutput<R> {
    /// Where the landing is.
    pub phase: Phase,
    /// The manoeuvre to fly.
    pub maneuver: Maneuver<R>,
    /// Why the phase is not the next one of a landing without trouble.
    pub reason: Option<Reason>,
    /// Aborted descents so far, the operator's left out.
    pub go_arounds: u8,
    /// The planner should not wait for a better moment.
    pub hurry: bool,
}
