//! File formats and the choices of their writers.

use serde::Deserialize;

use hexcast_core::base::error::{Error, Result};
#[cfg(not(target_arch = "wasm32"))]
use hexcast_core::input::job::Level;
use hexcast_core::input::job::ZarrJob;
use hexcast_derived::mesh::SLAB_BYTES;

/// A format of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Flags only, one byte (or bit) a cell, x fastest; [`super::sidecar_json`] describes them.
    Raw,
    /// NumPy array of shape (nz, ny, nx).
    Npy,
    /// NumPy archive: the flags as in `.npy`, and the lines of each axis.
    Npz,
    /// VTK image data, for ParaView.
    Vti,
    /// VTK rectilinear grid, for ParaView: also of cells that differ in size.
    Vtr,
    /// hexcast's own column file, which reads back.
    Columns,
    /// A Zarr store: a folder of many files, or a bucket, which `write::zarr` fills, natively.
    Zarr,
    /// The files of a Zarr store in a ZIP archive, stored as they are: what zarr-python opens as a `ZipStore`.
    ZarrZip,
}

impl Format {
    /// Every format, in the order of the documentation.
    pub const ALL: [Format; 8] = [
        Format::Raw,
        Format::Npy,
        Format::Npz,
        Format::Vti,
        Format::Vtr,
        Format::Columns,
        Format::Zarr,
        Format::ZarrZip,
    ];
    /// Those that are one file: what [`crate::write::write()`] writes.
    pub const FILES: [Format; 7] =
        [Format::Raw, Format::Npy, Format::Npz, Format::Vti, Format::Vtr, Format::Columns, Format::ZarrZip];

    /// Finds the format by the extension of a file name, upper or lower case.
    ///
    /// # Errors
    /// `output-name` where the extension is none of those of [`Format::ALL`], or there is no name before it.
    pub fn of_name(name: &str) -> Result<Format> {
        let (stem, extension) = name.rsplit_once('.').unwrap_or((name, ""));
        let extension = extension.to_ascii_lowercase();
        let (stem, extension) = match stem.rsplit_once('.') {
            Some((stem, inner)) if extension == "zip" && inner.eq_ignore_ascii_case("zarr") => {
                (stem, "zarr.zip".into())
            }
            _ => (stem, extension),
        };
        let found = Format::ALL.into_iter().find(|format| format.extension() == extension).ok_or_else(|| {
            let known = Format::ALL.map(|format| format!(".{}", format.extension())).join(", ");
            let message = match extension.is_empty() {
                true => format!("{name}: the name has no extension, which says the format"),
                false => format!("{name}: no format has the extension \"{extension}\""),
            };
            Error::new("output-name", message, format!("use {known}"))
        })?;
        if stem.is_empty() || stem.ends_with('/') {
            let message = format!("{name}: there is no name before the extension, and such files are hidden");
            return Err(Error::new("output-name", message, format!("write a name, such as mesh.{extension}")));
        }
        Ok(found)
    }

    /// Extension of file names, without the dot.
    pub fn extension(self) -> &'static str {
        self.row().0
    }

    /// What is in such a file, for a list of formats.
    pub fn about(self) -> &'static str {
        self.row().1
    }

    /// Extension and contents of each format.
    fn row(self) -> (&'static str, &'static str) {
        match self {
            Format::Raw => ("raw", "one byte a cell, x fastest; OUT.raw.json says what they mean"),
            Format::Npy => ("npy", "NumPy array of shape (nz, ny, nx)"),
            Format::Npz => (
                "npz",
                "the same as the array flag, and the lines of each axis as x, y, z (zlib unless --compress=none)",
            ),
            Format::Vti => ("vti", "VTK image data, for ParaView (zlib unless --compress=none)"),
            Format::Vtr => ("vtr", "VTK rectilinear grid: like .vti, with all lines, for cells that differ in size"),
            Format::Columns => ("hxc", "columns, by far the smallest; `hexcast convert` makes any other from it"),
            Format::Zarr => (
                "zarr",
                "Zarr v3, a folder or s3://BUCKET/NAME.zarr: flag (z, y, x) in shards, and the centres x, y, z; for \
                 zarr-python and xarray. With --part K/N only the shards of that part, in the store of the whole",
            ),
            Format::ZarrZip => ("zarr.zip", "the files of such a store in one archive: a ZipStore of zarr-python"),
        }
    }
}

/// How a format that can compress does so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Compress {
    /// Not at all.
    #[default]
    None,
    /// zlib at a level, 1 (fast) to 9 (small). The flags of fine meshes shrink to 1/25 at 1, to 1/100 at 6, which takes
    /// twice as long, and to 1/115 at 9, in twenty times as long.
    Zlib(u8),
}

