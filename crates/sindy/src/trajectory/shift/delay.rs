//! A delay of a column, and its text.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::{SindyError, require};

/// The longest delay, and the most delays in one text.
const LONGEST: usize = 100_000;

/// A delayed column: `x@3` is x three samples ago, `x@0.03s` what it was 0.03 units of time ago.
///
/// As a column of its own it is called by the number of samples, `x_ago3`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Delay {
    pub(super) column: String,
    pub(super) by: By,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum By {
    Samples(usize),
    Time(f64),
}

impl Delay {
    /// A delay by whole samples.
    ///
    /// # Errors
    /// A column without a name; a delay of 0 or more than 100 000 samples.
    pub fn samples(column: &str, samples: usize) -> Result<Self, SindyError> {
        if !(1..=LONGEST).contains(&samples) {
            let expected = format!("1 to {LONGEST} samples");
            return Err(SindyError::setting("delay", expected, samples));
        }
        Self::new(column, By::Samples(samples))
    }

    /// A delay by a time, in the unit of the time column. It has to be a whole number of periods of the data
    /// that it is used with.
    ///
    /// # Errors
    /// A column without a name; a delay that is not positive and finite.
    pub fn time(column: &str, delay: f64) -> Result<Self, SindyError> {
        require(
            delay > 0.0 && delay.is_finite(),
            "delay",
            "a positive, finite time",
            delay,
        )?;
        Self::new(column, By::Time(delay))
    }

    fn new(column: &str, by: By) -> Result<Self, SindyError> {
        require(!column.is_empty(), "delay", "a name before `@`", "none")?;
        let column = column.to_string();
        Ok(Self { column, by })
    }

    /// Reads `x@3`, `x@0.03s`, or several delays `x@1..3`. The name is all that stands before the last `@`.
    ///
    /// ```
    /// use sindy::trajectory::shift::Delay;
    /// assert_eq!(Delay::parse("x@1..3")?.len(), 3);
    /// assert_eq!(Delay::parse("v_p@0.02s")?, [Delay::time("v_p", 0.02)?]);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// A text of another form; a delay outside its range.
    pub fn parse(text: &str) -> Result<Vec<Self>, SindyError> {
        let unread = || {
            let expected = "a delay such as `x@3`, `x@1..3` (samples) or `x@0.03s` (time)";
            SindyError::setting("delay", expected, format!("`{text}`"))
        };
        let (column, by) = text.rsplit_once('@').ok_or_else(unread)?;
        let (column, by) = (column.trim(), by.trim());
        if let Some(time) = by.strip_suffix('s') {
            let time = time.trim().parse().map_err(|_| unread())?;
            return Ok(vec![Self::time(column, time)?]);
        }
        let (from, to) = by.split_once("..").unwrap_or((by, by));
        let whole = |text: &str| text.trim().parse::<usize>().map_err(|_| unread());
        let (from, to) = (whole(from)?, whole(to)?);
        if from > to {
            return Err(unread());
        }
        Self::samples(column, to)?;
        (from..=to).map(|n| Self::samples(column, n)).collect()
    }

    /// The column that is delayed.
    #[must_use]
    pub fn column(&self) -> &str {
        &self.column
    }

    /// The delay as whole periods.
    pub(super) fn in_samples(&self, period: Option<f64>) -> Result<usize, SindyError> {
        let time = match self.by {
            By::Samples(samples) => return Ok(samples),
            By::Time(time) => time,
        };
        let Some(period) = period else {
            let expected = "a time column or a period for a delay in time";
            return Err(SindyError::setting("delay", expected, format!("`{self}`")));
        };
        let periods = time / period;
        let whole = periods.round();
        // As exact as the times themselves have to be: a thousandth of a period.
        if (periods - whole).abs() <= 1e-3 && (1.0..=LONGEST as f64).contains(&whole) {
            return Ok(whole as usize);
        }
        let expected = format!("a whole number of periods of {period} (up to {LONGEST})");
        Err(SindyError::setting(
            "delay",
            expected,
            format!("`{self}`, {periods:.3} of them"),
        ))
    }
}

impl fmt::Display for Delay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.by {
            By::Samples(samples) => write!(f, "{}@{samples}", self.column),
            By::Time(time) => write!(f, "{}@{time}s", self.column),
        }
    }
}

impl From<Delay> for String {
    fn from(delay: Delay) -> Self {
        delay.to_string()
    }
}

impl TryFrom<String> for Delay {
    type Error = SindyError;

    fn try_from(text: String) -> Result<Self, SindyError> {
        match &Self::parse(&text)?[..] {
            [delay] => Ok(delay.clone()),
            _ => Err(SindyError::setting(
                "delay",
                "one delay, not a range",
                format!("`{text}`"),
            )),
        }
    }
}
