//! Readers of logs with topics, behind one interface.
//!
//! A reader walks a file once, in the order of its bytes, and tells a [`sink::Sink`] what it
//! finds: topics, messages, parameters, and at the end what was lost. Two sinks serve all formats:
//! the [`survey`] of what there is, and the [`extract`]ion of the columns that a map names, which
//! are then [`join`]ed to one clock.

mod built_in;
mod extract;
mod fields;
mod formats;
mod join;
mod joined;
mod log;
mod resets;
mod sink;
mod steps;
mod survey;
mod trial;

pub use formats::{LogFormat, UlogTopic, UlogWriter};
pub use log::Log;
pub use survey::{Field, Survey, Topic};
