//! What thrust drifts with along a segment: the battery's voltage, or time where no voltage was logged.

/// Unit of time of a drift (s). A prior of 0.3 on the drift in this time is weak for any battery: twice the unit halves it.
pub(super) const DRIFT_S: f64 = 300.0;

/// What thrust drifts with, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Drift {
    /// Neither voltage nor time.
    #[default]
    Unknown,
    /// Battery voltage relative to the mean of all flights (V).
    Voltage(Vec<f64>),
    /// Time since the start of the log, in units of 300 s.
    Time(Vec<f64>),
}

impl Drift {
    /// Along these stamps of a log that started at `start_s`.
    pub(super) fn of_time(time_s: &[f64], start_s: f64) -> Self {
        Self::Time(time_s.iter().map(|t| (t - start_s) / DRIFT_S).collect())
    }

    /// Its value at a row.
    pub(super) fn at(&self, row: usize) -> Option<f64> {
        match self {
            Self::Unknown => None,
            Self::Voltage(values) | Self::Time(values) => Some(values[row]),
        }
    }

    /// The same at these rows only.
    pub(super) fn pick(&self, rows: &[usize]) -> Self {
        let of = |values: &[f64]| rows.iter().map(|&i| values[i]).collect();
        match self {
            Self::Unknown => Self::Unknown,
            Self::Voltage(values) => Self::Voltage(of(values)),
            Self::Time(values) => Self::Time(of(values)),
        }
    }
}

/// The quantity with which thrust drifts, in words.
pub(super) fn drift_name(of_time: bool) -> &'static str {
    if of_time {
        "drift with time"
    } else {
        "battery voltage"
    }
}
