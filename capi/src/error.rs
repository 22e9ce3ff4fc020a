//! Errors for the caller.

use std::ffi::{CString, c_char};
use std::ptr;

use hexcast::Error;

use crate::border::c_text;

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
    if !error.is_null() {
        // SAFETY: `call` made it with `Box::into_raw`, and it was not freed, for which the caller vouches
        drop(unsafe { Box::from_raw(error) });
    }
}
