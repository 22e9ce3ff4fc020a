//! Zarr v3, as files by their names: a group with a number for each cell as a sharded array, and the centres of the cells along each axis.
//!
//! Mesh, options -> names and bytes. The group holds `flag` (uint8, axes z, y, x), `solid` (float32) for fractions, or `distance` (float64), and `z`, `y`, `x` (float64),
//! the centres of the cells, so that xarray finds them as coordinates. Attributes of `flag`: `origin`, `spacing`, `unit`,
//! `lines` (null past [`super::sidecar::MAX_LINES`] cells, as in the sidecar of `.raw`) and `flags` with their names.
//!
//! [`crate::shards`] chooses shards and their chunks. Chunks are compressed one by one; those without any flag are left out. Every shard is there,
//! also one without flags, so that a missing one can be named. The bytes do not depend on the number of threads, nor on who writes which shard.
//!
//! Cost: the numbers of a row of chunks, twice, and what they compress to. Source: the Zarr v3 specification. Tests read the stores by the crate `zarrs`, which
//! shares no code with this, and have it write the same bytes.

mod metadata;
mod shard;

use std::ops::Range;

use serde_json::{Value, json};

use super::archive::{Archive, Buffer};
use super::{Compress, Options, Sink};
use crate::shards::Shards;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::{CellBox, flags_of_box};
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_derived::mesh::{Mesh, Named};
pub(super) use metadata::sharded;
use metadata::{Described, attributes, group, plain, text};
#[cfg(test)]
pub(super) use shard::gzip;
use shard::{Chunks, Row, Shard};
#[cfg(not(target_arch = "wasm32"))]
pub(super) use shard::{NOWHERE, checksum};

/// Where the cells of a mesh lie in a store: the lines of the whole, and the first cell.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Place {
    /// Lines of all cells of the store.
    pub whole: Lines,
    /// The first cell of the mesh, on x, y, z.
    pub first: [u32; 3],
}

impl Place {
    /// The lines of all cells of a store, and the first cell of a mesh, on x, y, z.
    pub fn new(whole: Lines, first: [u32; 3]) -> Place {
        Place { whole, first }
    }

    /// That of a mesh which is a whole store.
    pub(crate) fn of_whole(mesh: &Mesh) -> Place {
        Place { whole: mesh.lines().clone(), first: [0; 3] }
    }
}

/// The array of flags.
const FLAG: &str = "flag";

/// A number for each cell.
pub(crate) struct OfCells<'a> {
    pub(super) name: &'static str,
    /// Type, the number that is not stored, bytes of a number.
    pub(super) numbers: (&'static str, Value, usize),
    /// Rays of a cell, of fractions.
    pub(super) rays: Option<u32>,
    /// The numbers of a box of cells, x fastest, little-endian.
    pub(super) of_box: Box<OfBox<'a>>,
}

pub(super) type OfBox<'a> = dyn Fn(&Columns, &CellBox) -> Result<Vec<u8>> + Sync + 'a;

impl<'a> OfCells<'a> {
    /// The flags.
    pub(crate) fn flags() -> OfCells<'a> {
        let of_box = Box::new(|columns: &Columns, cells: &CellBox| flags_of_box(columns, cells));
        OfCells { name: FLAG, numbers: ("uint8", json!(0), 1), rays: None, of_box }
    }
}

/// What a store says of itself; nothing that only the whole mesh knows.
pub(super) struct Head<'a> {
    pub(super) whole: &'a Lines,
    pub(super) cells: &'a OfCells<'a>,
    pub(super) shapes: Shards,
    pub(super) compress: Compress,
    pub(super) names: &'a [Named],
    pub(super) unit: Option<&'a str>,
}

