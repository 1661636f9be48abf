//! Calls that a C program may get wrong return an error code and write nothing; right ones fly.

// The calls are those of C.
#![allow(unsafe_code)]

mod cards;
mod refusals;

use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::path::Path;
use std::ptr::{null, null_mut};

use touchdown_ffi::*;

/// Memory for a controller, as a C program gives it.
#[repr(align(8))]
struct Memory([u8; TD_COMPUTER_SIZE + 8]);

fn memory() -> Box<Memory> {
    Box::new(Memory([0; TD_COMPUTER_SIZE + 8]))
}

fn default<T>(fill: unsafe extern "C" fn(*mut T) -> td_error) -> T {
    let mut value = MaybeUninit::uninit();
    // SAFETY: memory of a `T`, which the function fills in.
    unsafe {
        assert_eq!(fill(value.as_mut_ptr()), td_error::None);
        value.assume_init()
    }
}

static START: td_measurement = td_measurement {
    height_m: 0.8,
    relative_velocity_mps: 0.0,
    vehicle_velocity_mps: 0.0,
    acceleration_mps2: 0.0,
};
const COMMAND: td_command = td_command {
    thrust_n: -1.0,
    throttle: -1.0,
    ground_effect_n: -1.0,
};
const SETTING: td_setting = td_setting {
    name: [1; TD_SETTING_NAME_SIZE],
    expected: [1; TD_SETTING_EXPECTED_SIZE],
    found: -1.0,
};

fn name(setting: &td_setting) -> &str {
    // SAFETY: the interface ends the name with a zero.
    unsafe { CStr::from_ptr(setting.name.as_ptr()) }
        .to_str()
        .unwrap()
}

/// Initialises a vertical controller and returns the code, its handle and the setting.
fn vertical(
    memory: &mut Memory,
    settings: &td_vertical_settings,
) -> (td_error, *mut td_vertical, td_setting) {
    let (mut handle, mut setting) = (null_mut(), SETTING);
    // SAFETY: all of them are variables of this frame, or the memory.
    let error = unsafe {
        td_vertical_init(
            memory.0.as_mut_ptr().cast(),
            TD_VERTICAL_SIZE,
            settings,
            &raw const START,
            0.5,
            &raw mut handle,
            &raw mut setting,
        )
    };
    (error, handle, setting)
}

fn computer(
    memory: &mut Memory,
    settings: &td_computer_settings,
) -> (td_error, *mut td_computer, td_setting) {
    let (mut handle, mut setting) = (null_mut(), SETTING);
    // SAFETY: all of them are variables of this frame, or the memory.
    let error = unsafe {
        td_computer_init(
            memory.0.as_mut_ptr().cast(),
            TD_COMPUTER_SIZE,
            settings,
            0.5,
            &raw mut handle,
            &raw mut setting,
        )
    };
    (error, handle, setting)
}

fn sensed(readings: &[td_reading]) -> td_sensed {
    td_sensed {
        specific_force_mps2: [0.0, 0.0, 9.81],
        attitude: [1.0, 0.0, 0.0, 0.0],
        readings: readings.as_ptr(),
        readings_count: readings.len(),
        deck_normal: [0.0; 3],
        deck_normal_age_s: -1.0,
        battery_share: 1.0,
        contact: -1,
        request: td_request::None as u32,
    }
}

fn range(distance_m: f32) -> td_reading {
    td_reading {
        kind: td_reading_kind::Range as u32,
        age_s: 0.02,
        data: td_reading_data {
            range: td_range { distance_m },
        },
    }
}

#[test]
fn analytic_stated_sizes_hold_the_controllers() {
    for (size, stated, align, stated_align) in [
        (
            td_vertical_size(),
            TD_VERTICAL_SIZE,
            td_vertical_align(),
            TD_VERTICAL_ALIGN,
        ),
        (
            td_computer_size(),
            TD_COMPUTER_SIZE,
            td_computer_align(),
            TD_COMPUTER_ALIGN,
        ),
    ] {
        let found = format!("{size} of {stated} bytes, alignment {align} of {stated_align}");
        assert!(size <= stated && align <= stated_align, "{found}");
    }
}

