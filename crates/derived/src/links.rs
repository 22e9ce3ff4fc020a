//! Links: how far it is from cells of a fluid to the surface, in the directions of a stencil.
//!
//! Frame, columns, window, stencil, flags of the fluid -> [`Links`]. A link is the segment from the centre of a cell to that of a neighbour. For
//! each link that begins in the fluid and meets a surface behind which the flag is no fluid, q is the fraction of the link up to there.
//!
//! # Theory
//! Centres are lattice points, so that links of one direction follow each other on lines through the box. A shear turns these lines into
//! rays along an axis (`links/sheared.rs`): they are cast as any others, by exact integers. The tie rule stays the same, so
//! flags and links agree: where the flags of two cells of closed geometries differ, the link between them has a crossing.
//!
//! Several crossings of a link are put in order by exact fractions. Those at the same place act together.
//!
//! `q = height / (D 2^F)`, an exact fraction from 0 to 1, is rounded to f32 once: off by less than 2^-24 of itself and 2^-50. Where the
//! surface meets the centre of the fluid's cell itself, q is the least normal f32, 2^-126, in place of 0.
//!
//! Geometries that are not closed, and those with cells along their surfaces, have other cells than rays tell (`links/undecided.rs`): there
//! a link may end in another flag without a crossing. Its q is 1/2, and it names no facet.
//!
//! Links lead through sides of the box that are periodic, to cells at the other side (`links/periodic.rs`).
//!
//! Links of a window begin in its cells, and are those of the whole box: rays go through these cells and their neighbours, in the frame of the whole box.
//!
//! Source: the distances are those of Bouzidi, Firdaouss & Lallemand (2001), Physics of Fluids 13, 3452.
//! Cost: a cast for each pair of directions, of about as many rays as two times those of the mesh or four times; 24 bytes a link.

use hexcast_core::input::job::Stencil;

mod field;
mod find;
mod order;
mod periodic;
mod sheared;
mod strip;
mod undecided;
mod walk;

#[doc(hidden)]
pub use field::Field;

/// A link from a cell of the fluid to the surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Link {
    /// The cell of the fluid, x, y, z, as the mesh counts it.
    pub cell: [u32; 3],
    /// Fraction of the link up to the surface: greater than 0, at most 1.
    pub q: f32,
    /// The facet, counted from 0 in its geometry; -1 where no facet crosses the link.
    pub facet: i32,
    /// The geometry of the facet, counted from 0 in the job; -1 where no facet crosses the link.
    pub geometry: i16,
    /// The direction, as an index of [`Stencil::directions`].
    pub direction: u8,
    /// Flag of the cell at the other end: one of the fluid where the wall between is thinner than the link.
    pub flag: u8,
}

/// All links from cells of the fluid to the surface, of a box or of a window.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Links {
    /// The directions.
    pub stencil: Stencil,
    /// Flags of the fluid.
    pub fluid: Vec<u8>,
    /// Number of cells of the mesh on x, y, z.
    pub dims: [u32; 3],
    /// The first cell of the mesh, counted in the box: 0 but for windows, less where a halo begins beyond the box.
    pub origin: [i32; 3],
    /// The links of each plane of cells across z.
    #[doc(hidden)]
    pub planes: Vec<Vec<Link>>,
}

impl Links {
    /// The links, in the order of their cells, x fastest, then of their directions. Those that lead out of the box do so through periodic sides.
    pub fn iter(&self) -> impl Iterator<Item = &Link> + Clone {
        self.planes.iter().flatten()
    }

    /// Number of links.
    pub fn len(&self) -> usize {
        self.planes.iter().map(Vec::len).sum()
    }

    #[doc(hidden)]
    pub fn n_bytes(&self) -> u64 {
        (self.len() * size_of::<Link>()) as u64
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.planes.iter().all(Vec::is_empty)
    }
}
