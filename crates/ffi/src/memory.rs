//! The caller's memory: checks of its addresses; reads and writes through them.

use core::ffi::c_void;
use core::mem::{align_of, size_of};

use crate::error::td_error;

/// Checks the address of a `T`.
pub(crate) fn check<T>(address: *const T) -> Result<(), td_error> {
    if address.is_null() {
        Err(td_error::NullPointer)
    } else if address.is_aligned() {
        Ok(())
    } else {
        Err(td_error::Misaligned)
    }
}

/// Checks the address of a `T`, if it is not null.
pub(crate) fn check_optional<T>(address: *const T) -> Result<(), td_error> {
    if address.is_null() {
        Ok(())
    } else {
        check(address)
    }
}

/// A copy of what the caller's pointer points to.
///
/// # Safety
/// An address that is neither null nor misaligned points to a `T` that can be read.
pub(crate) unsafe fn read<T: Copy>(from: *const T) -> Result<T, td_error> {
    check(from)?;
    // SAFETY: checked above; the rest is the caller's promise.
    Ok(unsafe { from.read() })
}

/// Writes to the caller's pointer.
///
/// # Safety
/// An address that is neither null nor misaligned points to memory of a `T`.
pub(crate) unsafe fn write<T: Copy>(to: *mut T, value: T) -> Result<(), td_error> {
    check(to)?;
    // SAFETY: checked above; the rest is the caller's promise.
    unsafe { to.write(value) };
    Ok(())
}

/// Checks size and alignment of memory for a `T`.
pub(crate) fn place<T>(memory: *mut c_void, size: usize) -> Result<*mut T, td_error> {
    let place = memory.cast::<T>();
    check(place)?;
    if size < size_of::<T>() {
        return Err(td_error::TooSmall);
    }
    Ok(place)
}

/// What lives in the caller's memory. Its first write is the last of the initialisation: a mark,
/// by which memory that was never initialised is recognised.
pub(crate) trait Placed: Sized {
    /// The mark: letters of the type, which zeroed memory does not hold.
    const MARK: u32;

    /// Where the mark is.
    fn mark(place: *mut Self) -> *mut u32;
}

/// What a handle refers to.
///
/// # Safety
/// An address that is neither null nor misaligned points to memory of the size of a `T` that has
/// been written. If its mark is that of a `T`, it was initialised as one, and nothing else uses
/// it for `'a`.
pub(crate) unsafe fn live<'a, T: Placed>(handle: *mut T) -> Result<&'a mut T, td_error> {
    check(handle)?;
    // SAFETY: checked above; the rest is the caller's promise.
    if unsafe { T::mark(handle).read() } != T::MARK {
        return Err(td_error::NotInitialized);
    }
    // SAFETY: the mark is written last, when all other fields hold values.
    Ok(unsafe { &mut *handle })
}

/// Checks at compile time that a `T` fits in the memory that the header states.
pub(crate) const fn fits<T>(size: usize, align: usize) {
    assert!(size_of::<T>() <= size, "the stated size is too small");
    assert!(
        align_of::<T>() <= align,
        "the stated alignment is too small"
    );
}
