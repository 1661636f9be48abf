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
//! In every step the first row whose condition holds is applied, in this order. If no
//! condition holds, the phase stays.
//!
//! | from | when | to |
//! | --- | --- | --- |
//! | any | operator disarms | `Disarmed` |
//! | `Approach` | sinking | `GoAround` |
//! | `Approach`, `Hold`, `Wait` | out of sight for `lost_s` (sooner above a rough sea), below `safe_height_m`, not climbed since | `GoAround` |
//! | `Approach`, `Hold`, `Wait` | out of sight for `search_s` | `GivenUp` |
//! | `Approach` | operator aborts | `Hold` |
//! | `Approach` | battery low | `GivenUp` |
//! | `Approach` | patience over | `GivenUp` |
//! | `Approach` | everything fresh, at the hold height and over the pad | `Hold` |
//! | `Hold`, `Wait` | sinking; not blind, and at the commit height or below | `GoAround` |
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
//! | `Descend` | blind, tag lost, astray, saturated, deck beyond limits, gust, battery low, late | `GoAround` |
//! | `Descend` | at the commit height or below | `Commit` |
//! | `Commit` | operator aborts | `GoAround` |
//! | `Commit` | blind | `GoAround` |
//! | `Commit` | supported for `support_s`, or touching for `contact_s` | `Touchdown` |
//! | `Commit` | astray, saturated, late, *gusty* | `GoAround` |
//! | `Commit` | above the commit height by `commit_margin_m`, tag lost | `GoAround` |
//! | `Commit` | above the commit height by `commit_margin_m` | `Descend` |
//! | `Touchdown` | operator aborts | `GoAround` |
//! | `Touchdown` | evidence for `confirm_s` | `Disarmed` |
//! | `Touchdown` | not supported for `fall_s`, late | `GoAround` |
//! | `Touchdown` | neither touching nor low for `bounce_s`, and blind | `GoAround` |
//! | `Touchdown` | neither touching nor low for `bounce_s` | `Commit` |
//! | `GoAround` | climbed or late; battery critical, operator does not abort | `Approach` |
//! | `GoAround` | climbed or late; battery low | `GivenUp` |
//! | `GoAround` | climbed or late; more go-arounds than allowed | `GivenUp` |
//! | `GoAround` | climbed or late; operator aborts | `Hold` |
//! | `GoAround` | climbed or late | `Approach` |
//! | `GivenUp` | operator restarts | `Approach`, go-arounds forgotten |
//! | `GivenUp` | battery critical, everything fresh, operator does not abort | `Approach` |
//! | `Disarmed` | operator restarts | `Approach`, go-arounds forgotten |
//!
//! # Conditions
//!
//! - *blind*: the estimate is not finite or has diverged, or the IMU's last sample is older than its limit. Or neither range
//!   nor tag is within its limit, and the height's standard deviation exceeds `coast_sd_m`. *Fresh*: not blind, and the
//!   last tag reading is within its limit. *Out of sight*: not fresh.
//! - *astray*: tilt, lateral error or closing speed beyond its limit for
//!   `excess_s`. Lateral error and closing speed are limited by a [`Funnel`].
//!   *Sinking*: closing speed beyond its limit for `excess_s`, outside a descent.
//! - *saturated*: the demand has exceeded what the rotors give for `saturation_s`.
//! - *ready*: all of these hold. The input is fresh and finite. The vehicle is at the hold
//!   height and over the pad, and slower than `hold_speed_mps` relative to the deck. No
//!   limit is exceeded, the rotors are not saturated, and the battery is not low. The deck
//!   is within its limits, unless the battery is critical.
//! - *gust*: the trim's slope exceeds `wind_slope` (no descent begins), by 0.08 more (a descent
//!   above the commit height is aborted). The wind would push a standing vehicle off the deck.
//!   *Gusty*: the wind pushes harder than feet hold that just touch, and harder than it usually does
//!   ([`MachineInput::gusty`]), no foot is *low*, the battery is neither low nor critical, and the hover is not
//!   raised over a rough sea. In such a gust the vehicle would slide as it touches, and fall from
//!   one foot onto the others.
//! - *touching*: not blind; height, relative velocity and lateral speed in the deck's
//!   frame are within the limits of a touchdown; no contact switch is open. Or *supported*.
//!   The height is that of the lowest foot, which tilt brings down. *Low*: that height alone,
//!   up to `support_margin_m` more, after a touch of a vehicle that leans into the wind: it rocks
//!   from foot to foot, and slides. While it leans, twice the speeds count for `contact_s`.
//! - *supported*: touching, and the deck's force on the legs is at least `support_share` of
//!   the weight. Up to `support_margin_m` above the height of a touchdown, and up to twice
//!   its speed, twice that force counts: a first contact is short, and height and velocity
//!   follow it late. This force comes from the models of thrust and ground effect. It
//!   decides when the thrust decreases; the evidence below, without models, stops the rotors.
//! - *evidence*: touching, or low and sliding at twice the vertical speed of a touchdown at most,
//!   and one of two. Either the contact switch is closed, or the
//!   thrust is at most `idle_thrust_share` of the weight while the IMU measures at least
//!   `supported_load_factor`, so that something else carries the vehicle. A thrust below a tenth of
//!   the weight needs only the difference of these two limits beyond it, because a shaking deck carries
//!   a vehicle now more, now less. *Not supported*: the thrust is at most `idle_thrust_share`, but the
//!   IMU measures less than `supported_load_factor`. While the lowest foot is more than `leaning_m`
//!   below the others there is no evidence before the thrust is below a tenth of the weight: the
//!   vehicle would fall when the rotors stop. After a touch in a tilt, the fall onto
//!   the other feet is not counted.
//! - *battery low*: no landing begins, so that the remaining energy can be used to fly
//!   elsewhere. *Critical*: the energy does not suffice to fly elsewhere. Then the number
//!   of go-arounds, the deck's limits and the planner's waiting time
//!   ([`MachineOutput::hurry`]) no longer matter. Critical excludes low.
//! - *climbed*: fresh, and at least at the hover height less its tolerance; or at `safe_height_m`.
//! - *go-arounds*: all count but those of the operator; those out of a hover and those for the wind have limits of their own. *Patience*: the limit of the time in
//!   Approach, Hold and Wait together since the last descent. *Late*: the time in Descend,
//!   Commit and Touchdown together, or in GoAround, exceeds its limit.
//!
//! A value that is not finite fails every condition that would continue the landing. A
//! step longer than `greatest_step_s` counts in full towards time limits, but not towards
//! the time for which a condition has held.
//!
//! # Out of sight
//!
//! A hover that does not see the deck keeps its place in the world, while the deck moves on. So it climbs after `lost_s`, once,
//! to `safe_height_m` (for `climb_s` where the height is not known), from where the camera sees farther. There it waits
//! until it sees the deck again, or gives up after `search_s`. A vehicle that has given up at the deck climbs as well.
//!
//! # Below the commit height
//!
//! Near the deck the tag leaves the camera's view, and landing is safer than climbing
//! away. So below the commit height the vehicle continues without the tag, on IMU and
//! range finder. Without a range it continues as long as the IMU carries the height on. Deck and battery no longer matter.
//!
//! # Remaining failures by wrong sensors
//!
//! The machine accepts ages and values that are finite and plausible:
//!
//! - A range finder stuck below the touchdown height, in a slow flight over the deck,
//!   leads to `Touchdown`, where the thrust decreases. The IMU then measures the fall, and
//!   the machine goes around after `fall_s`. The vehicle drops by `g/2 · fall_s²` plus the
//!   height that the climb needs. Disarming requires IMU, range, velocity and thrust to
//!   agree.
//! - With a range finder that reads too high, the vehicle touches the deck at the speed of
//!   the descent. The machine does not detect the touchdown. At the time limit of the
//!   descent it takes off again, up to the number of go-arounds.
//! - The vehicle lands on a tag that is not where the map says, and on a foreign tag.
//! - Time stamps that are always "now" make old data fresh.
//! - A contact switch stuck closed replaces thrust and IMU as evidence. If the range
//!   finder is stuck low as well, the rotors stop in the air. A switch stuck open prevents
//!   disarming; the machine then gives up in the air.
//! - An IMU stuck at 1 g, together with a stuck range finder, also stops the rotors.
//! - A battery gauge that reads too high ends in an unpowered fall. One that reads zero
//!   makes every deck acceptable.
//! - A wrong estimate whose innovations stay within their gates is accepted.
//! - If the deck is never observed, the machine never lands. The failsafe of the flight
//!   stack must then react to an empty battery.

