//! Numbers for the cells and points of some flags, layer by layer: what formats without a grid need.
//!
//! Mesh, flags to keep -> [`Layer`], one for each plane of cells from below, and one more for the points on top. Kept cells are numbered from 0, x
//! fastest, then y, then z; so are those points that a kept cell has as a corner. Points are numbered line by line, too: point (x, y, z) is where
//! lines x, y and z meet.
//!
//! A layer knows the flags of its plane of cells and of the planes below and above, and the numbers of its own cells, of those above and of the
//! points of both its sides. Cost: O(cells) time; besides two slabs of flags 19 bytes for each cell of a plane across z.

use super::output::Export;
use hexcast_core::base::error::Result;

/// The number of a cell or point that is not kept.
const NONE: u32 = u32::MAX;

/// A plane of cells.
#[derive(Default)]
struct Plane {
    /// x fastest; empty beyond the mesh.
    flags: Vec<u8>,
    /// Numbers of its kept cells, counted from the first of them; NONE for others.
    ranks: Vec<u32>,
    n_kept: u64,
}

/// The points on the lines between two planes of cells.
#[derive(Default)]
struct Points {
    ranks: Vec<u32>,
    n_used: u64,
}

/// A plane of cells between two planes of points.
pub(super) struct Layer<'a> {
    /// Index of the plane of cells, and of the points below it.
    pub(super) z: u32,
    nx: usize,
    ny: usize,
    keeps: &'a [bool; 256],
    below: Plane,
    here: Plane,
    above: Plane,
    low: Points,
    high: Points,
    /// Number of the first cell of `here`, and of the first point of `low`.
    first_cell: u64,
    first_point: u64,
}

/// Directions to the six neighbours of a cell, in the order -x, +x, -y, +y, -z, +z.
pub(super) const N_SIDES: usize = 6;

/// Calls `visit` with every layer, in ascending order, and then with one that has only points, those on top of the mesh.
///
/// # Errors
/// `cancelled`, looked at before every slab; `io` as for [`Mesh::flag`](hexcast_derived::mesh::Mesh::flag); whatever `visit` returns.
pub(super) async fn for_each_layer(
    job: &Export<'_>,
    keeps: &[bool; 256],
    visit: &mut dyn FnMut(&Layer) -> Result<()>,
) -> Result<()> {
    let [nx, ny, nz] = job.mesh.dims();
    let mut layer = Layer::new(nx as usize, ny as usize, keeps);
    let plane = nx as usize * ny as usize;
    let mut n_planes = 0;
    // whole planes, also where one is larger than a slab
    let mut push = |flags: &[u8]| {
        for flags in flags.chunks_exact(plane) {
            layer.push(flags);
            n_planes += 1;
            if n_planes > 1 {
                layer.z = n_planes - 2;
                visit(&layer)?;
            }
        }
        Ok(())
    };
    job.for_each_slab(plane, &mut push).await?;
    for z in [nz - 1, nz] {
        layer.push(&[]);
        layer.z = z;
        visit(&layer)?;
    }
    Ok(())
}

