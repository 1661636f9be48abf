//! The world and the vehicle during a landing, step by step.

use std::collections::VecDeque;

use touchdown_flight::ground_effect::{GroundEffect, Guarded};
use touchdown_lander::computer::{ComputerOutput, ComputerState, Sensed};
use touchdown_lander::state_machine::{OperatorRequest, Phase, Reason};

use super::faults::FaultClock;
use super::flight_log::FlightLog;
use super::landing::SpaceLander;
use super::outcome::{SpaceLanding, SpaceOutcome, SpaceTrace, Touch};
use super::policy::{Observation, Pilot};
use super::touchdown::TouchdownJudge;
use super::track::Track;
use super::trial::{TrialAir, TrialDraw, hover};
use super::waits::Waits;
use crate::STEP_S;
use crate::air::turbulence::RotorTurbulence;
use crate::air::wind::{GustSettings, Wind};
use crate::body::cascade::{AttitudeSetpoint, CascadeState};
use crate::body::rigid::{Disturbance, Loads, RigidState, RigidVehicle};
use crate::deck::rigid::DeckPose;
use crate::error::SimError;
use crate::number::vector::{add, scale};
use crate::random::{Purpose, Stream};
use crate::sensors::suite::{SensorSuite, Truth, nan_if, steps};

/// State of the landing computer that is simulated.
type ComputerMemory = ComputerState<f64, <Guarded<f64> as GroundEffect<f64>>::State>;

/// Sees the readings and `dt` of each step, and may replace what the landing computer returned.
pub type StepHook<'a> = &'a mut dyn FnMut(&Sensed<'_, f64>, f64, &mut ComputerOutput<f64>);

/// A command on its way to the attitude control.
#[derive(Clone, Copy)]
pub(super) struct PendingCommand {
    pub(super) arrives: u64,
    pub(super) setpoint: Option<AttitudeSetpoint>,
}

/// What is true of a descent so far.
#[derive(Clone, Copy)]
pub(super) struct Descent {
    pub(super) since: u64,
    pub(super) path_m: f64,
    pub(super) touch: Option<Touch>,
}

/// Everything that changes during a landing.
pub(super) struct Flight<'a> {
    pub(super) lander: &'a SpaceLander,
    pub(super) vehicle: RigidVehicle,
    pub(super) track: Track,
    pub(super) state: RigidState,
    pub(super) pose: DeckPose,
    pub(super) loads: Loads,
    pub(super) wind: Wind,
    pub(super) gusting: bool,
    pub(super) turbulence: Option<RotorTurbulence>,
    pub(super) disturbance: Disturbance,
    pub(super) sensors: SensorSuite,
    pub(super) brain: ComputerMemory,
    pub(super) hook: Option<StepHook<'a>>,
    pub(super) pilot: Option<Pilot<'a>>,
    /// Rates as the attitude control measured them last, rad/s.
    pub(super) measured_rates: [f64; 3],
    pub(super) sent: VecDeque<PendingCommand>,
    pub(super) setpoint: Option<AttitudeSetpoint>,
    pub(super) control: CascadeState,
    pub(super) throttle: [f64; 4],
    pub(super) touching: TouchdownJudge,
    pub(super) descending: Option<Descent>,
    pub(super) fault_start: Option<u64>,
    pub(super) weakened: bool,
    pub(super) phase: Phase,
    pub(super) waits: Waits,
    pub(super) stopped: Option<u64>,
    /// When the landing was given up, and why.
    pub(super) gave_up: Option<(u64, Option<Reason>)>,
    /// Noise of what is logged.
    pub(super) log_noise: Stream,
    pub(super) landing: SpaceLanding,
}

