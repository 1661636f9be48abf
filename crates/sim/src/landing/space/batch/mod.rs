//! Landings in SIMD lanes: many at once on one core, with ideal sensors.
//!
//! ```text
//! deck, wind ─> vehicles (1 kHz, one per lane) ─> truth ─> controller (100 Hz) ─> cascade (500 Hz) ─> throttles
//! ```
//!
//! Vehicle, legs, attitude control and the deck's splines are computed for as many
//! landings at once as a vector of the processor holds (eight with AVX-512, four with
//! AVX2, else one), by the same code that flies a single landing. The [`SpaceController`] of the landing
//! computer is stepped for each. A batch has no sensors, estimators, planner or state machine, which a
//! [`SpaceLander`] has. The descent begins at once, from relative
//! rest, and the rotors stop at the first touch.
//!
//! A landing is a function of scenario, seed and index: bit for bit the same whatever
//! processor it is flown on, whatever lanes fly beside it, and however trials are
//! divided among calls ([`Batch::land`], [`Batch::land_one`]).
//!
//! Decks are splines with knots every 0.1 s. Their error is `(ω 0.1 s)⁶/46 080` of the amplitude:
//! 2e-8 at 0.5 Hz and 1e-6 at 1 Hz. A deck is refused where the error exceeds 1e-4 of the sum of a
//! coordinate's waves (a tone above 2 Hz).
//!
//! Each step holds constant the values that
//! [`RigidVehicle::step`](crate::body::rigid::RigidVehicle::step) holds. Each rotor's share ρ of the
//! plate and its upwash P ρ change slowly. They are recomputed every ten steps, at the position that
//! the velocity predicts for the middle of those steps. Compared with shares of every step, this moves
//! a vehicle up to its touchdown by 7 µm. (That is the median of 200 landings each on the paper's deck,
//! with turbulence and without, and at sea; 97 % move by less than 25 µm.) V_L moves by less than
//! 0.6 mm/s and T_L by less than 2 ms. One in 600 landings moved by 8 ms and 0.3 mm, because the
//! controller froze its estimates one control period earlier. Half the steps give half the error.
//! `cargo test -p touchdown-sim --lib shares_held` flies such pairs.

mod air;
mod commanded;
mod control;
mod engine;
mod lane_flight;
mod lane_state;

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
use touchdown_flight::reference::{Reference, Terminal};
use touchdown_lander::computer::Descent;
use touchdown_lander::guidance::Guidance;
use touchdown_lander::space_controller::SpaceController;

use super::computer::cannot_be_flown;
use super::landing::SpaceLander;
use super::outcome::SpaceLanding;
use crate::STEP_S;
use crate::body::contact::Legs;
use crate::check;
use crate::deck::rigid::{RigidDeck, RigidMotion};
use crate::error::SimError;
use crate::number::lanes::Lanes;
use crate::sensors::suite::steps;
pub use commanded::{Commanded, LaneEnd};
use engine::Engine;

/// Steps of the integration between two knots of a deck's spline. Trials begin at
/// knots, so that all lanes come to theirs together.
const KNOT_STEPS: u64 = 100;

/// Steps over which the rotors' shares of the plate are held; divides [`KNOT_STEPS`].
const HELD_STEPS: u64 = 10;

/// Largest error of a deck's spline, relative to the amplitude of its waves.
const MOST_OFF: f64 = 1e-4;

/// A scenario whose trials are flown by the lane.
#[derive(Clone, Debug)]
pub struct Batch {
    lander: SpaceLander,
    legs: Legs,
    controller: SpaceController<f64>,
    guidance: Guidance<f64>,
    reference: Reference<f64>,
    steps: Steps,
}

/// Times of a scenario, in steps of the integration.
#[derive(Clone, Copy, Debug)]
struct Steps {
    control: u64,
    cascade: u64,
    command_delay: u64,
    watch: u64,
    timeout: u64,
    /// For how long the rotors' shares of the plate are held: [`HELD_STEPS`].
    held: u64,
}

