//! Doubt: the cells of open geometries that their rays do not decide, as a list of boxes and as a mask.
//!
//! Runs of cells along rays -> [`Doubt`]; [`Doubt::boxes`] -> boxes that are the same along every ray axis; [`Doubt::mask`] -> a mesh.
//!
//! # Theory
//! The boxes are made of rows along x, as long as can be; rows of the same ends that follow each other along y are a plate, as many as
//! can be; plates of the same ends that follow each other along z are a box. This depends on the set of cells alone. Runs along y or z
//! are cut in such rows by a sweep along x, and what is left of runs along z in plates by one along y: from place to place it keeps
//! since when each cell is in the set.
//!
//! Cost: O(n log n) for n runs; 16 bytes a run, some 100 for a moment.

use crate::columns::{Band, CellRun, Columns, Named, run};
use crate::mesh::Mesh;
use crate::parallel::*;
use crate::rays::Rays;

mod sweep;

use sweep::sweep;

/// Name of the flag of the mask.
const NAME: &str = "doubtful";
/// Rays of a band of the mask.
const BAND_RAYS: u64 = 1 << 16;

/// A box of cells: its first cell and its end, exclusive.
pub type Corners = [[u32; 3]; 2];

/// A set of cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Doubt {
    rays: Rays,
    /// Ascending; those of a ray do not touch.
    runs: Vec<CellRun>,
}

/// First and end of some cells along x, y and z, in the order in which they are sorted: by rows first.
type Sorted = [[u32; 2]; 3];

impl Doubt {
    /// Unites runs in any order.
    pub fn new(rays: Rays, runs: Vec<CellRun>) -> Doubt {
        Doubt { rays, runs: CellRun::united(runs) }
    }

    /// Number of cells.
    pub fn n_cells(&self) -> u64 {
        self.runs.iter().map(|run| u64::from(run.end - run.start)).sum()
    }

    /// All cells in boxes that have none in common, the largest first.
    pub fn boxes(&self) -> Vec<Corners> {
        let mut boxes = joined([0, 1, 2], plates(self.rays.axis, self.rows()));
        // of equal ones the first in the order of the cells
        boxes.sort_unstable_by_key(|[x, y, z]| {
            let n: u64 = [x, y, z].into_iter().map(|[first, end]| u64::from(end - first)).product();
            (u64::MAX - n, z[0], y[0], x[0])
        });
        boxes.into_iter().map(|[x, y, z]| [0, 1].map(|end: usize| [x[end], y[end], z[end]])).collect()
    }

    /// All cells in boxes whose extents along x are those of the longest rows.
    fn rows(&self) -> Vec<Sorted> {
        let n = u64::from(self.rays.counts[0]);
        let mut rows = Vec::new();
        for of_row in self.runs.chunk_by(|one, next| one.ray / n == next.ray / n) {
            let row = (of_row[0].ray / n) as u32;
            let places = of_row.iter().map(|run| ((run.ray % n) as u32, [run.start, run.end]));
            match self.rays.axis {
                0 => rows.extend(places.map(|(y, x)| [x, [y, y + 1], [row, row + 1]])),
                1 => sweep(places, |y, x| rows.push([x, y, [row, row + 1]])),
                _ => sweep(places, |z, x| rows.push([x, [row, row + 1], z])),
            }
        }
        rows
    }

    /// A mesh of the same cells with the flag 1 in the set and 0 elsewhere.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has other cells.
    pub fn mask(&self, mesh: &Mesh) -> crate::Result<Mesh> {
        let n_rays = self.rays.n_rays();
        let band = |index: u64| {
            let rays = index * BAND_RAYS..n_rays.min((index + 1) * BAND_RAYS);
            let mut band = Band { first_ray: rays.start, ..Band::default() };
            let mut rest = &self.runs[self.runs.partition_point(|run| run.ray < rays.start)..];
            for ray in rays {
                while let Some((next, after)) = rest.split_first().filter(|(next, _)| next.ray == ray) {
                    band.runs.push(run(next.start, 1));
                    if next.end < self.rays.depth {
                        band.runs.push(run(next.end, 0));
                    }
                    rest = after;
                }
                band.ends.push(band.runs.len() as u32);
            }
            band
        };
        let bands: Vec<Band> = (0..n_rays.div_ceil(BAND_RAYS)).into_par_iter().map(band).collect();
        let names = vec![Named { flag: 1, name: NAME.into() }];
        Mesh::new(mesh.lines, Columns::new(self.rays, bands), names, mesh.unit.clone())
    }
}

/// Joins rows, which came from runs along an axis, to plates: as many of the same ends along y as can be.
fn plates(axis: usize, mut rows: Vec<Sorted>) -> Vec<Sorted> {
    if axis < 2 {
        // planes of the same z: the rows of a plate touch
        return joined([0, 2, 1], rows);
    }
    rows.par_sort_unstable();
    let mut plates = Vec::new();
    for same in rows.chunk_by(|one, next| one[0] == next[0]) {
        sweep(same.iter().map(|[_, y, z]| (y[0], *z)), |z, y| plates.push([same[0][0], y, z]));
    }
    plates
}

/// Joins boxes that differ in nothing but the last of three axes, and touch there.
fn joined(axes: [usize; 3], mut boxes: Vec<Sorted>) -> Vec<Sorted> {
    boxes.sort_unstable_by_key(|of| axes.map(|axis| of[axis]));
    let [first, second, last] = axes;
    boxes.dedup_by(|next, before| {
        let touches =
            next[first] == before[first] && next[second] == before[second] && next[last][0] == before[last][1];
        if touches {
            before[last][1] = next[last][1];
        }
        touches
    });
    boxes
}

#[cfg(test)]
mod tests;
