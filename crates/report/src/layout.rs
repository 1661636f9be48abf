//! Where everything stands: panels one below the other with common left and right edges, legends above each.

use crate::canvas::Rect;
use crate::figure::{Figure, Kind, Panel, Series};
use crate::font::{self, Weight};
use crate::scale::{Axis, extent, limits};

/// Sizes of letters in pixels.
pub(crate) const TITLE_SIZE: f32 = 16.0;
pub(crate) const PANEL_TITLE_SIZE: f32 = 13.0;
pub(crate) const LABEL_SIZE: f32 = 13.0;
pub(crate) const TICK_SIZE: f32 = 12.0;
/// Length of the sample of line in a legend.
pub(crate) const SWATCH: f32 = 26.0;

const MARGIN: f32 = 14.0;
const LOWEST_PANEL: f32 = 48.0;
const ROW: f32 = 19.0;

/// A figure with every place decided.
#[derive(Debug)]
pub(crate) struct Layout {
    pub(crate) height: u32,
    pub(crate) title: Vec<String>,
    pub(crate) panels: Vec<PanelLayout>,
}

/// One panel with every place decided.
#[derive(Debug)]
pub(crate) struct PanelLayout {
    pub(crate) plot: Rect,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// Top of the rows with title and legend.
    pub(crate) header_top: f32,
    pub(crate) legend: Vec<LegendEntry>,
    /// Whether x has numbers and a label here.
    pub(crate) x_labelled: bool,
    pub(crate) y_label: Vec<String>,
}

/// A name in the legend, relative to the left edge of the plot and the top of the header.
#[derive(Debug)]
pub(crate) struct LegendEntry {
    pub(crate) series: usize,
    pub(crate) name: String,
    pub(crate) x: f32,
    pub(crate) row: usize,
}

/// Decides all places. Without `headings`, title and legends are left to the surrounding page.
pub(crate) fn layout(figure: &Figure, headings: bool) -> Layout {
    let width = figure.width_px as f32;
    let title = match headings {
        true => font::wrap(
            &figure.title,
            Weight::SemiBold,
            TITLE_SIZE,
            width - 2.0 * MARGIN,
        ),
        false => Vec::new(),
    };
    let legends: Vec<_> = figure
        .panels
        .iter()
        .map(|p| legend(p, width - 110.0, headings))
        .collect();
    let headers: Vec<f32> = legends
        .iter()
        .map(|(_, rows)| *rows as f32 * ROW + 6.0)
        .collect();
    let last = figure.panels.len() - 1;
    let labelled = |index: usize| !figure.share_x || index == last;
    let footer = |index: usize| if labelled(index) { 44.0 } else { 8.0 };

    let fixed = title.len() as f32 * 22.0
        + headers
            .iter()
            .enumerate()
            .map(|(i, header)| header + footer(i))
            .sum::<f32>()
        + MARGIN;
    let weights: f64 = figure.panels.iter().map(|p| p.height_weight).sum();
    let lightest = figure
        .panels
        .iter()
        .map(|p| p.height_weight)
        .fold(f64::INFINITY, f64::min);
    let unit = ((figure.wanted_height_px() as f32 - fixed) / weights as f32)
        .max(LOWEST_PANEL / lightest as f32);

    let (xs, mut ys) = ranges(figure);
    let heights: Vec<f32> = figure
        .panels
        .iter()
        .map(|p| unit * p.height_weight as f32)
        .collect();
    let y_ticks = |height: f32| ((height / 34.0) as usize).clamp(2, 10);
    let y_axes: Vec<Axis> = (0..=last)
        .map(|i| Axis::new(ys[i], figure.panels[i].log_y, y_ticks(heights[i])))
        .collect();
    let widest = y_axes
        .iter()
        .flat_map(|axis| &axis.ticks)
        .map(|tick| tick_width(&tick.label))
        .fold(0.0, f32::max);
    let y_labels: Vec<Vec<String>> = (0..=last)
        .map(|i| y_label(&figure.panels[i].y_label, heights[i]))
        .collect();
    let label_lines = y_labels.iter().map(Vec::len).max().unwrap_or(0);
    let left = (MARGIN + label_lines as f32 * 17.0 + widest.min(0.3 * width) + 10.0).round() + 0.5;
    let right = (width - 24.0).round() + 0.5;

    let mut top = MARGIN + title.len() as f32 * 22.0;
    let mut panels = Vec::with_capacity(figure.panels.len());
    for (index, (panel, (legend, _))) in figure.panels.iter().zip(legends).enumerate() {
        let header_top = top;
        // Half pixels, so that lines along the edges are sharp.
        let plot_top = (top + headers[index] - 0.5).floor() + 0.5;
        let plot = Rect {
            left,
            top: plot_top,
            right,
            bottom: plot_top + heights[index].floor(),
        };
        top = plot.bottom + footer(index);
        let mut x_range = xs[index];
        if panel.equal_aspect && !figure.share_x && !panel.log_x && !panel.log_y {
            (x_range, ys[index]) = equal_scale(x_range, ys[index], &plot);
        }
        let y = Axis::new(ys[index], panel.log_y, y_ticks(heights[index]));
        panels.push(PanelLayout {
            plot,
            x: x_axis(panel, x_range, plot.width()),
            y,
            header_top,
            legend,
            x_labelled: labelled(index),
            y_label: y_labels[index].clone(),
        });
    }
    Layout {
        height: top.ceil().max(figure.wanted_height_px() as f32) as u32,
        title,
        panels,
    }
}

