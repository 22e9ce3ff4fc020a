//! Zarr v3: a group with the flags as a sharded array, and the centres of the cells along each axis.
//!
//! Mesh, options, a store -> keys and values. The group holds `flag` (uint8, axes z, y, x) and `z`, `y`, `x` (float64),
//! the centres of the cells, so that xarray finds them as coordinates. Attributes of `flag`: `origin`, `spacing`, `unit`,
//! `lines` (null past [`super::sidecar::MAX_LINES`] cells, as in the sidecar of `.raw`) and `flags` with their names.
//!
//! [`crate::shards`] chooses shards and their chunks. Chunks are compressed one by one, the shards of a batch side by side; chunks without
//! any flag are left out. Every shard is there, also one without flags, so that a missing one can be named. The bytes do not depend on
//! the number of threads, nor on who writes which shard: [`write_part`] writes those of a window.
//!
//! Cost: two shards of memory for each of up to four side by side, and what they compress to. Source: the Zarr v3 specification and its sharding codec, ZEP 2.

mod check;
mod gzip;
#[cfg(test)]
mod tests;
mod values;

use std::num::NonZeroU64;
use std::ops::Range;
use std::sync::Arc;

use serde_json::{Map, Value, json};
use zarrs::array::codec::ShardingCodecBuilder;
use zarrs::array::{
    Array, ArrayBuilder, ArrayMetadataOptions, ChunkShape, CodecOptions, DataType, Element, FillValue, data_type,
};
use zarrs::storage::{StoreKey, WritableStorage, WritableStorageTraits};

use crate::columns::{Columns, Named};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::flags::{CellBox, flags_of_box, n_cells};
use crate::fractions::Fractions;
use crate::lines::Lines;
use crate::mesh::Mesh;
use crate::parallel::*;
use crate::shards::Shards;

use super::sidecar::lines;
use super::solid::{check_dims, solid};
use super::{Compress, Options};
pub use check::Stored;
pub use gzip::Gzip;
pub use values::Values;

/// Most shards made side by side.
const MAX_SHARDS: usize = 4;

/// Where the cells of a mesh lie in a store: the lines of the whole, and the first cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Lines of all cells of the store.
    pub whole: Lines,
    /// The first cell of the mesh, on x, y, z.
    pub first: [u32; 3],
}

/// Writes a mesh to a store; `advance` is called with the number of cells of every batch of shards that was written.
///
/// # Errors
/// `job-conflict` for bits, which Zarr does not have; `io` where the store fails; `cancelled`, looked at before every batch of shards;
/// those of [`Shards::new`].
pub fn write(
    mesh: &Mesh,
    options: &Options,
    store: WritableStorage,
    control: &Control,
    advance: impl FnMut(u64),
) -> Result<()> {
    write_part(mesh, &Place { whole: mesh.lines.clone(), first: [0; 3] }, options, store, control, advance)
}

/// Writes the metadata of a store, the same whichever part writes it, and the shards of a part of its cells.
///
/// # Errors
/// Those of [`write()`]; `job-conflict` where the mesh begins or ends within a shard.
pub fn write_part(
    mesh: &Mesh,
    place: &Place,
    options: &Options,
    store: WritableStorage,
    control: &Control,
    advance: impl FnMut(u64),
) -> Result<()> {
    let flags = OfCells {
        name: "flag",
        data_type: data_type::uint8(),
        fill: 0u8.into(),
        attributes: attributes(mesh, &place.whole, true),
        of_box: |columns: &Columns, cells: &CellBox| flags_of_box(columns, cells),
    };
    write_cells(mesh, place, (flags, options), store, control, advance)
}

/// Writes the fraction of every cell that is not background as `solid` (float32) to a store of its own.
///
/// # Errors
/// Those of [`write()`]; `job-conflict` where mesh and fractions are not of the same box.
pub fn write_solid(
    mesh: &Mesh,
    fractions: &Fractions,
    options: &Options,
    store: WritableStorage,
    control: &Control,
) -> Result<()> {
    check_dims(mesh, fractions)?;
    let [nx, ny, _] = mesh.dims().map(u64::from);
    let of_box = |columns: &Columns, cells: &CellBox| {
        let [across, down, up] = cells;
        let flags = flags_of_box(columns, cells)?;
        let rows = up.clone().flat_map(|z| down.clone().map(move |y| u64::from(y) + ny * u64::from(z)));
        let firsts = rows.map(|row| u64::from(across.start) + nx * row);
        Ok(firsts.zip(flags.chunks_exact(across.len())).flat_map(|(first, row)| solid(row, first, fractions)).collect())
    };
    let mut attributes = attributes(mesh, &mesh.lines, false);
    attributes.insert("rays".into(), json!(fractions.rays));
    let cells = OfCells { name: "solid", data_type: data_type::float32(), fill: 0f32.into(), attributes, of_box };
    let place = Place { whole: mesh.lines.clone(), first: [0; 3] };
    write_cells(mesh, &place, (cells, options), store, control, |_| ())
}

