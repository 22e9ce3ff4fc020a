//! What C, C++ and Fortran call; `include/hexcast.h` is made of these functions.
//!
//! Jobs and reports cross as JSON, flags into memory of the caller's. No panic crosses: [`error::call`] makes an error of it. Every
//! handle is a box whose pointer the caller holds; a mesher is behind a lock, so that threads may share it.

mod border;
mod error;
mod facets;
mod file;
mod mesh;
mod mesher;
mod runs;
mod scene;

use std::ffi::c_char;

/// The version of the library, such as "0.1.0"; HEXCAST_VERSION_STRING is that of the header. Before 1.0 both must have the same major and
/// minor version. Lives as long as the program, and must not be freed.
#[unsafe(no_mangle)]
pub extern "C" fn hexcast_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
