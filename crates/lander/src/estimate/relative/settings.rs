//! Settings of the filter: error models of the sensors, prior of the deck, gate.
//!
//! The defaults are of the order of hobby-grade sensors: a MEMS inertial unit, a laser
//! range finder in whole centimetres, GNSS without corrections.

use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

/// The inertial unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ImuModel<R> {
    /// White noise of the specific force, m/s²/√Hz (a sample's standard
    /// deviation times the root of the time between samples).
    pub noise_density: R,
    /// Bias, standard deviation at the start, m/s².
    pub bias_sd_mps2: R,
    /// Drift of the bias, m/s²/√s.
    pub bias_walk: R,
    /// Error of roll and pitch, standard deviation, rad. Multiplied by g it adds to the
    /// horizontal biases; multiplied by the distance it adds to the errors of range and
    /// tag.
    pub attitude_sd_rad: R,
    /// Latency of the IMU: age of a sample at the end of its step, s.
    pub delay_s: R,
    /// Age from which the last sample counts as stale, s.
    pub stale_s: R,
}

/// The range finder.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: Real + serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct RangeModel<R> {
    /// Position in body axes, from the vehicle's reference point, m.
    pub position_m: Vector<R>,
    /// Direction of the beam in body axes.
    pub direction: Vector<R>,
    /// White noise, standard deviation, m.
    pub noise_sd_m: R,
    /// Additional noise as a share of the distance.
    pub noise_share: R,
    /// Resolution of the readings, m. Its rounding counts as noise with the variance
    /// quantum²/12.
    pub quantum_m: R,
    /// Smallest usable distance, m.
    pub least_m: R,
    /// Largest usable distance, m.
    pub greatest_m: R,
    /// Largest usable angle between the beam and the deck's normal, rad.
    pub greatest_angle_rad: R,
    /// Jitter of the age, standard deviation, s.
    pub jitter_s: R,
    /// Error of the deck's normal, standard deviation on each axis, rad. The computer replaces it by that of the deck it sees.
    #[cfg_attr(feature = "serde", serde(default = "no_tilt"))]
    pub normal_sd_rad: R,
    /// Age from which the last reading counts as stale, s.
    pub stale_s: R,
}

/// The camera and the detection of the tag.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: Real + serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct TagModel<R> {
    /// Position of the camera in body axes, from the reference point, m.
    pub position_m: Vector<R>,
    /// Rotation from camera axes (x right in the image, y down, z along the view) to body
    /// axes.
    pub attitude: Attitude<R>,
    /// Error in addition to the reading's own covariance, standard deviation on each
    /// axis, m.
    pub noise_sd_m: R,
    /// Jitter of the age, standard deviation, s.
    pub jitter_s: R,
    /// Age from which the last reading counts as stale, s.
    pub stale_s: R,
}

/// Velocity by satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct GnssModel<R> {
    /// Horizontal noise on each axis, standard deviation, m/s.
    pub horizontal_sd_mps: R,
    /// Vertical noise, standard deviation, m/s.
    pub vertical_sd_mps: R,
    /// Age from which the last reading counts as stale, s.
    pub stale_s: R,
}

/// The barometer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct BarometerModel<R> {
    /// Noise, standard deviation, m.
    pub noise_sd_m: R,
    /// Random walk of the barometer's zero, m/√s.
    pub drift: R,
    /// Height above the deck below which readings are ignored, because the pressure field
    /// of the rotors disturbs them. The landing computer also uses lower readings where nothing else shows the climb.
    pub trusted_above_m: R,
    /// Age from which the last reading counts as stale, s.
    pub stale_s: R,
}

/// The deck's broadcast of its place and velocity by satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct BeaconModel<R> {
    /// Error of the horizontal place on each axis, standard deviation, m. It changes slowly.
    pub horizontal_sd_m: R,
    /// Error of the height, standard deviation, m.
    pub vertical_sd_m: R,
    /// Error of the deck's horizontal velocity on each axis, standard deviation, m/s.
    pub velocity_sd_mps: R,
    /// Age from which the last reading counts as stale, s.
    pub stale_s: R,
}

