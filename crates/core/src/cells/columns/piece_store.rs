//! Columns outside memory: the pieces of a column file, finished or not, read when they are needed.
//!
//! Cost: 24 bytes of memory a piece, and at most the bytes allowed for what was read last.

use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use super::codec::{self, PieceEncoder, PieceSplitter};
use super::file::corrupt;
use super::file::piece::{self, PIECE_HEAD, PieceHead};
use super::packed_band::PackedBand;
use super::run::Band;
use super::store::Store;
use super::totals_check::TotalsCheck;
use crate::base::checksum::crc32;
use crate::base::error::{Error, Result};
use crate::base::parallel::*;

/// Most bytes of decoded pieces that are cached: a few a core, so that neighbours need not be read twice.
const CACHE_BYTES: u64 = 16 << 20;

/// Where a piece is in the store, and its rays.
#[derive(Debug, Clone, Copy)]
#[doc(hidden)]
pub struct PieceEntry {
    /// Byte at which its head starts.
    #[doc(hidden)]
    pub at: u64,
    #[doc(hidden)]
    pub first_ray: u64,
    #[doc(hidden)]
    pub n_rays: u32,
}

impl PieceEntry {
    /// Index of the ray after the last.
    pub(crate) fn end_ray(&self) -> u64 {
        self.first_ray + u64::from(self.n_rays)
    }
}

/// The slabs that were read last.
#[derive(Default)]
pub(super) struct SlabCache {
    /// Cells along the rays, and the runs that decide their flags.
    pub(super) cached: Option<(Range<u32>, Arc<Vec<PackedBand>>)>,
    pub(super) slab_exceeds_budget: bool,
}

/// A store with the pieces of a column file, and those read from it last.
#[doc(hidden)]
pub struct PieceStore {
    store: Arc<dyn Store>,
    depth: u32,
    zlib: bool,
    /// Whether the file came from outside: then the file is to blame for damage, otherwise the medium.
    pub(super) is_foreign: bool,
    /// The pieces, in the order of their rays.
    #[doc(hidden)]
    pub entries: Vec<PieceEntry>,
    /// Bytes of the file.
    pub(super) n_bytes: u64,
    /// Most bytes of slabs in memory.
    pub(super) max_bytes: u64,
    pub(super) slab: Mutex<SlabCache>,
    cache: Mutex<VecDeque<(u64, Arc<PackedBand>)>>,
    cache_bytes: u64,
    /// What the end of a file from outside says of its pieces.
    #[doc(hidden)]
    pub totals_check: Option<TotalsCheck>,
}

impl fmt::Debug for PieceStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PieceStore").field("n_bytes", &self.n_bytes).finish_non_exhaustive()
    }
}

impl PieceStore {
    /// Uses an empty store for pieces that this program writes, not compressed, for rays of `depth` cells, and at most
    /// `max_bytes` of memory for what is read back.
    pub(crate) fn own(store: Arc<dyn Store>, depth: u32, max_bytes: u64) -> PieceStore {
        let cache_bytes = CACHE_BYTES.min(max_bytes / 4);
        PieceStore {
            store,
            depth,
            zlib: false,
            is_foreign: false,
            entries: Vec::new(),
            n_bytes: 0,
            max_bytes: max_bytes - cache_bytes,
            slab: Mutex::default(),
            cache: Mutex::default(),
            cache_bytes,
            totals_check: None,
        }
    }

    /// Uses the pieces of a file of `n_bytes` bytes that came from outside.
    #[doc(hidden)]
    pub fn foreign(store: Arc<dyn Store>, n_bytes: u64, depth: u32, zlib: bool, max_bytes: u64) -> PieceStore {
        PieceStore { n_bytes, zlib, is_foreign: true, ..PieceStore::own(store, depth, max_bytes) }
    }

