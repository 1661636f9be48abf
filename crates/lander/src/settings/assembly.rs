//! Builds the landing computer from settings and the parameters of its vehicle.

use core::f64::consts::TAU;

use touchdown_flight::control::{Composite, Imbc, Ssc};
use touchdown_flight::error::SettingsError;
use touchdown_flight::ground_effect::{Empirical, GroundEffectModel, Guarded, Validity};
use touchdown_flight::method::{Feedforward, Laws};
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::{Exponential, Reference, Terminal};
use touchdown_flight::{Attitude, Limits, Vector};

use super::{ControlSettings, DescentShape};
use crate::computer::{Computer, Descent};
use crate::control::Delays;
use crate::estimate::relative::RelativeFilter;
use crate::models::FlightModels;
use crate::space_controller::SpaceController;
use crate::state_machine::StateMachine;

// The reasons below are physical. The effect of halving or doubling was not measured.

/// Standard deviation below which position (m) and velocity (m/s) of the paper's quadrotor count
/// as known: about the closing speed that the state machine allows at the deck, 0.35 m/s. Another
/// vehicle's follow its rotor radius and the root of it.
const KNOWN_SD: f64 = 0.3;
/// Time apart from its readings after which the estimator restarts, s: five readings of the
/// slowest sensor, GNSS at 10 Hz, so that one outlier does not decide.
const RESTART_S: f64 = 0.5;
/// Time constant of the deck's normal, s: six views of a camera at 30 Hz, and short against a
/// ship's roll of 3 s or more.
const NORMAL_FILTER_S: f64 = 0.2;
/// Time constant with which the largest tilt of the deck fades, s: two to three periods of a
/// ship's roll, so that the last crest still counts at the next one.
const TILT_MEMORY_S: f64 = 10.0;
/// Time between two plans, s: half of the shortest window that the planner accepts
/// (`quiescence.dwell_s`, 0.2 s).
const PLANNER_PERIOD_S: f64 = 0.1;

/// Parameters of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleNumbers<R> {
    /// Mass, kg.
    pub mass_kg: R,
    /// Acceleration of gravity, m/s².
    pub gravity_mps2: R,
    /// Rotor radius R of eq. (2), m.
    pub rotor_radius_m: R,
    /// Greatest thrust of all rotors in free air, N.
    pub greatest_thrust_n: R,
}

/// Parameters of the sensors that the estimators need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNumbers<R> {
    /// Latency of specific force and attitude, s.
    pub imu_latency_s: R,
    /// Position of the range finder, body axes, m.
    pub range_position_m: Vector<R>,
    /// Resolution of the range finder, m; 0 for none.
    pub range_quantum_m: R,
    /// Smallest and largest distance of the range finder, m.
    pub range_limits_m: [R; 2],
    /// Scale of the range finder's half-normal jitter, s.
    pub range_jitter_s: R,
    /// Position of the camera, body axes, m.
    pub camera_position_m: Vector<R>,
    /// Rotation of the camera about the body's z axis, rad.
    pub camera_turn_rad: R,
    /// Scale of the camera's half-normal jitter, s.
    pub camera_jitter_s: R,
}

/// Times of the control loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopTiming<R> {
    /// Time between two steps of the landing computer, s.
    pub period_s: R,
    /// Delay of a command, to the attitude control, s.
    pub command_delay_s: R,
}

impl<R: Real> Default for VehicleNumbers<R> {
    /// The paper's quadrotor: 1.37 kg, rotors of 0.12 m, 20.4 N.
    fn default() -> Self {
        Self {
            mass_kg: r(1.37),
            gravity_mps2: r(9.81),
            rotor_radius_m: r(0.12),
            greatest_thrust_n: Limits::default().thrust_max_n,
        }
    }
}

impl<R: Real> VehicleNumbers<R> {
    /// Limits of thrust and throttle: the vehicle's greatest thrust, and a least thrust of the
    /// same share of the weight as the paper's quadrotor has (0.5 N of 13.4 N).
    #[must_use]
    pub fn limits(&self) -> Limits<R> {
        let standard = Limits::default();
        let mass = self.mass_kg / Self::default().mass_kg;
        Limits {
            thrust_min_n: standard.thrust_min_n * mass,
            thrust_max_n: self.greatest_thrust_n,
            ..standard
        }
    }
}

