//! Which part of the plane every panel shows.

use crate::figure::{Figure, Kind, Panel};
use crate::scale::{extent, limits};
use crate::shape::Rect;

/// Lower and upper limit.
pub(crate) type Range = (f64, f64);

/// Limits of x and y of every panel.
pub(crate) fn ranges(figure: &Figure) -> [Vec<Range>; 2] {
    let own = |panel: &Panel| {
        panel
            .x_range
            .unwrap_or_else(|| x_limits(std::slice::from_ref(panel)))
    };
    let xs: Vec<_> = if figure.share_x {
        let given = figure.panels.iter().find_map(|p| p.x_range);
        vec![given.unwrap_or_else(|| x_limits(&figure.panels)); figure.panels.len()]
    } else {
        figure.panels.iter().map(own).collect()
    };
    let ys = figure
        .panels
        .iter()
        .zip(&xs)
        .map(|(p, x)| p.y_range.unwrap_or_else(|| y_limits(p, *x)))
        .collect();
    [xs, ys]
}

fn x_limits(panels: &[Panel]) -> Range {
    let log = panels[0].log_x;
    let series = || panels.iter().flat_map(|p| &p.series);
    let names = panels.iter().map(|p| p.categories.len()).max().unwrap_or(0);
    if names > 0 {
        return (-0.5, names as f64 - 0.5);
    }
    let values = series()
        .filter(|s| !matches!(s.kind, Kind::HorizontalLine))
        .flat_map(|s| s.x.iter().copied());
    let half_bar = series()
        .filter(|s| s.kind == Kind::Bars)
        .map(|s| 0.5 * spacing(&s.x))
        .fold(0.0, f64::max);
    let points = series().any(|s| {
        matches!(
            s.kind,
            Kind::Points | Kind::LinesPoints | Kind::ErrorBars { .. }
        )
    });
    let found = extent(values, log);
    if half_bar > 0.0 && !log {
        return limits(
            found.map(|(low, high)| (low - half_bar, high + half_bar)),
            log,
            0.0,
        );
    }
    limits(found, log, if points { 0.02 } else { 0.0 })
}

fn y_limits(panel: &Panel, (x_low, x_high): Range) -> Range {
    let mut values = Vec::new();
    for series in &panel.series {
        let visible = |x: f64| (x_low..=x_high).contains(&x);
        let shown = |column: &[f64]| -> Vec<f64> {
            series
                .x
                .iter()
                .zip(column)
                .filter(|(x, _)| visible(**x))
                .map(|(_, y)| *y)
                .collect()
        };
        match &series.kind {
            Kind::HorizontalLine => values.extend_from_slice(&series.y),
            Kind::VerticalLine => {}
            Kind::Band { lower, upper } => {
                values.extend(shown(lower).into_iter().chain(shown(upper)));
            }
            Kind::ErrorBars { plus_minus } => {
                values.extend(shown(&series.y));
                for sign in [-1.0, 1.0] {
                    let ends: Vec<f64> = series
                        .y
                        .iter()
                        .zip(plus_minus)
                        .map(|(y, e)| y + sign * e)
                        .collect();
                    values.extend(shown(&ends));
                }
            }
            _ => values.extend(shown(&series.y)),
        }
    }
    let bars = panel.series.iter().any(|s| s.kind == Kind::Bars) && !panel.log_y;
    if bars {
        values.push(0.0);
    }
    let (low, high) = limits(
        extent(values.iter().copied(), panel.log_y),
        panel.log_y,
        0.05,
    );
    // Bars stand on the axis: no margin on the side of zero.
    match bars {
        true if values.iter().all(|v| !v.is_finite() || *v >= 0.0) && high > 0.0 => (0.0, high),
        true if values.iter().all(|v| !v.is_finite() || *v <= 0.0) && low < 0.0 => (low, 0.0),
        _ => (low, high),
    }
}

/// Smallest distance of two neighbours, 1 if there is none.
pub(crate) fn spacing(x: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = x.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let smallest = sorted
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|d| *d > 0.0)
        .fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 1.0 }
}

/// Widens one of two ranges so that a unit has the same length on both axes.
pub(crate) fn equal_scale(x: Range, y: Range, plot: &Rect) -> (Range, Range) {
    let per_pixel_x = (x.1 - x.0) / f64::from(plot.width());
    let per_pixel_y = (y.1 - y.0) / f64::from(plot.height());
    let per_pixel = per_pixel_x.max(per_pixel_y);
    let widened = |(low, high): Range, pixels: f32| {
        let more = 0.5 * (per_pixel * f64::from(pixels) - (high - low)).max(0.0);
        (low - more, high + more)
    };
    (widened(x, plot.width()), widened(y, plot.height()))
}