impl<'a> Layer<'a> {
    fn new(nx: usize, ny: usize, keeps: &'a [bool; 256]) -> Layer<'a> {
        let [below, here, above] = [const { Plane { flags: Vec::new(), ranks: Vec::new(), n_kept: 0 } }; 3];
        let [low, high] = [const { Points { ranks: Vec::new(), n_used: 0 } }; 2];
        Layer { z: 0, nx, ny, keeps, below, here, above, low, high, first_cell: 0, first_point: 0 }
    }

    /// Goes one plane up: what was above is here, and these are the flags above.
    fn push(&mut self, flags: &[u8]) {
        self.first_cell += self.here.n_kept;
        self.first_point += self.low.n_used;
        std::mem::swap(&mut self.below, &mut self.here);
        std::mem::swap(&mut self.here, &mut self.above);
        self.above.fill(flags, self.keeps);
        std::mem::swap(&mut self.low, &mut self.high);
        self.high.fill([&self.here, &self.above], [self.nx, self.ny]);
    }

    /// Calls `visit` with x, y, flag and number of every kept cell, x fastest.
    pub(super) fn for_each_cell(&self, mut visit: impl FnMut([usize; 2], u8, u64) -> Result<()>) -> Result<()> {
        for (index, (&flag, &rank)) in self.here.flags.iter().zip(&self.here.ranks).enumerate() {
            if rank != NONE {
                visit([index % self.nx, index / self.nx], flag, self.first_cell + u64::from(rank))?;
            }
        }
        Ok(())
    }

    /// Calls `visit` with x, y and number of every point below these cells that a kept cell has, x fastest.
    pub(super) fn for_each_point(&self, mut visit: impl FnMut([usize; 2], u64) -> Result<()>) -> Result<()> {
        for (index, &rank) in self.low.ranks.iter().enumerate() {
            if rank != NONE {
                visit([index % (self.nx + 1), index / (self.nx + 1)], self.first_point + u64::from(rank))?;
            }
        }
        Ok(())
    }

    /// Number of the corner of a kept cell: 0 or 1 on each axis.
    pub(super) fn corner(&self, [x, y]: [usize; 2], [i, j, k]: [usize; 3]) -> u64 {
        let at = x + i + (self.nx + 1) * (y + j);
        match k {
            0 => self.first_point + u64::from(self.low.ranks[at]),
            _ => self.first_point + self.low.n_used + u64::from(self.high.ranks[at]),
        }
    }

    /// Numbers of the corners of a kept cell: those below against the clock as seen from above, from the least x and y on, then
    /// those above likewise.
    pub(super) fn corners(&self, cell: [usize; 2]) -> [u64; 8] {
        CORNERS.map(|corner| self.corner(cell, corner))
    }

    /// The flag of a neighbour of a cell; None beyond the mesh.
    pub(super) fn neighbour(&self, [x, y]: [usize; 2], side: usize) -> Option<u8> {
        let at = x + self.nx * y;
        match side {
            0 => (x > 0).then(|| self.here.flags[at - 1]),
            1 => (x + 1 < self.nx).then(|| self.here.flags[at + 1]),
            2 => (y > 0).then(|| self.here.flags[at - self.nx]),
            3 => (y + 1 < self.ny).then(|| self.here.flags[at + self.nx]),
            4 => self.below.flags.get(at).copied(),
            _ => self.above.flags.get(at).copied(),
        }
    }

    /// Whether the cells of a flag are kept.
    pub(super) fn keeps(&self, flag: u8) -> bool {
        self.keeps[usize::from(flag)]
    }

    /// Number of the kept neighbour of a cell along +x, +y or +z: sides 1, 3 and 5.
    pub(super) fn next(&self, [x, y]: [usize; 2], side: usize) -> u64 {
        let at = x + self.nx * y;
        match side {
            1 => self.first_cell + u64::from(self.here.ranks[at + 1]),
            3 => self.first_cell + u64::from(self.here.ranks[at + self.nx]),
            _ => self.first_cell + self.here.n_kept + u64::from(self.above.ranks[at]),
        }
    }
}

const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// The corners of each side of a cell, by their places in [`Layer::corners`]; against the clock as seen from outside of the cell.
pub(super) const SIDES: [[usize; 4]; N_SIDES] =
    [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]];

impl Plane {
    fn fill(&mut self, flags: &[u8], keeps: &[bool; 256]) {
        self.flags.clear();
        self.flags.extend_from_slice(flags);
        self.ranks.clear();
        let mut n = 0;
        self.ranks.extend(flags.iter().map(|flag| {
            let is_kept = keeps[usize::from(*flag)];
            n += u32::from(is_kept);
            if is_kept { n - 1 } else { NONE }
        }));
        self.n_kept = n.into();
    }
}

impl Points {
    /// Numbers the points between two planes of cells.
    fn fill(&mut self, planes: [&Plane; 2], [nx, ny]: [usize; 2]) {
        self.ranks.clear();
        self.ranks.resize((nx + 1) * (ny + 1), NONE);
        for plane in planes {
            for (row, ranks) in plane.ranks.chunks_exact(nx).enumerate() {
                for (x, _) in ranks.iter().enumerate().filter(|(_, rank)| **rank != NONE) {
                    for corner in [0, 1, nx + 1, nx + 2] {
                        self.ranks[x + row * (nx + 1) + corner] = 0;
                    }
                }
            }
        }
        let mut n = 0;
        for rank in self.ranks.iter_mut().filter(|rank| **rank != NONE) {
            *rank = n;
            n += 1;
        }
        self.n_used = n.into();
    }
}
