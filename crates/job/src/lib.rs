//! The job of hexcast, the files that it is read from, and errors. Callers use the crate `hexcast`, which passes on what they may rely on.

// The groups, each on those before it. They are open to the other crates of hexcast, and change without notice.

#[doc(hidden)]
pub mod base {
    pub mod error;
}
#[doc(hidden)]
pub mod input {
    pub mod choices;
    pub mod job;
}
/// What tests of several crates use.
#[cfg(any(test, feature = "testing"))]
#[doc(hidden)]
pub mod testing;

pub use base::error::{self, Error, Result};
pub use input::job::{self, GeometryJob, Job};
