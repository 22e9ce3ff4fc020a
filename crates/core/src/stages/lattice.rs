//! The lattice: bins of the projection plane, each with the facets that a ray in it may hit.
//!
//! Snapped facets, rays, a bin size -> [`Lattice`]. A facet belongs to a bin iff its box covers a ray of the bin and, for
//! each edge, `q + max(0, A (w - 1)) + max(0, B (h - 1)) >= 0` where q is the edge function at the bin's first ray and
//! w x h the bin's rays: the corner of the bin that lies farthest inside the edge (Eq. 13-15), exact, on ray centres.
//!
//! Degenerate case: facets parallel to the rays belong to no bin. Source: the paper, section 2.3.
//! Twins: `shaders/lattice.wgsl`, `shared/items.wgsl`, `shared/walk.wgsl`, `shared/graded.wgsl`.
//! Cost: O(facets + bins of their boxes) time; 4 bytes a bin and 4 bytes a (facet, bin) pair.

use std::ops::Range;

use crate::base::parallel::*;
use crate::base::sort::by_number;
use crate::grid::frame::{Frame, SnappedFacet};
use crate::grid::rays::Rays;
use crate::stages::facet::Projected;

/// Facets that one core takes at a time.
const CHUNK: usize = 4096;

/// Facets of each bin of a band of bin rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lattice {
    /// Rays of a bin along each axis across; the last bin of a row or column may reach past the domain.
    pub bin: [u32; 2],
    /// Number of bins in a row.
    pub n_across: u32,
    /// The bin rows of this band.
    pub rows: Range<u32>,
    /// First entry of `facets` of each bin, then the end: `n_across * rows + 1` entries.
    pub offsets: Vec<u32>,
    /// Facet indices, bin after bin; ascending within a bin.
    pub facets: Vec<u32>,
}

impl Lattice {
    /// Facets of a bin, by position in the row and absolute bin row.
    pub fn bin_facets(&self, column: u32, row: u32) -> &[u32] {
        let bin = ((row - self.rows.start) * self.n_across + column) as usize;
        &self.facets[self.offsets[bin] as usize..self.offsets[bin + 1] as usize]
    }

    /// Number of bin rows that cover all rays.
    pub fn n_rows(rays: &Rays, bin: [u32; 2]) -> u32 {
        rays.counts[1].div_ceil(bin[1])
    }
}

/// Builds the lattice of a band of bin rows.
pub fn lattice(frame: &Frame, rays: &Rays, bin: [u32; 2], rows: Range<u32>) -> Lattice {
    let n_across = rays.counts[0].div_ceil(bin[0]);
    let n_bins = (n_across * (rows.end - rows.start)) as usize;
    // pairs of a chunk of facets in order, so that the counting sort below keeps facets ascending within a bin
    let pairs_of_chunk = |(chunk, corners): (usize, &[SnappedFacet])| {
        let mut pairs = Vec::new();
        for (facet, corners) in (chunk * CHUNK..).zip(corners) {
            if let Some(projected) = Projected::new(corners, frame, rays) {
                for_each_bin(&projected, (frame, rays), bin, &rows, |bin| pairs.push((bin, facet as u32)));
            }
        }
        pairs
    };
    let chunks: Vec<Vec<(u32, u32)>> =
        on_all_cores(|| frame.facets.par_chunks(CHUNK).enumerate().map(pairs_of_chunk).collect());
    let (mut offsets, mut facets) = (Vec::new(), Vec::new());
    by_number(chunks.iter().flatten().copied(), n_bins, &mut offsets, &mut facets);
    Lattice { bin, n_across, rows, offsets, facets }
}

/// Calls `found` with the index in the band of every bin that the facet overlaps.
#[inline(always)]
fn for_each_bin(
    facet: &Projected,
    (frame, rays): (&Frame, &Rays),
    bin: [u32; 2],
    rows: &Range<u32>,
    mut found: impl FnMut(u32),
) {
    let n_across = rays.counts[0].div_ceil(bin[0]);
    let columns = facet.rays[0].map(|ray| ray / bin[0]);
    let first_row = (facet.rays[1][0] / bin[1]).max(rows.start);
    let last_row = (facet.rays[1][1] / bin[1] + 1).min(rows.end);
    for row in first_row..last_row {
        let down = ends_of_bin(facet, (frame, rays), 1, row * bin[1], bin[1]);
        for column in columns[0]..=columns[1] {
            let across = ends_of_bin(facet, (frame, rays), 0, column * bin[0], bin[0]);
            let farthest = |e: usize| {
                let of = |step: i64, ends: [i64; 2]| (step * ends[0]).max(step * ends[1]);
                facet.q[e] + of(facet.a[e], across) + of(facet.b[e], down)
            };
            if (0..3).all(|edge| farthest(edge) >= 0) {
                found((row - rows.start) * n_across + column);
            }
        }
    }
}

/// How far the first and the last ray of a bin are from the first of a facet, in steps of its edge functions.
#[inline(always)]
fn ends_of_bin(facet: &Projected, (frame, rays): (&Frame, &Rays), side: usize, first: u32, n: u32) -> [i64; 2] {
    let from = facet.rays[side][0];
    if !frame.is_graded() {
        let start = i64::from(first) - i64::from(from);
        return [start, start + i64::from(n - 1)];
    }
    let centre = |ray: u32| i64::from(frame.centre(rays.across[side], ray));
    [first, (first + n).min(rays.counts[side]) - 1].map(|ray| centre(ray) - centre(from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::lines::Lines;
    use crate::input::geometry::Geometry;

    #[test]
    fn a_triangle_is_in_the_bins_it_overlaps_and_no_other() {
        let corners = [[0.0, 0.0, 1.0], [16.0, 0.0, 1.0], [0.0, 16.0, 1.0]];
        let lines = Lines::new([0.0; 3], [1.0; 3], [16, 16, 4]).unwrap();
        let frame = Frame::new(&[Geometry::new("t", 1, vec![corners]).unwrap()], &lines).unwrap();
        let rays = Rays::new(2, lines.dims());
        let lattice = lattice(&frame, &rays, [4, 4], 0..4);
        for row in 0..4 {
            for column in 0..4 {
                let expected = usize::from(column + row <= 3);
                assert_eq!(lattice.bin_facets(column, row).len(), expected, "bin {column}, {row}");
            }
        }
    }

    #[test]
    fn bands_of_rows_are_parts_of_the_whole() {
        let corners = [[0.5, 0.3, 1.0], [15.0, 3.0, 1.0], [2.0, 14.0, 1.0]];
        let lines = Lines::new([0.0; 3], [1.0; 3], [16, 16, 4]).unwrap();
        let frame = Frame::new(&[Geometry::new("t", 1, vec![corners; 3]).unwrap()], &lines).unwrap();
        let rays = Rays::new(2, lines.dims());
        let whole = lattice(&frame, &rays, [4, 2], 0..8);
        let part = lattice(&frame, &rays, [4, 2], 3..6);
        for row in 3..6 {
            for column in 0..4 {
                assert_eq!(whole.bin_facets(column, row), part.bin_facets(column, row));
            }
        }
    }
}
