//! Curves and points, few enough for a screen.

use serde::Serialize;

/// Points of a series at most. A screen of 4K has 3840 columns; twice or half of this looks the same on it.
const MOST: usize = 4000;

/// One figure.
#[derive(Debug, Serialize)]
pub(crate) struct Plot {
    pub(crate) title: String,
    /// What the horizontal axis shows, with its unit.
    pub(crate) x: &'static str,
    /// What the vertical axis shows, with its unit.
    pub(crate) y: &'static str,
    pub(crate) series: Vec<Series>,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Style {
    Line,
    Points,
    /// A bound of a 95 % interval; `Low` and `High` follow each other.
    Low,
    High,
}

#[derive(Debug, Serialize)]
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) style: Style,
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
}

impl Series {
    /// A series of at most 4000 points. Of more, the least and the greatest of each equal part stay, in their order,
    /// so that no peak is lost.
    pub(crate) fn new(name: impl Into<String>, style: Style, x: &[f64], y: &[f64]) -> Self {
        let rows: Vec<usize> = (0..x.len().min(y.len()))
            .filter(|&i| x[i].is_finite() && y[i].is_finite())
            .collect();
        let kept = if rows.len() <= MOST {
            rows
        } else {
            rows.chunks(rows.len().div_ceil(MOST / 2))
                .flat_map(|part| extremes(part, y))
                .collect()
        };
        Self {
            name: name.into(),
            style,
            x: kept.iter().map(|&i| x[i]).collect(),
            y: kept.iter().map(|&i| y[i]).collect(),
        }
    }
}

/// The rows of the least and the greatest value, in their order.
fn extremes(rows: &[usize], y: &[f64]) -> Vec<usize> {
    let by = |a: &&usize, b: &&usize| y[**a].total_cmp(&y[**b]);
    let ends = [rows.iter().min_by(by), rows.iter().max_by(by)];
    let mut ends: Vec<usize> = ends.into_iter().flatten().copied().collect();
    ends.sort_unstable();
    ends.dedup();
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_long_series_keeps_its_peaks() {
        let x: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut y = vec![0.0; x.len()];
        (y[777], y[54_321]) = (5.0, -7.0);
        let series = Series::new("", Style::Line, &x, &y);
        assert!(series.x.len() <= MOST, "{}", series.x.len());
        assert!(series.x.windows(2).all(|w| w[0] < w[1]));
        let at = |time: f64| {
            series
                .x
                .iter()
                .position(|t| *t == time)
                .map(|i| series.y[i])
        };
        assert_eq!((at(777.0), at(54_321.0)), (Some(5.0), Some(-7.0)));
    }

    #[test]
    fn analytic_gaps_are_left_out() {
        let series = Series::new("", Style::Line, &[0.0, 1.0, 2.0], &[1.0, f64::NAN, 3.0]);
        assert_eq!((series.x, series.y), (vec![0.0, 2.0], vec![1.0, 3.0]));
    }
}
