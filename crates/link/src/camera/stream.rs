//! Frames in a stream of bytes, as programs write them to a pipe.
//!
//! | format | frame | who writes it |
//! | --- | --- | --- |
//! | `grey` | width times height bytes, nothing between frames | `ffmpeg -f rawvideo -pix_fmt gray -`, `v4l2-ctl --stream-to=-` |
//! | `yuyv` | twice as many bytes, of which the first, third, fifth … are grey | `v4l2-ctl --stream-to=-` |
//! | `pgm` | `P5 WIDTH HEIGHT 255` and the bytes; a comment `# monotonic_s 12.345678` is the middle of the exposure | `ffmpeg -f image2pipe -c:v pgm -`, programs of your own |
//! | `y4m` | a head for the stream, then `FRAME` and the planes, of which the first is grey | `ffmpeg -f yuv4mpegpipe -`, `rpicam-vid` with `ffmpeg` |
//!
//! The stamp of a PGM image is of `CLOCK_MONOTONIC`. A stream cannot be resynchronised: after an error it has ended.

use serde::{Deserialize, Serialize};

use super::{Frame, FrameError, excerpt};

/// Longest head of a stream or a frame, bytes: ten times what writers need.
const LONGEST_HEAD: usize = 1024;

/// How frames follow each other in a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StreamFormat {
    /// Pixels only.
    Grey,
    /// Pixels with colours: YUYV 4:2:2, packed.
    Yuyv,
    /// Binary PGM images of eight bits.
    Pgm,
    /// YUV4MPEG2 of eight bits.
    #[default]
    Y4m,
}

/// Finds the frames in bytes that come in any pieces.
#[derive(Clone, Debug)]
pub struct FrameParser {
    format: StreamFormat,
    size_px: [usize; 2],
    bytes: Vec<u8>,
    /// Bytes of a Y4M frame after its grey plane, once the head of the stream is read.
    chroma: Option<usize>,
    error: Option<FrameError>,
}

/// The head of a frame: its length, and its stamp, µs.
type Head = (usize, Option<i64>);

impl FrameParser {
    /// A parser for frames of a width and a height, px.
    #[must_use]
    pub fn new(format: StreamFormat, size_px: [usize; 2]) -> Self {
        Self {
            format,
            size_px,
            bytes: Vec::new(),
            chroma: None,
            error: None,
        }
    }

    /// Takes the next bytes of the stream.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.error.is_none() {
            self.bytes.extend_from_slice(bytes);
        }
    }

    /// Bytes that wait for the rest of their frame.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.bytes.len()
    }

    /// Bytes of the pixels of a frame; of Y4M those of its grey plane.
    #[must_use]
    pub fn frame_bytes(&self) -> usize {
        let [width, height] = self.size_px;
        let each = if self.format == StreamFormat::Yuyv {
            2
        } else {
            1
        };
        each * width * height
    }

    /// The next whole frame, if there is one.
    ///
    /// # Errors
    /// Bytes that are no frames, or frames of another size. The stream has then ended: each later call returns the same.
    pub fn next_frame(&mut self) -> Result<Option<Frame>, FrameError> {
        if let Some(error) = &self.error {
            return Err(error.clone());
        }
        self.parse().inspect_err(|error| {
            self.error = Some(error.clone());
            self.bytes = Vec::new();
        })
    }

    fn parse(&mut self) -> Result<Option<Frame>, FrameError> {
        let head = match self.format {
            StreamFormat::Grey | StreamFormat::Yuyv => Some((0, None)),
            StreamFormat::Pgm => pgm_head(&self.bytes, self.size_px)?,
            StreamFormat::Y4m => self.y4m_head()?,
        };
        let Some((head, stamp_us)) = head else {
            return Ok(None);
        };
        let grey = head + self.frame_bytes();
        let end = grey + self.chroma.unwrap_or(0);
        if self.bytes.len() < end {
            return Ok(None);
        }
        let pixels = &self.bytes[head..grey];
        let pixels = match self.format {
            StreamFormat::Yuyv => pixels.iter().step_by(2).copied().collect(),
            _ => pixels.to_vec(),
        };
        self.bytes.drain(..end);
        Ok(Some(Frame {
            pixels,
            size_px: self.size_px,
            stamp_us,
        }))
    }

    /// Reads the head of the stream first, then that of a frame.
    fn y4m_head(&mut self) -> Result<Option<Head>, FrameError> {
        if self.chroma.is_none() {
            let Some(length) = line(&self.bytes, "YUV4MPEG2 ")? else {
                return Ok(None);
            };
            self.chroma = Some(y4m_chroma(&self.bytes[..length - 1], self.size_px)?);
            self.bytes.drain(..length);
        }
        Ok(line(&self.bytes, "FRAME")?.map(|length| (length, None)))
    }
}

