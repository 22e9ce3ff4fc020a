//! Splicing: some rays of columns get other runs, and what that changes is listed.
//!
//! Columns, runs of some rays -> columns, [`ChangedRun`]s. Bands without such a ray stay as they are; the others are packed again, in
//! bands of at most twice [`PIECE_RAYS`] rays, so that the next splice touches less.
//! Cost: the rays and runs of the bands that are touched; clones keep theirs, and share the others.

use std::ops::Range;
use std::sync::Arc;

use super::codec::PIECE_RAYS;
use super::packed_band::PackedBand;
use super::run::{Band, run_cell, run_flag};
use super::{Columns, Content};
use crate::base::error::{Error, Result};
use crate::base::parallel::*;

/// Consecutive cells of a ray that had one flag and have another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub struct ChangedRun {
    /// Index of the ray.
    pub ray: u64,
    /// First cell.
    pub start: u32,
    /// The cell after the last.
    pub end: u32,
    /// The flag that they had.
    pub before: u8,
    /// The flag that they have.
    pub after: u8,
}

/// Runs of some rays.
#[derive(Debug, Default)]
pub struct SomeRuns {
    /// Indices of the rays, ascending.
    pub(crate) rays: Vec<u64>,
    /// End in `runs` of the runs of each.
    pub(crate) ends: Vec<u32>,
    /// Runs, ray after ray.
    pub(crate) runs: Vec<u32>,
}

impl SomeRuns {
    /// Number of rays.
    pub fn n_rays(&self) -> u64 {
        self.rays.len() as u64
    }

    /// The rays from one to another, by their places in the list, with their runs.
    fn rays_of(&self, places: Range<usize>) -> impl Iterator<Item = (u64, &[u32])> {
        places.map(|at| {
            let start = if at == 0 { 0 } else { self.ends[at - 1] };
            (self.rays[at], &self.runs[start as usize..self.ends[at] as usize])
        })
    }

    /// Where the rays of a band are in the list.
    fn places(&self, band: &PackedBand) -> Range<usize> {
        let before = |ray: u64| self.rays.partition_point(|&other| other < ray);
        before(band.first_ray)..before(band.end_ray())
    }
}

impl Columns {
    /// Gives some rays other runs, after which all rays have so many crossings and none is odd; returns what that changes, in the order of rays
    /// and cells.
    ///
    /// # Errors
    /// `job-conflict` where the columns are in a store.
    #[doc(hidden)]
    pub fn splice(&mut self, some: &SomeRuns, n_crossings: u64) -> Result<Vec<ChangedRun>> {
        let Content::InMemory(shared) = &mut self.content else {
            return Err(Error::new("job-conflict", "the columns are in a file, not in memory", "mesh again"));
        };
        let bands = Arc::unwrap_or_clone(std::mem::take(shared));
        let depth = self.rays.depth;
        let of_band = |band: PackedBand| match some.places(&band) {
            places if places.is_empty() => (vec![band], Vec::new()),
            places => spliced(&band, some, places, depth),
        };
        let pieces: Vec<_> = bands.into_par_iter().map(of_band).collect();
        let (bands, changed): (Vec<_>, Vec<_>) = pieces.into_iter().unzip();
        let mut bands: Vec<PackedBand> = bands.into_iter().flatten().collect();
        // the columns tell their sum alone
        for (index, band) in bands.iter_mut().enumerate() {
            (band.n_crossings, band.odd_rays) = (if index == 0 { n_crossings } else { 0 }, 0);
        }
        *shared = Arc::new(bands);
        Ok(changed.concat())
    }

    /// Lists what other columns of the same rays have in place of the flags of these, in the order of rays and cells.
    ///
    /// # Errors
    /// `job-conflict` where the rays differ; `io` where columns are in a store that fails.
    pub fn changed_runs(&self, other: &Columns) -> Result<Vec<ChangedRun>> {
        if self.rays != other.rays {
            return Err(Error::new("job-conflict", "the columns have other rays", "compare columns of the same box"));
        }
        let n_rays = self.rays.n_rays();
        let mut changed = Vec::new();
        for first in (0..n_rays).step_by(PIECE_RAYS as usize) {
            let rays = first..n_rays.min(first + u64::from(PIECE_RAYS));
            let mut before = SomeRuns::default();
            self.for_rays(rays.clone(), |runs| {
                before.runs.extend_from_slice(runs);
                before.ends.push(before.runs.len() as u32);
            })?;
            before.rays.extend(rays.clone());
            let mut of_before = before.rays_of(0..before.rays.len());
            other.for_rays(rays, |after| {
                if let Some((ray, before)) = of_before.next() {
                    add_changed(ray, before, after, self.rays.depth, &mut changed);
                }
            })?;
        }
        Ok(changed)
    }
}

