//! A figure as a canvas: grid, series, axes, words.

use crate::canvas::{Anchor, Canvas, Ink, Rect, Stroke, Type};
use crate::decimate::keep;
use crate::figure::{Figure, Kind, Panel, Series};
use crate::font::{self, Weight};
use crate::layout::{LABEL_SIZE, Layout, PANEL_TITLE_SIZE, PanelLayout, SWATCH, TICK_SIZE, TITLE_SIZE, layout, spacing};
use crate::raster;
use crate::svg::{self, About};
use crate::{Error, Result, files};
use std::path::{Path, PathBuf};

const INK: [u8; 3] = [0x1f, 0x23, 0x28];
const QUIET: [u8; 3] = [0x55, 0x5b, 0x63];
const GRID: [u8; 3] = [0xe4, 0xe6, 0xea];
const FRAME: [u8; 3] = [0x9a, 0xa1, 0xab];

/// Opacity of bands, so that curves and other bands show through.
pub(crate) const BAND_ALPHA: f32 = 0.22;

/// Share of the room between two bars' positions that bars fill.
pub(crate) const BAR_FILL: f64 = 0.8;

impl Figure {
    /// The picture as SVG text. Letters are outlines: it needs no font.
    ///
    /// # Errors
    /// When the figure does not make sense (see [`Error`]); data that are not finite are gaps, not errors.
    pub fn svg(&self) -> Result<String> {
        let canvas = self.canvas(true)?;
        Ok(svg::write(&canvas, &About { prefix: "", title: &self.title, description: &self.caption }))
    }

    /// The picture as PNG with `scale` pixels to the CSS pixel (0.1 to 8; 2 suits print and fine screens).
    ///
    /// # Errors
    /// As [`Figure::svg`]; also when `scale` is out of range or the picture cannot be encoded.
    pub fn png(&self, scale: f32) -> Result<Vec<u8>> {
        let canvas = self.canvas(true)?;
        if !(0.1..=8.0).contains(&scale) {
            return Err(self.setting("scale", "0.1 to 8", scale));
        }
        raster::png(&canvas, scale).map_err(|reason| Error::Png { figure: self.id.clone(), reason })
    }

    /// Writes `<id>.svg` and `<id>.png` (two pixels to the CSS pixel) into the directory, each whole or not at all,
    /// and returns their paths.
    ///
    /// # Errors
    /// As [`Figure::png`]; also when a file cannot be written.
    pub fn write(&self, directory: impl AsRef<Path>) -> Result<[PathBuf; 2]> {
        let (svg, png) = (self.svg()?, self.png(2.0)?);
        let paths = ["svg", "png"].map(|extension| directory.as_ref().join(format!("{}.{extension}", self.id)));
        files::write_atomic(&paths[0], svg.as_bytes())?;
        files::write_atomic(&paths[1], &png)?;
        Ok(paths)
    }

    /// The picture as SVG for a page that shows title and legends itself.
    pub(crate) fn inline_svg(&self, prefix: &str) -> Result<String> {
        Ok(svg::write(&self.canvas(false)?, &About { prefix, title: &self.title, description: "" }))
    }

    fn canvas(&self, headings: bool) -> Result<Canvas> {
        self.check()?;
        let layout = layout(self, headings);
        let mut canvas = Canvas { width: self.width_px, height: layout.height, items: Vec::new() };
        draw_title(&mut canvas, &layout);
        for (panel, place) in self.panels.iter().zip(&layout.panels) {
            draw_header(&mut canvas, panel, place);
            draw_grid(&mut canvas, place);
            draw_series(&mut canvas, panel, place);
            draw_axes(&mut canvas, panel, place);
        }
        Ok(canvas)
    }
}

fn line(rgb: [u8; 3], width: f32) -> Stroke {
    Stroke { ink: Ink::solid(rgb), width, dash: Vec::new() }
}

fn draw_title(canvas: &mut Canvas, layout: &Layout) {
    let style = Type { size: TITLE_SIZE, weight: Weight::SemiBold, rgb: INK };
    for (row, text) in layout.title.iter().enumerate() {
        canvas.text(text, [14.0, 14.0 + TITLE_SIZE * 0.75 + 22.0 * row as f32], style, Anchor::Start);
    }
}