#[test]
fn regress_the_page_on_chips_has_the_size_of_the_computer() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src/how-to/chip.md");
    let page = std::fs::read_to_string(page).unwrap();
    let (thousands, rest) = (TD_COMPUTER_SIZE / 1000, TD_COMPUTER_SIZE % 1000);
    let stated = format!("`TD_COMPUTER_SIZE` is {thousands} {rest:03} bytes");
    assert!(page.contains(&stated), "expected: {stated}");
}

#[test]
fn analytic_every_error_has_a_text_of_its_own() {
    // SAFETY: static texts that end with a zero.
    let text = |code| unsafe { CStr::from_ptr(td_error_text(code)) };
    let mut texts: Vec<_> = (0..=td_error::Pilot as u32 + 1).map(text).collect();
    assert_eq!(text(u32::MAX), *texts.last().unwrap());
    texts.sort_unstable();
    texts.dedup();
    assert_eq!(texts.len(), td_error::Pilot as usize + 2);
}

#[test]
fn analytic_bad_memory_is_refused() {
    let settings = default(td_vertical_settings_default);
    let mut memory = memory();
    let bytes = memory.0.as_mut_ptr();
    let init = |bytes: *mut u8, size, settings, start, handle| {
        // SAFETY: variables of this frame, null, or misaligned: the latter are not touched.
        unsafe { td_vertical_init(bytes.cast(), size, settings, start, 0.5, handle, null_mut()) }
    };
    let mut handle = null_mut();
    let (size, handle) = (TD_VERTICAL_SIZE, &raw mut handle);
    let start = &raw const START;
    let settings = &raw const settings;
    for (found, expected) in [
        (
            init(null_mut(), size, settings, start, handle),
            td_error::NullPointer,
        ),
        (
            init(bytes.wrapping_add(1), size, settings, start, handle),
            td_error::Misaligned,
        ),
        (
            init(bytes, td_vertical_size() - 1, settings, start, handle),
            td_error::TooSmall,
        ),
        (
            init(bytes, size, null(), start, handle),
            td_error::NullPointer,
        ),
        (
            init(bytes, size, settings.wrapping_byte_add(1), start, handle),
            td_error::Misaligned,
        ),
        (
            init(bytes, size, settings, null(), handle),
            td_error::NullPointer,
        ),
        (
            init(bytes, size, settings, start, null_mut()),
            td_error::NullPointer,
        ),
    ] {
        assert_eq!(found, expected);
    }
    assert!(
        memory.0.iter().all(|&byte| byte == 0),
        "nothing was written"
    );
    // The exact size of this target suffices.
    let bytes = memory.0.as_mut_ptr();
    assert_eq!(
        init(bytes, td_vertical_size(), settings, start, handle),
        td_error::None
    );
}

#[test]
fn analytic_vertical_step_refuses_what_is_wrong_and_flies_through_nan() {
    let settings = default(td_vertical_settings_default);
    let mut memory = memory();
    let bytes: *mut td_vertical = memory.0.as_mut_ptr().cast();
    let mut command = COMMAND;
    let mut step = |handle, measurement: *const td_measurement, dt_s| {
        // SAFETY: a handle or null, variables of this test.
        let error = unsafe { td_vertical_step(handle, measurement, dt_s, &raw mut command) };
        (error, std::mem::replace(&mut command, COMMAND))
    };
    let now = &raw const START;
    assert_eq!(
        step(bytes, now, 0.01),
        (td_error::NotInitialized, COMMAND),
        "zeroed memory"
    );
    let (error, handle, setting) = vertical(&mut memory, &settings);
    assert_eq!((error, name(&setting)), (td_error::None, ""));
    assert_eq!(step(null_mut(), now, 0.01).0, td_error::NullPointer);
    assert_eq!(step(handle, null(), 0.01).0, td_error::NullPointer);
    for dt_s in [0.0, -0.01, f32::NAN, f32::INFINITY] {
        assert_eq!(step(handle, now, dt_s), (td_error::TimeStep, COMMAND));
    }
    let (error, flown) = step(handle, now, 0.01);
    assert_eq!(error, td_error::None);
    assert!((0.05..=1.0).contains(&flown.throttle));
    let nan = td_measurement {
        height_m: f32::NAN,
        ..START
    };
    let (error, flown) = step(handle, &raw const nan, 0.01);
    assert_eq!(error, td_error::SensorNotFinite);
    assert!((0.05..=1.0).contains(&flown.throttle) && flown.thrust_n.is_finite());
}

