//! The landing computer: readings of the sensors in, thrust and attitude out.
//!
//! ```text
//! IMU, range, tag, GNSS, barometer ─> relative estimator ─┬─> deck estimator ─> planner ─┐
//!                                            │            │                              v
//!                                            └── health ──┴──────────> state machine ─> guidance ─> controller
//! ```
//!
//! What is put together here, beyond the parts:
//!
//! * **Deck heights** that the relative estimator reads off range and tag have
//!   different ages; they wait until all are `deck.delay_s` old, so that the deck
//!   estimator gets them evenly late. Where they come later than that, the estimator
//!   falls behind by as much, and predicts farther.
//! * **The deck's band**: once harmonics are known, the relative estimator expects heave
//!   around their mean frequency, of their power, in a band as wide as they are
//!   apart and uncertain; before, what its settings say. Phases are not handed on: an
//!   estimator that is told what to expect by one that listens to it ends up
//!   believing itself.
//! * **A descent begins** only after the deck has been seen for `watch_s`
//!   ([`DeckEstimatorState::observed_s`]). The planner's patience is that of all waiting
//!   since the approach, however often it was interrupted.
//! * **The deck's normal** follows what the camera sees of it with the time constant
//!   `normal_filter_s`; the largest tilt seen fades with `tilt_memory_s`.
//! * **The deck's speed**, by which the state machine judges it, is that of all its
//!   harmonics at once, before any is known two standard deviations of what was seen,
//!   and not less than the estimated one of now. It is infinite before the deck was seen.
//! * **Position and velocity** are predicted by `lead_s` (the age of the IMU) to now;
//!   the deck's acceleration to when the rotors will act ([`Guidance::acting_s`]).
//! * **An estimate is known** once the standard deviations of place and velocity relative
//!   to the deck are below `known_sd_m` and `known_sd_mps`. Until then the vehicle hovers
//!   level at the thrust of its weight
//!   (once it has been in control, only while its own velocity is not known either),
//!   and the state machine is told that the estimator has diverged, as it is when
//!   readings and expectations part. Models of rotors and ground effect go on meanwhile.
//!   An estimator that stays apart from its readings for `restart_s` begins anew; if it
//!   knew the vehicle's own velocity, with that, to half of `known_sd_mps`, so that a
//!   go-around goes on climbing. If that does not bring them together, all is forgotten.
//!   Without satellites the vehicle's own horizontal velocity gets less and less certain;
//!   it takes none to land. Beyond `known_sd_mps` the deck counts as at rest horizontally:
//!   a climb away from it goes up from where it is.
//! * **Observer and adaptation** stand still below `contact_height_m`: the legs'
//!   force is no lift.

mod known;
mod sightings;
mod step;

use sightings::Sightings;

use crate::estimate::deck::{DeckEstimator, DeckEstimatorState, DeckMotionPrediction};
use crate::estimate::latency::{LatencyEstimator, LatencyState};
use crate::estimate::relative::{
    Health, ImuSample, Reading, RelativeEstimate, RelativeFilter, RelativeState,
};
use crate::guidance::{Guidance, GuidanceState};
use crate::planner::{Plan, Planner, PlannerState};
use crate::space_controller::{SpaceCommand, SpaceController, SpaceControllerState, Target};
use crate::state_machine::{MachineOutput, MachineState, OperatorRequest, Phase, StateMachine};
use touchdown_flight::control::VerticalState;
use touchdown_flight::error::{SettingsError, not_negative, positive};
use touchdown_flight::ground_effect::{GroundEffect, Guarded};
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::Reference;
use touchdown_flight::space::Vector;

/// How a descent is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Descent<R> {
    /// The planner waits for a window and plans the descent.
    Planned(Planner<R>),
    /// Straight down by this reference (from wherever the hover is) as soon as the
    /// vehicle is ready.
    Straight(Reference<R>),
}

/// The landing computer; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: Real + serde::Serialize, G: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>, G: serde::Deserialize<'de>"
    ))
)]
pub struct Computer<R: Real, G = Guarded<R>> {
    /// Estimator of the vehicle relative to the deck.
    pub relative: RelativeFilter<R>,
    /// Estimator of a delay that readings do not tell, where one is used.
    pub latency: Option<LatencyEstimator<R>>,
    /// Estimator of the deck's heave, of displacements of the age `deck.delay_s`.
    pub deck: DeckEstimator<R>,
    /// How a descent is chosen.
    pub descent: Descent<R>,
    /// State machine.
    pub state_machine: StateMachine<R>,
    /// From what is to be flown to targets.
    pub guidance: Guidance<R>,
    /// The controller.
    pub controller: SpaceController<R, G>,
    /// Whether the deck's estimated acceleration is fed forward.
    pub deck_acceleration: bool,
    /// Age of the estimate that is made up for, s.
    pub lead_s: R,
    /// Standard deviation of the place on any axis below which it is known, m.
    pub known_sd_m: R,
    /// Standard deviation of the velocity on any axis below which it is known, m/s.
    pub known_sd_mps: R,
    /// Time apart from its readings after which the estimator begins anew, s.
    pub restart_s: R,
    /// Height below which observer and adaptation stand still, m.
    pub contact_height_m: R,
    /// Time for which the deck is seen before a descent, s.
    pub watch_s: R,
    /// Least heave velocity of a deck that moves, standard deviation, m/s.
    pub deck_known_mps: R,
    /// Least width of the band in which it is expected to, as a damping ratio.
    pub least_damping_ratio: R,
    /// Time constant of the deck's normal, s.
    pub normal_filter_s: R,
    /// Time constant with which the largest tilt of the deck fades, s.
    pub tilt_memory_s: R,
    /// Time between two looks of the planner, s.
    pub planner_period_s: R,
}

