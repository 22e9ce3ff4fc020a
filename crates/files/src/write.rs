//! Writing a mesh: one format a file, each nothing but bytes in file order to an `io::Write`.
//!
//! Mesh, format, options -> bytes. No writer seeks or holds the cells: flags come slab by slab from the columns, so a
//! file of any size needs a few slabs of memory. What else a format costs is at the top of its file.

#[doc(hidden)]
pub mod archive;
pub mod bits;
#[doc(hidden)]
pub mod cells;
pub mod column_file;
mod leaves;
#[doc(hidden)]
pub mod measured;
pub mod npy;
mod npz;
mod options;
mod ordered;
pub mod raw;
pub mod sidecar;
mod sink;
pub(crate) mod store;
pub mod vti;
mod vtp;
#[cfg(not(target_arch = "wasm32"))]
pub mod zarr;

use std::io;

use sha2::{Digest, Sha256};

use hexcast_core::base::checksum::hex;
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::Lines;
use hexcast_derived::distance::Distance;
use hexcast_derived::fractions::Fractions;
use hexcast_derived::mesh::Mesh;

pub use archive::{Array, write_arrays};
use cells::{Cells, Numbers};
pub use leaves::{leaf_arrays, write_leaves};
pub use measured::conformal::write_conformal;
pub use measured::distance::write_distance;
pub use measured::fractions::write_fractions;
pub use measured::links::{LinksFormat, write_links};
use measured::solid;
pub use measured::staggered::write_staggered;
pub use measured::tensors::write_tensors;
#[doc(hidden)]
pub use measured::{conformal, distance, fractions, links, staggered, tensors};
pub use options::{AxisOrder, Compress, Format, Options, Written};
pub use sidecar::sidecar_json;
pub use sink::Sink;
pub use store::Place;
use store::{OfCells, Store};
pub use vtp::leak_vtp;

/// Writes a mesh in file order, slab by slab; never seeks. Flushes at the end.
///
/// # Errors
/// `job-conflict` where format and options contradict each other, bits were asked of a mesh with several flags, or the format is not one
/// file ([`Format::FILES`]);
/// `job-value` where the compression level is not 1 to 9; `io` where `out` fails; `cancelled`, looked at before every slab.
pub fn write(
    mesh: &Mesh,
    format: Format,
    options: &Options,
    out: &mut dyn io::Write,
    control: &Control,
) -> Result<Written> {
    at_once(Cells::flags(mesh, options).write(format, out, &control.without_pauses()))
}

/// Writes the fraction of every cell that is not background, as 32-bit floating point, x fastest. Returns the number of bytes.
///
/// # Errors
/// `job-conflict` where mesh and fractions are not of the same box, the mesh has a halo, or the format is none of `.vti`, `.vtr`, `.npy` and `.zarr.zip`; `lines-graded` for `.vti`
/// where cells differ in size; `job-value` where the compression level is not 1 to 9; `io` where `out` fails; `cancelled`.
pub fn write_solid(
    mesh: &Mesh,
    fractions: &Fractions,
    (format, options): (Format, &Options),
    out: &mut dyn io::Write,
    control: &Control,
) -> Result<u64> {
    let cells = Cells::solid(mesh, fractions, options)?;
    Ok(at_once(cells.write(format, out, &control.without_pauses()))?.n_bytes)
}

/// Writes the signed distance of every cell or node, as 64-bit floating point, x fastest. Returns the number of bytes.
///
/// # Errors
/// `job-conflict` where mesh and distances are not of the same box, or the format is none of `.vti`, `.vtr`, `.npy` and, of cells, `.zarr.zip`; `lines-graded` for `.vti`
/// where cells differ in size; `job-value` where the compression level is not 1 to 9; `io` where `out` fails; `cancelled`.
pub fn write_distance_cells(
    mesh: &Mesh,
    distance: &Distance,
    (format, options): (Format, &Options),
    out: &mut dyn io::Write,
    control: &Control,
) -> Result<u64> {
    let cells = Cells::distance(mesh, distance, options)?;
    Ok(at_once(cells.write(format, out, &control.without_pauses()))?.n_bytes)
}

/// The bytes before and after the flags in a file that holds them as they are, for callers that make the file slab by slab;
/// None for compressed formats and the column file.
///
/// # Errors
/// Those of [`write()`] before the first byte.
pub fn around(mesh: &Mesh, format: Format, options: &Options) -> Result<Option<(Vec<u8>, Vec<u8>)>> {
    Cells::flags(mesh, options).around(format)
}

/// Refuses cells of many sizes for a format of equal ones, for callers that have no mesh yet.
///
/// # Errors
/// `lines-graded`.
pub fn check_lines(lines: &Lines, format: Format) -> Result<()> {
    if format == Format::Vti && lines.is_graded() {
        let message = "cells differ in size, and .vti holds equal ones only";
        return Err(Error::new("lines-graded", message, "write .vtr, which holds the lines of each axis"));
    }
    Ok(())
}

