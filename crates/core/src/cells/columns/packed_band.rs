//! A packed band: the runs of consecutive rays, in memory, with a compact index.
//!
//! The index holds a byte a ray, its number of runs, and for every [`BLOCK`] rays the offset of their runs. A ray with [`WIDE`] runs
//! or more is also in a list of wide rays. The runs of any ray are found by adding at most [`BLOCK`] - 1 bytes, those of the next
//! ray by adding one.
//! Cost in memory: 4 bytes a run and 1.07 bytes a ray.

use std::sync::Arc;

use super::run::{Band, run_cell, run_flag};
use crate::base::parallel::*;

/// Rays of a block.
const BLOCK: usize = 64;
/// The count of a ray in the list of wide rays.
const WIDE: u32 = 255;
/// Rays that one core takes at a time; whole blocks.
const CHUNK: usize = 256 * BLOCK;

/// Runs of consecutive rays, which clones share.
#[derive(Debug, Clone, Default)]
pub(crate) struct PackedBand {
    /// Index of the first ray.
    pub(crate) first_ray: u64,
    /// Rays that do not leave every geometry they enter.
    pub(crate) odd_rays: u64,
    /// Number of crossings of the rays.
    pub(crate) n_crossings: u64,
    packed: Arc<Packed>,
}

/// What the clones of a band share.
#[derive(Debug, Default)]
struct Packed {
    /// Offset in `runs` of the runs of every block of rays.
    bases: Vec<u32>,
    /// Number of runs of each ray, at most [`WIDE`].
    counts: Vec<u8>,
    /// Rays with [`WIDE`] runs and more: the ray, and how many more.
    wide: Vec<(u32, u32)>,
    /// Runs, ray after ray.
    runs: Vec<u32>,
}

impl Packed {
    /// Number of runs of a ray, counted from the first of the band.
    #[inline(always)]
    fn count(&self, ray: usize) -> usize {
        match u32::from(self.counts[ray]) {
            WIDE => {
                let index = self.wide.partition_point(|&(other, _)| (other as usize) < ray);
                (WIDE + self.wide[index].1) as usize
            }
            count => count as usize,
        }
    }

    /// Offset in `runs` of the runs of a ray.
    fn start(&self, ray: usize) -> usize {
        let block = ray / BLOCK;
        let before = block * BLOCK..ray;
        let sum: u32 = self.counts[before.clone()].iter().map(|&count| u32::from(count)).sum();
        let first_wide = self.wide.partition_point(|&(other, _)| (other as usize) < before.start);
        let wide = self.wide[first_wide..].iter().take_while(|&&(other, _)| (other as usize) < ray);
        (self.bases[block] + sum + wide.map(|(_, more)| more).sum::<u32>()) as usize
    }
}

impl PackedBand {
    /// Packs the index of a band; the runs are taken as they are.
    pub(crate) fn new(band: Band) -> PackedBand {
        let Band { first_ray, ends, runs, odd_rays, n_crossings } = band;
        let mut counts = vec![0u8; ends.len()];
        let chunks = counts.par_chunks_mut(CHUNK).zip(ends.par_chunks(CHUNK)).enumerate();
        let wide = chunks.map(|(chunk, (counts, chunk_ends))| {
            let first = chunk * CHUNK;
            let mut start = if first == 0 { 0 } else { ends[first - 1] };
            let mut wide = Vec::new();
            for (index, (count, &end)) in counts.iter_mut().zip(chunk_ends).enumerate() {
                *count = (end - start).min(WIDE) as u8;
                if end - start >= WIDE {
                    wide.push(((first + index) as u32, end - start - WIDE));
                }
                start = end;
            }
            wide
        });
        let wide = wide.collect::<Vec<_>>().concat();
        let bases = (0..ends.len()).step_by(BLOCK).map(|ray| if ray == 0 { 0 } else { ends[ray - 1] }).collect();
        PackedBand { first_ray, odd_rays, n_crossings, packed: Arc::new(Packed { bases, counts, wide, runs }) }
    }

    /// Number of rays.
    pub(crate) fn n_rays(&self) -> u64 {
        self.packed.counts.len() as u64
    }

    /// Index of the ray after the last.
    pub(crate) fn end_ray(&self) -> u64 {
        self.first_ray + self.n_rays()
    }

