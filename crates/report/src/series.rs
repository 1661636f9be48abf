//! The data of one series as shapes on the canvas.

use crate::canvas::{Canvas, Ink, Stroke};
use crate::curve::{neighbours, steps, visible_runs};
use crate::decimate::keep;
use crate::figure::{Kind, Series};
use crate::layout::PanelLayout;
use crate::ranges::spacing;
use crate::shape::Rect;

/// Radius of a dot in a legend at least (px): one of a pixel shows no colour.
pub(crate) const LEAST_DOT: f64 = 3.0;
/// Opacity of bands, so that curves and other bands show through.
pub(crate) const BAND_ALPHA: f32 = 0.22;

/// Share of the room between two bars' positions that bars fill.
pub(crate) const BAR_FILL: f64 = 0.8;

/// A solid line.
pub(crate) fn line(rgb: [u8; 3], width: f32) -> Stroke {
    Stroke {
        ink: Ink::solid(rgb),
        width,
        dash: Vec::new(),
    }
}

/// Whether samples are marked one by one.
pub(crate) fn has_points(kind: &Kind) -> bool {
    matches!(
        kind,
        Kind::Points | Kind::LinesPoints | Kind::ErrorBars { .. }
    )
}

/// How the line of a series is drawn; `None` for a series without a line.
pub(crate) fn stroke(series: &Series, rgb: [u8; 3]) -> Option<Stroke> {
    let width = series.width as f32;
    let dash = match series.kind {
        Kind::Points | Kind::ErrorBars { .. } | Kind::Bars | Kind::Band { .. } => return None,
        Kind::Dashed => vec![4.0 * width, 2.5 * width],
        Kind::Dotted => vec![1.2 * width, 1.6 * width],
        Kind::HorizontalLine | Kind::VerticalLine => vec![6.0, 4.0],
        Kind::Line | Kind::LinesPoints | Kind::Steps => Vec::new(),
    };
    Some(Stroke {
        ink: Ink::solid(rgb),
        width,
        dash,
    })
}

/// One series in its panel.
pub(crate) struct View<'a> {
    pub(crate) place: &'a PanelLayout,
    pub(crate) series: &'a Series,
    pub(crate) rgb: [u8; 3],
}