/// As many ticks as their labels leave room for.
fn x_axis(panel: &Panel, range: (f64, f64), width: f32) -> Axis {
    if !panel.categories.is_empty() {
        return Axis::new(range, false, 2).with_categories(&panel.categories);
    }
    let mut target = ((width / 75.0) as usize).clamp(2, 12);
    loop {
        let axis = Axis::new(range, panel.log_x, target);
        let labels = axis.ticks.iter().filter(|tick| !tick.label.is_empty());
        let needed: f32 = labels.map(|tick| tick_width(&tick.label) + 14.0).sum();
        if needed <= width || target <= 2 {
            return axis;
        }
        target -= 1;
    }
}

fn tick_width(label: &str) -> f32 {
    font::width(label, Weight::Regular, TICK_SIZE)
}

/// Label of y on at most two lines along the panel.
fn y_label(label: &str, height: f32) -> Vec<String> {
    let mut lines = font::wrap(label, Weight::Regular, LABEL_SIZE, height + 20.0);
    if lines.len() > 2 {
        let rest = lines.split_off(1).join(" ");
        lines.push(font::fit(&rest, Weight::Regular, LABEL_SIZE, height + 20.0));
    }
    lines
}

/// Entries of the legend and the number of rows with the panel's title.
fn legend(panel: &Panel, room: f32, headings: bool) -> (Vec<LegendEntry>, usize) {
    if !headings {
        return (Vec::new(), 0);
    }
    let mut entries = Vec::new();
    let title = panel.title.as_ref().map_or(0.0, |t| {
        font::width(t, Weight::SemiBold, PANEL_TITLE_SIZE) + 22.0
    });
    let (mut x, mut row) = (title.min(room), 0);
    for (series, Series { name, .. }) in panel
        .series
        .iter()
        .enumerate()
        .filter(|(_, s)| !s.name.is_empty())
    {
        let name = font::fit(name, Weight::Regular, TICK_SIZE, room - SWATCH - 8.0);
        let width = SWATCH + 6.0 + font::width(&name, Weight::Regular, TICK_SIZE);
        if x > 0.0 && x + width > room {
            (x, row) = (0.0, row + 1);
        }
        entries.push(LegendEntry {
            series,
            name,
            x,
            row,
        });
        x += width + 18.0;
    }
    let rows = if entries.is_empty() && panel.title.is_none() {
        0
    } else {
        row + 1
    };
    (entries, rows)
}

/// Limits of x and y of every panel.
fn ranges(figure: &Figure) -> (Vec<(f64, f64)>, Vec<(f64, f64)>) {
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
    (xs, ys)
}

fn x_limits(panels: &[Panel]) -> (f64, f64) {
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

fn y_limits(panel: &Panel, (x_low, x_high): (f64, f64)) -> (f64, f64) {
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
                values.extend(shown(lower).into_iter().chain(shown(upper)))
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
fn equal_scale(x: (f64, f64), y: (f64, f64), plot: &Rect) -> ((f64, f64), (f64, f64)) {
    let per_pixel_x = (x.1 - x.0) / f64::from(plot.width());
    let per_pixel_y = (y.1 - y.0) / f64::from(plot.height());
    let per_pixel = per_pixel_x.max(per_pixel_y);
    let widened = |(low, high): (f64, f64), pixels: f32| {
        let more = 0.5 * (per_pixel * f64::from(pixels) - (high - low)).max(0.0);
        (low - more, high + more)
    };
    (widened(x, plot.width()), widened(y, plot.height()))
}
