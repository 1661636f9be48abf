//! Maps: how the channels of a trial follow from the columns of a table or a log.

pub(crate) mod apply;
pub(crate) mod by_parts;
mod define;
pub(crate) mod evaluate;
mod median;
mod names;
pub(crate) mod resolve;
pub(crate) mod rows;
mod source;

use crate::{ColumnKind, LogError, Place, Table, inspect};
pub use apply::apply;
use serde::{Deserialize, Serialize};
use sindy_expr::Expr;
use source::Source;
use std::path::Path;
use touchdown_trial::TIME_CHANNEL;

/// How the channels of a trial follow from the columns of a table; a TOML file.
///
/// ```toml
/// schema = 1
/// description = "A thrust stand"
///
/// [channels]                       # channel = 'expression over columns'; time_s is required
/// time_s = '"Time (s)"'            # odd column names in double quotes
/// throttle = '("ESC signal (µs)" - 1000) / 1000'
/// thrust_n = '9.80665e-3 * "Thrust (gf)"'
/// rotor_rpm = '"Motor Electrical Speed (RPM)"'
///
/// [filter]                         # optional
/// keep = '"Thrust (gf)" > -50'     # rows are kept where it is not 0 (nor NaN)
/// median = { rotor_rpm = 5 }       # running median of a channel, in samples, odd
///
/// [[windows]]                      # optional, several; both ends included, of time_s
/// from_s = 9.0
/// to_s = 42.2
/// file = "log10.csv"               # optional: only for files whose path ends so
///
/// [resample]                       # optional: linear, gaps stay gaps
/// period_s = 0.01
/// max_gap_s = 0.5                  # optional: join neighbours up to this far apart
///
/// [vehicle]                        # optional
/// mass_kg = 0.027                  # known to the expressions as mass_kg
/// rotor_radius_m = 0.023
/// arm_m = 0.046                    # distance of the rotors' axes from the centre
/// rotors = 4
/// measured_rotors = 1              # whose thrust the log has, if not all rotors'
/// ```
///
/// A channel may be a list of expressions: the first one whose names all exist is used. A channel in
/// the list `optional` is omitted, with a warning, if none of its expressions can be used.
/// `[define]` holds named expressions, for use in later definitions and in the channels.
///
/// For a log with topics, such as a PX4 ULog, a name is `topic.field`, in quotes if it contains
/// brackets or slashes: `vehicle_local_position.vz`, `"vehicle_attitude.q[0]"`. `topic#1` is the
/// second instance of a topic, `param.NAME` a parameter of the vehicle. Each message of the topic
/// `clock` gives a row, and `time_s` is its stamp. The other topics are interpolated to it:
///
/// ```toml
/// schema = 1
/// clock = ["sensor_combined", "vehicle_acceleration"]   # the first that there is
/// optional = ["battery_v"]
///
/// [define]
/// lift = '-"vehicle_acceleration.xyz[2]"'
///
/// [channels]
/// time_s = 'time_s'
/// specific_force_mps2 = 'lift'
/// battery_v = ['battery_status.voltage_v', 'battery_status.voltage_filtered_v']
///
/// [topics."battery_status"]        # optional, for each topic
/// join = "hold"                    # the latest value; "once": each value in one row only; "linear" is the default
/// valid = 'battery_status.connected != 0'   # messages count where it is not 0 (nor NaN);
///                                  # over the topic's own fields, parameters and definitions
/// offset_s = -0.02                 # added to its stamps
/// limit_s = 2.0                    # farther apart is a gap; ten median steps or 0.05 s by default
/// ```
///
/// The expressions know the columns by name, `row` (the row's number in the file from 0) and, if
/// stated, `mass_kg`. A column with one of these names replaces them. Windows with a `file` apply to
/// that file only; a file without a window is used whole. Each window is resampled on a separate
/// grid, so that no value is interpolated across its ends.
#[derive(Debug, Clone)]
pub struct Map {
    pub(crate) path: String,
    description: String,
    pub(crate) clocks: Option<(Place, Vec<String>)>,
    pub(crate) optional: Vec<String>,
    /// Alternatives of one name follow each other.
    pub(crate) defines: Vec<Rule>,
    /// Alternatives of one channel follow each other.
    pub(crate) channels: Vec<Rule>,
    pub(crate) topics: Vec<Topic>,
    pub(crate) keep: Option<Rule>,
    pub(crate) medians: Vec<(String, usize)>,
    pub(crate) windows: Vec<Window>,
    pub(crate) resample: Option<Resample>,
    vehicle: Vehicle,
}

