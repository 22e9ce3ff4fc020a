//! The border: what comes in is checked, panics stay inside, and errors go to the place that the caller has for them.

use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use hexcast::{Error, Result};

use crate::error::HexcastError;

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

/// The error of a bug.
pub(crate) fn crashed() -> Error {
    Error::new("device-failed", "the driver or hexcast crashed", "choose the backend \"cpu\", and report it")
}

/// Reads a text of the caller's; `what` names it in messages.
///
/// # Errors
/// `job-value` where it is NULL or not UTF-8.
///
/// # Safety
/// `text` is NULL or a text that ends with a zero byte and does not change meanwhile.
pub(crate) unsafe fn text<'a>(text: *const c_char, what: &str) -> Result<&'a str> {
    if text.is_null() {
        return Err(null(what));
    }
    // SAFETY: it is not NULL, and the caller of this function vouches for the rest
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|error| Error::new("job-value", format!("{what} is not UTF-8: {error}"), ""))
}

/// Looks at what is behind a pointer of the caller's.
///
/// # Errors
/// `job-value` where it is NULL.
///
/// # Safety
/// `handle` is NULL or points to a value that nobody changes or frees meanwhile.
pub(crate) unsafe fn behind<'a, T>(handle: *const T, what: &str) -> Result<&'a T> {
    // SAFETY: the caller of this function vouches for it
    unsafe { handle.as_ref() }.ok_or_else(|| null(what))
}

/// Looks at an array of the caller's, which may be NULL where it has no elements.
///
/// # Errors
/// `job-value` where it is NULL but should have elements, is not aligned, or is longer than memory can be.
///
/// # Safety
/// `first` is NULL or points to `n` elements that nobody changes or frees meanwhile.
pub(crate) unsafe fn array<'a, T>(first: *const T, n: usize, what: &str) -> Result<&'a [T]> {
    if n == 0 {
        return Ok(&[]);
    }
    check(first, n, what)?;
    // SAFETY: it is not NULL, is aligned and not longer than memory, and the caller of this function vouches for the rest
    Ok(unsafe { std::slice::from_raw_parts(first, n) })
}

/// Makes an array of the caller's zero, to write to it; see [`array`]. Its memory may be fresh.
///
/// # Errors
/// Those of [`array`].
///
/// # Safety
/// `first` is NULL or points to room for `n` elements that nobody else reads, changes or frees meanwhile.
pub(crate) unsafe fn array_mut<'a, T: Number>(first: *mut T, n: usize, what: &str) -> Result<&'a mut [T]> {
    if n == 0 {
        return Ok(&mut []);
    }
    check(first, n, what)?;
    // SAFETY: there is room for them and nobody else uses it, for which the caller of this function vouches; it is aligned
    unsafe { first.write_bytes(0, n) };
    // SAFETY: as for `array`; all of it has values now, as zero bytes are a number
    Ok(unsafe { std::slice::from_raw_parts_mut(first, n) })
}

/// A type of which zero bytes are a value.
pub(crate) trait Number {}
impl Number for u8 {}
impl Number for u32 {}
impl Number for f64 {}

fn check<T>(first: *const T, n: usize, what: &str) -> Result<()> {
    if first.is_null() {
        return Err(null(what));
    }
    if !first.is_aligned() {
        let message = format!("{what} is at {first:p}, which is not a multiple of {} bytes", align_of::<T>());
        return Err(Error::new("job-value", message, "hand over an array of the type of the function"));
    }
    if n > isize::MAX as usize / size_of::<T>() {
        return Err(Error::new("job-value", format!("{what} has {n} elements, which no memory holds"), ""));
    }
    Ok(())
}

fn null(what: &str) -> Error {
    Error::new("job-value", format!("{what} is NULL"), "")
}

/// A text for the caller. One of ours has no zero byte; names of files in messages cannot have one.
pub(crate) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;
    use std::ptr;

    use super::*;
    use crate::error::{hexcast_error_code, hexcast_error_free};

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

    #[test]
    fn an_array_that_is_not_aligned_is_an_error() {
        let numbers = [0u32; 3];
        let odd = numbers.as_ptr().wrapping_byte_add(1);
        // SAFETY: it is not looked at
        let error = unsafe { array(odd, 2, "lines") }.unwrap_err();
        assert!(error.to_string().contains("not a multiple of 4 bytes"), "{error}");
    }
}
