//! Where everything stands: panels one below the other with common left and right edges, legends above each.

use crate::figure::{Figure, Panel, Series};
use crate::font::{self, Weight};
use crate::ranges::{Range, equal_scale, ranges};
use crate::scale::Axis;
use crate::shape::Rect;

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

/// Decides all places. Without `headings`, the figure's title and legends are left to the surrounding page.
pub(crate) fn layout(figure: &Figure, headings: bool) -> Layout {
    // The room of a legend depends on the width of the numbers beside the panels, they on the height of the panels,
    // and that on the rows of the legend: the second time, the width is known.
    let usual = 86.0;
    let first = arrange(figure, headings, usual);
    let left = first
        .panels
        .iter()
        .map(|panel| panel.plot.left)
        .fold(usual, f32::max);
    arrange(figure, headings, left)
}

fn arrange(figure: &Figure, headings: bool, left_expected: f32) -> Layout {
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
        .map(|p| legend(p, width - 24.0 - left_expected, headings))
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
    let heights = panel_heights(figure, fixed);
    let [xs, mut ys] = ranges(figure);
    let y_labels: Vec<Vec<String>> = (0..=last)
        .map(|i| y_label(&figure.panels[i].y_label, heights[i]))
        .collect();
    let label_lines = y_labels.iter().map(Vec::len).max().unwrap_or(0);
    let numbers = widest_y_number(figure, &ys, &heights).min(0.3 * width);
    let left = (MARGIN + label_lines as f32 * 17.0 + numbers + 10.0).round() + 0.5;
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

/// Heights of the plots, where titles, legends and labels of x take `fixed` pixels.
fn panel_heights(figure: &Figure, fixed: f32) -> Vec<f32> {
    let panel_weights = || figure.panels.iter().map(|p| p.height_weight);
    let weights: f64 = panel_weights().sum();
    let lightest = panel_weights().fold(f64::INFINITY, f64::min);
    let unit = ((figure.wanted_height_px() as f32 - fixed) / weights as f32)
        .max(LOWEST_PANEL / lightest as f32);
    panel_weights().map(|weight| unit * weight as f32).collect()
}

/// Width of the widest number beside the panels.
fn widest_y_number(figure: &Figure, ys: &[Range], heights: &[f32]) -> f32 {
    let panels = figure.panels.iter().zip(ys).zip(heights);
    panels
        .flat_map(|((panel, y), height)| Axis::new(*y, panel.log_y, y_ticks(*height)).ticks)
        .map(|tick| tick_width(&tick.label))
        .fold(0.0, f32::max)
}

fn y_ticks(height: f32) -> usize {
    ((height / 34.0) as usize).clamp(2, 10)
}

/// As many ticks as their labels leave room for.
fn x_axis(panel: &Panel, range: Range, width: f32) -> Axis {
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
        // The page has the legends; panels keep their own titles.
        return (Vec::new(), usize::from(panel.title.is_some()));
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
