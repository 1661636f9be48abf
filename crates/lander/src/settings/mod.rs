//! Settings of the landing computer, with the defaults that campaigns fly.

mod assembly;

pub use assembly::{LoopTiming, SensorNumbers, VehicleNumbers};

use crate::check::{not_negative, positive};
use touchdown_flight::control::Gains;
use touchdown_flight::error::SettingsError;
use touchdown_flight::method::{C_DECK_PER_S, Method};
use touchdown_flight::real::{Real, r};

use crate::computer::{Feet, Seek};
use crate::control::{Adaptation, Horizontal, Observer};
use crate::estimate::deck::{DeckEstimator, Observed};
use crate::estimate::latency::LatencyEstimator;
use crate::estimate::relative::{DeckPrior, ImuModel, RelativeFilter, TagModel};
use crate::guidance::Guidance;
use crate::planner::{self, Planner};
use crate::state_machine::StateMachine;

/// The descent's shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum DescentShape {
    /// Critically damped (eq. 13); it begins as soon as the vehicle is ready.
    Exponential,
    /// A quintic to a terminal sink rate.
    #[default]
    Terminal,
}

/// What is expected of the course of a deck under way, before any reading and without a broadcast.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct CoursePrior<R> {
    /// Velocity on each axis, standard deviation, m/s.
    pub velocity_sd_mps: R,
    /// Acceleration on each axis, standard deviation, m/s²; at least 0.4 rad/s times the deck's speed, up to 4 m/s².
    pub acceleration_sd_mps2: R,
    /// Correlation time of the acceleration, s.
    pub acceleration_s: R,
    /// Velocity relative to the vehicle on each axis before anything is known of the deck, standard deviation, m/s: such a landing
    /// begins alongside. 0 for a deck whose velocity has nothing to do with the vehicle's.
    #[cfg_attr(feature = "serde", serde(default = "follows_sd_mps"))]
    pub follows_sd_mps: R,
}

#[cfg(feature = "serde")]
fn follows_sd_mps<R: Real>() -> R {
    CoursePrior::default().follows_sd_mps
}

impl<R: Real> Default for CoursePrior<R> {
    /// 8 m/s: cars at 15 m/s are within two standard deviations. 1.5 m/s²: what slow decks have; of a fast one more is expected. 4 s: of a
    /// turn or a change of speed. Of 600 landings of the 1.37 kg vehicle and 600 of 4 kg without a broadcast in turns at 10 m/s (`turns.toml`, seeds
    /// 9401 and 9402) 585 and 589 succeed, with half of the time 572 and 560, with twice 576 and 586 (these without the limit of 4 m/s², and all with a deck estimator
    /// for periods from 0.8 s on). 3 m/s: a vehicle that waits beside the
    /// course of a slow ship is within one standard deviation. Other effects of halving and doubling were not measured.
    fn default() -> Self {
        Self {
            velocity_sd_mps: r(8.0),
            acceleration_sd_mps2: r(1.5),
            acceleration_s: r(4.0),
            follows_sd_mps: r(3.0),
        }
    }
}

impl<R: Real> CoursePrior<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Deviations must not be negative, the time must be positive.
    pub fn validate(&self) -> Result<(), SettingsError> {
        not_negative("course.velocity_sd_mps", self.velocity_sd_mps)?;
        not_negative("course.acceleration_sd_mps2", self.acceleration_sd_mps2)?;
        positive("course.acceleration_s", self.acceleration_s)?;
        not_negative("course.follows_sd_mps", self.follows_sd_mps)
    }
}

/// All settings of the landing computer.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: Real + serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct ControlSettings<R: Real> {
    /// The method.
    #[cfg_attr(feature = "serde", serde(rename = "controller"))]
    pub method: Method,
    /// The descent's shape.
    pub reference: DescentShape,
    /// Whether the planner waits for a window and plans the descent (`terminal` only).
    /// Otherwise the descent begins as soon as the vehicle is ready.
    pub planner: bool,
    /// Whether the scale factor of the ground-effect model is adapted.
    pub adaptation: bool,
    /// Whether the deck's estimated acceleration is fed forward.
    pub deck_acceleration: bool,
    /// Rate C of the exponential descent, 1/s.
    pub exponential_per_s: R,
    /// Duration of a terminal descent without planner, s.
    pub terminal_s: R,
    /// Sink rate at touchdown of a terminal descent without planner, m/s.
    pub terminal_sink_mps: R,
    /// Frequency of the deck motion that `imbc` rejects, Hz.
    pub imbc_hz: R,
    /// Time constant with which the thrust follows its demand, as a share of the motors' own, in [0.5, 1]; 1: as the motors do.
    /// `guidance.acting_s` follows: command delay and this share of the motors' time constant. At 1, and 0.07 s, V_L is higher: 0.055 m/s
    /// in place of 0.040 on a deck that heaves by 5 cm at 1 Hz, 0.154 in place of 0.136 at 10 m/s of wind over a sea of 0.5 m. In calm
    /// seas, on cars and in turns it is the same.
    pub motor_lag_share: R,
    /// Gains of the composite law.
    pub gains: Gains<R>,
    /// Horizontal control.
    pub horizontal: Horizontal<R>,
    /// The disturbance observer.
    pub observer: Observer<R>,
    /// The adaptation.
    pub adapting: Adaptation<R>,
    /// Guidance.
    pub guidance: Guidance<R>,
    /// State machine.
    #[cfg_attr(feature = "serde", serde(rename = "lander"))]
    pub state_machine: StateMachine<R>,
    /// Planner.
    pub planning: Planner<R>,
    /// Relative estimator. The assembly replaces positions, rotations and resolutions of
    /// sensors by those of the sensors' settings.
    pub relative: RelativeFilter<R>,
    /// Whether an unknown latency of range, tag and GNSS is estimated.
    pub finds_latency: bool,
    /// Estimator of that latency.
    pub latency: LatencyEstimator<R>,
    /// Whether the deck may be under way: the vehicle then estimates its course, and follows it in every phase.
    pub under_way: bool,
    /// What is expected of such a course.
    pub course: CoursePrior<R>,
    /// Whether the vehicle seeks a deck that is not below, by its broadcast or by a search.
    pub seeks: bool,
    /// The flight there.
    pub seeking: Seek<R>,
    /// Deck estimator.
    pub deck: DeckEstimator<R>,
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
}

