//! Writing and reading a mesh as a column file; its layout stands in [`crate::columns::file`].
//!
//! The bytes do not depend on how the columns were split in bands. Cost: a piece a core while writing; 4 bytes a ray and a run
//! while reading to memory, nothing but an index where the file is only opened. Smooth surfaces take 2 bytes a run and 1 a ray,
//! and an eighth of that or less with zlib.

mod open;
mod read;
#[cfg(test)]
mod tests;

pub use open::{is_column_file, open};
pub use read::{read_columns, read_columns_within};

use std::ops::Range;

use crate::columns::codec::{self, Plan};
use crate::columns::file::end::{self, Totals};
use crate::columns::file::head::VERSION;
use crate::columns::file::piece::{self, PieceHead};
use crate::columns::{Columns, Head};
use crate::control::Control;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::parallel::*;
use crate::write::{Compress, Sink};

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
    index: Vec<[u64; 2]>,
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
            head(mesh, self.level.is_some()).encode()?
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
        for (place, (rays, (head, stored))) in batch.iter().zip(encoded).enumerate() {
            self.index.push([self.n_bytes + bytes.len() as u64, rays.start]);
            // the whole is one band: its last piece has all counts
            let ends_band = self.n_made + place + 1 == self.pieces.len();
            let counts = if ends_band { [mesh.columns.odd_rays(), mesh.columns.n_crossings()] } else { [0; 2] };
            bytes.extend(PieceHead { counts, ends_band, ..head }.to_bytes());
            bytes.extend(stored);
        }
        self.n_made = end;
        Ok(bytes)
    }

    fn end(&self, mesh: &Mesh) -> Vec<u8> {
        end::encode(VERSION, &self.index, &totals(&mesh.columns), self.n_bytes)
    }
}

/// The head of the file of a mesh.
fn head(mesh: &Mesh, zlib: bool) -> Head {
    let Mesh { lines, columns, names, unit } = mesh;
    Head { identity: None, rays: columns.rays, zlib, lines: *lines, unit: unit.clone(), names: names.clone() }
}

fn totals(columns: &Columns) -> Totals {
    let [odd_rays, n_crossings] = [columns.odd_rays(), columns.n_crossings()];
    Totals { n_runs: columns.n_runs(), odd_rays, n_crossings, cells: Box::new(columns.cells_per_flag()) }
}

/// The rays of all pieces; the same for any split in bands.
fn plan(columns: &Columns) -> Result<Vec<Range<u64>>> {
    let mut plan = Plan::new(0);
    columns.for_rays(0..columns.rays.n_rays(), |runs| plan.push(runs.len() as u64))?;
    Ok(plan.finish())
}

/// A piece: its head, still without counts, and its stored bytes.
fn encode_piece(mesh: &Mesh, rays: Range<u64>, level: Option<u8>) -> Result<(PieceHead, Vec<u8>)> {
    let n_rays = (rays.end - rays.start) as u32;
    let mut encoder = codec::Encoder::default();
    mesh.columns.for_rays(rays, |runs| encoder.push(runs))?;
    piece::encode(n_rays, encoder, level)
}