impl Head<'_> {
    /// The file by which others know that there is a store: it has what is said of all arrays, too.
    ///
    /// # Errors
    /// `io`, none but for a defect.
    pub(super) fn group(&self) -> Result<Vec<u8>> {
        let centres = [0, 1, 2].map(|axis| (AXES[axis], self.centres_described(axis)));
        let arrays = std::iter::once((self.cells.name, self.described())).chain(centres);
        text(&group(arrays.map(|(name, of)| (name.to_string(), of)).collect()))
    }

    /// The files that say what the store is, and the centres. The group is first.
    ///
    /// # Errors
    /// `io`, none but for a defect.
    pub(super) fn files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let whole = self.whole;
        let mut files = vec![("zarr.json".to_string(), self.group()?)];
        for (axis, name) in AXES.iter().enumerate() {
            let centres = (0..whole.dims()[axis]).flat_map(|cell| whole.centre(axis, cell).to_le_bytes());
            files.push((format!("{name}/zarr.json"), text(&self.centres_described(axis))?));
            files.push((format!("{name}/c/0"), centres.collect()));
        }
        files.push((format!("{}/zarr.json", self.cells.name), text(&self.described())?));
        Ok(files)
    }

    fn described(&self) -> Value {
        let ([nx, ny, nz], [sx, sy, sz]) = (self.whole.dims().map(u64::from), self.shapes.shard.map(u64::from));
        let (data_type, fill, _) = self.cells.numbers.clone();
        let mut attributes = attributes((self.names, self.unit), self.whole, self.cells.name == FLAG);
        attributes.extend(self.cells.rays.map(|rays| ("rays".to_string(), json!(rays))));
        Described {
            shape: vec![nz, ny, nx],
            numbers: (data_type, fill),
            file: vec![sz, sy, sx],
            codecs: sharded(&self.shapes, self.compress),
            attributes,
            axes: &["z", "y", "x"],
        }
        .json()
    }

    /// The array of the centres of the cells along an axis, of one file.
    fn centres_described(&self, axis: usize) -> Value {
        let n = u64::from(self.whole.dims()[axis]);
        let unit = self.unit.into_iter().map(|unit| ("units".to_string(), json!(unit)));
        Described {
            shape: vec![n],
            numbers: ("float64", json!("NaN")),
            file: vec![n],
            codecs: json!([plain()]),
            attributes: unit.collect(),
            axes: &[["x"], ["y"], ["z"]][axis],
        }
        .json()
    }
}

/// A shard of a part: its index on z, y, x, and its cells, counted from the first of the part.
pub(super) type ShardOfPart = ([u64; 3], CellBox);

/// The files of a store, or of a part of it.
pub struct Store<'a> {
    mesh: &'a Mesh,
    place: Place,
    cells: OfCells<'a>,
    compress: Compress,
    pub(super) shapes: Shards,
    pub(super) shards: Vec<ShardOfPart>,
}