/// A band with other runs of some of its rays, and what that changes.
fn spliced(band: &PackedBand, some: &SomeRuns, places: Range<usize>, depth: u32) -> (Vec<PackedBand>, Vec<ChangedRun>) {
    let n_rays = band.n_rays() as usize;
    let rays_of_piece = if n_rays < 2 * PIECE_RAYS as usize { n_rays } else { PIECE_RAYS as usize };
    let (mut pieces, mut changed) = (Vec::new(), Vec::new());
    let mut next = some.rays_of(places).peekable();
    let mut piece = Band { first_ray: band.first_ray, ..Band::default() };
    for (ray, before) in (band.first_ray..).zip(band.rays_from(0)) {
        let runs = match next.next_if(|(other, _)| *other == ray) {
            Some((_, after)) => {
                add_changed(ray, before, after, depth, &mut changed);
                after
            }
            None => before,
        };
        piece.runs.extend_from_slice(runs);
        piece.ends.push(piece.runs.len() as u32);
        if piece.ends.len() == rays_of_piece {
            let after = Band { first_ray: ray + 1, ..Band::default() };
            pieces.push(PackedBand::new(std::mem::replace(&mut piece, after)));
        }
    }
    if !piece.ends.is_empty() {
        pieces.push(PackedBand::new(piece));
    }
    (pieces, changed)
}

/// Appends the cells of a ray whose flags differ before and after.
fn add_changed(ray: u64, before: &[u32], after: &[u32], depth: u32, changed: &mut Vec<ChangedRun>) {
    let (mut before, mut after) = (before.iter().peekable(), after.iter().peekable());
    let (mut start, mut from, mut to) = (0, 0, 0);
    loop {
        let cell = |run: Option<&&u32>| run.map_or(depth, |run| run_cell(**run));
        let end = cell(before.peek()).min(cell(after.peek())).min(depth);
        if from != to && start < end {
            changed.push(ChangedRun { ray, start, end, before: from, after: to });
        }
        if end == depth {
            return;
        }
        start = end;
        from = before.next_if(|run| run_cell(**run) == end).map_or(from, |run| run_flag(*run));
        to = after.next_if(|run| run_cell(**run) == end).map_or(to, |run| run_flag(*run));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::columns::run;
    use crate::grid::rays::Rays;

    /// Columns of 3 x 3 rays of 10 cells in bands of 4 rays: ray r has flag 1 from cell r on.
    fn columns() -> Columns {
        let band = |first_ray: u64, n: u32| Band {
            first_ray,
            ends: (1..=n).collect(),
            runs: (0..n).map(|ray| run(first_ray as u32 + ray, 1)).collect(),
            odd_rays: 0,
            n_crossings: 5,
        };
        Columns::new(Rays::new(2, [3, 3, 10]), vec![band(0, 4), band(4, 4), band(8, 1)]).unwrap()
    }

    fn changed(ray: u64, [start, end]: [u32; 2], [before, after]: [u8; 2]) -> ChangedRun {
        ChangedRun { ray, start, end, before, after }
    }

    #[test]
    fn rays_get_other_runs_and_what_changes_is_listed() {
        let (before, mut after) = (columns(), columns());
        let runs = vec![run(0, 2), run(5, 0), run(7, 1), run(8, 1)];
        let some = SomeRuns { rays: vec![3, 4, 8], ends: vec![3, 3, 4], runs };
        let found = after.splice(&some, 7).unwrap();
        let expected = vec![
            changed(3, [0, 3], [0, 2]),
            changed(3, [3, 5], [1, 2]),
            changed(3, [5, 7], [1, 0]),
            changed(4, [4, 10], [1, 0]),
        ];
        assert_eq!(found, expected);
        assert_eq!((after.n_crossings(), after.odd_rays()), (7, 0));
        let rays: Vec<Vec<u32>> = (0..9).map(|ray| after.ray(ray).unwrap().into_owned()).collect();
        assert_eq!(rays[3], some.runs[..3]);
        assert_eq!((&rays[4][..], &rays[5][..], &rays[8][..]), (&[][..], &[run(5, 1)][..], &[run(8, 1)][..]));
        assert_eq!(before.changed_runs(&after).unwrap(), expected);
        assert_eq!(before, columns());
    }

    #[test]
    fn long_bands_are_cut_in_pieces() {
        let n = 2 * PIECE_RAYS + 5;
        let rays = Rays::new(2, [n, 1, 4]);
        let band = Band { ends: (1..=n).collect(), runs: vec![run(1, 3); n as usize], ..Band::default() };
        let mut columns = Columns::new(rays, vec![band]).unwrap();
        let last = u64::from(n) - 1;
        let some = SomeRuns { rays: vec![0, last], ends: vec![0, 1], runs: vec![run(2, 3)] };
        let found = columns.splice(&some, 0).unwrap();
        assert_eq!(found, [changed(0, [1, 4], [3, 0]), changed(last, [1, 2], [3, 0])]);
        assert_eq!(columns.n_runs(), u64::from(n) - 1);
        assert_eq!(
            (columns.ray(1).unwrap().to_vec(), columns.ray(last).unwrap().to_vec()),
            (vec![run(1, 3)], vec![run(2, 3)])
        );
    }

    #[test]
    fn columns_of_other_rays_are_not_compared() {
        let other = Columns::new(Rays::new(2, [9, 1, 10]), vec![Band { ends: vec![0; 9], ..Band::default() }]).unwrap();
        assert_eq!(columns().changed_runs(&other).unwrap_err().code(), "job-conflict");
    }
}
