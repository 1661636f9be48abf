//! A figure as a canvas: grid, series, axes, words.

use crate::canvas::{Anchor, Canvas, Ink, Type};
use crate::figure::{Figure, Kind, Panel, Series};
use crate::font::{self, Weight};
use crate::layout::{
    LABEL_SIZE, Layout, PANEL_TITLE_SIZE, PanelLayout, SWATCH, TICK_SIZE, TITLE_SIZE, layout,
};
use crate::raster;
use crate::scale::Tick;
use crate::series::{BAND_ALPHA, LEAST_DOT, View, has_points, line, stroke};
use crate::shape::Rect;
use crate::svg::{self, About};
use crate::{Error, Result, files};
use std::path::{Path, PathBuf};

const INK: [u8; 3] = [0x1f, 0x23, 0x28];
const QUIET: [u8; 3] = [0x55, 0x5b, 0x63];
const GRID: [u8; 3] = [0xe4, 0xe6, 0xea];
const FINE_GRID: [u8; 3] = [0xf2, 0xf3, 0xf5];
const FRAME: [u8; 3] = [0x9a, 0xa1, 0xab];

impl Figure {
    /// The picture as SVG text. Letters are outlines: it needs no font.
    ///
    /// # Errors
    /// When the figure does not make sense (see [`Error`]); data that are not finite are gaps, not errors.
    pub fn svg(&self) -> Result<String> {
        let canvas = self.canvas()?;
        Ok(svg::write(
            &canvas,
            &About {
                title: &self.title,
                description: &self.caption,
            },
        ))
    }

    /// The picture as PNG with `scale` pixels to the CSS pixel (0.1 to 8; 2 suits print and fine screens).
    ///
    /// # Errors
    /// As [`Figure::svg`]; also when `scale` is out of range or the picture cannot be encoded.
    pub fn png(&self, scale: f32) -> Result<Vec<u8>> {
        let canvas = self.canvas()?;
        if !(0.1..=8.0).contains(&scale) {
            return Err(self.setting("scale", "0.1 to 8", scale));
        }
        raster::png(&canvas, scale).map_err(|reason| Error::Png {
            figure: self.id.clone(),
            reason,
        })
    }

    /// Writes `<id>.svg` and `<id>.png` (two pixels to the CSS pixel) into the directory, each whole or not at all,
    /// and returns their paths.
    ///
    /// # Errors
    /// As [`Figure::png`]; also when a file cannot be written.
    pub fn write(&self, directory: impl AsRef<Path>) -> Result<[PathBuf; 2]> {
        let (svg, png) = (self.svg()?, self.png(2.0)?);
        let paths = ["svg", "png"]
            .map(|extension| directory.as_ref().join(format!("{}.{extension}", self.id)));
        files::write_atomic(&paths[0], svg.as_bytes())?;
        files::write_atomic(&paths[1], &png)?;
        Ok(paths)
    }

    fn canvas(&self) -> Result<Canvas> {
        self.check()?;
        let layout = layout(self, true);
        let mut canvas = Canvas {
            width: self.width_px,
            height: layout.height,
            items: Vec::new(),
        };
        draw_title(&mut canvas, &layout);
        for (panel, place) in self.panels.iter().zip(&layout.panels) {
            draw_header(&mut canvas, panel, place);
            draw_grid(&mut canvas, panel, place);
            draw_series(&mut canvas, panel, place);
            draw_axes(&mut canvas, panel, place);
        }
        Ok(canvas)
    }
}

fn draw_title(canvas: &mut Canvas, layout: &Layout) {
    let style = Type {
        size: TITLE_SIZE,
        weight: Weight::SemiBold,
        rgb: INK,
    };
    for (row, text) in layout.title.iter().enumerate() {
        canvas.text(
            text,
            [14.0, 14.0 + TITLE_SIZE * 0.75 + 22.0 * row as f32],
            style,
            Anchor::Start,
        );
    }
}

fn draw_header(canvas: &mut Canvas, panel: &Panel, place: &PanelLayout) {
    let left = place.plot.left;
    let baseline = |row: usize| place.header_top + 14.0 + 19.0 * row as f32;
    if let Some(title) = panel
        .title
        .as_ref()
        .filter(|_| place.header_top < place.plot.top - 12.0)
    {
        let style = Type {
            size: PANEL_TITLE_SIZE,
            weight: Weight::SemiBold,
            rgb: INK,
        };
        let title = font::fit(title, style.weight, style.size, place.plot.width());
        canvas.text(&title, [left, baseline(0)], style, Anchor::Start);
    }
    let style = Type {
        size: TICK_SIZE,
        weight: Weight::Regular,
        rgb: INK,
    };
    for entry in &place.legend {
        let (x, y) = (left + entry.x, baseline(entry.row));
        let rgb = panel.color_of(entry.series).rgb();
        swatch(canvas, &panel.series[entry.series], rgb, [x, y - 4.5]);
        canvas.text(&entry.name, [x + SWATCH + 6.0, y], style, Anchor::Start);
    }
}