fn draw_header(canvas: &mut Canvas, panel: &Panel, place: &PanelLayout) {
    let left = place.plot.left;
    let baseline = |row: usize| place.header_top + 14.0 + 19.0 * row as f32;
    if let Some(title) = panel.title.as_ref().filter(|_| place.header_top < place.plot.top - 12.0) {
        let style = Type { size: PANEL_TITLE_SIZE, weight: Weight::SemiBold, rgb: INK };
        let title = font::fit(title, style.weight, style.size, place.plot.width());
        canvas.text(&title, [left, baseline(0)], style, Anchor::Start);
    }
    let style = Type { size: TICK_SIZE, weight: Weight::Regular, rgb: INK };
    for entry in &place.legend {
        let (x, y) = (left + entry.x, baseline(entry.row));
        let rgb = panel.color_of(entry.series).rgb();
        swatch(canvas, &panel.series[entry.series], rgb, [x, y - 4.5]);
        canvas.text(&entry.name, [x + SWATCH + 6.0, y], style, Anchor::Start);
    }
}

/// A sample of the series, from `x` over the width of a swatch, centred on `y`.
fn swatch(canvas: &mut Canvas, series: &Series, rgb: [u8; 3], [x, y]: [f32; 2]) {
    let area = |half: f32| Rect { left: x, top: y - half, right: x + SWATCH, bottom: y + half };
    let everywhere = area(20.0);
    let width = series.width as f32;
    match series.kind {
        Kind::Bars => canvas.polygons(&[area(5.0).corners().to_vec()], Ink::solid(rgb), None),
        Kind::Band { .. } => {
            canvas.polygons(&[area(5.0).corners().to_vec()], Ink { rgb, alpha: BAND_ALPHA }, None);
        }
        _ => {
            if let Some(stroke) = stroke(series, rgb) {
                canvas.segment([x, y], [x + SWATCH, y], stroke);
            }
        }
    }
    if has_points(&series.kind) {
        canvas.dots(vec![[x + 0.5 * SWATCH, y]], 1.5 * width, Ink::solid(rgb), everywhere);
    }
}

fn has_points(kind: &Kind) -> bool {
    matches!(kind, Kind::Points | Kind::LinesPoints | Kind::ErrorBars { .. })
}

/// How the line of a series is drawn; `None` for a series without a line.
fn stroke(series: &Series, rgb: [u8; 3]) -> Option<Stroke> {
    let width = series.width as f32;
    let dash = match series.kind {
        Kind::Points | Kind::ErrorBars { .. } | Kind::Bars | Kind::Band { .. } => return None,
        Kind::Dashed => vec![4.0 * width, 2.5 * width],
        Kind::Dotted => vec![1.2 * width, 1.6 * width],
        Kind::HorizontalLine | Kind::VerticalLine => vec![6.0, 4.0],
        Kind::Line | Kind::LinesPoints | Kind::Steps => Vec::new(),
    };
    Some(Stroke { ink: Ink::solid(rgb), width, dash })
}

fn draw_grid(canvas: &mut Canvas, place: &PanelLayout) {
    let plot = &place.plot;
    let vertical = place.x.ticks.iter().map(|tick| {
        let x = plot.left + place.x.place(tick.value) as f32 * plot.width();
        vec![[crisp(x), plot.top], [crisp(x), plot.bottom]]
    });
    let horizontal = place.y.ticks.iter().map(|tick| {
        let y = plot.bottom - place.y.place(tick.value) as f32 * plot.height();
        vec![[plot.left, crisp(y)], [plot.right, crisp(y)]]
    });
    let lines: Vec<_> = vertical.chain(horizontal).collect();
    canvas.lines(&lines, line(GRID, 1.0), None);
}

/// The middle of a pixel: a line of one pixel there is sharp.
fn crisp(v: f32) -> f32 {
    v.floor() + 0.5
}

