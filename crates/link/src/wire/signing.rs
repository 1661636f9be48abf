//! Signatures of MAVLink 2.
//!
//! A signature is a link id, a time in units of 10 µs since 2015-01-01, and the first six bytes of
//! `SHA-256(key, frame, link id, time)`. Source: <https://mavlink.io/en/guide/message_signing.html>. A frame is accepted if
//! its hash is right and its time is later than that of the last frame of the same sender and link. The first frame of a
//! sender may be at most a minute older than the newest time that was seen.

use std::fmt;

use sha2::{Digest, Sha256};

use super::{SIGNATURE, SIGNED};

/// Units of signature times in a minute.
const MINUTE: u64 = 60 * 100_000;
/// Microseconds in a unit.
const UNIT_US: u64 = 10;
/// Seconds from 1970-01-01 to 2015-01-01.
const EPOCH_S: u64 = 1_420_070_400;
/// Senders and links that are known at most.
const MOST_STREAMS: usize = 16;

/// The secret that both sides share.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct SigningKey([u8; 32]);

impl fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SigningKey(..)")
    }
}

impl SigningKey {
    /// A key of 32 bytes.
    #[must_use]
    pub fn new(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }

    /// Who hears one signed message can try all shorter passphrases of letters and digits in about an hour.
    pub const SHORTEST_PASSPHRASE: usize = 8;

    /// The key of a file's text: 64 hexadecimal digits, or else a passphrase whose SHA-256 is the key, as in QGroundControl
    /// and MAVProxy. Surrounding white space does not count.
    ///
    /// # Errors
    /// Fewer letters than [`Self::SHORTEST_PASSPHRASE`], or 32 and more hexadecimal digits that are not 64: a key that was
    /// cut, not a passphrase.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let digits_only = text.bytes().all(|byte| byte.is_ascii_hexdigit());
        let letters = text.chars().count();
        let cut = digits_only && letters >= 32 && letters != 64;
        if letters < Self::SHORTEST_PASSPHRASE || cut {
            let what = if cut { "hexadecimal digits" } else { "letters" };
            return Err(format!(
                "expected 64 hexadecimal digits or a passphrase of at least {} letters, found {letters} {what}",
                Self::SHORTEST_PASSPHRASE
            ));
        }
        let digits: Option<Vec<u8>> = (text.len() == 64 && text.is_ascii())
            .then(|| {
                (0..32)
                    .map(|k| u8::from_str_radix(&text[2 * k..2 * k + 2], 16).ok())
                    .collect()
            })
            .flatten();
        Ok(match digits.and_then(|digits| digits.try_into().ok()) {
            Some(bytes) => Self(bytes),
            None => Self(Sha256::digest(text.as_bytes()).into()),
        })
    }

    fn hash(&self, frame: &[u8], link_and_time: &[u8]) -> [u8; 6] {
        let mut hash = Sha256::new();
        hash.update(self.0);
        hash.update(frame);
        hash.update(link_and_time);
        let whole: [u8; 32] = hash.finalize().into();
        [whole[0], whole[1], whole[2], whole[3], whole[4], whole[5]]
    }
}

/// The signing of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signing {
    /// The secret.
    pub key: SigningKey,
    /// Id of our link.
    pub link_id: u8,
    /// Time of the companion's start, in units of 10 µs since 2015-01-01.
    pub start: u64,
}

/// The signature time of a UNIX time in microseconds.
#[must_use]
pub fn signature_time(unix_us: u64) -> u64 {
    unix_us.saturating_sub(EPOCH_S * 1_000_000) / UNIT_US
}

/// Signs outgoing frames.
#[derive(Clone, Debug)]
pub struct Signer {
    signing: Signing,
    last: u64,
}

impl Signer {
    /// A signer that has signed nothing.
    #[must_use]
    pub fn new(signing: Signing) -> Self {
        Self { signing, last: 0 }
    }

    /// Appends the signature of the frame that begins at `begin`.
    pub(super) fn append(&mut self, begin: usize, now_us: i64, out: &mut Vec<u8>) {
        let elapsed = u64::try_from(now_us).unwrap_or(0) / UNIT_US;
        // Two frames of one instant need two times.
        self.last = (self.signing.start + elapsed).max(self.last + 1);
        let mut link_and_time = [0; 7];
        link_and_time[0] = self.signing.link_id;
        link_and_time[1..].copy_from_slice(&self.last.to_le_bytes()[..6]);
        let hash = self.signing.key.hash(&out[begin..], &link_and_time);
        out.extend_from_slice(&link_and_time);
        out.extend_from_slice(&hash);
    }
}

/// Checks the signatures of incoming frames.
#[derive(Clone, Debug)]
pub struct Verifier {
    key: SigningKey,
    newest: u64,
    /// System, component and link of each sender, and the time of its last frame.
    streams: Vec<([u8; 3], u64)>,
}

impl Verifier {
    /// A verifier that has heard nothing.
    #[must_use]
    pub fn new(signing: Signing) -> Self {
        Self {
            key: signing.key,
            newest: signing.start,
            streams: Vec::with_capacity(MOST_STREAMS),
        }
    }

    /// Whether a whole frame of MAVLink 2, whose signature begins at `end`, is signed by the key and not older than what
    /// came before.
    pub(super) fn accepts(&mut self, frame: &[u8], end: usize) -> bool {
        if frame.len() != end + SIGNATURE || frame[2] & SIGNED == 0 {
            return false;
        }
        let (signed, signature) = frame.split_at(end);
        let (link_and_time, hash) = signature.split_at(7);
        if self.key.hash(signed, link_and_time) != hash {
            return false;
        }
        let mut time = [0; 8];
        time[..6].copy_from_slice(&link_and_time[1..]);
        let time = u64::from_le_bytes(time);
        let sender = [frame[5], frame[6], link_and_time[0]];
        let full = self.streams.len() == MOST_STREAMS;
        match self.streams.iter_mut().find(|(known, _)| *known == sender) {
            Some((_, last)) if time > *last => *last = time,
            Some(_) => return false,
            None if time + MINUTE < self.newest || full => {
                return false;
            }
            None => self.streams.push((sender, time)),
        }
        self.newest = self.newest.max(time);
        true
    }
}
