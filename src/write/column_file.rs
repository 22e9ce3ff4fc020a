//! The column file, `.hxc`: a mesh as its runs, some bytes a ray instead of one a cell; lossless, and it reads back.
//!
//! All numbers are little-endian. `u8`, `u32`, `u64` are unsigned integers, `f64` is IEEE 754, a *text* is a u32 number
//! of bytes and that many bytes of UTF-8, a *varint* is LEB128: seven bits a byte, lowest first, the top bit set on all
//! bytes but the last, at most five bytes and below 2^32. `crc32` is that of zlib and PNG.
//!
//! A file is a head, pieces, an end; nothing follows.
//!
//! **Head.**
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `89 48 58 43 0d 0a 1a 0a` (`.HXC`, CR LF, ctrl-Z, LF) |
//! | u32 | version of the layout: 1. A reader refuses a higher one here |
//! | u32 | number of bytes of the body, at most 2^20 |
//! | body | 3 u32 `dims`: cells on x, y, z, 1 to 2^24 each, their product below 2^63 |
//! | | u8 `axis` of the rays: 0, 1, 2; u8 compression of pieces: 0 none, 1 zlib; u8 kind of lines: 0 uniform; u8 zero |
//! | | 3 f64 `origin`, 3 f64 `spacing`: line i of an axis is origin + i * spacing |
//! | | u8 1 and a text: the unit of lengths; or u8 0: none was named |
//! | | u32 number of names; for each a u8 flag (not 0) and a text: the name of the flag |
//! | u32 | crc32 of all bytes before |
//!
//! **Pieces.** The rays follow each other by their index `i + n_i * j`, where i and j count cells along the first and the
//! second of the two axes across `axis`, in the order x, y, z. A piece holds 1 to 2^16 whole rays and at most 2^18 runs,
//! or one ray with any number of runs.
//!
//! | bytes | what |
//! |---|---|
//! | 4 | `PIEC` |
//! | u32 | number of rays |
//! | u32 | number of runs |
//! | u32 | number of bytes of the content |
//! | u32 | number of bytes stored: the content, or a zlib stream of it |
//! | u32 | crc32 of the stored bytes |
//! | u64 | odd rays; u64 crossings: the sums over all pieces are those of the mesh |
//! | u32 | crc32 of the 40 bytes before |
//! | ... | the stored bytes |
//!
//! The content is three lists one after the other: a varint a ray, its number of runs; a varint a run, its first cell; a
//! u8 a run, its flag. A run reaches to the cell before the next run of its ray, the last to the end of the ray; cells
//! before the first run have flag 0; cells ascend, and a flag differs from the one before it (0 before the first).
//! The first cell is stored as its difference d from a guess, as 2 d for d >= 0 and -2 d - 1 for d < 0. The guess for
//! run k of a ray is the cell of run k of the ray before, if that ray is in this piece and has such a run; otherwise the
//! cell of run k - 1 of the same ray, or 0 for k = 0.
//!
//! **End.**
//!
//! | bytes | what |
//! |---|---|
//! | 4 | `ENDS` |
//! | u64 | number of pieces; for each a u64, the byte at which it starts, and a u64, the index of its first ray |
//! | u64 | number of runs of all pieces |
//! | u32 | crc32 of the bytes from `ENDS` on |
//! | u64 | the byte at which `ENDS` stands, so that the index is found from the end of the file |
//! | 8 | `HXC END` and LF |
//!
//! The bytes do not depend on how the columns were split in bands. Cost: a piece a core while writing; 4 bytes a ray and a
//! run while reading. Smooth surfaces take 2 bytes a run and 1 a ray, and an eighth of that or less with zlib.

mod head;
mod layout;
mod read;
#[cfg(test)]
mod tests;

use layout::{END_MAGIC, END_TAG, PIECE_TAG};
pub use read::{read_columns, read_columns_within};

use std::ops::Range;

use crate::checksum::crc32;
use crate::columns::Columns;
use crate::columns::codec::{self, Plan};
use crate::control::Control;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::parallel::*;
use crate::write::{Compress, Sink, zlib};

/// Writes a mesh as a column file.
pub(crate) fn write(mesh: &Mesh, compress: Compress, sink: &mut Sink, control: &Control) -> Result<()> {
    let mut encoder = Encoder::new(mesh, compress)?;
    loop {
        control.check()?;
        match encoder.step(mesh)? {
            Some(bytes) => sink.put(&bytes)?,
            None => return Ok(()),
        }
    }
}

