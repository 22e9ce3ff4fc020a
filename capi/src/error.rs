//! Errors for the caller: they go to the place that it has for them, and panics become some.

use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use hexcast::{Error, Result};

use crate::border::{c_text, free};

/// What went wrong. Freed by hexcast_error_free.
pub struct HexcastError {
    code: CString,
    message: CString,
    hint: CString,
}

impl HexcastError {
    pub(crate) fn new(error: &Error) -> HexcastError {
        HexcastError { code: c_text(error.code()), message: c_text(&error.to_string()), hint: c_text(error.hint()) }
    }
}

/// Does something, and puts its error, if there is one, at `error`, unless that is NULL. Returns None for an error.
///
/// # Safety
/// `error` is NULL or a place for a pointer that the caller owns.
pub(crate) unsafe fn call<T>(error: *mut *mut HexcastError, act: impl FnOnce() -> Result<T>) -> Option<T> {
    // what `act` leaves half done is behind a lock that is poisoned then, or is memory of flags, for which any bytes will do
    let result = catch_unwind(AssertUnwindSafe(act)).unwrap_or_else(|_| Err(crashed()));
    result
        .map_err(|problem| {
            if !error.is_null() {
                // SAFETY: it is not NULL, and the caller of this function vouches for the rest
                unsafe { error.write(Box::into_raw(Box::new(HexcastError::new(&problem)))) };
            }
        })
        .ok()
}

/// What all functions that return a number return.
pub(crate) fn status(done: Option<()>) -> i32 {
    if done.is_some() { 0 } else { 1 }
}

/// The error of a bug.
pub(crate) fn crashed() -> Error {
    Error::new("device-failed", "the driver or hexcast crashed", "choose the backend \"cpu\", and report it")
}

/// The stable code of an error, such as "stl-truncated"; NULL for NULL. Lives as long as the error.
///
/// # Safety
/// `error` is NULL or an error that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_error_code(error: *const HexcastError) -> *const c_char {
    // SAFETY: it is NULL or alive, for which the caller vouches
    unsafe { error.as_ref() }.map_or(ptr::null(), |error| error.code.as_ptr())
}

/// A sentence that says what went wrong, with the numbers; NULL for NULL. Lives as long as the error.
///
/// # Safety
/// `error` is NULL or an error that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_error_message(error: *const HexcastError) -> *const c_char {
    // SAFETY: it is NULL or alive, for which the caller vouches
    unsafe { error.as_ref() }.map_or(ptr::null(), |error| error.message.as_ptr())
}

/// What to do about an error; may be empty. NULL for NULL. Lives as long as the error.
///
/// # Safety
/// `error` is NULL or an error that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_error_hint(error: *const HexcastError) -> *const c_char {
    // SAFETY: it is NULL or alive, for which the caller vouches
    unsafe { error.as_ref() }.map_or(ptr::null(), |error| error.hint.as_ptr())
}

/// Frees an error.
///
/// # Safety
/// `error` is NULL or an error that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_error_free(error: *mut HexcastError) {
    // SAFETY: `call` made it with `Box::into_raw`, and the caller vouches for the rest
    unsafe { free(error) };
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::*;

    #[test]
    fn a_panic_becomes_an_error() {
        let mut error = ptr::null_mut();
        // SAFETY: it is a place for a pointer
        let done: Option<()> = unsafe { call(&mut error, || panic!("a bug")) };
        assert!(done.is_none() && !error.is_null());
        // SAFETY: `call` made it, and it is freed once
        unsafe {
            assert_eq!(CStr::from_ptr(hexcast_error_code(error)), c"device-failed");
            hexcast_error_free(error);
        }
    }
}
