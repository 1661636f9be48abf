//! A grey image that somebody else owns.

use crate::camera::MIN_SIDE_PX;
use crate::error::VisionError;

/// A view of an image of one byte a pixel, row by row from the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GrayImage<'a> {
    pixels: &'a [u8],
    width_px: usize,
    height_px: usize,
    stride: usize,
}

impl<'a> GrayImage<'a> {
    /// Looks at `pixels` as rows of `width_px` pixels, `stride` bytes from one
    /// row's start to the next's.
    ///
    /// # Errors
    /// Sides are at least 32 px, the stride is at least the width and the
    /// buffer holds all rows (the last one without its padding).
    pub fn new(
        pixels: &'a [u8],
        width_px: usize,
        height_px: usize,
        stride: usize,
    ) -> Result<Self, VisionError> {
        let fail = |key, expected: String, found: usize| {
            Err(VisionError::Image {
                key,
                expected,
                found: found.to_string(),
            })
        };
        for (key, side) in [("width_px", width_px), ("height_px", height_px)] {
            if side < MIN_SIDE_PX {
                return fail(key, format!("at least {MIN_SIDE_PX} pixels"), side);
            }
        }
        if stride < width_px {
            let expected = format!("at least the width of {width_px} bytes");
            return fail("stride", expected, stride);
        }
        let bytes = (height_px - 1)
            .checked_mul(stride)
            .and_then(|whole| whole.checked_add(width_px));
        if bytes.is_none_or(|bytes| pixels.len() < bytes) {
            let expected = format!("{height_px} rows of {stride} bytes");
            return fail("pixels", expected, pixels.len());
        }
        Ok(Self {
            pixels,
            width_px,
            height_px,
            stride,
        })
    }

    /// The bytes.
    #[must_use]
    pub fn pixels(&self) -> &'a [u8] {
        self.pixels
    }

    /// Width, px.
    #[must_use]
    pub fn width_px(&self) -> usize {
        self.width_px
    }

    /// Height, px.
    #[must_use]
    pub fn height_px(&self) -> usize {
        self.height_px
    }

    /// Bytes from one row's start to the next's.
    #[must_use]
    pub fn stride(&self) -> usize {
        self.stride
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_images_without_pixels_or_rows_are_refused() {
        let pixels = vec![0; 64 * 64];
        assert!(GrayImage::new(&pixels, 64, 64, 64).is_ok());
        // The last row needs no padding.
        assert!(GrayImage::new(&pixels[..62 * 65 + 60], 60, 63, 65).is_ok());
        for (width, height, stride, key) in [
            (0, 64, 64, "width_px"),
            (64, 0, 64, "height_px"),
            (64, 64, 63, "stride"),
            (64, 65, 64, "pixels"),
            (64, usize::MAX, usize::MAX, "pixels"),
        ] {
            let error = GrayImage::new(&pixels, width, height, stride).unwrap_err();
            assert!(error.to_string().contains(key), "{error}");
        }
        assert!(GrayImage::new(&[], 64, 64, 64).is_err());
    }
}