    /// Appends bands as pieces, each of which ends with the counts of its band.
    ///
    /// # Errors
    /// `io` where the store fails.
    pub(crate) fn append(&mut self, bands: &[PackedBand]) -> Result<()> {
        let mut pieces = Vec::new();
        for band in bands {
            let mut splitter = PieceSplitter::new(band.first_ray);
            band.rays_from(0).for_each(|runs| splitter.push(runs.len() as u64));
            pieces.extend(splitter.finish().into_iter().map(|rays| (band, rays)));
        }
        for pieces in pieces.chunks(4 * current_num_threads()) {
            let encoded = pieces.par_iter().map(|(band, rays)| encode(band, rays));
            for ((_, rays), bytes) in pieces.iter().zip(encoded.collect::<Result<Vec<_>>>()?) {
                let at = self.append_bytes(&bytes)?;
                self.entries.push(PieceEntry { at, first_ray: rays.start, n_rays: (rays.end - rays.start) as u32 });
            }
        }
        Ok(())
    }

    /// Appends bytes; returns where they start.
    ///
    /// # Errors
    /// `io` where the store fails.
    pub(crate) fn append_bytes(&mut self, bytes: &[u8]) -> Result<u64> {
        let at = self.store.append(bytes).map_err(|error| Error::io("writing columns to the disk", error))?;
        self.n_bytes += bytes.len() as u64;
        Ok(at)
    }

    /// Reads the rays of a piece, from the cache if they are there.
    ///
    /// # Errors
    /// Those of [`PieceStore::packed`].
    pub(crate) fn cached(&self, entry: &PieceEntry) -> Result<Arc<PackedBand>> {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, band)) = cache.iter().find(|(at, _)| *at == entry.at) {
            return Ok(band.clone());
        }
        // other threads may read other pieces meanwhile
        drop(cache);
        let band = Arc::new(self.packed(entry)?);
        cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        cache.push_back((entry.at, band.clone()));
        let n_bytes =
            |cache: &VecDeque<(u64, Arc<PackedBand>)>| cache.iter().map(|(_, band)| band.n_bytes()).sum::<u64>();
        while cache.len() > 1 && n_bytes(&cache) > self.cache_bytes {
            cache.pop_front();
        }
        Ok(band)
    }

    /// Reads the rays of a piece of a file that has its end.
    ///
    /// # Errors
    /// Those of [`PieceStore::band`]; `columns-corrupt` where the totals of a file from outside are not those of its pieces,
    /// once all of them were read.
    pub(crate) fn packed(&self, entry: &PieceEntry) -> Result<PackedBand> {
        let band = PackedBand::new(self.band(entry)?);
        if let Some(check) = &self.totals_check {
            let piece = self.entries.partition_point(|other| other.first_ray < entry.first_ray);
            check.add(piece, &band, self.depth)?;
        }
        Ok(band)
    }

    /// Reads and decodes the rays of a piece.
    ///
    /// # Errors
    /// `io` where the store fails, or gives back other bytes than it was given; `columns-corrupt` where a file from outside
    /// is damaged; `memory` where a piece takes more than is allowed.
    pub(crate) fn band(&self, entry: &PieceEntry) -> Result<Band> {
        let head = self.head(entry.at)?;
        let is_sound = head.n_rays == entry.n_rays && head.is_sound(u64::from(entry.n_rays), self.depth);
        if !is_sound || !head.stores_no_more_than_needed() {
            let PieceHead { n_rays, n_runs, n_stored, .. } = head;
            return Err(
                self.damaged(entry.at, &format!("its head says {n_rays} rays, {n_runs} runs, {n_stored} bytes"))
            );
        }
        let end = entry.at.saturating_add(PIECE_HEAD as u64 + u64::from(head.n_stored));
        if self.is_foreign && end > self.n_bytes {
            return Err(self.damaged(entry.at, "the file ends before it does"));
        }
        self.check_memory(entry.at, &head)?;
        let mut stored = vec![0; head.n_stored as usize];
        self.read(entry.at + PIECE_HEAD as u64, &mut stored)?;
        if crc32(&stored) != head.crc {
            return Err(self.damaged(entry.at, "the checksum is wrong"));
        }
        let band = head.decode(&stored, self.zlib, self.depth).map_err(|what| self.damaged(entry.at, &what))?;
        Ok(Band { first_ray: entry.first_ray, ..band })
    }

    /// Reads the head of the piece that starts at a byte.
    ///
    /// # Errors
    /// Those of [`PieceStore::band`].
    pub(crate) fn head(&self, at: u64) -> Result<PieceHead> {
        let mut head = [0; PIECE_HEAD];
        self.read(at, &mut head)?;
        PieceHead::from_checked_bytes(&head).ok_or_else(|| self.damaged(at, "the checksum of its head is wrong"))
    }

    /// Refuses a piece larger than any piece of several rays: a ray with millions of runs.
    fn check_memory(&self, at: u64, head: &PieceHead) -> Result<()> {
        let runs = 4 * (u64::from(head.n_rays) + u64::from(head.n_runs));
        let needed = (2 * runs + head.most_content() + u64::from(head.n_stored)) * current_num_threads() as u64;
        let allowed = self.max_bytes.saturating_add(self.cache_bytes).max(64 << 20);
        if head.n_runs > codec::PIECE_RUNS && needed > allowed {
            let message = format!("the piece at byte {at} of the columns takes {needed} bytes; {allowed} are allowed");
            return Err(Error::new("memory", message, crate::base::error::MORE_MEMORY));
        }
        Ok(())
    }

    fn read(&self, at: u64, bytes: &mut [u8]) -> Result<()> {
        self.store.read(at, bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof if self.is_foreign => self.damaged(at, "the file ends before it does"),
            _ => Error::io("reading columns from the disk", error),
        })
    }

    fn damaged(&self, at: u64, what: &str) -> Error {
        if self.is_foreign {
            return corrupt(format!("the piece at byte {at}: {what}"));
        }
        let message = format!("columns that were written to the disk came back damaged at byte {at}: {what}");
        Error::new("io", message, "check the disk, and mesh again")
    }
}

