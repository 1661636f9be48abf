//! The landing computer: readings of the sensors in, thrust and attitude out.
//!
//! ```text
//! IMU, range, tag, GNSS, barometer ─> relative estimator ─┬─> deck estimator ─> planner ─┐
//!                                            │            │                              v
//!                                            └── health ──┴──────────> state machine ─> guidance ─> controller
//! ```
//!
//! The computer adds these rules to its parts:
//!
//! * **Deck heights** from range and tag have different ages. They wait until all are
//!   `deck.delay_s` old, so that the deck estimator gets them with a constant age. If they
//!   arrive later, this age grows, and the deck estimator predicts farther ahead.
//! * **The deck's band.** Once harmonics are known, they set the prior of the relative
//!   estimator: its centre is their mean frequency, its power theirs, its width their
//!   spread and uncertainty. Before, the settings hold. Phases are not passed on: the deck
//!   estimator listens to the relative estimator, so the loop would confirm itself.
//! * **A descent begins** only after the deck has been observed for `watch_s`
//!   ([`DeckEstimatorState::observed_s`]). The planner's waiting time counts from the
//!   approach on, over all interruptions.
//! * **The deck's normal** follows the camera with the time constant `normal_filter_s`.
//!   The largest tilt fades with `tilt_memory_s`.
//! * **The deck's speed**, which the state machine limits, is the sum of all harmonics'
//!   greatest speeds, and at least the estimated speed. Before harmonics are known it is
//!   two standard deviations of the observed motion; before any reading it is infinite.
//! * **Position and velocity** are predicted to now, by the age of the estimate (`imu_latency_s`).
//!   The deck's acceleration is predicted to when the rotors act ([`Guidance::acting_s`]).
//! * **An estimate is known** if the standard deviations of position and velocity
//!   relative to the deck are below `known_sd_m` and `known_sd_mps`. Otherwise the state
//!   machine gets the same report as after a divergence. Until the estimate is first
//!   known, the vehicle keeps the attitude of the flight before at the thrust of its
//!   weight. If its own velocity is not known later, it balances the mean disturbance of the last 10 s, in the trim attitude that follows,
//!   level without wind. From 0.5 s on its own velocity suffices to climb away. After 0.3 s without
//!   the inertial unit it hovers as well, with a little more thrust at first, so that it
//!   rises. Models of rotors and ground effect run on.
//! * **A diverged estimator** restarts after `restart_s`. If it knew the vehicle's own
//!   velocity, it keeps that with half of `known_sd_mps` as its standard deviation, so
//!   that a go-around continues to climb. The next restart keeps nothing.
//! * **Without satellites** the vehicle's own horizontal velocity becomes uncertain; a
//!   landing does not need it. Beyond `known_sd_mps` the deck counts as at rest
//!   horizontally, so that a go-around climbs straight up.
//! * **The barometer** also counts near the deck, when the vehicle neither sees the deck nor knows how fast it climbs.
//! * **A deck under way** is followed in every phase ([`Computer::under_way`]): its horizontal acceleration is fed
//!   forward, and a flight in the world's frame keeps the deck's last known velocity.
//! * **A deck that is not below** is sought ([`Seek`]), if the settings say so.
//! * **The approach leans** into the wind by the trim's slope beyond 0.15, so that
//!   the pad stays in the middle of the camera's view and under the range finder's beam.
//! * **A rough sea raises the hover** by 1 m for each 1 m/s of the deck's greatest speed
//!   beyond 0.7 m/s, as it was within the last 30 s. The deck's horizontal acceleration is then estimated
//!   and fed forward, and a go-around climbs faster (`sea`).
//! * **Height of contact.** Near the deck a tilted vehicle is as low as its lowest foot
//!   ([`Feet`]). Contact, the end of a descent and `contact_height_m` go by that foot.
//! * **Observer and adaptation** pause below `contact_height_m`, because the legs' force
//!   is not lift.

mod feet;
mod known;
mod sea;
mod seek;
mod sightings;
mod steady;
mod step;
mod support;
#[cfg(test)]
mod tests;
mod weather;

pub use feet::Feet;
use sea::Sea;
pub use seek::Seek;
use seek::SeekState;
use sightings::Sightings;
use steady::Steady;
use support::Support;

use crate::check::{not_negative, positive};
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
use touchdown_flight::error::{SettingsError, within};
use touchdown_flight::ground_effect::{GroundEffect, Guarded};
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::Reference;
use touchdown_flight::space::{Attitude, Vector};

