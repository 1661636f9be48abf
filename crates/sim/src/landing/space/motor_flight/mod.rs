//! The world of a landing under an autopilot that is not simulated: motor signals in, readings of the autopilot's sensors
//! and the truth out, one step of 1 ms at a time.
//!
//! ```text
//!                 ┌── readings every few steps ──> autopilot ── motor signals ──┐
//! deck, wind ─> vehicle (1 kHz) <──────────────────────────────────────────────┘
//! ```
//!
//! The vehicle begins at rest on the deck with its rotors stopped. The deck stands and the air is calm until
//! [`MotorFlight::release_deck`], so that an autopilot can be armed and can take off as on ground. Landings are judged by the truth, as all others are:
//! [`MotorFlight::begin_descent`] starts their clock.
//!
//! Sensors are those of the scenario, with their noise, latencies, losses and faults. An autopilot also needs what the
//! landing computer of a simulation does not: raw samples of the inertial unit, a magnetometer, and places of GNSS.

use touchdown_lander::estimate::relative::{Reading, TagReading};
use touchdown_lander::state_machine::Reason;

use super::faults::FaultClock;
use super::flight::{Descent, Flight};
use super::landing::SpaceLander;
use super::outcome::{Abort, SpaceLanding, SpaceOutcome};
use super::touchdown::TouchdownJudge;
use crate::STEP_S;
use crate::body::rigid::RigidState;
use crate::deck::rigid::DeckPose;
use crate::error::SimError;
use crate::number::vector::{add, along, to_world};
use crate::sensors::Wander;
use crate::sensors::camera::CameraSettings;
use crate::sensors::history::History;
use crate::sensors::suite::{Truth, steps};

/// Clearance of the feet above the deck at the start, m: the vehicle settles onto a deck that leans by 2 degrees.
const CLEARANCE_M: f64 = 0.005;
/// Signal up to which a motor counts as stopped: below the idle signal of armed motors, 0.03 as `touchdown simulator` sets
/// ArduPilot. At half of it nothing changes; at twice it, idling rotors would count as stopped.
const STOPPED_SIGNAL: f64 = 0.02;
/// White noise of a magnetometer's axis, standard deviation, gauss: the order of small magnetoresistive sensors.
const MAGNETOMETER_SD_GAUSS: f64 = 0.002;
/// Slowly varying error of a GNSS place on each axis, standard deviation, m, and its correlation time, s: a receiver
/// without corrections, after the constant part, which an autopilot takes into its origin.
const PLACE_WANDER: (f64, f64) = (0.2, 60.0);
/// Remembered places, in steps: longer than the greatest latency of a reading, with its fault.
const REMEMBERED: usize = 800;

/// Signals of the four motors, in [0, 1], in the order of the rotors: front left, rear left, rear right, front right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorSignals(pub [f64; 4]);

/// A fix of satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GnssFix {
    /// Place at the time of the measurement, world axes, m.
    pub position_m: [f64; 3],
    /// Velocity, world axes, m/s.
    pub velocity_mps: [f64; 3],
}

/// The deck as the camera sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckSighting {
    /// The deck's centre from the vehicle's reference point, body axes, m.
    pub position_m: [f64; 3],
    /// Age of the image that the vehicle knows of, s.
    pub age_s: f64,
    /// Number of the camera's frame, from zero.
    pub frame: u64,
}

/// What the sensors report to the autopilot and to a companion. A sensor whose reading is not a number, or that has none
/// since the last report, reports none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AutopilotReadings {
    /// Time since the start, s.
    pub time_s: f64,
    /// Mean specific force over the last 4 ms, body axes, m/s².
    pub specific_force_mps2: Option<[f64; 3]>,
    /// Angular velocity, body axes, rad/s.
    pub rates: Option<[f64; 3]>,
    /// Magnetic field, body axes, gauss.
    pub magnetic_field_gauss: [f64; 3],
    /// Height by the barometer, m.
    pub barometer_m: Option<f64>,
    /// Satellite navigation.
    pub gnss: Option<GnssFix>,
    /// Distance along the range finder's beam, m.
    pub range_m: Option<f64>,
    /// The deck in the camera, oldest first.
    pub sightings: Vec<DeckSighting>,
}

/// What is true at a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleTruth {
    /// Time since the start, s.
    pub time_s: f64,
    /// The vehicle.
    pub state: RigidState,
    /// Its acceleration, world axes, m/s².
    pub acceleration_mps2: [f64; 3],
    /// The deck.
    pub deck: DeckPose,
    /// Place relative to the deck's centre, along its axes, m.
    pub relative_m: [f64; 3],
    /// Velocity relative to the deck, along its axes, m/s.
    pub relative_mps: [f64; 3],
    /// Force of each rotor, N.
    pub rotor_n: [f64; 4],
    /// Ground effect and climb damping of all rotors, N.
    pub ground_effect_n: f64,
    /// Normal forces on the feet, N.
    pub feet_n: [f64; 4],
    /// Wind, m/s.
    pub wind_mps: [f64; 3],
    /// Signals of the motors.
    pub signals: MotorSignals,
}

