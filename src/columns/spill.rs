//! Columns outside memory: pieces of runs in a store that the caller gives, found again by their place in it.
//!
//! A part is cut in pieces; each becomes a record, appended to the store. Records say which rays they hold and the last
//! record of a part closes it, with the counts of the whole part: a store that was cut short is good up to the last part
//! that was closed. Numbers are little-endian.
//!
//! | bytes | what |
//! |---|---|
//! | u32 | 1 if the record closes its part, else 0 |
//! | u64 | index of the first ray |
//! | u32 | number of rays; u32 number of runs; u32 number of bytes of the content |
//! | u64 | odd rays; u64 crossings of the part, in the record that closes it; else 0 |
//! | u32 | crc32 of the content; u32 crc32 of the 44 bytes before |
//! | ... | the content, as in a piece of [`crate::write::column_file`] |
//!
//! A store that is kept for a later run starts with a head: 8 bytes [`KEPT_MAGIC`], u32 version of the layout, 32 bytes
//! that identify what is meshed, u32 crc32 of the 44 bytes before.
//! Cost: 1 to 3 bytes a run and a byte a ray in the store; 40 bytes a piece in memory.

use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use super::codec::{self, Encoder, Plan};
use super::part::Part;
use super::run::Band;
use crate::checksum::crc32;
use crate::error::{Error, Result};
use crate::parallel::*;

/// Bytes of the head of a record.
pub(crate) const RECORD_HEAD: usize = 48;
/// What a store starts with that is kept for a later run.
const KEPT_MAGIC: [u8; 8] = *b"\x89HXP\r\n\x1a\n";
const KEPT_VERSION: u32 = 1;
/// Bytes of the head of such a store.
pub(crate) const KEPT_HEAD: usize = 48;
/// Most bytes of decoded pieces kept at hand: a few a core, so that neighbours need not be read twice.
const CACHE_BYTES: u64 = 16 << 20;

/// A place for bytes outside memory, such as a file. Calls may come from several threads.
pub trait Store: Send + Sync {
    /// Appends bytes and returns the place of the first.
    ///
    /// # Errors
    /// Whatever the medium fails with.
    fn append(&self, bytes: &[u8]) -> io::Result<u64>;

    /// Reads the bytes at a place that was appended before.
    ///
    /// # Errors
    /// Whatever the medium fails with.
    fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()>;

    /// Drops everything from a place on; the next append goes there.
    ///
    /// # Errors
    /// Whatever the medium fails with.
    fn truncate(&self, n_bytes: u64) -> io::Result<()>;
}

/// Rays and counts of a piece in a store.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Record {
    /// Place of its head.
    pub(crate) at: u64,
    pub(crate) first_ray: u64,
    pub(crate) n_rays: u32,
    pub(crate) n_runs: u32,
    pub(crate) n_bytes: u32,
    /// Odd rays and crossings of the part that it closes, if it does.
    pub(crate) closes: Option<[u64; 2]>,
    crc: [u8; 4],
}

impl Record {
    /// Index of the ray behind the last.
    pub(crate) fn end_ray(&self) -> u64 {
        self.first_ray + u64::from(self.n_rays)
    }

    /// Bytes in the store.
    pub(crate) fn n_stored(&self) -> u64 {
        RECORD_HEAD as u64 + u64::from(self.n_bytes)
    }

    fn head(&self) -> Vec<u8> {
        let mut head = u32::from(self.closes.is_some()).to_le_bytes().to_vec();
        head.extend(self.first_ray.to_le_bytes());
        [self.n_rays, self.n_runs, self.n_bytes].iter().for_each(|number| head.extend(number.to_le_bytes()));
        self.closes.unwrap_or_default().iter().for_each(|count| head.extend(count.to_le_bytes()));
        head.extend(self.crc);
        head.extend(crc32(&head));
        head
    }

    /// Understands the head of a record at a place; None where it is damaged.
    pub(crate) fn from_head(at: u64, head: &[u8; RECORD_HEAD]) -> Option<Record> {
        let (body, crc) = head.split_at(RECORD_HEAD - 4);
        let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let long = |at: usize| u64::from(number(at)) | u64::from(number(at + 4)) << 32;
        let closes = (number(0) == 1).then(|| [long(24), long(32)]);
        let [n_rays, n_runs, n_bytes] = [12, 16, 20].map(number);
        let record = Record { at, first_ray: long(4), n_rays, n_runs, n_bytes, closes, crc: number(40).to_le_bytes() };
        (crc == crc32(body)).then_some(record)
    }
}

/// The cells along the rays that were read last, for the slabs that need some of every ray.
#[derive(Default)]
pub(super) struct SlabCache {
    pub(super) taken: Option<(Range<u32>, Arc<Vec<Part>>)>,
    /// Whether not even one slab fits.
    pub(super) slab_exceeds_budget: bool,
}

/// A store, and the pieces read from it last.
pub(crate) struct Spill {
    pub(crate) store: Arc<dyn Store>,
    depth: u32,
    /// Bytes that may be held of what is read back.
    pub(super) room: u64,
    pub(super) clip: Mutex<SlabCache>,
    cache: Mutex<VecDeque<(u64, Arc<Part>)>>,
    cache_bytes: u64,
}

