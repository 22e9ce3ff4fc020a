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
    /// Where the surface bends sharply on each face, as at an edge of a body, along the two axes of the face, in cells; NaN where it runs straight from crossing to crossing.
    pub bends: [[f64; 2]; 6],
    /// Where it has a corner within the cell, from the low corner, in cells; NaN where it has none.
    pub peak: [f64; 3],
    /// Whether an edge is crossed several times: what is there is thinner than the cell.
    pub is_thin: bool,
    /// The fraction of the cell that is fluid.
    pub fraction: f64,
}

impl OutlineCell {
    /// The corners that are in a fluid, as bits.
    pub(crate) fn in_fluid(&self, fluid: u8) -> u8 {
        (0..8).filter(|&corner| self.corners[corner] == fluid).fold(0, |all, corner| all | 1 << corner)
    }
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
    /// Volume of the fluid in the box, in the unit of the lines cubed.
    pub volume: f64,
}

impl Outline {
    pub(crate) fn new(fluid: u8, cells: Vec<OutlineCell>, walls: Vec<String>, volume: f64) -> Outline {
        Outline { fluid, cells, walls, parts: Vec::new(), volume }
    }

    /// Cells of which an edge is crossed several times.
    pub fn n_thin(&self) -> usize {
        self.cells.iter().filter(|cell| cell.is_thin).count()
    }

    /// Cells without a corner in the fluid that have some of it.
    pub fn n_left_out(&self) -> usize {
        let is_left_out = |cell: &&OutlineCell| cell.fraction > 0.0 && !cell.corners.contains(&self.fluid);
        self.cells.iter().filter(is_left_out).count()
    }
}
