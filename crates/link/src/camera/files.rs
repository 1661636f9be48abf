//! Images in files: PNG, JPEG and PGM, told apart by their first bytes. Colours become grey.

use std::io::Cursor;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::stream::pgm_head;
use super::{Frame, FrameError, excerpt};

/// Ends of the names of files that are images.
pub const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "pgm"];

/// Largest file that is read, bytes: an image of 64 million pixels without compression.
pub const LARGEST_FILE: u64 = 1 << 26;

/// The image in the bytes of a file, which must have a width and a height, px. The size is read first, so an image of
/// another size costs no memory.
///
/// # Errors
/// Bytes that are no whole image, or one of another size.
pub fn decode(bytes: &[u8], size_px: [usize; 2]) -> Result<Frame, FrameError> {
    let (pixels, stamp_us) = match bytes {
        [0x89, b'P', b'N', b'G', ..] => (png(bytes, size_px)?, None),
        [0xff, 0xd8, ..] => (jpeg(bytes, size_px)?, None),
        [b'P', b'5', ..] => pgm(bytes, size_px)?,
        _ => {
            return Err(FrameError::format(
                "an image: PNG, JPEG or binary PGM",
                excerpt(bytes),
            ));
        }
    };
    Ok(Frame {
        pixels,
        size_px,
        stamp_us,
    })
}

fn check_size(expected: [usize; 2], found: [usize; 2]) -> Result<(), FrameError> {
    if found == expected {
        Ok(())
    } else {
        Err(FrameError::Size { expected, found })
    }
}

fn pgm(bytes: &[u8], size_px: [usize; 2]) -> Result<(Vec<u8>, Option<i64>), FrameError> {
    let [width, height] = size_px;
    let head = pgm_head(bytes, size_px)?;
    let image = head.and_then(|(at, stamp_us)| {
        let pixels = bytes.get(at..at + width * height)?;
        Some((pixels.to_vec(), stamp_us))
    });
    image.ok_or_else(|| cut(bytes.len()))
}

/// The error of a file that ends too early.
fn cut(bytes: usize) -> FrameError {
    FrameError::format(
        "a whole image",
        format!("one that ends after {bytes} bytes"),
    )
}

fn png(bytes: &[u8], size_px: [usize; 2]) -> Result<Vec<u8>, FrameError> {
    let bad =
        |error: png::DecodingError| FrameError::format("a whole PNG image", error.to_string());
    let mut decoder = png::Decoder::new_with_limits(
        Cursor::new(bytes),
        png::Limits {
            bytes: LARGEST_FILE as usize,
        },
    );
    // Eight bits for each channel, palettes as colours.
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let head = decoder.read_header_info().map_err(bad)?;
    check_size(size_px, [head.width as usize, head.height as usize])?;
    let mut reader = decoder.read_info().map_err(bad)?;
    let length = reader.output_buffer_size().unwrap_or(0);
    let mut colours = vec![0; length];
    let info = reader.next_frame(&mut colours).map_err(bad)?;
    let channels = info.color_type.samples();
    Ok(grey(&colours[..info.buffer_size()], channels))
}

/// Grey levels of pixels of one to four channels, the last of two or four being the opacity, by ITU-R BT.601.
fn grey(colours: &[u8], channels: usize) -> Vec<u8> {
    let pixels = colours.chunks_exact(channels);
    let luma = |pixel: &[u8]| match *pixel {
        [red, green, blue, ..] => {
            let sum = 299 * u32::from(red) + 587 * u32::from(green) + 114 * u32::from(blue);
            // The weights sum to 1000.
            ((sum + 500) / 1000) as u8
        }
        [grey, ..] => grey,
        [] => 0,
    };
    pixels.map(luma).collect()
}

fn jpeg(bytes: &[u8], size_px: [usize; 2]) -> Result<Vec<u8>, FrameError> {
    let bad =
        |error: &dyn std::fmt::Display| FrameError::format("a whole JPEG image", error.to_string());
    // Strict: an image that is cut is an error, not grey below the cut.
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| bad(&e))?;
    let info = decoder.info();
    let found = info.map_or([0, 0], |info| {
        [usize::from(info.width), usize::from(info.height)]
    });
    check_size(size_px, found)?;
    let pixels = decoder.decode().map_err(|e| bad(&e))?;
    if pixels.len() == size_px[0] * size_px[1] {
        Ok(pixels)
    } else {
        Err(cut(bytes.len()))
    }
}

/// A grey image as the bytes of a PNG file.
///
/// # Errors
/// A frame whose pixels are not width times height.
pub fn encode_png(frame: &Frame) -> Result<Vec<u8>, FrameError> {
    let bad = |error: png::EncodingError| FrameError::format("a grey image", error.to_string());
    let [width, height] = frame.size_px.map(|side| u32::try_from(side).unwrap_or(0));
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(bad)?;
    writer.write_image_data(&frame.pixels).map_err(bad)?;
    writer.finish().map_err(bad)?;
    Ok(bytes)
}