/// Prior of the deck's motion.
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
pub struct DeckPrior<R> {
    /// Heave velocity, standard deviation, m/s; 0 for a deck at rest.
    pub heave_velocity_sd_mps: R,
    /// Angular frequency around which heave is expected, rad/s.
    pub heave_angular_frequency: R,
    /// Bandwidth of the heave: damping ratio ζ of the process, in (0, 1]. Use 1 for an
    /// unknown period and 0.1 for a swell of known period.
    pub heave_damping_ratio: R,
    /// Horizontal velocity at the start, standard deviation, m/s. Use 0, and 0 for the
    /// walk, for a deck at rest.
    pub horizontal_velocity_sd_mps: R,
    /// Random walk of the horizontal velocity, m/s/√s.
    pub horizontal_velocity_walk: R,
    /// Horizontal acceleration, standard deviation on each axis, m/s²; 0 for a deck that keeps its velocity.
    #[cfg_attr(feature = "serde", serde(default = "no_acceleration"))]
    pub horizontal_acceleration_sd_mps2: R,
    /// Correlation time of that acceleration, s.
    #[cfg_attr(feature = "serde", serde(default = "horizontal_acceleration_s"))]
    pub horizontal_acceleration_s: R,
}

// Recordings of earlier versions do not have the keys of these.

fn no_tilt<R: Real>() -> R {
    R::ZERO
}

fn no_acceleration<R: Real>() -> R {
    R::ZERO
}

/// A turn or a change of speed of a few seconds. The effect of halving or doubling was not measured.
fn horizontal_acceleration_s<R: Real>() -> R {
    r(3.0)
}

/// Uncertainty before any reading.
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
pub struct InitialSpread<R> {
    /// Relative position on each axis, standard deviation, m.
    pub position_sd_m: R,
    /// Velocity of the vehicle on each axis, standard deviation, m/s.
    pub velocity_sd_mps: R,
    /// Height above the deck at the start, as the operator knows it, m.
    #[cfg_attr(feature = "serde", serde(default = "unknown"))]
    pub height_m: R,
    /// Its standard deviation, m; 0 where the operator does not know the height.
    #[cfg_attr(feature = "serde", serde(default = "unknown"))]
    pub height_sd_m: R,
    /// Horizontal velocity relative to the deck on each axis, standard deviation, m/s, of a vehicle that travels along with it
    /// before the first reading; 0 for a deck that moves independently of the vehicle.
    #[cfg_attr(feature = "serde", serde(default = "unknown"))]
    pub follows_sd_mps: R,
}

/// Of recordings of earlier versions.
#[cfg(feature = "serde")]
fn unknown<R: Real>() -> R {
    R::ZERO
}

/// Limits for the rejection of readings and for divergence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Gate<R> {
    /// A reading whose innovation exceeds this many standard deviations is rejected.
    pub gate_sd: R,
    /// Number of readings in the running mean of the normalised innovation squared.
    pub memory: R,
    /// Mean normalised innovation squared above which the filter counts as diverged. It
    /// is 1 for a consistent filter.
    pub nis_limit: R,
    /// Number of successive rejections of one sensor after which the filter counts as
    /// diverged.
    pub rejections: u32,
}

impl<R: Real> Default for ImuModel<R> {
    /// 0.02 m/s²/√Hz, bias 0.05 m/s², walk 0.002, attitude 0.01 rad, no latency,
    /// stale after 0.05 s.
    fn default() -> Self {
        Self {
            noise_density: r(0.02),
            bias_sd_mps2: r(0.05),
            bias_walk: r(0.002),
            attitude_sd_rad: r(0.01),
            delay_s: R::ZERO,
            stale_s: r(0.05),
        }
    }
}

impl<R: Real> RangeModel<R> {
    /// Whether a distance is usable.
    pub(crate) fn reaches(&self, distance_m: R) -> bool {
        distance_m >= self.least_m && distance_m <= self.greatest_m
    }
}

