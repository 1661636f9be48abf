//! A deck that moves as a rigid body: surge, sway, heave, roll and pitch.
//!
//! The deck is a plane through its centre. World axes: x forward along the
//! ship at rest, y to port, z up; the origin is the mean place of the deck's
//! centre. Attitude is `R = R_y(pitch) R_x(roll)`, whose columns are the deck's
//! axes; the third is its normal. Ground is a deck that does not move.

use std::f64::consts::{FRAC_PI_2, PI};

use serde::{Deserialize, Serialize};

use super::harmonics::{self, Harmonic};
use super::ship::ShipSettings;
use super::spline::MotionSpline;
use super::wave::{Spectrum, Wave, WaveSpectrum};
use super::{DeckMotion, DeckPoint};
use crate::check;
use crate::error::SimError;
use crate::number::vector::{add, cross, scale};
use crate::number::{Number, sin_cos};
use crate::random::{Purpose, Stream};

/// The greatest amplitude of a roll or pitch, rad (45 degrees).
const STEEPEST_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// One coordinate of the deck's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Forward, m.
    Surge,
    /// To port, m.
    Sway,
    /// Up, m.
    Heave,
    /// Port side up, rad.
    Roll,
    /// Bow down, rad.
    Pitch,
}

/// A sine in one coordinate: `A sin(2π f t + φ)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tone {
    /// Which coordinate.
    pub axis: Axis,
    /// Amplitude A, m or rad (roll and pitch: at most π/4).
    pub amplitude: f64,
    /// Frequency f, Hz.
    pub frequency_hz: f64,
    /// Phase φ at t = 0, rad.
    #[serde(default)]
    pub phase_rad: f64,
}

/// Directions of the waves about the mean direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spreading {
    /// All waves travel the same way.
    #[default]
    LongCrested,
    /// The energy has the density `(2/π) cos² θ` within a quarter turn to both sides.
    CosineSquared,
}

/// Halvings of half a turn for a random direction: rounding.
const HALVINGS: usize = 50;

impl Spreading {
    /// The direction θ below which the share `uniform` of the energy lies, rad: the root of
    /// `1/2 + θ/π + sin 2θ/(2π) = uniform`.
    fn direction_rad(self, uniform: f64) -> f64 {
        match self {
            Self::LongCrested => 0.0,
            Self::CosineSquared => {
                let (mut low, mut high) = (-FRAC_PI_2, FRAC_PI_2);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    let below = 0.5 + (middle + 0.5 * (2.0 * middle).sin()) / PI;
                    if below < uniform {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                0.5 * (low + high)
            }
        }
    }
}

/// A sea and the ship in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SeaSettings {
    /// Spectrum of the waves.
    pub spectrum: WaveSpectrum,
    /// Direction in which the waves travel, from the bow's, to port, rad: 0 they come
    /// from astern, π/2 from starboard, π from ahead.
    pub heading_rad: f64,
    /// How the waves' directions spread about that direction.
    pub spreading: Spreading,
    /// The ship.
    pub ship: ShipSettings,
    /// Number of waves of a realisation.
    pub waves: usize,
}

impl Default for SeaSettings {
    /// The default waves on the default ship's bow, from 30 degrees to starboard of ahead.
    fn default() -> Self {
        Self {
            spectrum: WaveSpectrum::default(),
            heading_rad: 5.0 / 6.0 * std::f64::consts::PI,
            spreading: Spreading::default(),
            ship: ShipSettings::default(),
            waves: 100,
        }
    }
}

/// How a deck moves about its mean place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum RigidMotion {
    /// The deck is the ground and does not move. (With braces, so that serde refuses unknown keys.)
    Still {},
    /// Sums of sines.
    Sines {
        /// The sines.
        tones: Vec<Tone>,
    },
    /// Heave at constant speed between ± the amplitude, as on the rig.
    Triangle {
        /// Amplitude, m.
        amplitude_m: f64,
        /// Speed, m/s.
        speed_mps: f64,
        /// Phase at t = 0, rad: 0 is the mean height, rising.
        #[serde(default)]
        phase_rad: f64,
    },
    /// A ship in an irregular sea; the seed determines the waves.
    Sea(SeaSettings),
}

