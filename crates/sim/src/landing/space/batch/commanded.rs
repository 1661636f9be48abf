//! Landings in SIMD lanes that follow commands from outside, decision by decision: what an environment for learning steps.
//!
//! ```text
//! outside: thrust, and attitude or rates (every few 20 ms) ─> delay ─> cascade (500 Hz) ─> vehicles (1 kHz) ─> truth ─> outside
//! ```
//!
//! Plant, cascade, delay of the command, deck, air, touch and judgement are those of [`Batch`]; only its controller is
//! replaced. A landing ends as a batched one does: rotors stop at the first touch, and the vehicle is watched for a while.

use pulp::{Arch, Simd, WithSimd};

use super::Batch;
use super::air::BLOCK_STEPS;
use super::engine::Engine;
use super::lane_flight::LaneFlight;
use crate::body::cascade::Setpoint;
use crate::check;
use crate::error::SimError;
use crate::landing::space::outcome::SpaceLanding;
use crate::landing::space::policy::{CommandKind, Observation};
use crate::number::lanes::Lanes;

/// A landing that has ended in its lane.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneEnd {
    /// Its place among the landings.
    pub place: usize,
    /// How it ended.
    pub landing: SpaceLanding,
    /// The true state at its end, as an observation.
    pub state: [f64; Observation::NUMBERS],
}

/// The same in a lane.
pub(super) struct Ended {
    pub(super) lane: usize,
    pub(super) landing: SpaceLanding,
    pub(super) state: [f64; Observation::NUMBERS],
}

/// Landings side by side that are commanded from outside. A place holds one landing at a time.
pub struct Commanded {
    batch: Batch,
    groups: Vec<Box<dyn Group>>,
    /// Landings of a group.
    lanes: usize,
    places: usize,
    steps: u64,
    kind: CommandKind,
}

impl std::fmt::Debug for Commanded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Commanded")
            .field("places", &self.places)
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

/// The landings of one vector of the processor.
trait Group: Send {
    fn begin(&mut self, batch: &Batch, lane: usize, trial: u64, seed: u64) -> Result<(), SimError>;

    /// Flies so many steps with a command for each lane, and gives the landings that have ended.
    fn fly(&mut self, batch: &Batch, commands: &[f64], steps: u64) -> Vec<Ended>;

    fn observe(&self, lane: usize) -> Observation;
}

impl Commanded {
    /// So many places over the scenario of a batch, with a decision every `decision_s`. All places are empty.
    ///
    /// # Errors
    /// A decision time that is no multiple of 20 ms, for which the air is drawn, or above 1 s, or no place.
    pub fn new(
        batch: Batch,
        kind: CommandKind,
        places: usize,
        decision_s: f64,
    ) -> Result<Self, SimError> {
        let steps = (decision_s / crate::STEP_S).round();
        check::that(
            (1.0..=1000.0).contains(&steps)
                && (steps as u64).is_multiple_of(BLOCK_STEPS)
                && (steps * crate::STEP_S - decision_s).abs() < 1e-9,
            "decision_s",
            "a multiple of 0.02 s, at most 1 s",
            decision_s,
        )?;
        check::that(places > 0, "places", "at least one", places as f64)?;
        let mut commanded = Self {
            batch,
            groups: Vec::new(),
            lanes: 1,
            places,
            steps: steps as u64,
            kind,
        };
        commanded.clear();
        Ok(commanded)
    }

    /// Empties all places. What begins next begins at a knot of its deck's spline: it is the same landing, to the bit, as in a new
    /// value.
    pub fn clear(&mut self) {
        self.groups.clear();
        while self.groups.len() * self.lanes < self.places {
            let (group, lanes) = Arch::new().dispatch(Make(&self.batch, self.kind));
            self.lanes = lanes;
            self.groups.push(group);
        }
    }

    /// What commands ask for.
    #[must_use]
    pub fn kind(&self) -> CommandKind {
        self.kind
    }

    /// Places.
    #[must_use]
    pub fn places(&self) -> usize {
        self.places
    }

    /// Steps of the integration (1 ms each) between two decisions.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The nominal weight of the vehicle, N.
    #[must_use]
    pub fn weight_n(&self) -> f64 {
        self.batch.lander.scenario.plant.weight_n()
    }