impl Compress {
    /// Refuses levels that zlib does not have.
    pub(super) fn check(self) -> Result<()> {
        match self {
            Compress::None | Compress::Zlib(1..=9) => Ok(()),
            Compress::Zlib(level) => {
                let message = format!("compression level {level} is not 1 to 9");
                Err(Error::new("job-value", message, "6 is enough for flags"))
            }
        }
    }
}

#[cfg(not(target_arch = "wasm32"))]
impl From<Compress> for Level {
    fn from(compress: Compress) -> Level {
        match compress {
            Compress::None => Level::Word("none".into()),
            Compress::Zlib(level) => Level::Level(level),
        }
    }
}

/// Which axis is the slowest in a file of flags: the order of the axes of its array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum AxisOrder {
    /// z slowest and x fastest: shape (nz, ny, nx).
    #[default]
    Zyx,
    /// x slowest and z fastest: shape (nx, ny, nz).
    Xyz,
}

/// Choices of a writer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// Compression, for `.npz`, `.vti`, `.vtr`, Zarr and the column file.
    pub compress: Compress,
    /// Eight cells a byte, for `.raw` and `.npy` of meshes with a single flag; the order is in [`super::bits`].
    pub bits: bool,
    /// Order of the axes, for `.raw`, `.npy` and `.npz`.
    pub axis_order: AxisOrder,
    /// What is written for each flag in its place, for `.raw`, `.npy` and `.npz`. None: the flag itself.
    pub map: Option<[u8; 256]>,
    /// Whether the SHA-256 of a `.raw` is made as it is written: about as long again.
    pub sha256: bool,
    /// Flags held at once, twice; at least one row of cells is.
    pub slab_bytes: usize,
    /// Shapes of the chunks and shards of a Zarr store.
    pub zarr: ZarrJob,
    /// Compressed bytes of a `.vti` in memory until all block sizes are known; what exceeds them is compressed twice.
    pub block_cache_bytes: usize,
}

impl Default for Options {
    fn default() -> Options {
        let (compress, slab_bytes, block_cache_bytes) = (Compress::None, SLAB_BYTES, 256 << 20);
        let (axis_order, map) = (AxisOrder::Zyx, None);
        Options {
            compress,
            bits: false,
            axis_order,
            map,
            sha256: false,
            slab_bytes,
            zarr: ZarrJob::default(),
            block_cache_bytes,
        }
    }
}

impl Options {
    /// Compresses, or does not.
    pub fn with_compress(self, compress: Compress) -> Options {
        Options { compress, ..self }
    }

    /// Packs eight cells in a byte.
    pub fn with_bits(self, bits: bool) -> Options {
        Options { bits, ..self }
    }

    /// Chooses the order of the axes.
    pub fn with_axis_order(self, axis_order: AxisOrder) -> Options {
        Options { axis_order, ..self }
    }

    /// Writes another number for each flag: `map[flag]`.
    pub fn with_map(self, map: [u8; 256]) -> Options {
        Options { map: Some(map), ..self }
    }

    /// Whether what is written are not the flags with x fastest.
    pub fn has_own_bytes(&self) -> bool {
        self.map.is_some() || self.axis_order != AxisOrder::Zyx
    }

    /// Asks for the SHA-256 of a `.raw`.
    pub fn with_sha256(self, sha256: bool) -> Options {
        Options { sha256, ..self }
    }

    /// Chooses the shapes of the shards and chunks of `.zarr`.
    pub fn with_zarr(self, zarr: ZarrJob) -> Options {
        Options { zarr, ..self }
    }

    /// Limits the flags that are held at once, twice.
    pub fn with_slab_bytes(self, slab_bytes: usize) -> Options {
        Options { slab_bytes, ..self }
    }

    /// Limits the compressed bytes of a `.vti` that are held.
    pub fn with_block_cache_bytes(self, block_cache_bytes: usize) -> Options {
        Options { block_cache_bytes, ..self }
    }
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Written {
    /// Bytes handed to the output.
    pub n_bytes: u64,
    /// SHA-256 of these bytes in hexadecimal, for `.raw` where it was asked for (not bit-packed, it is [`Mesh::flags_sha256`](hexcast_derived::mesh::Mesh::flags_sha256)).
    pub sha256: Option<String>,
}

impl Written {
    /// What was handed to an output, and its hash.
    #[doc(hidden)]
    pub fn new(n_bytes: u64, sha256: Option<String>) -> Written {
        Written { n_bytes, sha256 }
    }
}
