//! The border: pointers of the caller's are checked, and handles of ours are freed.

use std::ffi::{CStr, CString, c_char};

use hexcast::{Error, Result};

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
impl Number for u64 {}
impl Number for usize {}
impl Number for f64 {}
impl<T> Number for *const T {}

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

/// Frees what is behind a handle, if it is not NULL.
///
/// # Safety
/// `handle` is NULL, or of `Box::into_raw`, was not freed, and no thread uses it.
pub(crate) unsafe fn free<T>(handle: *mut T) {
    if !handle.is_null() {
        // SAFETY: it is not NULL, and the caller of this function vouches for the rest
        drop(unsafe { Box::from_raw(handle) });
    }
}

/// A text for the caller. One of ours has no zero byte; names of files in messages cannot have one.
pub(crate) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_that_is_not_aligned_is_an_error() {
        let numbers = [0u32; 3];
        let odd = numbers.as_ptr().wrapping_byte_add(1);
        // SAFETY: it is not looked at
        let error = unsafe { array(odd, 2, "lines") }.unwrap_err();
        assert!(error.to_string().contains("not a multiple of 4 bytes"), "{error}");
    }
}
