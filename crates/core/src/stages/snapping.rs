//! Snapping in steps, and the facts that depend on all facets of a surface: whether it is closed, its ends, and the bound of
//! its volume.
//!
//! Geometries, lines, rays -> [`Snapped`]. The frame has all facets, or only those whose boxes contain a ray: no ray hits the
//! others. So a fine surface in a coarse mesh loses nearly all of its facets here.
//!
//! Cost: some 70 ns per facet on one core; 38 bytes per facet that stays, and for a moment 12 bytes per facet of one geometry.

use crate::base::error::Result;
use crate::base::parallel::*;
use crate::grid::closed::{CHUNK, Closed, EdgeHashes, Hashes};
use crate::grid::frame::{Ends, Frame, SnappedFacet, too_many_ranks};
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::grid::volume_bound::{self, BoundSums};
use crate::input::geometry::{Facet, Geometry};
use crate::input::job::Rule;
use crate::stages::facet::rays_under;

/// Facets of a step: some tens of milliseconds. A multiple of those that sums take together.
pub const FACETS_AT_ONCE: usize = 1 << 18;
/// A frame, and what is known of all facets of each geometry, in the order of positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapped {
    /// The facets that stay.
    pub frame: Frame,
    /// What the edges say.
    pub closed: Vec<Closed>,
    /// Least and greatest coordinates; None without facets.
    pub ends: Vec<Ends>,
    /// What the bound of the volume is made of.
    pub bound_sums: Vec<BoundSums>,
}

impl Snapped {
    /// Moves what is not closed before all that is and has the same priority; shells and what is flat stay, which have no cells within.
    fn put_open_lower(&mut self, geometries: &[Geometry], rule: Rule) {
        let Snapped { frame, closed, ends, bound_sums } = self;
        let key = |position: usize| {
            let geometry = &geometries[frame.ranks.geometry_at[position]];
            let is_flat = ends[position].is_none_or(|[low, high]| (0..3).any(|axis| low[axis] == high[axis]));
            (geometry.priority, geometry.shell || is_flat || closed[position].by(rule))
        };
        if (0..closed.len()).is_sorted_by_key(key) {
            return;
        }
        let mut order: Vec<usize> = (0..closed.len()).collect();
        order.sort_by_key(|&position| key(position));
        let n_facets = |position: usize| frame.range_at(position).len();
        let new_position = (0..).zip(&order).flat_map(|(to, &from)| std::iter::repeat_n(to, n_facets(from)));
        let position_of_facet = new_position.collect();
        let facets = order.iter().flat_map(|&from| frame.facets_at(from)).copied().collect();
        (frame.facets, frame.position_of_facet) = (facets, position_of_facet);
        frame.ranks.put_in_order(&order, geometries);
        *closed = order.iter().map(|&from| closed[from]).collect();
        *ends = order.iter().map(|&from| ends[from]).collect();
        *bound_sums = order.iter().map(|&from| bound_sums[from]).collect();
    }
}

/// Snaps the facets of geometries, in steps.
pub struct Snapping<'a> {
    geometries: &'a [Geometry],
    lines: &'a Lines,
    rays: Option<&'a Rays>,
    next_facet: usize,
    n_taken: usize,
    n_all: usize,
    edges: EdgeHashes,
    snapped: Snapped,
}

