//! A checked scenario, and its landings.

use super::belief::TruthSettings;
use super::computer::computer;
use super::flight::{Flight, StepHook};
use super::outcome::{SpaceLanding, SpaceOutcome};
use super::policy::{Pilot, Policy};
use super::scenario::SpaceScenario;
use super::track::Track;
use crate::sensors::CameraMode;
use crate::sensors::suite::steps;
use touchdown_lander::computer::Computer;

use crate::STEP_S;
use crate::air::ground::DeckSurface;
use crate::body::cascade::Cascade;
use crate::body::rigid::RigidVehicle;
use crate::check;
use crate::deck::course::Course;
use crate::deck::rigid::{RigidDeck, RigidMotion};
use crate::deck::wave::Spectrum;
use crate::error::SimError;
use crate::landing::measured_deck::{check_length, measured_start_s};
use crate::sensors::camera::fast::FastCamera;
use crate::sensors::camera::pipeline::{CameraPipeline, PipelineFactory};

/// A scenario that has been checked, ready to land.
#[derive(Clone, Debug)]
pub struct SpaceLander {
    pub(super) scenario: SpaceScenario,
    pub(super) computer: Computer<f64>,
    pub(super) vehicle: RigidVehicle,
    pub(super) cascade: Cascade,
    pub(super) camera: FastCamera,
    /// Builds renderer and detector for rendered images.
    pub(super) pipelines: Option<PipelineFactory>,
    pub(super) half_side_m: Option<f64>,
    /// The sea's spectrum.
    spectrum: Option<Spectrum>,
    /// A measured motion in place of the scenario's.
    pub(super) deck: Option<RigidDeck>,
    /// What flies the descents in the place of the computer's controller.
    pub(super) policy: Option<Policy>,
}

/// Flies one landing of a scenario: a pure function of scenario, seed and index.
///
/// # Errors
/// Those of [`SpaceLander::new`].
pub fn land(scenario: &SpaceScenario, trial: u64, seed: u64) -> Result<SpaceLanding, SimError> {
    SpaceLander::new(scenario)?.land(trial, seed, false)
}

impl SpaceLander {
    /// Checks a scenario.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and what was found.
    pub fn new(scenario: &SpaceScenario) -> Result<Self, SimError> {
        let of_truth = scenario.truth != TruthSettings::default();
        Self::of_resolved(&scenario.resolved()?).map_err(|error| {
            let stated = SpaceScenario {
                truth: TruthSettings::default(),
                ..scenario.clone()
            };
            match of_truth {
                true => Self::new(&stated)
                    .err()
                    .unwrap_or_else(|| scenario.of_truth(error)),
                false => error,
            }
        })
    }

    /// The lander of a scenario whose vehicle is the true one.
    fn of_resolved(scenario: &SpaceScenario) -> Result<Self, SimError> {
        let vehicle = RigidVehicle::new(&scenario.plant, &scenario.body)?
            .with_legs(&scenario.legs, &scenario.plant)?;
        scenario.check()?;
        let cascade = Cascade::new(&scenario.cascade, &scenario.believed_vehicle()?)
            .map_err(|error| error.in_section("cascade"))?;
        scenario
            .deck
            .validate()
            .map_err(|error| error.in_section("deck"))?;
        scenario
            .course
            .validate()
            .map_err(|error| error.in_section("course"))?;
        let half_side_m = DeckSurface::new(&scenario.plant.wake())?.half_side_m();
        let camera = scenario
            .sensors
            .tag
            .fast(half_side_m.map(|half| 2.0 * half), scenario.sensors.camera)
            .map_err(|error| error.in_section("sensors.tag"))?;
        let computer = computer(scenario)?;
        Ok(Self {
            scenario: scenario.clone(),
            computer,
            vehicle,
            cascade,
            camera,
            pipelines: None,
            half_side_m,
            spectrum: match &scenario.deck {
                RigidMotion::Sea(sea) => Some(sea.spectrum(scenario.plant.gravity_mps2)?),
                _ => None,
            },
            deck: None,
            policy: None,
        })
    }