impl Default for RigidMotion {
    fn default() -> Self {
        Self::Still {}
    }
}

impl SeaSettings {
    /// Checks the settings and computes the spectrum.
    pub(crate) fn spectrum(&self, gravity_mps2: f64) -> Result<Spectrum, SimError> {
        check::positive("gravity_mps2", gravity_mps2)?;
        check::finite("heading_rad", self.heading_rad)?;
        check::within("waves", self.waves as f64, 1.0, 100_000.0)?;
        let spectrum = Spectrum::new(&self.spectrum).map_err(|e| e.in_section("spectrum"))?;
        self.ship.validate().map_err(|e| e.in_section("ship"))?;
        Ok(spectrum)
    }

    /// The ship's motion in one realisation of the waves.
    pub(crate) fn waves(
        &self,
        spectrum: &Spectrum,
        gravity_mps2: f64,
        seed: u64,
        index: u64,
    ) -> RigidDeck {
        let (waves, directions) = self.realised(spectrum, seed, index);
        let met = waves.iter().zip(directions);
        let moved = |(wave, heading_rad)| self.ship.response(wave, heading_rad, gravity_mps2);
        RigidDeck::Harmonics(met.map(moved).collect())
    }

    /// The waves of one realisation, and the direction of each from the bow's, rad.
    pub(super) fn realised(
        &self,
        spectrum: &Spectrum,
        seed: u64,
        index: u64,
    ) -> (Vec<Wave>, Vec<f64>) {
        let mut stream = Stream::new(seed, index, Purpose::Deck);
        let waves = spectrum.waves(self.waves, &mut stream);
        let direction = |_: &Wave| {
            let spread = self.spreading != Spreading::LongCrested;
            let uniform = if spread { stream.uniform() } else { 0.5 };
            self.heading_rad + self.spreading.direction_rad(uniform)
        };
        let directions = waves.iter().map(direction).collect();
        (waves, directions)
    }
}

impl From<DeckMotion> for RigidMotion {
    fn from(motion: DeckMotion) -> Self {
        match motion {
            DeckMotion::Still => Self::Still {},
            DeckMotion::Sine {
                amplitude_m,
                frequency_hz,
                phase_rad,
            } => Self::Sines {
                tones: vec![Tone {
                    axis: Axis::Heave,
                    amplitude: amplitude_m,
                    frequency_hz,
                    phase_rad,
                }],
            },
            DeckMotion::Triangle {
                amplitude_m,
                speed_mps,
                phase_rad,
            } => Self::Triangle {
                amplitude_m,
                speed_mps,
                phase_rad,
            },
        }
    }
}

/// Surge, sway, heave in m, roll, pitch in rad, with derivatives per s and s².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeckCoordinates<N = f64> {
    /// The coordinates.
    pub value: [N; 5],
    /// Their first derivatives.
    pub rate: [N; 5],
    /// Their second derivatives.
    pub acceleration: [N; 5],
}

/// The deck at one time, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckPose<N = f64> {
    /// Place of the deck's centre, m.
    pub origin_m: [N; 3],
    /// Its velocity, m/s.
    pub velocity_mps: [N; 3],
    /// Its acceleration, m/s².
    pub acceleration_mps2: [N; 3],
    /// The deck's axes: forward, port, normal.
    pub axes: [[N; 3]; 3],
    /// Angular velocity, rad/s.
    pub angular_velocity: [N; 3],
    /// Angular acceleration, rad/s².
    pub angular_acceleration: [N; 3],
}

impl Default for DeckPose {
    fn default() -> Self {
        DeckCoordinates::default().pose()
    }
}

impl<N: Number> DeckPose<N> {
    /// Velocity of the deck's material point that is `arm_m` (world axes) from
    /// its centre, m/s.
    #[inline]
    #[must_use]
    pub fn point_velocity(&self, arm_m: [N; 3]) -> [N; 3] {
        add(self.velocity_mps, cross(self.angular_velocity, arm_m))
    }
}