/// The planner that flies.
fn planning<R: Real>() -> Planner<R> {
    Planner {
        quiescence: planner::Quiescence {
            // Such a deck is landed on without waiting for the end of its patience.
            tilt_rad: r(0.15),
            ..planner::Quiescence::default()
        },
        descent: planner::Descent {
            // A centimetre above contact, so that tilt and height errors do not
            // cause contact while the vehicle still brakes.
            end_height_m: r(0.11),
            // Contact counts from 0.108 m on, so even a slow touch is detected.
            sink_per_sd: r(0.1),
            duration_min_s: r(2.0),
            ..planner::Descent::default()
        },
        ..Planner::default()
    }
}

impl<R: Real> Default for ControlSettings<R> {
    fn default() -> Self {
        Self {
            method: Method::default(),
            reference: DescentShape::default(),
            planner: true,
            adaptation: false,
            deck_acceleration: true,
            exponential_per_s: r(C_DECK_PER_S),
            terminal_s: r(2.5),
            terminal_sink_mps: r(0.03),
            imbc_hz: r(0.5),
            motor_lag_share: r(0.5),
            // Stiffer than published, so that errors of the deck's predicted acceleration
            // and of the ground-effect model matter less. With much stiffer gains an
            // unknown latency makes the hover oscillate.
            gains: Gains {
                k_p: r(8.0),
                gamma: r(2.5),
                ..Gains::default()
            },
            horizontal: Horizontal::default(),
            observer: Observer::default(),
            adapting: Adaptation::default(),
            guidance: Guidance {
                // The computer predicts position and velocity to now.
                sensing_s: R::ZERO,
                ..Guidance::default()
            },
            state_machine: StateMachine {
                // Contact at 0.1 m plus four standard deviations of the height. A vehicle
                // that floats a centimetre above the deck then keeps its thrust.
                touchdown_height_m: r(0.108),
                // A range finder with a latency of 0.1 s that sometimes misses a reading.
                range_age_s: r(0.2),
                // A deck in seas of 4 m: friction of 0.6 holds 0.54 rad, and the thrust reserve, 5 m/s², is more than the 3.4 m/s²
                // with which it heaves at most. At 0.25 rad and 1 m/s nothing lands there.
                deck_tilt_rad: r(0.4),
                deck_speed_mps: r(4.0),
                ..StateMachine::default()
            },
            planning: planning(),
            relative: RelativeFilter {
                // A ship surges and sways.
                deck: DeckPrior {
                    horizontal_velocity_sd_mps: r(0.1),
                    horizontal_velocity_walk: r(0.1),
                    horizontal_acceleration_s: r(1.5),
                    ..DeckPrior::default()
                },
                imu: ImuModel {
                    noise_density: r(0.015),
                    ..ImuModel::default()
                },
                tag: TagModel {
                    noise_sd_m: r(0.001),
                    ..TagModel::default()
                },
                ..RelativeFilter::default()
            },
            finds_latency: true,
            latency: LatencyEstimator::default(),
            under_way: false,
            course: CoursePrior::default(),
            seeks: false,
            seeking: Seek::default(),
            deck: DeckEstimator {
                delay_s: r(0.09),
                // GNSS and accelerometer bias make the vehicle's estimated velocity drift.
                offset_drift: r(0.005),
                offset_rate_drift: r(0.03),
                ..DeckEstimator::new(Observed::Displacement, r(0.006))
            },
            feet: Feet::default(),
            contact_height_m: r(0.11),
            watch_s: r(6.0),
            deck_known_mps: r(0.2),
            least_damping_ratio: r(0.05),
        }
    }
}
