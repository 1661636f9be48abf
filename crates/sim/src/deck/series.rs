//! Measured motions: time series from tables, as cubic splines.

use std::io::Read;

use serde::{Deserialize, Serialize};

use super::rigid::{Axis, DeckCoordinates, RigidDeck};
use super::spline::{MotionSpline, cubic_rates, natural_cubic};
use crate::check;
use crate::error::SimError;

/// A column of a table, times a factor that brings it to SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Name in the header, without blanks at its ends.
    pub column: String,
    /// Factor to s, m or rad; 1 where none is stated.
    #[serde(default = "unit")]
    pub factor: f64,
}

/// A column that is a coordinate of the deck.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Which coordinate.
    pub axis: Axis,
    /// Name in the header, without blanks at its ends.
    pub column: String,
    /// Factor to m or rad; 1 where none is stated.
    #[serde(default = "unit")]
    pub factor: f64,
}

fn unit() -> f64 {
    1.0
}

/// Meaning of a table's columns, and limits of its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SeriesFormat {
    /// Columns whose sum is the time in s (for example hours, minutes, seconds).
    pub time: Vec<Column>,
    /// The coordinates. A coordinate without a column is zero.
    pub channels: Vec<Channel>,
    /// Longest time between two rows, s; a longer one is a gap and an error.
    pub longest_step_s: f64,
    /// Greatest excursion of surge, sway and heave from their means, m.
    pub greatest_excursion_m: f64,
    /// Greatest roll and pitch from their means, rad.
    pub greatest_angle_rad: f64,
}

impl Default for SeriesFormat {
    /// A heave `z_m` over `time_s`, rows at most 1 s apart; excursions within 15 m and 0.8 rad.
    fn default() -> Self {
        Self {
            time: vec![Column {
                column: "time_s".to_owned(),
                factor: 1.0,
            }],
            channels: vec![Channel {
                axis: Axis::Heave,
                column: "z_m".to_owned(),
                factor: 1.0,
            }],
            longest_step_s: 1.0,
            greatest_excursion_m: 15.0,
            greatest_angle_rad: 0.8,
        }
    }
}

/// A measured motion, means removed; times start at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSeries {
    times_s: Vec<f64>,
    values: Vec<[f64; 5]>,
    /// What was removed from each coordinate.
    means: [f64; 5],
}

fn bad(key: &str, row: usize, expected: &str, found: &dyn ToString) -> SimError {
    SimError::Series {
        key: key.to_owned(),
        row,
        expected: expected.to_owned(),
        found: found.to_string(),
    }
}

impl SeriesFormat {
    fn validate(&self) -> Result<(), SimError> {
        check::that(
            !self.time.is_empty(),
            "time",
            "at least one column",
            self.time.len() as f64,
        )?;
        check::that(
            !self.channels.is_empty(),
            "channels",
            "at least one channel",
            self.channels.len() as f64,
        )?;
        let factors = self.channels.iter().map(|c| c.factor);
        for factor in self.time.iter().map(|c| c.factor).chain(factors) {
            check::that(
                factor.is_finite() && factor != 0.0,
                "factor",
                "a finite number other than 0",
                factor,
            )?;
        }
        check::positive("longest_step_s", self.longest_step_s)?;
        check::positive("greatest_excursion_m", self.greatest_excursion_m)?;
        check::positive("greatest_angle_rad", self.greatest_angle_rad)
    }
}