impl<N: Number> DeckCoordinates<N> {
    /// Place, axes and velocities of the deck. Angles may be large.
    #[inline(always)]
    #[must_use]
    pub fn pose(&self) -> DeckPose<N> {
        let ((sr, cr), (sp, cp)) = (sin_cos(self.value[3]), sin_cos(self.value[4]));
        let (zero, one) = (cr.splat(0.0), cr.splat(1.0));
        let forward = [cp, zero, -sp];
        let across = [zero, one, zero];
        let (p, q) = (self.rate[3], self.rate[4]);
        let (dp, dq) = (self.acceleration[3], self.acceleration[4]);
        // ω = q e_y + p x_d and x_d' = q e_y × x_d.
        let turning = cross(scale(across, q), scale(forward, p));
        DeckPose {
            origin_m: [self.value[0], self.value[1], self.value[2]],
            velocity_mps: [self.rate[0], self.rate[1], self.rate[2]],
            acceleration_mps2: [
                self.acceleration[0],
                self.acceleration[1],
                self.acceleration[2],
            ],
            axes: [forward, [sp * sr, cr, cp * sr], [sp * cr, -sr, cp * cr]],
            angular_velocity: add(scale(across, q), scale(forward, p)),
            angular_acceleration: add(add(scale(across, dq), scale(forward, dp)), turning),
        }
    }
}

/// A deck with its waves realised: a function of time.
#[derive(Clone, Debug, PartialEq)]
pub enum RigidDeck {
    /// Ground.
    Still,
    /// Vertical motion as on the rig.
    Vertical(DeckMotion),
    /// A sum of sines.
    Harmonics(Vec<Harmonic>),
    /// A tabulated or measured motion.
    Spline(MotionSpline),
}

impl RigidMotion {
    /// Checks the motion and realises its waves; `gravity_mps2` ties the length of
    /// waves to their period.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn build(&self, gravity_mps2: f64, seed: u64, index: u64) -> Result<RigidDeck, SimError> {
        match self {
            Self::Still {} => Ok(RigidDeck::Still),
            Self::Sines { tones } => {
                let harmonics = tones.iter().map(Tone::harmonic);
                Ok(RigidDeck::Harmonics(harmonics.collect::<Result<_, _>>()?))
            }
            &Self::Triangle {
                amplitude_m,
                speed_mps,
                phase_rad,
            } => {
                let motion = DeckMotion::Triangle {
                    amplitude_m,
                    speed_mps,
                    phase_rad,
                };
                motion.validate()?;
                Ok(RigidDeck::Vertical(motion))
            }
            Self::Sea(sea) => {
                let spectrum = sea.spectrum(gravity_mps2)?;
                Ok(sea.waves(&spectrum, gravity_mps2, seed, index))
            }
        }
    }

    /// Checks the motion.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn validate(&self) -> Result<(), SimError> {
        self.build(9.81, 0, 0).map(|_| ())
    }
}

impl Tone {
    fn harmonic(&self) -> Result<Harmonic, SimError> {
        check::not_negative("tones.amplitude", self.amplitude)?;
        if matches!(self.axis, Axis::Roll | Axis::Pitch) {
            check::that(
                self.amplitude <= STEEPEST_RAD,
                "tones.amplitude",
                &format!("at most {STEEPEST_RAD} rad of roll or pitch (angles are in rad)"),
                self.amplitude,
            )?;
        }
        check::positive("tones.frequency_hz", self.frequency_hz)?;
        check::finite("tones.phase_rad", self.phase_rad)?;
        let (sin, cos) = self.phase_rad.sin_cos();
        let only = |value: f64| {
            std::array::from_fn(|axis| {
                if axis == self.axis as usize {
                    value
                } else {
                    0.0
                }
            })
        };
        Ok(Harmonic {
            angular_frequency: std::f64::consts::TAU * self.frequency_hz,
            cosine: only(self.amplitude * sin),
            sine: only(self.amplitude * cos),
        })
    }
}