impl Batch {
    /// Takes a scenario: its vehicle, deck, wind, turbulence, spread and controller.
    ///
    /// # Errors
    /// Those of [`SpaceLander::new`]; faults, an airwake, decks that are neither still nor waves or too
    /// fast for their splines, and periods of the control that do not divide 0.1 s are named.
    pub fn new(scenario: &super::SpaceScenario) -> Result<Self, SimError> {
        let lander = SpaceLander::new(scenario)?;
        if matches!(scenario.deck, RigidMotion::Triangle { .. }) {
            let expected = "`still`, `sines` or `sea`, which have splines";
            return Err(check::fail("deck.kind", expected, &"triangle"));
        }
        if scenario.course.is_set() {
            let expected = "none: the deck of a batch is not under way, and its bow has the direction of the x axis";
            return Err(check::fail("course", expected, &"a course"));
        }
        let off = spline_off(&lander.deck_of(0, 0, 0.0, None)?.0);
        check::that(
            off <= MOST_OFF,
            "deck",
            "waves of which knots every 0.1 s miss at most 1e-4 (a tone of up to 2 Hz)",
            off,
        )?;
        for (key, period_s) in [
            ("control_period_s", scenario.control_period_s),
            ("cascade.period_s", scenario.cascade.period_s),
        ] {
            check::that(
                KNOT_STEPS.is_multiple_of(steps(period_s) as u64),
                key,
                "a period that divides 0.1 s",
                period_s,
            )?;
        }
        if let Some((fault, found)) = scenario.faults.first() {
            let key = format!("faults.{fault}");
            let expected = "none: sensors are ideal, and all lanes have the same air";
            return Err(check::fail(&key, expected, &found));
        }
        if scenario.wind.airwake.is_some() {
            let expected = "none: all lanes have the same air at every height";
            return Err(check::fail("wind.airwake", expected, &"an airwake"));
        }
        // The truth has no age.
        let mut controller = lander.computer.controller;
        (controller.delays.sensing_s, controller.delays.attitude_s) = (0.0, 0.0);
        controller
            .validate()
            .map_err(|error| cannot_be_flown(&error))?;
        let reference = match &lander.computer.descent {
            Descent::Straight(reference) => *reference,
            Descent::Planned(planner) => Reference::Terminal(Terminal {
                start_height_m: scenario.start_m[2],
                end_height_m: planner.descent.end_height_m,
                sink_rate_mps: scenario.control.terminal_sink_mps,
                duration_s: scenario.control.terminal_s,
            }),
        };
        Ok(Self {
            guidance: lander.computer.guidance,
            legs: Legs::new(&scenario.legs, &scenario.plant)?,
            lander,
            controller,
            reference,
            steps: Steps {
                control: steps(scenario.control_period_s) as u64,
                cascade: steps(scenario.cascade.period_s) as u64,
                command_delay: steps(scenario.command_delay_s) as u64,
                watch: steps(scenario.watch_s) as u64,
                timeout: steps(scenario.timeout_s) as u64,
                held: HELD_STEPS,
            },
        })
    }

    /// Flies trials of a seed, in lanes; results are in the order of the trials.
    ///
    /// # Errors
    /// None that [`Self::new`] has not found.
    pub fn land(&self, trials: Range<u64>, seed: u64) -> Result<Vec<SpaceLanding>, SimError> {
        Arch::new().dispatch(BatchRun {
            batch: self,
            trials,
            seed,
        })
    }

    /// Flies one trial alone; the result is that of [`Self::land`].
    ///
    /// # Errors
    /// None that [`Self::new`] has not found.
    pub fn land_one(&self, trial: u64, seed: u64) -> Result<SpaceLanding, SimError> {
        let mut landings = Engine::new(self, trial..trial + 1, seed, 0.0).run(self)?;
        Ok(landings.swap_remove(0))
    }

    /// The deck of a trial and the time at which the trial starts in it.
    fn deck(&self, trial: u64, seed: u64, phase: f64) -> Result<(RigidDeck, f64), SimError> {
        self.lander.deck_of(trial, seed, phase, None)
    }
}

/// How far a deck's spline is off at most, as a share of the waves' amplitudes.
fn spline_off(deck: &RigidDeck) -> f64 {
    let RigidDeck::Harmonics(harmonics) = deck else {
        return 0.0;
    };
    let knot_s = KNOT_STEPS as f64 * STEP_S;
    let of_axis = |axis: usize| {
        let (mut all, mut off) = (0.0, 0.0);
        for wave in harmonics {
            let amplitude = wave.cosine[axis].hypot(wave.sine[axis]);
            all += amplitude;
            off += amplitude * (wave.angular_frequency * knot_s).powi(6) / 46_080.0;
        }
        if all > 0.0 { off / all } else { 0.0 }
    };
    (0..5).map(of_axis).fold(0.0, f64::max)
}

/// What is dispatched to the processor's vectors.
struct BatchRun<'a> {
    batch: &'a Batch,
    trials: Range<u64>,
    seed: u64,
}

impl WithSimd for BatchRun<'_> {
    type Output = Result<Vec<SpaceLanding>, SimError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let like = Lanes::splat(simd, 0.0);
        Engine::new(self.batch, self.trials, self.seed, like).run(self.batch)
    }
}