impl<'a> Flight<'a> {
    pub(super) fn new(
        lander: &'a SpaceLander,
        trial: u64,
        seed: u64,
        record: bool,
    ) -> Result<Self, SimError> {
        let scenario = &lander.scenario;
        let draw = TrialDraw::new(scenario, trial, seed);
        let vehicle = draw.vehicle(&lander.vehicle)?;
        let mut track = lander.track(trial, seed, draw.phase)?;
        let pose = track.at(0.0)?;
        let (state, throttle) = draw.start(scenario, &vehicle, &pose);
        let TrialAir {
            wind,
            turbulence,
            disturbance,
        } = TrialAir::new(scenario, &vehicle, &state, &pose, trial, seed)?;
        let gravity = scenario.plant.gravity_mps2;
        let mut sensors = SensorSuite::new(
            &scenario.sensors,
            &lander.camera,
            scenario.control_period_s,
            &state,
            gravity,
            seed,
            trial,
        );
        sensors.camera.pipeline = lander.camera_pipeline()?;
        sensors.range_finder.log = record.then(Vec::new);
        Ok(Self {
            lander,
            loads: vehicle.loads(&state, &pose, &disturbance),
            vehicle,
            track,
            state,
            pose,
            wind,
            gusting: false,
            turbulence,
            disturbance,
            sensors,
            brain: lander.computer.initial(throttle),
            hook: None,
            pilot: lander.pilot(),
            measured_rates: [0.0; 3],
            sent: VecDeque::with_capacity(8),
            setpoint: Some(hover(&state)),
            control: CascadeState::default(),
            throttle: [throttle; 4],
            touching: TouchdownJudge::default(),
            descending: None,
            fault_start: (scenario.faults.since == FaultClock::Start).then_some(0),
            weakened: false,
            phase: Phase::Approach,
            waits: Waits::default(),
            stopped: None,
            gave_up: None,
            log_noise: Stream::new(seed, trial, Purpose::Log),
            landing: SpaceLanding {
                trace: record.then(|| SpaceTrace {
                    rows: Vec::new(),
                    log: FlightLog {
                        range_finder: scenario.sensors.range,
                        ..FlightLog::default()
                    },
                }),
                ..SpaceLanding::begun(trial)
            },
        })
    }

    /// Time on the faults' clock.
    pub(super) fn since_s(&self, step: u64) -> f64 {
        self.fault_start
            .map_or(f64::NEG_INFINITY, |start| (step - start) as f64 * STEP_S)
    }

    /// One step of the integration; returns the outcome of a trial that ends in it.
    pub(super) fn step(&mut self, step: u64) -> Result<Option<SpaceOutcome>, SimError> {
        let scenario = &self.lander.scenario;
        let truth = Truth {
            step,
            faults: scenario.faults.of_sensors(self.since_s(step)),
            state: &self.state,
            deck: &self.pose,
            acceleration_mps2: self.loads.acceleration_mps2,
            half_side_m: self.lander.half_side_m,
        };
        let gravity = scenario.plant.gravity_mps2;
        self.sensors.observe(&truth, gravity);
        if step.is_multiple_of(steps(scenario.control_period_s) as u64) {
            let arrivals = self.sensors.arrivals(&truth);
            let now_s = step as f64 * STEP_S;
            let sensed = Sensed {
                imu: arrivals.imu,
                readings: &arrivals.readings,
                deck_normal: arrivals.normal,
                battery_share: (scenario.battery_share - now_s / scenario.battery_s).max(0.0),
                contact: None,
                request: OperatorRequest::None,
            };
            let period_s = scenario.control_period_s;
            let mut output = self
                .lander
                .computer
                .step(&mut self.brain, &sensed, period_s);
            if let Some(hook) = &mut self.hook {
                hook(&sensed, period_s, &mut output);
            }
            let attitude = sensed.imu.attitude.to_quaternion();
            let body_rates = self.pilot(&mut output, attitude);
            self.log_tags(now_s, &arrivals.readings);
            self.note(step, &output);
            self.sent.push_back(PendingCommand {
                arrives: step + steps(scenario.command_delay_s) as u64,
                setpoint: output.command.map(|command| AttitudeSetpoint {
                    thrust_n: command.thrust_n,
                    attitude: command.attitude.to_quaternion(),
                    yaw_rate: 0.0,
                    body_rates,
                }),
            });
        }
        while let Some(sent) = self.sent.front().filter(|sent| sent.arrives <= step) {
            self.setpoint = sent.setpoint;
            self.sent.pop_front();
        }
        self.drive(step);
        self.log_sample(step);
        self.strike(step);
        self.fly(step)
    }