impl RigidDeck {
    /// The coordinates at the time t.
    #[inline]
    #[must_use]
    pub fn coordinates(&self, time_s: f64) -> DeckCoordinates {
        match self {
            Self::Still => DeckCoordinates::default(),
            Self::Vertical(motion) => {
                let DeckPoint {
                    height_m,
                    velocity_mps,
                } = motion.at(time_s);
                let mut coordinates = DeckCoordinates::default();
                coordinates.value[2] = height_m;
                coordinates.rate[2] = velocity_mps;
                coordinates.acceleration[2] = motion.acceleration_mps2(time_s);
                coordinates
            }
            Self::Harmonics(harmonics) => harmonics::at(harmonics, time_s),
            Self::Spline(spline) => spline.at(time_s),
        }
    }

    /// The deck at the time t.
    #[inline]
    #[must_use]
    pub fn at(&self, time_s: f64) -> DeckPose {
        self.coordinates(time_s).pose()
    }

    /// The same motion from `from_s` to `to_s` as a quintic spline with a knot
    /// every `step_s`, which meets value, rate and acceleration at the knots.
    /// Evaluation then costs the same for one sine and for a thousand waves.
    /// [`Self::greatest_difference`] measures its error, which falls with the
    /// sixth power of the step (in the acceleration with the fourth). Motions
    /// with corners, and splines, are returned as they are.
    ///
    /// # Errors
    /// The step must be positive, the times finite and in order.
    pub fn splined(&self, from_s: f64, to_s: f64, step_s: f64) -> Result<Self, SimError> {
        check::positive("step_s", step_s)?;
        check::finite("from_s", from_s)?;
        check::that(
            to_s.is_finite() && to_s > from_s,
            "to_s",
            "a time after `from_s`",
            to_s,
        )?;
        let Self::Harmonics(harmonics) = self else {
            return Ok(self.clone());
        };
        let count = ((to_s - from_s) / step_s).ceil() as usize;
        let times: Vec<f64> = (0..=count).map(|i| from_s + step_s * i as f64).collect();
        let knots: Vec<_> = times.iter().map(|&t| harmonics::at(harmonics, t)).collect();
        Ok(Self::Spline(MotionSpline::new(&times, &knots)))
    }

    /// Greatest absolute difference to another deck at `samples` times from
    /// `from_s` to `to_s`, in each coordinate and derivative.
    #[must_use]
    pub fn greatest_difference(
        &self,
        other: &Self,
        from_s: f64,
        to_s: f64,
        samples: usize,
    ) -> DeckCoordinates {
        let mut greatest = DeckCoordinates::default();
        for i in 0..samples {
            let t = from_s + (to_s - from_s) * (i as f64 + 0.5) / samples as f64;
            let (a, b) = (self.coordinates(t), other.coordinates(t));
            for axis in 0..5 {
                let keep = |most: &mut f64, a: f64, b: f64| *most = most.max((a - b).abs());
                keep(&mut greatest.value[axis], a.value[axis], b.value[axis]);
                keep(&mut greatest.rate[axis], a.rate[axis], b.rate[axis]);
                keep(
                    &mut greatest.acceleration[axis],
                    a.acceleration[axis],
                    b.acceleration[axis],
                );
            }
        }
        greatest
    }
}

#[cfg(test)]
mod tests {
    use super::Spreading;
    use std::f64::consts::PI;

    #[test]
    fn analytic_directions_of_a_short_crested_sea() {
        let directions = (0..1000).map(|i| {
            let uniform = (f64::from(i) + 0.5) / 1000.0;
            Spreading::CosineSquared.direction_rad(uniform)
        });
        // ∫ (2/π) cos² θ θ² dθ = π²/12 - 1/2; midpoints of 1000 shares, dense at the middle.
        let variance = directions.map(|theta| theta * theta).sum::<f64>() / 1000.0;
        assert!(
            (variance - (PI * PI / 12.0 - 0.5)).abs() < 1e-3,
            "{variance}"
        );
        assert!(Spreading::CosineSquared.direction_rad(0.5).abs() < 1e-14);
        assert_eq!(Spreading::LongCrested.direction_rad(0.9), 0.0);
    }
}