impl View<'_> {
    /// Where a sample stands, in pixels; `None` for a gap.
    fn at(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let plot = &self.place.plot;
        // A million widths away is as good as anywhere farther, and keeps the geometry exact.
        let [u, v] = [self.place.x.place(x), self.place.y.place(y)].map(|p| p.clamp(-1e6, 1e6));
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

    pub(crate) fn curve(&self, canvas: &mut Canvas) {
        let Series {
            x, y, kind, width, ..
        } = self.series;
        let samples = keep(&[x, y]).into_iter().map(|i| self.at(x[i], y[i]));
        let points: Vec<Option<[f64; 2]>> = if *kind == Kind::Steps {
            steps(samples)
        } else {
            samples.collect()
        };
        if let Some(stroke) = stroke(self.series, self.rgb) {
            canvas.lines(
                &visible_runs(&points, &self.place.plot.grown(30.0)),
                stroke,
                Some(self.clip()),
            );
            // A sample between two gaps has no line: a dot of the line's width shows it.
            let lone =
                |i: usize| points[i].filter(|_| neighbours(&points, i).iter().all(Option::is_none));
            let lone: Vec<_> = (0..points.len()).filter_map(lone).collect();
            self.dots(canvas, &lone, 0.75 * *width as f32 + 0.5);
        }
        if has_points(kind) {
            self.dots(
                canvas,
                &points.iter().flatten().copied().collect::<Vec<_>>(),
                1.5 * *width as f32,
            );
        }
    }

    fn dots(&self, canvas: &mut Canvas, points: &[[f64; 2]], radius: f32) {
        let clip = self.place.plot.grown(radius + 1.0);
        let inside = |[x, y]: &[f64; 2]| {
            let (left, right) = (f64::from(clip.left), f64::from(clip.right));
            let (top, bottom) = (f64::from(clip.top), f64::from(clip.bottom));
            (left..=right).contains(x) && (top..=bottom).contains(y)
        };
        let centers = points
            .iter()
            .filter(|p| inside(p))
            .map(|[x, y]| [*x as f32, *y as f32])
            .collect();
        canvas.dots(centers, radius, Ink::solid(self.rgb), clip);
    }

    pub(crate) fn band(&self, canvas: &mut Canvas, lower: &[f64], upper: &[f64]) {
        let x = &self.series.x;
        let edges = keep(&[x, lower, upper])
            .into_iter()
            .map(|i| self.at(x[i], lower[i]).zip(self.at(x[i], upper[i])));
        let edges: Vec<_> = edges.collect();
        let polygon = |run: &[Option<([f64; 2], [f64; 2])>]| -> Vec<[f32; 2]> {
            let lower = run.iter().flatten().map(|(low, _)| self.near(*low));
            let upper = run.iter().flatten().map(|(_, high)| self.near(*high)).rev();
            lower.chain(upper).collect()
        };
        let polygons: Vec<_> = edges
            .split(Option::is_none)
            .filter(|run| run.len() > 1)
            .map(polygon)
            .collect();
        canvas.polygons(
            &polygons,
            Ink {
                rgb: self.rgb,
                alpha: BAND_ALPHA,
            },
            Some(self.place.plot),
        );
    }

    /// The point, or the nearest one that is not far out of the picture: areas need no exact slopes out there.
    fn near(&self, [x, y]: [f64; 2]) -> [f32; 2] {
        let far = self.place.plot.grown(10_000.0);
        [
            x.clamp(f64::from(far.left), f64::from(far.right)) as f32,
            y.clamp(f64::from(far.top), f64::from(far.bottom)) as f32,
        ]
    }

    pub(crate) fn bars(&self, canvas: &mut Canvas, before: usize, of: usize) {
        let Series { x, y, .. } = self.series;
        let slot = BAR_FILL * spacing(x) / of as f64;
        let offset = (before as f64 - 0.5 * of as f64) * slot;
        let base = if self.place.y.log {
            self.place.y.low
        } else {
            0.0
        };
        let corner = |i: usize| {
            let (a, b) = (
                self.at(x[i] + offset, base)?,
                self.at(x[i] + offset + slot, y[i])?,
            );
            let ([left, top], [right, bottom]) = (self.near(a), self.near(b));
            // A hair of white between neighbours.
            let hair = if right - left > 6.0 { 0.5 } else { 0.0 };
            Some(
                Rect {
                    left: left + hair,
                    top,
                    right: right - hair,
                    bottom,
                }
                .corners()
                .to_vec(),
            )
        };
        let polygons: Vec<_> = keep(&[x, y]).into_iter().filter_map(corner).collect();
        canvas.polygons(&polygons, Ink::solid(self.rgb), Some(self.place.plot));
    }

    pub(crate) fn error_bars(&self, canvas: &mut Canvas, plus_minus: &[f64]) {
        let Series { x, y, width, .. } = self.series;
        let low: Vec<f64> = y.iter().zip(plus_minus).map(|(y, e)| y - e.abs()).collect();
        let high: Vec<f64> = y.iter().zip(plus_minus).map(|(y, e)| y + e.abs()).collect();
        let mut whiskers = Vec::new();
        let mut centers = Vec::new();
        let kept = keep(&[x, y, &low, &high]);
        for i in kept {
            centers.extend(self.at(x[i], y[i]));
            let below = if self.place.y.log {
                low[i].max(self.place.y.low)
            } else {
                low[i]
            };
            let Some((a, b)) = self.at(x[i], below).zip(self.at(x[i], high[i])) else {
                continue;
            };
            let ([ax, ay], [bx, by]) = (self.near(a), self.near(b));
            let cap = |x: f32, y: f32| vec![[x - 4.0, y], [x + 4.0, y]];
            whiskers.extend([vec![[ax, ay], [bx, by]], cap(ax, ay), cap(bx, by)]);
        }
        canvas.lines(
            &whiskers,
            line(self.rgb, 0.75 * *width as f32),
            Some(self.place.plot.grown(5.0)),
        );
        self.dots(canvas, &centers, 1.5 * *width as f32);
    }

    pub(crate) fn reference(&self, canvas: &mut Canvas) {
        let Some(stroke) = stroke(self.series, self.rgb) else {
            return;
        };
        let (plot, x, y) = (&self.place.plot, &self.place.x, &self.place.y);
        let inside = |place: &f64| (0.0..=1.0).contains(place);
        let lines: Vec<_> = if self.series.kind == Kind::HorizontalLine {
            let heights = self.series.y.iter().map(|v| y.place(*v)).filter(inside);
            let heights = heights.map(|v| plot.bottom - v as f32 * plot.height());
            heights
                .map(|y| vec![[plot.left, y], [plot.right, y]])
                .collect()
        } else {
            let places = self.series.x.iter().map(|v| x.place(*v)).filter(inside);
            let places = places.map(|u| plot.left + u as f32 * plot.width());
            places
                .map(|x| vec![[x, plot.bottom], [x, plot.top]])
                .collect()
        };
        canvas.lines(&lines, stroke, None);
    }
}