    /// Begins a trial of a seed at a place; a landing that is there ends unjudged.
    ///
    /// The start of the deck's motion, the vehicle and the air are those of the trial. Where the deck is between two knots of its
    /// spline depends on when the trial begins after [`Self::clear`]; see [`Batch`] for the spline's error.
    ///
    /// # Errors
    /// None that [`Batch::new`] has not found.
    pub fn begin(&mut self, place: usize, trial: u64, seed: u64) -> Result<(), SimError> {
        let (group, lane) = (place / self.lanes, place % self.lanes);
        self.groups[group].begin(&self.batch, lane, trial, seed)
    }

    /// Flies up to the next decision. `commands` holds [`CommandKind::numbers`] for each place; those of empty places and of
    /// vehicles whose rotors have stopped are passed over. A command that is not finite keeps the one before it.
    ///
    /// # Panics
    /// With fewer commands than places.
    pub fn fly(&mut self, commands: &[f64]) -> Vec<LaneEnd> {
        let numbers = self.kind.numbers();
        assert!(commands.len() >= self.places * numbers, "too few commands");
        let share = self.lanes * numbers;
        let mut ends = Vec::new();
        for (k, group) in self.groups.iter_mut().enumerate() {
            let last = commands.len().min((k + 1) * share);
            let of_group = group.fly(&self.batch, &commands[k * share..last], self.steps);
            ends.extend(of_group.into_iter().map(|ended| LaneEnd {
                place: k * self.lanes + ended.lane,
                landing: ended.landing,
                state: ended.state,
            }));
        }
        ends
    }

    /// Writes the numbers of an [`Observation`] for each place: the true state.
    ///
    /// # Panics
    /// With less room than that.
    pub fn observe(&self, out: &mut [f64]) {
        for (place, row) in out
            .chunks_exact_mut(Observation::NUMBERS)
            .take(self.places)
            .enumerate()
        {
            let seen = self.groups[place / self.lanes].observe(place % self.lanes);
            row.copy_from_slice(&seen.numbers());
        }
    }
}

/// Makes a group of as many lanes as the processor has.
struct Make<'a>(&'a Batch, CommandKind);

impl WithSimd for Make<'_> {
    type Output = (Box<dyn Group>, usize);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut engine = Engine::new(self.0, 0..0, 0, Lanes::splat(simd, 0.0));
        if self.1 == CommandKind::Rates {
            engine.follow_rates();
        }
        (Box::new(Side { simd, engine }), S::F64_LANES)
    }
}

/// Landings in the lanes of `S`.
struct Side<S: Simd> {
    simd: S,
    engine: Engine<Lanes<S>>,
}

impl<S: Simd> Group for Side<S> {
    fn begin(&mut self, batch: &Batch, lane: usize, trial: u64, seed: u64) -> Result<(), SimError> {
        let departure = LaneFlight::new(batch, trial, seed, self.engine.step())?;
        self.engine.begin(lane, departure);
        Ok(())
    }

    fn fly(&mut self, batch: &Batch, commands: &[f64], steps: u64) -> Vec<Ended> {
        self.simd.vectorize(Fly {
            engine: &mut self.engine,
            batch,
            commands,
            steps,
        })
    }

    fn observe(&self, lane: usize) -> Observation {
        self.engine.observe(lane)
    }
}

/// What is dispatched to the processor's vectors.
struct Fly<'a, S: Simd> {
    engine: &'a mut Engine<Lanes<S>>,
    batch: &'a Batch,
    commands: &'a [f64],
    steps: u64,
}

impl<S: Simd> WithSimd for Fly<'_, S> {
    type Output = Vec<Ended>;

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) -> Self::Output {
        self.engine.follow(self.batch, self.commands, self.steps)
    }
}

/// The setpoint with the commands of the lanes that have one.
pub(super) fn with_commands<N: crate::number::Number>(
    mut wanted: Setpoint<N>,
    commands: &[f64],
) -> Setpoint<N> {
    let kind = match wanted.body_rates {
        None => CommandKind::Attitude,
        Some(_) => CommandKind::Rates,
    };
    for (lane, command) in commands.chunks_exact(kind.numbers()).enumerate() {
        if !command.iter().all(|value| value.is_finite()) {
            continue;
        }
        wanted.thrust_n = wanted.thrust_n.with(lane, command[0].max(0.0));
        let turn: &mut [N] = match &mut wanted.body_rates {
            None => &mut wanted.attitude,
            Some(rates) => rates,
        };
        for (to, value) in turn.iter_mut().zip(&command[1..]) {
            *to = to.with(lane, *value);
        }
    }
    wanted
}
