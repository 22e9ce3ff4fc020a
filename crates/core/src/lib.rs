//! The core of hexcast, from the bytes of surfaces to columns of cells. Callers use the crate `hexcast`, which passes on what
//! they may rely on.

// what is public names stages that errors come from
#![allow(rustdoc::private_intra_doc_links)]

// The groups, each on those before it. They are open to the other crates of hexcast, and change without notice.

#[doc(hidden)]
pub mod base {
    pub mod checksum;
    pub mod control;
    pub mod finding;
    pub mod length;
    pub mod memory;
    pub mod network;
    pub mod parallel;
    pub mod set;
    pub mod sort;
    pub mod zlib;
    pub use hexcast_job::base::error;
}
#[doc(hidden)]
pub mod input {
    pub mod edges;
    pub mod geometry;
    pub mod preview;
    pub mod read;
    pub mod sources;
    pub mod surface;
    pub use hexcast_job::input::job;
}
#[doc(hidden)]
pub mod grid {
    pub mod closed;
    pub mod domain;
    pub mod frame;
    pub mod lines;
    pub mod rays;
    pub mod totals;
    pub mod volume_bound;
    pub mod window;
}
#[doc(hidden)]
pub mod cells {
    pub mod columns;
    pub mod fingerprint;
    pub mod flags;
    pub mod volumes;
}
#[doc(hidden)]
pub mod stages {
    pub mod axis_crossings;
    pub mod cast;
    pub mod cpu;
    pub mod crossings;
    pub mod expected_crossings;
    pub mod facet;
    pub mod inside;
    pub mod kept;
    pub mod lattice;
    pub mod map;
    pub mod pillars;
    pub mod slots;
    pub mod snapping;
}
#[doc(hidden)]
pub mod open_surfaces {
    pub mod doubt;
    pub mod open;
    pub mod overlay;
    pub mod points;
    pub mod sheet;
}
/// What tests of several crates use.
#[cfg(any(test, feature = "testing"))]
#[doc(hidden)]
pub mod testing;

pub use base::control::{self, Control};
pub use base::error::{self, Error, Result};
pub use base::{finding, length, memory};
pub use cells::columns;
pub use grid::lines;
pub use input::job::{self, GeometryJob, Job};
pub use input::sources::{self, Source};
pub use input::{geometry, read, surface};