/// What a map states of the vehicle.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Vehicle {
    /// Mass (kg).
    pub mass_kg: Option<f64>,
    /// Radius of a rotor (m).
    pub rotor_radius_m: Option<f64>,
    /// Distance of the rotors' axes from the centre (m).
    pub arm_m: Option<f64>,
    /// Number of rotors.
    pub rotors: Option<u32>,
    /// Rotors whose thrust the log has.
    pub measured_rotors: Option<u32>,
}

/// One expression and its place in the map.
#[derive(Debug, Clone)]
pub(crate) struct Rule {
    /// The channel; empty for the row filter.
    pub(crate) channel: String,
    pub(crate) place: Place,
    pub(crate) expr: Expr,
}

/// Rules that bring the values of a topic to the stamps of the clock.
#[derive(Debug, Clone)]
pub(crate) struct Topic {
    pub(crate) name: String,
    pub(crate) join: Join,
    /// Conditions for using a message. The first expression whose names are all fields of the topic
    /// decides.
    pub(crate) valid: Vec<Rule>,
    pub(crate) offset_s: f64,
    pub(crate) limit_s: Option<f64>,
}

/// Interpolation between two stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Join {
    /// Linear.
    Linear,
    /// The latest value is held.
    Hold,
    /// A value stands in the first row from its stamp on, and in no other.
    Once,
}

impl Join {
    /// The names in a map.
    pub(crate) const NAMES: [(&'static str, Self); 3] = [
        ("linear", Self::Linear),
        ("hold", Self::Hold),
        ("once", Self::Once),
    ];
}

#[derive(Debug, Clone)]
pub(crate) struct Window {
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    pub(crate) file: Option<String>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Resample {
    pub(crate) period_s: f64,
    pub(crate) max_gap_s: Option<f64>,
}

impl Map {
    /// Reads and checks a map.
    ///
    /// # Errors
    /// [`LogError::Map`], or one with the line and key of what is wrong.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LogError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        match touchdown_files::read_text(path) {
            Ok(text) => Self::parse(&name, &text),
            Err(source) => Err(LogError::Map { path: name, source }),
        }
    }

    /// Checks a map in memory; `path` names it in errors.
    ///
    /// # Errors
    /// [`LogError::MapToml`], [`LogError::MapValue`] or [`LogError::MapExpression`].
    pub fn parse(path: &str, text: &str) -> Result<Self, LogError> {
        Source { path, text }.map()
    }

    /// The map of a table with our own channel names: every column of numbers is the channel of its
    /// name, without conversion.
    ///
    /// # Errors
    /// [`LogError::NeedsMap`] with a map to start from, if there is no column `time_s`; [`LogError::TextChannel`] for a column
    /// of text with the name of a known channel.
    pub fn identity_for(table: &Table) -> Result<Self, LogError> {
        for column in &table.columns {
            if let (ColumnKind::Text { example }, true) =
                (&column.kind, names::is_channel(&column.name))
            {
                return Err(LogError::TextChannel {
                    path: table.path.clone(),
                    found: column.name.clone(),
                    example: example.clone(),
                    why: String::new(),
                });
            }
        }
        if table.column(TIME_CHANNEL).is_none() {
            return Err(LogError::NeedsMap {
                path: table.path.clone(),
                columns: table.names.clone(),
                suggested: inspect(table, None).suggested_map.unwrap_or_default(),
            });
        }
        let place = Place {
            map: table.path.clone(),
            line: 1,
            key: String::new(),
        };
        Ok(Self {
            path: String::new(),
            description: String::new(),
            clocks: None,
            optional: Vec::new(),
            defines: Vec::new(),
            topics: Vec::new(),
            channels: table
                .columns
                .iter()
                .filter(|column| !column.is_text())
                .map(|column| Rule {
                    channel: column.name.clone(),
                    place: place.clone(),
                    expr: Expr::variable(&column.name),
                })
                .collect(),
            keep: None,
            medians: Vec::new(),
            windows: Vec::new(),
            resample: None,
            vehicle: Vehicle::default(),
        })
    }

    /// The map's file; empty for an [identity](Self::identity_for).
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The map's description of itself.
    #[must_use]
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The channels that it makes, in its order.
    pub fn channels(&self) -> impl Iterator<Item = &str> {
        let mut last = "";
        let names = self.channels.iter().map(|rule| rule.channel.as_str());
        names.filter(move |name| std::mem::replace(&mut last, name) != *name)
    }

    /// The vehicle's mass in kg, if the map states it.
    #[must_use]
    pub fn mass_kg(&self) -> Option<f64> {
        self.vehicle.mass_kg
    }

    /// What the map states of the vehicle.
    #[must_use]
    pub fn vehicle(&self) -> Vehicle {
        self.vehicle
    }
}