impl<'a> Snapping<'a> {
    /// Starts with no facet snapped; all stay, or those that rays may hit if these are given.
    ///
    /// # Errors
    /// Those of [`Frame::new`].
    pub fn new(geometries: &'a [Geometry], lines: &'a Lines, rays: Option<&'a Rays>) -> Result<Snapping<'a>> {
        let frame = Frame::without_facets(geometries, lines)?;
        let n = geometries.len();
        let (ends, bound_sums) = (vec![None; n], vec![BoundSums::default(); n]);
        let snapped = Snapped { frame, closed: Vec::new(), ends, bound_sums };
        let n_all = geometries.iter().map(|geometry| geometry.facets.len()).sum();
        let (next_facet, n_taken, edges) = (0, 0, EdgeHashes::default());
        Ok(Snapping { geometries, lines, rays, next_facet, n_taken, n_all, edges, snapped })
    }

    /// Does a part of the work; false once all is done.
    pub fn step(&mut self) -> bool {
        let start = self.n_taken;
        loop {
            let position = self.snapped.closed.len();
            let Some(&index) = self.snapped.frame.ranks.geometry_at.get(position) else { return false };
            let geometry = &self.geometries[index];
            if self.next_facet < geometry.facets.len() {
                let end = geometry.facets.len().min(self.next_facet + FACETS_AT_ONCE);
                self.take(position, geometry, &geometry.facets[self.next_facet..end]);
                self.next_facet = end;
            } else if let Some(closed) = self.edges.step() {
                self.snapped.closed.push(closed);
                (self.edges, self.next_facet) = (EdgeHashes::default(), 0);
            } else {
                return true;
            }
            if self.n_taken - start >= FACETS_AT_ONCE {
                return true;
            }
        }
    }

    /// Facets for which there is room.
    pub fn n_stay(&self) -> usize {
        self.snapped.frame.facets.capacity()
    }

    /// What was made, once all is done. Of equal priority the geometries that are closed by this rule win over those that are not: what an open
    /// surface encloses is an estimate, which may reach far beyond it.
    ///
    /// # Errors
    /// `too-many-geometries` where too many lie over one another.
    pub fn finish(mut self, rule: Rule) -> Result<Snapped> {
        self.snapped.frame.facets.shrink_to_fit();
        self.snapped.put_open_lower(self.geometries, rule);
        let Snapped { frame, closed, ends, .. } = &mut self.snapped;
        let shared = frame.ranks.share(self.geometries, ends, |position| closed[position].nonzero);
        shared.map_err(|_| too_many_ranks(self.geometries.len()))?;
        Ok(self.snapped)
    }

    /// Snaps facets, and does all that needs every one of them while the cache of a core has them.
    fn take(&mut self, position: usize, geometry: &Geometry, facets: &[Facet]) {
        let Snapped { frame, ends, bound_sums, .. } = &mut self.snapped;
        let snap = frame.snapping(geometry, self.lines);
        let of_chunk = |facets: &[Facet]| OfChunk::new(facets.iter().map(&snap).collect(), frame, self.rays);
        let chunks: Vec<OfChunk> = facets.par_chunks(CHUNK).map(of_chunk).collect();
        self.n_taken += facets.len();
        let n_staying = chunks.iter().map(|chunk| chunk.staying.len()).sum();
        make_room(&mut frame.facets, n_staying, self.n_taken as f64 / self.n_all as f64);
        for chunk in chunks {
            ends[position] = chunk.ends.iter().flatten().fold(ends[position], with_corner);
            bound_sums[position] = chunk.bound_sums.into_iter().fold(bound_sums[position], BoundSums::plus);
            frame.facets.extend_from_slice(&chunk.staying);
            self.edges.add(chunk.hashes);
        }
        frame.position_of_facet.resize(frame.facets.len(), position as u16);
    }
}

/// What is known of the facets that a core takes at a time.
struct OfChunk {
    staying: Vec<SnappedFacet>,
    ends: Ends,
    /// Of parts that do not depend on the number of threads.
    bound_sums: Vec<BoundSums>,
    hashes: Hashes,
}

impl OfChunk {
    fn new(mut facets: Vec<SnappedFacet>, frame: &Frame, rays: Option<&Rays>) -> OfChunk {
        let hashes = Hashes::new(&facets);
        let ends = facets.as_flattened().iter().fold(None, with_corner);
        // there is no bound for cells that differ in size
        let bounded = if frame.is_graded() { &[][..] } else { &facets[..] };
        let parts = bounded.chunks(volume_bound::CHUNK);
        let bound_sums = parts.map(|part| BoundSums::of(part, frame.fraction_bits)).collect();
        if let Some(rays) = rays {
            facets.retain(|facet| rays_under(facet, frame, rays).is_some());
        }
        OfChunk { staying: facets, ends, bound_sums, hashes }
    }
}

/// Least and greatest coordinates with those of one more corner.
#[inline(always)]
fn with_corner(ends: Ends, corner: &[i32; 3]) -> Ends {
    let [mut low, mut high] = ends.unwrap_or([*corner; 2]);
    for axis in 0..3 {
        low[axis] = low[axis].min(corner[axis]);
        high[axis] = high[axis].max(corner[axis]);
    }
    Some([low, high])
}

/// Makes room for more facets of which this share was looked at: for as many in all as that share lets expect, as twice the room would be
/// too much of memory.
fn make_room(facets: &mut Vec<SnappedFacet>, n_more: usize, share: f64) {
    let n = facets.len() + n_more;
    if n > facets.capacity() {
        let n_expected = (1.01 * n as f64 / share) as usize;
        facets.reserve_exact(n_expected.max(n) - facets.len());
    }
}

#[cfg(test)]
mod tests;