fn draw_axes(canvas: &mut Canvas, panel: &Panel, place: &PanelLayout) {
    let plot = &place.plot;
    let frame = vec![[plot.left, plot.top], [plot.left, plot.bottom], [plot.right, plot.bottom]];
    canvas.lines(&[frame], line(FRAME, 1.0), None);
    let quiet = Type { size: TICK_SIZE, weight: Weight::Regular, rgb: QUIET };
    for tick in place.y.ticks.iter().filter(|tick| !tick.label.is_empty()) {
        let y = plot.bottom - place.y.place(tick.value) as f32 * plot.height();
        canvas.text(&tick.label, [plot.left - 7.0, y + 0.36 * TICK_SIZE], quiet, Anchor::End);
    }
    let label = Type { size: LABEL_SIZE, weight: Weight::Regular, rgb: INK };
    for (row, text) in place.y_label.iter().enumerate() {
        let middle = 0.5 * (plot.top + plot.bottom);
        canvas.text_upward(text, [24.0 + 17.0 * row as f32, middle], label, Anchor::Middle);
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
    let text = font::fit(&panel.x_label, label.weight, label.size, canvas.width as f32 - 20.0);
    canvas.text(&text, [0.5 * (plot.left + plot.right), plot.bottom + 36.0], label, Anchor::Middle);
}

fn draw_series(canvas: &mut Canvas, panel: &Panel, place: &PanelLayout) {
    let is_band = |series: &Series| matches!(series.kind, Kind::Band { .. });
    let bars = panel.series.iter().filter(|s| s.kind == Kind::Bars).count();
    let mut bars_before = 0;
    for bands in [true, false] {
        for (index, series) in panel.series.iter().enumerate().filter(|(_, s)| is_band(s) == bands) {
            let view = View { place, series, rgb: panel.color_of(index).rgb() };
            match &series.kind {
                Kind::Band { lower, upper } => view.band(canvas, lower, upper),
                Kind::Bars => {
                    view.bars(canvas, bars_before, bars);
                    bars_before += 1;
                }
                Kind::ErrorBars { plus_minus } => view.error_bars(canvas, plus_minus),
                Kind::HorizontalLine | Kind::VerticalLine => view.reference(canvas),
                _ => view.curve(canvas),
            }
        }
    }
    if panel.series.iter().all(|s| s.x.is_empty() && s.y.is_empty()) {
        let plot = &place.plot;
        let middle = [0.5 * (plot.left + plot.right), 0.5 * (plot.top + plot.bottom)];
        canvas.text("no data", middle, Type { size: LABEL_SIZE, weight: Weight::Regular, rgb: QUIET }, Anchor::Middle);
    }
}

/// One series in its panel.
struct View<'a> {
    place: &'a PanelLayout,
    series: &'a Series,
    rgb: [u8; 3],
}

