use crate::{Provenance, TrialError};

/// The name under which [`Trial::channel`] gives the stamps.
pub const TIME_CHANNEL: &str = "time_s";

/// One experiment: stamps, channels of the same length, a name and a provenance.
///
/// Invariants, kept by every method: stamps are finite and strictly increasing; every channel has
/// as many values as there are stamps; a value is finite or NaN, and NaN is a gap; channel names
/// are unique and none is `time_s`. Channels keep the order in which they came.
///
/// There is no `PartialEq`: a gap equals nothing, not even itself.
#[derive(Debug, Clone)]
pub struct Trial {
    pub(crate) name: String,
    pub(crate) time_s: Vec<f64>,
    pub(crate) channels: Vec<(String, Vec<f64>)>,
    pub(crate) provenance: Provenance,
}

impl Trial {
    /// A trial without channels.
    ///
    /// # Errors
    /// [`TrialError::TimeNotFinite`] or [`TrialError::TimeNotIncreasing`] with the first bad stamp.
    pub fn new(name: impl Into<String>, time_s: Vec<f64>) -> Result<Self, TrialError> {
        if let Some(row) = time_s.iter().position(|t| !t.is_finite()) {
            let found = time_s[row];
            return Err(TrialError::TimeNotFinite { row, found });
        }
        if let Some(row) = time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(TrialError::TimeNotIncreasing {
                row: row + 1,
                previous: time_s[row],
                found: time_s[row + 1],
            });
        }
        Ok(Self {
            name: name.into(),
            time_s,
            channels: Vec::new(),
            provenance: Provenance::default(),
        })
    }

    /// The trial with one more channel.
    ///
    /// # Errors
    /// As [`insert`](Self::insert), and [`TrialError::Duplicate`] where the name is taken.
    pub fn with_channel(
        mut self,
        name: impl Into<String>,
        values: Vec<f64>,
    ) -> Result<Self, TrialError> {
        let channel = name.into();
        if self.channels.iter().any(|(known, _)| *known == channel) {
            return Err(TrialError::Duplicate { channel });
        }
        self.insert(channel, values)?;
        Ok(self)
    }

    /// The trial with another provenance.
    #[must_use]
    pub fn with_provenance(mut self, provenance: Provenance) -> Self {
        self.provenance = provenance;
        self
    }

    /// The trial under another name.
    #[must_use]
    pub fn with_name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Adds a channel, or replaces the values of the channel of that name and gives the old ones.
    ///
    /// # Errors
    /// [`TrialError::ChannelName`], [`TrialError::Length`] or [`TrialError::Infinite`]; the trial
    /// is then as it was.
    pub fn insert(
        &mut self,
        name: impl Into<String>,
        values: Vec<f64>,
    ) -> Result<Option<Vec<f64>>, TrialError> {
        let channel = name.into();
        if let Some(expected) = name_fault(&channel) {
            let found = channel;
            return Err(TrialError::ChannelName { found, expected });
        }
        if values.len() != self.time_s.len() {
            return Err(TrialError::Length {
                channel,
                expected: self.time_s.len(),
                found: values.len(),
            });
        }
        if let Some(row) = values.iter().position(|v| v.is_infinite()) {
            let found = values[row];
            return Err(TrialError::Infinite {
                channel,
                row,
                found,
            });
        }
        match self
            .channels
            .iter_mut()
            .find(|(known, _)| *known == channel)
        {
            Some((_, old)) => Ok(Some(std::mem::replace(old, values))),
            None => {
                self.channels.push((channel, values));
                Ok(None)
            }
        }
    }

    /// Adds one sentence to the notes of the provenance.
    pub fn note(&mut self, sentence: impl Into<String>) {
        self.provenance.notes.push(sentence.into());
    }

    /// The trial's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the numbers came from and what was done to them.
    #[must_use]
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// The stamps, in s.
    #[must_use]
    pub fn time_s(&self) -> &[f64] {
        &self.time_s
    }

    /// A channel's values, or the stamps for `time_s`.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&[f64]> {
        if name == TIME_CHANNEL {
            return Some(&self.time_s);
        }
        self.channels()
            .find_map(|(known, values)| (known == name).then_some(values))
    }

    /// A channel that the caller cannot do without.
    ///
    /// # Errors
    /// [`TrialError::Missing`], which lists the channels that there are.
    pub fn require(&self, name: &str) -> Result<&[f64], TrialError> {
        self.channel(name).ok_or_else(|| TrialError::Missing {
            trial: self.name.clone(),
            channel: name.to_owned(),
            available: std::iter::once(TIME_CHANNEL)
                .chain(self.channels().map(|(known, _)| known))
                .map(str::to_owned)
                .collect(),
        })
    }

    /// The channels in order, without `time_s`.
    pub fn channels(&self) -> impl ExactSizeIterator<Item = (&str, &[f64])> {
        self.channels
            .iter()
            .map(|(name, values)| (name.as_str(), values.as_slice()))
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// From the first stamp to the last, in s; 0 for fewer than two rows.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// The median step between stamps, in s; `None` for fewer than two rows.
    #[must_use]
    pub fn period_s(&self) -> Option<f64> {
        median_step(&self.time_s)
    }

    /// Whether every step is within `rel_tol` times the median step of the median step. True for
    /// fewer than three rows.
    #[must_use]
    pub fn is_uniform(&self, rel_tol: f64) -> bool {
        self.period_s().is_none_or(|period_s| {
            self.time_s
                .windows(2)
                .all(|pair| (pair[1] - pair[0] - period_s).abs() <= rel_tol * period_s)
        })
    }
}

/// What a channel's name should have been, if it may not be `name`.
fn name_fault(name: &str) -> Option<&'static str> {
    if name == TIME_CHANNEL {
        Some("a name other than time_s, which is the trial's own")
    } else if name.is_empty() {
        Some("at least one character")
    } else if name.trim() != name {
        Some("no spaces at its ends")
    } else if name.chars().any(char::is_control) {
        Some("no control characters")
    } else {
        None
    }
}

/// The median of the steps between consecutive values.
pub(crate) fn median_step(values: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    let even = steps.len().is_multiple_of(2);
    let (below, &mut upper, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = below.iter().copied().max_by(f64::total_cmp);
    Some(match lower {
        Some(lower) if even => lower + (upper - lower) / 2.0,
        _ => upper,
    })
}