mod conditions;
mod input;
mod machine;
mod settings;

pub use input::{MachineInput, OperatorRequest};
pub(crate) use machine::CALM_MPS;
pub use machine::MachineState;
pub use settings::{Funnel, StateMachine};

/// Phase of a landing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Phase {
    /// Flying to the position above the pad.
    #[default]
    Approach,
    /// Hovering above the pad until the vehicle has been ready for `settle_s`.
    Hold,
    /// Ready; waiting for the planner.
    Wait,
    /// Descending, ready to abort.
    Descend,
    /// Too low to abort for a lost tag.
    Commit,
    /// Probably on the deck; the thrust decreases.
    Touchdown,
    /// Rotors off.
    Disarmed,
    /// Climbing away.
    GoAround,
    /// The landing is given up; the vehicle holds its position.
    GivenUp,
}

/// Reason why a landing was interrupted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Reason {
    /// The operator's request.
    Operator,
    /// A number is not finite.
    NotFinite,
    /// The estimator has diverged.
    Diverged,
    /// The IMU's last sample is too old.
    ImuStale,
    /// The range finder's last sample is too old.
    RangeStale,
    /// The last detection of the tag is too old.
    TagLost,
    /// Tilted too far.
    Tilt,
    /// Too far from the axis above the pad.
    LateralError,
    /// The closing speed to the deck is too high.
    ClosingSpeed,
    /// The demand exceeds what the rotors give.
    Saturated,
    /// The deck moves or tilts too much, or its motion is not known.
    Deck,
    /// The wind pushes harder than friction holds on the deck.
    Wind,
    /// The battery is low.
    BatteryLow,
    /// Not at the hold height.
    Height,
    /// Moving too fast relative to the deck to begin a descent.
    Unsteady,
    /// A time limit is exceeded.
    Late,
    /// The thrust was reduced, but nothing carries the vehicle.
    NotSupported,
    /// The vehicle left the deck again.
    Bounce,
}

