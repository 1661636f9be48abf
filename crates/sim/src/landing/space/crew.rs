//! Controllers by name, as a landing computer of the flight crate.

use serde::{Deserialize, Serialize};
use touchdown_flight::control::{Composite, Gains, Imbc, Law, Ssc};
use touchdown_flight::ground_effect::{
    Empirical, GroundEffectModel, Guarded, Lag, StaticMap, Validity, VelocityInput,
};
use touchdown_flight::reference::{Exponential, Reference, Terminal};
use touchdown_flight::thrust::{Library, ThrustModel};
use touchdown_flight::{Attitude, Limits};
use touchdown_lander::computer::{Computer, Descent};
use touchdown_lander::control::{Adaptation, Delays, Horizontal, Observer};
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};
use touchdown_lander::estimate::latency::LatencyEstimator;
use touchdown_lander::estimate::relative::{DeckPrior, ImuModel, RelativeFilter, TagModel};
use touchdown_lander::guidance::Guidance;
use touchdown_lander::planner::{self, Planner};
use touchdown_lander::space_controller::SpaceController;
use touchdown_lander::state_machine::StateMachine;

use crate::body::plant::PlantSettings;
use crate::error::SimError;
use crate::sensors::SensorSettings;

/// A controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Controller {
    /// No ground-effect model (Method I).
    Feedback,
    /// The empirical law of eq. (2) (Method II).
    Empirical,
    /// The identified dynamic model (Method III).
    Dynamic,
    /// Internal-model regulator, for a deck of known period.
    Imbc,
    /// Smooth sliding control.
    Ssc,
    /// No model, a disturbance observer.
    Observer,
    /// The identified model and a disturbance observer.
    #[default]
    #[serde(rename = "dynamic+observer")]
    DynamicObserver,
}

impl Controller {
    /// All controllers, in the order of tables.
    pub const ALL: [Self; 7] = [
        Self::Feedback,
        Self::Empirical,
        Self::Dynamic,
        Self::Imbc,
        Self::Ssc,
        Self::Observer,
        Self::DynamicObserver,
    ];

    /// The name in settings and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Feedback => "feedback",
            Self::Empirical => "empirical",
            Self::Dynamic => "dynamic",
            Self::Imbc => "imbc",
            Self::Ssc => "ssc",
            Self::Observer => "observer",
            Self::DynamicObserver => "dynamic+observer",
        }
    }
}

/// The descent's shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DescentShape {
    /// Critically damped (eq. 13), begun as soon as the vehicle is ready.
    Exponential,
    /// A quintic to a terminal sink rate.
    #[default]
    Terminal,
}

/// The models that controllers count on, as identified beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlightModels {
    /// Throttle to thrust.
    pub thrust: ThrustModel<f64>,
    /// μ of eq. (2), for `empirical`.
    pub mu: f64,
    /// The dynamic model, for `dynamic` and `dynamic+observer`.
    pub dynamic: Guarded<f64>,
}

impl Default for FlightModels {
    /// As `touchdown identify` finds them on the virtual rig's rich data of the
    /// default plant (seed 1).
    fn default() -> Self {
        let map = StaticMap::new([-0.007_458, 0.041_323, 0.130_612, 0.031_397]);
        let lag = Lag {
            map,
            k: [-0.035_058, 0.103_208],
            tau_s: 0.176_759,
        };
        Self {
            thrust: ThrustModel::Library(Library::from_array([
                7.134_375,
                -11.427_189,
                112.592_380,
                -55.082_173,
                -0.119_445,
                0.836_960,
                -56.642_801,
                2.049_671,
            ])),
            mu: 1.958,
            dynamic: Guarded {
                model: GroundEffectModel::Lag(lag),
                validity: Validity::default(),
                velocity: VelocityInput::NegativeRelative,
            },
        }
    }
}

