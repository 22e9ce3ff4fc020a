//! Columns: the sorted, labelled runs of every ray. The result of a mesh: small, lossless, random access.
//!
//! A run is one u32, `first cell << 8 | flag`. The runs of a ray are sorted by cell; a run ends where the next begins, the
//! last at the end of the ray; cells before the first run are background; neighbouring runs differ in flag.
//! Bands come as the backends make them, with 4 bytes a ray; joined they take 1.07 (see `part.rs`). Columns larger than
//! the memory allowed go to a [`Store`] and are read back piece by piece.
//! Cost in memory: 4 bytes a run and 1.07 bytes a ray.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use crate::error::{Error, Result};
use crate::parallel::*;
use crate::rays::Rays;

mod clip;
pub(crate) mod codec;
pub mod file;
mod growing;
mod part;
mod run;
pub(crate) mod store;
mod stored;
mod target;

pub(crate) use clip::SlabColumns;
use file::end::Totals;
pub use file::head::{Head, Named};
pub use growing::Growing;
pub(crate) use part::Part;
pub use run::{Band, flag_at, run, run_cell, run_flag};
pub use store::Store;
pub(crate) use stored::{Record, Stored};

/// Runs of all rays of the box.
#[derive(Debug, Clone)]
pub struct Columns {
    /// The rays.
    pub rays: Rays,
    content: Content,
    odd_rays: u64,
    n_crossings: u64,
}

#[derive(Debug, Clone)]
enum Content {
    /// In memory.
    Held(Arc<Vec<Part>>),
    /// In a store: the pieces, what all of them hold, and their bytes.
    Spilled { stored: Arc<Stored>, records: Arc<[Record]>, totals: Totals, n_bytes: u64 },
}

impl PartialEq for Columns {
    /// Two results are equal if every ray has the same runs, however they are split and wherever they are; columns that
    /// cannot be read equal none.
    fn eq(&self, other: &Columns) -> bool {
        let mut ray = 0;
        let mut equal = self.rays == other.rays;
        let n_rays = self.rays.n_rays();
        while equal && ray < n_rays {
            // as much as one piece holds
            let end = n_rays.min(ray + u64::from(codec::PIECE_RAYS));
            let runs_of = |columns: &Columns| {
                let mut all = Vec::new();
                columns.for_rays(ray..end, |runs| all.extend([&[runs.len() as u32], runs].concat()))?;
                Ok::<_, Error>(all)
            };
            equal = matches!((runs_of(self), runs_of(other)), (Ok(ours), Ok(theirs)) if ours == theirs);
            ray = end;
        }
        equal
    }
}

impl Columns {
    /// Joins bands, in order of their rays, to the columns of a box.
    ///
    /// # Panics
    /// If the bands do not cover every ray once, in order: a bug of the caller.
    pub fn new(rays: Rays, bands: Vec<Band>) -> Columns {
        let mut next = 0;
        let [mut odd_rays, mut n_crossings] = [0; 2];
        for band in &bands {
            assert_eq!(band.first_ray, next, "bands must follow each other");
            next += band.ends.len() as u64;
            odd_rays += band.odd_rays;
            n_crossings += band.n_crossings;
        }
        assert_eq!(next, rays.n_rays(), "bands must cover all rays");
        let content = Content::Held(Arc::new(bands.into_iter().map(Part::new).collect()));
        Columns { rays, content, odd_rays, n_crossings }
    }

    /// Takes the columns of a file that stay there.
    pub(crate) fn in_file(rays: Rays, stored: Stored, records: Vec<Record>, totals: Totals, n_bytes: u64) -> Columns {
        let [odd_rays, n_crossings] = [totals.odd_rays, totals.n_crossings];
        let content = Content::Spilled { stored: Arc::new(stored), records: records.into(), totals, n_bytes };
        Columns { rays, content, odd_rays, n_crossings }
    }

