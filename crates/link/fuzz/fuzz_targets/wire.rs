//! Any bytes in any pieces are messages, or are counted; signed links accept nothing without the key.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_link::wire::Decoder;
use touchdown_link::wire::signing::{Signing, SigningKey, Verifier};

fuzz_target!(|bytes: &[u8]| {
    let Some((piece, bytes)) = bytes.split_first() else {
        return;
    };
    let signing = Signing {
        key: SigningKey::new([7; 32]),
        link_id: 0,
        start: 0,
    };
    let read = |mut decoder: Decoder, piece: usize| {
        let mut messages = Vec::new();
        for chunk in bytes.chunks(piece) {
            decoder.push(chunk);
            while let Some(frame) = decoder.next_frame() {
                messages.push(format!("{frame:?}"));
            }
            // A frame has at most 280 bytes: more never waits.
            assert!(decoder.waiting() < 280);
        }
        messages
    };
    let piece = usize::from(*piece) + 1;
    // The end of an unknown frame is judged by the byte that follows, so pieces may differ from the whole: neither may panic.
    read(Decoder::default(), bytes.len().max(1));
    read(Decoder::default(), piece);
    assert!(read(Decoder::new(Some(Verifier::new(signing))), piece).is_empty());
});