/// Everything of the landing computer that can be set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ControlSettings {
    /// The controller.
    pub controller: Controller,
    /// The descent's shape.
    pub reference: DescentShape,
    /// Whether the planner waits for a window and plans the descent (`terminal`
    /// only); else it goes straight down as soon as the vehicle is ready.
    pub planner: bool,
    /// Whether the strength of the ground-effect model is adapted.
    pub adaptation: bool,
    /// Whether the deck's estimated acceleration is fed forward.
    pub deck_acceleration: bool,
    /// Rate C of the exponential descent, 1/s.
    pub exponential_per_s: f64,
    /// Duration of a terminal descent without planner, s.
    pub terminal_s: f64,
    /// Its sink rate at touchdown, m/s.
    pub terminal_sink_mps: f64,
    /// Frequency that `imbc` is built for, Hz.
    pub imbc_hz: f64,
    /// Gains of the composite law.
    pub gains: Gains<f64>,
    /// Horizontal control.
    pub horizontal: Horizontal<f64>,
    /// The disturbance observer.
    pub observer: Observer<f64>,
    /// The adaptation.
    pub adapting: Adaptation<f64>,
    /// Guidance.
    pub guidance: Guidance<f64>,
    /// State machine.
    pub lander: StateMachine<f64>,
    /// Planner.
    pub planning: Planner<f64>,
    /// Relative estimator; places, turns and quanta of sensors are filled in from the
    /// sensors' settings.
    pub relative: RelativeFilter<f64>,
    /// Whether a delay of range, tag and GNSS that their stamps do not tell is looked for.
    pub finds_latency: bool,
    /// How it is.
    pub latency: LatencyEstimator<f64>,
    /// Deck estimator.
    pub deck: DeckEstimator<f64>,
    /// Height below which observer and adaptation stand still, m.
    pub contact_height_m: f64,
    /// Time for which the deck is watched before a descent, s.
    pub watch_s: f64,
    /// Least heave velocity of a deck that moves, standard deviation, m/s.
    pub deck_known_mps: f64,
    /// Least width of the band of its heave, as a damping ratio.
    pub least_damping_ratio: f64,
}

impl Default for ControlSettings {
    fn default() -> Self {
        Self {
            controller: Controller::default(),
            reference: DescentShape::default(),
            planner: true,
            adaptation: false,
            deck_acceleration: true,
            exponential_per_s: 0.5566,
            terminal_s: 2.5,
            terminal_sink_mps: 0.03,
            imbc_hz: 0.5,
            // Stiffer than published: errors of the deck's predicted acceleration and
            // of the ground-effect model show less. Much stiffer, and a latency that is
            // not known makes the hover swing.
            gains: Gains {
                k_p: 8.0,
                gamma: 2.5,
                ..Gains::default()
            },
            horizontal: Horizontal::default(),
            observer: Observer::default(),
            adapting: Adaptation::default(),
            guidance: Guidance {
                // The computer predicts to now.
                sensing_s: 0.0,
                ..Guidance::default()
            },
            lander: StateMachine {
                // Contact at 0.1 m and four standard deviations of the height: a
                // vehicle that floats a centimetre above the deck is not let fall.
                touchdown_height_m: 0.108,
                // The next reading of a range finder that is 0.1 s late and now and then
                // misses one.
                range_age_s: 0.2,
                ..StateMachine::default()
            },
            planning: Planner {
                descent: planner::Descent {
                    // A centimetre above contact: tilt and errors of the height do not
                    // make it touch while it still brakes.
                    end_height_m: 0.11,
                    // Touches are judged at 0.108 m: none is missed for being slow.
                    sink_per_sd: 0.1,
                    duration_min_s: 2.0,
                    ..planner::Descent::default()
                },
                ..Planner::default()
            },
            relative: RelativeFilter {
                // A ship surges and sways.
                deck: DeckPrior {
                    horizontal_velocity_sd_mps: 0.1,
                    horizontal_velocity_walk: 0.1,
                    ..DeckPrior::default()
                },
                imu: ImuModel {
                    noise_density: 0.015,
                    ..ImuModel::default()
                },
                tag: TagModel {
                    noise_sd_m: 0.001,
                    ..TagModel::default()
                },
                ..RelativeFilter::default()
            },
            finds_latency: true,
            latency: LatencyEstimator::default(),
            deck: DeckEstimator {
                delay_s: 0.09,
                // The vehicle's own velocity wanders with GNSS and accelerometer bias.
                offset_drift: 0.005,
                offset_rate_drift: 0.03,
                ..DeckEstimator::new(Observed::Displacement, 0.006)
            },
            contact_height_m: 0.11,
            watch_s: 6.0,
            deck_known_mps: 0.2,
            least_damping_ratio: 0.05,
        }
    }
}

