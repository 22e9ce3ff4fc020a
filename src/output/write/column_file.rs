//! Writing and reading a mesh as a column file; its layout is in [`crate::cells::columns::file`].
//!
//! The bytes do not depend on how the columns were split into bands. Cost: a piece a core while writing, an index while the file
//! is open. Smooth surfaces take 2 bytes a run and 1 a ray, and an eighth of that or less with zlib.

mod open;
#[cfg(test)]
mod tests;

pub use open::{is_column_file, may_continue, open, read};

use std::ops::Range;

use crate::base::control::Control;
use crate::base::error::Result;
use crate::base::parallel::*;
use crate::cells::columns::codec::{PieceEncoder, PieceSplitter};
use crate::cells::columns::file::end;
use crate::cells::columns::file::piece;
use crate::cells::columns::{Columns, Head};
use crate::derived::mesh::Mesh;
use crate::output::write::{Compress, Sink};

/// Writes a mesh as a column file.
pub(crate) fn write(mesh: &Mesh, compress: Compress, sink: &mut Sink, control: &Control) -> Result<()> {
    let mut encoder = ColumnFileEncoder::new(mesh, compress)?;
    loop {
        control.check()?;
        match encoder.step(mesh)? {
            Some(bytes) => sink.put(&bytes)?,
            None => return Ok(()),
        }
    }
}

/// Encodes a column file, some pieces at a time, for callers that do other work in between.
pub struct ColumnFileEncoder {
    level: Option<u8>,
    /// Rays of all pieces, and the number of pieces that are encoded.
    pieces: Vec<Range<u64>>,
    n_encoded: usize,
    /// The byte at which each piece starts, and its first ray.
    index: Vec<[u64; 2]>,
    /// Bytes returned so far.
    n_bytes: u64,
    is_done: bool,
}

impl ColumnFileEncoder {
    /// Plans the file of a mesh.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    pub fn new(mesh: &Mesh, compress: Compress) -> Result<ColumnFileEncoder> {
        let level = match compress {
            Compress::None => None,
            Compress::Zlib(level) => Some(level),
        };
        let pieces = pieces(&mesh.columns)?;
        Ok(ColumnFileEncoder { level, pieces, n_encoded: 0, index: Vec::new(), n_bytes: 0, is_done: false })
    }

    /// Returns the next bytes: the head, then two pieces a core at a time, then the end, then None.
    ///
    /// # Errors
    /// `job-value` where the head does not fit its limits; `io` where zlib fails.
    pub fn step(&mut self, mesh: &Mesh) -> Result<Option<Vec<u8>>> {
        let bytes = if self.n_bytes == 0 {
            head(mesh, self.level.is_some()).encode()?
        } else if self.n_encoded < self.pieces.len() {
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
        let end = (self.n_encoded + 2 * current_num_threads()).min(self.pieces.len());
        let batch = &self.pieces[self.n_encoded..end];
        let encode = |rays: &Range<u64>| encode_piece(mesh, rays.clone(), self.level);
        let encoded = batch.par_iter().map(encode).collect::<Result<Vec<_>>>()?;
        let mut bytes = Vec::new();
        for (rays, piece) in batch.iter().zip(encoded) {
            self.index.push([self.n_bytes + bytes.len() as u64, rays.start]);
            bytes.extend(piece);
        }
        self.n_encoded = end;
        Ok(bytes)
    }

    fn end(&self, mesh: &Mesh) -> Vec<u8> {
        end::encode(&self.index, &mesh.columns.totals(), self.n_bytes)
    }
}

/// The head of the file of a mesh.
fn head(mesh: &Mesh, zlib: bool) -> Head {
    let Mesh { lines, columns, names, unit, .. } = mesh;
    Head { identity: None, rays: columns.rays, zlib, lines: lines.clone(), unit: unit.clone(), names: names.clone() }
}

/// The rays of all pieces; the same for any split into bands.
fn pieces(columns: &Columns) -> Result<Vec<Range<u64>>> {
    let mut splitter = PieceSplitter::new(0);
    columns.for_rays(0..columns.rays.n_rays(), |runs| splitter.push(runs.len() as u64))?;
    Ok(splitter.finish())
}

/// Encodes a piece.
fn encode_piece(Mesh { columns, .. }: &Mesh, rays: Range<u64>, level: Option<u8>) -> Result<Vec<u8>> {
    let n_rays = (rays.end - rays.start) as u32;
    // the whole is one band: its last piece has all counts
    let counts = (rays.end == columns.rays.n_rays()).then(|| [columns.odd_rays(), columns.n_crossings()]);
    let mut encoder = PieceEncoder::default();
    columns.for_rays(rays, |runs| encoder.push(runs))?;
    piece::encode(n_rays, encoder, level, counts)
}
