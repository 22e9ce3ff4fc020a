//! Snapping, and the facts that depend on all facets of a surface: whether it is closed, its ends, and the bound of
//! its volume.
//!
//! Geometries, lines, rays -> [`Snapped`]. The frame has all facets, or only those whose boxes contain a ray: no ray hits the
//! others. So a fine surface in a coarse mesh loses nearly all of its facets here.
//!
//! Cost: some 70 ns per facet on one core; 38 bytes per facet that stays, and for a moment 12 bytes, the hashes of its edges, per facet of one geometry. Facets are snapped to
//! where they stay; those that do not leave at once.

use std::ops::Range;

use crate::base::control::{Control, Paced};
use crate::base::error::Result;
use crate::base::memory::{Held, Memory};
use crate::base::parallel::*;
use crate::grid::closed::{CHUNK, Closed, Hashes};
use crate::grid::frame::{Ends, Frame, SnappedFacet, too_many_ranks};
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::grid::volume_bound::{self, BoundSums};
use crate::input::geometry::{Facet, Geometry};
use crate::input::job::Rule;
use crate::stages::facet::rays_under;

/// Facets between two rests: so few that they are in the cache when their edges are hashed. A multiple of those that sums take together.
const FACETS_AT_ONCE: usize = 1 << 16;
/// Bytes of a snapped facet.
const SNAPPED_BYTES: u64 = 38;
/// Bytes of the hashes of the edges of a facet, at most, while they are made: two, and these in parts.
const HASHED_BYTES: u64 = 32;
/// What errors of memory call them.
const SNAPPED: &str = "the snapped facets and their edges";

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
    /// With no facet yet.
    fn new(geometries: &[Geometry], lines: &Lines) -> Result<Snapped> {
        let (frame, n) = (Frame::without_facets(geometries, lines)?, geometries.len());
        Ok(Snapped { frame, closed: Vec::new(), ends: vec![None; n], bound_sums: vec![BoundSums::default(); n] })
    }

    /// Adds what is known of facets of a geometry; returns the hashes of their edges.
    fn add(&mut self, position: usize, chunks: Vec<OfChunk>) -> Vec<Hashes> {
        let Snapped { frame, ends, bound_sums, .. } = self;
        let mut hashes = Vec::with_capacity(chunks.len());
        for chunk in chunks {
            ends[position] = chunk.ends.iter().flatten().fold(ends[position], with_corner);
            bound_sums[position] = chunk.bound_sums.into_iter().fold(bound_sums[position], BoundSums::plus);
            hashes.push(chunk.hashes);
        }
        frame.position_of_facet.resize(frame.facets.len(), position as u16);
        hashes
    }

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

/// Snaps the facets of geometries, of which all stay, or those that rays may hit if these are given; with the room that is taken for them. Of
/// equal priority the geometries that are closed by this rule win over those that are not: what an open surface encloses is an estimate, which
/// may reach far beyond it.
///
/// # Errors
/// Those of [`Frame::new`]; `too-many-geometries` where too many lie over one another; `memory`; `cancelled`; `io` where facets stay in their
/// file, and that cannot be read again.
pub async fn snapped(
    geometries: &[Geometry],
    lines: &Lines,
    (rays, rule): (Option<&Rays>, Rule),
    memory: &Memory,
    control: &Control,
) -> Result<(Snapped, Held)> {
    let n_facets = geometries.iter().map(|geometry| geometry.facets.len());
    let n_all: usize = n_facets.sum();
    let mut room = memory.take(0, SNAPPED)?;
    // where no ray is asked for, all stay
    let least = if rays.is_none() { SNAPPED_BYTES * n_all as u64 } else { 0 };
    let mut snapped = Snapped::new(geometries, lines)?;
    let bare = snapped.frame.clone();
    let mut n_taken = 0;
    let mut pace = Paced::new(control, FACETS_AT_ONCE);
    for (position, index) in snapped.frame.ranks.geometry_at.clone().into_iter().enumerate() {
        let geometry = &geometries[index];
        let (mut edges, mut bytes_of_edges) = (Vec::new(), 0);
        let mut some = geometry.facets.chunks(FACETS_AT_ONCE);
        while let Some(facets) = some.next_some()? {
            let all = &mut snapped.frame.facets;
            make_room(all, facets.len(), n_taken as f64 / n_all as f64);
            let of_facets = least.max(SNAPPED_BYTES * all.capacity() as u64);
            room.set(of_facets + bytes_of_edges + HASHED_BYTES * facets.len() as u64, SNAPPED)?;
            let chunks = append(all, facets, bare.snapping(geometry, lines), (&bare, rays));
            let hashes = snapped.add(position, chunks);
            bytes_of_edges += hashes.iter().map(Hashes::bytes).sum::<u64>();
            edges.extend(hashes);
            n_taken += facets.len();
            pace.done(facets.len()).await?;
        }
        snapped.closed.push(Closed::new(&edges, control).await?);
    }
    snapped.frame.facets.shrink_to_fit();
    snapped.put_open_lower(geometries, rule);
    let Snapped { frame, closed, ends, .. } = &mut snapped;
    let shared = frame.ranks.share(geometries, ends, |position| closed[position].nonzero);
    shared.map_err(|_| too_many_ranks(geometries.len()))?;
    room.set(SNAPPED_BYTES * frame.facets.capacity() as u64, SNAPPED)?;
    Ok((snapped, room))
}

