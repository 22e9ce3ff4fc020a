//! Zarr v3, as files by their names: a group with a number for each cell as a sharded array, and the centres of the cells along each axis.
//!
//! Mesh, options -> names and bytes. [`Store`] has the cells of one level. The group holds `flag` (uint8, axes z, y, x), `solid` (float32) for fractions, or `distance` (float64), and `z`, `y`, `x` (float64),
//! the centres of the cells, so that xarray finds them as coordinates. Attributes of `flag`: `origin`, `spacing`, `unit`,
//! `lines` (null past [`super::sidecar::MAX_LINES`] cells, as in the sidecar of `.raw`) and `flags` with their names.
//!
//! Coarser levels of the flags are such groups in `levels/1`, `levels/2` and so on, and the first group tells of all of them as OME-Zarr does.
//!
//! [`crate::shards`] chooses shards and their chunks. Chunks are compressed one by one; those without any flag are left out. Every shard is there,
//! also one without flags, so that a missing one can be named, unless the store is sparse. The bytes do not depend on the number of threads, nor on who writes which shard.
//!
//! Cost: the numbers of a row of chunks, twice, and what they compress to. Source: the Zarr v3 specification. Tests read the stores by the crate `zarrs`, which
//! shares no code with this, and have it write the same bytes.

mod head;
mod levels;
mod metadata;
mod numbers;
mod ome;
mod shard;

use std::borrow::Cow;
use std::ops::Range;

use super::archive::{Archive, Buffer};
use super::{Compress, Options, Sink};
use crate::shards::Shards;
#[cfg(not(target_arch = "wasm32"))]
pub(super) use head::Head;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::{CellBox, flags_of_box};
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::job::ZarrJob;
use hexcast_core::set;
use hexcast_derived::mesh::Mesh;
pub(super) use levels::check_levels_of_part;
use levels::{Coarser, group_of, levels, zarr_of_levels};
#[cfg(not(target_arch = "wasm32"))]
pub(super) use metadata::sharded;
pub(crate) use numbers::{OfBox, OfCells};
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

/// A shard of a part: its index on z, y, x, and its cells, counted from the first of the part.
pub(super) type ShardOfPart = ([u64; 3], CellBox);

/// The files of a store, or of a part of it; of its finest level alone.
pub struct Store<'a> {
    mesh: &'a Mesh,
    place: Place,
    cells: OfCells<'a>,
    compress: Compress,
    chunks: Chunks,
    zarr: ZarrJob,
    pub(super) shapes: Shards,
    pub(super) shards: Vec<ShardOfPart>,
}