/// Choice of the descent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub enum Descent<R> {
    /// The planner waits for a window and plans the descent.
    Planned(Planner<R>),
    /// The descent follows this reference, from the height of the hover, as soon as the
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
    /// Estimator of an unknown latency, if one is used.
    pub latency: Option<LatencyEstimator<R>>,
    /// Estimator of the deck's heave, of displacements of the age `deck.delay_s`.
    pub deck: DeckEstimator<R>,
    /// Choice of the descent.
    pub descent: Descent<R>,
    /// State machine.
    pub state_machine: StateMachine<R>,
    /// Guidance, from manoeuvres to targets.
    pub guidance: Guidance<R>,
    /// The controller.
    pub controller: SpaceController<R, G>,
    /// Whether the deck's estimated acceleration is fed forward.
    pub deck_acceleration: bool,
    /// Whether the deck may be under way.
    #[cfg_attr(feature = "serde", serde(default))]
    pub under_way: bool,
    /// The flight to a deck that is not below; none hovers where the deck is lost.
    #[cfg_attr(feature = "serde", serde(default = "none"))]
    pub seek: Option<Seek<R>>,
    /// Latency of the IMU, by which the estimate is predicted to now, s.
    #[cfg_attr(feature = "serde", serde(rename = "lead_s"))]
    pub imu_latency_s: R,
    /// Largest standard deviation of a known position, on each axis, m.
    pub known_sd_m: R,
    /// Largest standard deviation of a known velocity, on each axis, m/s.
    pub known_sd_mps: R,
    /// Time after which a diverged estimator restarts, s.
    pub restart_s: R,
    /// The feet, whose lowest decides about contact.
    pub feet: Feet<R>,
    /// Height of the lowest foot, as that of a level vehicle's reference point, below which
    /// observer and adaptation pause, m.
    pub contact_height_m: R,
    /// Time for which the deck is observed before a descent, s.
    pub watch_s: R,
    /// Least heave velocity in the prior of a moving deck, standard deviation, m/s.
    pub deck_known_mps: R,
    /// Least bandwidth in that prior, as a damping ratio.
    pub least_damping_ratio: R,
    /// Time constant of the deck's normal, s.
    pub normal_filter_s: R,
    /// Time constant with which the largest tilt of the deck fades, s.
    pub tilt_memory_s: R,
    /// Time between two steps of the planner, s.
    pub planner_period_s: R,
}

/// Of recordings that do not have the key.
#[cfg(feature = "serde")]
fn none<T>() -> Option<T> {
    None
}

/// The deck's normal, measured by the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalReading<R> {
    /// The normal, camera axes.
    pub normal: Vector<R>,
    /// Age, s.
    pub age_s: R,
}

/// Input of a step: readings of the sensors and the operator's request.
#[derive(Clone, Copy, Debug)]
pub struct Sensed<'a, R: Real> {
    /// Sample of the IMU since the last step.
    pub imu: ImuSample<R>,
    /// Readings that have arrived since the last step. The computer replaces the deck's
    /// normal in ranges by its own.
    pub readings: &'a [Reading<R>],
    /// The deck's normal, if the camera has measured it.
    pub deck_normal: Option<NormalReading<R>>,
    /// Remaining energy of the battery, in [0, 1].
    pub battery_share: R,
    /// Contact switch in the legs, if there is one.
    pub contact: Option<bool>,
    /// The operator's request.
    pub request: OperatorRequest,
}

/// State of a [`Computer`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputerState<R: Real, S> {
    relative: RelativeState<R>,
    latency: LatencyState<R>,
    /// Time since the estimated latency changed, s.
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
    /// Time since the normal was measured, s.
    normal_age_s: R,
    tilt_rad: R,
    apart_s: R,
    /// The estimator restarted with its last velocity, and is not known again yet.
    carried_over: bool,
    hurry: bool,
    command: SpaceCommand<R>,
    support: Support<R>,
    /// Attitude of the flight before the first step, within the tilt limit.
    taken_over: Option<Attitude<R>>,
    /// Direction of thrust that holds the vehicle still in the wind, of this step.
    trim_up: Vector<R>,
    /// The barometer counts at any height.
    needs_barometer: bool,
    /// Images may be late by an unknown time.
    may_be_late: bool,
    /// [`Computer::wider`] at the last step.
    wider: R,
    /// Time since the start, s.
    flown_s: R,
    /// How rough the sea is.
    sea: Sea<R>,
    /// Horizontal way of the approach's axis per metre of height.
    lean: Vector<R>,
    /// Horizontal acceleration of a deck under way or in a rough sea, m/s².
    course_mps2: Vector<R>,
    seek: SeekState<R>,
    /// The disturbance while the vehicle knew its velocity.
    steady: Steady<R>,
    /// Time since the last value in it, s.
    unremembered_s: R,
}

