//! Arguments of `touchdown identify` and `touchdown validate`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use touchdown_identify::settings::ThrustForm;
use touchdown_model::Form;

#[derive(Args, Debug)]
pub(crate) struct IdentifyArgs {
    #[command(subcommand)]
    pub(crate) what: Identify,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Identify {
    /// Identify the thrust from throttle
    ///
    /// Logs of a thrust stand or a force rig need the channels `time_s`, `thrust_n` and `throttle` (or `throttle_1`,
    /// `throttle_2`, ...). `rotor_rpm` and `battery_v` are used where a log has them.
    ///
    /// Logs of flights may have `specific_force_mps2`, or poses at 40 Hz or more, in place of `thrust_n`. They need the
    /// vehicle's mass in --map or --settings. They give the thrust by throttle with the lag and the dead time of the motors,
    /// and the hover throttle of every armed interval. What the data do not support is refused, with the reason.
    #[command(after_help = THRUST)]
    Thrust {
        #[command(flatten)]
        common: IdentifyCommon,
        /// Form of the model [default: the data decide]
        #[arg(long, value_parser = thrust_form())]
        form: Option<ThrustForm>,
        /// Degree of polynomials in throttle [default: 2]
        #[arg(long)]
        degree: Option<usize>,
        /// Add a term for the battery voltage to static maps
        #[arg(long)]
        battery: bool,
        /// Rotors whose thrust the logs have together [default: as many as they have throttles or speeds of, else 1]
        ///
        /// Simulations multiply the thrust by the vehicle's rotors over these. Logs of a whole vehicle need no number.
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
        rotors: Option<u32>,
    },
    /// Identify the ground-effect force from height and motion
    ///
    /// Logs of a force rig need the channels `time_s`, `throttle`, `thrust_n` and `height_m`, and --thrust with the card of
    /// the thrust out of ground effect. `deck_velocity_mps` and `vehicle_velocity_mps` are used where a log has them. All logs
    /// are fitted together.
    ///
    /// Logs of flights have no `thrust_n` and need no thrust card. They need `rotor_radius_m` in the table [flight] of
    /// --settings, and the channels `height_m` and `throttle` or `rotor_rpm`. Hover below two rotor radii and above four,
    /// without landing in between. What a log supports depends on its channels:
    ///
    ///   `specific_force_mps2` (accelerometer along the rotor axis, 9.81 in hover)   curve, lags, effect of climb
    ///   poses at 40 Hz or more                                                      curve, lag of the wake
    ///   slower poses                                                                ratio of thrusts at each hover
    ///
    /// Slower poses compare hovers by `rotor_rpm`, by --thrust CARD, or roughly by throttle. What the data do not support is
    /// refused, with what to record.
    #[command(after_help = GROUND_EFFECT, verbatim_doc_comment)]
    GroundEffect {
        #[command(flatten)]
        common: IdentifyCommon,
        /// Card of the thrust out of ground effect; flights use it only without accelerometer and rotor speed
        #[arg(long)]
        thrust: Option<PathBuf>,
        /// Forms; repeatable [default: all five; `lag` if --out is a single file]
        #[arg(long, value_parser = ground_effect_form())]
        form: Vec<Form>,
    },
}

const THRUST: &str = "\
Examples:
  touchdown identify thrust stand.csv --map examples/maps/thrust-7in-rcbenchmark.toml --out thrust.toml
  touchdown identify thrust rig/thrust_training/*.csv --out thrust.toml
  touchdown identify thrust *.ulg --settings vehicle.toml --out thrust";

const GROUND_EFFECT: &str = "\
Examples:
  touchdown identify ground-effect rig/ground_effect_rich/*.csv --thrust thrust.toml --out models

Flights, with `[flight] mass_kg = 1.4` and `rotor_radius_m = 0.12` in vehicle.toml:
  PX4             touchdown identify ground-effect *.ulg --settings vehicle.toml --out vehicle
  ArduPilot       touchdown identify ground-effect *.BIN --settings vehicle.toml --out vehicle
  motion capture  touchdown identify ground-effect *.csv --map mocap.toml --settings vehicle.toml --out vehicle";

#[derive(Args, Debug)]
pub(crate) struct IdentifyCommon {
    /// Logs: CSV, Parquet, PX4 ULog, ArduPilot DataFlash, MCAP or ROS 1 bag
    #[arg(required = true)]
    pub(crate) logs: Vec<PathBuf>,
    /// Map from columns to channels: a TOML file, or a built-in map (px4, ardupilot, ros, fly)
    ///
    /// Logs of PX4 and ArduPilot, and tables whose columns are channels, need none.
    #[arg(long)]
    pub(crate) map: Option<PathBuf>,
    /// Settings that override the defaults (`touchdown settings identify` prints them all, with comments)
    ///
    /// A TOML file with any of these sections and keys:
    ///
    ///   [smoothing]      window, degree, thrust_window
    ///   [choice]         solver, criterion, folds, seed, effective_rows
    ///   [sr3]            thresholds, nus; or one lambda, one nu
    ///   [published]      threshold, nu (the published procedure to the letter)
    ///   [weak]           half_width_s, spacing, power, generalised
    ///   [shooting]       window_s, stride_s, every, noise_n, max_iterations
    ///   [thrust]         form, degree, battery, settle_s, min_thrust_n, library, refine, max_lag_s, dead_time
    ///   [ground_effect]  rotor_radius_m, lengths_m, library, lag_bounds_s, ratio_limits, velocity_input
    ///   [flight]         mass_kg, rotor_radius_m, height_offset_m, gravity_mps2, idle_throttle, reference_radii, height_bias_radii,
    ///                    least_rate_hz, resamples, seed (logs of flights, without a force sensor)
    ///   [vehicle]        mass_kg, rotor_radius_m, arm_m, rotors, measured_rotors (stands, rigs and flights)
    #[arg(long, verbatim_doc_comment)]
    pub(crate) settings: Option<PathBuf>,
    /// File MODEL.toml for one card from all logs; or a folder for all cards and a report [default: nothing is written]
    ///
    /// The folder gets a card for each log (thrust) or form (ground effect), summary.csv, figures/, report.html and
    /// results.json.
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
}

const VALIDATE: &str = "\
Examples:
  touchdown validate thrust.toml rig/thrust_validation/*.csv
  touchdown validate models/*.toml rig/ground_effect_validation/*.csv --thrust thrust.toml --out validation
  touchdown validate thrust.toml ground-effect.toml flight.ulg --thrust thrust.toml

Flights have no force sensor: mass times specific force is compared. The mass is that of --map or of the thrust card. Thrust \
scale and height offset of each armed interval are free, unless --scale and --height-offset hold them, and are shown.

Without --out nothing is written. The folder of --out gets summary.csv, figures/, report.html and results.json.";

#[derive(Args, Debug)]
#[command(after_help = VALIDATE)]
pub(crate) struct ValidateArgs {
    /// Model cards (.toml) and logs (all other files), in any order
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Map from the logs' columns to channels: a TOML file, or a built-in map (px4, ardupilot, ros, fly)
    #[arg(long)]
    pub(crate) map: Option<PathBuf>,
    /// Card of the thrust out of ground effect; ground-effect cards need it
    #[arg(long)]
    pub(crate) thrust: Option<PathBuf>,
    /// Thrust over that of the card in flights; without it, each armed interval has its own
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    pub(crate) scale: Option<f64>,
    /// Metres added to the heights of flights; without it, each armed interval has its own
    #[arg(long, value_name = "METRES", value_parser = finite, allow_negative_numbers = true)]
    pub(crate) height_offset: Option<f64>,
    /// Folder for tables of errors, plots and a report
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
}

/// Forms of thrust models, by name.
fn thrust_form() -> impl TypedValueParser<Value = ThrustForm> {
    let described = |form: ThrustForm| PossibleValue::new(form.name()).help(form.description());
    PossibleValuesParser::new(ThrustForm::ALL.map(described))
        .try_map(|name| name.parse::<ThrustForm>())
}

/// Forms of ground-effect models, by name.
fn ground_effect_form() -> impl TypedValueParser<Value = Form> {
    let described = |form: Form| PossibleValue::new(form.name()).help(form.description());
    PossibleValuesParser::new(Form::GROUND_EFFECT.map(described))
        .try_map(|name| Form::ground_effect_named(&name).ok_or("no such form"))
}

/// A finite number above zero.
fn positive(text: &str) -> Result<f64, String> {
    match finite(text)? {
        value if value > 0.0 => Ok(value),
        value => Err(format!("expected a number above 0, found {value}")),
    }
}

/// A finite number.
fn finite(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if f64::is_finite(value) => Ok(value),
        _ => Err(format!("expected a finite number, found `{text}`")),
    }
}