/// Length of the first line with its end, once it is there. It must begin as `expected`.
fn line(bytes: &[u8], expected: &str) -> Result<Option<usize>, FrameError> {
    let common = bytes.len().min(expected.len());
    let fits = bytes[..common] == expected.as_bytes()[..common];
    let end = bytes.iter().take(LONGEST_HEAD).position(|b| *b == b'\n');
    if !fits || (end.is_none() && bytes.len() >= LONGEST_HEAD) {
        let expected = format!("`{expected}` of a Y4M stream");
        return Err(FrameError::format(&expected, excerpt(bytes)));
    }
    // An end within the expected text is caught above.
    Ok(end.map(|end| end + 1))
}

/// Bytes after the grey plane of each frame, from the head of a Y4M stream.
fn y4m_chroma(head: &[u8], size_px: [usize; 2]) -> Result<usize, FrameError> {
    let text = String::from_utf8_lossy(head);
    let (mut found, mut colour) = ([0, 0], "420");
    for field in text.split(' ').skip(1) {
        let Some((key, value)) = field.split_at_checked(1) else {
            continue;
        };
        match key {
            "W" => found[0] = value.parse().unwrap_or(0),
            "H" => found[1] = value.parse().unwrap_or(0),
            "C" => colour = value,
            _ => {}
        }
    }
    if found != size_px {
        let expected = size_px;
        return Err(FrameError::Size { expected, found });
    }
    let [width, height] = size_px;
    let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
    match colour {
        "mono" => Ok(0),
        "420" | "420jpeg" | "420paldv" | "420mpeg2" => Ok(2 * half_width * half_height),
        "422" => Ok(2 * half_width * height),
        "444" => Ok(2 * width * height),
        "411" => Ok(2 * width.div_ceil(4) * height),
        other => Err(FrameError::format(
            "Y4M of eight bits: Cmono, C420, C422, C444 or C411",
            format!("C{other}"),
        )),
    }
}

/// Reads the head of a binary PGM image, once it is there.
pub(super) fn pgm_head(bytes: &[u8], expected: [usize; 2]) -> Result<Option<Head>, FrameError> {
    let mut head = PgmHead {
        bytes,
        at: 0,
        stamp_us: None,
    };
    let numbers = head.read()?;
    let length = numbers.map_or(bytes.len(), |_| head.at);
    if length > LONGEST_HEAD {
        return Err(no_pgm(bytes));
    }
    let Some([width, height, white]) = numbers else {
        return Ok(None);
    };
    if [width, height] != expected {
        let found = [width, height];
        return Err(FrameError::Size { expected, found });
    }
    if white != 255 {
        return Err(FrameError::format(
            "a PGM image whose white is 255",
            white.to_string(),
        ));
    }
    Ok(Some((head.at, head.stamp_us)))
}

fn no_pgm(bytes: &[u8]) -> FrameError {
    FrameError::format("a binary PGM image (`P5 WIDTH HEIGHT 255`)", excerpt(bytes))
}

/// A reader of a PGM image's head.
struct PgmHead<'a> {
    bytes: &'a [u8],
    at: usize,
    stamp_us: Option<i64>,
}

