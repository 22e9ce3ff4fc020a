//! The overlay: decided geometries over the columns of the others.
//!
//! Bands whose runs carry rank + 1 for a flag, open geometries -> bands with the flags of the job. Of two geometries in a cell the
//! higher rank wins. Bands come in the order of their rays, as the backends hand them out.
//! Cost: one pass over the runs of all.

use super::part::{OpenPart, Surface};
use super::votes::{Rows, Through, Votes};
use crate::cast::Cast;
use crate::columns::Band;
use crate::geometry::Open;
use crate::lines::Lines;
use crate::parallel::*;

/// What was found of an open geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Index in the job.
    pub geometry: usize,
    /// How its cells were decided.
    pub policy: Open,
    /// What its surface lacks.
    pub surface: Surface,
    /// Rays along x, y and z that do not leave it as often as they enter.
    pub odd_rays: [u64; 3],
    /// Cells whose three rays are not all even, or do not agree.
    pub doubtful_cells: u64,
}

struct Laid {
    rank: u8,
    votes: Votes,
    through: Through,
    found: Found,
}

/// Open geometries, ready to be put over bands.
pub struct Overlay {
    geometries: Vec<Laid>,
    /// Flag of each code of a run: rank + 1, or 0.
    flags: Vec<u8>,
    n_b: u64,
}

impl Overlay {
    /// Casts the rays of three axes at open geometries, if there are any; `cast` is what [`super::part::split`] left, `flags` has the flag
    /// of each rank.
    pub fn new(parts: Vec<OpenPart>, cast: &Cast, flags: &[u8], lines: &Lines) -> Option<Overlay> {
        if parts.is_empty() {
            return None;
        }
        let geometry = |part: OpenPart| {
            let votes = Votes::new(&part, cast.frame, cast.rays, cast.rule, lines.spacing);
            let found = Found {
                geometry: cast.frame.ranks.geometry_of_rank[usize::from(part.rank)],
                policy: part.policy,
                surface: part.surface,
                odd_rays: votes.odd_rays,
                doubtful_cells: 0,
            };
            Laid { rank: part.rank, through: votes.start(), votes, found }
        };
        let flags = [&[0], flags].concat();
        let geometries = parts.into_iter().map(geometry).collect();
        Some(Overlay { geometries, flags, n_b: cast.rays.counts[0].into() })
    }

    /// Bytes that it holds.
    pub fn n_bytes(&self) -> u64 {
        self.geometries.iter().map(|laid| laid.votes.n_bytes()).sum()
    }

    /// What was found so far.
    pub fn found(self) -> Vec<Found> {
        self.geometries.into_iter().map(|laid| laid.found).collect()
    }

    /// Puts the geometries over the next bands, which follow each other; the first may begin within a row of rays.
    pub fn lay(&mut self, bands: Vec<Band>) -> Vec<Band> {
        let (Some(first), Some(last)) = (bands.first(), bands.last()) else { return bands };
        let end_ray = last.first_ray + last.ends.len() as u64;
        let (start, end) = ((first.first_ray / self.n_b) as u32, end_ray.div_ceil(self.n_b) as u32);
        let n_parts = (end - start).min(2 * current_num_threads() as u32);
        let part = |index: u32| start + (u64::from(end - start) * u64::from(index) / u64::from(n_parts)) as u32;
        let parts: Vec<_> = (0..n_parts).map(|index| part(index)..part(index + 1)).collect();
        let mut decided: Vec<Vec<Rows>> = Vec::new();
        for laid in &mut self.geometries {
            let mut starts = Vec::new();
            for planes in &parts {
                laid.votes.go_through(&mut laid.through, planes.start);
                starts.push((laid.through.clone(), planes.clone()));
            }
            let rows: Vec<Rows> =
                starts.into_par_iter().map(|(through, planes)| laid.votes.rows(through, planes)).collect();
            laid.found.doubtful_cells += rows.iter().map(|rows| rows.n_doubtful).sum::<u64>();
            decided.push(rows);
        }
        let lay = |band: Band| self.lay_one(band, &decided, &parts);
        bands.into_par_iter().map(lay).collect()
    }

    fn lay_one(&self, band: Band, decided: &[Vec<Rows>], parts: &[std::ops::Range<u32>]) -> Band {
        let rows =
            (band.first_ray / self.n_b) as u32..(band.first_ray + band.ends.len() as u64).div_ceil(self.n_b) as u32;
        let n_crossings = self.geometries.iter().map(|laid| laid.votes.n_crossings(&rows)).sum::<u64>();
        let mut laid = Band {
            first_ray: band.first_ray,
            ends: Vec::with_capacity(band.ends.len()),
            runs: Vec::with_capacity(band.runs.len()),
            odd_rays: band.odd_rays,
            n_crossings: band.n_crossings + n_crossings,
        };
        let (mut now, mut next) = (Vec::new(), Vec::new());
        for ray in 0..band.ends.len() {
            let index = band.first_ray + ray as u64;
            let row = (index / self.n_b) as u32;
            let part = parts.partition_point(|planes| planes.end <= row);
            now.clear();
            now.extend_from_slice(band.ray(ray));
            for (geometry, rows) in self.geometries.iter().zip(decided) {
                let over = &rows[part].band;
                next.clear();
                higher(&now, over.ray((index - over.first_ray) as usize), geometry.rank + 1, &mut next);
                std::mem::swap(&mut now, &mut next);
            }
            let mut flag = 0;
            for &run in &now {
                let own = self.flags[(run & 0xff) as usize];
                if own != flag {
                    laid.runs.push(run & !0xff | u32::from(own));
                    flag = own;
                }
            }
            laid.ends.push(laid.runs.len() as u32);
        }
        laid
    }
}

/// Runs that have, in every cell, the higher code of two lists; the flag 1 of the second stands for `code`.
fn higher(one: &[u32], other: &[u32], code: u8, out: &mut Vec<u32>) {
    let (mut of_one, mut of_other, mut last) = (0, 0, 0);
    let (mut i, mut j) = (0, 0);
    while i < one.len() || j < other.len() {
        let cell = [one.get(i), other.get(j)].into_iter().flatten().map(|run| run >> 8).min().unwrap_or(0);
        if let Some(run) = one.get(i).filter(|&&run| run >> 8 == cell) {
            of_one = run & 0xff;
            i += 1;
        }
        if let Some(run) = other.get(j).filter(|&&run| run >> 8 == cell) {
            of_other = (run & 0xff) * u32::from(code);
            j += 1;
        }
        let winner = of_one.max(of_other);
        if winner != last {
            out.push(cell << 8 | winner);
            last = winner;
        }
    }
}
