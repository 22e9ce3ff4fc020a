//! The outline of a fluid: on which side of its surface the corners of cut cells are, and where it crosses their edges.
//!
//! [`cut_cells::outline`](crate::cut_cells::outline) finds it, [`parts`](crate::cut_cells::parts) what the fluid has of its cells, [`polyhedra`](crate::cut_cells::polyhedra) makes cells of it. All cells at an edge have the same numbers.

/// Of a cut cell: its corners are numbered by bits of x, y and z; its edges 4 along x, then y, then z, each at the low ends of the two other axes, at
/// the high end of the first of them, at that of the second, and at both.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct OutlineCell {
    /// Index of the cell in the mesh: x + nx (y + ny z).
    pub cell: u64,
    /// The flag at each corner: infinitesimally below it, as at a centre that lies on a surface.
    pub corners: [u8; 8],
    /// Where the surface of the fluid crosses each edge, from its low end, in edges; NaN where both ends are on one side. Of an edge that it crosses several times the place
    /// is that which leaves the fluid the length that it has.
    pub crossings: [f64; 12],
    /// Whose facet that is: an index of [`Outline::walls`]; not used where there is no crossing.
    pub walls: [u32; 12],
    /// Whether an edge is crossed several times: what is there is thinner than the cell.
    pub is_thin: bool,
}

/// What a fluid has of a cut cell, and of its faces and edges, which are numbered as those of [`OutlineCell`]; faces below and above along x, then y, then z.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OutlinePart {
    /// The fraction of its volume.
    pub fraction: f64,
    /// The centre of what it has of the cell, in cells from the low corner: 0.5 where that is nothing.
    pub centre: [f64; 3],
    /// The fraction of each face.
    pub areas: [f64; 6],
    /// The centre of that along the two axes of the face, ascending: 0.5 where that is nothing.
    pub face_centres: [[f64; 2]; 6],
    /// The fraction of each edge.
    pub lengths: [f64; 12],
}

/// The outline of the cells of one flag.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Outline {
    /// The flag of the fluid.
    pub fluid: u8,
    /// Cells through which the surface of a geometry passes, by index.
    pub cells: Vec<OutlineCell>,
    /// Names of solids, or of geometries whose files name no solids.
    pub walls: Vec<String>,
    /// For each cell what the fluid has of it; empty unless asked for.
    pub parts: Vec<OutlinePart>,
}

impl Outline {
    /// Cells of which an edge is crossed several times.
    pub fn n_thin(&self) -> usize {
        self.cells.iter().filter(|cell| cell.is_thin).count()
    }
}
