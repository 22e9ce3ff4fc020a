//! Opening a column file without reading it: its head, its index, its totals.
//!
//! Store -> [`Mesh`] whose columns stay in the store. Cost: 24 bytes of memory a piece.

use std::io::{self, Read};
use std::sync::Arc;

use hexcast_core::base::checksum::crc32;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::codec::PIECE_RAYS;
use hexcast_core::cells::columns::file::corrupt;
use hexcast_core::cells::columns::file::end::{self, TAIL};
use hexcast_core::cells::columns::file::head::{self, MAGIC, START};
use hexcast_core::cells::columns::{Columns, Head, MemoryStore, PieceEntry, PieceStore, Store, TotalsCheck};
use hexcast_derived::mesh::Mesh;

/// Whether a file that starts with these bytes, 8 at least, is a column file of any version.
pub fn is_column_file(start: &[u8]) -> bool {
    start.starts_with(&MAGIC)
}

/// Whether a file that starts with these bytes, and may end after them, may become a column file when it is continued.
pub fn may_continue(start: &[u8]) -> bool {
    MAGIC.starts_with(&start[..start.len().min(MAGIC.len())])
}

/// Opens the column file of `n_bytes` bytes in a store; at most `max_bytes` of memory are taken for its index and for what is
/// read of it later. Damage of a piece shows when it is read, totals that are not those of the pieces when all were read.
///
/// # Errors
/// `columns-corrupt` where head or end is damaged or the file is not finished; `columns-version` where a newer hexcast wrote
/// it; `memory` where the index does not fit; `io` where the store fails.
pub fn open(store: Arc<dyn Store>, n_bytes: u64, max_bytes: u64) -> Result<Mesh> {
    let file = File { store: &*store, n_bytes };
    let (head, start) = file.head()?;
    let (at, end) = file.end(start, max_bytes)?;
    let (index, totals) = end::decode(&end, at)?;
    let entries = entries(&index, start, at, head.rays.n_rays())?;
    let max_bytes = max_bytes.saturating_sub(size_of_val(entries.as_slice()) as u64);
    let mut pieces = PieceStore::foreign(store, n_bytes, head.rays.depth, head.zlib, max_bytes);
    pieces.entries = entries;
    pieces.totals_check = Some(TotalsCheck::new(totals.clone(), pieces.entries.len()));
    let n_cells = head.lines.n_cells();
    let n_flagged = totals.cells.iter().try_fold(0u64, |sum, &cells| sum.checked_add(cells));
    if totals.n_runs > n_cells || n_flagged.is_none_or(|n| n > n_cells) || totals.odd_rays > head.rays.n_rays() {
        return Err(corrupt(format!("the end at byte {at}: its totals exceed the mesh")));
    }
    let columns = Columns::in_store(head.rays, pieces, totals);
    Mesh::new(head.lines, columns, head.names, head.unit)
}

/// Reads a column file to memory and opens it there, for input that is not a file; both take half of `max_bytes`.
///
/// # Errors
/// Those of [`open()`]; `memory` where the file does not fit; `io` where `input` fails.
pub fn read(input: &mut dyn Read, max_bytes: u64) -> Result<Mesh> {
    let mut bytes = Vec::new();
    let most = max_bytes / 2;
    let read = input.take(most.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|error| Error::io(format_args!("reading the column file at byte {}", bytes.len()), error))?;
    let n_bytes = bytes.len() as u64;
    if n_bytes > most {
        let message = format!("the column file has more than the {most} bytes that are allowed for it");
        return Err(Error::new("memory", message, "write it to a file first, or allow more memory"));
    }
    open(Arc::new(MemoryStore::new(bytes)), n_bytes, most)
}

/// The bytes of a file.
struct File<'a> {
    store: &'a dyn Store,
    n_bytes: u64,
}

impl File<'_> {
    fn read(&self, at: u64, n: usize, section: &str) -> Result<Vec<u8>> {
        if at.checked_add(n as u64).is_none_or(|end| end > self.n_bytes) {
            let missing = (at + n as u64).saturating_sub(self.n_bytes);
            let message = format!("the file ends at byte {}, {missing} bytes before the {section} does", self.n_bytes);
            return Err(corrupt(message));
        }
        let mut bytes = vec![0; n];
        self.store.read(at, &mut bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => corrupt(format!("the file ends before byte {}", at + n as u64)),
            _ => Error::io(format_args!("reading the column file at byte {at}"), error),
        })?;
        Ok(bytes)
    }

    /// The head, and the offset of the first byte after it.
    fn head(&self) -> Result<(Head, u64)> {
        let (version, n_body) = head::start(&self.read(0, START, "head")?)?;
        let bytes = self.read(0, START + n_body + 4, "head")?;
        let (head, crc) = bytes.split_at(START + n_body);
        if crc != crc32(head) {
            return Err(corrupt(format!("the checksum of the head, bytes 0 to {}, is wrong", head.len())));
        }
        Ok((head::decode(version, &head[START..])?, bytes.len() as u64))
    }

    /// The end without its tail, and the byte at which it starts.
    fn end(&self, start: u64, max_bytes: u64) -> Result<(u64, Vec<u8>)> {
        let unfinished = || {
            let message =
                format!("the file of {} bytes has no end: it is cut short or was never finished", self.n_bytes);
            corrupt(message)
        };
        let tail_at = self.n_bytes.checked_sub(TAIL as u64).filter(|at| *at >= start).ok_or_else(unfinished)?;
        let tail = self.read(tail_at, TAIL, "end")?;
        let at = tail.first_chunk().and_then(end::start).filter(|at| (start..tail_at).contains(at));
        let at = at.ok_or_else(unfinished)?;
        // as bytes, as an index and as entries
        let needed = 4 * (tail_at - at);
        if needed > max_bytes {
            let message = format!("the index of the column file takes {needed} bytes; {max_bytes} are allowed");
            return Err(Error::new("memory", message, hexcast_core::base::error::MORE_MEMORY));
        }
        Ok((at, self.read(at, (tail_at - at) as usize, "end")?))
    }
}

/// The pieces of an index: all of them, in the order of their rays, between head and end.
fn entries(index: &[[u64; 2]], start: u64, end: u64, n_rays: u64) -> Result<Vec<PieceEntry>> {
    let wrong = |piece: usize| corrupt(format!("piece {piece} of the index does not fit the one before it"));
    let mut entries = Vec::with_capacity(index.len());
    let mut next = [start, 0];
    for (piece, &[at, first_ray]) in index.iter().enumerate() {
        let end_ray = index.get(piece + 1).map_or(n_rays, |[_, first_ray]| *first_ray);
        let n = end_ray.checked_sub(first_ray).filter(|n| (1..=u64::from(PIECE_RAYS)).contains(n));
        let fits = at >= next[0] && at < end && first_ray == next[1];
        let n = n.filter(|_| fits).ok_or_else(|| wrong(piece))?;
        entries.push(PieceEntry { at, first_ray, n_rays: n as u32 });
        next = [at + 1, end_ray];
    }
    if next[1] == n_rays { Ok(entries) } else { Err(wrong(index.len())) }
}
