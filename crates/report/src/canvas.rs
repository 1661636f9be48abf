//! What both picture formats draw: shapes, dots and set text, in pixels from the top left corner.

use crate::font::{self, Line, Weight};
use crate::shape::{Rect, Segment};

/// Colour and opacity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ink {
    pub(crate) rgb: [u8; 3],
    pub(crate) alpha: f32,
}

impl Ink {
    pub(crate) fn solid(rgb: [u8; 3]) -> Self {
        Self { rgb, alpha: 1.0 }
    }
}

/// How an outline is drawn.
#[derive(Debug, Clone)]
pub(crate) struct Stroke {
    pub(crate) ink: Ink,
    pub(crate) width: f32,
    /// Lengths of dashes and spaces, in turn; empty for a solid line.
    pub(crate) dash: Vec<f32>,
}

/// One thing to draw.
#[derive(Debug, Clone)]
pub(crate) enum Item {
    Shape {
        segments: Vec<Segment>,
        fill: Option<Ink>,
        stroke: Option<Stroke>,
        clip: Option<Rect>,
    },
    Dots {
        centers: Vec<[f32; 2]>,
        radius: f32,
        ink: Ink,
        clip: Rect,
    },
    Text {
        line: Line,
        at: [f32; 2],
        size: f32,
        upward: bool,
        ink: Ink,
    },
}

/// Which part of a text stands at the given point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// Style of a text.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Type {
    pub(crate) size: f32,
    pub(crate) weight: Weight,
    pub(crate) rgb: [u8; 3],
}

/// A picture as a list of items, later ones on top.
#[derive(Debug, Clone)]
pub(crate) struct Canvas {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) items: Vec<Item>,
}

impl Canvas {
    /// Text with its baseline at `at`.
    pub(crate) fn text(&mut self, text: &str, at: [f32; 2], style: Type, anchor: Anchor) {
        self.set_text(text, at, style, anchor, false);
    }

    /// Text that reads from bottom to top.
    pub(crate) fn text_upward(&mut self, text: &str, at: [f32; 2], style: Type, anchor: Anchor) {
        self.set_text(text, at, style, anchor, true);
    }

    fn set_text(
        &mut self,
        text: &str,
        [x, y]: [f32; 2],
        style: Type,
        anchor: Anchor,
        upward: bool,
    ) {
        let line = font::set(text, style.weight);
        let share = match anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5,
            Anchor::End => 1.0,
        };
        let back = share * line.width * style.size;
        let at = if upward { [x, y + back] } else { [x - back, y] };
        self.items.push(Item::Text {
            line,
            at,
            size: style.size,
            upward,
            ink: Ink::solid(style.rgb),
        });
    }

    /// A straight line.
    pub(crate) fn segment(&mut self, from: [f32; 2], to: [f32; 2], stroke: Stroke) {
        self.lines(&[vec![from, to]], stroke, None);
    }

    /// Several open lines in one style.
    pub(crate) fn lines(&mut self, lines: &[Vec<[f32; 2]>], stroke: Stroke, clip: Option<Rect>) {
        let segments = outline_of(lines, false);
        if !segments.is_empty() {
            self.items.push(Item::Shape {
                segments,
                fill: None,
                stroke: Some(stroke),
                clip,
            });
        }
    }

    /// Several filled polygons in one colour.
    pub(crate) fn polygons(&mut self, polygons: &[Vec<[f32; 2]>], ink: Ink, clip: Option<Rect>) {
        let segments = outline_of(polygons, true);
        if !segments.is_empty() {
            self.items.push(Item::Shape {
                segments,
                fill: Some(ink),
                stroke: None,
                clip,
            });
        }
    }

    /// Filled circles.
    pub(crate) fn dots(&mut self, centers: Vec<[f32; 2]>, radius: f32, ink: Ink, clip: Rect) {
        if !centers.is_empty() {
            self.items.push(Item::Dots {
                centers,
                radius,
                ink,
                clip,
            });
        }
    }
}

fn outline_of(lines: &[Vec<[f32; 2]>], close: bool) -> Vec<Segment> {
    let mut segments = Vec::with_capacity(lines.iter().map(|l| l.len() + 1).sum());
    for line in lines.iter().filter(|line| line.len() > 1) {
        segments.push(Segment::Move(line[0]));
        segments.extend(line[1..].iter().map(|p| Segment::Line(*p)));
        if close {
            segments.push(Segment::Close);
        }
    }
    segments
}
