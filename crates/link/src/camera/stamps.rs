//! Times of exposure as `v4l2-ctl --verbose` prints them, a line for each buffer of the driver:
//!
//! ```text
//! cap dqbuf: 2 seq:     14 bytesused: 307200 ts: 5021.386113 delta: 33.341 ms fps: 29.99 (ts-monotonic, ts-src-soe)
//! ```
//!
//! The time is of `CLOCK_MONOTONIC`, mostly of the start of the exposure (`ts-src-soe`) or of the end of the transfer
//! (`ts-src-eof`). A buffer that is marked `error` is printed, but its image is not written.

use super::stream::seconds_to_us;

/// What a line says of an image that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferStamp {
    /// The driver's stamp, µs, of `CLOCK_MONOTONIC`; none if the driver has another clock.
    pub stamp_us: Option<i64>,
    /// Bytes of the image.
    pub bytes: Option<usize>,
    /// Whether it is of the start of the exposure.
    pub starts: bool,
}

/// The stamp of the image that goes with a line; none if the line goes with no image.
#[must_use]
pub fn buffer_stamp(line: &str) -> Option<BufferStamp> {
    let (_, rest) = line.split_once(" dqbuf: ")?;
    let (_, flags) = rest.rsplit_once('(').unwrap_or_default();
    let has = |name: &str| {
        flags
            .trim_end()
            .trim_end_matches(')')
            .split(", ")
            .any(|f| f == name)
    };
    if has("error") {
        return None;
    }
    let after = |name: &str| rest.split_once(name)?.1.split_whitespace().next();
    let stamp_us = after(" ts: ").and_then(seconds_to_us);
    let stamp_us = stamp_us.filter(|_| has("ts-monotonic"));
    Some(BufferStamp {
        stamp_us,
        bytes: after(" bytesused: ").and_then(|bytes| bytes.parse().ok()),
        starts: has("ts-src-soe"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_lines_with_images_have_stamps_and_others_do_not() {
        let line = "cap dqbuf: 2 seq:     14 bytesused: 307200 ts: 5021.386113 delta: 33.341 ms fps: 29.99 (ts-monotonic, ts-src-soe)";
        let with = |stamp_us, starts, bytes| BufferStamp {
            stamp_us,
            bytes,
            starts,
        };
        let stamp = |stamp_us, starts| Some(with(stamp_us, starts, Some(307_200)));
        assert_eq!(buffer_stamp(line), stamp(Some(5_021_386_113), true));
        let end = line.replace("ts-src-soe", "ts-src-eof");
        assert_eq!(buffer_stamp(&end), stamp(Some(5_021_386_113), false));
        assert_eq!(buffer_stamp(&line.replace("soe)", "soe, error)")), None);
        let unknown = line.replace("ts-monotonic, ts-src-soe", "ts-unknown");
        assert_eq!(buffer_stamp(&unknown), stamp(None, false));
        let copied = "\tcap dqbuf: 0 seq: 1 bytesused: 9";
        assert_eq!(buffer_stamp(copied), Some(with(None, false, Some(9))));
        for other in [
            "",
            "<<<<",
            "VIDIOC_STREAMON returned 0 (Success)",
            "dqbuf: (",
            " dqbuf: ts: (",
        ] {
            let with_image = other == " dqbuf: ts: (";
            assert_eq!(buffer_stamp(other).is_some(), with_image, "{other}");
        }
    }
}
