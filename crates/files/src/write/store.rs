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

mod metadata;
mod ome;
mod shard;

use std::ops::Range;

use serde_json::{Map, Value, json};

use super::archive::{Archive, Buffer};
use super::{Compress, Options, Sink};
use crate::shards::Shards;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::{CellBox, flags_of_box};
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_core::input::job::ZarrJob;
use hexcast_core::set;
use hexcast_derived::mesh::level::Pyramid;
use hexcast_derived::mesh::{Mesh, Named};
pub(super) use metadata::sharded;
use metadata::{Described, attributes, group, plain, text};
use ome::{OmeLevel, ome};
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
/// Cells along an axis of which no coarser level is made.
const FEW: u32 = 64;

/// A number for each cell.
pub(crate) struct OfCells<'a> {
    pub(super) name: &'static str,
    /// Type, the number that is not stored, bytes of a number.
    pub(super) numbers: (&'static str, Value, usize),
    /// Rays of a cell, of fractions.
    pub(super) rays: Option<u32>,
    /// The numbers of a box of cells, x fastest, little-endian; None where all are the number that is not stored.
    pub(super) of_box: Box<OfBox<'a>>,
}

pub(super) type OfBox<'a> = dyn Fn(&Columns, &CellBox) -> Result<Option<Vec<u8>>> + Sync + 'a;

impl<'a> OfCells<'a> {
    /// The flags.
    pub(crate) fn flags() -> OfCells<'a> {
        let of_box = Box::new(|columns: &Columns, cells: &CellBox| match columns.has_flags(cells)? {
            true => flags_of_box(columns, cells).map(Some),
            false => Ok(None),
        });
        OfCells { name: FLAG, numbers: ("uint8", json!(0), 1), rays: None, of_box }
    }
}

/// What a store says of itself; nothing that only the whole mesh knows.
pub(super) struct Head<'a> {
    pub(super) whole: &'a Lines,
    pub(super) cells: &'a OfCells<'a>,
    pub(super) zarr: ZarrJob,
    pub(super) compress: Compress,
    pub(super) names: &'a [Named],
    pub(super) unit: Option<&'a str>,
}

/// A group that says nothing.
fn bare_group() -> Value {
    json!({ "attributes": {}, "node_type": "group", "zarr_format": 3 })
}

/// The path of the group of a level, with a slash at its end.
pub(super) fn group_of(level: usize) -> String {
    if level == 0 { String::new() } else { format!("levels/{level}/") }
}

/// Shapes of the shards of all levels: those of the finest, as far as these have cells.
fn zarr_of_levels(zarr: &ZarrJob, Shards { shard, chunk }: Shards) -> ZarrJob {
    let shapes = ZarrJob::default();
    set!(ZarrJob { chunks: Some(chunk), shards: Some(shard), sparse: zarr.sparse, ..shapes })
}

/// Refuses coarser levels of a part: a cell of theirs may have cells of other parts, and which flags are rare only the whole mesh knows.
///
/// # Errors
/// `job-conflict`.
#[doc(hidden)]
pub fn check_levels_of_part(zarr: &ZarrJob) -> Result<()> {
    if zarr.levels.is_none() {
        return Ok(());
    }
    let message = "zarr.levels is given with a part of the mesh: coarser levels are made of the whole mesh";
    Err(Error::new("job-conflict", message, "leave out zarr.levels (--zarr-levels), or mesh the whole in one run"))
}

/// Lines of the levels of a store: of its mesh alone, or also of coarser ones until no axis has more than 64 cells.
///
/// # Errors
/// None but for a defect: coarser lines are fewer.
pub(super) fn levels(whole: &Lines, zarr: &ZarrJob) -> Result<Vec<Lines>> {
    let mut levels = vec![whole.clone()];
    while let (Some(last), true) = (levels.last(), zarr.levels.is_some())
        && last.dims().iter().any(|&n| n > FEW)
    {
        levels.push(last.doubled()?);
    }
    Ok(levels)
}

