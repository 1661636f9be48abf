//! Settings of the command, as they stand in TOML files.

pub mod defaults;
pub mod rig;

pub use touchdown_campaign::settings_file::{parse, read, to_toml};