/// Returns the size of a file before it is written, in bytes; None where it depends on the flags.
pub fn exact_size(mesh: &Mesh, format: Format, options: &Options) -> Option<u64> {
    Cells::flags(mesh, options).exact_size(format)
}

/// Returns the size of a file of cells that are not known yet, in bytes, as far as it is known: without its head; None where it depends on
/// the flags.
#[doc(hidden)]
pub fn least_size(lines: &Lines, format: Format, options: &Options) -> Option<u64> {
    let is_plain = matches!(format, Format::Raw | Format::Npy)
        || matches!(format, Format::Vti | Format::Vtr) && options.compress == Compress::None;
    raw::n_bytes(lines.dims(), options.bits).filter(|_| is_plain)
}

/// Refuses options that the format would silently ignore, for callers that have no mesh yet.
///
/// # Errors
/// `job-conflict` and `job-value` as for [`write()`].
#[doc(hidden)]
pub fn check(format: Format, options: &Options) -> Result<()> {
    let name = format.extension();
    if format == Format::Zarr {
        let message = ".zarr is a folder of many files, and one file was to be written";
        let hint = "write the store with write::zarr, or with `hexcast mesh -o mesh.zarr`";
        return Err(Error::new("job-conflict", message, hint));
    }
    options.compress.check()?;
    if options.compress != Compress::None && matches!(format, Format::Raw | Format::Npy) {
        return Err(Error::new("job-conflict", format!(".{name} cannot be compressed"), "use .vti, .vtr or .hxc"));
    }
    let has_own_bytes = options.has_own_bytes();
    if has_own_bytes && !matches!(format, Format::Raw | Format::Npy | Format::Npz) {
        let message = format!(".{name} always has the flags, in one order of cells");
        let hint = "write .raw, .npy or .npz, or leave out axis order and map";
        return Err(Error::new("job-conflict", message, hint));
    }
    if has_own_bytes && options.bits {
        let message = "bits are given with an axis order or a map, which only bytes can have";
        return Err(Error::new("job-conflict", message, "leave out one of them"));
    }
    if options.bits && !matches!(format, Format::Raw | Format::Npy) {
        return Err(Error::new("job-conflict", format!(".{name} has no bit-packed variant"), "use .raw or .npy"));
    }
    Ok(())
}

impl<'a> Cells<'a> {
    /// The bytes before and after the numbers in a file that holds them as they are; None for compressed files, archives and column files.
    ///
    /// # Errors
    /// Those of a file before its first byte: what the format cannot hold, and options that it would ignore.
    pub fn around(&self, format: Format) -> Result<Option<(Vec<u8>, Vec<u8>)>> {
        self.check_format(format)?;
        check(format, self.options)?;
        check_lines(self.mesh.lines(), format)?;
        if self.options.bits {
            bits::check(self.mesh)?;
        }
        Ok(self.head_and_tail(format))
    }

    /// The size of a file before it is written, in bytes; None where it depends on the numbers.
    pub fn exact_size(&self, format: Format) -> Option<u64> {
        let (head, tail) = self.head_and_tail(format)?;
        self.n_bytes()?.checked_add((head.len() + tail.len()) as u64)
    }

    fn head_and_tail(&self, format: Format) -> Option<(Vec<u8>, Vec<u8>)> {
        match (format, self.options.compress) {
            (Format::Raw, _) => Some((Vec::new(), Vec::new())),
            (Format::Npy, _) => Some((self.npy_header(), Vec::new())),
            (Format::Vti | Format::Vtr, Compress::None) => Some(vti::head_and_tail(self, format)),
            _ => None,
        }
    }

    /// The files of a store.
    ///
    /// # Errors
    /// Those of [`Store::new`].
    pub fn store(&self) -> Result<Store<'a>> {
        let cells = match self.numbers {
            Numbers::Flags => OfCells::flags(),
            Numbers::Solid(fractions) => solid::cells_of_store(self.mesh, fractions)?,
            Numbers::Distance(distance) => distance::cells_of_store(self.mesh, distance)?,
        };
        Store::new(self.mesh, &Place::of_whole(self.mesh), cells, self.options)
    }

    /// Writes them in file order; never seeks. Flushes at the end.
    ///
    /// # Errors
    /// Those of [`Cells::around`]; `io` where `out` fails; `cancelled`, looked at before every slab.
    pub async fn write(&self, format: Format, out: &mut dyn io::Write, control: &Control) -> Result<Written> {
        let &Cells { mesh, options, .. } = self;
        let around = self.around(format)?;
        let mut sink = Sink::new(out, self.named());
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

#[cfg(test)]
pub(crate) mod tests;
