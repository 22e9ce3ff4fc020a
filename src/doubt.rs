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

    /// The largest of the boxes that hold all cells and have none in common, at most so many, the largest first.
    pub fn boxes(&self, most: usize) -> Vec<Corners> {
        let n = u64::from(self.rays.counts[0]);
        let rows: Vec<&[CellRun]> = self.runs.chunk_by(|one, next| one.ray / n == next.ray / n).collect();
        let parts = rows.into_par_iter().map(|of_row| self.rows(of_row));
        let mut boxes = if self.rays.axis < 2 {
            // the rows of a part have the same z
            stacked(parts.map(|rows| joined([0, 2, 1], rows)).collect())
        } else {
            joined([0, 1, 2], plates(parts.flatten_iter().collect()))
        };
        // of equal ones the first in the order of the cells
        let order = |[x, y, z]: &Sorted| {
            let n: u64 = [x, y, z].into_iter().map(|[first, end]| u64::from(end - first)).product();
            (u64::MAX - n, z[0], y[0], x[0])
        };
        if boxes.len() > most {
            boxes.select_nth_unstable_by_key(most, order);
            boxes.truncate(most);
        }
        boxes.sort_unstable_by_key(order);
        boxes.into_iter().map(|[x, y, z]| [0, 1].map(|end: usize| [x[end], y[end], z[end]])).collect()
    }

    /// The cells of a row of rays in boxes whose extents along x are those of the longest rows.
    fn rows(&self, of_row: &[CellRun]) -> Vec<Sorted> {
        let n = u64::from(self.rays.counts[0]);
        let row = of_row.first().map_or(0, |run| (run.ray / n) as u32);
        let places = of_row.iter().map(|run| ((run.ray % n) as u32, [run.start, run.end]));
        let mut rows = Vec::new();
        match self.rays.axis {
            0 => rows.extend(places.map(|(y, x)| [x, [y, y + 1], [row, row + 1]])),
            1 => sweep(places, |y, x| rows.push([x, y, [row, row + 1]])),
            _ => sweep(places, |z, x| rows.push([x, [row, row + 1], z])),
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

/// Joins rows that came from runs along z to plates: as many of the same ends along x as can be.
fn plates(mut rows: Vec<Sorted>) -> Vec<Sorted> {
    rows.par_sort_unstable();
    let mut plates = Vec::new();
    for same in rows.chunk_by(|one, next| one[0] == next[0]) {
        sweep(same.iter().map(|[_, y, z]| (y[0], *z)), |z, y| plates.push([same[0][0], y, z]));
    }
    plates
}

/// Two pairs as one number, in the same order: it is compared at once.
fn packed(pairs: [[u32; 2]; 2]) -> u128 {
    pairs.as_flattened().iter().fold(0, |number, part| number << 32 | u128::from(*part))
}

/// Joins the plates of planes, which ascend along z, to boxes; those of a plane are in order.
fn stacked(planes: Vec<Vec<Sorted>>) -> Vec<Sorted> {
    let (mut boxes, mut below) = (Vec::new(), Vec::<Sorted>::new());
    for mut plane in planes {
        let mut ended = below.into_iter().peekable();
        for plate in &mut plane {
            while let Some(other) = ended.next_if(|of| of[..2] < plate[..2]) {
                boxes.push(other);
            }
            match ended.next_if(|of| of[..2] == plate[..2]) {
                Some(same) if same[2][1] == plate[2][0] => plate[2][0] = same[2][0],
                Some(other) => boxes.push(other),
                None => {}
            }
        }
        boxes.extend(ended);
        below = plane;
    }
    boxes.extend(below);
    boxes
}

/// Joins boxes that differ in nothing but the last of three axes, and touch there.
fn joined(axes: [usize; 3], mut boxes: Vec<Sorted>) -> Vec<Sorted> {
    let [first, second, last] = axes;
    boxes.sort_unstable_by_key(|of| (packed([of[first], of[second]]), of[last][0]));
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