impl MotionSeries {
    /// Reads a table of comma-separated values with a header (which may start
    /// with `#`).
    ///
    /// # Errors
    /// A missing column, a field that is not a number, times that do not increase, a gap,
    /// or a value that is impossible in the stated unit. The error names the key, the row
    /// of data (from 1) and the value.
    pub fn read_csv(table: impl Read, format: &SeriesFormat) -> Result<Self, SimError> {
        format.validate()?;
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(table);
        let header = reader
            .headers()
            .map_err(|e| bad("header", 0, "a header", &e))?
            .clone();
        let find = |column: &str, factor: f64| {
            let name = |field: &str| field.trim_start_matches('#').trim() == column;
            let list = || header.iter().collect::<Vec<_>>().join(", ");
            let mut places = header.iter().enumerate().filter(|(_, field)| name(field));
            match (places.next(), places.next()) {
                (Some((place, _)), None) => Ok((place, factor)),
                (Some((first, _)), Some((second, _))) => {
                    let places = format!("it twice, as columns {} and {}", first + 1, second + 1);
                    Err(bad(column, 0, "one column of this name", &places))
                }
                (None, _) => Err(bad(column, 0, "a column of this name", &list())),
            }
        };
        let times = format.time.iter().map(|c| find(&c.column, c.factor));
        let time: Vec<_> = times.collect::<Result<_, _>>()?;
        let channels = format.channels.iter();
        let channels = channels.map(|c| Ok((c.axis as usize, find(&c.column, c.factor)?)));
        let channels: Vec<_> = channels.collect::<Result<_, SimError>>()?;
        let (mut times_s, mut values) = (Vec::new(), Vec::new());
        for (row, record) in reader.records().enumerate() {
            let record = record.map_err(|e| bad("record", row + 1, "a row like the header", &e))?;
            let number = |(place, factor): (usize, f64)| {
                let field = record.get(place).unwrap_or_default();
                let value = field.parse::<f64>().ok().filter(|v| v.is_finite());
                value.map(|v| factor * v).ok_or_else(|| {
                    bad(
                        &header[place],
                        row + 1,
                        "a finite number",
                        &field.to_owned(),
                    )
                })
            };
            let mut t = 0.0;
            for &column in &time {
                t += number(column)?;
            }
            let mut value = [0.0; 5];
            for &(axis, column) in &channels {
                value[axis] += number(column)?;
            }
            times_s.push(t);
            values.push(value);
        }
        Self::checked(times_s, values, format)
    }

