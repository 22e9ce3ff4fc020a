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

mod caps;
mod holes;
mod orient;
mod part;
mod votes;

pub(crate) use caps::Shift;
pub use part::{OpenPart, Surface};
pub(crate) use votes::{Through, Votes};
