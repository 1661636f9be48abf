//! Readers of logs with topics, behind one interface.
//!
//! A reader passes over a file once, in the order of its bytes, and reports to a [`sink::Sink`]:
//! topics, messages, parameters, and at the end the losses. Two sinks serve all formats: the
//! [`survey`] of the topics, and the [`extract`]ion of the columns that a map names, which are then
//! [`join`]ed to one clock.

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
