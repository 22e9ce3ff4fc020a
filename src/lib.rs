//! hexcast: exact Cartesian meshing of closed surfaces by parallel ray casting.

pub mod error;
pub mod geometry;
pub mod lines;
pub mod read;
pub mod surface;

pub use error::{Error, Result};
