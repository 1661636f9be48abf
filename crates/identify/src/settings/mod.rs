//! Settings of identification, as they stand in a settings file.

mod check;
mod flights;
mod solver;
mod vehicle;

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use sindy::trajectory::shooting::Shooting;
use touchdown_model::Form;

pub use flights::FlightSettings;
pub use solver::{
    ChoiceSettings, CriterionName, PublishedSettings, SolverName, Sr3Settings, WeakSettings,
};
pub use vehicle::VehicleSettings;

/// Settings of identification; every key has a default.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct IdentificationSettings {
    /// Smoothing and differentiation.
    pub smoothing: SmoothingSettings,
    /// Which solver, and how its fit is chosen.
    pub choice: ChoiceSettings,
    /// SR3.
    pub sr3: Sr3Settings,
    /// The published procedure to the letter, for comparison.
    pub published: PublishedSettings,
    /// The weak form, for comparison.
    pub weak: WeakSettings,
    /// Refinement by multiple shooting.
    pub shooting: ShootingSettings,
    /// Thrust models.
    pub thrust: ThrustSettings,
    /// Ground-effect models.
    pub ground_effect: GroundEffectSettings,
    /// Flights: what is known of the vehicle, and how its logs are read.
    pub flight: FlightSettings,
    /// The vehicle, of stands and flights alike.
    pub vehicle: VehicleSettings,
}

impl IdentificationSettings {
    /// The same with what `other`, a map, says of the vehicle where the settings do not. Mass and rotor radius of
    /// `[flight]` count as those of the vehicle.
    #[must_use]
    pub fn of_vehicle(mut self, other: VehicleSettings) -> Self {
        let of_flight = VehicleSettings {
            mass_kg: self.flight.mass_kg,
            rotor_radius_m: self.flight.rotor_radius_m,
            ..VehicleSettings::default()
        };
        self.vehicle = of_flight.or(self.vehicle).or(other);
        self.flight.mass_kg = self.vehicle.mass_kg;
        self.flight.rotor_radius_m = self.vehicle.rotor_radius_m;
        self
    }
}

/// Savitzky–Golay filter.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SmoothingSettings {
    /// Samples in a window (odd).
    pub window: usize,
    /// Degree of the polynomials.
    pub degree: usize,
    /// Samples in a window for throttle-to-thrust trials, whose sines are faster.
    pub thrust_window: usize,
}

impl Default for SmoothingSettings {
    fn default() -> Self {
        Self {
            window: 41,
            degree: 3,
            thrust_window: 21,
        }
    }
}

/// Multiple shooting.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShootingSettings {
    /// Length of a window (s): some fifty wake lags, so that the free start of each costs little information.
    pub window_s: f64,
    /// Distance between the starts of two windows (s).
    pub stride_s: f64,
    /// Every how many samples a residual is taken.
    pub every: usize,
    /// Standard deviation of the measured force's noise (N), that weighs data against priors. Without it, 0.1 N or a hundredth of the
    /// greatest thrust, whichever is less.
    pub noise_n: Option<f64>,
    /// Steps at most.
    pub max_iterations: usize,
}

impl Default for ShootingSettings {
    fn default() -> Self {
        Self {
            window_s: 10.0,
            stride_s: 10.0,
            every: 3,
            noise_n: None,
            max_iterations: 40,
        }
    }
}

impl ShootingSettings {
    /// Standard deviation of the measured force's noise (N), of logs that reach `greatest_n`: that of the settings, or 0.1 N, for small
    /// vehicles a hundredth of the greatest thrust, as of a load cell made for them. With 0.1 N their data would count less than
    /// priors.
    pub(crate) fn noise_sd_n(&self, greatest_n: f64) -> f64 {
        self.noise_n.unwrap_or(0.1_f64.min(0.01 * greatest_n))
    }

    /// The solver's settings, with the standard deviation of a window's start in the state's unit, for logs that reach `greatest_n`.
    #[must_use]
    pub fn build(&self, start_sd: f64, greatest_n: f64) -> Shooting {
        Shooting {
            window: self.window_s,
            stride: self.stride_s,
            every: self.every,
            start_sd,
            noise_sd: self.noise_sd_n(greatest_n),
            max_iterations: self.max_iterations,
        }
    }
}

/// Form of a thrust model.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ThrustForm {
    /// √T as a polynomial of throttle, at rest.
    StaticSqrt,
    /// T as a polynomial of throttle, at rest.
    StaticThrust,
    /// One lag on every motor's own throttle, then a polynomial for its thrust, summed.
    LaggedMotors,
    /// Eq. (7): x' = (c0 s + c1 - x)/T_m, x = √T, fitted in free run.
    FirstOrder,
    /// Eq. (8): x' as a sparse sum of library terms, by SR3 on derivatives, refined in free run.
    Library,
}

impl ThrustForm {
    /// All forms, in the order of their complexity.
    pub const ALL: [Self; 5] = [
        Self::StaticSqrt,
        Self::StaticThrust,
        Self::LaggedMotors,
        Self::FirstOrder,
        Self::Library,
    ];