impl ControlSettings {
    /// The landing computer of a vehicle whose mass, sensors and delays are known.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn computer(
        &self,
        models: &FlightModels,
        plant: &PlantSettings,
        sensors: &SensorSettings,
        control_period_s: f64,
        command_delay_s: f64,
        start_height_m: f64,
    ) -> Result<Computer<f64>, SimError> {
        let composite = Law::Composite(Composite { gains: self.gains });
        let none = Guarded::new(GroundEffectModel::None, Validity::default());
        let empirical = Guarded::new(
            GroundEffectModel::Empirical(Empirical {
                mu: models.mu,
                rotor_radius_m: plant.rotor_radius_m,
                rotor_offset_m: 0.0,
            }),
            Validity::default(),
        );
        let (law, ground_effect) = match self.controller {
            Controller::Feedback | Controller::Observer => (composite, none),
            Controller::Empirical => (composite, empirical),
            Controller::Dynamic | Controller::DynamicObserver => (composite, models.dynamic),
            Controller::Imbc => {
                let imbc = Imbc::new(std::f64::consts::TAU * self.imbc_hz);
                (Law::Imbc(imbc), none)
            }
            Controller::Ssc => (Law::Ssc(Ssc::default()), none),
        };
        let observes = matches!(
            self.controller,
            Controller::Observer | Controller::DynamicObserver
        );
        let imu_s = sensors.imu.latency_s;
        let descent = match self.reference {
            DescentShape::Exponential => Descent::Straight(Reference::Exponential(Exponential {
                c_per_s: self.exponential_per_s,
                start_height_m,
                end_height_m: 0.0,
            })),
            DescentShape::Terminal if self.planner => Descent::Planned(self.planning),
            DescentShape::Terminal => Descent::Straight(Reference::Terminal(Terminal {
                start_height_m,
                end_height_m: self.planning.descent.end_height_m,
                sink_rate_mps: self.terminal_sink_mps,
                duration_s: self.terminal_s,
            })),
        };
        let mut relative = self.relative;
        relative.gravity_mps2 = plant.gravity_mps2;
        relative.imu.delay_s = imu_s;
        relative.range.position_m = crate::sensors::readings::vector(sensors.range.place_m);
        relative.range.quantum_m = sensors.range.quantum_m;
        relative.range.least_m = sensors.range.least_m;
        relative.range.greatest_m = sensors.range.greatest_m;
        relative.range.jitter_s = sensors.range.schedule.jitter_s;
        relative.tag.position_m = crate::sensors::readings::vector(sensors.tag.camera.place_m);
        // The camera's turn comes on top of how it looks by the settings.
        relative.tag.attitude =
            Attitude::from_yaw(sensors.tag.camera.turn_rad) * relative.tag.attitude;
        relative.tag.jitter_s = sensors.tag.schedule.jitter_s;
        let computer = Computer {
            relative,
            latency: self.finds_latency.then_some(self.latency),
            deck: self.deck,
            descent,
            state_machine: self.lander,
            guidance: self.guidance,
            controller: SpaceController {
                mass_kg: plant.mass_kg,
                gravity_mps2: plant.gravity_mps2,
                law,
                horizontal: self.horizontal,
                thrust: models.thrust,
                ground_effect,
                observer: observes.then_some(self.observer),
                adaptation: self.adaptation.then_some(self.adapting),
                // Attitude and acceleration come together, the mean over a period.
                delays: Delays {
                    sensing_s: imu_s + 0.5 * control_period_s,
                    attitude_s: imu_s + 0.5 * control_period_s,
                    command_s: command_delay_s,
                },
                rotors_m: None,
                limits: Limits::default(),
            },
            deck_acceleration: self.deck_acceleration,
            lead_s: imu_s,
            known_sd_m: 0.3,
            known_sd_mps: 0.3,
            restart_s: 0.5,
            contact_height_m: self.contact_height_m,
            watch_s: self.watch_s,
            deck_known_mps: self.deck_known_mps,
            least_damping_ratio: self.least_damping_ratio,
            normal_filter_s: 0.2,
            tilt_memory_s: 10.0,
            planner_period_s: 0.1,
        };
        computer
            .validate()
            .map_err(|error| cannot_be_flown(&error))?;
        Ok(computer)
    }
}

/// Settings that the flight side refuses.
pub(super) fn cannot_be_flown(error: &touchdown_flight::SettingsError) -> SimError {
    let expected = "settings that the landing computer can fly";
    crate::check::fail("control", expected, error)
}
