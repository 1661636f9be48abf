//! A vehicle with rotors, attitude lag, legs and sensors over a deck that heaves.

use std::collections::VecDeque;

use touchdown_flight::control::{Composite, Law};
use touchdown_flight::ground_effect::{GroundEffectState, Guarded, GuardedState};
use touchdown_flight::thrust::{FirstOrder, ThrustModel, ThrustState};
use touchdown_flight::{Attitude, Limits, Vector};
use touchdown_lander::computer::{Computer, ComputerOutput, ComputerState, Descent, Feet, Sensed};
use touchdown_lander::control::{Delays, Horizontal, Observer};
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};
use touchdown_lander::estimate::relative::{
    BarometerReading, GnssVelocity, ImuModel, ImuSample, RangeReading, Reading, RelativeFilter,
    TagReading,
};
use touchdown_lander::guidance::Guidance;
use touchdown_lander::planner::Planner;
use touchdown_lander::space_controller::{SpaceCommand, SpaceController};
use touchdown_lander::state_machine::{OperatorRequest, StateMachine};

use crate::common::noise::Noise;

pub(crate) type State = ComputerState<f64, GuardedState<f64, GroundEffectState<f64>>>;

pub(crate) const DT: f64 = 0.01;
/// Age of IMU samples, s.
pub(crate) const IMU_S: f64 = 0.02;
pub(crate) const MASS_KG: f64 = 1.37;
pub(crate) const GRAVITY: f64 = 9.81;
pub(crate) const WEIGHT_N: f64 = MASS_KG * GRAVITY;

/// Rotors that follow within 60 ms.
fn rotors() -> ThrustModel<f64> {
    ThrustModel::FirstOrder(FirstOrder {
        c0: 6.9,
        c1: 0.3,
        t_m_s: 0.06,
    })
}

/// A computer that knows the delays of [`World`].
pub(crate) fn computer() -> Computer<f64> {
    Computer {
        relative: RelativeFilter {
            imu: ImuModel {
                delay_s: IMU_S,
                ..ImuModel::default()
            },
            ..RelativeFilter::default()
        },
        latency: None,
        deck: DeckEstimator {
            delay_s: 0.05,
            ..DeckEstimator::new(Observed::Displacement, 0.005)
        },
        descent: Descent::Planned(Planner::default()),
        state_machine: StateMachine::default(),
        guidance: Guidance {
            sensing_s: 0.0,
            ..Guidance::default()
        },
        controller: SpaceController {
            motor_lag_share: 0.5,
            mass_kg: MASS_KG,
            gravity_mps2: GRAVITY,
            law: Law::Composite(Composite::default()),
            horizontal: Horizontal::default(),
            thrust: rotors(),
            ground_effect: Guarded::default(),
            observer: Some(Observer::default()),
            adaptation: None,
            delays: Delays {
                // Attitude and acceleration come together, the mean over a step.
                sensing_s: IMU_S + 0.5 * DT,
                attitude_s: IMU_S + 0.5 * DT,
                ..Delays::default()
            },
            limits: Limits::default(),
        },
        deck_acceleration: true,
        under_way: false,
        seek: None,
        imu_latency_s: IMU_S,
        known_sd_m: 0.3,
        known_sd_mps: 0.3,
        restart_s: 0.5,
        feet: Feet::default(),
        contact_height_m: 0.11,
        watch_s: 3.0,
        deck_known_mps: 0.02,
        least_damping_ratio: 0.1,
        normal_filter_s: 0.2,
        tilt_memory_s: 10.0,
        planner_period_s: 0.1,
    }
}

/// Every how many steps a sensor reads, and the age of its readings in steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rate {
    pub(crate) every: usize,
    pub(crate) age: usize,
}

const fn rate(every: usize, age: usize) -> Option<Rate> {
    Some(Rate { every, age })
}

fn vector(mut part: impl FnMut() -> f64) -> Vector<f64> {
    Vector::new(part(), part(), part())
}

