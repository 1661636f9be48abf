//! A canvas as SVG text. Letters are outlines, so the file looks the same with and without fonts.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::canvas::{Canvas, Ink, Item, Stroke};
use crate::color::hex;
use crate::font::{self, Glyph};
use crate::shape::{Rect, Segment};

/// Glyph outlines are stored once, at this many units to the em, and scaled where they are used.
const GLYPH_EM: f32 = 1000.0;

/// What an SVG says about itself.
pub(crate) struct About<'a> {
    pub(crate) title: &'a str,
    pub(crate) description: &'a str,
}

/// The whole `<svg>` element.
pub(crate) fn write(canvas: &Canvas, about: &About<'_>) -> String {
    let mut svg = Svg {
        text: String::new(),
        clips: Vec::new(),
    };
    let (w, h) = (canvas.width, canvas.height);
    svg.push(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{}\">",
        escape(about.title)
    ));
    if !about.description.is_empty() {
        svg.push(format_args!("<desc>{}</desc>", escape(about.description)));
    }
    svg.definitions(canvas);
    svg.push(format_args!(
        "<rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>"
    ));
    for item in &canvas.items {
        svg.item(item);
    }
    svg.text.push_str("</svg>\n");
    svg.text
}

struct Svg {
    text: String,
    clips: Vec<Rect>,
}

impl Svg {
    fn push(&mut self, arguments: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = self.text.write_fmt(arguments);
    }

    /// Outlines of all glyphs and all clip rectangles, each once.
    fn definitions(&mut self, canvas: &Canvas) {
        let mut glyphs: BTreeSet<Glyph> = BTreeSet::new();
        for item in &canvas.items {
            match item {
                Item::Text { line, .. } => {
                    glyphs.extend(line.glyphs.iter().map(|(glyph, _)| *glyph));
                }
                Item::Shape {
                    clip: Some(clip), ..
                }
                | Item::Dots { clip, .. }
                    if !self.clips.contains(clip) =>
                {
                    self.clips.push(*clip);
                }
                Item::Shape { .. } | Item::Dots { .. } => {}
            }
        }
        self.text.push_str("<defs>");
        for glyph in glyphs {
            let outline = font::outline(glyph);
            if outline.is_empty() {
                continue;
            }
            self.push(format_args!("<path id=\"{}\" d=\"", glyph.name()));
            self.outline(&outline, GLYPH_EM, 0);
            self.text.push_str("\"/>");
        }
        for (index, clip) in self.clips.clone().into_iter().enumerate() {
            let [x, y, w, h] =
                [clip.left, clip.top, clip.width(), clip.height()].map(|v| Number(v, 2));
            self.push(format_args!(
                "<clipPath id=\"c{index}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>"
            ));
        }
        self.text.push_str("</defs>\n");
    }

    fn item(&mut self, item: &Item) {
        match item {
            Item::Shape {
                segments,
                fill,
                stroke,
                clip,
            } => {
                self.text.push_str("<path d=\"");
                self.outline(segments, 1.0, 2);
                self.text.push('"');
                self.fill(*fill);
                if let Some(stroke) = stroke {
                    self.stroke(stroke);
                }
                self.clip(*clip);
                self.text.push_str("/>\n");
            }
            Item::Dots {
                centers,
                radius,
                ink,
                clip,
            } => {
                // A stroke of no length with round ends is a circle, in a tenth of the bytes.
                self.text.push_str("<path d=\"");
                for [x, y] in centers {
                    self.push(format_args!("M{} {}h0", Number(*x, 2), Number(*y, 2)));
                }
                self.text
                    .push_str("\" fill=\"none\" stroke-linecap=\"round\"");
                self.stroke(&Stroke {
                    ink: *ink,
                    width: 2.0 * radius,
                    dash: Vec::new(),
                });
                self.clip(Some(*clip));
                self.text.push_str("/>\n");
            }
            Item::Text {
                line,
                at: [x, y],
                size,
                upward,
                ink,
            } => {
                let scale = Number(size / GLYPH_EM, 5);
                let turn = if *upward { " rotate(-90)" } else { "" };
                self.push(format_args!(
                    "<g transform=\"translate({} {}){turn} scale({scale})\"",
                    Number(*x, 2),
                    Number(*y, 2)
                ));
                self.fill(Some(*ink));
                self.text.push('>');
                for (glyph, x) in line
                    .glyphs
                    .iter()
                    .filter(|(glyph, _)| !font::outline(*glyph).is_empty())
                {
                    let x = Number(x * GLYPH_EM, 0);
                    self.push(format_args!("<use href=\"#{}\" x=\"{x}\"/>", glyph.name()));
                }
                self.text.push_str("</g>\n");
            }
        }
    }

    fn outline(&mut self, segments: &[Segment], scale: f32, decimals: usize) {
        for segment in segments {
            let (letter, points): (char, &[[f32; 2]]) = match segment {
                Segment::Move(p) => ('M', &[*p]),
                Segment::Line(p) => ('L', &[*p]),
                Segment::Quad(c, p) => ('Q', &[*c, *p]),
                Segment::Cubic(a, b, p) => ('C', &[*a, *b, *p]),
                Segment::Close => ('Z', &[]),
            };
            self.text.push(letter);
            for (index, [x, y]) in points.iter().enumerate() {
                let space = if index == 0 { "" } else { " " };
                self.push(format_args!(
                    "{space}{} {}",
                    Number(x * scale, decimals),
                    Number(y * scale, decimals)
                ));
            }
        }
    }

    fn fill(&mut self, ink: Option<Ink>) {
        let Some(ink) = ink else {
            return self.text.push_str(" fill=\"none\"");
        };
        self.push(format_args!(" fill=\"{}\"", hex(ink.rgb)));
        if ink.alpha < 1.0 {
            self.push(format_args!(" fill-opacity=\"{}\"", ink.alpha));
        }
    }

    fn stroke(&mut self, stroke: &Stroke) {
        self.push(format_args!(
            " stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
            hex(stroke.ink.rgb),
            Number(stroke.width, 2)
        ));
        if stroke.ink.alpha < 1.0 {
            self.push(format_args!(" stroke-opacity=\"{}\"", stroke.ink.alpha));
        }
        if !stroke.dash.is_empty() {
            let dash: Vec<String> = stroke
                .dash
                .iter()
                .map(|d| Number(*d, 2).to_string())
                .collect();
            self.push(format_args!(" stroke-dasharray=\"{}\"", dash.join(" ")));
        }
    }

    fn clip(&mut self, clip: Option<Rect>) {
        if let Some(index) = clip.and_then(|clip| self.clips.iter().position(|c| *c == clip)) {
            self.push(format_args!(" clip-path=\"url(#c{index})\""));
        }
    }
}

/// A number with at most so many decimals and no trailing zeros.
struct Number(f32, usize);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.*}", self.1, self.0);
        let text = if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            &text
        };
        f.write_str(if text == "-0" { "0" } else { text })
    }
}

/// Text as it may stand in XML, in elements and in quoted attributes. Characters that XML forbids are left out.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\t' => escaped.push(' '),
            c if c.is_control() || c == '\u{FFFE}' || c == '\u{FFFF}' => {}
            c => escaped.push(c),
        }
    }
    escaped
}