impl<'a> Store<'a> {
    /// Plans the files.
    ///
    /// # Errors
    /// `job-conflict` for bits, which Zarr does not have, and where the mesh begins or ends within a shard; those of [`Shards::new`].
    pub(crate) fn new(mesh: &'a Mesh, place: &Place, cells: OfCells<'a>, options: &Options) -> Result<Store<'a>> {
        if options.bits {
            return Err(Error::new("job-conflict", "Zarr has no bit-packed variant", "use .raw or .npy"));
        }
        let shapes = Shards::new(place.whole.dims(), &options.zarr)?;
        let shards = shards_of_part(mesh.dims(), place, &shapes)?;
        Ok(Store { mesh, place: place.clone(), cells, compress: options.compress, shapes, shards })
    }

    /// The files that say what the store is, and the centres.
    ///
    /// # Errors
    /// Those of [`Head::files`].
    pub(super) fn head(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let Store { mesh, place, cells, compress, shapes, .. } = self;
        let (whole, names, unit) = (&place.whole, mesh.names(), mesh.unit());
        Head { whole, cells, shapes: *shapes, compress: *compress, names, unit }.files()
    }

    /// The name of the file of a shard.
    pub(super) fn name_of(&self, ([k, j, i], _): &ShardOfPart) -> String {
        format!("{}/c/{k}/{j}/{i}", self.cells.name)
    }

    /// Bytes of the numbers of a shard.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn shard_bytes(&self) -> u64 {
        self.shapes.n_cells() * self.cells.numbers.2 as u64
    }

    /// Bytes of the numbers of a row of chunks: what is held at once.
    #[cfg(target_arch = "wasm32")]
    pub fn row_bytes(&self) -> u64 {
        let ([sx, ..], [_, cy, cz]) = (self.shapes.shard.map(u64::from), self.shapes.chunk.map(u64::from));
        sx.saturating_mul(cy).saturating_mul(cz).saturating_mul(self.cells.numbers.2 as u64)
    }

    /// The bytes of a shard.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn shard(&self, of: &ShardOfPart) -> Result<Vec<u8>> {
        let (mut shard, mut bytes) = (Shard::default(), Vec::new());
        let columns = self.mesh.columns().for_slab(&of.1[self.mesh.columns().rays().axis])?;
        for row in self.rows(of) {
            bytes.extend(self.row(&mut shard, &columns, &row)?);
        }
        bytes.extend(shard.end());
        Ok(bytes)
    }

    /// The cells of the rows of chunks of a shard, which are none beyond the mesh.
    fn rows(&self, (_, [x, y, z]): &ShardOfPart) -> Vec<CellBox> {
        let ([_, sy, sz], [_, cy, cz]) = (self.shapes.shard, self.shapes.chunk);
        let along = |cells: &Range<u32>, all: u32, step: u32| -> Vec<Range<u32>> {
            let within = |at: u32| cells.start.saturating_add(at).min(cells.end);
            (0..all / step).map(|chunk| within(chunk * step)..within((chunk + 1) * step)).collect()
        };
        let down = along(y, sy, cy);
        let rows = along(z, sz, cz).into_iter().flat_map(|z| down.iter().map(move |y| (y.clone(), z.clone())));
        rows.map(|(y, z)| [x.clone(), y, z]).collect()
    }

    fn row(&self, shard: &mut Shard, columns: &Columns, cells: &CellBox) -> Result<Vec<u8>> {
        let ([cx, cy, cz], [sx, ..]) = (self.shapes.chunk.map(|n| n as usize), self.shapes.shard);
        let (n_of_row, n_bytes) = (sx as usize / cx, self.cells.numbers.2);
        let chunks = Chunks { shape: [cx, cy, cz], n_of_row, n_bytes, compress: self.compress };
        let dims = [0, 1, 2].map(|axis| cells[axis].len());
        if dims.contains(&0) {
            return shard.row(&chunks, None);
        }
        let bytes = (self.cells.of_box)(columns, cells)?;
        shard.row(&chunks, Some(&Row { bytes: &bytes, dims }))
    }

    /// Writes the store as an archive whose entries are stored as they are: what zarr-python opens as a `ZipStore`. Rests before every row
    /// of chunks.
    ///
    /// # Errors
    /// `io`; `cancelled`.
    pub(crate) async fn zip(&self, sink: &mut Sink<'_>, control: &Control) -> Result<()> {
        let mut archive = Archive::new(Compress::None, Buffer::default());
        for (name, bytes) in self.head()? {
            let mut entry = archive.file(&name)?;
            entry.pass(&bytes, sink)?;
            entry.end()?;
        }
        for of in &self.shards {
            let mut entry = archive.file(&self.name_of(of))?;
            let mut shard = Shard::default();
            for row in self.rows(of) {
                control.rest().await?;
                let columns = self.mesh.columns().for_slab(&of.1[self.mesh.columns().rays().axis])?;
                entry.pass(&self.row(&mut shard, &columns, &row)?, sink)?;
            }
            entry.pass(&shard.end(), sink)?;
            entry.end()?;
        }
        sink.put(&archive.finish()?)
    }
}

/// The shards of a part.
fn shards_of_part(dims: [u32; 3], place: &Place, shards: &Shards) -> Result<Vec<ShardOfPart>> {
    let Place { whole, first } = place;
    let mut along: [Vec<(u64, Range<u32>)>; 3] = Default::default();
    for axis in 0..3 {
        let (step, n, first) = (shards.shard[axis], whole.dims()[axis], first[axis]);
        let end = first + dims[axis];
        if !first.is_multiple_of(step) || end > n || !(end.is_multiple_of(step) || end == n) {
            let name = ["x", "y", "z"][axis];
            let message = format!("cells {first} to {end} along {name} begin or end within a shard, of {step} cells");
            let hint =
                "divide the mesh along the borders of shards, as --part K/N does for an output that ends in .zarr";
            return Err(Error::new("job-conflict", message, hint));
        }
        let starts = (first..end).step_by(step as usize);
        along[axis] =
            starts.map(|at| ((at / step).into(), at - first..at.saturating_add(step).min(end) - first)).collect();
    }
    let [x, y, z] = &along;
    let rows = z.iter().flat_map(|k| y.iter().map(move |j| (k, j)));
    let all = rows.flat_map(|(k, j)| x.iter().map(move |i| ([k.0, j.0, i.0], [i.1.clone(), j.1.clone(), k.1.clone()])));
    Ok(all.collect())
}