/// One geometry in a frame with the box and the fraction bits of all.
#[derive(Debug)]
pub(crate) struct SnappedAlone {
    /// The facets that rays may hit.
    pub(crate) facets: Vec<SnappedFacet>,
    /// What the edges say.
    pub(crate) closed: Closed,
    /// Least and greatest coordinates.
    pub(crate) ends: Ends,
}

/// Snaps one geometry as [`snapped`] does, in a frame that was made for all of them.
///
/// # Errors
/// `cancelled`; `io` as there.
pub(crate) async fn snapped_alone(
    frame: &Frame,
    (geometry, lines): (&Geometry, &Lines),
    rays: &Rays,
    control: &Control,
) -> Result<SnappedAlone> {
    let (mut facets, mut ends, mut edges) = (Vec::new(), None, Vec::new());
    let mut chunks = geometry.facets.chunks(FACETS_AT_ONCE);
    while let Some(some) = chunks.next_some()? {
        for chunk in append(&mut facets, some, frame.snapping(geometry, lines), (frame, Some(rays))) {
            ends = chunk.ends.iter().flatten().fold(ends, with_corner);
            edges.push(chunk.hashes);
        }
        control.rest().await?;
    }
    Ok(SnappedAlone { facets, closed: Closed::new(&edges, control).await?, ends })
}

/// Appends facets as they are snapped, of which those stay that rays may hit, if these are given; returns what is known of all.
fn append(
    all: &mut Vec<SnappedFacet>,
    facets: &[Facet],
    snap: impl Fn(&Facet) -> SnappedFacet + Sync + Send,
    (frame, rays): (&Frame, Option<&Rays>),
) -> Vec<OfChunk> {
    let start = all.len();
    on_all_cores(|| extend_with(all, facets, snap));
    let of_chunk = |facets: &[SnappedFacet]| OfChunk::new(facets, frame, rays);
    let chunks: Vec<OfChunk> = on_all_cores(|| all[start..].par_chunks(CHUNK).map(of_chunk).collect());
    let mut end = start;
    for (chunk, first) in chunks.iter().zip((start..).step_by(CHUNK)) {
        for staying in &chunk.staying {
            if end != first + staying.start {
                all.copy_within(first + staying.start..first + staying.end, end);
            }
            end += staying.len();
        }
    }
    all.truncate(end);
    chunks
}

/// What is known of the facets that a core takes at a time.
struct OfChunk {
    /// Those that stay, as ranges.
    staying: Vec<Range<usize>>,
    ends: Ends,
    /// Of parts that do not depend on the number of threads.
    bound_sums: Vec<BoundSums>,
    hashes: Hashes,
}

impl OfChunk {
    fn new(facets: &[SnappedFacet], frame: &Frame, rays: Option<&Rays>) -> OfChunk {
        let hashes = Hashes::new(facets);
        let ends = ends(facets);
        // there is no bound for cells that differ in size
        let bounded = if frame.is_graded() { &[][..] } else { facets };
        let parts = bounded.chunks(volume_bound::CHUNK);
        let bound_sums = parts.map(|part| BoundSums::of(part, frame.fraction_bits)).collect();
        let stays = |facet: &SnappedFacet| rays.is_none_or(|rays| rays_under(facet, frame, rays).is_some());
        let mut staying: Vec<Range<usize>> = Vec::new();
        for (index, _) in facets.iter().enumerate().filter(|(_, facet)| stays(facet)) {
            match staying.last_mut() {
                Some(last) if last.end == index => last.end += 1,
                _ => staying.push(index..index + 1),
            }
        }
        OfChunk { staying, ends, bound_sums, hashes }
    }
}

/// Least and greatest coordinates; None without facets. All nine numbers of a facet are compared at once.
fn ends(facets: &[SnappedFacet]) -> Ends {
    let first = facets.first()?;
    let (mut low, mut high) = (*first, *first);
    for facet in facets {
        for (corner, of_facet) in facet.iter().enumerate() {
            for (axis, &at) in of_facet.iter().enumerate() {
                low[corner][axis] = low[corner][axis].min(at);
                high[corner][axis] = high[corner][axis].max(at);
            }
        }
    }
    low.iter().chain(&high).fold(None, with_corner)
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

/// Makes room for more facets, where those that there are are what stays of this share of all: for as many as that lets expect in all, as twice
/// the room would be too much of memory.
fn make_room(facets: &mut Vec<SnappedFacet>, n_more: usize, share: f64) {
    let n = facets.len() + n_more;
    if n > facets.capacity() {
        let n_expected = if share > 0.0 { (1.01 * facets.len() as f64 / share) as usize } else { 0 };
        facets.reserve_exact(n_expected.max(n) - facets.len());
    }
}

#[cfg(test)]
mod tests;
