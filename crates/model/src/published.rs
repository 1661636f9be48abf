//! Published models that ship with the toolkit, as cards. They are for comparison: read the warnings.

/// Eq. (11): throttle to thrust, eight terms, as printed.
pub const EQ_11: &str = include_str!("../cards/paper-eq11.toml");

/// Eq. (12): ground-effect force, eleven terms, as printed.
pub const EQ_12: &str = include_str!("../cards/paper-eq12.toml");
