//! Fields that were measured on a grid of time and space.

use crate::error::{SindyError, require, same_size};

/// Coordinates may be off an even grid by this share of a step: those of single precision, or of a text with few digits, are.
const EVEN: f64 = 1e-2;
/// Axes at most: time and three dimensions of space.
const AXES: usize = 4;

/// An axis of a grid with even steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    name: String,
    step: f64,
    len: usize,
}

impl Axis {
    /// An axis with these coordinates.
    ///
    /// # Errors
    /// Fewer than two coordinates, coordinates that are not finite or do not increase, and uneven steps.
    pub fn new(name: impl Into<String>, coordinates: &[f64]) -> Result<Self, SindyError> {
        let (name, n) = (name.into(), coordinates.len());
        let [first, .., last] = coordinates else {
            return Err(SindyError::too_short(2, n));
        };
        if let Some(index) = coordinates.iter().position(|c| !c.is_finite()) {
            return Err(SindyError::NotFinite { what: name, index });
        }
        let step = (last - first) / (n - 1) as f64;
        let off = |i: usize| (coordinates[i] - (first + step * i as f64)).abs();
        let worst = (0..n)
            .max_by(|&a, &b| off(a).total_cmp(&off(b)))
            .unwrap_or(0);
        let even = step > 0.0 && off(worst) <= EVEN * step;
        require(
            even,
            "axis",
            "coordinates that increase by even steps",
            format!(
                "`{name}` with {} at place {worst} of {n}, where steps of {step} give {}",
                coordinates[worst],
                first + step * worst as f64
            ),
        )?;
        Self::even(name, step, n)
    }

    /// An axis of `len` points, `step` apart.
    ///
    /// # Errors
    /// Fewer than two points; a step that is not positive and finite.
    pub fn even(name: impl Into<String>, step: f64, len: usize) -> Result<Self, SindyError> {
        if len < 2 {
            return Err(SindyError::too_short(2, len));
        }
        let allowed = step > 0.0 && step.is_finite();
        require(allowed, "step", "positive and finite", step)?;
        let name = name.into();
        Ok(Self { name, step, len })
    }

    /// The axis's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Distance between neighbouring points.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.len
    }
}

/// Fields `u(t, x, ...)`, `v(t, x, ...)`, ... on one grid: time first, then up to three dimensions of space.
///
/// Values are in row-major order: neighbours in memory are neighbours along the last axis. NaN marks a missing sample.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldData {
    axes: Vec<Axis>,
    names: Vec<String>,
    values: Vec<Vec<f64>>,
}

impl FieldData {
    /// Fields by name over `axes`, the axis of time first.
    ///
    /// # Errors
    /// No axis of space or more than three, no fields, two things of one name, a field whose length is not the product of
    /// the axes' lengths, infinite values.
    pub fn new(axes: Vec<Axis>, fields: Vec<(String, Vec<f64>)>) -> Result<Self, SindyError> {
        let dimensions = (2..=AXES).contains(&axes.len());
        require(
            dimensions,
            "axes",
            "time and one to three of space",
            axes.len(),
        )?;
        require(!fields.is_empty(), "fields", "at least one", "none")?;
        let points: usize = axes.iter().map(Axis::points).product();
        let mut taken: Vec<&str> = axes.iter().map(Axis::name).collect();
        for (name, values) in &fields {
            same_size(
                "values of a field (the product of the axes' points)",
                points,
                values.len(),
            )?;
            if let Some(index) = values.iter().position(|v| v.is_infinite()) {
                let what = name.clone();
                return Err(SindyError::NotFinite { what, index });
            }
            taken.push(name);
        }
        taken.sort_unstable();
        let twice = taken.windows(2).find(|w| w[0] == w[1]);
        require(
            twice.is_none(),
            "names",
            "fields and axes with names of their own",
            format!("`{}` twice", twice.map_or("", |w| w[0])),
        )?;
        let (names, values) = fields.into_iter().unzip();
        Ok(Self {
            axes,
            names,
            values,
        })
    }

    /// The axes, time first.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// The fields' names.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The values of a field, by its place among the names.
    ///
    /// # Panics
    /// If there is no such field.
    #[must_use]
    pub fn values(&self, field: usize) -> &[f64] {
        &self.values[field]
    }

    pub(super) fn set(&mut self, field: usize, place: usize, value: f64) {
        self.values[field][place] = value;
    }

    /// Points of the grid.
    #[must_use]
    pub fn points(&self) -> usize {
        self.axes.iter().map(Axis::points).product()
    }

    /// Lines of a field along an axis, about `count` of them, evenly spread over the others, without those that lack a value.
    pub(super) fn lines(&self, field: usize, axis: usize, count: usize) -> Vec<Vec<f64>> {
        let inner: usize = self.axes[axis + 1..].iter().map(Axis::points).product();
        let (len, values) = (self.axes[axis].len, &self.values[field]);
        let lines = values.len() / len;
        let stride = (lines / count).max(1);
        (0..lines)
            .skip(stride / 2)
            .step_by(stride)
            .map(|line| {
                let start = line / inner * inner * len + line % inner;
                (0..len).map(|i| values[start + i * inner]).collect()
            })
            .filter(|line: &Vec<f64>| line.iter().all(|v| v.is_finite()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_lines_run_along_their_axis() {
        let axes = vec![
            Axis::even("t", 0.1, 2).unwrap(),
            Axis::even("x", 1.0, 3).unwrap(),
            Axis::even("y", 1.0, 4).unwrap(),
        ];
        let values = (0..24).map(f64::from).collect();
        let data = FieldData::new(axes, vec![("u".to_owned(), values)]).unwrap();
        assert_eq!(data.lines(0, 2, 100)[1], [4.0, 5.0, 6.0, 7.0]);
        assert_eq!(data.lines(0, 1, 100)[5], [13.0, 17.0, 21.0]);
        assert_eq!(data.lines(0, 0, 100)[7], [7.0, 19.0]);
    }

    #[test]
    fn prop_uneven_axes_and_wrong_lengths_are_refused() {
        let said = Axis::new("x", &[0.0, 1.0, 2.5, 3.0])
            .unwrap_err()
            .to_string();
        assert!(said.contains("2.5 at place 2"), "{said}");
        assert!(Axis::new("x", &[0.0, 0.1_f32.into(), 0.2_f32.into()]).is_ok());
        assert!(Axis::new("x", &[1.0, 0.0]).is_err());
        let axes = || {
            vec![
                Axis::even("t", 0.1, 2).unwrap(),
                Axis::even("x", 1.0, 3).unwrap(),
            ]
        };
        let field = |name: &str, n| vec![(name.to_owned(), vec![0.0; n])];
        assert!(FieldData::new(axes(), field("u", 6)).is_ok());
        assert!(FieldData::new(axes(), field("u", 5)).is_err());
        assert!(FieldData::new(axes(), field("x", 6)).is_err());
        assert!(FieldData::new(axes()[..1].to_vec(), field("u", 2)).is_err());
    }
}