impl<R: Real> Default for SensorNumbers<R> {
    /// An inertial unit with a latency of 20 ms; a range finder at the reference point,
    /// in whole centimetres from 0.02 to 12 m; a camera 2 cm below it.
    fn default() -> Self {
        Self {
            imu_latency_s: r(0.02),
            range_position_m: Vector::ZERO,
            range_quantum_m: r(0.01),
            range_limits_m: [r(0.02), r(12.0)],
            range_jitter_s: r(0.002),
            camera_position_m: Vector::new(R::ZERO, R::ZERO, r(-0.02)),
            camera_turn_rad: R::ZERO,
            camera_jitter_s: r(0.003),
        }
    }
}

impl<R: Real> Default for LoopTiming<R> {
    /// 100 Hz, commands with a delay of 10 ms.
    fn default() -> Self {
        Self {
            period_s: r(0.01),
            command_delay_s: r(0.01),
        }
    }
}

impl<R: Real> ControlSettings<R> {
    /// The landing computer of a vehicle.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn computer(
        &self,
        models: &FlightModels<R>,
        vehicle: &VehicleNumbers<R>,
        sensors: &SensorNumbers<R>,
        timing: &LoopTiming<R>,
        start_height_m: R,
    ) -> Result<Computer<R>, SettingsError> {
        let imu_latency_s = sensors.imu_latency_s;
        let size = vehicle.rotor_radius_m / VehicleNumbers::default().rotor_radius_m;
        self.course.validate()?;
        let computer = Computer {
            under_way: self.under_way,
            seek: self.seeks.then_some(self.seeking),
            relative: self.relative_filter(vehicle, sensors, start_height_m),
            latency: self.finds_latency.then_some(self.latency),
            deck: self.deck,
            descent: self.descent(start_height_m),
            state_machine: self.state_machine(),
            guidance: self.guidance,
            controller: self.controller(models, vehicle, imu_latency_s, timing),
            deck_acceleration: self.deck_acceleration,
            imu_latency_s,
            known_sd_m: r::<R>(KNOWN_SD) * size,
            known_sd_mps: r::<R>(KNOWN_SD) * size.sqrt(),
            restart_s: r(RESTART_S),
            feet: self.feet,
            contact_height_m: self.contact_height_m,
            watch_s: self.watch_s,
            deck_known_mps: self.deck_known_mps,
            least_damping_ratio: self.least_damping_ratio,
            normal_filter_s: r(NORMAL_FILTER_S),
            tilt_memory_s: r(TILT_MEMORY_S),
            planner_period_s: r(PLANNER_PERIOD_S),
        };
        computer.validate()?;
        Ok(computer)
    }

    /// The state machine. A vehicle that seeks the deck climbs while it seeks, not in a go-around before.
    fn state_machine(&self) -> StateMachine<R> {
        let given = self.state_machine;
        StateMachine {
            lost_s: if self.seeks {
                given.search_s
            } else {
                given.lost_s
            },
            ..given
        }
    }

    /// The first setting of the relative estimator that the assembly replaces although it differs from its default, so that it
    /// would have no effect: its key, its value and its default.
    #[must_use]
    pub fn without_effect(&self) -> Option<(&'static str, R, R)> {
        let (given, standard) = (&self.relative, &Self::default().relative);
        let value = |key, of: fn(&RelativeFilter<R>) -> R| (key, of(given), of(standard));
        let of_sensors = [
            value("relative.gravity_mps2", |of| of.gravity_mps2),
            value("relative.imu.delay_s", |of| of.imu.delay_s),
            value("relative.range.position_m.x", |of| of.range.position_m.x),
            value("relative.range.position_m.y", |of| of.range.position_m.y),
            value("relative.range.position_m.z", |of| of.range.position_m.z),
            value("relative.range.quantum_m", |of| of.range.quantum_m),
            value("relative.range.least_m", |of| of.range.least_m),
            value("relative.range.greatest_m", |of| of.range.greatest_m),
            value("relative.range.jitter_s", |of| of.range.jitter_s),
            value("relative.tag.position_m.x", |of| of.tag.position_m.x),
            value("relative.tag.position_m.y", |of| of.tag.position_m.y),
            value("relative.tag.position_m.z", |of| of.tag.position_m.z),
            value("relative.tag.jitter_s", |of| of.tag.jitter_s),
        ];
        let of_seeking = [
            value("relative.initial.height_m", |of| of.initial.height_m),
            value("relative.initial.height_sd_m", |of| of.initial.height_sd_m),
        ];
        let of_seeking = of_seeking.into_iter().filter(|_| self.seeks);
        let mut replaced = of_sensors.into_iter().chain(of_seeking);
        replaced.find(|(_, value, default)| value != default)
    }

    /// The relative estimator with the numbers of its sensors.
    fn relative_filter(
        &self,
        vehicle: &VehicleNumbers<R>,
        sensors: &SensorNumbers<R>,
        start_height_m: R,
    ) -> RelativeFilter<R> {
        let mut relative = self.relative;
        relative.gravity_mps2 = vehicle.gravity_mps2;
        relative.imu.delay_s = sensors.imu_latency_s;
        relative.range.position_m = sensors.range_position_m;
        relative.range.quantum_m = sensors.range_quantum_m;
        [relative.range.least_m, relative.range.greatest_m] = sensors.range_limits_m;
        relative.range.jitter_s = sensors.range_jitter_s;
        relative.tag.position_m = sensors.camera_position_m;
        // The camera's rotation follows after the attitude in the settings.
        relative.tag.attitude = Attitude::from_yaw(sensors.camera_turn_rad) * relative.tag.attitude;
        relative.tag.jitter_s = sensors.camera_jitter_s;
        if self.seeks {
            relative.initial.height_m = start_height_m;
            relative.initial.height_sd_m = self.seeking.start_sd_m;
        }
        if self.under_way {
            // The vehicle travels along before its first reading.
            let velocity_sd_mps = &mut relative.initial.velocity_sd_mps;
            *velocity_sd_mps = velocity_sd_mps.max(self.course.velocity_sd_mps);
            relative.initial.follows_sd_mps = self.course.follows_sd_mps;
            let deck = &mut relative.deck;
            deck.horizontal_velocity_sd_mps = self.course.velocity_sd_mps;
            deck.horizontal_acceleration_sd_mps2 = self.course.acceleration_sd_mps2;
            deck.horizontal_acceleration_s = self.course.acceleration_s;
        }
        relative
    }

    fn descent(&self, start_height_m: R) -> Descent<R> {
        match self.reference {
            DescentShape::Exponential => Descent::Straight(Reference::Exponential(Exponential {
                c_per_s: self.exponential_per_s,
                start_height_m,
                end_height_m: R::ZERO,
            })),
            DescentShape::Terminal if self.planner => Descent::Planned(self.planning),
            DescentShape::Terminal => Descent::Straight(Reference::Terminal(Terminal {
                start_height_m,
                end_height_m: self.planning.descent.end_height_m,
                sink_rate_mps: self.terminal_sink_mps,
                duration_s: self.terminal_s,
            })),
        }
    }

    /// The controller in space of the method.
    fn controller(
        &self,
        models: &FlightModels<R>,
        vehicle: &VehicleNumbers<R>,
        imu_latency_s: R,
        timing: &LoopTiming<R>,
    ) -> SpaceController<R> {
        let laws = Laws {
            composite: Composite { gains: self.gains },
            imbc: Imbc::new(r::<R>(TAU) * self.imbc_hz),
            ssc: Ssc::default(),
        };
        let ground_effect = match self.method.feedforward() {
            Feedforward::None => Guarded::new(GroundEffectModel::None, Validity::default()),
            Feedforward::Empirical => Guarded::new(
                GroundEffectModel::Empirical(Empirical {
                    mu: models.mu,
                    rotor_radius_m: vehicle.rotor_radius_m,
                    rotor_offset_m: R::ZERO,
                }),
                Validity::default(),
            ),
            Feedforward::Dynamic => models.dynamic,
        };
        // Attitude and acceleration arrive together, as the mean over a period.
        let sensing_s = imu_latency_s + r::<R>(0.5) * timing.period_s;
        SpaceController {
            mass_kg: vehicle.mass_kg,
            gravity_mps2: vehicle.gravity_mps2,
            law: self.method.law(&laws),
            horizontal: self.horizontal,
            thrust: models.thrust,
            motor_lag_share: self.motor_lag_share,
            ground_effect,
            observer: self.method.has_observer().then_some(self.observer),
            adaptation: self.adaptation.then_some(self.adapting),
            delays: Delays {
                sensing_s,
                attitude_s: sensing_s,
                command_s: timing.command_delay_s,
            },
            limits: vehicle.limits(),
        }
    }
}
