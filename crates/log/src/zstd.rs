//! Unpacks Zstandard: by its library in C, or in Rust where a browser's target has no compiler for C.

use std::io::Read;

/// Hands the unpacked bytes to `read`, which returns whether it wants more frames. Returns whether all of them were
/// whole and wanted.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn unpack(bytes: &[u8], read: &mut dyn FnMut(&mut dyn Read) -> bool) -> bool {
    zstd::stream::read::Decoder::new(bytes).is_ok_and(|mut input| read(&mut input))
}

/// The same without the library in C: frame by frame, each against its checksum.
#[cfg(target_family = "wasm")]
pub(crate) fn unpack(mut bytes: &[u8], read: &mut dyn FnMut(&mut dyn Read) -> bool) -> bool {
    while !bytes.is_empty() {
        let Ok(mut frame) = ruzstd::decoding::StreamingDecoder::new(&mut bytes) else {
            return false;
        };
        let whole = read(&mut frame);
        let stated = frame.decoder.get_checksum_from_data();
        if !whole || stated.is_some_and(|sum| frame.decoder.get_calculated_checksum() != Some(sum))
        {
            return false;
        }
    }
    true
}