#[test]
fn analytic_computer_step_refuses_what_is_wrong_and_flies_through_nan() {
    let settings = default(td_computer_settings_default);
    let mut memory = memory();
    let (error, handle, _) = computer(&mut memory, &settings);
    assert_eq!(error, td_error::None);
    let step = |sensed: &td_sensed, dt_s| {
        let mut output = td_computer_output::default();
        // SAFETY: a handle, variables of this frame.
        let error = unsafe { td_computer_step(handle, sensed, dt_s, &raw mut output) };
        (error, output)
    };
    let nothing = td_computer_output::default();
    let readings = [range(0.8); TD_READINGS_MAX + 1];
    let mut unknown = range(0.8);
    unknown.kind = 5;
    for (sensed, expected) in [
        (sensed(&readings), td_error::TooManyReadings),
        (sensed(&[unknown]), td_error::UnknownValue),
        (
            td_sensed {
                contact: 2,
                ..sensed(&[])
            },
            td_error::UnknownValue,
        ),
        (
            td_sensed {
                request: 4,
                ..sensed(&[])
            },
            td_error::UnknownValue,
        ),
        (
            td_sensed {
                readings: null(),
                ..sensed(&readings[..1])
            },
            td_error::NullPointer,
        ),
    ] {
        assert_eq!(step(&sensed, 0.01), (expected, nothing));
    }
    assert_eq!(step(&sensed(&[]), f32::NAN), (td_error::TimeStep, nothing));
    let none = td_sensed {
        readings: null(),
        ..sensed(&[])
    };
    let (error, output) = step(&none, 0.01);
    assert_eq!((error, output.rotors), (td_error::None, 1));
    let nan = [range(f32::NAN)];
    for broken in [
        sensed(&nan),
        td_sensed {
            attitude: [0.0, f32::NAN, 0.0, 0.0],
            ..sensed(&readings[..1])
        },
        td_sensed {
            specific_force_mps2: [f32::INFINITY; 3],
            ..sensed(&readings[..1])
        },
    ] {
        let (error, output) = step(&broken, 0.01);
        assert_eq!((error, output.rotors), (td_error::SensorNotFinite, 1));
        assert!(output.thrust_n.is_finite() && output.attitude.iter().all(|x| x.is_finite()));
    }
    // SAFETY: a handle and null.
    unsafe {
        assert_eq!(td_computer_restart(handle), td_error::None);
        assert_eq!(td_computer_restart(null_mut()), td_error::NullPointer);
    }
}

#[test]
fn analytic_handle_of_one_controller_is_not_one_of_the_other() {
    let settings = default(td_vertical_settings_default);
    let mut memory = memory();
    let (error, handle, _) = vertical(&mut memory, &settings);
    assert_eq!(error, td_error::None);
    // SAFETY: the memory is large enough for both.
    let error = unsafe { td_computer_restart(handle.cast()) };
    assert_eq!(error, td_error::NotInitialized);
}

#[test]
fn analytic_hover_throttle_is_that_of_the_model() {
    let settings = default(td_vertical_settings_default);
    let mut throttle = 0.0;
    let hover = |vehicle: &td_vehicle, throttle: &mut f32| {
        // SAFETY: variables of this test.
        unsafe { td_hover_throttle(vehicle, &raw const settings.models, throttle, null_mut()) }
    };
    assert_eq!(hover(&settings.vehicle, &mut throttle), td_error::None);
    let models = touchdown_lander::models::FlightModels::<f32>::default();
    let expected = models.thrust.throttle_for(1.37 * 9.81);
    assert_eq!(throttle.to_bits(), expected.to_bits());
    let weightless = td_vehicle {
        mass_kg: f32::NAN,
        ..settings.vehicle
    };
    assert_eq!(hover(&weightless, &mut throttle), td_error::Setting);
}
