//! The `repr(C)` twins of the structs in the shaders. A test compares them with what naga reads from the WGSL.

use std::ops::Range;

use super::line::Cast;
pub(crate) use crate::estimate::bands::{BIN, FACET_WORDS};
use crate::frame::{Frame, SnappedFacet};
use crate::map::Rule;
use crate::rays::Rays;

/// The numbers of one band; `Params` in `shaders/shared/params.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Params {
    /// F: a cell is 2^F units.
    pub fraction_bits: u32,
    /// Ray axis: 0, 1 or 2.
    pub axis: u32,
    /// Cells of a ray.
    pub depth: u32,
    /// Rays along the first axis across.
    pub n_i: u32,
    /// Rays along the second axis across, of the whole domain.
    pub n_j: u32,
    /// First ray row of the band.
    pub first_row: u32,
    /// End of the band's ray rows.
    pub end_row: u32,
    /// Bins in a row of bins.
    pub n_across: u32,
    /// Bins of the band.
    pub n_bins: u32,
    /// Facets that rays of the band may hit.
    pub n_facets: u32,
    /// (facet, bin) pairs that the buffers hold.
    pub pair_capacity: u32,
    /// Crossings that the buffer holds.
    pub event_capacity: u32,
    /// 0 parity, 1 nonzero.
    pub rule: u32,
    /// Geometries.
    pub n_ranks: u32,
    /// Padding to a multiple of 16 bytes.
    pub unused: [u32; 2],
}

impl Params {
    /// Describes a band of ray rows with so many facets, and buffers for so many pairs and crossings.
    pub(crate) fn new(cast: &Cast, rows: &Range<u32>, [n_facets, pairs, events]: [u32; 3]) -> Params {
        let Cast { frame, rays, rule } = *cast;
        let n_across = rays.counts[0].div_ceil(BIN);
        Params {
            fraction_bits: frame.fraction_bits,
            axis: rays.axis as u32,
            depth: rays.depth,
            n_i: rays.counts[0],
            n_j: rays.counts[1],
            first_row: rows.start,
            end_row: rows.end,
            n_across,
            n_bins: n_across * (rows.end - rows.start).div_ceil(BIN),
            n_facets,
            pair_capacity: pairs,
            event_capacity: events,
            rule: match rule {
                Rule::Parity => 0,
                Rule::Nonzero => 1,
            },
            n_ranks: frame.ranks.flag_of_rank.len() as u32,
            unused: [0; 2],
        }
    }

    /// Rows of rays of the band's bins.
    pub(crate) fn n_chunks(&self) -> u64 {
        u64::from(self.end_row - self.first_row) * u64::from(self.n_across)
    }

    /// Rays of the band.
    pub fn n_rays(&self) -> u32 {
        (self.end_row - self.first_row) * self.n_i
    }
}

/// Packs the facets whose boxes reach rays of some rows for the `corners` buffer: four words an axis, in the order (across,
/// across, along), which are its places of the three corners and, the first time, the rank. For all rows these are all facets.
pub(crate) fn corners(frame: &Frame, rays: &Rays, rows: &Range<u32>) -> Vec<i32> {
    use crate::parallel::*;
    let height = |row: u32| (row as i32) << frame.fraction_bits;
    let (low, high) = (height(rows.start), height(rows.end - 1));
    let is_whole = rows.len() as u32 == rays.counts[1];
    let reaches = |facet: &SnappedFacet| {
        let [a, b, c] = facet.map(|corner| corner[rays.across[1]]);
        is_whole || (a.min(b).min(c) <= high && a.max(b).max(c) >= low)
    };
    let chosen: Vec<usize> =
        (0..frame.facets.len()).into_par_iter().filter(|&index| reaches(&frame.facets[index])).collect();
    let mut words = vec![0; chosen.len() * FACET_WORDS];
    words.par_chunks_mut(FACET_WORDS).zip(&chosen).for_each(|(words, &index)| {
        let corners = frame.facets[index].map(|corner| rays.project(corner));
        for axis in 0..3 {
            words[4 * axis..4 * axis + 3].copy_from_slice(&corners.map(|corner| corner[axis]));
        }
        words[3] = i32::from(frame.rank_of_facet[index]);
    });
    words
}

/// Packs the flag of each rank, four a word, for the `flag_of_rank` uniform.
pub(crate) fn flag_words(flag_of_rank: &[u8]) -> [u32; 64] {
    let mut words = [0; 64];
    for (rank, &flag) in flag_of_rank.iter().enumerate() {
        words[rank / 4] |= u32::from(flag) << (8 * (rank % 4));
    }
    words
}