impl PgmHead<'_> {
    /// Width, height and white, up to the first pixel; none while bytes are missing.
    fn read(&mut self) -> Result<Option<[usize; 3]>, FrameError> {
        let magic = b"P5";
        let common = self.bytes.len().min(magic.len());
        if self.bytes[..common] != magic[..common] {
            return Err(no_pgm(self.bytes));
        }
        self.at = magic.len();
        let mut numbers = [0; 3];
        for number in &mut numbers {
            match self.number()? {
                Some(found) => *number = found,
                None => return Ok(None),
            }
        }
        // One white space stands between the head and the pixels.
        self.at += 1;
        Ok(Some(numbers))
    }

    /// The next number, after white space and comments; none while its end is missing.
    fn number(&mut self) -> Result<Option<usize>, FrameError> {
        let mut separated = false;
        loop {
            match self.bytes.get(self.at) {
                None => return Ok(None),
                Some(b'#') => {
                    let rest = &self.bytes[self.at..];
                    let Some(length) = rest.iter().position(|b| *b == b'\n') else {
                        return Ok(None);
                    };
                    self.stamp_us = stamp(&rest[..length]).or(self.stamp_us);
                    self.at += length;
                }
                Some(b) if b.is_ascii_whitespace() => {
                    separated = true;
                    self.at += 1;
                }
                Some(_) => break,
            }
        }
        let digits = &self.bytes[self.at..];
        let Some(length) = digits.iter().position(|b| !b.is_ascii_digit()) else {
            return Ok(None);
        };
        let text = std::str::from_utf8(&digits[..length]).unwrap_or_default();
        let ends = digits[length].is_ascii_whitespace();
        match text.parse() {
            // Larger sides than any camera's are no sides.
            Ok(number @ 1..=65_535) if separated && ends => {
                self.at += length;
                Ok(Some(number))
            }
            _ => Err(no_pgm(self.bytes)),
        }
    }
}

/// The stamp in a comment, µs.
fn stamp(comment: &[u8]) -> Option<i64> {
    let text = std::str::from_utf8(comment).ok()?;
    let seconds = text.strip_prefix("# monotonic_s ")?.trim();
    seconds_to_us(seconds)
}

