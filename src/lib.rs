#![doc = include_str!("../docs/rust.md")]
// with that feature the stages are public, and have callers
#![cfg_attr(not(feature = "stages"), allow(dead_code, unreachable_pub, unused_imports))]
// what is public names stages that errors come from
#![allow(rustdoc::private_intra_doc_links)]

mod axis_crossings;
#[cfg(not(feature = "stages"))]
mod cast;
#[cfg(feature = "stages")]
pub mod cast;
#[cfg(not(feature = "stages"))]
mod certificate;
#[cfg(feature = "stages")]
pub mod certificate;
mod checksum;
#[cfg(not(feature = "stages"))]
mod closed;
#[cfg(feature = "stages")]
pub mod closed;
#[cfg(any(feature = "pictures", feature = "export"))]
mod colours;
pub mod columns;
pub mod control;
pub mod converge;
#[cfg(not(feature = "stages"))]
mod cpu;
#[cfg(feature = "stages")]
pub mod cpu;
#[cfg(not(feature = "stages"))]
mod crossings;
#[cfg(feature = "stages")]
pub mod crossings;
pub mod cut;
pub mod difference;
#[cfg(not(feature = "stages"))]
mod domain;
#[cfg(feature = "stages")]
pub mod domain;
#[cfg(not(feature = "stages"))]
mod doubt;
#[cfg(feature = "stages")]
pub mod doubt;
#[cfg(not(feature = "stages"))]
mod edges;
#[cfg(feature = "stages")]
pub mod edges;
pub mod error;
pub mod estimate;
#[cfg(feature = "export")]
pub mod export;
#[cfg(not(feature = "stages"))]
mod facet;
#[cfg(feature = "stages")]
pub mod facet;
#[cfg(not(target_arch = "wasm32"))]
pub mod files;
pub mod finding;
mod fingerprint;
#[cfg(not(feature = "stages"))]
mod flags;
#[cfg(feature = "stages")]
pub mod flags;
pub mod fractions;
#[cfg(not(feature = "stages"))]
mod frame;
#[cfg(feature = "stages")]
pub mod frame;
pub mod gaps;
pub mod geometry;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(not(feature = "stages"))]
mod inside;
#[cfg(feature = "stages")]
pub mod inside;
pub mod job;
#[cfg(not(feature = "stages"))]
mod lattice;
#[cfg(feature = "stages")]
pub mod lattice;
pub mod leak;
pub mod length;
pub mod lines;
pub mod links;
#[cfg(not(target_arch = "wasm32"))]
pub mod machine;
#[cfg(not(feature = "stages"))]
mod map;
#[cfg(feature = "stages")]
pub mod map;
pub mod measured;
pub mod memory;
pub mod mesh;
#[cfg(not(target_arch = "wasm32"))]
pub mod mesher;
#[cfg(not(feature = "stages"))]
mod open;
#[cfg(feature = "stages")]
pub mod open;
#[cfg(not(feature = "stages"))]
mod overlay;
#[cfg(feature = "stages")]
pub mod overlay;
mod parallel;
pub mod parts;
#[cfg(feature = "pictures")]
pub mod picture;
pub mod pipeline;
#[cfg(not(feature = "stages"))]
mod preview;
#[cfg(feature = "stages")]
pub mod preview;
#[cfg(not(feature = "stages"))]
mod rays;
#[cfg(feature = "stages")]
pub mod rays;
pub mod read;
pub mod report;
pub mod shards;
mod sheet;
mod shells;
pub mod skin;
mod snapping;
mod sort;
pub mod sources;
pub mod staggered;
pub mod surface;
mod totals;
#[cfg(not(feature = "stages"))]
mod volume_bound;
#[cfg(feature = "stages")]
pub mod volume_bound;
mod volumes;
pub mod walls;
#[cfg(all(feature = "web", target_arch = "wasm32"))]
pub mod web;
#[cfg(not(feature = "stages"))]
mod window;
#[cfg(feature = "stages")]
pub mod window;
pub mod write;
mod zlib;

pub use control::Control;
pub use error::{Error, Result};
pub use job::{GeometryJob, Job};
pub use measured::Measured;
pub use mesh::Mesh;
#[cfg(not(target_arch = "wasm32"))]
pub use mesher::{Mesher, MesherOptions};
pub use sources::Source;
pub use write::column_file;
