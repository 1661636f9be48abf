//! One landing: vehicle, air, deck, sensors and delays around a controller.

mod hover;
mod scenario;

use serde::Serialize;
use touchdown_flight::touch::TouchClass;
use touchdown_flight::types::{Command, Measurement};

use crate::STEP_S;
use crate::air::turbulence::Turbulence;
use crate::body::plant::{Plant, PlantSettings};
use crate::body::vertical::{VerticalState, VerticalVehicle};
use crate::deck::character::HEAVE;
use crate::deck::spline::MotionSpline;
use crate::deck::{DeckMotion, DeckPoint};
use crate::error::SimError;
use crate::landing::measured_deck::{check_length, measured_start_s};
use crate::random::{Purpose, Stream};
use crate::sensors::FlightSensorSettings;
use crate::sensors::history::History;

use hover::HoverWindow;

pub use hover::HOVER_WINDOW_S;
pub use scenario::{LandingScenario, NominalStart, SpreadSettings};

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The true height fell to the landed height, no faster than the crash speed.
    Landed,
    /// It fell there faster.
    Crashed,
    /// It had not by the timeout.
    TimedOut,
    /// The state stopped being finite or left the ceiling.
    Diverged,
}

impl Outcome {
    /// The name in tables and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Landed => "landed",
            Self::Crashed => "crashed",
            Self::TimedOut => "timed_out",
            Self::Diverged => "diverged",
        }
    }
}

/// Result of one landing trial, by the true state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Landing {
    /// Index of the trial.
    pub trial_index: u64,
    /// How it ended.
    pub outcome: Outcome,
    /// T_L: time of the first crossing of the landed height, also of a crash, s.
    pub t_l_s: Option<f64>,
    /// V_L: relative speed |v| there, m/s.
    pub v_l_mps: Option<f64>,
    /// S_L = ∫|v| dt to the end of the trial, m.
    pub s_l_m: f64,
    /// Height above the deck at the end, m.
    pub final_height_m: f64,
    /// Mean height over the last [`HOVER_WINDOW_S`] of a trial that timed out in a hover, m; absent where it still came
    /// down or climbed.
    pub hover_height_m: Option<f64>,
    /// The record, if asked for.
    pub trace: Option<LandingTrace>,
}

/// Record of a landing at the controller's ticks.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LandingTrace {
    /// Time since the start, s.
    pub time_s: Vec<f64>,
    /// True height above the deck z, m.
    pub height_m: Vec<f64>,
    /// True relative velocity v, m/s.
    pub relative_velocity_mps: Vec<f64>,
    /// Height of the deck z_p, m.
    pub deck_height_m: Vec<f64>,
    /// Height of the vehicle z_q, m.
    pub vehicle_height_m: Vec<f64>,
    /// Throttle commanded.
    pub throttle: Vec<f64>,
    /// Thrust commanded, N.
    pub commanded_thrust_n: Vec<f64>,
    /// True force beyond free-air thrust (ground effect and climb damping,
    /// without turbulence), N.
    pub ground_effect_n: Vec<f64>,
    /// The force that the controller counted on, N.
    pub ground_effect_estimate_n: Vec<f64>,
}

/// Everything true at one step.
#[derive(Clone, Copy)]
struct Snapshot {
    state: VerticalState,
    deck: DeckPoint,
    turbulence_n: f64,
}

impl Snapshot {
    fn height_m(&self) -> f64 {
        self.state.height_m - self.deck.height_m
    }

    fn relative_velocity_mps(&self) -> f64 {
        self.state.velocity_mps - self.deck.velocity_mps
    }
}

/// One vehicle of the scenario's spread.
struct Draw<'a> {
    thrust_scale_error: f64,
    ground_effect_scale: f64,
    deck: Deck<'a>,
    acceleration_bias_mps2: f64,
}

impl<'a> Draw<'a> {
    fn new(
        scenario: &LandingScenario,
        measured: Option<&'a MotionSpline>,
        trial_index: u64,
        seed: u64,
    ) -> Self {
        // All numbers are drawn always, so that one switch moves one of them.
        let mut stream = Stream::new(seed, trial_index, Purpose::Spread);
        let (thrust, scale, phase) = (stream.normal(), stream.uniform(), stream.uniform());
        let bias = stream.normal();
        let spread = &scenario.spread;
        let (low, high) = (
            spread.ground_effect_scale_min,
            spread.ground_effect_scale_max,
        );
        Self {
            thrust_scale_error: spread.thrust_scale_sd * thrust,
            ground_effect_scale: low + (high - low) * scale,
            deck: match measured {
                Some(motion) => Deck::Measured {
                    motion,
                    start_s: measured_start_s(motion, scenario.timeout_s, phase),
                },
                None if spread.deck_phase => {
                    Deck::Prescribed(scenario.deck.advanced(std::f64::consts::TAU * phase))
                }
                None => Deck::Prescribed(scenario.deck),
            },
            acceleration_bias_mps2: if scenario.noise {
                scenario.sensors.acceleration_bias_sd_mps2 * bias
            } else {
                0.0
            },
        }
    }
}

