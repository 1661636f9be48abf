//! Summary of a table or a trial, with guesses at the time column and at the channels. Guesses only
//! serve messages and suggested maps; no reader uses them.

mod file;
mod inspect;
mod jumps;
mod motors;
mod recognise;
mod sample;
pub(crate) mod suggest;
mod tally;
mod thrust;
mod time_column;
mod units;

pub use file::inspect_file;
pub(crate) use inspect::Inspector;
pub use inspect::{ColumnSummary, Inspection, TimeBase, inspect, inspect_trial};
pub(crate) use time_column::{SLOW_STEP_S, is_slow};
