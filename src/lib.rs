//! hexcast: exact Cartesian meshing of closed surfaces by parallel ray casting.

mod axis_crossings;
pub mod cast;
pub mod certificate;
mod checksum;
pub mod closed;
pub mod columns;
pub mod control;
pub mod cpu;
pub mod crossings;
pub mod domain;
pub mod doubt;
pub mod edges;
pub mod error;
pub mod estimate;
pub mod facet;
mod fingerprint;
pub mod flags;
pub mod frame;
pub mod gaps;
pub mod geometry;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod job;
pub mod lattice;
pub mod leak;
pub mod lines;
pub mod map;
pub mod mesh;
pub mod open;
pub mod overlay;
mod parallel;
pub mod parts;
pub mod pipeline;
pub mod rays;
pub mod read;
pub mod report;
pub mod shards;
mod sheet;
mod shells;
pub mod skin;
pub mod sources;
pub mod surface;
pub mod volume_bound;
#[cfg(all(feature = "web", target_arch = "wasm32"))]
pub mod web;
pub mod write;
mod zlib;

pub use error::{Error, Result};
pub use write::column_file;