impl View<'_> {
    /// Where a sample stands, in pixels; `None` for a gap.
    fn at(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let plot = &self.place.plot;
        let [u, v] = [self.place.x.place(x), self.place.y.place(y)];
        let point = [
            f64::from(plot.left) + u * f64::from(plot.width()),
            f64::from(plot.bottom) - v * f64::from(plot.height()),
        ];
        (u.is_finite() && v.is_finite()).then_some(point)
    }

    /// Lines keep to the plot, with room for half their width.
    fn clip(&self) -> Rect {
        self.place.plot.grown(self.series.width as f32)
    }

    fn curve(&self, canvas: &mut Canvas) {
        let Series { x, y, kind, width, .. } = self.series;
        let samples = keep(&[x, y]).into_iter().map(|i| self.at(x[i], y[i]));
        let points: Vec<Option<[f64; 2]>> = if *kind == Kind::Steps { steps(samples) } else { samples.collect() };
        if let Some(stroke) = stroke(self.series, self.rgb) {
            canvas.lines(&visible_runs(&points, &self.place.plot.grown(30.0)), stroke, Some(self.clip()));
            // A sample between two gaps has no line: a dot of the line's width shows it.
            let lone = |i: usize| points[i].filter(|_| neighbours(&points, i).iter().all(Option::is_none));
            let lone: Vec<_> = (0..points.len()).filter_map(lone).collect();
            self.dots(canvas, &lone, 0.75 * *width as f32 + 0.5);
        }
        if has_points(kind) {
            self.dots(canvas, &points.iter().flatten().copied().collect::<Vec<_>>(), 1.5 * *width as f32);
        }
    }

    fn dots(&self, canvas: &mut Canvas, points: &[[f64; 2]], radius: f32) {
        let clip = self.place.plot.grown(radius + 1.0);
        let inside = |[x, y]: &[f64; 2]| {
            let (left, right) = (f64::from(clip.left), f64::from(clip.right));
            let (top, bottom) = (f64::from(clip.top), f64::from(clip.bottom));
            (left..=right).contains(x) && (top..=bottom).contains(y)
        };
        let centers = points.iter().filter(|p| inside(p)).map(|[x, y]| [*x as f32, *y as f32]).collect();
        canvas.dots(centers, radius, Ink::solid(self.rgb), clip);
    }

    fn band(&self, canvas: &mut Canvas, lower: &[f64], upper: &[f64]) {
        let x = &self.series.x;
        let edges = keep(&[x, lower, upper]).into_iter().map(|i| self.at(x[i], lower[i]).zip(self.at(x[i], upper[i])));
        let edges: Vec<_> = edges.collect();
        let polygon = |run: &[Option<([f64; 2], [f64; 2])>]| -> Vec<[f32; 2]> {
            let lower = run.iter().flatten().map(|(low, _)| self.near(*low));
            let upper = run.iter().flatten().map(|(_, high)| self.near(*high)).rev();
            lower.chain(upper).collect()
        };
        let polygons: Vec<_> = edges.split(Option::is_none).filter(|run| run.len() > 1).map(polygon).collect();
        canvas.polygons(&polygons, Ink { rgb: self.rgb, alpha: BAND_ALPHA }, Some(self.place.plot));
    }

    /// The point, or the nearest one that is not far out of the picture: areas need no exact slopes out there.
    fn near(&self, [x, y]: [f64; 2]) -> [f32; 2] {
        let far = self.place.plot.grown(10_000.0);
        [
            x.clamp(f64::from(far.left), f64::from(far.right)) as f32,
            y.clamp(f64::from(far.top), f64::from(far.bottom)) as f32,
        ]
    }

    fn bars(&self, canvas: &mut Canvas, before: usize, of: usize) {
        let Series { x, y, .. } = self.series;
        let slot = BAR_FILL * spacing(x) / of as f64;
        let offset = (before as f64 - 0.5 * of as f64) * slot;
        let base = if self.place.y.log { self.place.y.low } else { 0.0 };
        let corner = |i: usize| {
            let (a, b) = (self.at(x[i] + offset, base)?, self.at(x[i] + offset + slot, y[i])?);
            let ([left, top], [right, bottom]) = (self.near(a), self.near(b));
            // A hair of white between neighbours.
            let hair = if right - left > 6.0 { 0.5 } else { 0.0 };
            Some(Rect { left: left + hair, top, right: right - hair, bottom }.corners().to_vec())
        };
        let polygons: Vec<_> = keep(&[x, y]).into_iter().filter_map(corner).collect();
        canvas.polygons(&polygons, Ink::solid(self.rgb), Some(self.place.plot));
    }

    fn error_bars(&self, canvas: &mut Canvas, plus_minus: &[f64]) {
        let Series { x, y, width, .. } = self.series;
        let low: Vec<f64> = y.iter().zip(plus_minus).map(|(y, e)| y - e.abs()).collect();
        let high: Vec<f64> = y.iter().zip(plus_minus).map(|(y, e)| y + e.abs()).collect();
        let mut whiskers = Vec::new();
        let mut centers = Vec::new();
        let kept = keep(&[x, y, &low, &high]);
        for i in kept {
            centers.extend(self.at(x[i], y[i]));
            let below = if self.place.y.log { low[i].max(self.place.y.low) } else { low[i] };
            let Some((a, b)) = self.at(x[i], below).zip(self.at(x[i], high[i])) else { continue };
            let ([ax, ay], [bx, by]) = (self.near(a), self.near(b));
            let cap = |x: f32, y: f32| vec![[x - 4.0, y], [x + 4.0, y]];
            whiskers.extend([vec![[ax, ay], [bx, by]], cap(ax, ay), cap(bx, by)]);
        }
        canvas.lines(&whiskers, line(self.rgb, 0.75 * *width as f32), Some(self.place.plot.grown(5.0)));
        self.dots(canvas, &centers, 1.5 * *width as f32);
    }

    fn reference(&self, canvas: &mut Canvas) {
        let Some(stroke) = stroke(self.series, self.rgb) else { return };
        let (plot, x, y) = (&self.place.plot, &self.place.x, &self.place.y);
        let inside = |place: &f64| (0.0..=1.0).contains(place);
        let lines: Vec<_> = if self.series.kind == Kind::HorizontalLine {
            let heights = self.series.y.iter().map(|v| y.place(*v)).filter(inside);
            let heights = heights.map(|v| plot.bottom - v as f32 * plot.height());
            heights.map(|y| vec![[plot.left, y], [plot.right, y]]).collect()
        } else {
            let places = self.series.x.iter().map(|v| x.place(*v)).filter(inside);
            let places = places.map(|u| plot.left + u as f32 * plot.width());
            places.map(|x| vec![[x, plot.bottom], [x, plot.top]]).collect()
        };
        canvas.lines(&lines, stroke, None);
    }
}