/// The deck of one landing.
enum Deck<'a> {
    Prescribed(DeckMotion),
    Measured {
        motion: &'a MotionSpline,
        /// Time of the motion at the start of the landing.
        start_s: f64,
    },
}

impl Deck<'_> {
    fn at(&self, time_s: f64) -> DeckPoint {
        match self {
            Self::Prescribed(motion) => motion.at(time_s),
            Self::Measured { motion, start_s } => {
                let now = motion.at(start_s + time_s);
                DeckPoint {
                    height_m: now.value[HEAVE],
                    velocity_mps: now.rate[HEAVE],
                }
            }
        }
    }
}

fn sense(
    vehicle: &VerticalVehicle,
    sensors: &FlightSensorSettings,
    bias_mps2: f64,
    seen: &Snapshot,
    stream: &mut Stream,
) -> Measurement<f64> {
    let acceleration = vehicle.acceleration_mps2(&seen.state, seen.deck, seen.turbulence_n);
    Measurement {
        height_m: seen.height_m() + sensors.height_sd_m * stream.normal(),
        relative_velocity_mps: seen.relative_velocity_mps()
            + sensors.relative_velocity_sd_mps * stream.normal(),
        vehicle_velocity_mps: seen.state.velocity_mps
            + sensors.vehicle_velocity_sd_mps * stream.normal(),
        acceleration_mps2: acceleration
            + bias_mps2
            + sensors.acceleration_sd_mps2 * stream.normal(),
    }
}

fn steps_of(time_s: f64) -> usize {
    (time_s / STEP_S).round() as usize
}

/// A landing while it is flown.
struct Flight<'a> {
    scenario: &'a LandingScenario,
    draw: Draw<'a>,
    plant: Plant,
    vehicle: VerticalVehicle,
    sensors: FlightSensorSettings,
    sensor_stream: Stream,
    turbulence: Option<Turbulence>,
    now: Snapshot,
    /// Snapshots over the latency of the sensors.
    past: History<Snapshot>,
    /// Age of a measurement in steps.
    latency_steps: usize,
    rest_throttle: f64,
    control_steps: usize,
    /// The throttles of all control periods so far.
    commands: Vec<f64>,
    trace: Option<LandingTrace>,
    path_m: f64,
}

impl<'a> Flight<'a> {
    fn new(
        scenario: &'a LandingScenario,
        measured: Option<&'a MotionSpline>,
        trial_index: u64,
        seed: u64,
        record: bool,
    ) -> Result<Self, SimError> {
        scenario.validate()?;
        if let Some(motion) = measured {
            check_length(motion, scenario.timeout_s)?;
        }
        let draw = Draw::new(scenario, measured, trial_index, seed);
        let plant = Plant::new(&PlantSettings {
            ground_effect_scale: scenario.plant.ground_effect_scale * draw.ground_effect_scale,
            ..scenario.plant
        })?;
        let vehicle = VerticalVehicle::new(plant, scenario.plant.mass_kg, draw.thrust_scale_error);
        let sensors = if scenario.noise {
            scenario.sensors
        } else {
            scenario.sensors.without_noise()
        };
        let latency_steps = steps_of(sensors.latency_s);
        let deck = draw.deck.at(0.0);
        let (state, rest_throttle) = vehicle.balanced(scenario.start_height_m, deck);
        let turbulence = scenario.noise.then(|| {
            let stream = Stream::new(seed, trial_index, Purpose::Turbulence);
            let sd_n = plant.turbulence_sd_n(&state.plant, scenario.start_height_m);
            Turbulence::new(stream, plant.turbulence_correlation_s(), STEP_S, sd_n)
        });
        let now = Snapshot {
            state,
            deck,
            turbulence_n: turbulence.as_ref().map_or(0.0, Turbulence::value_n),
        };
        Ok(Self {
            scenario,
            draw,
            plant,
            vehicle,
            sensors,
            sensor_stream: Stream::new(seed, trial_index, Purpose::Sensor),
            turbulence,
            now,
            past: History::new(latency_steps + 1, now),
            latency_steps,
            rest_throttle,
            control_steps: steps_of(scenario.control_period_s),
            commands: Vec::new(),
            trace: record.then(LandingTrace::default),
            path_m: 0.0,
        })
    }

    /// Measures, and calls the controller where a control period begins.
    fn control(
        &mut self,
        step: usize,
        controller: &mut dyn FnMut(&Measurement<f64>) -> Command<f64>,
    ) {
        self.past.push(self.now);
        if !step.is_multiple_of(self.control_steps) {
            return;
        }
        let measurement = sense(
            &self.vehicle,
            &self.sensors,
            self.draw.acceleration_bias_mps2,
            &self.past.at(self.latency_steps),
            &mut self.sensor_stream,
        );
        let command = controller(&measurement);
        let last = self.commands.last().copied();
        self.commands.push(if command.throttle.is_finite() {
            command.throttle.clamp(0.0, 1.0)
        } else {
            last.unwrap_or(self.rest_throttle)
        });
        if let Some(trace) = &mut self.trace {
            trace.push(step as f64 * STEP_S, &self.vehicle, &self.now, &command);
        }
    }

