//! What the commands `touchdown` and `sindy` share.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`status`] | the table of exit statuses |
//! | [`terminal`] | text for people, JSON for programs, progress, and how a command ends |
//! | [`escape`] | characters of names that command a terminal, shown as escapes |
//! | [`manual`] | completions of shells, and manual pages |
//!
//! A command parses its arguments by [`parse`], runs with a [`Terminal`], and ends with [`Terminal::conclude`].

pub mod escape;
mod failure;
mod interrupt;
pub mod manual;
pub mod status;
pub mod terminal;

pub use clap_complete::Shell;
pub use status::{Done, EXIT_STATUS};
pub use terminal::{Output, Terminal, parse};
