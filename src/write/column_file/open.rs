//! Opening a column file without reading it: its head, its index, its totals.
//!
//! Store -> [`Mesh`] whose columns stay where they are. Cost: 24 bytes of memory a piece; a file of version 1, which has no
//! totals, is read once, a piece a core at a time.

use std::io;
use std::sync::Arc;

use crate::checksum::crc32;
use crate::columns::codec::PIECE_RAYS;
use crate::columns::file::corrupt;
use crate::columns::file::end::{self, TAIL, Totals};
use crate::columns::file::head::{self, MAGIC, START};
use crate::columns::{Band, Columns, Head, Part, Record, Store, Stored};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::parallel::*;

/// Whether bytes begin a column file of any version; 8 are enough.
pub fn is_column_file(start: &[u8]) -> bool {
    start.starts_with(&MAGIC)
}

/// Opens the column file of `n_bytes` bytes in a store; at most `max_bytes` of memory are taken for its index and for what is
/// read of it later. Damage of a piece shows when it is read.
///
/// # Errors
/// `columns-corrupt` where head or end is damaged or the file is not finished; `columns-version` where a newer hexcast wrote
/// it; `memory` where the index does not fit; `io` where the store fails; `cancelled`.
pub fn open(store: Arc<dyn Store>, n_bytes: u64, max_bytes: u64, control: &Control) -> Result<Mesh> {
    let file = File { store: &*store, n_bytes };
    let (version, head, start) = file.head()?;
    let (at, end) = file.end(start, max_bytes)?;
    let (index, totals) = end::decode(version, &end, at)?;
    let records = records(&index, start, at, head.rays.n_rays())?;
    let index_bytes = size_of_val(records.as_slice()) as u64;
    let stored = Stored::foreign(store, head.rays.depth, head.zlib, max_bytes.saturating_sub(index_bytes));
    let totals = match totals {
        Some(totals) => totals,
        None => counted(&stored, &records, head.rays.depth, control)?,
    };
    let n_cells = head.lines.n_cells();
    let n_flagged = totals.cells.iter().try_fold(0u64, |sum, &cells| sum.checked_add(cells));
    if totals.n_runs > n_cells || n_flagged.is_none_or(|n| n > n_cells) || totals.odd_rays > head.rays.n_rays() {
        return Err(corrupt(format!("the end at byte {at}: it counts more than there is")));
    }
    let columns = Columns::in_file(head.rays, stored, records, totals, n_bytes);
    Mesh::new(head.lines, columns, head.names, head.unit)
}

/// The bytes of a file.
struct File<'a> {
    store: &'a dyn Store,
    n_bytes: u64,
}

impl File<'_> {
    fn read(&self, at: u64, n: usize, part: &str) -> Result<Vec<u8>> {
        if at.checked_add(n as u64).is_none_or(|end| end > self.n_bytes) {
            let missing = (at + n as u64).saturating_sub(self.n_bytes);
            let message = format!("the file ends at byte {}, {missing} bytes before the {part} does", self.n_bytes);
            return Err(corrupt(message));
        }
        let mut bytes = vec![0; n];
        self.store.read(at, &mut bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => corrupt(format!("the file ends before byte {}", at + n as u64)),
            _ => Error::io(format_args!("reading the column file at byte {at}"), error),
        })?;
        Ok(bytes)
    }

    /// Version, head, and the byte behind it.
    fn head(&self) -> Result<(u32, Head, u64)> {
        let (version, n_body) = head::start(&self.read(0, START, "head")?)?;
        let bytes = self.read(0, START + n_body + 4, "head")?;
        let (head, crc) = bytes.split_at(START + n_body);
        if crc != crc32(head) {
            return Err(corrupt(format!("the checksum of the head, bytes 0 to {}, is wrong", head.len())));
        }
        Ok((version, head::decode(version, &head[START..])?, bytes.len() as u64))
    }

    /// The end without its tail, and the byte where it starts.
    fn end(&self, start: u64, max_bytes: u64) -> Result<(u64, Vec<u8>)> {
        let unfinished = || {
            let message =
                format!("the file of {} bytes has no end: it is cut short or was never finished", self.n_bytes);
            corrupt(message)
        };
        let place = self.n_bytes.checked_sub(TAIL as u64).filter(|place| *place >= start).ok_or_else(unfinished)?;
        let tail = self.read(place, TAIL, "end")?;
        let at = tail.first_chunk().and_then(end::place).filter(|at| (start..place).contains(at));
        let at = at.ok_or_else(unfinished)?;
        // as bytes, as an index and as records
        let needed = 4 * (place - at);
        if needed > max_bytes {
            let message = format!("the index of the column file takes {needed} bytes; {max_bytes} are allowed");
            return Err(Error::new("memory", message, crate::error::MORE_MEMORY));
        }
        Ok((at, self.read(at, (place - at) as usize, "end")?))
    }
}

/// The pieces of an index: in the order of their rays, all of them, between head and end.
fn records(index: &[[u64; 2]], start: u64, end: u64, n_rays: u64) -> Result<Vec<Record>> {
    let wrong = |piece: usize| corrupt(format!("piece {piece} of the index does not fit the one before it"));
    let mut records = Vec::with_capacity(index.len());
    let mut next = [start, 0];
    for (piece, &[at, first_ray]) in index.iter().enumerate() {
        let end_ray = index.get(piece + 1).map_or(n_rays, |[_, first_ray]| *first_ray);
        let n = end_ray.checked_sub(first_ray).filter(|n| (1..=u64::from(PIECE_RAYS)).contains(n));
        let fits = at >= next[0] && at < end && first_ray == next[1];
        let n = n.filter(|_| fits).ok_or_else(|| wrong(piece))?;
        records.push(Record { at, first_ray, n_rays: n as u32 });
        next = [at + 1, end_ray];
    }
    if next[1] == n_rays { Ok(records) } else { Err(wrong(index.len())) }
}

/// Counts what the pieces of a file without totals hold.
fn counted(stored: &Stored, records: &[Record], depth: u32, control: &Control) -> Result<Totals> {
    let mut totals = Totals { n_runs: 0, odd_rays: 0, n_crossings: 0, cells: Box::new([0; 256]) };
    for batch in records.chunks(current_num_threads()) {
        control.check()?;
        let of_piece = |record: &Record| -> Result<([u64; 3], [u64; 256])> {
            let band = stored.band(record)?;
            let counts = [band.runs.len() as u64, band.odd_rays, band.n_crossings];
            let mut cells = [0; 256];
            Part::new(Band { first_ray: 0, ..band }).add_cells(depth, &mut cells);
            Ok((counts, cells))
        };
        for (counts, cells) in batch.par_iter().map(of_piece).collect::<Result<Vec<_>>>()? {
            for (sum, count) in
                [&mut totals.n_runs, &mut totals.odd_rays, &mut totals.n_crossings].into_iter().zip(counts)
            {
                let more = sum.checked_add(count);
                *sum = more.ok_or_else(|| corrupt("the pieces count more crossings than fit 64 bits".into()))?;
            }
            totals.cells.iter_mut().zip(cells).for_each(|(sum, cells)| *sum += cells);
        }
    }
    totals.cells[0] = 0;
    Ok(totals)
}
