//! Embedded typefaces: glyphs, widths and outlines, so that no font is needed on any machine.
//!
//! Inter for text, with a subset of DejaVu Sans for symbols that Inter lacks. Licences stand beside the files in
//! `fonts/`. Lines of text are set from left to right without kerning.

use std::sync::OnceLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::shape::Segment;

/// Inter Regular, for the report's own text too.
pub(crate) const REGULAR: &[u8] = include_bytes!("../fonts/Inter-Regular.otf");
/// Inter SemiBold.
pub(crate) const SEMIBOLD: &[u8] = include_bytes!("../fonts/Inter-SemiBold.otf");
const SYMBOLS: &[u8] = include_bytes!("../fonts/DejaVuSans-Symbols.ttf");

/// How strong letters are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Weight {
    Regular,
    SemiBold,
}

/// One glyph of one typeface; the key of its outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Glyph {
    face: usize,
    id: u16,
}

impl Glyph {
    /// A short name that is unique among all glyphs.
    pub(crate) fn name(self) -> String {
        format!("{}{}", ["r", "b", "s"][self.face], self.id)
    }
}

/// A line of text, set: every glyph with its distance from the start, in ems.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(crate) glyphs: Vec<(Glyph, f32)>,
    pub(crate) width: f32,
}

fn faces() -> &'static [Face<'static>; 3] {
    static FACES: OnceLock<[Face<'static>; 3]> = OnceLock::new();
    // The bytes are part of the program, and a test parses them.
    FACES.get_or_init(|| {
        [REGULAR, SEMIBOLD, SYMBOLS].map(|bytes| Face::parse(bytes, 0).expect("embedded typeface"))
    })
}

fn glyph(character: char, weight: Weight) -> Option<Glyph> {
    let first = if weight == Weight::SemiBold { 1 } else { 0 };
    let in_face = |face: usize| {
        let id = faces()[face].glyph_index(character)?;
        Some(Glyph { face, id: id.0 })
    };
    in_face(first).or_else(|| in_face(2))
}

/// Sets `text` on one line. Line ends and other control characters become spaces.
pub(crate) fn set(text: &str, weight: Weight) -> Line {
    let mut glyphs = Vec::with_capacity(text.len());
    let mut width = 0.0;
    for character in text.chars() {
        let character = if character.is_control() {
            ' '
        } else {
            character
        };
        let Some(glyph) = glyph(character, weight).or_else(|| glyph('\u{FFFD}', weight)) else {
            continue;
        };
        let face = &faces()[glyph.face];
        let advance = face.glyph_hor_advance(GlyphId(glyph.id)).unwrap_or(0);
        glyphs.push((glyph, width));
        width += f32::from(advance) / f32::from(face.units_per_em());
    }
    Line { glyphs, width }
}

/// Width of `text` at `size` pixels.
pub(crate) fn width(text: &str, weight: Weight, size: f32) -> f32 {
    set(text, weight).width * size
}

/// `text`, or its beginning with an ellipsis, so that it is at most `room` pixels wide.
pub(crate) fn fit(text: &str, weight: Weight, size: f32, room: f32) -> String {
    if width(text, weight, size) <= room {
        return text.to_owned();
    }
    let mut short: Vec<char> = text.chars().collect();
    while short.pop().is_some() {
        let candidate: String = short.iter().chain(['…'].iter()).collect();
        if width(&candidate, weight, size) <= room {
            return candidate;
        }
    }
    String::new()
}

/// Words of `text` on as many lines as it takes to stay within `room` pixels.
pub(crate) fn wrap(text: &str, weight: Weight, size: f32, room: f32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (longer, lines.last_mut()) {
            (Some(longer), Some(last)) if width(&longer, weight, size) <= room => *last = longer,
            _ => lines.push(fit(word, weight, size, room)),
        }
    }
    lines
}

/// Outline of a glyph in ems, y down, origin on the baseline.
pub(crate) fn outline(glyph: Glyph) -> Vec<Segment> {
    let face = &faces()[glyph.face];
    let mut pen = Pen {
        em: f32::from(face.units_per_em()),
        segments: Vec::new(),
    };
    face.outline_glyph(GlyphId(glyph.id), &mut pen);
    pen.segments
}

struct Pen {
    em: f32,
    segments: Vec<Segment>,
}

impl Pen {
    fn point(&self, x: f32, y: f32) -> [f32; 2] {
        [x / self.em, -y / self.em]
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let p = self.point(x, y);
        self.segments.push(Segment::Move(p));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let p = self.point(x, y);
        self.segments.push(Segment::Line(p));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (c, p) = (self.point(x1, y1), self.point(x, y));
        self.segments.push(Segment::Quad(c, p));
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (a, b, p) = (self.point(x1, y1), self.point(x2, y2), self.point(x, y));
        self.segments.push(Segment::Cubic(a, b, p));
    }

    fn close(&mut self) {
        self.segments.push(Segment::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_every_symbol_that_labels_use_has_an_outline() {
        let symbols = "AZaz09αβγδεζηθκλμνξπρστφχψωΔΘΣΩẋż₀₁₂ₚᵥ⁰¹²³⁴⁵⁶⁷⁸⁹⁻−·×±≈≤≥∞∂∇√∫→←°µ‰–—…′″éüßñ";
        for weight in [Weight::Regular, Weight::SemiBold] {
            for character in symbols.chars() {
                let glyph = glyph(character, weight);
                assert!(
                    glyph.is_some_and(|g| !outline(g).is_empty()),
                    "{character} in {weight:?}"
                );
            }
        }
    }

    #[test]
    fn analytic_text_is_cut_and_wrapped_to_its_room() {
        assert_eq!(fit("short", Weight::Regular, 12.0, 100.0), "short");
        let cut = fit("a label that is much too long", Weight::Regular, 12.0, 80.0);
        assert!(
            cut.ends_with('…') && width(&cut, Weight::Regular, 12.0) <= 80.0,
            "{cut}"
        );
        let lines = wrap("one two three four five six", Weight::Regular, 12.0, 60.0);
        assert!(lines.len() > 1 && lines.join(" ") == "one two three four five six");
    }
}
