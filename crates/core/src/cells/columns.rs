//! Columns: the sorted, labelled runs of every ray. The result of a mesh: small, lossless, random access.
//!
//! A run is one u32, `first cell << 8 | flag`. The runs of a ray are sorted by cell; a run ends where the next begins, the
//! last at the end of the ray; cells before the first run are background; neighbouring runs differ in flag.
//! A band, some consecutive rays, comes from a backend with 4 bytes a ray; packed it has 1.07 (see `packed_band.rs`). Columns
//! that exceed the memory allowed go to a [`Store`] and are read back piece by piece.
//! Cost in memory: 4 bytes a run and 1.07 bytes a ray.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use crate::base::error::{Error, Result};
use crate::grid::rays::Rays;

mod box_runs;
mod builder;
#[doc(hidden)]
pub mod codec;
mod cut;
#[doc(hidden)]
pub mod file;
mod packed_band;
mod pad;
mod piece_store;
mod run;
mod slab;
mod splice;
mod store;
mod totals_check;

pub use box_runs::BoxRuns;
#[doc(hidden)]
pub use builder::ColumnsBuilder;
use file::end::Totals;
pub use file::head::Head;
pub use file::head::Named;
pub(crate) use packed_band::PackedBand;
pub use piece_store::{PieceEntry, PieceStore};
#[doc(hidden)]
pub use run::for_differing;
pub use run::spans;
pub use run::{Band, CellRun, flag_at, run, run_cell, run_flag};
#[doc(hidden)]
pub use slab::SlabColumns;
pub use splice::ChangedRun;
#[doc(hidden)]
pub use splice::SomeRuns;
#[doc(hidden)]
pub use store::sealed;
pub use store::{MemoryStore, Store};
pub use totals_check::TotalsCheck;

/// Runs of all rays of the box.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Columns {
    /// The rays.
    pub(crate) rays: Rays,
    content: Content,
}

#[derive(Debug, Clone)]
enum Content {
    InMemory(Arc<Vec<PackedBand>>),
    InStore { pieces: Arc<PieceStore>, totals: Totals },
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
    /// The rays along which the runs lie.
    pub fn rays(&self) -> &Rays {
        &self.rays
    }

    /// Joins bands, in order of their rays, to the columns of a box.
    ///
    /// # Errors
    /// `job-conflict` where the bands do not cover every ray once, in order.
    pub fn new(rays: Rays, bands: Vec<Band>) -> Result<Columns> {
        let mut next = 0;
        for band in &bands {
            if band.first_ray != next {
                let message = format!("a band begins with ray {}, after those up to ray {next}", band.first_ray);
                return Err(Error::new("job-conflict", message, "give the bands in the order of their rays"));
            }
            next += band.ends.len() as u64;
        }
        if next != rays.n_rays() {
            let message = format!("the bands have {next} rays, and the columns {}", rays.n_rays());
            return Err(Error::new("job-conflict", message, "give a band for every ray"));
        }
        Ok(Columns::in_memory(rays, Arc::new(bands.into_iter().map(PackedBand::new).collect())))
    }

    fn in_memory(rays: Rays, bands: Arc<Vec<PackedBand>>) -> Columns {
        Columns { rays, content: Content::InMemory(bands) }
    }

    /// Takes the columns of a file that stay there.
    #[doc(hidden)]
    pub fn in_store(rays: Rays, pieces: PieceStore, totals: Totals) -> Columns {
        Columns { rays, content: Content::InStore { pieces: Arc::new(pieces), totals } }
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
        if rays.is_empty() {
            return Ok(());
        }
        let mut of_band = |band: &PackedBand| {
            let start = rays.start.max(band.first_ray) - band.first_ray;
            let n = rays.end.min(band.end_ray()) - band.first_ray - start;
            band.rays_from(start as usize).take(n as usize).for_each(&mut found);
        };
        match &self.content {
            Content::InMemory(bands) => {
                let first = bands.partition_point(|band| band.end_ray() <= rays.start);
                bands[first..].iter().take_while(|band| band.first_ray < rays.end).for_each(of_band);
            }
            Content::InStore { pieces, .. } => {
                let first = pieces.entries.partition_point(|entry| entry.end_ray() <= rays.start);
                for entry in pieces.entries[first..].iter().take_while(|entry| entry.first_ray < rays.end) {
                    of_band(&*pieces.cached(entry)?);
                }
            }
        }
        Ok(())
    }