/// A grey image as the bytes of a PGM file, with its stamp.
#[must_use]
pub fn encode_pgm(frame: &Frame) -> Vec<u8> {
    let [width, height] = frame.size_px;
    let stamp = frame.stamp_us.map_or_else(String::new, |stamp_us| {
        format!("# monotonic_s {:.6}\n", stamp_us as f64 * 1e-6)
    });
    let mut bytes = format!("P5\n{stamp}{width} {height}\n255\n").into_bytes();
    bytes.extend_from_slice(&frame.pixels);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SIZE: [usize; 2] = [40, 33];

    fn frame() -> Frame {
        Frame {
            pixels: (0..40 * 33).map(|i| (i % 251) as u8).collect(),
            size_px: SIZE,
            stamp_us: None,
        }
    }

    /// A baseline JPEG of 8 × 8 grey pixels of one level, by hand: one Huffman code each for "no difference" and "end".
    fn small_jpeg() -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8, 0xff, 0xdb, 0, 67, 0];
        bytes.extend([1; 64]);
        bytes.extend([0xff, 0xc0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0]);
        for class in [0x00, 0x10] {
            bytes.extend([0xff, 0xc4, 0, 20, class, 1]);
            bytes.extend([0; 15]);
            bytes.push(0);
        }
        bytes.extend([0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0]);
        // Two codes of one bit, filled with ones.
        bytes.extend([0b0011_1111, 0xff, 0xd9]);
        bytes
    }

    #[test]
    fn analytic_images_come_back_from_their_files() {
        let frame = frame();
        assert_eq!(decode(&encode_png(&frame).unwrap(), SIZE).unwrap(), frame);
        assert_eq!(decode(&encode_pgm(&frame), SIZE).unwrap(), frame);
        let stamped = Frame {
            stamp_us: Some(12_345_678),
            ..frame
        };
        assert_eq!(decode(&encode_pgm(&stamped), SIZE).unwrap(), stamped);
        let jpeg = decode(&small_jpeg(), [8, 8]).unwrap();
        assert_eq!(jpeg.pixels, [128; 64]);
    }

    #[test]
    fn analytic_colours_become_their_luma() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Sixteen);
        let mut writer = encoder.write_header().unwrap();
        let (white, dim) = ([0xff; 8], [0x80, 0, 0, 0, 0, 0, 0xff, 0xff]);
        writer.write_image_data(&[white, dim].concat()).unwrap();
        writer.finish().unwrap();
        // 0.299 of a red of 128.
        assert_eq!(decode(&bytes, [2, 1]).unwrap().pixels, [255, 38]);
    }

    #[test]
    fn prop_files_that_are_cut_empty_or_of_another_size_are_one_error() {
        let files = [
            (encode_png(&frame()).unwrap(), SIZE),
            (encode_pgm(&frame()), SIZE),
            (small_jpeg(), [8, 8]),
        ];
        for (bytes, size) in files {
            let whole = decode(&bytes, size).unwrap();
            for length in 0..bytes.len() {
                match decode(&bytes[..length], size) {
                    // Behind the last pixel stand only check sums and the file's end.
                    Ok(frame) => assert!(frame == whole && length + 20 > bytes.len(), "{length}"),
                    Err(error) => assert!(error.to_string().contains("expected")),
                }
            }
            let other = decode(&bytes, [640, 480]).unwrap_err().to_string();
            assert!(
                other.contains("found") && other.contains("640 x 480"),
                "{other}"
            );
        }
        let dot = Frame {
            pixels: vec![7],
            size_px: [1, 1],
            stamp_us: None,
        };
        for bytes in [encode_png(&dot).unwrap(), encode_pgm(&dot)] {
            let said = decode(&bytes, SIZE).unwrap_err().to_string();
            assert!(said.contains("found 1 x 1"), "{said}");
        }
        assert!(
            decode(b"", SIZE)
                .unwrap_err()
                .to_string()
                .contains("nothing")
        );
    }

    #[test]
    fn prop_an_image_that_claims_to_be_huge_costs_no_memory() {
        let mut huge = encode_png(&frame()).unwrap();
        // Width and height of the head; its check sum is then wrong as well, which must not decide.
        huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        assert!(decode(&huge, SIZE).is_err());
        let pgm = b"P5 65535 65535 255\n";
        assert!(matches!(decode(pgm, SIZE), Err(FrameError::Size { .. })));
        assert!(
            decode(pgm, [65_535, 65_535])
                .unwrap_err()
                .to_string()
                .contains("19 bytes")
        );
    }

    proptest! {
        #[test]
        fn prop_any_bytes_are_an_image_or_an_error(
            file in 0..3_usize,
            at in 0..1500_usize,
            noise in proptest::collection::vec(any::<u8>(), 1..20),
        ) {
            let (mut bytes, size) = match file {
                0 => (encode_png(&frame()).unwrap(), SIZE),
                1 => (encode_pgm(&frame()), SIZE),
                _ => (small_jpeg(), [8, 8]),
            };
            let at = at % bytes.len();
            for (byte, noise) in bytes[at..].iter_mut().zip(noise) {
                *byte ^= noise;
            }
            if let Ok(frame) = decode(&bytes, size) {
                prop_assert_eq!(frame.pixels.len(), size[0] * size[1]);
            }
        }
    }
}