/// An array with a number for each cell.
struct OfCells<F> {
    name: &'static str,
    data_type: DataType,
    fill: FillValue,
    attributes: Map<String, Value>,
    /// The numbers of a box of cells, x fastest.
    of_box: F,
}

fn write_cells<T: Element + Copy + Default + Send + Sync>(
    mesh: &Mesh,
    place: &Place,
    (cells, options): (OfCells<impl Fn(&Columns, &CellBox) -> Result<Vec<T>> + Sync>, &Options),
    store: WritableStorage,
    control: &Control,
    mut advance: impl FnMut(u64),
) -> Result<()> {
    if options.bits {
        return Err(Error::new("job-conflict", "Zarr has no bit-packed variant", "use .raw or .npy"));
    }
    let shards = Shards::new(place.whole.dims(), &options.zarr)?;
    let shards_of_part = shards_of_part(mesh.dims(), place, &shards)?;
    let of_box = cells.of_box;
    let described = (cells.name, cells.data_type, cells.fill, cells.attributes);
    let array = cells_array(described, &place.whole, (options, &shards), store.clone())?;
    let centres = [0, 1, 2].map(|axis| centres_array(mesh, &place.whole, axis, store.clone()));
    let centres = centres.into_iter().collect::<Result<Vec<StoredArray>>>()?;
    // first: by it other parts know that the store is one
    store_group(std::iter::once(&array).chain(&centres), &*store)?;
    for (axis, centres) in centres.iter().enumerate() {
        write_centres(centres, &place.whole, axis)?;
    }
    store_metadata(&array)?;
    // chunks of one shard encoded in parallel would be stored in the order in which they are done: a shard a core instead
    let serial = CodecOptions::default().with_concurrent_target(1).with_store_empty_chunks(true);
    let n_at_once =
        (options.slab_bytes as u64 / (shards.n_cells() * size_of::<T>() as u64)).clamp(1, MAX_SHARDS as u64);
    for batch in shards_of_part.chunks(current_num_threads().min(n_at_once as usize)) {
        control.check()?;
        batch.par_iter().try_for_each(|(index, cells)| {
            let columns = mesh.columns.for_slab(&cells[mesh.columns.rays.axis])?;
            let shard = padded(of_box(&columns, cells)?, cells, shards.shard);
            array.store_chunk_opt(index, shard, &serial).map_err(failed)
        })?;
        advance(batch.iter().map(|(_, cells)| n_cells(cells) as u64).sum());
    }
    Ok(())
}

/// The shards of a part: their indices on z, y, x, and their cells, counted from the first of the part.
fn shards_of_part(dims: [u32; 3], place: &Place, shards: &Shards) -> Result<Vec<([u64; 3], CellBox)>> {
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

/// Without a note on who made an array: `generator` says that.
fn metadata_options() -> ArrayMetadataOptions {
    let mut options = ArrayMetadataOptions::default();
    options.set_include_zarrs_metadata(false);
    options
}

/// Stores what an array is.
fn store_metadata(array: &StoredArray) -> Result<()> {
    array.store_metadata_opt(&metadata_options()).map_err(failed)
}

/// Stores the group, with what its arrays are: readers then need not look for them, which xarray warns about.
///
/// Written here and not by zarrs, whose map of arrays has another order each time.
fn store_group<'a>(arrays: impl Iterator<Item = &'a StoredArray>, store: &dyn WritableStorageTraits) -> Result<()> {
    let mut of_arrays = Map::new();
    for array in arrays {
        let metadata = serde_json::to_value(array.metadata_opt(&metadata_options())).map_err(failed)?;
        of_arrays.insert(array.path().as_str().trim_start_matches('/').into(), metadata);
    }
    let consolidated = json!({ "kind": "inline", "must_understand": false, "metadata": of_arrays });
    let group = json!({
        "attributes": {},
        "consolidated_metadata": consolidated,
        "node_type": "group",
        "zarr_format": 3,
    });
    let text = serde_json::to_string_pretty(&group).map_err(failed)?;
    let key = StoreKey::new("zarr.json").map_err(failed)?;
    store.set(&key, text.into_bytes().into()).map_err(failed)
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::new("io", format!("writing Zarr: {error}"), "")
}