    /// Runs of a ray by its index `i + n_i * j` over the axes across.
    ///
    /// # Errors
    /// `job-value` where there is no such ray; `io` where the columns are in a store that fails.
    pub fn ray(&self, ray: u64) -> Result<Cow<'_, [u32]>> {
        if ray >= self.rays.n_rays() {
            return Err(self.no_ray(ray));
        }
        match &self.content {
            Content::InMemory(_) => Ok(Cow::Borrowed(self.ray_in_memory(ray))),
            Content::InStore { pieces, .. } => {
                let entry = pieces.entries.partition_point(|entry| entry.end_ray() <= ray);
                let band = pieces.cached(&pieces.entries[entry])?;
                Ok(Cow::Owned(band.ray((ray - band.first_ray) as usize).to_vec()))
            }
        }
    }

    /// Runs of rays from one on that lie together in memory, those of at most `max_rays` rays and of at least one; and where the runs of
    /// each of these rays end in them.
    ///
    /// # Errors
    /// `job-value` where there is no such ray; `job-conflict` where the columns are in a store.
    pub fn together(&self, ray: u64, max_rays: usize) -> Result<(&[u32], impl ExactSizeIterator<Item = u64>)> {
        let Content::InMemory(bands) = &self.content else {
            return Err(Error::new(
                "job-conflict",
                "the columns are in a file, not in memory",
                "ask for one ray at a time",
            ));
        };
        if ray >= self.rays.n_rays() {
            return Err(self.no_ray(ray));
        }
        let band = &bands[bands.partition_point(|band| band.end_ray() <= ray)];
        Ok(band.together((ray - band.first_ray) as usize, max_rays.max(1)))
    }

    fn no_ray(&self, ray: u64) -> Error {
        Error::new("job-value", format!("ray {ray} of {}, counted from 0", self.rays.n_rays()), "")
    }

    /// Runs of a ray of columns in memory; none where they are not.
    #[doc(hidden)]
    pub fn ray_in_memory(&self, ray: u64) -> &[u32] {
        let Content::InMemory(bands) = &self.content else { return &[] };
        let band = &bands[bands.partition_point(|band| band.end_ray() <= ray)];
        band.ray((ray - band.first_ray) as usize)
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
        self.sum(PackedBand::n_runs, |totals| totals.n_runs)
    }

    /// Number of crossings that the rays had.
    pub fn n_crossings(&self) -> u64 {
        self.sum(|band| band.n_crossings, |totals| totals.n_crossings)
    }

    /// Rays that do not leave every geometry they enter.
    pub fn odd_rays(&self) -> u64 {
        self.sum(|band| band.odd_rays, |totals| totals.odd_rays)
    }

    /// Whether the runs are in a store outside memory.
    pub fn is_spilled(&self) -> bool {
        matches!(self.content, Content::InStore { .. })
    }

    /// Most bytes of an opened file that may be in memory at once; None for other columns.
    #[doc(hidden)]
    pub fn max_bytes(&self) -> Option<u64> {
        match &self.content {
            Content::InMemory(_) => None,
            Content::InStore { pieces, .. } => pieces.is_foreign.then_some(pieces.max_bytes),
        }
    }

    /// Bytes in memory.
    pub fn n_bytes(&self) -> u64 {
        match &self.content {
            Content::InMemory(bands) => bands.iter().map(PackedBand::n_bytes).sum(),
            Content::InStore { pieces, .. } => size_of_val(&*pieces.entries) as u64,
        }
    }

    /// Bytes in a store outside memory.
    pub fn spilled_bytes(&self) -> u64 {
        match &self.content {
            Content::InMemory(_) => 0,
            Content::InStore { pieces, .. } => pieces.n_bytes,
        }
    }

    /// Number of cells of every flag, 0 to 255.
    pub fn cells_per_flag(&self) -> [u64; 256] {
        let mut cells = *self.totals().cells;
        let flagged: u64 = cells.iter().sum();
        cells[0] += self.rays.n_rays() * u64::from(self.rays.depth) - flagged;
        cells
    }

    /// Counts what all rays hold.
    #[doc(hidden)]
    pub fn totals(&self) -> Totals {
        match &self.content {
            Content::InMemory(bands) => Totals::of(bands, self.rays.depth),
            Content::InStore { totals, .. } => totals.clone(),
        }
    }

    fn sum(&self, of_band: impl Fn(&PackedBand) -> u64, of_totals: impl Fn(&Totals) -> u64) -> u64 {
        match &self.content {
            Content::InMemory(bands) => bands.iter().map(of_band).sum(),
            Content::InStore { totals, .. } => of_totals(totals),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Columns {
        let rays = Rays::new(2, [2, 2, 10]);
        let first =
            Band { first_ray: 0, ends: vec![2, 2, 3], runs: vec![run(1, 7), run(4, 0), run(9, 1)], ..Band::default() };
        let second = Band { first_ray: 3, ends: vec![1], runs: vec![run(0, 2)], ..Band::default() };
        Columns::new(rays, vec![first, second]).unwrap()
    }

    #[test]
    fn bands_that_do_not_cover_all_rays_in_order_are_refused() {
        let band = |first_ray, n: u32| Band { first_ray, ends: vec![0; n as usize], ..Band::default() };
        let of = |bands| Columns::new(Rays::new(2, [2, 2, 10]), bands).map(|columns| columns.dims());
        assert_eq!(of(vec![band(0, 3), band(3, 1)]).unwrap(), [2, 2, 10]);
        let wrong = [
            (vec![band(0, 2), band(3, 1)], "begins with ray 3, after those up to ray 2"),
            (vec![band(1, 3)], "begins with ray 1, after those up to ray 0"),
            (vec![band(0, 3)], "the bands have 3 rays, and the columns 4"),
            (vec![band(0, 5)], "the bands have 5 rays, and the columns 4"),
        ];
        for (bands, sentence) in wrong {
            let error = of(bands).unwrap_err();
            assert!(error.code() == "job-conflict" && error.to_string().contains(sentence), "{error}");
        }
        let error = columns().ray(4).unwrap_err();
        assert_eq!((error.code(), error.to_string().as_str()), ("job-value", "ray 4 of 4, counted from 0"));
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
    fn runs_that_lie_together_are_those_of_one_band() {
        let columns = columns();
        let together = |ray, max_rays| {
            let (runs, ends) = columns.together(ray, max_rays).unwrap();
            (runs.to_vec(), ends.collect::<Vec<u64>>())
        };
        let [a, b, c, d] = [run(1, 7), run(4, 0), run(9, 1), run(0, 2)];
        assert_eq!(together(0, usize::MAX), (vec![a, b, c], vec![2, 2, 3]));
        assert_eq!(together(0, 2), (vec![a, b], vec![2, 2]));
        assert_eq!(together(1, 1), (vec![], vec![0]));
        assert_eq!(together(1, 9), (vec![c], vec![0, 1]));
        // there is always one
        assert_eq!(together(3, 0), (vec![d], vec![1]));
        assert_eq!(columns.together(4, 1).err().map(|error| error.code()), Some("job-value"));
    }

    #[test]
    fn every_cell_is_counted_once() {
        let cells = columns().cells_per_flag();
        assert_eq!([cells[0], cells[1], cells[2], cells[7]], [26, 1, 10, 3]);
        assert_eq!(cells.iter().sum::<u64>(), 40);
        let columns = columns();
        assert_eq!((columns.n_runs(), columns.spilled_bytes(), columns.max_bytes()), (4, 0, None));
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
        assert_eq!(Columns::new(columns().rays, vec![joined.clone()]).unwrap(), columns());
        assert_ne!(Columns::new(columns().rays, vec![other]).unwrap(), columns());
        let first = Band { runs: vec![run(2, 7), run(4, 0), run(9, 1), run(0, 2)], ..joined.clone() };
        assert_ne!(Columns::new(columns().rays, vec![first]).unwrap(), columns());
    }
}
