//! The landing computer, and nothing else: its flash and RAM.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use core::ptr::{read_volatile, write_volatile};

use cortex_m_rt::entry;
use touchdown_flight::Attitude;
use touchdown_flight::Vector;
use touchdown_lander::computer::Sensed;
use touchdown_lander::estimate::relative::{ImuSample, RangeReading, Reading};
use touchdown_lander::state_machine::OperatorRequest;
use touchdown_replay::{ComputerRecording, computer_start, computer_step};

/// Where the stub's sensors and rotors are: unused RAM at the end of the boards' memory.
const SENSORS: *const f32 = 0x203f_f000 as *const f32;
const THRUST: *mut f32 = 0x203f_f020 as *mut f32;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}

/// A word of the stub's sensors.
fn word(i: usize) -> f32 {
    // SAFETY: words of RAM that nothing else uses.
    unsafe { read_volatile(SENSORS.add(i)) }
}

#[entry]
fn main() -> ! {
    let recording = ComputerRecording {
        start_height_m: 0.8,
        throttle: 0.5,
    };
    let Some(computer) = recording.computer() else {
        loop {}
    };
    let mut state = computer_start(&computer, recording.throttle);
    loop {
        let readings = [Reading::Range(RangeReading::level(word(7), 0.02))];
        let quaternion = [word(3), word(4), word(5), word(6)];
        let sensed = Sensed {
            imu: ImuSample {
                specific_force_mps2: Vector::new(word(0), word(1), word(2)),
                attitude: Attitude::from_quaternion(quaternion).unwrap_or(Attitude::LEVEL),
            },
            readings: &readings,
            deck_normal: None,
            battery_share: 1.0,
            contact: None,
            request: OperatorRequest::None,
        };
        let output = computer_step(&computer, &mut state, &sensed, 0.01);
        let thrust_n = output.command.map_or(0.0, |command| command.thrust_n);
        // SAFETY: a word of RAM that nothing else uses.
        unsafe { write_volatile(THRUST, thrust_n) };
    }
}