/// Microseconds of a number of seconds, none for one that a clock does not show.
pub(super) fn seconds_to_us(text: &str) -> Option<i64> {
    let seconds: f64 = text.parse().ok()?;
    // 30 years: clocks begin at a start of the machine or of a recording.
    let usable = (0.0..1e9).contains(&seconds);
    usable.then(|| (seconds * 1e6).round() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SIZE: [usize; 2] = [6, 4];

    fn pixels(k: u8) -> Vec<u8> {
        (0..24).map(|i| i * 7 + k).collect()
    }

    /// Three frames in each format.
    fn streams() -> Vec<(StreamFormat, Vec<u8>)> {
        let (mut grey, mut pgm, mut y4m) = (Vec::new(), Vec::new(), Vec::new());
        let mut yuyv = Vec::new();
        let mut mono = b"YUV4MPEG2 W6 H4 Cmono\n".to_vec();
        y4m.extend_from_slice(b"YUV4MPEG2 W6 H4 F30:1 Ip A1:1 C420jpeg XYSCSS=420JPEG\n");
        for k in 0..3 {
            grey.extend(pixels(k));
            yuyv.extend(pixels(k).iter().flat_map(|grey| [*grey, 128]));
            let head = format!("P5\n# of a camera\n# monotonic_s 1{k}.25\n6 4\n255\n");
            pgm.extend(head.as_bytes());
            pgm.extend(pixels(k));
            y4m.extend(b"FRAME Ip\n");
            y4m.extend(pixels(k));
            y4m.extend([128; 12]);
            mono.extend(b"FRAME\n");
            mono.extend(pixels(k));
        }
        vec![
            (StreamFormat::Yuyv, yuyv),
            (StreamFormat::Grey, grey),
            (StreamFormat::Pgm, pgm),
            (StreamFormat::Y4m, y4m),
            (StreamFormat::Y4m, mono),
        ]
    }

    /// The frames of a stream that comes in pieces, and what ended it.
    fn read(format: StreamFormat, bytes: &[u8], piece: usize) -> (Vec<Frame>, Option<FrameError>) {
        let mut parser = FrameParser::new(format, SIZE);
        let mut frames = Vec::new();
        for chunk in bytes.chunks(piece.max(1)) {
            parser.push(chunk);
            loop {
                match parser.next_frame() {
                    Ok(Some(frame)) => frames.push(frame),
                    Ok(None) => break,
                    Err(error) => {
                        assert_eq!(parser.next_frame(), Err(error.clone()));
                        return (frames, Some(error));
                    }
                }
            }
            assert!(parser.waiting() <= LONGEST_HEAD + 48);
        }
        (frames, None)
    }

    #[test]
    fn analytic_every_format_gives_its_pixels_and_its_stamps_in_pieces_of_any_size() {
        for (format, bytes) in streams() {
            for piece in 1..bytes.len() {
                let (frames, error) = read(format, &bytes, piece);
                assert_eq!((frames.len(), error), (3, None), "{format:?} by {piece}");
                for (k, frame) in frames.iter().enumerate() {
                    assert_eq!((&frame.pixels, frame.size_px), (&pixels(k as u8), SIZE));
                    let stamp =
                        (format == StreamFormat::Pgm).then_some(10_250_000 + 1_000_000 * k as i64);
                    assert_eq!(frame.stamp_us, stamp);
                }
            }
        }
    }

    #[test]
    fn prop_a_stream_that_is_cut_anywhere_gives_its_whole_frames_and_no_error() {
        for (format, bytes) in streams() {
            for length in 0..bytes.len() {
                let (frames, error) = read(format, &bytes[..length], 7);
                assert!(
                    frames.len() < 3 && error.is_none(),
                    "{format:?} at {length}"
                );
            }
        }
    }

    #[test]
    fn prop_streams_of_other_sizes_and_formats_are_refused_in_one_sentence() {
        let refused = |format, bytes: &[u8]| {
            let (frames, error) = read(format, bytes, 5);
            assert!(frames.is_empty());
            error.expect("an error").to_string()
        };
        let said = refused(StreamFormat::Pgm, b"P5 8 4 255 ");
        assert_eq!(
            said,
            "expected 6 x 4 pixels (`camera.width_px`, `camera.height_px`), found 8 x 4"
        );
        assert!(refused(StreamFormat::Y4m, b"YUV4MPEG2 W1 H1 Cmono\n").contains("found 1 x 1"));
        assert!(refused(StreamFormat::Y4m, b"YUV4MPEG2 Wx H4\n").contains("found 0 x 4"));
        assert!(refused(StreamFormat::Y4m, b"YUV4MPEG2 W6 H4 C420p10\n").contains("C420p10"));
        assert!(refused(StreamFormat::Y4m, b"P5 6 4 255\n").contains("P5"));
        assert!(refused(StreamFormat::Pgm, b"P2 6 4 255\n").contains("P2"));
        assert!(refused(StreamFormat::Pgm, b"P5 6 4 65535\n").contains("65535"));
        assert!(refused(StreamFormat::Pgm, b"P5 99999999999999999999 4 255\n").contains("P5"));
        assert!(refused(StreamFormat::Pgm, b"P56 4 255\n").contains("P56"));
        let mut endless = b"P5 #".to_vec();
        endless.resize(4 * LONGEST_HEAD, b'x');
        assert!(refused(StreamFormat::Pgm, &endless).contains("P5"));
        let mut endless = b"YUV4MPEG2 ".to_vec();
        endless.resize(4 * LONGEST_HEAD, b'x');
        assert!(refused(StreamFormat::Y4m, &endless).contains("YUV4MPEG2"));
    }

    #[test]
    fn prop_stamps_that_no_clock_shows_are_none() {
        for text in ["-1", "nan", "inf", "1e300", "", "x"] {
            let bytes = format!("P5 # a\n# monotonic_s {text}\n6 4 255\n");
            let (_, stamp) = pgm_head(bytes.as_bytes(), SIZE).unwrap().unwrap();
            assert_eq!(stamp, None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn prop_any_bytes_are_frames_or_one_error_and_never_pile_up(
            format in 0..5_usize,
            at in 0..400_usize,
            noise in proptest::collection::vec(any::<u8>(), 0..40),
            piece in 1..64_usize,
        ) {
            let (format, mut bytes) = streams().swap_remove(format);
            let at = at.min(bytes.len());
            bytes.splice(at..at, noise);
            let whole = read(format, &bytes, bytes.len());
            prop_assert_eq!(read(format, &bytes, piece).0, whole.0);
        }
    }
}