/// Frame of a hover.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Frame {
    /// Above the pad, following the deck.
    Deck,
    /// At the vehicle's position; the estimate of the deck is not used.
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
        /// Frame of the hover: the deck's or the world's.
        frame: Frame,
    },
    /// The planned descent.
    Descend,
    /// The planned descent, with the horizontal estimate that is available.
    Commit,
    /// Climb away from the deck, with the IMU alone if necessary.
    ClimbAway,
    /// Reduce the thrust.
    Idle,
    /// Keep the thrust.
    Rest,
    /// Rotors off.
    Disarm,
}

impl<R> Maneuver<R> {
    /// A flight that does not follow the deck.
    pub(crate) fn is_in_the_world(&self) -> bool {
        matches!(
            self,
            Self::ClimbAway
                | Self::Hover {
                    frame: Frame::World,
                    ..
                }
        )
    }
}

/// Output of a step of a [`StateMachine`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MachineOutput<R> {
    /// Phase of the landing.
    pub phase: Phase,
    /// The manoeuvre to fly.
    pub maneuver: Maneuver<R>,
    /// Reason why the landing was interrupted.
    pub reason: Option<Reason>,
    /// What keeps the vehicle in Approach or Hold; none in other phases.
    pub waits_for: Option<Reason>,
    /// Number of go-arounds, without those that the operator ordered.
    pub go_arounds: u8,
    /// The planner must not wait for a better moment.
    pub hurry: bool,
}
