//! Wind: steady, Dryden turbulence, a single gust, and the wake of a deckhouse.
//!
//! Forming filters of white noise for the Dryden spectra of MIL-F-8785C. The time scale is
//! τ = L/V: a frozen field passes the vehicle at the speed V.
//!
//! ```text
//! along    H_u = σ_u √(2τ) / (1 + τ s)
//! across   H_v = σ_v √τ (1 + √3 τ s)/(1 + τ s)²     (w likewise)
//! ```
//!
//! (for white noise of unit two-sided intensity, so that the variances are σ²).
//! The discrete filters are exact: the distribution does not depend on the step. The first
//! direction is that of the steady wind, or x without steady wind.

use serde::{Deserialize, Serialize};

use super::airwake::AirwakeSettings;
use crate::check;
use crate::error::SimError;
use crate::number::vector::{Vector, add, scale};
use crate::random::{Purpose, Stream};

/// Dryden turbulence with components along the wind, across it and vertical.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrydenSettings {
    /// Standard deviations σ_u, σ_v, σ_w, m/s.
    pub intensity_mps: [f64; 3],
    /// Lengths L_u, L_v, L_w, m.
    pub length_m: [f64; 3],
    /// Speed V at which the field passes, m/s.
    pub passing_mps: f64,
}

impl DrydenSettings {
    /// MIL-F-8785C at low altitude, h from 10 to 1000 ft (3.05 to 304.8 m):
    /// `L_w = h`, `L_u = L_v = h/(0.177 + 0.000823 h)^1.2` in ft,
    /// `σ_w = 0.1 W20`, `σ_u = σ_v = σ_w/(0.177 + 0.000823 h)^0.4`. W20 is the
    /// wind at 20 ft (6.1 m), which is also taken as the passing speed; heights
    /// below 10 ft count as 10 ft.
    ///
    /// # Errors
    /// Height and wind must be positive.
    pub fn low_altitude(height_m: f64, wind_mps: f64) -> Result<Self, SimError> {
        check::positive("height_m", height_m)?;
        check::positive("wind_mps", wind_mps)?;
        let feet = (height_m / 0.3048).clamp(10.0, 1000.0);
        let shape = 0.177 + 0.000_823 * feet;
        let (long, vertical) = (feet / shape.powf(1.2) * 0.3048, feet * 0.3048);
        let sd = 0.1 * wind_mps;
        Ok(Self {
            intensity_mps: [sd / shape.powf(0.4), sd / shape.powf(0.4), sd],
            length_m: [long, long, vertical],
            passing_mps: wind_mps,
        })
    }
}

/// One gust that rises and falls as a cosine (MIL-F-8785C).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GustSettings {
    /// Velocity at its height, world axes, m/s.
    pub velocity_mps: [f64; 3],
    /// Time at which it begins, s.
    pub start_s: f64,
    /// Time of the rise, and of the fall, s.
    pub rise_s: f64,
    /// Time at full speed between rise and fall, s.
    #[serde(default)]
    pub hold_s: f64,
}

impl GustSettings {
    /// Velocity at the time t, m/s.
    #[must_use]
    pub fn at(&self, time_s: f64) -> [f64; 3] {
        let t = time_s - self.start_s;
        let until_end = 2.0 * self.rise_s + self.hold_s - t;
        let share = (t.min(until_end) / self.rise_s).clamp(0.0, 1.0);
        let level = 0.5 * (1.0 - (std::f64::consts::PI * share).cos());
        scale(self.velocity_mps, level)
    }
}

/// The wind of a scenario.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WindSettings {
    /// Steady wind, world axes, m/s.
    pub steady_mps: [f64; 3],
    /// Turbulence of the free stream.
    pub dryden: Option<DrydenSettings>,
    /// A single gust.
    pub gust: Option<GustSettings>,
    /// The wake of a deckhouse, in the steady wind.
    pub airwake: Option<AirwakeSettings>,
}

impl WindSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Velocities must be finite, intensities not negative, lengths, passing
    /// speed and rise positive.
    pub fn validate(&self) -> Result<(), SimError> {
        for value in self.steady_mps {
            check::finite("steady_mps", value)?;
        }
        if let Some(dryden) = &self.dryden {
            for k in 0..3 {
                check::not_negative("dryden.intensity_mps", dryden.intensity_mps[k])?;
                check::positive("dryden.length_m", dryden.length_m[k])?;
            }
            check::positive("dryden.passing_mps", dryden.passing_mps)?;
        }
        if let Some(gust) = &self.gust {
            for value in gust.velocity_mps {
                check::finite("gust.velocity_mps", value)?;
            }
            check::finite("gust.start_s", gust.start_s)?;
            check::positive("gust.rise_s", gust.rise_s)?;
            check::not_negative("gust.hold_s", gust.hold_s)?;
        }
        self.airwake.map_or(Ok(()), |airwake| airwake.validate())
    }
}

/// The two states of a filter across the wind, a = 1/(1 + τ s), b = a²; along
/// it only a is used. Scaled to unit white noise over √(2τ): Var a = 1,
/// Cov(a, b) = Var b = 1/2.
#[derive(Clone, Copy, Debug)]
struct Filter {
    sd: f64,
    across: bool,
    decay: f64,
    step: f64,
    /// Cholesky factor of the noise of one step.
    noise: [f64; 3],
    state: [f64; 2],
}

