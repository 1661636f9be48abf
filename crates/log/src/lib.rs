//! Reads foreign tables and logs into trials by maps, and writes trials.
//!
//! ```text
//! file ──read_csv──> Table ──apply(Map)──> Trial ──write_csv──> file
//!                      └──inspect──> Inspection
//! ```
//!
//! * [`read_csv`] reads any headed table of numbers: byte-order mark, any line end, comma,
//!   semicolon or tab, quoted cells, empty cells and `nan`, date-time stamps. It never guesses a
//!   unit.
//! * A [`Map`] is a small TOML file that states how the channels of a [`Trial`] follow from the
//!   columns: each is an expression. A map can also hold windows, a row filter and resampling.
//!   Data are never edited.
//! * Every reader returns [`Findings`] with its result: counts of read and dropped rows, and
//!   warnings. [`Findings::is_lossy`] states whether input was lost.
//! * With the feature `flight-logs` a `Log` is a PX4 ULog, an ArduPilot DataFlash log, an MCAP
//!   recording or a bag of ROS 1, recognised by its content. `Log::survey` lists its topics, rates
//!   and gaps. `Log::trial` makes a trial by a map, or by the built-in map of its autopilot. Tables
//!   may be Parquet files as well.
//! * [`read_trial`] does both steps, [`write_csv`] writes a trial so that it reads back bit for
//!   bit. [`inspect`] summarises a table and suggests a map; [`inspect_file`] does so in bounded
//!   memory (for Parquet, in that of one row group). [`inspect_mapped`] makes the trial of a map in
//!   the same pass, and holds its channels alone.
//!
//! ```
//! use touchdown_log::{Map, apply, parse_csv};
//!
//! let text = "Time (s),ESC signal (µs),Thrust (gf)\n0,1050,6.1\n0.1,1145,14.6\n";
//! let map = Map::parse("stand.toml", r#"
//! schema = 1
//! [channels]
//! time_s = '"Time (s)"'
//! throttle = '("ESC signal (µs)" - 1000) / 1000'
//! thrust_n = '9.80665e-3 * "Thrust (gf)"'
//! "#)?;
//! let (table, _) = parse_csv("stand.csv", text.as_bytes())?;
//! let (trial, findings) = apply(&table, &map)?;
//! assert_eq!(trial.require("throttle")?, [0.05, 0.145]);
//! assert!(!findings.is_lossy());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//!
//! A small file must not ask for much memory or time. A reader refuses a file beyond a limit with
//! [`LogError::Excess`]. Each limit is far above the logs that vehicles and stands write.
//!
//! | what | at most | why |
//! | --- | --- | --- |
//! | one name, with its parents | 512 bytes | the longest of PX4, ArduPilot and ROS has 80 |
//! | all names of a log | 16 MiB | a log of PX4 has 0.3 MB |
//! | fields of all topics of a log | 262 144 | PX4 has 20 000 |
//! | fields of one topic of JSON | 1024 | further fields are not read |
//! | topics of a log | 4096 | PX4 has 200 |
//! | depth of nested messages | 16 | ROS has 5; JSON may have 128 |
//! | parts of all definitions of ROS | 1 048 576 | a recording of a robot has 10 000 |
//! | columns of a table | 16 384 | spreadsheets have no more |
//! | channels and definitions of a map | 1024, in 1 MiB of text | the largest built-in map has 50 |
//! | one record, one line, one chunk | 64 MiB | a chunk of a recorder has 1 to 4 MiB |
//! | one message of JSON | 8 MiB | it takes 32 times its size while it is read |
//! | unpacked bytes | 64 MiB, and 100 for each packed byte | logs of flights shrink to a tenth |
//! | memory of values | 256 MiB, and 64 bytes for each byte of the file | a number of a text table takes 4 |
//!
//! Time follows from these: every byte, unpacked or not, costs a bounded number of steps, because names and
//! columns are found by hashing.
//!
//! A file must be a regular one. A pipe or a device is refused by name, because logs are read more than once.
//!
//! [`Trial`]: touchdown_trial::Trial

mod error;
mod findings;
mod hashing;
mod inspection;
// Logs and Parquet have limits that text tables have not.
#[cfg_attr(not(feature = "flight-logs"), allow(dead_code))]
mod limits;
// Maps also describe topics, which only logs have.
#[cfg_attr(not(feature = "flight-logs"), allow(dead_code))]
mod map;
mod read;
mod tables;
#[cfg(feature = "flight-logs")]
mod topics;
#[cfg(any(
    feature = "flight-logs",
    all(feature = "parquet", target_family = "wasm")
))]
mod zstd;

pub use error::{ErrorKind, LogError, Place};
pub use findings::Findings;
pub use hashing::sha256;
pub use inspection::{ColumnSummary, Inspection, TimeBase, inspect, inspect_file, inspect_trial};
pub use map::{Map, Vehicle, apply};
pub use read::{inspect_mapped, read_trial};
pub use tables::{Column, ColumnKind, Table, parse_csv, read_csv, read_table, to_csv, write_csv};
#[cfg(feature = "parquet")]
pub use tables::{
    ParquetColumn, ParquetFile, ParquetRows, ParquetValues, read_parquet, to_parquet,
};
#[cfg(feature = "flight-logs")]
pub use topics::{Field, Log, LogFormat, Survey, Topic, UlogTopic, UlogWriter};
