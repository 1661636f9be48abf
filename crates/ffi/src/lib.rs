//! C interface of the vertical controller and of the landing computer, in single precision.
//!
//! The header is `include/touchdown.h`; `examples/` holds programs in C and C++ that land in
//! the simulator. `no_std`, no allocation: the caller gives the memory.
//!
//! | module | what it holds |
//! | --- | --- |
//! | `error` | error codes and their texts |
//! | `memory` | checks of the caller's pointers; all reads and writes through them |
//! | `numbers` | constants of enumerations by their numbers |
//! | `refusal` | why an initialisation failed |
//! | `fields` | fields of C's structs by the keys of errors in Rust |
//! | `vehicle` | vehicle and method as the caller states them |
//! | `models` | models of thrust and ground effect as the caller states them |
//! | `vertical` | the vertical controller |
//! | `computer` | the landing computer |
//! | `world` | the simulator, on a computer only (feature `world`) |
//!
//! # Errors and panics
//!
//! A function that can fail returns a [`td_error`]. A null or misaligned pointer, too little
//! memory, an unknown constant, an unusable setting or time step is an error; nothing is
//! written then. Readings that are not finite are a state of the sensors and not an error of
//! the program: the step returns [`td_error::SensorNotFinite`] with a command.
//!
//! No call is meant to panic. If one does, the program does not continue with a broken
//! controller: on a computer the process aborts, because a panic cannot leave an `extern "C"`
//! function; on a chip the panic handler of this crate loops until the watchdog resets it.
//!
//! # Unsafe code
//!
//! C hands over addresses, which Rust cannot check. So this crate alone of those that fly may
//! use `unsafe`. What a function requires of its pointers is said once, here: each points to
//! memory of its type, of the stated number of elements, that nothing else uses during the call.
#![no_std]
#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]
// Types have the names that C sees.
#![allow(non_camel_case_types)]
// Stated once, above, for all functions.
#![allow(clippy::missing_safety_doc)]

// Supplies the panic handler where there is an operating system.
#[cfg(not(target_os = "none"))]
extern crate std;

mod computer;
mod error;
mod fields;
mod memory;
mod models;
mod numbers;
mod refusal;
mod vehicle;
mod vertical;
#[cfg(feature = "world")]
mod world;

pub use computer::{
    TD_COMPUTER_ALIGN, TD_COMPUTER_SIZE, TD_READINGS_MAX, td_barometer, td_beacon, td_computer,
    td_computer_align, td_computer_init, td_computer_output, td_computer_restart,
    td_computer_settings, td_computer_settings_default, td_computer_size, td_computer_step,
    td_gnss, td_phase, td_range, td_reading, td_reading_data, td_reading_kind, td_reason,
    td_request, td_sensed, td_sensors, td_tag,
};
pub use error::{
    TD_SETTING_EXPECTED_SIZE, TD_SETTING_NAME_SIZE, td_error, td_error_text, td_setting,
};
pub use models::{
    td_ground_effect, td_ground_effect_form, td_hover_throttle, td_models, td_models_default,
    td_models_paper, td_outside, td_thrust_form, td_thrust_model, td_velocity_input,
};
pub use vehicle::{td_method, td_vehicle};
pub use vertical::{
    TD_VERTICAL_ALIGN, TD_VERTICAL_SIZE, td_command, td_measurement, td_vertical,
    td_vertical_align, td_vertical_init, td_vertical_settings, td_vertical_settings_default,
    td_vertical_size, td_vertical_step,
};
#[cfg(feature = "world")]
pub use world::{
    td_landing, td_outcome, td_space_pilot, td_vertical_pilot, td_vertical_world, td_world,
    td_world_free, td_world_land, td_world_land_vertical, td_world_new, td_world_start_height_m,
    td_world_start_throttle,
};

/// Loops: a watchdog then resets the chip. Continuing would fly with a broken controller.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