    /// Where a policy flies, its command takes the place of the computer's. Gives the rates that it asks for.
    fn pilot(&mut self, output: &mut ComputerOutput<f64>, attitude: [f64; 4]) -> Option<[f64; 3]> {
        let computer = &self.lander.computer;
        let estimate = output.estimate;
        let given = self
            .pilot
            .as_mut()?
            .command(output, computer, || Observation {
                place_m: estimate.position_m.to_array(),
                relative_mps: estimate.relative_velocity_mps().to_array(),
                velocity_mps: estimate.velocity_mps.to_array(),
                attitude,
                rates: self.measured_rates,
                normal: self.brain.deck_normal().to_array(),
            })?;
        computer.replace_command(&mut self.brain, &given.command);
        output.command = Some(given.command);
        given.rates
    }

    /// Attitude control.
    fn drive(&mut self, step: u64) {
        let cascade = &self.lander.cascade;
        match &self.setpoint {
            None => self.throttle = [0.0; 4],
            Some(setpoint) if step.is_multiple_of(steps(cascade.period_s()) as u64) => {
                let faults = &self.lander.scenario.faults;
                let nan = faults.of_sensors(self.since_s(step)).nan;
                let attitude = self.sensors.inertial.believed(self.state.attitude);
                let attitude = attitude.map(|q| nan_if(nan.attitude, q));
                let rates = self.sensors.inertial.rates(self.state.rates);
                let rates = rates.map(|rate| nan_if(nan.rates, rate));
                self.measured_rates = rates;
                let output = cascade.step(&mut self.control, attitude, rates, setpoint);
                self.throttle = output.throttle;
            }
            Some(_) => {}
        }
    }

    /// Faults of the vehicle and its air.
    pub(super) fn strike(&mut self, step: u64) {
        let faults = &self.lander.scenario.faults;
        let since_s = self.since_s(step);
        if let Some(rotor) = faults
            .rotor
            .filter(|rotor| !self.weakened && since_s >= rotor.from_s)
        {
            self.weakened = true;
            let mut error = self.vehicle.thrust_scale_error();
            error[rotor.rotor.min(3)] = rotor.share * (1.0 + error[rotor.rotor.min(3)]) - 1.0;
            self.vehicle = self.vehicle.clone().with_thrust_scale_error(error);
        }
        self.gusting = faults.gust.is_some() && since_s >= 0.0;
    }

    /// Advances the wind by a step. Above a deck that is held the air is calm, and the wind's time stands. When the deck is
    /// released, the wind rises as the deck speeds up.
    fn blow(&mut self, step: u64) {
        if !self.track.is_held() {
            self.wind.step();
        }
        let height_m = self.state.position_m[2] - self.pose.origin_m[2];
        let wind_mps = self.wind.velocity_at(height_m);
        let share = self.track.released_share((step + 1) as f64 * STEP_S);
        self.disturbance.wind_mps = share.map_or(wind_mps, |share| scale(wind_mps, share));
        if let (true, Some(gust)) = (self.gusting, &self.lander.scenario.faults.gust) {
            let gust = GustSettings {
                velocity_mps: gust.velocity_mps,
                start_s: gust.from_s,
                rise_s: gust.rise_s,
                hold_s: gust.hold_s,
            };
            let blow = gust.at(self.since_s(step));
            self.disturbance.wind_mps = add(self.disturbance.wind_mps, blow);
        }
    }

    /// Moves the vehicle over a step and judges it.
    pub(super) fn fly(&mut self, step: u64) -> Result<Option<SpaceOutcome>, SimError> {
        let t = step as f64 * STEP_S;
        let before = self.relative();
        let poses = [
            self.pose,
            self.track.at(t + 0.5 * STEP_S)?,
            self.track.at(t + STEP_S)?,
        ];
        let vehicle = &self.vehicle;
        self.loads = vehicle.step(
            &mut self.state,
            &poses,
            &self.throttle,
            &self.disturbance,
            STEP_S,
        );
        if let Some(turbulence) = &mut self.turbulence {
            let roots = &self.state.rotors.root_thrust;
            let sd_n = vehicle.rotors().turbulence_sd_n(roots, &self.loads.target);
            self.disturbance.turbulence_n = turbulence.step(sd_n);
        }
        self.blow(step);
        self.pose = poses[2];
        let log = &mut self.touching.log;
        self.vehicle
            .log_contact(log, t + STEP_S, &self.state, &self.pose);
        self.landing.steps = step + 1;
        if self.phase == Phase::Wait {
            self.landing.waited_s += STEP_S;
        }
        Ok(self.judge(step + 1, before))
    }
}