impl<R: Real> Default for RangeModel<R> {
    /// At the reference point, straight down; 5 mm, whole centimetres, 0.02 to
    /// 12 m, up to 0.6 rad, jitter 1 ms, stale after 0.2 s.
    fn default() -> Self {
        Self {
            position_m: Vector::ZERO,
            direction: -Vector::UP,
            noise_sd_m: r(0.005),
            noise_share: R::ZERO,
            quantum_m: r(0.01),
            least_m: r(0.02),
            greatest_m: r(12.0),
            greatest_angle_rad: r(0.9),
            jitter_s: r(0.001),
            normal_sd_rad: no_tilt(),
            stale_s: r(0.2),
        }
    }
}

impl<R: Real> TagModel<R> {
    /// A camera that looks straight down, the top of its image forward: camera
    /// x, y, z are the body's -y, -x, -z.
    #[must_use]
    pub fn looking_down() -> Attitude<R> {
        Attitude::from_quaternion([R::ZERO, R::ONE, -R::ONE, R::ZERO]).unwrap_or_default()
    }
}

impl<R: Real> Default for TagModel<R> {
    /// At the reference point, looking straight down; 2 mm beside the reading's
    /// own covariance, jitter 2 ms, stale after 0.3 s.
    fn default() -> Self {
        Self {
            position_m: Vector::ZERO,
            attitude: Self::looking_down(),
            noise_sd_m: r(0.002),
            jitter_s: r(0.002),
            stale_s: r(0.3),
        }
    }
}

impl<R: Real> Default for GnssModel<R> {
    /// 0.1 m/s horizontally, 0.15 m/s vertically, stale after 1 s.
    fn default() -> Self {
        Self {
            horizontal_sd_mps: r(0.1),
            vertical_sd_mps: r(0.15),
            stale_s: R::ONE,
        }
    }
}

impl<R: Real> Default for BarometerModel<R> {
    /// 0.15 m, drift 0.02 m/√s, trusted above 3 m, stale after 1 s.
    fn default() -> Self {
        Self {
            noise_sd_m: r(0.15),
            drift: r(0.02),
            trusted_above_m: r(3.0),
            stale_s: R::ONE,
        }
    }
}

impl<R: Real> Default for BeaconModel<R> {
    /// 2 m horizontally, 3 m vertically, 0.15 m/s, stale after 2 s.
    fn default() -> Self {
        Self {
            horizontal_sd_m: r(2.0),
            vertical_sd_m: r(3.0),
            velocity_sd_mps: r(0.15),
            stale_s: r(2.0),
        }
    }
}

impl<R: Real> Default for DeckPrior<R> {
    /// 0.2 m/s of heave around 3 rad/s, damping ratio 0.5; horizontally at rest.
    fn default() -> Self {
        Self {
            heave_velocity_sd_mps: r(0.2),
            heave_angular_frequency: r(3.0),
            heave_damping_ratio: r(0.5),
            horizontal_velocity_sd_mps: R::ZERO,
            horizontal_velocity_walk: R::ZERO,
            horizontal_acceleration_sd_mps2: no_acceleration(),
            horizontal_acceleration_s: horizontal_acceleration_s(),
        }
    }
}

impl<R: Real> Default for InitialSpread<R> {
    /// 10 m, 2 m/s.
    fn default() -> Self {
        Self {
            position_sd_m: r(10.0),
            velocity_sd_mps: r(2.0),
            height_m: R::ZERO,
            height_sd_m: R::ZERO,
            follows_sd_mps: R::ZERO,
        }
    }
}

impl<R: Real> Default for Gate<R> {
    /// Five standard deviations; a mean above 5 over 20 readings, or 10 successive
    /// rejections.
    fn default() -> Self {
        Self {
            gate_sd: r(5.0),
            memory: r(20.0),
            nis_limit: r(5.0),
            rejections: 10,
        }
    }
}
