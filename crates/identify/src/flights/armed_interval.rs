//! An armed interval: one run of the motors.

use serde::Serialize;

/// One armed interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArmedInterval {
    /// Motors on (s); absent where the log begins with running motors.
    pub on_s: Option<f64>,
    /// Motors off (s); absent where the log, or what it knows of the throttle, ends before.
    pub off_s: Option<f64>,
    /// The first time at which they are known to run (s).
    pub ran_from_s: f64,
    /// The last time at which they are known to run (s).
    pub ran_until_s: f64,
    /// Rows, from the first with running motors to the last.
    pub rows: [usize; 2],
    /// Height where the feet stood before (m), or else where they stand after; where that was seen.
    pub stood_m: Option<f64>,
    /// How far the height wandered while the vehicle stood before this run, over the whole stand, or from the first stand of
    /// the log to this one (m).
    pub drift_m: f64,
}

impl ArmedInterval {
    /// Motors on and off (s) in words, with `unit`; where one of them is not known, the first or last time at which they ran.
    #[must_use]
    pub fn span(&self, unit: &str) -> (String, String) {
        let of = |known: Option<f64>, ran_s: f64, beyond: &str| match known {
            Some(t) => format!("{t:.2}{unit}"),
            None => format!("{ran_s:.2}{unit} or {beyond}"),
        };
        (
            of(self.on_s, self.ran_from_s, "before"),
            of(self.off_s, self.ran_until_s, "later"),
        )
    }
}
