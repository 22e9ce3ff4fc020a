//! What is cast: the snapped facets, the rays through the box, and what counts as inside. The input of lattice, intersection and
//! mapping on both backends.

use crate::grid::frame::Frame;
use crate::grid::rays::Rays;
use crate::input::job::Rule;

pub mod sizes;

pub use sizes::{BIN, MAX_TILES, SEGMENT};

/// What is meshed: the input of the lattice, intersection and mapping.
#[derive(Debug, Clone, Copy)]
pub struct Cast<'a> {
    /// Snapped facets.
    pub frame: &'a Frame,
    /// The rays through the box.
    pub rays: &'a Rays,
    /// What is inside.
    pub rule: Rule,
}