/// A landing under an autopilot.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorLanding {
    /// The landing, as of all others.
    pub landing: SpaceLanding,
    /// When the motors were stopped for good, since the start, s.
    pub stopped_s: Option<f64>,
}

/// A flight whose motor signals come from outside.
pub struct MotorFlight<'a> {
    flight: Flight<'a>,
    step: u64,
    /// The Earth's magnetic field, world axes, gauss.
    field_gauss: [f64; 3],
    places_m: History<[f64; 3]>,
    wander: [Wander; 3],
    readings: AutopilotReadings,
}

impl SpaceLander {
    /// The world of a trial under an autopilot. `field_gauss` is the magnetic field there, world axes.
    ///
    /// # Errors
    /// As [`Self::land`].
    pub fn motor_flight(
        &self,
        trial: u64,
        seed: u64,
        field_gauss: [f64; 3],
    ) -> Result<MotorFlight<'_>, SimError> {
        let mut flight = Flight::new(self, trial, seed, false)?;
        flight.track.hold();
        flight.pose = flight.track.at(0.0)?;
        flight.disturbance.wind_mps = [0.0; 3];
        let above = flight.relative().0;
        let place = [above[0], above[1], self.scenario.legs.depth_m + CLEARANCE_M];
        flight.state = RigidState {
            position_m: add(flight.pose.origin_m, to_world(&flight.pose.axes, place)),
            ..RigidState::default()
        };
        flight.throttle = [0.0; 4];
        flight.fault_start = None;
        flight.loads = flight
            .vehicle
            .loads(&flight.state, &flight.pose, &flight.disturbance);
        let gnss_s = 1.0 / self.scenario.sensors.gnss.schedule.rate_hz;
        let (sd_m, correlation_s) = PLACE_WANDER;
        let wander = std::array::from_fn(|_| {
            Wander::new(sd_m, correlation_s, gnss_s, &mut flight.log_noise)
        });
        let mut flight = MotorFlight {
            places_m: History::new(REMEMBERED, flight.state.position_m),
            flight,
            step: 0,
            field_gauss,
            wander,
            readings: AutopilotReadings::default(),
        };
        flight.observe();
        Ok(flight)
    }
}