#[derive(Clone, Copy, Debug)]
struct History {
    /// Relative to the deck.
    position_m: Vector<f64>,
    velocity_mps: Vector<f64>,
    attitude: Attitude<f64>,
    altitude_m: f64,
}

/// Control steps of 10 ms; commands act after one of them.
#[derive(Clone, Debug)]
pub(crate) struct World {
    /// Amplitude and angular frequency of the deck's heave.
    pub(crate) heave: (f64, f64),
    pub(crate) thrust_scale: f64,
    /// Flies this attitude whatever is asked for.
    pub(crate) attitude_at: Option<fn(f64) -> Attitude<f64>>,
    pub(crate) range: Option<Rate>,
    pub(crate) tag: Option<Rate>,
    pub(crate) gnss: Option<Rate>,
    pub(crate) barometer: Option<Rate>,
    /// Noise of all sensors, where there is one.
    pub(crate) noise: Option<Noise>,
    /// Age of range, tag and satellites that their stamps do not tell, s.
    pub(crate) unstamped_s: f64,
    pub(crate) request: OperatorRequest,
    pub(crate) contact: Option<bool>,
    pub(crate) battery_share: f64,
    pub(crate) time_s: f64,
    pub(crate) position_m: Vector<f64>,
    pub(crate) velocity_mps: Vector<f64>,
    pub(crate) attitude: Attitude<f64>,
    rotors: ThrustState<f64>,
    sent: VecDeque<Option<SpaceCommand<f64>>>,
    samples: VecDeque<ImuSample<f64>>,
    past: VecDeque<History>,
    step: usize,
}

impl World {
    /// At rest 0.8 m above the deck, heading `yaw_rad`.
    pub(crate) fn new(yaw_rad: f64) -> Self {
        let model = rotors();
        Self {
            heave: (0.0, 1.0),
            thrust_scale: 1.0,
            attitude_at: None,
            range: rate(2, 2),
            tag: rate(3, 4),
            gnss: rate(10, 10),
            barometer: None,
            noise: None,
            unstamped_s: 0.0,
            request: OperatorRequest::None,
            contact: None,
            battery_share: 0.6,
            time_s: 0.0,
            position_m: Vector::UP * 0.8,
            velocity_mps: Vector::ZERO,
            attitude: Attitude::from_yaw(yaw_rad),
            rotors: ThrustState {
                x: model.rest(model.throttle_for(WEIGHT_N)),
            },
            sent: VecDeque::new(),
            samples: VecDeque::new(),
            past: VecDeque::new(),
            step: 0,
        }
    }

    pub(crate) fn throttle() -> f64 {
        rotors().throttle_for(WEIGHT_N)
    }

    /// Height and velocity of the deck now.
    pub(crate) fn deck(&self) -> [f64; 2] {
        let (a, w) = self.heave;
        let (sin, cos) = (w * self.time_s).sin_cos();
        [a * sin, a * w * cos]
    }

    pub(crate) fn height_m(&self) -> f64 {
        self.position_m.z - self.deck()[0]
    }

    /// Specific force: rotors and legs (4 kN/m, 60 N s/m below 0.1 m, feet that do not
    /// slide).
    fn force(&self) -> Vector<f64> {
        let pressed = 0.1 - self.height_m();
        let mut legs = Vector::ZERO;
        if pressed > 0.0 {
            let closing = self.velocity_mps.z - self.deck()[1];
            legs = Vector::UP * ((4000.0 * pressed - 60.0 * closing).max(0.0) / MASS_KG)
                - self.velocity_mps.horizontal() * 30.0;
        }
        self.attitude.up() * (self.rotors.thrust_n() * self.thrust_scale / MASS_KG) + legs
    }