/// The bytes of the piece of some rays of a band, with the counts of the band if they are its last rays.
fn encode(band: &PackedBand, rays: &Range<u64>) -> Result<Vec<u8>> {
    let n_rays = (rays.end - rays.start) as u32;
    let mut encoder = PieceEncoder::default();
    let runs = band.rays_from((rays.start - band.first_ray) as usize);
    runs.take(n_rays as usize).for_each(|runs| encoder.push(runs));
    let ends_band = rays.end == band.end_ray();
    piece::encode(n_rays, encoder, None, ends_band.then_some([band.odd_rays, band.n_crossings]))
}

#[cfg(test)]
mod tests {
    use super::super::file::end::Totals;
    use super::super::{Columns, MemoryStore, run};
    use super::*;
    use crate::grid::rays::Rays;

    #[test]
    fn pieces_that_were_read_last_are_cached_within_their_bytes() {
        // bands of 10 rays of 5 runs: the index takes 4 + 10 bytes
        let band = |first_ray| {
            let runs = (0..5).map(|k| run(2 * k, (k % 2 + 1) as u8)).collect::<Vec<_>>().repeat(10);
            PackedBand::new(Band { first_ray, ends: (1..=10).map(|ray| 5 * ray).collect(), runs, ..Band::default() })
        };
        let n_bytes = 4 + 10 + 4 * 50;
        assert_eq!(band(0).n_bytes(), n_bytes);
        // a quarter of the memory is for pieces; the last one stays, whatever it takes
        for (allowed, n_cached) in [(0, 1), (n_bytes - 1, 1), (3 * n_bytes - 1, 2), (3 * n_bytes, 3), (9 * n_bytes, 6)]
        {
            let mut store = PieceStore::own(Arc::new(MemoryStore::default()), 10, 4 * allowed);
            store.append(&(0..6).map(|k| band(10 * k)).collect::<Vec<_>>()).unwrap();
            let read: Vec<_> = store.entries.iter().map(|entry| store.cached(entry).unwrap()).collect();
            let cached: Vec<u64> = store.cache.lock().unwrap().iter().map(|(at, _)| *at).collect();
            let last: Vec<u64> = store.entries[6 - n_cached..].iter().map(|entry| entry.at).collect();
            assert_eq!(cached, last, "{allowed} bytes");
            assert!(Arc::ptr_eq(&read[5], &store.cached(&store.entries[5]).unwrap()));
        }
    }

