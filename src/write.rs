//! Writing a mesh: one format a file, each nothing but bytes in file order to an `io::Write`.
//!
//! Mesh, format, options -> bytes. No writer seeks or holds the cells: flags come slab by slab from the columns, so a
//! file of any size needs a few slabs of memory. What a format costs besides is said at the top of its file.

pub mod bits;
pub mod column_file;
pub mod npy;
pub mod raw;
pub mod sidecar;
pub mod vti;
#[cfg(all(feature = "zarr", not(target_arch = "wasm32")))]
pub mod zarr;
pub(crate) mod zlib;

use std::io;

use sha2::{Digest, Sha256};

use crate::control::Control;
use crate::error::{Error, Result};
use crate::mesh::{Mesh, SLAB_BYTES, hex};
use crate::parallel::beside;

pub use sidecar::sidecar_json;

/// A file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Flags only, one byte (or bit) a cell, x fastest; [`sidecar_json`] describes them.
    Raw,
    /// NumPy array of shape (nz, ny, nx).
    Npy,
    /// VTK image data, for ParaView.
    Vti,
    /// hexcast's own column file, which reads back.
    Columns,
}

impl Format {
    /// Every format, in the order of the documentation.
    pub const ALL: [Format; 4] = [Format::Raw, Format::Npy, Format::Vti, Format::Columns];

    /// Tells the format from the extension of a file name, upper or lower case.
    ///
    /// # Errors
    /// `job-value` where the extension is none of those of [`Format::ALL`].
    pub fn of_name(name: &str) -> Result<Format> {
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension).to_ascii_lowercase();
        Format::ALL.into_iter().find(|format| format.extension() == extension).ok_or_else(|| {
            let known = Format::ALL.map(|format| format!(".{}", format.extension())).join(", ");
            Error::new(
                "job-value",
                format!("{name}: no format has the extension \"{extension}\""),
                format!("use {known}"),
            )
        })
    }

    /// Extension of file names, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Raw => "raw",
            Format::Npy => "npy",
            Format::Vti => "vti",
            Format::Columns => "hxc",
        }
    }

    /// Media type.
    pub fn mime(self) -> &'static str {
        match self {
            Format::Vti => "application/vnd.vtk.vti+xml",
            _ => "application/octet-stream",
        }
    }
}

/// How a format that can compress does so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compress {
    /// Not at all.
    #[default]
    None,
    /// zlib at a level, 1 (fast) to 9 (small). The flags of fine meshes shrink to 1/25 at 1, to 1/100 at 6, which takes
    /// twice as long, and to 1/115 at 9, in twenty times as long.
    Zlib(u8),
}

/// Choices of a writer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Compression, for `.vti` and the column file.
    pub compress: Compress,
    /// Eight cells a byte, for `.raw` and `.npy` of meshes with a single flag; the order is in [`bits`].
    pub bits: bool,
    /// Flags held at once, twice; at least one row of cells is.
    pub slab_bytes: usize,
    /// Compressed bytes of a `.vti` kept until its block table is known; what exceeds them is compressed twice.
    pub kept_bytes: usize,
}

impl Default for Options {
    fn default() -> Options {
        Options { compress: Compress::None, bits: false, slab_bytes: SLAB_BYTES, kept_bytes: 256 << 20 }
    }
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// Bytes handed to the output.
    pub n_bytes: u64,
    /// SHA-256 of these bytes in hexadecimal, for `.raw` (not bit-packed, it is [`Mesh::flags_sha256`]).
    pub sha256: Option<String>,
}

/// Writes a mesh in file order, slab by slab; never seeks. Flushes at the end.
///
/// # Errors
/// `job-conflict` where format and options contradict each other, or bits were asked of a mesh with several flags;
/// `job-value` where the compression level is not 1 to 9; `io` where `out` fails; `cancelled`, looked at before every slab.
pub fn write(
    mesh: &Mesh,
    format: Format,
    options: &Options,
    out: &mut dyn io::Write,
    control: &Control,
) -> Result<Written> {
    check(format, options)?;
    let mut sink = Sink { out, n_bytes: 0, hash: (format == Format::Raw).then(Sha256::new) };
    match format {
        Format::Raw => raw::write(mesh, options, &mut sink, control)?,
        Format::Npy => npy::write(mesh, options, &mut sink, control)?,
        Format::Vti => vti::write(mesh, options, &mut sink, control)?,
        Format::Columns => column_file::write(mesh, options.compress, &mut sink, control)?,
    }
    sink.out.flush().map_err(|error| Error::io("writing the mesh", error))?;
    Ok(Written { n_bytes: sink.n_bytes, sha256: sink.hash.map(|hash| hex(&hash.finalize())) })
}

/// The bytes before and after the flags in a file that holds them as they are, for callers that make the file slab by slab;
/// None for compressed formats and the column file.
///
/// # Errors
/// Those of [`write()`] before the first byte.
pub fn around(mesh: &Mesh, format: Format, options: &Options) -> Result<Option<(Vec<u8>, Vec<u8>)>> {
    check(format, options)?;
    if options.bits {
        bits::check(mesh)?;
    }
    Ok(match (format, options.compress) {
        (Format::Raw, _) => Some((Vec::new(), Vec::new())),
        (Format::Npy, _) => Some((npy::header(mesh.dims(), options.bits), Vec::new())),
        (Format::Vti, Compress::None) => Some(vti::around(mesh)),
        _ => None,
    })
}

/// Tells the size of a file before it is written, in bytes; nothing where it depends on the flags.
pub fn exact_size(mesh: &Mesh, format: Format, options: &Options) -> Option<u64> {
    match (format, options.compress) {
        (Format::Raw, _) => raw::n_bytes(mesh.dims(), options.bits),
        (Format::Npy, _) => npy::n_bytes(mesh.dims(), options.bits),
        (Format::Vti, Compress::None) => vti::n_bytes(mesh),
        _ => None,
    }
}

/// Refuses options that the format would silently ignore.
fn check(format: Format, options: &Options) -> Result<()> {
    let name = format.extension();
    if let Compress::Zlib(level) = options.compress {
        if !(1..=9).contains(&level) {
            return Err(Error::new(
                "job-value",
                format!("compression level {level} is not 1 to 9"),
                "6 is enough for flags",
            ));
        }
        if matches!(format, Format::Raw | Format::Npy) {
            return Err(Error::new("job-conflict", format!(".{name} cannot be compressed"), "use .vti or .hxc"));
        }
    }
    if options.bits && matches!(format, Format::Vti | Format::Columns) {
        return Err(Error::new("job-conflict", format!(".{name} has no bit-packed variant"), "use .raw or .npy"));
    }
    Ok(())
}

/// The output of a writer, which counts and, where asked, hashes what passes.
pub(crate) struct Sink<'a> {
    out: &'a mut dyn io::Write,
    n_bytes: u64,
    hash: Option<Sha256>,
}

impl Sink<'_> {
    /// Writes all bytes.
    ///
    /// # Errors
    /// `io`.
    pub(crate) fn put(&mut self, bytes: &[u8]) -> Result<()> {
        let out = &mut self.out;
        let done = match &mut self.hash {
            None => out.write_all(bytes),
            // hashing takes as long as writing: beside it
            Some(hash) => beside(|| hash.update(bytes), || out.write_all(bytes)),
        };
        done.map_err(|error| Error::io("writing the mesh", error))?;
        self.n_bytes += bytes.len() as u64;
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod tests;