    /// The same landings on a measured deck. Each starts at a random time of the series or, without a spread
    /// of the deck's phase, at its start.
    ///
    /// # Errors
    /// The series must be longer than a landing may take.
    pub fn with_deck(mut self, deck: RigidDeck) -> Result<Self, SimError> {
        if let RigidDeck::Spline(spline) = &deck {
            check_length(spline, self.scenario.timeout_s)?;
        }
        self.deck = Some(deck);
        Ok(self)
    }

    /// The same landings with descents flown by a policy, which sees what the landing computer estimates.
    ///
    /// # Errors
    /// A time between decisions that is no multiple of the computer's period.
    pub fn with_policy(mut self, policy: Policy) -> Result<Self, SimError> {
        let period_s = self.scenario.control_period_s;
        let periods = policy.settings().decision_s / period_s;
        check::that(
            periods > 0.5 && (periods - periods.round()).abs() < 1e-6,
            "policy.decision_s",
            &format!("a multiple of the landing computer's period, {period_s} s"),
            policy.settings().decision_s,
        )?;
        self.policy = Some(policy);
        Ok(self)
    }

    /// The same landings with renderers and detectors from `pipelines`, where the scenario asks for
    /// rendered images.
    ///
    /// # Errors
    /// Settings of the camera or the tags that they cannot work with.
    pub fn with_camera_pipelines(mut self, pipelines: PipelineFactory) -> Result<Self, SimError> {
        self.pipelines = Some(pipelines);
        self.camera_pipeline().map(drop)?;
        Ok(self)
    }

