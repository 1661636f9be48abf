//! Frames in pieces, damaged, unknown and signed.

use super::signing::{Signer, Signing, SigningKey, Verifier};
use super::*;
use mavlink::dialects::common::{ATTITUDE_QUATERNION_DATA, HEARTBEAT_DATA};
use mavlink::{MAV_STX, MAV_STX_V2, Message as _};
use proptest::prelude::*;

fn two() -> Vec<u8> {
    two_by(Encoder::new(7, 1))
}

fn two_by(mut encoder: Encoder) -> Vec<u8> {
    let mut bytes = Vec::new();
    let heartbeat = HEARTBEAT_DATA {
        custom_mode: 0x0006_0000,
        ..HEARTBEAT_DATA::default()
    };
    encoder.write(&MavMessage::HEARTBEAT(heartbeat), &mut bytes);
    let attitude = ATTITUDE_QUATERNION_DATA {
        time_boot_ms: 1,
        q1: 1.0,
        ..ATTITUDE_QUATERNION_DATA::default()
    };
    encoder.write(&MavMessage::ATTITUDE_QUATERNION(attitude), &mut bytes);
    bytes
}

fn all(decoder: &mut Decoder) -> Vec<u32> {
    std::iter::from_fn(|| decoder.next_frame())
        .map(|frame| frame.message.message_id())
        .collect()
}

#[test]
fn prop_frames_come_back_in_any_pieces() {
    let bytes = two();
    for piece in 1..bytes.len() {
        let mut decoder = Decoder::default();
        let mut ids = Vec::new();
        for chunk in bytes.chunks(piece) {
            decoder.push(chunk);
            ids.extend(all(&mut decoder));
        }
        assert_eq!(ids, [0, 31], "pieces of {piece}");
        assert_eq!(decoder.counts.corrupt, 0);
    }
}

#[test]
fn prop_a_flipped_bit_never_becomes_a_message() {
    let bytes = two();
    for bit in 0..bytes.len() * 8 {
        let mut wrong = bytes.clone();
        wrong[bit / 8] ^= 1 << (bit % 8);
        let mut decoder = Decoder::default();
        decoder.push(&wrong);
        // One of the two is hurt; a frame that seems longer may wait for more.
        assert!(all(&mut decoder).len() <= 1, "bit {bit}");
    }
}

#[test]
fn prop_unknown_messages_are_skipped_and_counted() {
    let bytes = two();
    let mut unknown = vec![
        MAV_STX_V2, 3, 0, 0, 0, 1, 1, 0xb8, 0x01, 0x7f, 1, 2, 3, 9, 9,
    ];
    unknown.extend_from_slice(&bytes);
    let mut decoder = Decoder::default();
    decoder.push(&unknown);
    assert_eq!(all(&mut decoder), [0, 31]);
    assert_eq!(decoder.counts.unknown, 1);
}

/// Signing with a key and a start time.
fn signing(key: u8, start: u64) -> Signing {
    Signing {
        key: SigningKey::new([key; 32]),
        link_id: 3,
        start,
    }
}

#[test]
fn prop_signed_frames_are_accepted_once_and_only_with_the_key() {
    let bytes = two_by(Encoder::new(7, 1).signed(Some(Signer::new(signing(1, 1000)))));
    let heard = |signing: Option<Signing>, bytes: &[u8]| {
        let mut decoder = Decoder::new(signing.map(Verifier::new));
        decoder.push(bytes);
        let ids = all(&mut decoder);
        (ids, decoder.counts.unsigned)
    };
    assert_eq!(
        heard(None, &bytes),
        (vec![0, 31], 0),
        "signatures may be ignored"
    );
    assert_eq!(heard(Some(signing(1, 1000)), &bytes), (vec![0, 31], 0));
    assert_eq!(
        heard(Some(signing(2, 1000)), &bytes),
        (vec![], 2),
        "another key"
    );
    assert_eq!(
        heard(Some(signing(1, 1000)), &two()),
        (vec![], 2),
        "no signature"
    );
    let replayed = [bytes.clone(), bytes.clone()].concat();
    assert_eq!(
        heard(Some(signing(1, 1000)), &replayed),
        (vec![0, 31], 2),
        "replayed"
    );
    // More than a minute before our own time.
    assert_eq!(
        heard(Some(signing(1, 6_002_000)), &bytes),
        (vec![], 2),
        "old"
    );
}

#[test]
fn xval_a_signature_is_that_of_pymavlink() {
    // python: m = MAVLink(None, srcSystem=7, srcComponent=1); m.signing.secret_key = bytes(range(32));
    // m.signing.link_id = 3; m.signing.timestamp = 1000; m.signing.sign_outgoing = True;
    // heartbeat_encode(2, 12, 0, 0x60000, 4).pack(m).hex()
    let mut encoder = Encoder::new(7, 1).signed(Some(Signer::new(Signing {
        key: SigningKey::new(std::array::from_fn(|k| k as u8)),
        link_id: 3,
        start: 1000,
    })));
    let heartbeat = HEARTBEAT_DATA {
        custom_mode: 0x0006_0000,
        mavtype: mavlink::dialects::common::MavType::MAV_TYPE_QUADROTOR,
        autopilot: mavlink::dialects::common::MavAutopilot::MAV_AUTOPILOT_PX4,
        system_status: mavlink::dialects::common::MavState::MAV_STATE_ACTIVE,
        base_mode: mavlink::dialects::common::MavModeFlag::empty(),
        mavlink_version: 3,
    };
    let mut bytes = Vec::new();
    encoder.write(&MavMessage::HEARTBEAT(heartbeat), &mut bytes);
    let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        hex,
        "fd09010000070100000000000600020c0004030de003e80300000000c043cb2c7549"
    );
}

#[test]
fn prop_keys_are_digits_or_passphrases() {
    let key = |text: &str| SigningKey::from_text(text);
    let digits = "01".repeat(32);
    assert_eq!(key(&format!(" {digits}\n")), Ok(SigningKey::new([1; 32])));
    let secret = "ad8b12f33394b918e4e9d9e20ec852016fe0aba13c2a949d5e5fb898defdf2b1";
    assert_eq!(key("secret phrase"), key(secret), "SHA-256 of its bytes");
    assert_ne!(key("secret phrase"), key("Secret phrase"));
    assert_eq!(
        format!("{:?}", key("secret phrase").unwrap()),
        "SigningKey(..)"
    );
    for cut in ["", " \n", "abc", " seven77 ", &digits[1..], &digits[..32]] {
        assert!(key(cut).is_err(), "{cut}");
    }
}

proptest! {
    #[test]
    fn prop_any_bytes_are_read_without_panic(chunks in proptest::collection::vec(
        proptest::collection::vec(prop_oneof![Just(MAV_STX), Just(MAV_STX_V2), any::<u8>()], 0..300), 0..6)) {
        let mut decoder = Decoder::default();
        for chunk in &chunks {
            decoder.push(chunk);
            let _ = all(&mut decoder);
        }
        // A frame has at most 280 bytes: more never waits.
        prop_assert!(decoder.waiting() < 280);
    }
}
