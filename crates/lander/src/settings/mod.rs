//! Settings of the landing computer, with the defaults that campaigns fly.

mod assembly;

pub use assembly::{LoopTiming, SensorNumbers, VehicleNumbers};

use touchdown_flight::control::Gains;
use touchdown_flight::method::{C_DECK_PER_S, Method};
use touchdown_flight::real::{Real, r};

use crate::computer::Feet;
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
                // A roll of 8 degrees, as the camera sees it with noise; friction holds 0.54 rad.
                // At 0.14 rad 3 of 40 landings on that deck were given up.
                deck_tilt_rad: r(0.25),
                ..StateMachine::default()
            },
            planning: planning(),
            relative: RelativeFilter {
                // A ship surges and sways.
                deck: DeckPrior {
                    horizontal_velocity_sd_mps: r(0.1),
                    horizontal_velocity_walk: r(0.1),
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