    /// What the sensors say at the beginning of a step.
    fn sense(&mut self) -> (ImuSample<f64>, Vec<Reading<f64>>) {
        let late = (IMU_S / DT).round() as usize;
        if self.samples.len() > late + 1 {
            self.samples.pop_front();
        }
        let imu = self.samples.front().copied().unwrap_or(ImuSample {
            specific_force_mps2: Vector::UP * GRAVITY,
            attitude: self.attitude,
        });
        self.past.push_front(History {
            position_m: self.position_m - Vector::UP * self.deck()[0],
            velocity_mps: self.velocity_mps,
            attitude: self.attitude,
            altitude_m: self.position_m.z,
        });
        self.past.truncate(64);
        let camera = computer().relative.tag.attitude;
        let mut readings = Vec::new();
        let step = self.step;
        let due = |rate: Option<Rate>| {
            let rate = rate.filter(|rate| step.is_multiple_of(rate.every))?;
            let past = self.past.get(rate.age)?;
            Some((*past, rate.age as f64 * DT - self.unstamped_s))
        };
        let noise = &mut self.noise;
        let mut error = |sd: f64| noise.as_mut().map_or(0.0, |noise| sd * noise.normal());
        let imu = ImuSample {
            specific_force_mps2: imu.specific_force_mps2 + vector(|| error(0.1)),
            ..imu
        };
        if let Some((past, age_s)) = due(self.range) {
            let distance_m = past.position_m.z / past.attitude.up().z + error(3e-3);
            readings.push(Reading::Range(RangeReading::level(distance_m, age_s)));
        }
        if let Some((past, age_s)) = due(self.tag) {
            let body = past.attitude.unrotate(-past.position_m);
            readings.push(Reading::Tag(TagReading {
                position_m: camera.unrotate(body) + vector(|| error(2e-3)),
                covariance_m2: [[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-6]],
                age_s,
            }));
        }
        if let Some((past, age_s)) = due(self.gnss) {
            readings.push(Reading::Gnss(GnssVelocity {
                velocity_mps: past.velocity_mps + vector(|| error(0.03)),
                age_s,
            }));
        }
        if let Some((past, age_s)) = due(self.barometer) {
            readings.push(Reading::Barometer(BarometerReading {
                altitude_m: past.altitude_m + error(0.1),
                age_s,
            }));
        }
        self.step += 1;
        (imu, readings)
    }

    /// A step of the computer and the vehicle, what is sensed changed by `change`.
    pub(crate) fn step_with(
        &mut self,
        computer: &Computer<f64>,
        state: &mut State,
        change: impl FnOnce(&mut Sensed<'_, f64>),
    ) -> ComputerOutput<f64> {
        let (imu, readings) = self.sense();
        let mut sensed = Sensed {
            imu,
            readings: &readings,
            deck_normal: None,
            battery_share: self.battery_share,
            contact: self.contact,
            request: self.request,
        };
        change(&mut sensed);
        let output = computer.step(state, &sensed, DT);
        self.fly(output.command);
        output
    }

    pub(crate) fn step(
        &mut self,
        computer: &Computer<f64>,
        state: &mut State,
    ) -> ComputerOutput<f64> {
        self.step_with(computer, state, |_| ())
    }

    fn fly(&mut self, command: Option<SpaceCommand<f64>>) {
        self.sent.push_back(command);
        if self.sent.len() > 2 {
            self.sent.pop_front();
        }
        let command = self.sent[0];
        let model = rotors();
        let mut felt = Vector::ZERO;
        for _ in 0..10 {
            let dt = 1e-3;
            let throttle = command.map_or(0.0, |command| command.throttle);
            model.step(&mut self.rotors, throttle, dt);
            self.time_s += dt;
            if let Some(attitude_at) = self.attitude_at {
                self.attitude = attitude_at(self.time_s);
            } else if let Some(command) = command {
                self.attitude = self.attitude.between(command.attitude, dt / 0.08);
            }
            let force = self.force();
            felt += self.attitude.unrotate(force) * 0.1;
            self.velocity_mps += (force - Vector::UP * GRAVITY) * dt;
            self.position_m += self.velocity_mps * dt;
        }
        self.samples.push_back(ImuSample {
            specific_force_mps2: felt,
            attitude: self.attitude,
        });
    }
}
