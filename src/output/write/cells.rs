//! What a file holds of its cells, one number each: their flags, in the order, by the map or as the bits of the options, or the fraction
//! that is not background.
//!
//! Cells, a format -> bytes in file order, with a rest before every slab: natively all at once, in wasm whenever the reader wants more.
//! Cost: two slabs of memory, and what the format takes.

use std::io;

use sha2::{Digest, Sha256};

use super::store::{OfCells, Place, Store};
use super::{Compress, Format, Options, Sink, Written, bits, check, check_lines, column_file, npy, npz, ordered, raw};
use super::{solid, vti};
use crate::base::checksum::hex;
use crate::base::control::Control;
use crate::base::error::Result;
use crate::derived::fractions::Fractions;
use crate::derived::mesh::Mesh;

/// The cells of a mesh as a file has them.
#[derive(Clone, Copy)]
pub(crate) struct Cells<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) options: &'a Options,
    /// Whose fractions the numbers are; flags where there are none.
    fractions: Option<&'a Fractions>,
}

impl<'a> Cells<'a> {
    /// The flags of a mesh.
    pub(crate) fn flags(mesh: &'a Mesh, options: &'a Options) -> Cells<'a> {
        Cells { mesh, options, fractions: None }
    }

    /// The fraction of every cell that is not background.
    ///
    /// # Errors
    /// `job-conflict` where mesh and fractions are not of the same box, or the mesh has a halo.
    pub(crate) fn solid(mesh: &'a Mesh, fractions: &'a Fractions, options: &'a Options) -> Result<Cells<'a>> {
        solid::check_dims(mesh, fractions)?;
        Ok(Cells { mesh, options, fractions: Some(fractions) })
    }

    /// The name of the numbers, and their type as VTK names it.
    pub(super) fn kind(&self) -> (&'static str, &'static str) {
        if self.fractions.is_some() { ("solid", "Float32") } else { ("flag", "UInt8") }
    }

    /// Number of their bytes; None where it would not fit 64 bits.
    pub(crate) fn n_bytes(&self) -> Option<u64> {
        match self.fractions {
            Some(_) => self.mesh.n_cells().checked_mul(4),
            None => raw::n_bytes(self.mesh.dims(), self.options.bits),
        }
    }

    /// Numbers that are made at a time.
    pub(crate) fn n_of_slab(&self) -> usize {
        // a fraction has four bytes
        if self.fractions.is_some() { self.options.slab_bytes / 4 } else { self.options.slab_bytes }
    }

    /// The bytes before and after the numbers in a file that holds them as they are; None for compressed files, archives and column files.
    ///
    /// # Errors
    /// Those of a file before its first byte: what the format cannot hold, and options that it would ignore.
    pub(crate) fn around(&self, format: Format) -> Result<Option<(Vec<u8>, Vec<u8>)>> {
        if self.fractions.is_some() {
            solid::check_format(format)?;
        }
        check(format, self.options)?;
        check_lines(&self.mesh.lines, format)?;
        if self.options.bits {
            bits::check(self.mesh)?;
        }
        Ok(self.head_and_tail(format))
    }

    pub(super) fn head_and_tail(&self, format: Format) -> Option<(Vec<u8>, Vec<u8>)> {
        let dims = self.mesh.dims();
        match (format, self.options.compress) {
            (Format::Raw, _) => Some((Vec::new(), Vec::new())),
            (Format::Npy, _) if self.fractions.is_some() => Some((solid::npy_header(dims), Vec::new())),
            (Format::Npy, _) => Some((npy::header(dims, self.options), Vec::new())),
            (Format::Vti | Format::Vtr, Compress::None) => Some(vti::head_and_tail(self, format)),
            _ => None,
        }
    }

    /// Hands over the bytes of all numbers in order.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails; `cancelled`; whatever `consume` returns.
    pub(super) async fn each(&self, control: &Control, consume: &mut dyn FnMut(&[u8]) -> Result<()>) -> Result<()> {
        let Cells { mesh, options, fractions } = self;
        let Some(fractions) = fractions else {
            return match options.bits {
                true => mesh.for_each_slab_of_bits_with_rests(options.slab_bytes, control, consume).await,
                false => ordered::for_each_slab(mesh, options, control, consume).await,
            };
        };
        let mut cell = 0;
        let mut put = |flags: &[u8]| {
            let bytes = solid::bytes(flags, cell, fractions);
            cell += flags.len() as u64;
            consume(&bytes)
        };
        mesh.for_each_slab_with_rests(self.n_of_slab(), control, &mut put).await
    }

    /// The files of a store.
    ///
    /// # Errors
    /// Those of [`Store::new`].
    pub(crate) fn store(&self) -> Result<Store<'a>> {
        let cells = match self.fractions {
            Some(fractions) => solid::cells_of_store(self.mesh, fractions)?,
            None => OfCells::flags(),
        };
        Store::new(self.mesh, &Place::of_whole(self.mesh), cells, self.options)
    }

    /// Writes them in file order; never seeks. Flushes at the end.
    ///
    /// # Errors
    /// Those of [`Cells::around`]; `io` where `out` fails; `cancelled`, looked at before every slab.
    pub(crate) async fn write(&self, format: Format, out: &mut dyn io::Write, control: &Control) -> Result<Written> {
        let Cells { mesh, options, fractions } = self;
        let around = self.around(format)?;
        let mut sink = Sink::new(out, if fractions.is_some() { "the fractions" } else { "the mesh" });
        sink.hash = (format == Format::Raw && options.sha256).then(Sha256::new);
        match (around, options.compress) {
            (Some((head, tail)), _) => {
                sink.put(&head)?;
                self.each(control, &mut |bytes| sink.put(bytes)).await?;
                sink.put(&tail)?;
            }
            (None, Compress::Zlib(level)) if matches!(format, Format::Vti | Format::Vtr) => {
                vti::write(self, (format, level), &mut sink, control).await?;
            }
            (None, _) if format == Format::Npz => npz::write(mesh, options, &mut sink, control).await?,
            (None, _) if format == Format::ZarrZip => self.store()?.zip(&mut sink, control).await?,
            (None, compress) => column_file::write(mesh, compress, &mut sink, control).await?,
        }
        let sha256 = sink.hash.take().map(|hash| hex(&hash.finalize()));
        Ok(Written { n_bytes: sink.finish()?, sha256 })
    }
}
