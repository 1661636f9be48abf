//! Error codes, their texts, and the setting that is refused.

use core::ffi::{CStr, c_char};

use crate::numbers::numbered;

/// What a function returns. Beyond `TD_ERROR_NONE` and `TD_ERROR_SENSOR_NOT_FINITE` nothing was
/// written but the refused setting.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum td_error {
    /// No error.
    None = 0,
    /// A value of the sensors is not finite. The step was made without it; its output holds.
    SensorNotFinite = 1,
    /// A pointer is null.
    NullPointer = 2,
    /// A pointer is not aligned for its type.
    Misaligned = 3,
    /// The memory is smaller than the size that is required.
    TooSmall = 4,
    /// The memory behind a handle has not been initialised.
    NotInitialized = 5,
    /// A setting is not usable; `td_setting` has its field and what is expected there.
    Setting = 6,
    /// The time step is not a finite number above 0.
    TimeStep = 7,
    /// A number is none of its enumeration's constants. In settings, `td_setting` has its field.
    UnknownValue = 8,
    /// More than `TD_READINGS_MAX` readings in a step.
    TooManyReadings = 9,
    /// The simulator refuses the scenario.
    World = 10,
    /// The function that flies in the simulator returned an error.
    Pilot = 11,
}

/// Size of the name of a setting, with its final zero.
pub const TD_SETTING_NAME_SIZE: usize = 64;
/// Size of `expected` of a setting, with its final zero.
pub const TD_SETTING_EXPECTED_SIZE: usize = 96;

/// The first setting that is not usable; both texts are empty without such an error.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_setting {
    /// Its field, such as `vehicle.mass_kg`, or the argument of the function. Ends with a zero.
    pub name: [c_char; TD_SETTING_NAME_SIZE],
    /// What is expected there. Ends with a zero.
    pub expected: [c_char; TD_SETTING_EXPECTED_SIZE],
    /// The number that was found there, or follows from it.
    pub found: f64,
}

/// The texts one behind the other, cut to fit, with a final zero.
pub(crate) fn text_of<const N: usize>(parts: [&str; 2]) -> [c_char; N] {
    let mut out = [0; N];
    let bytes = parts.iter().flat_map(|part| part.bytes());
    for (to, from) in out.iter_mut().take(N - 1).zip(bytes) {
        // The same byte, whether `char` of C has a sign or not.
        *to = from as c_char;
    }
    out
}

impl From<Result<(), td_error>> for td_error {
    fn from(result: Result<(), td_error>) -> Self {
        result.err().unwrap_or(Self::None)
    }
}

/// The text of an error code, also of an unknown one. Never null; it is static.
#[unsafe(no_mangle)]
pub extern "C" fn td_error_text(code: u32) -> *const c_char {
    text(code).as_ptr()
}

fn text(code: u32) -> &'static CStr {
    let Ok(error) = td_error::of(code) else {
        return c"unknown error code";
    };
    match error {
        td_error::None => c"no error",
        td_error::SensorNotFinite => {
            c"a value of the sensors is not finite; the step was made without it"
        }
        td_error::NullPointer => c"a pointer is null",
        td_error::Misaligned => c"a pointer is not aligned for its type",
        td_error::TooSmall => c"the memory is smaller than the size that is required",
        td_error::NotInitialized => c"the memory has not been initialised",
        td_error::Setting => {
            c"a setting is not usable; td_setting has its field and what is expected"
        }
        td_error::TimeStep => c"the time step is not a finite number above 0",
        td_error::UnknownValue => c"a number is none of its enumeration's constants",
        td_error::TooManyReadings => c"more readings than TD_READINGS_MAX",
        td_error::World => c"the simulator refuses the scenario",
        td_error::Pilot => c"the function that flies in the simulator returned an error",
    }
}

numbered!(td_error: None, SensorNotFinite, NullPointer, Misaligned, TooSmall, NotInitialized, Setting, TimeStep,
    UnknownValue, TooManyReadings, World, Pilot);
