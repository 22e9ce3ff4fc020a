//! Open surfaces: which cells are inside of a geometry whose surface is not closed.
//!
//! # Theory
//! A geometry is closed if, after the snap, every edge has an even number of facets (rule `parity`), or as many one way as the
//! other (`nonzero`). Its rays decide every cell. Of one that is open ([`crate::input::geometry::Open::Winding`]):
//!
//! 1. Facets that share an edge with one other are turned to agree with it (`orient`). Where three open edges follow each other
//!    around a triangle that is no facet, that facet is missing, and is added (`holes`).
//! 2. Rays are cast along all three axes. A cell whose three rays cross the surface an even number of times, and agree, keeps
//!    their answer. Every other cell is doubtful.
//! 3. A doubtful cell is decided by the generalised winding number w at its centre (Jacobson, Kavan and Sorkine-Hornung 2013),
//!    the solid angle of the surface over 4 pi: inside if round(w) is odd, or for `nonzero` if it is not 0. Holes of up to 8 edges
//!    are closed first, with the triangles that bend the surface least, as if the triangles were part of it (`holes`). The other open edges form
//!    loops; a fan of triangles, a cap, closes each (`caps`). w is the winding number of surface and caps together, an
//!    integer, which one exact ray counts, less the solid angle of the caps over 4 pi, which falls with the square of the
//!    distance: far from all holes the exact ray decides alone.
//!
//! So closed parts cost nothing, and no tree of facets is needed, but one of caps. Only the caps are computed in f64: in the unit of the
//! lines, in a fixed order, with `libm`, so that the bits are the same on every machine. The result does not depend on the ray
//! axis, on bands or on the backend: crossings are exact on both, and all else is done on the host.
//!
//! # Practice
//! [`OpenPart`] turns and closes a surface. `Votes` says which rays decide it, and then finds its cells, row after row of rays.
//! [`crate::open_surfaces::overlay`] puts these cells over those of the other geometries.
//!
//! Degenerate cases: a surface of one sheet encloses little: round(w) is 0 in most cells. A surface that cannot be oriented has no
//! winding number; [`crate::input::geometry::Open::Vote`] decides it by the rays alone.
//! Cost: three casts, 32 bytes a crossing, a look at 64 cells at a time; near holes some microseconds a cell, and where most of a surface is
//! holes some hundred.

use crate::base::control::Control;
use crate::base::error::Result;
use crate::grid::frame::{Frame, SnappedFacet, world};
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::input::geometry::Open;
use crate::stages::axis_crossings::n_expected;

mod caps;
mod holes;
mod orient;
mod votes;

pub(crate) use caps::{CapAngles, Shift};
use caps::{Cells, caps, shifts};
use orient::orient;
pub(crate) use votes::{Through, Votes};

/// Of a triangle of a cap, and of its share of the clusters; clusters of few triangles take more.
const BYTES_OF_CAP: u64 = 450;
const BYTES_OF_FIRST_CAPS: u64 = 500;
const FIRST_CAPS: u64 = 1 << 17;

/// What the surface of an open geometry lacks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surface {
    /// Edges that facets use an odd number of times, or for `nonzero` more often one way than the other.
    pub open_edges: u64,
    /// Facets that were turned to agree with their neighbours.
    pub turned: u64,
    /// Its holes: loops of open edges.
    pub holes: u64,
    /// Holes of three edges, which the facet that is missing closed.
    pub added: u64,
    /// Middle of the longest open edge, in world coordinates.
    pub longest_at: [f64; 3],
}

/// A geometry that is not closed.
pub struct OpenPart {
    pub(crate) policy: Open,
    /// Its facets, turned to agree with each other, and those that were missing.
    pub(crate) facets: Vec<SnappedFacet>,
    /// Triangles that close its other small holes, as if they were facets, where the rays are in doubt.
    pub(crate) patches: Vec<SnappedFacet>,
    /// Triangles that close its large holes, counted from the first cell of the whole box.
    pub(crate) caps: Vec<SnappedFacet>,
    /// The first of the cells that are meshed, and its centre, counted from that of cell 0 of the whole box.
    pub(crate) first: ([u32; 3], [i32; 3]),
    pub(crate) surface: Surface,
}

impl OpenPart {
    /// Turns the facets of a geometry, adds those that are missing, and closes its other holes.
    ///
    /// # Errors
    /// `cancelled`.
    pub(crate) async fn new(
        policy: Open,
        facets: &[SnappedFacet],
        (fraction_bits, lines): (u32, &Lines),
        control: &Control,
    ) -> Result<OpenPart> {
        let sizes = lines.smallest().map(|size| size / lines.smallest()[0]);
        let oriented = orient(facets, sizes, control).await?;
        let caps = caps(&oriented.loops, control).await?;
        let place = |corner: [i32; 3]| world(corner, fraction_bits, lines);
        let ends = oriented.open_edges.iter().map(|edge| edge.map(place));
        let length = |[from, to]: &[[f64; 3]; 2]| (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>();
        let longest = ends.max_by(|one, other| length(one).total_cmp(&length(other))).unwrap_or_default();
        let surface = Surface {
            open_edges: oriented.open_edges.len() as u64,
            turned: oriented.n_turned,
            holes: oriented.loops.len() as u64 + oriented.n_closed,
            added: oriented.missing.len() as u64,
            longest_at: [0, 1, 2].map(|axis| 0.5 * (longest[0][axis] + longest[1][axis])),
        };
        let facets = [oriented.facets, oriented.missing].concat();
        Ok(OpenPart { policy, facets, patches: oriented.patches, caps, first: ([0; 3], [0; 3]), surface })
    }

    /// The cells of a frame whose winding number the caps move. `sizes` are the lengths of the smallest cells of the whole box.
    ///
    /// # Errors
    /// `cancelled`.
    pub(crate) async fn shifts(&self, frame: &Frame, sizes: [f64; 3], control: &Control) -> Result<Vec<Shift>> {
        if self.policy != Open::Winding {
            return Ok(Vec::new());
        }
        let (first, place) = self.first;
        let centre = |axis: usize, cell: u32| i64::from(frame.centre(axis, cell - first[axis]) + place[axis]);
        let cells = Cells { first, dims: frame.dims, centre: &centre };
        shifts(&self.caps, &cells, frame.fraction_bits, sizes, control).await
    }

    /// Bytes that deciding it takes, about: a word a crossing of each axis, along the rays once more with the caps, and as much again
    /// while crossings are grouped; and the clusters of the caps.
    pub(crate) fn n_bytes(&self, rays: &Rays, frame: &Frame) -> u64 {
        let crossings = |facets: &[SnappedFacet], axis: usize| n_expected(facets, axis, frame);
        let again = [&self.facets, &self.patches, &self.caps]
            .map(|facets| crossings(facets, rays.axis))
            .into_iter()
            .sum::<f64>();
        let n_caps = self.caps.len() as u64;
        let of_caps = BYTES_OF_CAP * n_caps + BYTES_OF_FIRST_CAPS * n_caps.min(FIRST_CAPS);
        of_caps + 16 * ((0..3).map(|axis| crossings(&self.facets, axis)).sum::<f64>() + again) as u64
    }
}
