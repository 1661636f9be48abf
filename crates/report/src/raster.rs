//! A canvas as pixels.

use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap,
    Stroke as SkiaStroke, StrokeDash, Transform,
};

use crate::canvas::{Canvas, Ink, Item, Stroke};
use crate::font;
use crate::shape::{Rect, Segment};

/// The picture at `scale` pixels to the CSS pixel, as PNG; `Err` says why not.
pub(crate) fn png(canvas: &Canvas, scale: f32) -> Result<Vec<u8>, String> {
    let pixels = |length: u32| (length as f32 * scale).round().max(1.0) as u32;
    let mut pixmap =
        Pixmap::new(pixels(canvas.width), pixels(canvas.height)).ok_or("picture too large")?;
    pixmap.fill(Color::WHITE);
    let mut raster = Raster {
        pixmap,
        scale,
        clip: None,
    };
    for item in &canvas.items {
        raster.item(item);
    }
    encode(&raster.pixmap).map_err(|error| error.to_string())
}

/// The pixels as PNG. They stand on white: no transparency is written.
///
/// The encoder's own fast compression: the others are those of whichever `deflate` library the build's other crates chose,
/// and a picture would have other bytes in another build.
fn encode(pixmap: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    let opaque: Vec<u8> = pixmap
        .data()
        .chunks_exact(4)
        .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
        .collect();
    writer.write_image_data(&opaque)?;
    writer.finish()?;
    Ok(bytes)
}

struct Raster {
    pixmap: Pixmap,
    scale: f32,
    /// The clip of the items drawn last: items of one panel follow each other.
    clip: Option<(Rect, Mask)>,
}

impl Raster {
    fn item(&mut self, item: &Item) {
        match item {
            Item::Shape {
                segments,
                fill,
                stroke,
                clip,
            } => {
                let Some(path) = path(segments) else { return };
                if let Some(ink) = fill {
                    self.fill(&path, *ink, self.view(), *clip);
                }
                if let Some(stroke) = stroke {
                    self.stroke(&path, stroke, *clip);
                }
            }
            Item::Dots {
                centers,
                radius,
                ink,
                clip,
            } => {
                let mut builder = PathBuilder::new();
                for [x, y] in centers {
                    builder.push_circle(*x, *y, *radius);
                }
                if let Some(path) = builder.finish() {
                    self.fill(&path, *ink, self.view(), Some(*clip));
                }
            }
            Item::Text {
                line,
                at: [x, y],
                size,
                upward,
                ink,
            } => {
                let turn = if *upward { -90.0 } else { 0.0 };
                for (glyph, advance) in &line.glyphs {
                    let Some(path) = path(&font::outline(*glyph)) else {
                        continue;
                    };
                    let place = Transform::from_translate(*advance, 0.0)
                        .post_scale(*size, *size)
                        .post_rotate(turn)
                        .post_translate(*x, *y)
                        .post_concat(self.view());
                    self.fill(&path, *ink, place, None);
                }
            }
        }
    }

    fn view(&self) -> Transform {
        Transform::from_scale(self.scale, self.scale)
    }

    fn fill(&mut self, path: &Path, ink: Ink, place: Transform, clip: Option<Rect>) {
        self.prepare(clip);
        let mask = clip.and_then(|_| self.clip.as_ref().map(|(_, mask)| mask));
        self.pixmap
            .fill_path(path, &paint(ink), FillRule::Winding, place, mask);
    }

    fn stroke(&mut self, path: &Path, stroke: &Stroke, clip: Option<Rect>) {
        self.prepare(clip);
        let style = SkiaStroke {
            width: stroke.width,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Round,
            dash: StrokeDash::new(stroke.dash.clone(), 0.0),
            ..SkiaStroke::default()
        };
        let mask = clip.and_then(|_| self.clip.as_ref().map(|(_, mask)| mask));
        let view = Transform::from_scale(self.scale, self.scale);
        self.pixmap
            .stroke_path(path, &paint(stroke.ink), &style, view, mask);
    }

    /// Makes `self.clip` the mask of `clip`.
    fn prepare(&mut self, clip: Option<Rect>) {
        let Some(rect) = clip else { return };
        if self.clip.as_ref().is_some_and(|(have, _)| *have == rect) {
            return;
        }
        let outline = tiny_skia::Rect::from_ltrb(rect.left, rect.top, rect.right, rect.bottom);
        let mask = outline.and_then(|outline| {
            let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
            mask.fill_path(
                &PathBuilder::from_rect(outline),
                FillRule::Winding,
                true,
                self.view(),
            );
            Some((rect, mask))
        });
        self.clip = mask;
    }
}

fn paint(ink: Ink) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    let [r, g, b] = ink.rgb;
    paint.set_color_rgba8(r, g, b, (255.0 * ink.alpha).round() as u8);
    paint
}

/// `None` for an outline without extent.
fn path(segments: &[Segment]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for segment in segments {
        match *segment {
            Segment::Move([x, y]) => builder.move_to(x, y),
            Segment::Line([x, y]) => builder.line_to(x, y),
            Segment::Quad([cx, cy], [x, y]) => builder.quad_to(cx, cy, x, y),
            Segment::Cubic([ax, ay], [bx, by], [x, y]) => builder.cubic_to(ax, ay, bx, by, x, y),
            Segment::Close => builder.close(),
        }
    }
    builder.finish()
}
