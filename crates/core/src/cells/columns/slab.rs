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

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::base::control::Control;
    use crate::cells::columns::{ColumnsBuilder, Head, MemoryStore, Store, run, sealed};
    use crate::derived::mesh::Mesh;
    use crate::grid::lines::Lines;
    use crate::grid::rays::Rays;

    /// A store that counts the bytes read from it.
    #[derive(Default)]
    struct Counting {
        memory: MemoryStore,
        n_read: AtomicU64,
    }

    impl sealed::Sealed for Counting {}

    impl Store for Counting {
        fn append(&self, bytes: &[u8]) -> std::io::Result<u64> {
            self.memory.append(bytes)
        }

        fn read(&self, at: u64, bytes: &mut [u8]) -> std::io::Result<()> {
            self.n_read.fetch_add(bytes.len() as u64, Ordering::Relaxed);
            self.memory.read(at, bytes)
        }

        fn truncate(&self, n_bytes: u64) -> std::io::Result<()> {
            self.memory.truncate(n_bytes)
        }
    }

    const SIDE: u32 = 60;
    const DEPTH: u32 = 400;

    /// Rays with some 50 runs each, in bands of 10 rows.
    fn bands() -> Vec<Band> {
        let rows = |first: u32| {
            let mut band = Band { first_ray: u64::from(first * SIDE), ..Band::default() };
            for ray in first * SIDE..(first + 10) * SIDE {
                let cells = (0..50).map(|k| k * 8 + (ray * 7 + k * 3) % 8);
                band.runs.extend(cells.zip([3, 0, 1, 2].into_iter().cycle()).map(|(cell, flag)| run(cell, flag)));
                band.ends.push(band.runs.len() as u32);
            }
            band
        };
        (0..SIDE).step_by(10).map(rows).collect()
    }

    fn mesh(max_bytes: u64, store: Option<Arc<dyn Store>>) -> Mesh {
        let dims = [SIDE, SIDE, DEPTH];
        let (rays, lines) = (Rays::new(2, dims), Lines::new([0.0; 3], [1.0; 3], dims).unwrap());
        let head = Head { identity: None, rays, zlib: false, lines: lines.clone(), unit: None, names: vec![] };
        let head = head.encode().unwrap();
        let mut builder = ColumnsBuilder::new(rays, max_bytes, store.map(|store| (head, store)));
        bands().into_iter().for_each(|band| builder.push(vec![band]).unwrap());
        Mesh::new(lines, builder.finish().unwrap(), vec![], None).unwrap()
    }

    fn all_flags(mesh: &Mesh, slab_bytes: usize) -> Vec<u8> {
        let mut flags = Vec::new();
        mesh.for_each_slab(slab_bytes, &Control::default(), |slab| {
            flags.extend_from_slice(slab);
            Ok(())
        })
        .unwrap();
        flags
    }

    fn all_bits(mesh: &Mesh, slab_bytes: usize) -> Vec<u8> {
        let mut bits = Vec::new();
        mesh.for_each_slab_of_bits(slab_bytes, &Control::default(), |slab| {
            bits.extend_from_slice(slab);
            Ok(())
        })
        .unwrap();
        bits
    }

    #[test]
    fn slabs_across_the_rays_read_the_store_a_few_times() {
        let whole = mesh(u64::MAX, None);
        let expected = all_flags(&whole, 1 << 20);
        let expected_bits = all_bits(&whole, 1 << 20);
        let n_bytes = whole.columns.n_bytes();
        // planes of 3600 cells: one a slab, five, or half a one
        for slab_bytes in [3600, 18_000, 1800] {
            for (max_bytes, most_readings) in
                [(n_bytes - 1, 3), (n_bytes / 2, 6), (n_bytes / 8, 24), (n_bytes / 20, 80)]
            {
                let store = Arc::new(Counting::default());
                let mesh = mesh(max_bytes, Some(store.clone()));
                assert!(mesh.columns.is_spilled());
                // twice: the second begins again at the first cell
                for _ in 0..2 {
                    store.n_read.store(0, Ordering::Relaxed);
                    assert!(all_flags(&mesh, slab_bytes) == expected, "slabs of {slab_bytes} in {max_bytes}");
                    let readings = store.n_read.load(Ordering::Relaxed) as f64 / mesh.columns.spilled_bytes() as f64;
                    assert!(
                        readings <= f64::from(most_readings),
                        "{readings} readings, slabs of {slab_bytes} in {max_bytes}"
                    );
                }
                store.n_read.store(0, Ordering::Relaxed);
                assert!(all_bits(&mesh, slab_bytes / 8) == expected_bits, "bits, slabs of {slab_bytes}");
                let readings = store.n_read.load(Ordering::Relaxed) as f64 / mesh.columns.spilled_bytes() as f64;
                assert!(readings <= f64::from(most_readings), "{readings} readings for bits in {max_bytes}");
                let slabs = mesh.columns.for_slab(&(200..201)).unwrap();
                assert!(slabs.n_bytes() <= max_bytes, "{} held of {max_bytes}", slabs.n_bytes());
            }
        }
    }

    #[test]
    fn boxes_and_columns_without_memory_for_slabs_are_read_from_the_store() {
        let expected = mesh(u64::MAX, None);
        for max_bytes in [0, 3000, 100_000] {
            let mesh = mesh(max_bytes, Some(Arc::new(MemoryStore::default())));
            assert!(all_flags(&mesh, 50_000) == all_flags(&expected, 50_000), "{max_bytes} bytes");
            let boxes =
                [[0..60, 0..60, 399..400], [0..60, 0..60, 17..90], [3..4, 5..50, 100..380], [0..60, 0..60, 7..7]];
            for cells in boxes {
                let flags = expected.box_flags(&cells).unwrap();
                assert!(mesh.box_flags(&cells).unwrap() == flags, "{cells:?} of {max_bytes} bytes");
                assert!(mesh.box_bits(&cells).unwrap() == expected.box_bits(&cells).unwrap(), "bits of {cells:?}");
            }
        }
    }
}
