//! The report of a geometry whose surface is not closed.

use serde::Serialize;

use crate::geometry::Open;
use crate::open::Found;

/// A geometry whose surface is not closed, and how its cells were decided.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OpenReport {
    /// Its name.
    pub geometry: String,
    /// How its cells were decided.
    pub policy: Open,
    /// Edges that facets use an odd number of times, or for the rule `nonzero` more often one way than the other.
    pub open_edges: u64,
    /// Loops of these edges.
    pub holes: u64,
    /// Middle of the longest of them.
    pub longest_at: [f64; 3],
    /// Facets that were turned to agree with their neighbours.
    pub turned: u64,
    /// Rays along x, y and z that cross it an odd number of times, or for `nonzero` do not leave as often as they enter.
    pub odd_rays: [u64; 3],
    /// Cells whose three rays are not all even, or do not agree.
    pub doubtful_cells: u64,
}

impl OpenReport {
    /// Describes what was found of an open geometry, by its name.
    pub fn new(found: &Found, geometry: String) -> OpenReport {
        OpenReport {
            geometry,
            policy: found.policy,
            open_edges: found.surface.open_edges,
            holes: found.surface.holes,
            longest_at: found.surface.longest_at,
            turned: found.surface.turned,
            odd_rays: found.odd_rays,
            doubtful_cells: found.doubtful_cells,
        }
    }

    /// Says it in a sentence, of a mesh of `n_cells`.
    pub fn warning(&self, n_cells: u64) -> String {
        let decided = match self.policy {
            Open::Vote => "by most of their even rays",
            _ => "by the winding number",
        };
        let ([x, y, z], [of_x, of_y, of_z]) = (self.longest_at, self.odd_rays);
        format!(
            "geometry \"{}\" is not closed: open edges {}, in {} loops, the longest edge at ({x}, {y}, {z}); rays that do not leave it \
             as often as they enter: {of_x} along x, {of_y} along y, {of_z} along z; {} of {n_cells} cells were doubtful and were \
             decided {decided}",
            self.geometry, self.open_edges, self.holes, self.doubtful_cells,
        )
    }
}
