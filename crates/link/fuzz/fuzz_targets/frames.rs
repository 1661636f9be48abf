//! Any bytes in any pieces are frames of the camera's size, or one error; any file is an image or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_link::camera::files;
use touchdown_link::camera::folder::images;
use touchdown_link::camera::report::CameraReport;
use touchdown_link::camera::stamps::buffer_stamp;
use touchdown_link::camera::stream::{FrameParser, StreamFormat};

const SIZE: [usize; 2] = [40, 32];

fuzz_target!(|bytes: &[u8]| {
    let Some((choice, bytes)) = bytes.split_first() else {
        return;
    };
    let formats = [
        StreamFormat::Grey,
        StreamFormat::Yuyv,
        StreamFormat::Pgm,
        StreamFormat::Y4m,
    ];
    let format = formats[usize::from(choice % 4)];
    let read = |piece: usize| {
        let mut parser = FrameParser::new(format, SIZE);
        let mut frames = Vec::new();
        for chunk in bytes.chunks(piece) {
            parser.push(chunk);
            while let Ok(Some(frame)) = parser.next_frame() {
                assert_eq!(frame.pixels.len(), SIZE[0] * SIZE[1]);
                frames.push(frame);
            }
            // A frame of YUV 4:4:4, and a head.
            assert!(parser.waiting() <= 3 * SIZE[0] * SIZE[1] + 2048);
        }
        frames
    };
    assert_eq!(read(usize::from(choice / 4) + 1), read(bytes.len().max(1)));
    if let Ok(frame) = files::decode(bytes, SIZE) {
        assert_eq!(frame.pixels.len(), SIZE[0] * SIZE[1]);
    }
    let text = String::from_utf8_lossy(bytes);
    let _ = buffer_stamp(&text);
    let _ = images(&["a.png".to_string(), "b.png".to_string()], Some(&text));
    let _ = images(&text.lines().map(str::to_string).collect::<Vec<_>>(), None);
    let _ = CameraReport::from_json(bytes);
});
