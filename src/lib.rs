//! hexcast: exact Cartesian meshing of closed surfaces by parallel ray casting.

pub mod error;
pub mod geometry;
pub mod lines;

pub use error::{Error, Result};
