//! What a table or a trial holds, which column seems to be the time, and which channels the columns
//! seem to be. Guesses are for messages and suggested maps only: nothing is read by them.

mod file;
mod inspect;
mod jumps;
mod motors;
mod recognise;
mod sample;
pub(crate) mod suggest;
mod tally;
mod time_column;

pub use file::inspect_file;
pub use inspect::{ColumnSummary, Inspection, TimeBase, inspect, inspect_trial};
pub(crate) use time_column::LONG_STEP_S;
