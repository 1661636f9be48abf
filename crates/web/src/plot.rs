//! Curves and points, few enough for a screen.

use serde::Serialize;
use touchdown_report::{Figure, Kind, Panel};

/// Points of a series at most. A screen of 4K has 3840 columns; twice or half of this looks the same on it.
const MOST: usize = 4000;

/// One pair of axes.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Plot {
    pub(crate) title: String,
    /// What to see; empty where the title says it.
    pub(crate) caption: String,
    /// What the horizontal axis shows, with its unit.
    pub(crate) x: String,
    /// What the vertical axis shows, with its unit.
    pub(crate) y: String,
    pub(crate) log_y: bool,
    pub(crate) series: Vec<Series>,
    /// Places on the horizontal axis.
    pub(crate) marks: Vec<Mark>,
}

/// A place on the horizontal axis, with its name.
#[derive(Debug, Serialize)]
pub(crate) struct Mark {
    name: String,
    x: f64,
}

impl Plot {
    /// The panels of a report's figure. The title stands above the first, the caption below the last.
    pub(crate) fn panels(figure: &Figure) -> Vec<Self> {
        let last = figure.panels.len().saturating_sub(1);
        let panels = figure.panels.iter().enumerate().map(|(k, panel)| Self {
            title: match (&panel.title, k) {
                (Some(title), _) => title.clone(),
                (None, 0) => figure.title.clone(),
                _ => String::new(),
            },
            caption: if k == last {
                figure.caption.clone()
            } else {
                String::new()
            },
            ..Self::of(panel)
        });
        panels.collect()
    }

    fn of(panel: &Panel) -> Self {
        let mut plot = Self {
            x: panel.x_label.clone(),
            y: panel.y_label.clone(),
            log_y: panel.log_y,
            ..Self::default()
        };
        for s in &panel.series {
            let series = |style, y: &[f64]| Series::new(&s.name, style, &s.x, y);
            match &s.kind {
                Kind::Points => plot.series.push(series(Style::Points, &s.y)),
                Kind::LinesPoints => plot.series.push(series(Style::LinePoints, &s.y)),
                Kind::Dashed | Kind::Dotted => plot.series.push(series(Style::Dashed, &s.y)),
                Kind::Band { lower, upper } => {
                    plot.series.push(series(Style::Low, lower));
                    plot.series.push(series(Style::High, upper));
                }
                // The page's grid has this line.
                Kind::HorizontalLine => {}
                Kind::VerticalLine => plot.marks.extend(s.x.iter().map(|&x| Mark {
                    name: s.name.clone(),
                    x,
                })),
                _ => plot.series.push(series(Style::Line, &s.y)),
            }
        }
        plot
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Style {
    Line,
    Dashed,
    LinePoints,
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
        let rows = || (0..x.len().min(y.len())).filter(|&i| x[i].is_finite() && y[i].is_finite());
        let count = rows().count();
        let mut kept = Vec::new();
        if count <= MOST {
            kept.extend(rows());
        } else {
            // A list of all rows of a long series would take half of its memory.
            let length = count.div_ceil(MOST / 2);
            let mut rows = rows();
            for _ in 0..count.div_ceil(length) {
                let part: Vec<usize> = rows.by_ref().take(length).collect();
                kept.extend(extremes(&part, y));
            }
        }
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