/// Output of a step of a [`Computer`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputerOutput<R: Real> {
    /// Thrust and attitude; none for rotors off.
    pub command: Option<SpaceCommand<R>>,
    /// The state machine.
    pub state_machine: MachineOutput<R>,
    /// Present position and motion.
    pub estimate: RelativeEstimate<R>,
    /// State of the sensors and consistency of the estimate.
    pub health: Health<R>,
    /// Present motion of the deck.
    pub deck: DeckMotionPrediction<R>,
    /// The planned descent that begins in this step.
    pub plan: Option<Plan<R>>,
    /// Estimated latency of the readings beyond their stamped ages, s.
    pub latency_s: R,
    /// The controller's target; none if the manoeuvre has no target.
    pub target: Option<Target<R>>,
    /// Estimated disturbance: the force that no model explains, N.
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
            Descent::Planned(planner) => {
                planner.validate()?;
                within(
                    "lander.hold_height_m",
                    self.state_machine.hold_height_m,
                    self.state_machine.hold_height_m <= planner.reach_m(),
                    "a height from which a descent ends within `planner.horizon_s`",
                )?;
            }
            Descent::Straight(reference) => reference.validate()?,
        }
        self.state_machine.validate()?;
        if let Some(seek) = &self.seek {
            seek.validate()?;
        }
        self.guidance.validate()?;
        self.controller.validate()?;
        not_negative("computer.lead_s", self.imu_latency_s)?;
        positive("computer.known_sd_m", self.known_sd_m)?;
        positive("computer.known_sd_mps", self.known_sd_mps)?;
        positive("computer.restart_s", self.restart_s)?;
        self.feet.validate()?;
        not_negative("computer.contact_height_m", self.contact_height_m)?;
        not_negative("computer.watch_s", self.watch_s)?;
        positive("computer.deck_known_mps", self.deck_known_mps)?;
        positive("computer.least_damping_ratio", self.least_damping_ratio)?;
        positive("computer.normal_filter_s", self.normal_filter_s)?;
        positive("computer.tilt_memory_s", self.tilt_memory_s)?;
        positive("computer.planner_period_s", self.planner_period_s)
    }

    /// The predicted heave of the deck `horizon_s` from now.
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
        let mut state = ComputerState {
            relative: RelativeState::BLANK,
            latency: self.latency.unwrap_or_default().initial(),
            mistimed_s: r(f64::INFINITY),
            deck: self.deck.initial(),
            sightings: Sightings::default(),
            planner: PlannerState::default(),
            since_plan_s: R::ZERO,
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
            command: self.weight(),
            support: Support::default(),
            taken_over: None,
            trim_up: Vector::UP,
            needs_barometer: false,
            may_be_late: false,
            wider: R::ONE,
            steady: Steady::NONE,
            unremembered_s: R::ZERO,
            flown_s: R::ZERO,
            sea: Sea::default(),
            lean: Vector::ZERO,
            course_mps2: Vector::ZERO,
            seek: SeekState::default(),
        };
        let mut relative = self.relative;
        self.roughen(&state, &mut relative);
        relative.reset(&mut state.relative);
        state
    }

    /// Starts the landing again with the present estimates: planner, state machine,
    /// guidance and controller forget what they did. Called before every step, it keeps
    /// the integrals at zero while somebody else flies.
    pub fn restart_landing(&self, state: &mut ComputerState<R, G::State>) {
        state.planner.restart();
        state.since_plan_s = R::ZERO;
        state.state_machine = self.state_machine.initial();
        state.guidance = self.guidance.initial();
        state.controller = None;
        state.hurry = false;
        state.command = self.weight();
    }

    /// Another controller flies `command` in the place of the one that the last step returned. Called after every step in which
    /// that is so, it keeps estimates true to what is flown.
    pub fn replace_command(
        &self,
        state: &mut ComputerState<R, G::State>,
        command: &SpaceCommand<R>,
    ) {
        state.command = *command;
        if let Some(controller) = &mut state.controller {
            self.controller.replace(controller, command);
        }
    }

    /// The command before the first step: the weight as thrust.
    fn weight(&self) -> SpaceCommand<R> {
        SpaceCommand {
            thrust_n: self.controller.mass_kg * self.controller.gravity_mps2,
            ..SpaceCommand::default()
        }
    }
}

impl<R: Real, S> ComputerState<R, S> {
    /// The phase of the landing.
    pub fn phase(&self) -> Phase {
        self.state_machine.phase()
    }

    /// The deck's normal, as the camera has measured it so far.
    pub fn deck_normal(&self) -> Vector<R> {
        self.normal
    }

    /// State of the vertical channel; none before the controller has started.
    pub fn vertical(&self) -> Option<&VerticalState<R, S>> {
        self.controller
            .as_ref()
            .map(|controller| &controller.vertical)
    }

    /// The thrust that was asked for last, N, which a command leads; with the rotors off, that of the command.
    fn demand_n(&self) -> R {
        let controller = self.controller.as_ref();
        controller.map_or(self.command.thrust_n, |controller| controller.demand_n)
    }
}
