//! A digest of a block's file in the file itself, by which a block that has changed on its disk is found.
//!
//! It stands as a note beside the landings: SHA-256 of the whole file, with zeros in its own place.

use sha2::{Digest, Sha256};

/// Key of the note.
pub(super) const SEAL: &str = "touchdown.file_sha256";
/// The note of a file that is not sealed yet.
pub(super) const UNSEALED: &str =
    "0000000000000000000000000000000000000000000000000000000000000000";
/// Most bytes between key and digest: their lengths, in the encoding of the file's metadata.
const BETWEEN: usize = 8;

/// A file with the note [`UNSEALED`], with its digest in place of the zeros.
pub(super) fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    if let Some(at) = place(&bytes) {
        let digest = hex(&bytes);
        bytes[at..at + UNSEALED.len()].copy_from_slice(digest.as_bytes());
    }
    bytes
}

/// Whether a file is as it was sealed. Files of versions before the seal count as such.
pub(super) fn is_intact(bytes: &[u8]) -> bool {
    if key_end(bytes).is_none() {
        return true;
    }
    place(bytes).is_some_and(|at| {
        let (mut unsealed, digest) = (bytes.to_vec(), at..at + UNSEALED.len());
        unsealed[digest.clone()].copy_from_slice(UNSEALED.as_bytes());
        hex(&unsealed).as_bytes() == &bytes[digest]
    })
}

/// Where the digest begins.
fn place(bytes: &[u8]) -> Option<usize> {
    let from = key_end(bytes)?;
    let digits = |at: &usize| {
        let digest = bytes.get(*at..at + UNSEALED.len());
        digest.is_some_and(|digest| digest.iter().all(u8::is_ascii_hexdigit))
    };
    (from..from + BETWEEN).find(digits)
}

/// Where the key of the note ends, which stands once, in the metadata at the end.
fn key_end(bytes: &[u8]) -> Option<usize> {
    let length = SEAL.len();
    let start = bytes
        .windows(length)
        .rposition(|part| part == SEAL.as_bytes());
    start.map(|start| start + length)
}

fn hex(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::super::part::CampaignPart;
    use super::super::points::Sweep;
    use super::super::row::LandingRow;
    use super::super::store::Store;
    use crate::place::Place;

    #[test]
    fn prop_a_block_with_a_changed_bit_is_refused_or_has_the_same_landings() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("sweep.toml");
        std::fs::write(&file, "trials = 5\n").unwrap();
        let sweep = Sweep::read(&file, None, None).unwrap();
        let out = folder.path().join("out");
        let place = Place::Folder(out.clone());
        let store = Store::open(&place, &sweep, CampaignPart::Whole, false).unwrap();
        let rows: Vec<LandingRow> = (0..5_u32)
            .map(|i| LandingRow {
                landing: i.into(),
                outcome: ["landed", "crashed"][(i % 2) as usize].into(),
                why: (i % 2 == 1).then(|| "speed".into()),
                abort_reasons: None,
                counts: [1, 0, i.into(), 40_000],
                numbers: std::array::from_fn(|k| Some(0.1 * f64::from(i) + k as f64)),
            })
            .collect();
        store.write(&sweep, 0, &rows).unwrap();
        assert_eq!(store.read(&sweep, 0).unwrap(), rows);
        let path = out.join("landings/block-000000.parquet");
        let bytes = std::fs::read(&path).unwrap();
        let mut read_again = 0;
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1 << (at % 8);
            std::fs::write(&path, changed).unwrap();
            if let Ok(read) = store.read(&sweep, 0) {
                assert_eq!(read, rows, "byte {at}");
                read_again += 1;
            }
        }
        // Nothing but the key of the note may change: a file without it counts as one of an earlier version.
        assert!(read_again <= super::SEAL.len(), "{read_again}");
    }
}
