#![doc = include_str!("../docs/rust.md")]
// without the command some stages have fewer callers
#![cfg_attr(not(feature = "cli"), allow(dead_code))]
// what is public names stages that errors come from
#![allow(rustdoc::private_intra_doc_links)]

// The groups, each on those before it. They are open to the tests, benchmarks and the command of hexcast, and change without notice; what
// callers may rely on is passed on below.

#[doc(hidden)]
pub mod base {
    pub mod checksum;
    pub mod control;
    pub mod error;
    pub mod finding;
    pub mod length;
    pub mod memory;
    pub mod parallel;
    pub mod sort;
    pub mod zlib;
}
#[doc(hidden)]
pub mod input {
    pub mod edges;
    pub mod geometry;
    pub mod job;
    pub mod preview;
    pub mod read;
    pub mod sources;
    pub mod surface;
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
    pub mod facet;
    pub mod inside;
    pub mod lattice;
    pub mod map;
    pub mod snapping;
}
#[doc(hidden)]
pub mod open_surfaces {
    pub mod doubt;
    pub mod open;
    pub mod overlay;
    pub mod sheet;
}
#[doc(hidden)]
pub mod derived {
    pub mod certificate;
    pub mod cut;
    pub mod difference;
    pub mod fractions;
    pub mod gaps;
    pub mod leak;
    pub mod links;
    pub mod mesh;
    pub mod shells;
    pub mod skin;
    pub mod staggered;
    pub mod walls;
}
#[doc(hidden)]
pub mod output {
    #[cfg(any(feature = "pictures", feature = "export"))]
    pub mod colours;
    #[cfg(feature = "export")]
    pub mod export;
    pub mod measured;
    #[cfg(feature = "pictures")]
    pub mod picture;
    pub mod report;
    pub mod shards;
    pub mod write;
}
#[cfg(feature = "gpu")]
pub mod gpu;
#[doc(hidden)]
pub mod meshing {
    pub mod converge;
    pub mod estimate;
    #[cfg(not(target_arch = "wasm32"))]
    pub mod files;
    #[cfg(not(target_arch = "wasm32"))]
    pub mod machine;
    #[cfg(not(target_arch = "wasm32"))]
    pub mod mesher;
    pub mod parts;
    pub mod pipeline;
}
#[cfg(all(feature = "web", target_arch = "wasm32"))]
pub mod web;

pub use base::control::{self, Control};
pub use base::error::{self, Error, Result};
pub use base::{finding, length, memory};
pub use cells::columns;
pub use derived::mesh::{self, Mesh};
pub use derived::{cut, difference, fractions, gaps, leak, links, skin, staggered, walls};
pub use grid::lines;
pub use input::job::{self, GeometryJob, Job};
pub use input::sources::{self, Source};
pub use input::{geometry, read, surface};
#[cfg(not(target_arch = "wasm32"))]
pub use meshing::mesher::{self, Mesher, MesherOptions};
pub use meshing::{converge, estimate, parts, pipeline};
#[cfg(not(target_arch = "wasm32"))]
pub use meshing::{files, machine};
#[cfg(feature = "export")]
pub use output::export;
pub use output::measured::{self, Measured};
#[cfg(feature = "pictures")]
pub use output::picture;
pub use output::write::{self, column_file};
pub use output::{report, shards};
