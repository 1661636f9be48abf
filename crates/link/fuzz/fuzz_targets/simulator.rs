//! Any bytes in any pieces from an autopilot's side of the simulator give motor signals in [0, 1], and end every wait.
#![no_main]

use std::cell::Cell;
use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use mavlink::dialects::common::{HIL_ACTUATOR_CONTROLS_DATA, MavMessage};
use touchdown_flight::{Attitude, Vector};
use touchdown_link::simulator::ardupilot::ServoFrame;
use touchdown_link::simulator::px4::{MOST_READS, PatientStream, Px4, Px4Codec};
use touchdown_link::simulator::{Motors, SensorReport, StateReport};
use touchdown_link::wire::Encoder;

/// A PX4 whose bytes are given; it is silent once they are used up.
struct Peer<'a> {
    pieces: std::slice::Chunks<'a, u8>,
    reads: &'a Cell<u32>,
}

impl Read for Peer<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.reads.set(self.reads.get() + 1);
        let piece = self.pieces.next().ok_or(ErrorKind::WouldBlock)?;
        buffer[..piece.len()].copy_from_slice(piece);
        Ok(piece.len())
    }
}

impl Write for Peer<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl PatientStream for Peer<'_> {
    fn set_patience(&mut self, _: Duration) -> std::io::Result<()> {
        Ok(())
    }
}

fn state() -> StateReport {
    StateReport {
        position_m: Vector::ZERO,
        velocity_mps: Vector::ZERO,
        acceleration_mps2: Vector::ZERO,
        attitude: Attitude::LEVEL,
        rates: Vector::ZERO,
    }
}

fn in_range(motors: Motors) {
    assert!(motors.0.iter().all(|signal| (0.0..=1.0).contains(signal)));
}

/// Bytes as they are, or an answer with these signals among them, so that the fuzzer need not find checksums.
fn with_answer(bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    let mut words = bytes.chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]);
    let mut controls = [0.0; 16];
    for control in &mut controls {
        *control = words.next().map_or(0.0, f32::from_le_bytes);
    }
    let message = MavMessage::HIL_ACTUATOR_CONTROLS(HIL_ACTUATOR_CONTROLS_DATA {
        time_usec: bytes.iter().map(|b| u64::from(*b) << 16).sum(),
        controls,
        ..HIL_ACTUATOR_CONTROLS_DATA::default()
    });
    Encoder::new(1, 1).write(&message, &mut out);
    out
}

fuzz_target!(|bytes: &[u8]| {
    let Some(([kind, piece], bytes)) = bytes.split_first_chunk::<2>() else {
        return;
    };
    if kind % 2 == 1 {
        if let Some(frame) = ServoFrame::read(bytes) {
            in_range(frame.motors());
        }
        // A datagram of the right length, whatever its content.
        let mut datagram = [18_458_u16, 29_569][usize::from(kind / 2 % 2)]
            .to_le_bytes()
            .to_vec();
        datagram.extend_from_slice(bytes);
        datagram.resize([40, 72][usize::from(kind / 2 % 2)], 0);
        in_range(
            ServoFrame::read(&datagram)
                .expect("its length is right")
                .motors(),
        );
        return;
    }
    let stream = if kind % 4 == 2 {
        with_answer(bytes)
    } else {
        bytes.to_vec()
    };
    let mut codec = Px4Codec::default();
    for piece in stream.chunks(usize::from(*piece) + 1) {
        codec.push(piece);
        while let Some(answer) = codec.answer() {
            in_range(answer.motors);
        }
    }
    let reads = Cell::new(0);
    let peer = Peer {
        pieces: stream.chunks(usize::from(*piece) + 1),
        reads: &reads,
    };
    let mut px4 = Px4::new(peer);
    let sensors = SensorReport {
        time_us: 4_000,
        ..SensorReport::default()
    };
    for _ in 0..4 {
        let Ok(motors) = px4.exchange(&sensors, &state()) else {
            break;
        };
        in_range(motors);
    }
    assert!(reads.get() <= 4 * MOST_READS);
});
