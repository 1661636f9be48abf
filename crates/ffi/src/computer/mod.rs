//! The landing computer.

mod output;
mod sensed;
mod settings;

pub use output::{td_computer_output, td_phase, td_reason};
pub use sensed::{
    td_barometer, td_beacon, td_gnss, td_range, td_reading, td_reading_data, td_reading_kind,
    td_request, td_sensed, td_tag,
};
pub use settings::{td_computer_settings, td_computer_settings_default, td_sensors};

use core::ffi::c_void;
use core::mem::{align_of, size_of};
use core::ptr::addr_of_mut;

use touchdown_flight::error::finite;
use touchdown_flight::ground_effect::{GroundEffectState, GuardedState};
use touchdown_lander::computer::{Computer, ComputerState};
use touchdown_lander::estimate::relative::{RangeReading, Reading};

use crate::error::{td_error, td_setting};
use crate::memory::{Placed, check, check_optional, fits, live, place, read, write};
use crate::refusal::Refusal;

/// Size of the memory of a `td_computer` on every target, bytes; `td_computer_size` returns that
/// of this one, which is less.
pub const TD_COMPUTER_SIZE: usize = 24576;
/// Alignment of that memory, bytes.
pub const TD_COMPUTER_ALIGN: usize = 8;

const _: () = fits::<td_computer>(TD_COMPUTER_SIZE, TD_COMPUTER_ALIGN);

/// Most readings of a step. 100 Hz and sensors of at most 50 Hz bring a handful, also after a gap.
pub const TD_READINGS_MAX: usize = 16;

/// A landing computer and its state, in the caller's memory.
pub struct td_computer {
    mark: u32,
    computer: Computer<f32>,
    state: ComputerState<f32, GuardedState<f32, GroundEffectState<f32>>>,
    /// The readings of a step: here, so that the stack does not hold them.
    readings: [Reading<f32>; TD_READINGS_MAX],
}

impl Placed for td_computer {
    const MARK: u32 = u32::from_be_bytes(*b"tdC1");

    fn mark(place: *mut Self) -> *mut u32 {
        // SAFETY: an address within the same memory; nothing is read.
        unsafe { addr_of_mut!((*place).mark) }
    }
}

/// Size of a `td_computer` on this target, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn td_computer_size() -> usize {
    size_of::<td_computer>()
}

/// Alignment of a `td_computer` on this target, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn td_computer_align() -> usize {
    align_of::<td_computer>()
}

/// Makes a landing computer in `memory` of `size` bytes, and its handle, in the air. `throttle`
/// is what is being sent. `setting` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_computer_init(
    memory: *mut c_void,
    size: usize,
    settings: *const td_computer_settings,
    throttle: f32,
    computer: *mut *mut td_computer,
    setting: *mut td_setting,
) -> td_error {
    let init = || -> Result<(), Refusal> {
        let place = place::<td_computer>(memory, size)?;
        check(computer)?;
        check_optional(setting)?;
        // SAFETY: as the crate's documentation requires of every pointer.
        let settings = unsafe { read(settings) }?;
        finite("throttle", throttle)?;
        let flies = settings.computer()?;
        // SAFETY: `place` was checked, and is the caller's memory of that size. The mark comes last.
        unsafe {
            addr_of_mut!((*place).readings)
                .write([Reading::Range(RangeReading::level(0.0, 0.0)); TD_READINGS_MAX]);
            addr_of_mut!((*place).state).write(flies.initial(throttle));
            addr_of_mut!((*place).computer).write(flies);
            td_computer::mark(place).write(td_computer::MARK);
            write(computer, place)?;
        }
        Ok(())
    };
    // SAFETY: as the crate's documentation requires of every pointer.
    unsafe { Refusal::report(init(), setting) }
}

/// One step, `dt_s` seconds after the last: readings in, thrust and attitude out.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_computer_step(
    computer: *mut td_computer,
    sensed: *const td_sensed,
    dt_s: f32,
    output: *mut td_computer_output,
) -> td_error {
    let step = || -> Result<(), td_error> {
        check(output)?;
        if !(dt_s > 0.0 && dt_s.is_finite()) {
            return Err(td_error::TimeStep);
        }
        // SAFETY: as the crate's documentation requires of every pointer.
        let (computer, sensed) = unsafe { (live(computer)?, read(sensed)?) };
        // SAFETY: as the crate's documentation requires of every pointer.
        let finite = unsafe { sensed.readings(&mut computer.readings) }? && sensed.is_finite();
        let readings = computer
            .readings
            .get(..sensed.readings_count)
            .unwrap_or_default();
        let found = computer
            .computer
            .step(&mut computer.state, &sensed.sensed(readings)?, dt_s);
        // SAFETY: as the crate's documentation requires of every pointer.
        unsafe { write(output, td_computer_output::new(&found)) }?;
        if finite {
            Ok(())
        } else {
            Err(td_error::SensorNotFinite)
        }
    };
    step().into()
}

/// Starts the landing again with the present estimates. Called before every step, it keeps the
/// integrals at zero while somebody else flies.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_computer_restart(computer: *mut td_computer) -> td_error {
    // SAFETY: as the crate's documentation requires of every pointer.
    let restart = unsafe { live(computer) }
        .map(|computer| computer.computer.restart_landing(&mut computer.state));
    restart.into()
}