    /// Number of runs.
    pub(crate) fn n_runs(&self) -> u64 {
        self.packed.runs.len() as u64
    }

    /// Bytes held in memory.
    pub(crate) fn n_bytes(&self) -> u64 {
        let Packed { bases, counts, wide, runs } = &*self.packed;
        (4 * bases.capacity() + counts.capacity() + 8 * wide.capacity() + 4 * runs.capacity()) as u64
    }

    /// Runs of a ray, counted from the first of the band.
    pub(crate) fn ray(&self, ray: usize) -> &[u32] {
        let packed = &*self.packed;
        let start = packed.start(ray);
        &packed.runs[start..start + packed.count(ray)]
    }

    /// Runs of the rays from one on, counted from the first of the band; cheaper than asking for each.
    pub(crate) fn rays_from(&self, ray: usize) -> impl Iterator<Item = &[u32]> {
        let packed = &*self.packed;
        let mut next = if ray < packed.counts.len() { packed.start(ray) } else { packed.runs.len() };
        (ray..packed.counts.len()).map(move |ray| {
            let start = next;
            next += packed.count(ray);
            &packed.runs[start..next]
        })
    }

    /// Runs of at most `max_rays` rays from one on, counted from the first of the band, and where those of each end in them.
    pub(crate) fn together(&self, ray: usize, max_rays: usize) -> (&[u32], impl ExactSizeIterator<Item = u64>) {
        let packed = &*self.packed;
        let rays = ray..packed.counts.len().min(ray.saturating_add(max_rays));
        let start = packed.start(ray);
        let n_runs: usize = rays.clone().map(|ray| packed.count(ray)).sum();
        let mut end = 0;
        let ends = rays.map(move |ray| {
            end += packed.count(ray) as u64;
            end
        });
        (&packed.runs[start..start + n_runs], ends)
    }

    /// Number of cells of every flag that the runs name; cells before the first run of a ray are not counted.
    pub(crate) fn cells_per_flag(&self, depth: u32) -> [u64; 256] {
        let mut cells = [0; 256];
        for runs in self.rays_from(0) {
            let mut end = depth;
            for &run in runs.iter().rev() {
                cells[usize::from(run_flag(run))] += u64::from(end - run_cell(run));
                end = run_cell(run);
            }
        }
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ray_is_found_whatever_the_number_of_its_runs() {
        // around the sizes of blocks, chunks and bytes
        let count = |ray: u32| match ray {
            63 => 254,
            64 => 255,
            70 | 16_384 => 256,
            16_390 => 70_000,
            _ => ray * 7 % 5,
        };
        let mut band = Band { first_ray: 9, ..Band::default() };
        for ray in 0..40_000 {
            band.runs.extend((0..count(ray)).map(|k| ray << 12 ^ k));
            band.ends.push(band.runs.len() as u32);
        }
        let packed = PackedBand::new(band.clone());
        assert_eq!((packed.n_rays(), packed.end_ray(), packed.n_runs()), (40_000, 40_009, band.runs.len() as u64));
        for ray in 0..40_000 {
            assert_eq!(packed.ray(ray), band.ray(ray), "ray {ray}");
        }
        for from in [0, 1, 63, 64, 65, 71, 16_383, 16_391, 39_999, 40_000] {
            let found: Vec<&[u32]> = packed.rays_from(from).collect();
            let expected: Vec<&[u32]> = (from..40_000).map(|ray| band.ray(ray)).collect();
            assert_eq!(found, expected, "from ray {from}");
            for n in [1usize, 2, 64, 16_390, usize::MAX] {
                let expected = &expected[..expected.len().min(n)];
                if from < 40_000 {
                    let (runs, ends) = packed.together(from, n);
                    let ends: Vec<u64> = ends.collect();
                    let starts = [0].into_iter().chain(ends.iter().copied());
                    let rays = starts.zip(&ends).map(|(start, &end)| &runs[start as usize..end as usize]);
                    assert!(rays.eq(expected.iter().copied()), "{n} rays from {from}");
                    assert_eq!(runs.len(), expected.iter().map(|of| of.len()).sum::<usize>());
                }
            }
        }
        let index = packed.n_bytes() - 4 * band.runs.len() as u64;
        // a byte a ray, four a block of 64 rays, eight for each of the four rays of 255 runs and more
        assert_eq!(index, 40_000 + 4 * 625 + 8 * 4);
    }
}
