//! Columns outside memory: the pieces of a column file, finished or not, read when they are needed.
//!
//! Cost: 24 bytes of memory a piece, and at most the bytes allowed for what was read last.

use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use super::codec::{self, Plan};
use super::file::corrupt;
use super::file::piece::{self, PIECE_HEAD, PieceHead};
use super::part::Part;
use super::run::Band;
use super::store::Store;
use crate::checksum::crc32;
use crate::error::{Error, Result};
use crate::parallel::*;

/// Most bytes of decoded pieces that are cached: a few a core, so that neighbours need not be read twice.
const CACHE_BYTES: u64 = 16 << 20;

/// A piece in a store.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Record {
    /// Place of its head.
    pub(crate) at: u64,
    pub(crate) first_ray: u64,
    pub(crate) n_rays: u32,
}

impl Record {
    /// Index of the ray behind the last.
    pub(crate) fn end_ray(&self) -> u64 {
        self.first_ray + u64::from(self.n_rays)
    }
}

/// The cells along the rays that were read last, for the slabs that need some of every ray.
#[derive(Default)]
pub(super) struct SlabCache {
    pub(super) taken: Option<(Range<u32>, Arc<Vec<Part>>)>,
    /// Whether not even one slab fits.
    pub(super) slab_exceeds_budget: bool,
}

/// A store with pieces, and those read from it last.
pub(crate) struct Stored {
    pub(crate) store: Arc<dyn Store>,
    depth: u32,
    zlib: bool,
    /// Whether the file came from outside: then damage is its own, else that of the medium.
    is_foreign: bool,
    /// Bytes that may be held of what is read back.
    pub(super) room: u64,
    pub(super) clip: Mutex<SlabCache>,
    cache: Mutex<VecDeque<(u64, Arc<Part>)>>,
    cache_bytes: u64,
}

impl fmt::Debug for Stored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stored").field("depth", &self.depth).finish_non_exhaustive()
    }
}

impl Stored {
    /// Uses a store of pieces, not compressed, that this program writes, for rays of `depth` cells, and at most `max_bytes` of
    /// memory for what is read back.
    pub(crate) fn own(store: Arc<dyn Store>, depth: u32, max_bytes: u64) -> Stored {
        let cache_bytes = CACHE_BYTES.min(max_bytes / 4);
        let (room, is_foreign, zlib) = (max_bytes - cache_bytes, false, false);
        Stored { store, depth, zlib, is_foreign, room, clip: Mutex::default(), cache: Mutex::default(), cache_bytes }
    }

    /// The same for the pieces of a file that came from outside.
    pub(crate) fn foreign(store: Arc<dyn Store>, depth: u32, zlib: bool, max_bytes: u64) -> Stored {
        Stored { zlib, is_foreign: true, ..Stored::own(store, depth, max_bytes) }
    }

    /// Appends parts, each a band with its odd rays and crossings; also returns the bytes appended.
    ///
    /// # Errors
    /// `io` where the store fails.
    pub(crate) fn append(&self, parts: &[(Part, [u64; 2])]) -> Result<(Vec<Record>, u64)> {
        let mut pieces = Vec::new();
        for (part, counts) in parts {
            let mut plan = Plan::new(part.first_ray);
            part.rays_from(0).for_each(|runs| plan.push(runs.len() as u64));
            let closes = |rays: &Range<u64>| (rays.end == part.end_ray()).then_some(*counts);
            pieces.extend(plan.finish().into_iter().map(|rays| (part, closes(&rays), rays)));
        }
        let (mut records, mut n_bytes) = (Vec::with_capacity(pieces.len()), 0);
        for pieces in pieces.chunks(4 * current_num_threads()) {
            let encoded = pieces.par_iter().map(|(part, closes, rays)| encode(part, rays, *closes));
            for ((_, _, rays), bytes) in pieces.iter().zip(encoded.collect::<Result<Vec<_>>>()?) {
                let at = self.store.append(&bytes).map_err(|error| Error::io("writing columns to the disk", error))?;
                n_bytes += bytes.len() as u64;
                records.push(Record { at, first_ray: rays.start, n_rays: (rays.end - rays.start) as u32 });
            }
        }
        Ok((records, n_bytes))
    }

