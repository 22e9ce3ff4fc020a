//! Doubt: the cells of open geometries that their rays do not decide, as a list of boxes and as a mask.
//!
//! Runs of cells along rays, row after row of rays -> [`Doubt`] -> [`Doubtful`]: boxes that are the same along every ray axis, and
//! columns. The runs of a row are not kept.
//!
//! # Theory
//! A row is made of cells along x, as many as possible. Rows with the same ends that follow each other along y are a plate, as
//! many as possible. Plates with the same ends that follow each other along z are a box. So the boxes depend on the set of
//! cells alone.
//!
//! # Practice
//! A row of rays is a plane of cells. A sweep along x cuts runs along y or z into rows along x. If the planes lie across z, rows
//! are joined to plates, and plates to those of the plane below. If they lie across y, as for rays along z, each row along x
//! remembers the plane in which its cells entered the set; they leave it together, as cells of one plate.
//!
//! Cost: O(n log n) for n runs; memory for the rows of some planes, the largest boxes and, if asked for, the mask.

use std::ops::Range;

use crate::base::error::Result;
use crate::base::parallel::*;
use crate::cells::columns::{Band, CellRun, Columns, ColumnsBuilder, run};
use crate::grid::rays::Rays;

mod boxes;
mod sweep;

pub use boxes::Corners;
use boxes::{Boxes, plane};

/// A set of cells, which grows row of rays after row of rays.
pub struct Doubt {
    rays: Rays,
    /// The rows before it have been added.
    next_row: u32,
    n_cells: u64,
    boxes: Boxes,
    mask: Option<ColumnsBuilder>,
}

/// A set of cells.
pub struct Doubtful {
    /// Number of cells.
    pub n_cells: u64,
    /// The largest of the boxes that hold all cells and have none in common, the largest first.
    pub boxes: Vec<Corners>,
    /// The cells with the flag 1, if asked for.
    pub mask: Option<Columns>,
}

/// What is found of the runs of some rows by themselves.
struct Found {
    n_cells: u64,
    planes: Vec<Vec<boxes::Sorted>>,
    band: Option<Band>,
}

impl Doubt {
    /// No cells. Keeps at most `most` boxes, and the columns of a mask in at most so many bytes, if asked for.
    pub fn new(rays: Rays, most: usize, mask_bytes: Option<u64>) -> Doubt {
        let mask = mask_bytes.map(|max_bytes| ColumnsBuilder::new(rays, max_bytes, None));
        Doubt { rays, next_row: 0, n_cells: 0, boxes: Boxes::new(rays.axis, most), mask }
    }

    /// Adds the runs of the next rows, in any order within a part. Rows that were added before are left out.
    ///
    /// # Errors
    /// `memory` where the mask takes more than it may.
    pub fn add(&mut self, parts: Vec<(Range<u32>, Vec<CellRun>)>) -> Result<()> {
        let end = parts.last().map_or(0, |(rows, _)| rows.end);
        let found: Vec<Found> = parts.into_par_iter().map(|(rows, runs)| self.found(rows, runs)).collect();
        self.next_row = self.next_row.max(end);
        let mut bands = Vec::new();
        for Found { n_cells, planes, band } in found {
            self.n_cells += n_cells;
            planes.into_iter().for_each(|plane| self.boxes.add(plane));
            bands.extend(band);
        }
        self.mask.as_mut().map_or(Ok(()), |mask| mask.push(bands))
    }

    fn found(&self, rows: Range<u32>, runs: Vec<CellRun>) -> Found {
        let rows = rows.start.max(self.next_row)..rows.end.max(self.next_row);
        let n = u64::from(self.rays.counts[0]);
        let mut runs = CellRun::united(runs);
        runs.retain(|run| run.ray >= u64::from(rows.start) * n);
        let of_row = runs.chunk_by(|one, next| one.ray / n == next.ray / n);
        Found {
            n_cells: runs.iter().map(|run| u64::from(run.end - run.start)).sum(),
            planes: of_row.map(|of_row| plane(&self.rays, of_row)).collect(),
            band: self.mask.is_some().then(|| self.band(&rows, &runs)),
        }
    }

    /// Rows of rays with the flag 1 in the cells of runs.
    fn band(&self, rows: &Range<u32>, runs: &[CellRun]) -> Band {
        let [first, end] = [rows.start, rows.end].map(|row| u64::from(row) * u64::from(self.rays.counts[0]));
        let mut band = Band { first_ray: first, ..Band::default() };
        let mut rest = runs;
        for ray in first..end {
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
    }

    /// All cells; rows that were not added have none.
    ///
    /// # Errors
    /// Those of [`Doubt::add`].
    pub fn finish(mut self) -> Result<Doubtful> {
        let rows = self.next_row..self.rays.counts[1];
        if self.mask.is_some() && !rows.is_empty() {
            self.add(vec![(rows, Vec::new())])?;
        }
        let mask = self.mask.map(ColumnsBuilder::finish).transpose()?;
        Ok(Doubtful { n_cells: self.n_cells, boxes: self.boxes.finish(), mask })
    }
}

#[cfg(test)]
mod tests;