    fn checked(
        mut times_s: Vec<f64>,
        mut values: Vec<[f64; 5]>,
        format: &SeriesFormat,
    ) -> Result<Self, SimError> {
        let rows = times_s.len();
        if rows < 4 {
            return Err(bad("rows", rows, "at least 4 rows", &rows));
        }
        for (row, pair) in times_s.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            let longest = format.longest_step_s;
            if !(step > 0.0 && step <= longest) {
                let expected = format!("a step above 0 and at most {longest} s");
                return Err(bad("time", row + 2, &expected, &format!("{step} s")));
            }
        }
        let start = times_s[0];
        times_s.iter_mut().for_each(|t| *t -= start);
        let mut means = [0.0; 5];
        for axis in 0..5 {
            let first = values[0][axis];
            // The mean of equal values is rounded. The rounding error must not be scaled to a motion.
            let mean = if values.iter().all(|v| v[axis] == first) {
                first
            } else {
                values.iter().map(|v| v[axis]).sum::<f64>() / rows as f64
            };
            means[axis] = mean;
            let (limit, unit) = if axis < 3 {
                (format.greatest_excursion_m, "m")
            } else {
                (format.greatest_angle_rad, "rad")
            };
            for (row, value) in values.iter_mut().enumerate() {
                value[axis] -= mean;
                if value[axis].abs() > limit {
                    let key = ["surge", "sway", "heave", "roll", "pitch"][axis];
                    let expected =
                        format!("at most {limit} {unit} from the mean (is the factor right?)");
                    return Err(bad(key, row + 1, &expected, &value[axis]));
                }
            }
        }
        Ok(Self {
            times_s,
            values,
            means,
        })
    }

    /// Mean roll and pitch of the table, rad, which are left out.
    #[must_use]
    pub fn mean_angles_rad(&self) -> [f64; 2] {
        [self.means[3], self.means[4]]
    }

    /// A heave alone, its mean removed; rows without a height are left out.
    ///
    /// # Errors
    /// Fewer than four rows, or times that do not increase.
    pub fn of_heave(times_s: &[f64], heave_m: &[f64]) -> Result<Self, SimError> {
        let known = times_s.iter().zip(heave_m);
        let known = known.filter(|(t, z)| t.is_finite() && z.is_finite());
        let (times, heave): (Vec<f64>, Vec<f64>) = known.unzip();
        let format = SeriesFormat {
            time: Vec::new(),
            channels: Vec::new(),
            longest_step_s: f64::INFINITY,
            greatest_excursion_m: f64::INFINITY,
            greatest_angle_rad: f64::INFINITY,
        };
        let values = heave.into_iter().map(|z| [0.0, 0.0, z, 0.0, 0.0]).collect();
        Self::checked(times, values, &format)
    }

    /// A series of rows that are known to be good.
    pub(super) fn of(times_s: Vec<f64>, values: Vec<[f64; 5]>) -> Self {
        Self {
            times_s,
            values,
            means: [0.0; 5],
        }
    }

    pub(super) fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Surge, sway, heave, roll and pitch of each row.
    pub(super) fn values(&self) -> &[[f64; 5]] {
        &self.values
    }

    /// One coordinate, row by row.
    pub(super) fn coordinate(&self, axis: usize) -> Vec<f64> {
        self.values.iter().map(|value| value[axis]).collect()
    }

    /// Other values at the same times.
    pub(super) fn with_values(&self, values: Vec<[f64; 5]>) -> Self {
        Self {
            times_s: self.times_s.clone(),
            values,
            means: self.means,
        }
    }

    /// Length of the series, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.times_s[self.times_s.len() - 1]
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.times_s.len()
    }

    /// Significant height of the heave, 4 standard deviations, m.
    #[must_use]
    pub fn significant_height_m(&self) -> f64 {
        let mean = self.values.iter().map(|v| v[2]).sum::<f64>() / self.rows() as f64;
        let square = |v: &[f64; 5]| (v[2] - mean).powi(2);
        4.0 * (self.values.iter().map(square).sum::<f64>() / self.rows() as f64).sqrt()
    }

    /// All coordinates times one factor, so that the heave has the significant
    /// height `height_m`.
    ///
    /// # Errors
    /// The height must not be negative, the series must heave.
    pub fn scaled_to(mut self, height_m: f64) -> Result<Self, SimError> {
        check::not_negative("significant_height_m", height_m)?;
        let measured = self.significant_height_m();
        check::positive("significant height of the series", measured)?;
        let factor = height_m / measured;
        for value in &mut self.values {
            *value = value.map(|v| factor * v);
        }
        Ok(self)
    }

    /// The rows from `start_s` on for `duration_s`, times from 0.
    ///
    /// # Errors
    /// The window must lie within the series.
    pub fn window(&self, start_s: f64, duration_s: f64) -> Result<Self, SimError> {
        let latest = self.duration_s() - duration_s;
        check::positive("duration_s", duration_s)?;
        check::within("start_s", start_s, 0.0, latest)?;
        // The window includes one more row at each end.
        let from = self.times_s.partition_point(|&t| t <= start_s) - 1;
        let to = self.times_s.partition_point(|&t| t < start_s + duration_s);
        let to = to.min(self.rows() - 1);
        let times = &self.times_s[from..=to];
        Ok(Self {
            times_s: times.iter().map(|t| t - start_s).collect(),
            values: self.values[from..=to].to_vec(),
            means: self.means,
        })
    }

    /// A window of the given length at a place drawn from the seed.
    ///
    /// # Errors
    /// The series must be long enough.
    pub fn random_window(&self, duration_s: f64, seed: u64, index: u64) -> Result<Self, SimError> {
        use crate::random::{Purpose, Stream};
        let share = Stream::new(seed, index, Purpose::Deck).uniform();
        self.window(share * (self.duration_s() - duration_s), duration_s)
    }

    /// The deck with this motion.
    #[must_use]
    pub fn deck(&self) -> RigidDeck {
        RigidDeck::Spline(self.spline())
    }

    /// Natural cubic splines through the rows.
    pub(super) fn spline(&self) -> MotionSpline {
        let mut knots = vec![DeckCoordinates::default(); self.rows()];
        for axis in 0..5 {
            let values: Vec<f64> = self.values.iter().map(|v| v[axis]).collect();
            let second = natural_cubic(&self.times_s, &values);
            let rates = cubic_rates(&self.times_s, &values, &second);
            for (i, knot) in knots.iter_mut().enumerate() {
                knot.value[axis] = values[i];
                knot.rate[axis] = rates[i];
                knot.acceleration[axis] = second[i];
            }
        }
        MotionSpline::new(&self.times_s, &knots)
    }
}
