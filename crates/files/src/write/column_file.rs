//! Writing and reading a mesh as a column file; its layout is in [`hexcast_core::cells::columns::file`].
//!
//! The bytes do not depend on how the columns were split into bands. Cost: a piece a core while writing, an index while the file
//! is open. Smooth surfaces take 2 bytes a run and 1 a ray, and an eighth of that or less with zlib.

mod open;
#[cfg(test)]
mod tests;

pub use open::{is_column_file, may_continue, open, read};

use std::ops::Range;

use crate::write::{Compress, Sink};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::parallel::*;
use hexcast_core::cells::columns::codec::{PieceEncoder, PieceSplitter};
use hexcast_core::cells::columns::file::end;
use hexcast_core::cells::columns::file::piece;
use hexcast_core::cells::columns::{Columns, Head};
use hexcast_derived::mesh::Mesh;

/// Writes a mesh as a column file, with which the sink begins: the head, then two pieces a core at a time, with a rest before them, then the
/// end.
///
/// # Errors
/// `job-value` where the head does not fit its limits; `io` where zlib or the sink fails, or the columns are in a store that does; `cancelled`.
#[doc(hidden)]
pub async fn write(mesh: &Mesh, compress: Compress, sink: &mut Sink<'_>, control: &Control) -> Result<()> {
    let level = match compress {
        Compress::None => None,
        Compress::Zlib(level) => Some(level),
    };
    control.check()?;
    sink.put(&head(mesh, level.is_some()).encode()?)?;
    // the byte at which each piece starts, and its first ray
    let mut index = Vec::new();
    for batch in pieces(mesh.columns())?.chunks(2 * current_num_threads()) {
        control.rest().await?;
        let encode = |rays: &Range<u64>| encode_piece(mesh.columns(), rays.clone(), level);
        for (rays, piece) in batch.iter().zip(batch.par_iter().map(encode).collect::<Result<Vec<_>>>()?) {
            index.push([sink.n_bytes, rays.start]);
            sink.put(&piece)?;
        }
    }
    control.rest().await?;
    sink.put(&end::encode(&index, &mesh.columns().totals(), sink.n_bytes))
}

/// The head of the file of a mesh.
fn head(mesh: &Mesh, zlib: bool) -> Head {
    Head {
        identity: None,
        rays: *mesh.columns().rays(),
        zlib,
        lines: mesh.lines().clone(),
        unit: mesh.unit().map(str::to_string),
        names: mesh.names().to_vec(),
    }
}

/// The rays of all pieces; the same for any split into bands.
fn pieces(columns: &Columns) -> Result<Vec<Range<u64>>> {
    let mut splitter = PieceSplitter::new(0);
    columns.for_rays(0..columns.rays().n_rays(), |runs| splitter.push(runs.len() as u64))?;
    Ok(splitter.finish())
}

/// Encodes a piece.
fn encode_piece(columns: &Columns, rays: Range<u64>, level: Option<u8>) -> Result<Vec<u8>> {
    let n_rays = (rays.end - rays.start) as u32;
    // the whole is one band: its last piece has all counts
    let counts = (rays.end == columns.rays().n_rays()).then(|| [columns.odd_rays(), columns.n_crossings()]);
    let mut encoder = PieceEncoder::default();
    columns.for_rays(rays, |runs| encoder.push(runs))?;
    piece::encode(n_rays, encoder, level, counts)
}
