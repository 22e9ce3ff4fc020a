//! The cells in which links and fractions are measured (those of a window or part, or all), and their numbers in the mesh.

/// Some cells of a box. Their mesh may have a halo around them, and counts from the first cell of that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellWindow {
    /// The first cell, counted in the box.
    pub first: [u32; 3],
    /// The end, exclusive.
    pub end: [u32; 3],
    /// Cells of the halo on both sides of each axis.
    pub halo: u32,
}

impl CellWindow {
    /// All cells of a box.
    pub fn all(dims: [u32; 3]) -> CellWindow {
        CellWindow { first: [0; 3], end: dims, halo: 0 }
    }

    /// Number of cells of the mesh on x, y, z, with its halo.
    pub fn dims(&self) -> [u32; 3] {
        [0, 1, 2].map(|axis| self.end[axis] - self.first[axis] + 2 * self.halo)
    }

    /// The first cell of the mesh, counted in the box; below 0 where the halo reaches beyond it.
    pub fn origin(&self) -> [i32; 3] {
        self.first.map(|cell| cell as i32 - self.halo as i32)
    }

    /// Where the mesh has a cell of the box; None where it is none of these.
    #[inline(always)]
    pub fn place(&self, cell: [u32; 3]) -> Option<[u32; 3]> {
        let CellWindow { first, end, halo } = *self;
        let [x, y, z] = cell;
        let is_one = first[0] <= x && x < end[0] && first[1] <= y && y < end[1] && first[2] <= z && z < end[2];
        is_one.then(|| [x - first[0] + halo, y - first[1] + halo, z - first[2] + halo])
    }

    /// One of these cells by the index that the mesh has for it, counted from the first of them.
    pub fn cell(&self, index: u64) -> [u32; 3] {
        let [nx, ny, _] = self.dims().map(u64::from);
        [index % nx, index / nx % ny, index / (nx * ny)].map(|at| at as u32 - self.halo)
    }

    /// The index that the mesh has for one of these cells, x fastest.
    pub fn index(&self, cell: [u32; 3]) -> u64 {
        let [nx, ny, _] = self.dims().map(u64::from);
        let [x, y, z] = [0, 1, 2].map(|axis| u64::from(cell[axis] - self.first[axis] + self.halo));
        x + nx * (y + ny * z)
    }

    /// These cells and their neighbours in a box: the first, and the end, exclusive.
    pub fn with_neighbours(&self, dims: [u32; 3]) -> [[u32; 3]; 2] {
        self.with_near(1, dims)
    }

    /// These cells and so many more on both sides of each axis, as far as the box goes: the first, and the end, exclusive.
    pub fn with_near(&self, n: u32, dims: [u32; 3]) -> [[u32; 3]; 2] {
        let end = [0, 1, 2].map(|axis| (self.end[axis] + n).min(dims[axis]));
        [self.first.map(|cell| cell.saturating_sub(n)), end]
    }
}
