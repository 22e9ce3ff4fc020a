//! Columns in a store that are read across their rays: some slabs of all rays at a time, in memory.
//!
//! Columns in a store, cells along the rays -> columns in memory that agree with them on those cells. With rays along z every
//! slab of a file needs a little of every ray, and pieces in the store hold rays whole. Instead of reading all pieces for every
//! slab, one reading takes as many slabs ahead as fit in the memory that the columns were allowed before they spilled.
//! Cost: the store is read once for every such range of slabs, which holds 1.07 bytes a ray, 4 bytes a ray that enters it
//! flagged and 4 bytes a run. Twice the memory halves the number of readings; where not even one slab fits, every slab reads all.

use std::ops::{Deref, Range};
use std::sync::{Arc, PoisonError};

use super::packed_band::PackedBand;
use super::piece_store::{PieceEntry, PieceStore};
use super::run::{Band, run_cell, run_flag};
use super::{Columns, Content};
use crate::base::error::Result;
use crate::base::parallel::*;

/// Columns, or their slabs in memory.
pub enum SlabColumns<'a> {
    Whole(&'a Columns),
    Slabs(Columns),
}

impl Deref for SlabColumns<'_> {
    type Target = Columns;

    fn deref(&self) -> &Columns {
        match self {
            SlabColumns::Whole(columns) => columns,
            SlabColumns::Slabs(columns) => columns,
        }
    }
}

impl Columns {
    /// Columns that have the same flags in some cells along the rays and are cheap to expand there, for callers that continue
    /// with the next cells.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    #[doc(hidden)]
    pub fn for_slab(&self, along: &Range<u32>) -> Result<SlabColumns<'_>> {
        // along x and y a slab needs few rays or all of them whole
        let Content::InStore { pieces, .. } = &self.content else { return Ok(SlabColumns::Whole(self)) };
        if self.rays.axis != 2 {
            return Ok(SlabColumns::Whole(self));
        }
        let mut slab = pieces.slab.lock().unwrap_or_else(PoisonError::into_inner);
        let mut likely = self.rays.depth;
        if let Some((range, bands)) = &slab.cached {
            if range.start <= along.start && along.end <= range.end {
                return Ok(SlabColumns::Slabs(Columns::in_memory(self.rays, bands.clone())));
            }
            likely = 2 * (range.end - range.start).max(1);
            // requests before the cached range bypass the cache, except those for the first cell
            if along.start < range.start && along.start > 0 {
                return Ok(SlabColumns::Whole(self));
            }
        }
        if slab.slab_exceeds_budget {
            return Ok(SlabColumns::Whole(self));
        }
        slab.cached = None;
        let end = along.start.saturating_add(likely).clamp(along.end, self.rays.depth);
        slab.cached = read_slabs(pieces, along, end)?.map(|(range, bands)| (range, Arc::new(bands)));
        slab.slab_exceeds_budget = slab.cached.is_none();
        Ok(match &slab.cached {
            Some((_, bands)) => SlabColumns::Slabs(Columns::in_memory(self.rays, bands.clone())),
            None => SlabColumns::Whole(self),
        })
    }
}

/// Reads the store once and keeps the cells along the rays from the first of `least` to `end`, or as many of them as fit;
/// None where not even `least` fits.
fn read_slabs(pieces: &PieceStore, least: &Range<u32>, mut end: u32) -> Result<Option<(Range<u32>, Vec<PackedBand>)>> {
    let mut bands: Vec<PackedBand> = Vec::new();
    let n_bytes = |bands: &[PackedBand]| bands.iter().map(PackedBand::n_bytes).sum::<u64>();
    for batch in pieces.entries.chunks(2 * current_num_threads()) {
        let read = |entry: &PieceEntry| Ok(pieces.packed(entry)?.clipped(&(least.start..end)));
        bands.extend(batch.par_iter().map(read).collect::<Result<Vec<PackedBand>>>()?);
        while n_bytes(&bands) > pieces.max_bytes {
            if end == least.end {
                return Ok(None);
            }
            end = (least.start + (end - least.start) / 2).max(least.end);
            bands = bands.into_par_iter().map(|band| band.clipped(&(least.start..end))).collect();
        }
    }
    Ok(Some((least.start..end, bands)))
}

impl PackedBand {
    /// The runs that decide the flags of some cells along the rays.
    fn clipped(&self, along: &Range<u32>) -> PackedBand {
        let mut band = Band { first_ray: self.first_ray, ..Band::default() };
        band.ends.reserve_exact(self.n_rays() as usize);
        for runs in self.rays_from(0) {
            let inside = runs.partition_point(|&run| run_cell(run) <= along.start);
            // a ray begins as background: a run of flag 0 before the range says nothing
            let entry = runs[..inside].last().filter(|&&run| run_flag(run) != 0);
            let inner = runs[inside..].iter().take_while(|&&run| run_cell(run) < along.end);
            band.runs.extend(entry.into_iter().chain(inner));
            band.ends.push(band.runs.len() as u32);
        }
        band.runs.shrink_to_fit();
        PackedBand::new(band)
    }
}
