use thiserror::Error;

/// What can be wrong with a trial, or with what is asked of one.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TrialError {
    /// A stamp is NaN or infinite.
    #[error("time_s, row {row}: expected a finite stamp, found {found}")]
    TimeNotFinite {
        /// Row number from 0.
        row: usize,
        /// The offending stamp.
        found: f64,
    },
    /// A stamp is not after the one before it.
    #[error("time_s, row {row}: expected a stamp after {previous} s, found {found} s")]
    TimeNotIncreasing {
        /// Row number from 0.
        row: usize,
        /// The stamp of the row before.
        previous: f64,
        /// The offending stamp.
        found: f64,
    },
    /// A channel's length differs from that of `time_s`.
    #[error("channel {channel:?}: expected {expected} rows as in time_s, found {found}")]
    Length {
        /// The channel.
        channel: String,
        /// Rows of `time_s`.
        expected: usize,
        /// Rows of the channel.
        found: usize,
    },
    /// A channel holds an infinite value.
    #[error(
        "channel {channel:?}, row {row}: expected a finite value or NaN (a gap), found {found}"
    )]
    Infinite {
        /// The channel.
        channel: String,
        /// Row number from 0.
        row: usize,
        /// The offending value.
        found: f64,
    },
    /// A channel's name is empty, `time_s`, or holds control characters or spaces at its ends.
    #[error("channel name {found:?}: expected {expected}")]
    ChannelName {
        /// The offending name.
        found: String,
        /// What a name may be.
        expected: &'static str,
    },
    /// A channel of this name is already there.
    #[error("channel {channel:?} is there already; replace it with `insert`")]
    Duplicate {
        /// The channel.
        channel: String,
    },
    /// The trial lacks a channel that is needed.
    #[error("trial {trial:?} has no channel {channel:?}; it has {}", list(.available))]
    Missing {
        /// The trial's name.
        trial: String,
        /// The channel that was asked for.
        channel: String,
        /// The channels that there are, `time_s` first.
        available: Vec<String>,
    },
    /// The ends of a window are not numbers in order.
    #[error("window: expected from_s <= to_s, found from_s = {from_s}, to_s = {to_s}")]
    Window {
        /// Start of the window.
        from_s: f64,
        /// End of the window.
        to_s: f64,
    },
    /// A period, or a longest gap, is not a usable number.
    #[error("{key}: expected {expected}, found {found}")]
    Period {
        /// Which setting.
        key: &'static str,
        /// What it may be.
        expected: &'static str,
        /// The offending number.
        found: f64,
    },
}

fn list(names: &[String]) -> String {
    names.join(", ")
}
