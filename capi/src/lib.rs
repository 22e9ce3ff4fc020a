//! What C, C++ and Fortran call; `include/hexcast.h` is made of these functions.
//!
//! Jobs and reports cross as JSON, flags into memory of the caller's. No panic crosses: [`error::call`] makes an error of it. Every
//! handle is a box whose pointer the caller holds; a mesher is behind a lock, so that threads may share it.

mod border;
mod error;
mod mesh;
mod mesher;

use std::ffi::c_char;

/// The version of hexcast, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn hexcast_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