    /// Number of cells on x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        let mut dims = [self.rays.depth; 3];
        dims[self.rays.across[0]] = self.rays.counts[0];
        dims[self.rays.across[1]] = self.rays.counts[1];
        dims
    }

    /// Calls `found` with the runs of consecutive rays, in their order.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    pub fn for_rays(&self, rays: Range<u64>, mut found: impl FnMut(&[u32])) -> Result<()> {
        let mut of_part = |part: &Part| {
            let start = rays.start.max(part.first_ray) - part.first_ray;
            let n = rays.end.min(part.end_ray()) - part.first_ray - start;
            part.rays_from(start as usize).take(n as usize).for_each(&mut found);
        };
        match &self.content {
            Content::Held(parts) => {
                let first = parts.partition_point(|part| part.end_ray() <= rays.start);
                parts[first..].iter().take_while(|part| part.first_ray < rays.end).for_each(of_part);
            }
            Content::Spilled { stored, records, .. } => {
                let first = records.partition_point(|record| record.end_ray() <= rays.start);
                for record in records[first..].iter().take_while(|record| record.first_ray < rays.end) {
                    of_part(&*stored.part(record)?);
                }
            }
        }
        Ok(())
    }

    /// Runs of a ray by its index `i + n_i * j` over the axes across.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    ///
    /// # Panics
    /// If there is no such ray: a bug of the caller.
    pub fn ray(&self, ray: u64) -> Result<Cow<'_, [u32]>> {
        match &self.content {
            Content::Held(_) => Ok(Cow::Borrowed(self.held_ray(ray))),
            Content::Spilled { stored, records, .. } => {
                let part = stored.part(&records[records.partition_point(|record| record.end_ray() <= ray)])?;
                Ok(Cow::Owned(part.ray((ray - part.first_ray) as usize).to_vec()))
            }
        }
    }

    /// Runs of a ray of columns in memory; none where they are not.
    pub(crate) fn held_ray(&self, ray: u64) -> &[u32] {
        let Content::Held(parts) = &self.content else { return &[] };
        let part = &parts[parts.partition_point(|part| part.end_ray() <= ray)];
        part.ray((ray - part.first_ray) as usize)
    }

    /// Flag of the cell (x, y, z), each below [`Columns::dims`].
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    pub fn flag(&self, cell: [u32; 3]) -> Result<u8> {
        let [i, j] = self.rays.across.map(|axis| u64::from(cell[axis]));
        Ok(flag_at(&self.ray(i + u64::from(self.rays.counts[0]) * j)?, cell[self.rays.axis]))
    }

    /// Number of runs of all rays.
    pub fn n_runs(&self) -> u64 {
        match &self.content {
            Content::Held(parts) => parts.iter().map(Part::n_runs).sum(),
            Content::Spilled { totals, .. } => totals.n_runs,
        }
    }

    /// Number of crossings that the rays had.
    pub fn n_crossings(&self) -> u64 {
        self.n_crossings
    }

    /// Rays that do not leave every geometry they enter.
    pub fn odd_rays(&self) -> u64 {
        self.odd_rays
    }

    /// Whether the runs are in a store outside memory.
    pub fn is_spilled(&self) -> bool {
        matches!(self.content, Content::Spilled { .. })
    }

    /// Most bytes of an opened file that may be in memory at once; none for other columns.
    pub(crate) fn most_held(&self) -> Option<u64> {
        match &self.content {
            Content::Held(_) => None,
            Content::Spilled { stored, .. } => stored.most_held(),
        }
    }

    /// Bytes held in memory.
    pub fn n_bytes(&self) -> u64 {
        match &self.content {
            Content::Held(parts) => parts.iter().map(Part::n_bytes).sum(),
            Content::Spilled { records, .. } => size_of_val(&**records) as u64,
        }
    }

    /// Bytes in a store outside memory.
    pub fn spilled_bytes(&self) -> u64 {
        match &self.content {
            Content::Held(_) => 0,
            Content::Spilled { n_bytes, .. } => *n_bytes,
        }
    }

    /// Number of cells of every flag, 0 to 255.
    pub fn cells_per_flag(&self) -> [u64; 256] {
        let mut cells = match &self.content {
            Content::Held(parts) => cells_of(parts, self.rays.depth),
            Content::Spilled { totals, .. } => *totals.cells,
        };
        let flagged: u64 = cells.iter().sum();
        cells[0] += self.rays.n_rays() * u64::from(self.rays.depth) - flagged;
        cells
    }
}

/// Cells of every flag that runs of the parts name; cells before the first run of a ray are not counted.
fn cells_of(parts: &[Part], depth: u32) -> [u64; 256] {
    let of_part = |part: &Part| {
        let mut cells = [0; 256];
        part.add_cells(depth, &mut cells);
        cells
    };
    let of_parts: Vec<[u64; 256]> = parts.par_iter().map(of_part).collect();
    of_parts.into_iter().fold([0; 256], |mut sum, cells| {
        sum.iter_mut().zip(cells).for_each(|(sum, cells)| *sum += cells);
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Columns {
        let rays = Rays::new(2, [2, 2, 10]);
        let first =
            Band { first_ray: 0, ends: vec![2, 2, 3], runs: vec![run(1, 7), run(4, 0), run(9, 1)], ..Band::default() };
        let second = Band { first_ray: 3, ends: vec![1], runs: vec![run(0, 2)], ..Band::default() };
        Columns::new(rays, vec![first, second])
    }

    #[test]
    fn runs_are_found_across_bands() {
        let columns = columns();
        assert_eq!(columns.dims(), [2, 2, 10]);
        let flags = |x, y| (0..10).map(|z| columns.flag([x, y, z]).unwrap()).collect::<Vec<_>>();
        assert_eq!(flags(0, 0), [0, 7, 7, 7, 0, 0, 0, 0, 0, 0]);
        assert_eq!(flags(1, 0), [0; 10]);
        assert_eq!(flags(0, 1), [0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
        assert_eq!(flags(1, 1), [2; 10]);
        for (ray, end) in [(0, 4), (1, 3), (2, 4), (3, 4), (3, 3), (4, 4), (0, 1)] {
            let mut found = Vec::new();
            columns.for_rays(ray..end, |runs| found.push(runs.to_vec())).unwrap();
            let expected: Vec<Vec<u32>> = (ray..end).map(|ray| columns.ray(ray).unwrap().into_owned()).collect();
            assert_eq!(found, expected, "rays {ray} to {end}");
        }
    }

    #[test]
    fn every_cell_is_counted_once() {
        let cells = columns().cells_per_flag();
        assert_eq!([cells[0], cells[1], cells[2], cells[7]], [26, 1, 10, 3]);
        assert_eq!(cells.iter().sum::<u64>(), 40);
    }

    #[test]
    fn equality_looks_at_rays_not_at_bands() {
        let joined = Band {
            first_ray: 0,
            ends: vec![2, 2, 3, 4],
            runs: vec![run(1, 7), run(4, 0), run(9, 1), run(0, 2)],
            ..Band::default()
        };
        let other = Band { runs: vec![run(1, 7), run(4, 0), run(9, 1), run(1, 2)], ..joined.clone() };
        assert_eq!(Columns::new(columns().rays, vec![joined]), columns());
        assert_ne!(Columns::new(columns().rays, vec![other]), columns());
    }
}
