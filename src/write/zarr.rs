//! Zarr v3: a group with the flags as a sharded array, and the centres of the cells along each axis.
//!
//! Mesh, options, a store -> keys and values. The group holds `flag` (uint8, axes z, y, x) and `z`, `y`, `x` (float64),
//! the centres of the cells, so that xarray finds them as coordinates. Attributes of `flag`: `origin`, `spacing`, `unit`,
//! `lines`
//! (null past [`super::sidecar::MAX_LINES`] cells, as in the sidecar of `.raw`) and `flags` with names and cells.
//!
//! A shard is a slab: some planes, or some rows of a few planes where these are large, over all cells along x. Its chunks
//! hold 256 KiB each: 64 x 64 x 64 cells, flatter where a slab of such chunks would be larger than allowed. Chunks are
//! compressed one by one, the shards of a batch side by side; chunks without any flag are left out. The bytes do not depend
//! on the number of threads.
//!
//! Cost: two shards of memory for each of up to four side by side, and what they compress to. Source: the Zarr v3 specification and its sharding codec, ZEP 2.

mod gzip;
#[cfg(test)]
mod tests;

use std::num::NonZeroU64;
use std::sync::Arc;

use serde_json::{Map, Value, json};
use zarrs::array::codec::ShardingCodecBuilder;
use zarrs::array::{Array, ArrayBuilder, ArrayMetadataOptions, ChunkShape, CodecOptions, data_type};
use zarrs::group::GroupBuilder;
use zarrs::storage::{WritableStorage, WritableStorageTraits};

use crate::control::Control;
use crate::error::{Error, Result};
use crate::flags::{CellBox, flags_of_box, n_cells};
use crate::mesh::Mesh;
use crate::parallel::*;

use super::sidecar::{flags, lines};
use super::{Compress, Options};
pub use gzip::Gzip;

/// Most shards made side by side.
const MAX_SHARDS: usize = 4;
/// Cells of a chunk, unless the mesh is smaller.
const CHUNK_CELLS: u32 = 1 << 18;

/// Shapes of shards and chunks on z, y, x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Cells of a shard; multiples of those of a chunk.
    pub shard: [u32; 3],
    /// Cells of a chunk.
    pub chunk: [u32; 3],
}

impl Layout {
    /// Chooses shards of at most `max_bytes` for a mesh of so many cells on x, y, z; larger only where a single row of chunks
    /// already is.
    pub fn new([nx, ny, nz]: [u32; 3], max_bytes: usize) -> Layout {
        let max = max_bytes as u64;
        let chunk_of = |edge: u32| [edge.min(nz), edge.min(ny), (CHUNK_CELLS / (edge * edge)).min(nx)];
        let padded = |n: u32, chunk: u32| u64::from(n.div_ceil(chunk)) * u64::from(chunk);
        let row_of = |[cz, cy, cx]: [u32; 3]| u64::from(cz) * u64::from(cy) * padded(nx, cx);
        // the thickest chunks of which a row along x fits
        let edges = [64, 32, 16, 8, 4];
        let chunk = edges.map(chunk_of).into_iter().find(|&chunk| row_of(chunk) <= max).unwrap_or(chunk_of(4));
        let [cz, cy, cx] = chunk;
        let rows = (max / row_of(chunk)).clamp(1, u64::from(ny.div_ceil(cy))) as u32;
        let planes = if rows < ny.div_ceil(cy) { 1 } else { max / (row_of(chunk) * u64::from(rows)) };
        let planes = planes.clamp(1, u64::from(nz.div_ceil(cz))) as u32;
        Layout { shard: [planes * cz, rows * cy, padded(nx, cx) as u32], chunk }
    }
}

/// Writes a mesh to a store; `advance` is called with the number of cells of every batch of shards that was written.
///
/// # Errors
/// `job-conflict` for bits, which Zarr does not have; `io` where the store fails; `cancelled`, looked at before every batch of shards.
pub fn write(
    mesh: &Mesh,
    options: &Options,
    store: WritableStorage,
    control: &Control,
    mut advance: impl FnMut(u64),
) -> Result<()> {
    if options.bits {
        return Err(Error::new("job-conflict", "Zarr has no bit-packed variant", "use .raw or .npy"));
    }
    GroupBuilder::new().build(store.clone(), "/").map_err(failed)?.store_metadata().map_err(failed)?;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        write_centres(mesh, axis, name, store.clone())?;
    }
    let layout = Layout::new(mesh.dims(), options.slab_bytes / MAX_SHARDS);
    let array = flag_array(mesh, options, layout, store)?;
    store_metadata(&array)?;
    let [nx, ny, nz] = mesh.dims();
    let [sz, sy, _] = layout.shard;
    let starts = |n: u32, step: u32| (0..n).step_by(step as usize).enumerate();
    let shards: Vec<([u64; 3], CellBox)> = starts(nz, sz)
        .flat_map(|(k, z)| starts(ny, sy).map(move |(j, y)| (k, z, j, y)))
        .map(|(k, z, j, y)| {
            let cells = [0..nx, y..y.saturating_add(sy).min(ny), z..z.saturating_add(sz).min(nz)];
            ([k as u64, j as u64, 0], cells)
        })
        .collect();
    // chunks of one shard encoded in parallel would be stored in the order in which they are done: a shard a core instead
    let serial = CodecOptions::default().with_concurrent_target(1);
    for batch in shards.chunks(current_num_threads().min(MAX_SHARDS)) {
        control.check()?;
        batch.par_iter().try_for_each(|(index, cells)| {
            let columns = mesh.columns.for_slab(&cells[mesh.columns.rays.axis])?;
            let shard = padded(flags_of_box(&columns, cells)?, cells, layout.shard);
            array.store_chunk_opt(index, shard, &serial).map_err(failed)
        })?;
        advance(batch.iter().map(|(_, cells)| n_cells(cells) as u64).sum());
    }
    Ok(())
}