    /// One step of the vehicle; the outcome and, of a landing, time and speed of the crossing, where
    /// the trial ends in it.
    fn advance(&mut self, step: usize) -> Option<(Outcome, Option<(f64, f64)>)> {
        let throttle = match step.checked_sub(steps_of(self.scenario.command_delay_s)) {
            Some(sent) => self.commands[sent / self.control_steps],
            None => self.rest_throttle,
        };
        let (now, deck) = (self.now, &self.draw.deck);
        let t = step as f64 * STEP_S;
        let after = deck.at((step + 1) as f64 * STEP_S);
        let decks = [now.deck, deck.at(t + 0.5 * STEP_S), after];
        let mut next = now;
        self.vehicle
            .step(&mut next.state, &decks, throttle, now.turbulence_n, STEP_S);
        next.deck = after;
        if let Some(turbulence) = &mut self.turbulence {
            let sd_n = (self.plant).turbulence_sd_n(&now.state.plant, now.height_m());
            next.turbulence_n = turbulence.step(sd_n);
        }
        self.now = next;

        let (z0, z1) = (now.height_m(), next.height_m());
        let (v0, v1) = (now.relative_velocity_mps(), next.relative_velocity_mps());
        if !next.state.is_finite() || z1 > self.scenario.ceiling_m {
            return Some((Outcome::Diverged, None));
        }
        if z1 <= self.scenario.landed_height_m {
            let share = (z0 - self.scenario.landed_height_m) / (z0 - z1);
            let v = v0 + share * (v1 - v0);
            self.path_m += 0.5 * (v0.abs() + v.abs()) * share * STEP_S;
            let outcome = match TouchClass::of(-v, self.scenario.crash_speed_mps) {
                TouchClass::Soft | TouchClass::Hard => Outcome::Landed,
                TouchClass::Crash => Outcome::Crashed,
            };
            return Some((outcome, Some((t + share * STEP_S, v))));
        }
        self.path_m += 0.5 * (v0.abs() + v1.abs()) * STEP_S;
        None
    }
}

/// Flies one landing.
///
/// The vehicle starts at the start height above the deck, in relative rest with
/// it (v_q = v_p), thrust and ground effect in balance with its weight and the
/// air at rest. The controller is called once every control period, first at t = 0,
/// with a measurement that is `sensors.latency_s` old; its throttle reaches the
/// motors `command_delay_s` later. A throttle that is not finite leaves the last
/// one in place. Landing is judged by the true state, interpolated inside a step.
///
/// The result is a pure function of the scenario, the seed and the index, given
/// a controller that is a pure function as well.
///
/// # Errors
/// Those of [`LandingScenario::validate`].
pub fn land(
    scenario: &LandingScenario,
    trial_index: u64,
    seed: u64,
    controller: &mut dyn FnMut(&Measurement<f64>) -> Command<f64>,
    record: bool,
) -> Result<Landing, SimError> {
    land_on(scenario, None, trial_index, seed, controller, record)
}

/// As [`land`], on a deck that heaves as measured in place of the scenario's; each landing starts at a time of the motion
/// that is drawn.
///
/// # Errors
/// As of [`land`], and a motion that is shorter than a landing may take.
pub fn land_on(
    scenario: &LandingScenario,
    measured: Option<&MotionSpline>,
    trial_index: u64,
    seed: u64,
    controller: &mut dyn FnMut(&Measurement<f64>) -> Command<f64>,
    record: bool,
) -> Result<Landing, SimError> {
    let mut flight = Flight::new(scenario, measured, trial_index, seed, record)?;
    let steps = steps_of(scenario.timeout_s);
    let mut hover = HoverWindow::of(steps);
    let mut end = None;
    for step in 0..steps {
        flight.control(step, controller);
        end = flight.advance(step);
        if end.is_some() {
            break;
        }
        hover.push(step, flight.now.height_m());
    }
    let (outcome, crossing) = end.unwrap_or((Outcome::TimedOut, None));
    Ok(Landing {
        trial_index,
        outcome,
        t_l_s: crossing.map(|(time_s, _)| time_s),
        v_l_mps: crossing.map(|(_, speed_mps)| speed_mps.abs()),
        s_l_m: flight.path_m,
        final_height_m: flight.now.height_m(),
        hover_height_m: hover.height_m().filter(|_| outcome == Outcome::TimedOut),
        trace: flight.trace,
    })
}

impl LandingTrace {
    fn push(
        &mut self,
        time_s: f64,
        vehicle: &VerticalVehicle,
        now: &Snapshot,
        command: &Command<f64>,
    ) {
        self.time_s.push(time_s);
        self.height_m.push(now.height_m());
        self.relative_velocity_mps.push(now.relative_velocity_mps());
        self.deck_height_m.push(now.deck.height_m);
        self.vehicle_height_m.push(now.state.height_m);
        self.throttle.push(command.throttle);
        self.commanded_thrust_n.push(command.thrust_n);
        let force = vehicle.force(&now.state, now.deck);
        self.ground_effect_n.push(force.ground_effect_n);
        self.ground_effect_estimate_n.push(command.ground_effect_n);
    }
}