/// Adds the corner of each step: a value holds until the next sample.
fn steps(samples: impl Iterator<Item = Option<[f64; 2]>>) -> Vec<Option<[f64; 2]>> {
    let mut out: Vec<Option<[f64; 2]>> = Vec::new();
    for sample in samples {
        if let (Some(Some([_, before])), Some([x, _])) = (out.last(), sample) {
            out.push(Some([x, *before]));
        }
        out.push(sample);
    }
    out
}

fn neighbours(points: &[Option<[f64; 2]>], i: usize) -> [Option<[f64; 2]>; 2] {
    let before = i.checked_sub(1).and_then(|i| points[i]);
    [before, points.get(i + 1).copied().flatten()]
}

/// Polylines of what is visible: broken at gaps, cut at the rectangle.
fn visible_runs(points: &[Option<[f64; 2]>], room: &Rect) -> Vec<Vec<[f32; 2]>> {
    let mut runs: Vec<Vec<[f32; 2]>> = Vec::new();
    let mut end: Option<[f64; 2]> = None;
    for pair in points.windows(2) {
        let [Some(a), Some(b)] = [pair[0], pair[1]] else { continue };
        let Some((from, to)) = cut(a, b, room) else { continue };
        let narrow = |[x, y]: [f64; 2]| [x as f32, y as f32];
        // Continue the last run only where this piece begins at the very sample where that one ended.
        match runs.last_mut() {
            Some(run) if end == Some(from) && from == a => run.push(narrow(to)),
            _ => runs.push(vec![narrow(from), narrow(to)]),
        }
        end = (to == b).then_some(to);
    }
    runs
}

/// The part of a straight line within a rectangle (Liang & Barsky 1984).
fn cut(a: [f64; 2], b: [f64; 2], room: &Rect) -> Option<([f64; 2], [f64; 2])> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let step = [b[0] - a[0], b[1] - a[1]];
    let sides = [
        (-step[0], a[0] - f64::from(room.left)),
        (step[0], f64::from(room.right) - a[0]),
        (-step[1], a[1] - f64::from(room.top)),
        (step[1], f64::from(room.bottom) - a[1]),
    ];
    for (toward, distance) in sides {
        if toward == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if toward < 0.0 {
            enter = enter.max(distance / toward);
        } else {
            leave = leave.min(distance / toward);
        }
    }
    let along = |t: f64| [a[0] + t * step[0], a[1] + t * step[1]];
    let from = if enter > 0.0 { along(enter) } else { a };
    let to = if leave < 1.0 { along(leave) } else { b };
    (enter <= leave && from.iter().chain(&to).all(|v| v.is_finite())).then_some((from, to))
}