impl Filter {
    fn new(sd: f64, time_s: f64, across: bool, step_s: f64, stream: &mut Stream) -> Self {
        let r = step_s / time_s;
        let decay = (-r).exp();
        // Covariance of the noise that keeps the process stationary: P - Φ P Φᵀ with
        // Φ = e^-r [[1, 0], [r, 1]].
        let d2 = decay * decay;
        let aa = 1.0 - d2;
        let ab = 0.5 - d2 * (r + 0.5);
        let bb = 0.5 - d2 * (r * r + r + 0.5);
        let first = aa.sqrt();
        let second = ab / first;
        let third = (bb - second * second).max(0.0).sqrt();
        let (w0, w1) = (stream.normal(), stream.normal());
        Self {
            sd,
            across,
            decay,
            step: r,
            noise: [first, second, third],
            state: [w0, 0.5 * (w0 + w1)],
        }
    }

    #[inline]
    fn value(&self) -> f64 {
        let [a, b] = self.state;
        if self.across {
            // σ √τ (√3 a + (1 - √3) b) with a, b scaled by 1/√(2τ): σ/√2 ...; variance σ².
            let root3 = 3.0_f64.sqrt();
            self.sd * std::f64::consts::FRAC_1_SQRT_2 * (root3 * a + (1.0 - root3) * b)
        } else {
            self.sd * a
        }
    }

    #[inline]
    fn advance(&mut self, stream: &mut Stream) {
        let (w0, w1) = (stream.normal(), stream.normal());
        let [a, b] = self.state;
        let [first, second, third] = self.noise;
        self.state = [
            self.decay * a + first * w0,
            self.decay * (self.step * a + b) + second * w0 + third * w1,
        ];
    }
}

/// Wind at the vehicle over time.
#[derive(Clone, Debug)]
pub struct Wind {
    settings: WindSettings,
    axes: [Vector; 3],
    filters: Option<[Filter; 3]>,
    /// Turbulence of the airwake.
    wake: Option<[Filter; 3]>,
    stream: Stream,
    step_s: f64,
    steps: u64,
}

impl Wind {
    /// Checks the settings and starts the wind at t = 0. The turbulence starts in its
    /// stationary distribution.
    ///
    /// # Errors
    /// Those of [`WindSettings::validate`].
    pub fn new(
        settings: &WindSettings,
        step_s: f64,
        seed: u64,
        index: u64,
    ) -> Result<Self, SimError> {
        settings.validate()?;
        check::positive("step_s", step_s)?;
        let mut stream = Stream::new(seed, index, Purpose::Wind);
        let mut filters_of = |dryden: DrydenSettings| {
            std::array::from_fn(|k| {
                let time_s = dryden.length_m[k] / dryden.passing_mps;
                Filter::new(dryden.intensity_mps[k], time_s, k > 0, step_s, &mut stream)
            })
        };
        let filters = settings.dryden.map(&mut filters_of);
        let wake = settings
            .airwake
            .map(|airwake| filters_of(airwake.turbulence(settings)));
        let [x, y, _] = settings.steady_mps;
        let speed = x.hypot(y);
        let (c, s) = if speed > 0.0 {
            (x / speed, y / speed)
        } else {
            (1.0, 0.0)
        };
        Ok(Self {
            settings: *settings,
            axes: [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]],
            filters,
            wake,
            stream,
            step_s,
            steps: 0,
        })
    }

    /// Present velocity of the air at a height above the deck, world axes, m/s.
    #[must_use]
    pub fn velocity_at(&self, height_m: f64) -> [f64; 3] {
        let mut wind = self.velocity_mps();
        if let (Some(airwake), Some(wake)) = (&self.settings.airwake, &self.wake) {
            let share = airwake.share(height_m);
            wind = add(
                wind,
                scale(self.settings.steady_mps, -share * airwake.deficit()),
            );
            for (filter, axis) in wake.iter().zip(self.axes) {
                wind = add(wind, scale(axis, share * filter.value()));
            }
        }
        wind
    }

    /// Present velocity of the free air, world axes, m/s.
    #[inline]
    #[must_use]
    pub fn velocity_mps(&self) -> [f64; 3] {
        let mut wind = self.settings.steady_mps;
        if let Some(gust) = &self.settings.gust {
            wind = add(wind, gust.at(self.steps as f64 * self.step_s));
        }
        if let Some(filters) = &self.filters {
            for (filter, axis) in filters.iter().zip(self.axes) {
                wind = add(wind, scale(axis, filter.value()));
            }
        }
        wind
    }

    /// Whether the wind changes over time.
    #[must_use]
    pub fn changes(&self) -> bool {
        self.filters.is_some() || self.wake.is_some() || self.settings.gust.is_some()
    }

    /// Advances the wind by one step.
    #[inline]
    pub fn step(&mut self) {
        self.steps += 1;
        for filter in self.filters.iter_mut().chain(&mut self.wake).flatten() {
            filter.advance(&mut self.stream);
        }
    }
}