impl fmt::Debug for Spill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Spill").field("depth", &self.depth).finish_non_exhaustive()
    }
}

impl Spill {
    /// Uses a store for rays of `depth` cells, and at most `max_bytes` of memory for what is read back.
    pub(crate) fn new(store: Arc<dyn Store>, depth: u32, max_bytes: u64) -> Spill {
        let cache_bytes = CACHE_BYTES.min(max_bytes / 4);
        let room = max_bytes - cache_bytes;
        Spill { store, depth, room, clip: Mutex::default(), cache: Mutex::default(), cache_bytes }
    }

    /// Appends parts, each with its odd rays and crossings.
    ///
    /// # Errors
    /// `io` where the store fails.
    pub(crate) fn append(&self, parts: &[(Part, [u64; 2])]) -> Result<Vec<Record>> {
        let mut pieces = Vec::new();
        for (part, counts) in parts {
            let mut plan = Plan::new(part.first_ray);
            part.rays_from(0).for_each(|runs| plan.push(runs.len() as u64));
            let closes = |rays: &Range<u64>| (rays.end == part.end_ray()).then_some(*counts);
            pieces.extend(plan.finish().into_iter().map(|rays| (part, closes(&rays), rays)));
        }
        let mut records = Vec::with_capacity(pieces.len());
        for pieces in pieces.chunks(4 * current_num_threads()) {
            let encoded = pieces.par_iter().map(|(part, closes, rays)| encode(part, rays, *closes));
            for (record, content) in encoded.collect::<Vec<_>>() {
                let bytes = [record.head(), content].concat();
                let at = self.store.append(&bytes).map_err(|error| Error::io("putting columns aside", error))?;
                records.push(Record { at, ..record });
            }
        }
        Ok(records)
    }

    /// Reads the part of a record, from the cache if it is there.
    ///
    /// # Errors
    /// `io` where the store fails or gives back other bytes than it was given.
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
    /// Those of [`Spill::part`].
    pub(crate) fn read(&self, record: &Record) -> Result<Part> {
        let wrong = |what: String| {
            let message = format!("columns that were put aside came back damaged at byte {}: {what}", record.at);
            Error::new("io", message, "look at the disk, and mesh again")
        };
        let mut content = vec![0; record.n_bytes as usize];
        let read = self.store.read(record.at + RECORD_HEAD as u64, &mut content);
        read.map_err(|error| Error::io("reading columns that were put aside", error))?;
        if crc32(&content) != record.crc {
            return Err(wrong("the checksum is wrong".into()));
        }
        let band = codec::decode(&content, record.n_rays, record.n_runs, self.depth).map_err(wrong)?;
        Ok(Part::new(Band { first_ray: record.first_ray, ..band }))
    }
}

/// The head of a store that is kept, for what `identity` stands for.
pub(crate) fn kept_head(identity: &[u8; 32]) -> Vec<u8> {
    let mut head = [&KEPT_MAGIC[..], &KEPT_VERSION.to_le_bytes(), identity].concat();
    head.extend(crc32(&head));
    head
}

/// The record of some rays of a part, its place still unknown, and its content.
fn encode(part: &Part, rays: &Range<u64>, closes: Option<[u64; 2]>) -> (Record, Vec<u8>) {
    let n_rays = (rays.end - rays.start) as u32;
    let mut encoder = Encoder::default();
    let runs = part.rays_from((rays.start - part.first_ray) as usize);
    runs.take(n_rays as usize).for_each(|runs| encoder.push(runs));
    let (n_runs, content) = encoder.finish();
    let (n_bytes, crc) = (content.len() as u32, crc32(&content));
    (Record { at: 0, first_ray: rays.start, n_rays, n_runs, n_bytes, closes, crc }, content)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A store for tests.
    #[derive(Default)]
    pub(crate) struct Memory(pub(crate) Mutex<Vec<u8>>);

    impl Store for Memory {
        fn append(&self, bytes: &[u8]) -> io::Result<u64> {
            let mut held = self.0.lock().unwrap();
            held.extend_from_slice(bytes);
            Ok((held.len() - bytes.len()) as u64)
        }

        fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()> {
            let held = self.0.lock().unwrap();
            let found = held.get(at as usize..at as usize + bytes.len()).ok_or(io::ErrorKind::UnexpectedEof)?;
            bytes.copy_from_slice(found);
            Ok(())
        }

        fn truncate(&self, n_bytes: u64) -> io::Result<()> {
            self.0.lock().unwrap().truncate(n_bytes as usize);
            Ok(())
        }
    }

    #[test]
    fn heads_read_back_and_damage_shows() {
        let record = Record {
            at: 7,
            first_ray: 1 << 40 | 5,
            n_rays: 3,
            n_runs: 9,
            n_bytes: 77,
            closes: Some([1, 1 << 33]),
            crc: [1, 2, 3, 4],
        };
        let head: [u8; RECORD_HEAD] = record.head().try_into().unwrap();
        assert_eq!(format!("{:?}", Record::from_head(7, &head)), format!("{:?}", Some(record)));
        for byte in 0..RECORD_HEAD {
            let mut head = head;
            head[byte] ^= 4;
            assert!(Record::from_head(7, &head).is_none(), "byte {byte}");
        }
    }
}