    /// The policy at the start of a landing, if one flies.
    pub(super) fn pilot(&self) -> Option<Pilot<'_>> {
        let period_s = self.scenario.control_period_s;
        let policy = self.policy.as_ref()?;
        Some(Pilot::new(policy, &self.computer, period_s))
    }

    /// The renderer and detector of a landing; none in the fast mode.
    pub(super) fn camera_pipeline(&self) -> Result<Option<Box<dyn CameraPipeline>>, SimError> {
        let sensors = &self.scenario.sensors;
        match (sensors.camera, &self.pipelines) {
            (CameraMode::Fast, _) => Ok(None),
            (CameraMode::Rendered, Some(pipelines)) => pipelines
                .build(&sensors.tag, self.half_side_m.map(|half| 2.0 * half))
                .map(Some)
                .map_err(|error| error.in_section("sensors.tag")),
            (CameraMode::Rendered, None) => Err(SimError::Setting {
                key: "sensors.camera".to_owned(),
                expected: "`fast`, for there is no detector here".to_owned(),
                found: "rendered".to_owned(),
            }),
        }
    }

    /// The scenario that is flown, with the true vehicle and the complete belief.
    #[must_use]
    pub fn scenario(&self) -> &SpaceScenario {
        &self.scenario
    }

    /// The landing computer that flies.
    #[must_use]
    pub fn computer(&self) -> &Computer<f64> {
        &self.computer
    }

    /// Whether the reference point, at a place along the deck's axes, is over the deck and at or below the
    /// landed height.
    pub(super) fn has_come_down(&self, [x, y, z]: [f64; 3]) -> bool {
        let beside = |l: f64| x.abs() > l || y.abs() > l;
        z <= self.scenario.landed_height_m && !self.half_side_m.is_some_and(beside)
    }

    /// The deck of a trial from its start on.
    pub(super) fn track(&self, trial: u64, seed: u64, phase: f64) -> Result<Track, SimError> {
        let course = self.course(phase);
        // At rest a deck meets the waves as without a course: their directions are relative to the bow.
        let under_way = course
            .as_ref()
            .filter(|_| self.scenario.course.is_under_way());
        let (deck, shift_s) = self.deck_of(trial, seed, phase, under_way)?;
        Ok(Track::new(deck, shift_s).on_course(course))
    }

    /// The course of a deck under way, or turned at rest; its manoeuvres begin at a random phase.
    fn course(&self, phase: f64) -> Option<Course> {
        let scenario = &self.scenario;
        let phase = if scenario.spread.deck_phase {
            phase
        } else {
            0.0
        };
        let settings = &scenario.course;
        // A second more than the last step needs.
        let to_s = scenario.timeout_s + 1.0;
        settings.is_set().then(|| settings.course(to_s, phase))
    }

    /// The deck of a trial and the time at which the trial starts in it.
    pub(super) fn deck_of(
        &self,
        trial: u64,
        seed: u64,
        phase: f64,
        course: Option<&Course>,
    ) -> Result<(RigidDeck, f64), SimError> {
        let scenario = &self.scenario;
        let gravity_mps2 = scenario.plant.gravity_mps2;
        let deck = match (&self.deck, &scenario.deck, &self.spectrum) {
            (Some(deck), _, _) => deck.clone(),
            (None, RigidMotion::Sea(sea), Some(spectrum)) if let Some(course) = course => {
                let to_s = scenario.timeout_s + 1.0;
                sea.waves_along(spectrum, gravity_mps2, (seed, trial), course, to_s)
            }
            (None, RigidMotion::Sea(sea), Some(spectrum)) => {
                sea.waves(spectrum, gravity_mps2, seed, trial)
            }
            (None, motion, _) => motion.build(gravity_mps2, seed, trial)?,
        };
        let random_waves = self.deck.is_none() && matches!(scenario.deck, RigidMotion::Sea(_));
        let phase = if scenario.spread.deck_phase {
            phase
        } else {
            0.0
        };
        let shift_s = match &deck {
            // Every trial has different waves.
            _ if random_waves => 0.0,
            RigidDeck::Spline(spline) => measured_start_s(spline, scenario.timeout_s, phase),
            // Far more than any period of the deck's motion.
            _ => 1000.0 * phase,
        };
        Ok((deck, shift_s))
    }

    /// Flies one landing: a pure function of scenario, seed and index.
    ///
    /// The vehicle starts in relative rest with the deck, forces in balance. It has
    /// landed when the computer has stopped the rotors and the vehicle then stands on the
    /// deck.
    ///
    /// # Errors
    /// Rendered images without a pipeline. [`Self::new`] finds all other errors.
    pub fn land(&self, trial: u64, seed: u64, record: bool) -> Result<SpaceLanding, SimError> {
        self.finish(Flight::new(self, trial, seed, record)?)
    }

    /// [`Self::land`] with a hook in each step of the landing computer: it records the
    /// readings, or lets another computer fly, such as one in single precision.
    ///
    /// # Errors
    /// As [`Self::land`].
    pub fn land_with(
        &self,
        trial: u64,
        seed: u64,
        record: bool,
        hook: StepHook<'_>,
    ) -> Result<SpaceLanding, SimError> {
        let mut flight = Flight::new(self, trial, seed, record)?;
        flight.hook = Some(hook);
        self.finish(flight)
    }

    /// Flies a landing to its end.
    fn finish(&self, mut flight: Flight<'_>) -> Result<SpaceLanding, SimError> {
        let last = steps(self.scenario.timeout_s) as u64;
        let mut outcome = None;
        for step in 0..last {
            outcome = flight.step(step)?;
            if outcome.is_some() {
                break;
            }
        }
        let mut landing = flight.landing;
        // Who gave up just before the end of the time gave up.
        let at_end = flight
            .gave_up
            .map_or(SpaceOutcome::TimedOut, |(_, reason)| {
                SpaceOutcome::GivenUp { reason }
            });
        landing.outcome = outcome.unwrap_or(at_end);
        landing.last_phase = Some(flight.phase);
        landing.waits_for = flight.waits.longest(flight.phase);
        landing.touch = flight.descending.and_then(|descending| descending.touch);
        landing.before_descent_s = flight
            .descending
            .map(|descending| descending.since as f64 * STEP_S);
        flight.touching.enter(&mut landing);
        landing.end_s = landing.steps as f64 * STEP_S;
        Ok(landing)
    }
}