impl<'a> Store<'a> {
    /// Plans the files.
    ///
    /// # Errors
    /// `job-conflict` for bits, which Zarr does not have, where the mesh begins or ends within a shard, and where coarser levels are asked for and the mesh is a
    /// part; those of [`Shards::new`].
    pub(crate) fn new(mesh: &'a Mesh, place: &Place, cells: OfCells<'a>, options: &Options) -> Result<Store<'a>> {
        // other numbers have one level, and may be there where no flag is
        let zarr = match cells.of_box {
            OfBox::Flags => options.zarr,
            OfBox::Numbers(_) => set!(ZarrJob { levels: None, sparse: false, ..options.zarr }),
        };
        if mesh.dims() != place.whole.dims() {
            check_levels_of_part(&zarr)?;
        }
        if options.bits {
            return Err(Error::new("job-conflict", "Zarr has no bit-packed variant", "use .raw or .npy"));
        }
        let shapes = Shards::new(place.whole.dims(), &options.zarr)?;
        let shards = shards_of_part(mesh.dims(), place, &shapes)?;
        let chunks = Chunks::new(shapes.chunk, cells.numbers.2, options.compress);
        Ok(Store { mesh, place: place.clone(), cells, compress: options.compress, chunks, zarr, shapes, shards })
    }

    /// The files that say what the store is, and the centres.
    ///
    /// # Errors
    /// Those of [`Head::files`].
    pub(super) fn head(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let Store { mesh, place, cells, compress, zarr, .. } = self;
        let (whole, names, unit) = (&place.whole, mesh.names(), mesh.unit());
        head::Head { whole, cells, zarr: *zarr, compress: *compress, names, unit }.files()
    }

    /// The name of the file of a shard, of a level.
    pub(super) fn name_of(&self, level: usize, ([k, j, i], _): &ShardOfPart) -> String {
        format!("{}{}/c/{k}/{j}/{i}", group_of(level), self.cells.name)
    }

    /// The meshes of its coarser levels.
    pub(super) fn coarser(&self) -> Result<Coarser<'a>> {
        let n = levels(&self.place.whole, &self.zarr)?.len();
        Ok(Coarser::new(self.mesh, self.zarr.levels, n))
    }

    /// The shards of a coarser level, from its mesh.
    ///
    /// # Errors
    /// None but for a defect: the shapes are those of this store.
    pub(super) fn of_level<'b>(&self, mesh: &'b Mesh) -> Result<Store<'b>> {
        let zarr = zarr_of_levels(&self.zarr, self.shapes);
        let options = Options { compress: self.compress, zarr, ..Options::default() };
        Store::new(mesh, &Place::of_whole(mesh), OfCells::flags(), &options)
    }

    /// Whether a shard has no file.
    fn is_left_out(&self, of: &ShardOfPart) -> Result<bool> {
        Ok(self.zarr.sparse && self.mesh.columns().only_flags(&of.1, u32::MAX)? == [Some(0)])
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

    /// The bytes of a shard; None where it has no file.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn shard(&self, of: &ShardOfPart) -> Result<Option<Vec<u8>>> {
        if self.is_left_out(of)? {
            return Ok(None);
        }
        let (mut shard, mut bytes) = (Shard::default(), Vec::new());
        let columns = self.mesh.columns().for_slab(&of.1[self.mesh.columns().rays().axis])?;
        for row in self.rows(of) {
            bytes.extend(self.row(&mut shard, &columns, &row)?);
        }
        bytes.extend(shard.end());
        Ok(Some(bytes))
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

    /// The bytes of the next row of chunks.
    fn row(&self, shard: &mut Shard, columns: &Columns, cells: &CellBox) -> Result<Vec<u8>> {
        let ([cx, cy, cz], [sx, ..]) = (self.shapes.chunk, self.shapes.shard);
        let n_of_row = (sx / cx) as usize;
        let mut chunks: Vec<Option<Cow<'_, [u8]>>> = Vec::with_capacity(n_of_row);
        if !cells.iter().any(|cells| cells.is_empty()) {
            let numbers = 0..cells[0].len().div_ceil(cx as usize);
            let dims = |cells: &CellBox| [0, 1, 2].map(|axis| cells[axis].len());
            match &self.cells.of_box {
                OfBox::Flags => {
                    let one = columns.only_flags(cells, cx)?;
                    let chunk = |number: usize| {
                        let start = cells[0].start + cx * number as u32;
                        let cells =
                            [start..start.saturating_add(cx).min(cells[0].end), cells[1].clone(), cells[2].clone()];
                        let is_whole = dims(&cells) == [cx, cy, cz].map(|n| n as usize);
                        match one[number] {
                            Some(flag) if is_whole || flag == 0 => {
                                Ok(self.chunks.of_one_flag(flag)?.map(Cow::Borrowed))
                            }
                            _ => {
                                let bytes = flags_of_box(columns, &cells)?;
                                let row = Row { bytes: &bytes, dims: dims(&cells) };
                                Ok(self.chunks.encoded(&row, 0)?.map(Cow::Owned))
                            }
                        }
                    };
                    chunks = numbers.into_par_iter().map(chunk).collect::<Result<_>>()?;
                }
                OfBox::Numbers(of_box) => {
                    let bytes = of_box(columns, cells)?;
                    let row = Row { bytes: &bytes, dims: dims(cells) };
                    let chunk = |number: usize| Ok(self.chunks.encoded(&row, number)?.map(Cow::Owned));
                    chunks = numbers.into_par_iter().map(chunk).collect::<Result<_>>()?;
                }
            }
        }
        chunks.resize(n_of_row, None);
        Ok(shard.put(&chunks))
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
        self.zip_shards(0, &mut archive, sink, control).await?;
        let mut coarser = self.coarser()?;
        while let Some((level, mesh)) = coarser.next(control).await? {
            let store = self.of_level(mesh)?;
            store.zip_shards(level, &mut archive, sink, control).await?;
        }
        sink.put(&archive.finish()?)
    }

    async fn zip_shards(
        &self,
        level: usize,
        archive: &mut Archive,
        sink: &mut Sink<'_>,
        control: &Control,
    ) -> Result<()> {
        for of in &self.shards {
            if self.is_left_out(of)? {
                continue;
            }
            let mut entry = archive.file(&self.name_of(level, of))?;
            let mut shard = Shard::default();
            for row in self.rows(of) {
                control.rest().await?;
                let columns = self.mesh.columns().for_slab(&of.1[self.mesh.columns().rays().axis])?;
                entry.pass(&self.row(&mut shard, &columns, &row)?, sink)?;
            }
            entry.pass(&shard.end(), sink)?;
            entry.end()?;
        }
        Ok(())
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