    #[test]
    fn pieces_of_a_file_are_held_to_its_length_its_totals_and_the_memory() {
        // as many pieces as a word has bits, of a ray of two runs each
        let bands: Vec<PackedBand> = (0..64)
            .map(|first_ray| {
                let runs = vec![run(2, 1), run(5, 0)];
                PackedBand::new(Band { first_ray, ends: vec![2], runs, odd_rays: 0, n_crossings: 2 })
            })
            .collect();
        let memory = Arc::new(MemoryStore::default());
        let mut own = PieceStore::own(memory.clone(), 1 << 24, 0);
        own.append(&bands).unwrap();
        let file = |n_bytes: u64, more: u64| {
            let mut totals = Totals::of(&bands, 1 << 24);
            totals.n_crossings += more;
            let mut pieces = PieceStore::foreign(memory.clone(), n_bytes, 1 << 24, false, 1000);
            pieces.entries = own.entries.clone();
            pieces.totals_check = Some(TotalsCheck::new(totals, 64));
            Columns::in_store(Rays::new(2, [8, 8, 1 << 24]), pieces, Totals::of(&[], 0))
        };
        let read = |columns: &Columns| columns.for_rays(0..64, |_| ());
        let says = |result: Result<()>, words: &str| {
            let error = result.unwrap_err();
            assert!(error.code() == "columns-corrupt" && error.to_string().contains(words), "{error}");
        };
        assert_eq!((read(&file(own.n_bytes, 0)), file(own.n_bytes, 0).max_bytes()), (Ok(()), Some(750)));
        says(read(&file(own.n_bytes, 1)), "the end says 129 crossings, and the pieces have 128");
        says(read(&file(own.n_bytes - 1, 0)), "the file ends before it does");
        memory.truncate(own.n_bytes - 1).unwrap();
        says(read(&file(own.n_bytes, 0)), "the file ends before it does");
        // a ray that would take more than may be held
        let (n_rays, n_runs, n_content, n_stored, crc) = (1, 9_000_000, 0, 0, crc32(&[]));
        let head = PieceHead { n_rays, n_runs, n_content, n_stored, crc, counts: [0; 2], ends_band: true };
        memory.truncate(0).unwrap();
        memory.append(&head.to_bytes()).unwrap();
        assert_eq!(read(&file(1000, 0)).unwrap_err().code(), "memory");
    }

    #[test]
    fn a_ray_of_more_runs_than_memory_has_is_refused_before_it_is_read() {
        let store = PieceStore::own(Arc::new(MemoryStore::default()), 1 << 18, 0);
        let head = |n_runs| {
            let (n_rays, n_content, n_stored, crc, counts) = (1, 0, 1000, [0; 4], [0; 2]);
            PieceHead { n_rays, n_runs, n_content, n_stored, crc, counts, ends_band: false }
        };
        // twice 4 bytes a number, 5 or 6 as they are stored, and the stored bytes, on every thread; 64 MiB are always allowed
        let needed = |n_runs: u64| (8 * (n_runs + 1) + 6 * n_runs + 5 + 1000) * current_num_threads() as u64;
        let most = (codec::PIECE_RUNS..).find(|&n_runs| needed(u64::from(n_runs) + 1) > 64 << 20).unwrap();
        if most > codec::PIECE_RUNS {
            assert!(store.check_memory(7, &head(most)).is_ok());
        }
        let error = store.check_memory(7, &head(most + 1)).unwrap_err();
        let numbers =
            format!("the piece at byte 7 of the columns takes {} bytes; 67108864 are", needed(u64::from(most) + 1));
        assert!(error.code() == "memory" && error.to_string().contains(&numbers), "{error}");
    }
}