impl Head<'_> {
    /// The file by which others know that there is a store: it has what is said of all arrays, too.
    ///
    /// # Errors
    /// Those of [`Shards::new`].
    pub(super) fn group(&self) -> Result<Vec<u8>> {
        let levels = levels(self.whole, &self.zarr)?;
        let mut arrays = Map::new();
        for (level, lines) in levels.iter().enumerate() {
            let of = self.of_level(lines)?;
            let group_of_level = group_of(level);
            if level == 1 {
                arrays.insert("levels".into(), bare_group());
            }
            if level > 0 {
                arrays.insert(group_of_level.trim_end_matches('/').into(), bare_group());
            }
            arrays.extend(of.arrays()?.into_iter().map(|(name, of)| (format!("{group_of_level}{name}"), of)));
        }
        let step = |level: usize| 2f64.powi(level as i32);
        let of_level = |(level, lines)| OmeLevel {
            path: format!("{}{}", group_of(level), self.cells.name),
            lines,
            step: step(level),
        };
        let of_levels: Vec<OmeLevel<'_>> = levels.iter().enumerate().map(of_level).collect();
        let names = (self.cells.name == FLAG).then_some(self.names);
        let ome = ome(self.cells.name, &of_levels, (names, self.unit), self.zarr.levels);
        text(&group(&json!({ "ome": ome }), arrays))
    }

    /// What is said of each array of a level.
    fn arrays(&self) -> Result<Vec<(&'static str, Value)>> {
        let centres = [0, 1, 2].map(|axis| (AXES[axis], self.centres_described(axis)));
        Ok(std::iter::once((self.cells.name, self.described()?)).chain(centres).collect())
    }

    fn of_level<'b>(&'b self, whole: &'b Lines) -> Result<Head<'b>> {
        let zarr = zarr_of_levels(&self.zarr, Shards::new(self.whole.dims(), &self.zarr)?);
        Ok(Head { whole, cells: self.cells, zarr, compress: self.compress, names: self.names, unit: self.unit })
    }

    /// The files that say what the store is, and the centres. The group is first.
    ///
    /// # Errors
    /// Those of [`Shards::new`].
    pub(super) fn files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let mut files = vec![("zarr.json".to_string(), self.group()?)];
        for (level, whole) in levels(self.whole, &self.zarr)?.iter().enumerate() {
            let (group, of) = (group_of(level), self.of_level(whole)?);
            if level == 1 {
                files.push(("levels/zarr.json".into(), text(&bare_group())?));
            }
            if level > 0 {
                files.push((format!("{group}zarr.json"), text(&bare_group())?));
            }
            for (axis, name) in AXES.iter().enumerate() {
                let centres = (0..whole.dims()[axis]).flat_map(|cell| whole.centre(axis, cell).to_le_bytes());
                files.push((format!("{group}{name}/zarr.json"), text(&of.centres_described(axis))?));
                files.push((format!("{group}{name}/c/0"), centres.collect()));
            }
            files.push((format!("{group}{}/zarr.json", self.cells.name), text(&of.described()?)?));
        }
        Ok(files)
    }

    fn described(&self) -> Result<Value> {
        let shapes = Shards::new(self.whole.dims(), &self.zarr)?;
        let ([nx, ny, nz], [sx, sy, sz]) = (self.whole.dims().map(u64::from), shapes.shard.map(u64::from));
        let (data_type, fill, _) = self.cells.numbers.clone();
        let mut attributes = attributes((self.names, self.unit), self.whole, self.cells.name == FLAG);
        attributes.extend(self.cells.rays.map(|rays| ("rays".to_string(), json!(rays))));
        attributes.extend(self.zarr.sparse.then(|| ("sparse".to_string(), json!(true))));
        let described = Described {
            shape: vec![nz, ny, nx],
            numbers: (data_type, fill),
            file: vec![sz, sy, sx],
            codecs: sharded(&shapes, self.compress),
            attributes,
            axes: &["z", "y", "x"],
        };
        Ok(described.json())
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

/// The files of a store, or of a part of it; of its finest level alone.
pub struct Store<'a> {
    mesh: &'a Mesh,
    place: Place,
    cells: OfCells<'a>,
    compress: Compress,
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
        // other numbers have one level
        let zarr = if cells.name == FLAG { options.zarr } else { set!(ZarrJob { levels: None, ..options.zarr }) };
        if mesh.dims() != place.whole.dims() {
            check_levels_of_part(&zarr)?;
        }
        if options.bits {
            return Err(Error::new("job-conflict", "Zarr has no bit-packed variant", "use .raw or .npy"));
        }
        let shapes = Shards::new(place.whole.dims(), &options.zarr)?;
        let shards = shards_of_part(mesh.dims(), place, &shapes)?;
        Ok(Store { mesh, place: place.clone(), cells, compress: options.compress, zarr, shapes, shards })
    }

    /// The files that say what the store is, and the centres.
    ///
    /// # Errors
    /// Those of [`Head::files`].
    pub(super) fn head(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let Store { mesh, place, cells, compress, zarr, .. } = self;
        let (whole, names, unit) = (&place.whole, mesh.names(), mesh.unit());
        Head { whole, cells, zarr: *zarr, compress: *compress, names, unit }.files()
    }

    /// The name of the file of a shard, of a level.
    pub(super) fn name_of(&self, level: usize, ([k, j, i], _): &ShardOfPart) -> String {
        format!("{}{}/c/{k}/{j}/{i}", group_of(level), self.cells.name)
    }

    /// Its coarser levels, which are made one after the other.
    pub(super) fn coarser(&self) -> Result<Coarser<'a>> {
        let rule = self.zarr.levels;
        let n = rule.map_or(Ok(1), |_| levels(&self.place.whole, &self.zarr).map(|levels| levels.len()))?;
        let zarr = zarr_of_levels(&self.zarr, self.shapes);
        let pyramid = rule.filter(|_| n > 1).map(|rule| Pyramid::of(self.mesh, rule));
        Ok(Coarser { fine: self.mesh, last: None, pyramid, level: 0, n, zarr, compress: self.compress })
    }

    /// Whether a shard has no file.
    fn is_left_out(&self, of: &ShardOfPart) -> Result<bool> {
        Ok(self.zarr.sparse && !self.mesh.columns().has_flags(&of.1)?)
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

    fn row(&self, shard: &mut Shard, columns: &Columns, cells: &CellBox) -> Result<Vec<u8>> {
        let ([cx, cy, cz], [sx, ..]) = (self.shapes.chunk.map(|n| n as usize), self.shapes.shard);
        let (n_of_row, n_bytes) = (sx as usize / cx, self.cells.numbers.2);
        let chunks = Chunks { shape: [cx, cy, cz], n_of_row, n_bytes, compress: self.compress };
        let dims = [0, 1, 2].map(|axis| cells[axis].len());
        if dims.contains(&0) {
            return shard.row(&chunks, None);
        }
        let bytes = (self.cells.of_box)(columns, cells)?;
        shard.row(&chunks, bytes.as_ref().map(|bytes| Row { bytes, dims }).as_ref())
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
        while let Some((level, store)) = coarser.next(control).await? {
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

/// The coarser levels of a store while they are made: one mesh at a time, of the one before.
pub(super) struct Coarser<'a> {
    fine: &'a Mesh,
    last: Option<Mesh>,
    pyramid: Option<Pyramid>,
    level: usize,
    n: usize,
    zarr: ZarrJob,
    compress: Compress,
}

impl Coarser<'_> {
    /// The next level, and the files of its shards.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails; `cancelled`.
    pub(super) async fn next(&mut self, control: &Control) -> Result<Option<(usize, Store<'_>)>> {
        let Some(pyramid) = self.pyramid.as_ref().filter(|_| self.level + 1 < self.n) else { return Ok(None) };
        self.level += 1;
        let mesh = pyramid.next(self.last.as_ref().unwrap_or(self.fine), control).await?;
        let mesh = self.last.insert(mesh);
        let options = Options { compress: self.compress, zarr: self.zarr, ..Options::default() };
        Ok(Some((self.level, Store::new(mesh, &Place::of_whole(mesh), OfCells::flags(), &options)?)))
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