/// Stores what an array is, without a note on who made it: `generator` says that.
fn store_metadata<T: WritableStorageTraits + ?Sized + 'static>(array: &Array<T>) -> Result<()> {
    let mut options = ArrayMetadataOptions::default();
    options.set_include_zarrs_metadata(false);
    array.store_metadata_opt(&options).map_err(failed)
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::new("io", format!("writing Zarr: {error}"), "")
}

type FlagArray = Array<dyn WritableStorageTraits>;

fn flag_array(mesh: &Mesh, options: &Options, layout: Layout, store: WritableStorage) -> Result<FlagArray> {
    let [nx, ny, nz] = mesh.dims().map(u64::from);
    let mut sharding = ShardingCodecBuilder::new(chunk_shape(layout.chunk)?, &data_type::uint8());
    if let Compress::Zlib(level) = options.compress {
        sharding.bytes_to_bytes_codecs(vec![Arc::new(Gzip(level))]);
    }
    let shard = layout.shard.map(u64::from).to_vec();
    let mut builder = ArrayBuilder::new(vec![nz, ny, nx], shard, data_type::uint8(), 0u8);
    builder.array_to_bytes_codec(sharding.build_arc());
    builder.dimension_names(Some(["z", "y", "x"])).attributes(attributes(mesh));
    builder.build(store, "/flag").map_err(failed)
}

fn chunk_shape(chunk: [u32; 3]) -> Result<ChunkShape> {
    let sides = chunk.map(|n| NonZeroU64::new(n.into()));
    sides.into_iter().collect::<Option<_>>().ok_or_else(|| failed("a chunk without cells"))
}

fn attributes(mesh: &Mesh) -> Map<String, Value> {
    let entries = [
        ("generator", json!(concat!("hexcast ", env!("CARGO_PKG_VERSION")))),
        ("unit", json!(mesh.unit)),
        ("origin", json!(mesh.lines.origin)),
        ("spacing", json!(mesh.lines.spacing)),
        ("flags", json!(flags(mesh))),
        ("lines", json!({"x": lines(mesh, 0), "y": lines(mesh, 1), "z": lines(mesh, 2)})),
    ];
    entries.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
}

/// Writes the centres of the cells along an axis as an array of one chunk.
fn write_centres(mesh: &Mesh, axis: usize, name: &str, store: WritableStorage) -> Result<()> {
    let n = mesh.dims()[axis];
    let centre = |cell: u32| mesh.lines.origin[axis] + (f64::from(cell) + 0.5) * mesh.lines.spacing[axis];
    let centres: Vec<f64> = (0..n).map(centre).collect();
    let n = u64::from(n);
    let mut builder = ArrayBuilder::new(vec![n], vec![n], data_type::float64(), f64::NAN);
    builder.dimension_names(Some([name]));
    builder.attributes_mut().extend(mesh.unit.iter().map(|unit| ("units".to_string(), json!(unit))));
    let array = builder.build(store, &format!("/{name}")).map_err(failed)?;
    store_metadata(&array)?;
    array.store_chunk(&[0], centres).map_err(failed)
}

/// Puts the flags of a box, x fastest, in a shard that may reach past the mesh, z slowest.
fn padded(flags: Vec<u8>, cells: &CellBox, [sz, sy, sx]: [u32; 3]) -> Vec<u8> {
    let [nx, ny, nz] = [0, 1, 2].map(|axis| cells[axis].len());
    let [sz, sy, sx] = [sz, sy, sx].map(|n| n as usize);
    if [nz, ny, nx] == [sz, sy, sx] {
        return flags;
    }
    let mut shard = vec![0; sz * sy * sx];
    for (row, flags) in flags.chunks_exact(nx).enumerate() {
        let start = (row / ny * sy + row % ny) * sx;
        shard[start..start + nx].copy_from_slice(flags);
    }
    shard
}
