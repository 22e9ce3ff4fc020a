//! Writing a mesh: one format a file, each nothing but bytes in file order to an `io::Write`.
//!
//! Mesh, format, options -> bytes. No writer seeks or holds the cells: flags come slab by slab from the columns, so a
//! file of any size needs a few slabs of memory. What else a format costs is at the top of its file.

pub(crate) mod archive;
pub mod bits;
pub(crate) mod cells;
pub mod column_file;
pub(crate) mod fractions;
pub(crate) mod links;
pub mod npy;
mod npz;
mod options;
mod ordered;
pub mod raw;
pub mod sidecar;
mod sink;
mod solid;
pub(crate) mod staggered;
pub(crate) mod store;
pub mod vti;
mod vtp;
#[cfg(not(target_arch = "wasm32"))]
pub mod zarr;

use std::io;

use crate::base::control::{Control, at_once};
use crate::base::error::{Error, Result};
use crate::derived::mesh::Mesh;
use crate::grid::lines::Lines;

pub use archive::{Array, write_arrays};
use cells::Cells;
pub use fractions::write_fractions;
pub use links::{LinksFormat, write_links};
pub use options::{AxisOrder, Compress, Format, Options, Written};
pub use sidecar::sidecar_json;
pub(crate) use sink::Sink;
pub use solid::write_solid;
pub use staggered::write_staggered;
pub use store::Place;
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
    let cells = Cells::flags(mesh, options);
    let (head, tail) = cells.head_and_tail(format)?;
    cells.n_bytes()?.checked_add((head.len() + tail.len()) as u64)
}

/// Refuses options that the format would silently ignore.
fn check(format: Format, options: &Options) -> Result<()> {
    let name = format.extension();
    if format == Format::Zarr {
        let message = ".zarr is a folder of many files, and one file was to be written";
        let hint = "write the store with write::zarr, or with `hexcast mesh -o mesh.zarr`";
        return Err(Error::new("job-conflict", message, hint));
    }
    if let Compress::Zlib(level) = options.compress {
        if !(1..=9).contains(&level) {
            return Err(Error::new(
                "job-value",
                format!("compression level {level} is not 1 to 9"),
                "6 is enough for flags",
            ));
        }
        if matches!(format, Format::Raw | Format::Npy) {
            return Err(Error::new("job-conflict", format!(".{name} cannot be compressed"), "use .vti, .vtr or .hxc"));
        }
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

#[cfg(test)]
pub(crate) mod tests;
