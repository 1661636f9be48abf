//! Settings of the landing computer, with the defaults that campaigns fly.

mod assembly;

pub use assembly::{LoopTiming, SensorNumbers, VehicleNumbers};

use touchdown_flight::control::Gains;
use touchdown_flight::method::{C_DECK_PER_S, Method};
use touchdown_flight::real::{Real, r};

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
    /// Critically damped (eq. 13), begun as soon as the vehicle is ready.
    Exponential,
    /// A quintic to a terminal sink rate.
    #[default]
    Terminal,
}

/// Everything of the landing computer that can be set.
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
    /// Whether the planner waits for a window and plans the descent (`terminal`
    /// only); else it goes straight down as soon as the vehicle is ready.
    pub planner: bool,
    /// Whether the strength of the ground-effect model is adapted.
    pub adaptation: bool,
    /// Whether the deck's estimated acceleration is fed forward.
    pub deck_acceleration: bool,
    /// Rate C of the exponential descent, 1/s.
    pub exponential_per_s: R,
    /// Duration of a terminal descent without planner, s.
    pub terminal_s: R,
    /// Its sink rate at touchdown, m/s.
    pub terminal_sink_mps: R,
    /// Frequency that `imbc` is built for, Hz.
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
    /// Relative estimator; places, turns and quanta of sensors are filled in from the
    /// sensors' settings.
    pub relative: RelativeFilter<R>,
    /// Whether a delay of range, tag and GNSS that their stamps do not tell is looked for.
    pub finds_latency: bool,
    /// How it is.
    pub latency: LatencyEstimator<R>,
    /// Deck estimator.
    pub deck: DeckEstimator<R>,
    /// Height below which observer and adaptation stand still, m.
    pub contact_height_m: R,
    /// Time for which the deck is watched before a descent, s.
    pub watch_s: R,
    /// Least heave velocity of a deck that moves, standard deviation, m/s.
    pub deck_known_mps: R,
    /// Least width of the band of its heave, as a damping ratio.
    pub least_damping_ratio: R,
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
            // Stiffer than published: errors of the deck's predicted acceleration and
            // of the ground-effect model show less. Much stiffer, and a latency that is
            // not known makes the hover swing.
            gains: Gains {
                k_p: r(8.0),
                gamma: r(2.5),
                ..Gains::default()
            },
            horizontal: Horizontal::default(),
            observer: Observer::default(),
            adapting: Adaptation::default(),
            guidance: Guidance {
                // The computer predicts to now.
                sensing_s: R::ZERO,
                ..Guidance::default()
            },
            state_machine: StateMachine {
                // Contact at 0.1 m and four standard deviations of the height: a
                // vehicle that floats a centimetre above the deck is not let fall.
                touchdown_height_m: r(0.108),
                // The next reading of a range finder that is 0.1 s late and now and then
                // misses one.
                range_age_s: r(0.2),
                ..StateMachine::default()
            },
            planning: Planner {
                descent: planner::Descent {
                    // A centimetre above contact: tilt and errors of the height do not
                    // make it touch while it still brakes.
                    end_height_m: r(0.11),
                    // Touches are judged at 0.108 m: none is missed for being slow.
                    sink_per_sd: r(0.1),
                    duration_min_s: r(2.0),
                    ..planner::Descent::default()
                },
                ..Planner::default()
            },
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
                // The vehicle's own velocity wanders with GNSS and accelerometer bias.
                offset_drift: r(0.005),
                offset_rate_drift: r(0.03),
                ..DeckEstimator::new(Observed::Displacement, r(0.006))
            },
            contact_height_m: r(0.11),
            watch_s: r(6.0),
            deck_known_mps: r(0.2),
            least_damping_ratio: r(0.05),
        }
    }
}