/// The deck's normal as the camera sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalReading<R> {
    /// The normal, camera axes.
    pub normal: Vector<R>,
    /// Age, s.
    pub age_s: R,
}

/// What has been sensed by the beginning of a step.
#[derive(Clone, Copy, Debug)]
pub struct Sensed<'a, R: Real> {
    /// The IMU since the last step.
    pub imu: ImuSample<R>,
    /// Readings that have arrived since the last step. The deck's normal in ranges is
    /// filled in.
    pub readings: &'a [Reading<R>],
    /// The deck's normal, where the camera has seen it.
    pub deck_normal: Option<NormalReading<R>>,
    /// Energy left in the battery, share of 1.
    pub battery_share: R,
    /// Contact switch in the legs, where there is one.
    pub contact: Option<bool>,
    /// What the operator wants.
    pub request: OperatorRequest,
}

/// State of a [`Computer`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputerState<R: Real, S> {
    relative: RelativeState<R>,
    latency: LatencyState<R>,
    /// Time since it changed, s.
    mistimed_s: R,
    deck: DeckEstimatorState<R>,
    sightings: Sightings<R>,
    planner: PlannerState<R>,
    since_plan_s: R,
    state_machine: MachineState<R>,
    guidance: GuidanceState<R>,
    controller: Option<SpaceControllerState<R, S>>,
    hover_throttle: R,
    normal: Vector<R>,
    /// Time since the normal was seen, s.
    normal_age_s: R,
    tilt_rad: R,
    apart_s: R,
    /// The estimator began anew with the velocity it had, and is not known again yet.
    carried_over: bool,
    hurry: bool,
    command: SpaceCommand<R>,
}

/// What a step of a [`Computer`] gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputerOutput<R: Real> {
    /// Thrust and attitude; none for rotors off.
    pub command: Option<SpaceCommand<R>>,
    /// The state machine.
    pub state_machine: MachineOutput<R>,
    /// Place and motion now.
    pub estimate: RelativeEstimate<R>,
    /// How far it can be trusted.
    pub health: Health<R>,
    /// The deck now.
    pub deck: DeckMotionPrediction<R>,
    /// The descent that begins in this step, where it was planned.
    pub plan: Option<Plan<R>>,
    /// How much later readings come than their ages say, s.
    pub latency_s: R,
    /// Where the controller is to fly; none where it is not flying to a target.
    pub target: Option<Target<R>>,
    /// Force that no model explains, N.
    pub disturbance_n: Vector<R>,
}

impl<R: Real, G: GroundEffect<R>> Computer<R, G> {
    /// Checks all settings.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.relative.validate()?;
        if let Some(latency) = &self.latency {
            latency.validate()?;
        }
        self.deck.validate()?;
        match &self.descent {
            Descent::Planned(planner) => planner.validate()?,
            Descent::Straight(reference) => reference.validate()?,
        }
        self.state_machine.validate()?;
        self.guidance.validate()?;
        self.controller.validate()?;
        not_negative("computer.lead_s", self.lead_s)?;
        positive("computer.known_sd_m", self.known_sd_m)?;
        positive("computer.known_sd_mps", self.known_sd_mps)?;
        positive("computer.restart_s", self.restart_s)?;
        not_negative("computer.contact_height_m", self.contact_height_m)?;
        not_negative("computer.watch_s", self.watch_s)?;
        positive("computer.deck_known_mps", self.deck_known_mps)?;
        positive("computer.least_damping_ratio", self.least_damping_ratio)?;
        positive("computer.normal_filter_s", self.normal_filter_s)?;
        positive("computer.tilt_memory_s", self.tilt_memory_s)?;
        positive("computer.planner_period_s", self.planner_period_s)
    }

    /// The deck's heave `horizon_s` from now, as far as it is known.
    #[must_use]
    pub fn forecast(
        &self,
        state: &ComputerState<R, G::State>,
        horizon_s: R,
    ) -> DeckMotionPrediction<R> {
        self.deck_ahead(state, horizon_s)
    }

    /// The state at the start, in the air with rotors at rest at `throttle`.
    #[must_use]
    pub fn initial(&self, throttle: R) -> ComputerState<R, G::State> {
        ComputerState {
            relative: self.relative.initial(),
            latency: self.latency.unwrap_or_default().initial(),
            mistimed_s: r(f64::INFINITY),
            deck: self.deck.initial(),
            sightings: Sightings::default(),
            planner: PlannerState::default(),
            since_plan_s: self.planner_period_s,
            state_machine: self.state_machine.initial(),
            guidance: self.guidance.initial(),
            controller: None,
            hover_throttle: throttle,
            normal: Vector::UP,
            normal_age_s: R::ZERO,
            tilt_rad: R::ZERO,
            apart_s: R::ZERO,
            carried_over: false,
            hurry: false,
            command: SpaceCommand {
                thrust_n: self.controller.mass_kg * self.controller.gravity_mps2,
                ..SpaceCommand::default()
            },
        }
    }
}

impl<R: Real, S> ComputerState<R, S> {
    /// Where the landing is.
    pub fn phase(&self) -> Phase {
        self.state_machine.phase()
    }

    /// State of the vertical channel, once there is one.
    pub fn vertical(&self) -> Option<&VerticalState<R, S>> {
        self.controller
            .as_ref()
            .map(|controller| &controller.vertical)
    }
}