/// A sample of the series, from `x` over the width of a swatch, centred on `y`.
fn swatch(canvas: &mut Canvas, series: &Series, rgb: [u8; 3], [x, y]: [f32; 2]) {
    let area = |half: f32| Rect {
        left: x,
        top: y - half,
        right: x + SWATCH,
        bottom: y + half,
    };
    let everywhere = area(20.0);
    let width = series.width as f32;
    match series.kind {
        Kind::Bars => canvas.polygons(&[area(5.0).corners().to_vec()], Ink::solid(rgb), None),
        Kind::Band { .. } => {
            canvas.polygons(
                &[area(5.0).corners().to_vec()],
                Ink {
                    rgb,
                    alpha: BAND_ALPHA,
                },
                None,
            );
        }
        _ => {
            if let Some(stroke) = stroke(series, rgb) {
                canvas.segment([x, y], [x + SWATCH, y], stroke);
            }
        }
    }
    if has_points(&series.kind) {
        canvas.dots(
            vec![[x + 0.5 * SWATCH, y]],
            (1.5 * width).max(LEAST_DOT as f32),
            Ink::solid(rgb),
            everywhere,
        );
    }
}

fn draw_grid(canvas: &mut Canvas, panel: &Panel, place: &PanelLayout) {
    let plot = &place.plot;
    let vertical = |tick: &Tick| {
        let x = crisp(plot.left + place.x.place(tick.value) as f32 * plot.width());
        vec![[x, plot.top], [x, plot.bottom]]
    };
    let horizontal = |tick: &Tick| {
        let y = crisp(plot.bottom - place.y.place(tick.value) as f32 * plot.height());
        vec![[plot.left, y], [plot.right, y]]
    };
    // Fine lines between decades first, then the labelled ones. Named positions need none.
    for (rgb, labelled) in [(FINE_GRID, false), (GRID, true)] {
        let wanted = |tick: &&Tick| tick.label.is_empty() != labelled;
        let mut lines: Vec<_> = place
            .y
            .ticks
            .iter()
            .filter(wanted)
            .map(horizontal)
            .collect();
        if panel.categories.is_empty() {
            lines.extend(place.x.ticks.iter().filter(wanted).map(vertical));
        }
        canvas.lines(&lines, line(rgb, 1.0), None);
    }
}

/// The middle of a pixel: a line of one pixel there is sharp.
fn crisp(v: f32) -> f32 {
    v.floor() + 0.5
}

fn draw_axes(canvas: &mut Canvas, panel: &Panel, place: &PanelLayout) {
    let plot = &place.plot;
    let frame = vec![
        [plot.left, plot.top],
        [plot.left, plot.bottom],
        [plot.right, plot.bottom],
    ];
    canvas.lines(&[frame], line(FRAME, 1.0), None);
    let quiet = Type {
        size: TICK_SIZE,
        weight: Weight::Regular,
        rgb: QUIET,
    };
    for tick in place.y.ticks.iter().filter(|tick| !tick.label.is_empty()) {
        let y = plot.bottom - place.y.place(tick.value) as f32 * plot.height();
        canvas.text(
            &tick.label,
            [plot.left - 7.0, y + 0.36 * TICK_SIZE],
            quiet,
            Anchor::End,
        );
    }
    let label = Type {
        size: LABEL_SIZE,
        weight: Weight::Regular,
        rgb: INK,
    };
    for (row, text) in place.y_label.iter().enumerate() {
        let middle = 0.5 * (plot.top + plot.bottom);
        canvas.text_upward(
            text,
            [24.0 + 17.0 * row as f32, middle],
            label,
            Anchor::Middle,
        );
    }
    if !place.x_labelled {
        return;
    }
    let room = plot.width() / place.x.ticks.len().max(1) as f32;
    for tick in place.x.ticks.iter().filter(|tick| !tick.label.is_empty()) {
        let x = plot.left + place.x.place(tick.value) as f32 * plot.width();
        let text = if panel.categories.is_empty() {
            tick.label.clone()
        } else {
            font::fit(&tick.label, quiet.weight, quiet.size, room - 6.0)
        };
        canvas.text(&text, [x, plot.bottom + 17.0], quiet, Anchor::Middle);
    }
    let text = font::fit(
        &panel.x_label,
        label.weight,
        label.size,
        canvas.width as f32 - 20.0,
    );
    canvas.text(
        &text,
        [0.5 * (plot.left + plot.right), plot.bottom + 36.0],
        label,
        Anchor::Middle,
    );
}

fn draw_series(canvas: &mut Canvas, panel: &Panel, place: &PanelLayout) {
    let of = panel.series.iter().filter(|s| s.kind == Kind::Bars).count();
    let mut before = 0;
    for index in panel.drawing_order() {
        let series = &panel.series[index];
        let rgb = panel.color_of(index).rgb();
        let view = View { place, series, rgb };
        match &series.kind {
            Kind::Band { lower, upper } => view.band(canvas, lower, upper),
            Kind::Bars => {
                view.bars(canvas, before, of);
                before += 1;
            }
            Kind::ErrorBars { plus_minus } => view.error_bars(canvas, plus_minus),
            Kind::HorizontalLine | Kind::VerticalLine => view.reference(canvas),
            _ => view.curve(canvas),
        }
    }
    if !panel.series.iter().any(Series::has_data) {
        let Rect {
            left,
            top,
            right,
            bottom,
        } = place.plot;
        let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
        let style = Type {
            size: LABEL_SIZE,
            weight: Weight::Regular,
            rgb: QUIET,
        };
        canvas.text("no data", middle, style, Anchor::Middle);
    }
}