type StoredArray = Array<dyn WritableStorageTraits>;

fn cells_array(
    (name, data_type, fill, attributes): (&str, DataType, FillValue, Map<String, Value>),
    whole: &Lines,
    (options, shards): (&Options, &Shards),
    store: WritableStorage,
) -> Result<StoredArray> {
    let [nx, ny, nz] = whole.dims().map(u64::from);
    let mut sharding = ShardingCodecBuilder::new(chunk_shape(shards.chunk)?, &data_type);
    if let Compress::Zlib(level) = options.compress {
        sharding.bytes_to_bytes_codecs(vec![Arc::new(Gzip(level))]);
    }
    let [sx, sy, sz] = shards.shard.map(u64::from);
    let mut builder = ArrayBuilder::new(vec![nz, ny, nx], vec![sz, sy, sx], data_type, fill);
    builder.array_to_bytes_codec(sharding.build_arc());
    builder.dimension_names(Some(["z", "y", "x"])).attributes(attributes);
    builder.build(store, &format!("/{name}")).map_err(failed)
}

fn chunk_shape([x, y, z]: [u32; 3]) -> Result<ChunkShape> {
    let sides = [z, y, x].map(|n| NonZeroU64::new(n.into()));
    sides.into_iter().collect::<Option<_>>().ok_or_else(|| failed("a chunk without cells"))
}

fn attributes(mesh: &Mesh, whole: &Lines, with_flags: bool) -> Map<String, Value> {
    // without numbers of cells, which no part knows
    let mut names: Vec<&Named> = mesh.names.iter().collect();
    names.sort_by_key(|named| named.flag);
    let told = |named: &&Named| match named.material.is_empty() {
        true => json!({ "flag": named.flag, "name": named.name }),
        false => json!({ "flag": named.flag, "name": named.name, "material": named.material }),
    };
    let names: Vec<Value> = names.iter().map(told).collect();
    let entries = [
        ("generator", json!(concat!("hexcast ", env!("CARGO_PKG_VERSION")))),
        ("unit", json!(mesh.unit)),
        ("origin", json!(whole.origin())),
        ("spacing", json!(whole.spacing())),
        ("flags", json!(names)),
        ("lines", json!({"x": lines(whole, 0), "y": lines(whole, 1), "z": lines(whole, 2)})),
    ];
    let entries = entries.into_iter().filter(|(key, _)| with_flags || *key != "flags");
    entries.map(|(key, value)| (key.to_string(), value)).collect()
}

/// The array of the centres of the cells along an axis, of one chunk.
fn centres_array(mesh: &Mesh, whole: &Lines, axis: usize, store: WritableStorage) -> Result<StoredArray> {
    let (n, name) = (u64::from(whole.dims()[axis]), ["x", "y", "z"][axis]);
    let mut builder = ArrayBuilder::new(vec![n], vec![n], data_type::float64(), f64::NAN);
    builder.dimension_names(Some([name]));
    builder.attributes_mut().extend(mesh.unit.iter().map(|unit| ("units".to_string(), json!(unit))));
    builder.build(store, &format!("/{name}")).map_err(failed)
}

fn write_centres(array: &StoredArray, whole: &Lines, axis: usize) -> Result<()> {
    let centres: Vec<f64> = (0..whole.dims()[axis]).map(|cell| whole.centre(axis, cell)).collect();
    store_metadata(array)?;
    array.store_chunk(&[0], centres).map_err(failed)
}

/// Puts the numbers of a box, x fastest, in a shard that may reach past the mesh, z slowest.
fn padded<T: Copy + Default>(of_box: Vec<T>, cells: &CellBox, [sx, sy, sz]: [u32; 3]) -> Vec<T> {
    let [nx, ny, nz] = [0, 1, 2].map(|axis| cells[axis].len());
    let [sz, sy, sx] = [sz, sy, sx].map(|n| n as usize);
    if [nz, ny, nx] == [sz, sy, sx] {
        return of_box;
    }
    let mut shard = vec![T::default(); sz * sy * sx];
    for (index, row) in of_box.chunks_exact(nx).enumerate() {
        let start = (index / ny * sy + index % ny) * sx;
        shard[start..start + nx].copy_from_slice(row);
    }
    shard
}
