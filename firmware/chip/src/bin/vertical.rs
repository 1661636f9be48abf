//! The vertical controller with lag and deck filter, and nothing else: its flash and RAM.
//!
//! A timer would call the step at 100 Hz; measurement and throttle are memory-mapped words
//! of a stub.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use core::ptr::{read_volatile, write_volatile};

use cortex_m_rt::entry;
use touchdown_flight::{Measurement, Method};
use touchdown_replay::{VerticalRecording, vertical_step};

/// Where the stub's sensors and rotors are: unused RAM at the end of the boards' memory.
const SENSORS: *const f32 = 0x203f_f000 as *const f32;
const THROTTLE: *mut f32 = 0x203f_f010 as *mut f32;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}

/// Reads the stub's sensors.
fn measure() -> Measurement<f32> {
    // SAFETY: four words of RAM that nothing else uses.
    let read = |i| unsafe { read_volatile(SENSORS.add(i)) };
    Measurement {
        height_m: read(0),
        relative_velocity_mps: read(1),
        vehicle_velocity_mps: read(2),
        acceleration_mps2: read(3),
    }
}

#[entry]
fn main() -> ! {
    let recording = VerticalRecording {
        method: Method::Dynamic,
        deck_angular_frequency: Some(core::f32::consts::PI),
        start_height_m: 0.8,
    };
    let Some(controller) = recording.controller() else {
        loop {}
    };
    let mut state = controller.initial(&measure(), 0.5);
    loop {
        let command = vertical_step(&controller, &mut state, &measure(), 0.01);
        // SAFETY: a word of RAM that nothing else uses.
        unsafe { write_volatile(THROTTLE, command.throttle) };
    }
}