impl MotorFlight<'_> {
    /// Lets the deck move and the wind blow from now on, both within 2 s, and starts to judge what touches it.
    pub fn release_deck(&mut self) {
        let flight = &mut self.flight;
        flight.track.release(self.step as f64 * STEP_S);
        flight.touching = TouchdownJudge::default();
        if flight.lander.scenario.faults.since == FaultClock::Start {
            flight.fault_start = Some(self.step);
        }
    }

    /// A descent begins now; one that had begun was broken off.
    pub fn begin_descent(&mut self) {
        let flight = &mut self.flight;
        flight.landing.descents += 1;
        flight.descending = Some(Descent {
            since: self.step,
            path_m: 0.0,
            touch: None,
        });
        flight.fault_start.get_or_insert(self.step);
    }

    /// The descent is broken off.
    pub fn break_off(&mut self, reason: Option<Reason>) {
        let flight = &mut self.flight;
        flight.descending = None;
        flight.landing.aborts.push(Abort {
            time_s: self.step as f64 * STEP_S,
            reason,
            height_m: flight.relative().0[2],
        });
    }

    /// Whether a descent has ended on the deck.
    #[must_use]
    pub fn has_touched(&self) -> bool {
        self.flight.descending.is_some_and(|d| d.touch.is_some())
    }

    /// Time since the start, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.step as f64 * STEP_S
    }

    /// What the sensors have reported since the last call.
    pub fn take_readings(&mut self) -> AutopilotReadings {
        let flight = &mut self.flight;
        let nan = &flight.lander.scenario.faults;
        let nan = nan.of_sensors(flight.since_s(self.step)).nan;
        let imu = &flight.lander.scenario.sensors.imu;
        // White over the 4 ms of a sample.
        let sd = imu.noise_density / (4.0 * STEP_S).sqrt();
        let force = flight.sensors.inertial.logged_force_mps2();
        let force = force.map(|f| f + sd * flight.log_noise.normal());
        let rates = flight.sensors.inertial.rates(flight.state.rates);
        let field = along(&flight.state.axes(), self.field_gauss);
        AutopilotReadings {
            time_s: self.step as f64 * STEP_S,
            specific_force_mps2: (!nan.specific_force).then_some(force),
            rates: (!nan.rates).then_some(rates),
            magnetic_field_gauss: field
                .map(|b| b + MAGNETOMETER_SD_GAUSS * flight.log_noise.normal()),
            ..std::mem::take(&mut self.readings)
        }
    }

    /// Flies one step with the signals that the autopilot gives its motors; returns the outcome of a landing that ends in
    /// it.
    ///
    /// # Errors
    /// None that the scenario's check has not found.
    pub fn advance(&mut self, signals: MotorSignals) -> Result<Option<SpaceOutcome>, SimError> {
        let flight = &mut self.flight;
        flight.throttle = signals.0.map(|s| {
            if s.is_finite() {
                s.clamp(0.0, 1.0)
            } else {
                0.0
            }
        });
        let stopped = flight.throttle.iter().all(|s| *s <= STOPPED_SIGNAL);
        flight.stopped = match (flight.descending, flight.stopped) {
            (Some(_), stopped_at) if stopped => Some(stopped_at.unwrap_or(self.step)),
            _ => None,
        };
        flight.strike(self.step);
        let outcome = flight.fly(self.step)?;
        self.step += 1;
        self.observe();
        Ok(outcome)
    }

    /// Everything that is true now.
    #[must_use]
    pub fn truth(&self) -> VehicleTruth {
        let flight = &self.flight;
        let (relative_m, relative_mps) = flight.relative();
        let feet = flight.vehicle.feet(&flight.state, &flight.pose);
        VehicleTruth {
            time_s: self.step as f64 * STEP_S,
            state: flight.state,
            acceleration_mps2: flight.loads.acceleration_mps2,
            deck: flight.pose,
            relative_m,
            relative_mps,
            rotor_n: flight.loads.rotor_n,
            ground_effect_n: flight.loads.ground_effect_n.iter().sum(),
            feet_n: feet.map(|foot| foot.force_n[2]),
            wind_mps: flight.disturbance.wind_mps,
            signals: MotorSignals(flight.throttle),
        }
    }

    /// The landing as it ended.
    #[must_use]
    pub fn finish(self, outcome: SpaceOutcome) -> MotorLanding {
        let flight = self.flight;
        let mut landing = flight.landing;
        landing.outcome = outcome;
        landing.touch = flight.descending.and_then(|descending| descending.touch);
        landing.before_descent_s = flight
            .descending
            .map(|descending| descending.since as f64 * STEP_S);
        flight.touching.enter(&mut landing);
        landing.end_s = landing.steps as f64 * STEP_S;
        MotorLanding {
            landing,
            stopped_s: flight.stopped.map(|step| step as f64 * STEP_S),
        }
    }

    /// Takes the samples of a step, and what arrives at it.
    fn observe(&mut self) {
        let flight = &mut self.flight;
        let scenario = &flight.lander.scenario;
        self.places_m.push(flight.state.position_m);
        let truth = Truth {
            step: self.step,
            faults: scenario.faults.of_sensors(flight.since_s(self.step)),
            state: &flight.state,
            deck: &flight.pose,
            acceleration_mps2: flight.loads.acceleration_mps2,
            half_side_m: flight.lander.half_side_m,
        };
        flight.sensors.observe(&truth, scenario.plant.gravity_mps2);
        if !self
            .step
            .is_multiple_of(steps(scenario.control_period_s) as u64)
        {
            return;
        }
        let arrivals = flight.sensors.arrivals(&truth);
        let mut frames = arrivals.frames.into_iter();
        for reading in arrivals.readings {
            let tag = matches!(reading, Reading::Tag(_));
            let frame = if tag { frames.next() } else { None };
            if !reading.is_finite() {
                continue;
            }
            match reading {
                Reading::Range(range) => self.readings.range_m = Some(range.distance_m),
                Reading::Barometer(height) => self.readings.barometer_m = Some(height.altitude_m),
                Reading::Tag(tag) => {
                    let frame = frame.unwrap_or_default();
                    let sighting = sighting(&scenario.sensors.tag.camera, &tag, frame);
                    self.readings.sightings.push(sighting);
                }
                // No autopilot takes it.
                Reading::Beacon(_) => {}
                Reading::Gnss(gnss) => {
                    let age = steps(gnss.age_s).min(REMEMBERED - 1);
                    let noise = &mut flight.log_noise;
                    let wander = [0, 1, 2].map(|k: usize| self.wander[k].step(noise));
                    self.readings.gnss = Some(GnssFix {
                        position_m: add(self.places_m.at(age), wander),
                        velocity_mps: gnss.velocity_mps.to_array(),
                    });
                }
            }
        }
    }
}

/// The deck in the vehicle's body axes, from a tag in the camera's.
fn sighting(camera: &CameraSettings, tag: &TagReading<f64>, frame: u64) -> DeckSighting {
    let (sin, cos) = camera.turn_rad.sin_cos();
    let axes = [[sin, -cos, 0.0], [-cos, -sin, 0.0], [0.0, 0.0, -1.0]];
    let seen = to_world(&axes, tag.position_m.to_array());
    DeckSighting {
        position_m: add(camera.place_m, seen),
        age_s: tag.age_s,
        frame,
    }
}

#[cfg(test)]
mod tests;