    /// Reads the part of a record, from the cache if it is there.
    ///
    /// # Errors
    /// Those of [`Stored::read`].
    pub(crate) fn part(&self, record: &Record) -> Result<Arc<Part>> {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, part)) = cache.iter().find(|(at, _)| *at == record.at) {
            return Ok(part.clone());
        }
        // others may read other pieces meanwhile
        drop(cache);
        let part = Arc::new(self.read(record)?);
        cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        cache.push_back((record.at, part.clone()));
        let held = |cache: &VecDeque<(u64, Arc<Part>)>| cache.iter().map(|(_, part)| part.n_bytes()).sum::<u64>();
        while cache.len() > 1 && held(&cache) > self.cache_bytes {
            cache.pop_front();
        }
        Ok(part)
    }

    /// Reads and decodes the part of a record.
    ///
    /// # Errors
    /// Those of [`Stored::band`].
    pub(crate) fn read(&self, record: &Record) -> Result<Part> {
        Ok(Part::new(self.band(record)?))
    }

    /// Reads and decodes the rays of a record.
    ///
    /// # Errors
    /// `io` where the store fails, or gives back other bytes than it was given; `columns-corrupt` where a file from outside
    /// is damaged; `memory` where a piece takes more than is allowed.
    pub(crate) fn band(&self, record: &Record) -> Result<Band> {
        let head = self.head(record.at)?;
        let sound = head.n_rays == record.n_rays && head.is_sound(u64::from(record.n_rays), self.depth);
        if !sound || !head.stores_no_more_than_needed() {
            let PieceHead { n_rays, n_runs, n_stored, .. } = head;
            return Err(
                self.damaged(record.at, &format!("its head says {n_rays} rays, {n_runs} runs, {n_stored} bytes"))
            );
        }
        self.check_memory(record.at, &head)?;
        let mut stored = vec![0; head.n_stored as usize];
        self.fill(record.at + PIECE_HEAD as u64, &mut stored)?;
        if crc32(&stored) != head.crc {
            return Err(self.damaged(record.at, "the checksum is wrong"));
        }
        let band = head.decode(&stored, self.zlib, self.depth).map_err(|what| self.damaged(record.at, &what))?;
        Ok(Band { first_ray: record.first_ray, ..band })
    }

    /// Most bytes that may be held of a file from outside; none for columns of this program, which planned for them.
    pub(super) fn most_held(&self) -> Option<u64> {
        self.is_foreign.then_some(self.room)
    }

    /// Reads the head of the piece at a place.
    ///
    /// # Errors
    /// Those of [`Stored::band`].
    pub(crate) fn head(&self, at: u64) -> Result<PieceHead> {
        let mut head = [0; PIECE_HEAD];
        self.fill(at, &mut head)?;
        PieceHead::from_checked_bytes(&head).ok_or_else(|| self.damaged(at, "the checksum of its head is wrong"))
    }

    /// Refuses a piece that no piece of many rays is as large as: a ray with millions of runs.
    fn check_memory(&self, at: u64, head: &PieceHead) -> Result<()> {
        let runs = 4 * (u64::from(head.n_rays) + u64::from(head.n_runs));
        let needed = (2 * runs + head.most_content() + u64::from(head.n_stored)) * current_num_threads() as u64;
        let allowed = self.room.saturating_add(self.cache_bytes).max(64 << 20);
        if head.n_runs > codec::PIECE_RUNS && needed > allowed {
            let message = format!("the piece at byte {at} of the columns takes {needed} bytes; {allowed} are allowed");
            return Err(Error::new("memory", message, crate::error::MORE_MEMORY));
        }
        Ok(())
    }

    fn fill(&self, at: u64, bytes: &mut [u8]) -> Result<()> {
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
        Error::new("io", message, "look at the disk, and mesh again")
    }
}

/// The bytes of the piece of some rays of a part.
fn encode(part: &Part, rays: &Range<u64>, closes: Option<[u64; 2]>) -> Result<Vec<u8>> {
    let n_rays = (rays.end - rays.start) as u32;
    let mut encoder = codec::Encoder::default();
    let runs = part.rays_from((rays.start - part.first_ray) as usize);
    runs.take(n_rays as usize).for_each(|runs| encoder.push(runs));
    let (head, stored) = piece::encode(n_rays, encoder, None)?;
    let head = PieceHead { counts: closes.unwrap_or_default(), ends_band: closes.is_some(), ..head };
    Ok([head.to_bytes(), stored].concat())
}