    /// The same form in a card.
    #[must_use]
    pub fn of_card(self) -> Form {
        match self {
            Self::StaticSqrt => Form::StaticSqrt,
            Self::StaticThrust => Form::StaticThrust,
            Self::LaggedMotors => Form::LaggedMotors,
            Self::FirstOrder => Form::FirstOrder,
            Self::Library => Form::Library,
        }
    }

    /// The name on the command line and in settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.of_card().name()
    }

    /// The form in a line.
    #[must_use]
    pub fn description(self) -> &'static str {
        self.of_card().description()
    }
}

impl FromStr for ThrustForm {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let found = Self::ALL.into_iter().find(|form| form.name() == text);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("expected one of {names}, found `{text}`")
        })
    }
}

/// What to do about dead time between throttle and measured thrust.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DeadTime {
    /// As `estimate`.
    #[default]
    Auto,
    /// Ignored: the lag takes it in.
    None,
    /// Estimated in free run together with the lag, for every form that has one. It stays where it predicts held-out
    /// parts better.
    Estimate,
    /// For eq. (8): the shift at which the library explains the smoothed derivative best. Quick, and biased by noise and
    /// slow sampling.
    Regression,
}

/// Thrust models.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ThrustSettings {
    /// Form; absent: chosen from the data.
    pub form: Option<ThrustForm>,
    /// Degree of the polynomials in throttle.
    pub degree: usize,
    /// Whether static maps get a battery-voltage term (`s*u`, u in volts).
    pub battery: bool,
    /// First seconds of a plateau that are not used.
    pub settle_s: f64,
    /// Thrust below which plateaus are not used for static maps (N); absent: 0.1 N, for small vehicles a fiftieth of the greatest.
    pub min_thrust_n: Option<f64>,
    /// Candidate terms of eq. (8), in the state `x = √T` and the throttle `s`.
    pub library: Vec<String>,
    /// Whether eq. (8) is refined in free run after SR3.
    pub refine: bool,
    /// Longest lag that is searched for (s).
    pub max_lag_s: f64,
    /// Dead time between throttle and measured thrust, of the measuring chain or of the motors' electronics.
    pub dead_time: DeadTime,
}

impl Default for ThrustSettings {
    fn default() -> Self {
        Self {
            form: None,
            degree: 2,
            battery: false,
            settle_s: 0.8,
            min_thrust_n: None,
            library: touchdown_flight::thrust::Library::<f64>::TERMS
                .map(String::from)
                .to_vec(),
            refine: true,
            max_lag_s: 1.0,
            dead_time: DeadTime::Auto,
        }
    }
}

impl ThrustSettings {
    /// Thrust below which steady points are not used (N), of logs that reach `greatest_n`: that of the settings, or 0.1 N
    /// (a standing rotor on a load cell), for small vehicles a fiftieth of the greatest. A tenth loses the throttles below
    /// 0.3; a five-hundredth keeps rotors that stand.
    pub(crate) fn least_thrust_n(&self, greatest_n: f64) -> f64 {
        self.min_thrust_n.unwrap_or(0.1_f64.min(0.02 * greatest_n))
    }
}

/// Ground-effect models.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct GroundEffectSettings {
    /// Rotor radius R of eq. (2) where the vehicle's own is not known (m).
    pub rotor_radius_m: f64,
    /// Lengths of the bounded functions of height (m). Without them, 0.08, 0.20 and 0.45 m for a rotor radius of 0.12 m, in proportion
    /// for another.
    pub lengths_m: Option<[f64; 3]>,
    /// Candidate terms of eq. (9), in `f`, `s`, `z`, `v_p`, `v_q`. Terms that are zero throughout the data
    /// are left out by themselves.
    pub library: Vec<String>,
    /// Bounds of the lag (s).
    pub lag_bounds_s: [f64; 2],
    /// Limits of f/T that flight obeys.
    pub ratio_limits: [f64; 2],
    /// What flight feeds the model's velocity input with.
    pub velocity_input: touchdown_model::card::VelocityInput,
}

impl Default for GroundEffectSettings {
    fn default() -> Self {
        Self {
            rotor_radius_m: 0.12,
            lengths_m: None,
            library: touchdown_flight::ground_effect::Polynomial::<f64>::TERMS
                .map(String::from)
                .to_vec(),
            lag_bounds_s: [0.02, 3.0],
            ratio_limits: [-0.1, 0.6],
            velocity_input: touchdown_model::card::VelocityInput::NegativeRelative,
        }
    }
}

impl GroundEffectSettings {
    /// Lengths of the bounded functions of height (m), of the settings or by the rotor radius.
    #[must_use]
    pub fn lengths_m(&self) -> [f64; 3] {
        let scale = self.rotor_radius_m / 0.12;
        let default_m = [0.08, 0.20, 0.45].map(|length_m| length_m * scale);
        self.lengths_m.unwrap_or(default_m)
    }
}