/// A column file in the making, some pieces at a time, for callers that have other things to do between them.
pub struct Encoder {
    level: Option<u8>,
    /// Rays of all pieces, and the number of pieces that were made.
    pieces: Vec<Range<u64>>,
    n_made: usize,
    /// The byte at which each piece starts, and its first ray, as the end has them.
    index: Vec<u8>,
    /// Bytes handed out.
    n_bytes: u64,
    is_done: bool,
}

impl Encoder {
    /// Plans the file of a mesh.
    ///
    /// # Errors
    /// Those of the store, where columns were put aside.
    pub fn new(mesh: &Mesh, compress: Compress) -> Result<Encoder> {
        let level = match compress {
            Compress::None => None,
            Compress::Zlib(level) => Some(level),
        };
        let pieces = plan(&mesh.columns)?;
        Ok(Encoder { level, pieces, n_made: 0, index: Vec::new(), n_bytes: 0, is_done: false })
    }

    /// Makes the next bytes: the head, then two pieces a core at a time, then the end, then none.
    ///
    /// # Errors
    /// `job-value` where the head does not fit its limits; `io` where zlib fails.
    pub fn step(&mut self, mesh: &Mesh) -> Result<Option<Vec<u8>>> {
        let bytes = if self.n_bytes == 0 {
            head::encode(mesh, self.level.is_some())?
        } else if self.n_made < self.pieces.len() {
            self.batch(mesh)?
        } else if !self.is_done {
            self.is_done = true;
            self.end(mesh)
        } else {
            return Ok(None);
        };
        self.n_bytes += bytes.len() as u64;
        Ok(Some(bytes))
    }

    fn batch(&mut self, mesh: &Mesh) -> Result<Vec<u8>> {
        let end = (self.n_made + 2 * current_num_threads()).min(self.pieces.len());
        let batch = &self.pieces[self.n_made..end];
        let encode = |rays: &Range<u64>| encode_piece(mesh, rays.clone(), self.level);
        let encoded = batch.par_iter().map(encode).collect::<Result<Vec<_>>>()?;
        let mut bytes = Vec::new();
        for (place, (rays, (mut head, stored))) in batch.iter().zip(encoded).enumerate() {
            self.index.extend((self.n_bytes + bytes.len() as u64).to_le_bytes());
            self.index.extend(rays.start.to_le_bytes());
            // the first piece carries the counts of all
            let is_first = self.n_made + place == 0;
            let counts = if is_first { [mesh.columns.odd_rays(), mesh.columns.n_crossings()] } else { [0; 2] };
            counts.iter().for_each(|count| head.extend(count.to_le_bytes()));
            head.extend(crc32(&head));
            bytes.append(&mut head);
            bytes.extend(stored);
        }
        self.n_made = end;
        Ok(bytes)
    }

    fn end(&self, mesh: &Mesh) -> Vec<u8> {
        let n_pieces = (self.pieces.len() as u64).to_le_bytes();
        let mut end = [END_TAG.as_slice(), &n_pieces, &self.index, &mesh.columns.n_runs().to_le_bytes()].concat();
        end.extend(crc32(&end));
        end.extend(self.n_bytes.to_le_bytes());
        end.extend(END_MAGIC);
        end
    }
}

/// The rays of all pieces; the same for any split in bands.
fn plan(columns: &Columns) -> Result<Vec<Range<u64>>> {
    let mut plan = Plan::new(0);
    columns.for_rays(0..columns.rays.n_rays(), |runs| plan.push(runs.len() as u64))?;
    Ok(plan.finish())
}

/// The head of a piece up to the crossings, and its stored bytes.
fn encode_piece(mesh: &Mesh, rays: Range<u64>, level: Option<u8>) -> Result<(Vec<u8>, Vec<u8>)> {
    let n_rays = (rays.end - rays.start) as u32;
    let mut encoder = codec::Encoder::default();
    mesh.columns.for_rays(rays, |runs| encoder.push(runs))?;
    let (n_runs, content) = encoder.finish();
    let n_content = content.len() as u32;
    let stored = match level {
        None => content,
        Some(level) => zlib::compress(&content, level)?,
    };
    let numbers = [n_rays, n_runs, n_content, stored.len() as u32];
    let mut head = PIECE_TAG.to_vec();
    numbers.iter().for_each(|number| head.extend(number.to_le_bytes()));
    head.extend(crc32(&stored));
    Ok((head, stored))
}
