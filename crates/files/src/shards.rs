//! Shards: how the cells of a Zarr store are divided into shards, which are files, and these into chunks.
//!
//! Numbers of cells, what the job asks for -> [`Shards`]. The shapes depend on nothing else, so every process that fills a part
//! of a store finds the same shapes, whatever its memory.
//!
//! A shard is a slab: some planes, or some rows of a few planes where these are large, over all cells along x. Its chunks hold 256 KiB
//! each: 64 x 64 x 64 cells, flatter where a row of such chunks would be larger than a shard. A shard has at most a 2,048th of the cells,
//! rounded up to a power of two, between 4 and 64 million, which are as many MiB of flags and four times as many of fractions: few files for large meshes, small ones for small.

use hexcast_core::base::error::{Error, Result};
use hexcast_core::input::job::ZarrJob;

/// Cells of a chunk, unless the mesh is smaller.
const CHUNK_CELLS: u32 = 1 << 18;
/// Shards of a large mesh, about.
const N_SHARDS: u64 = 2048;
/// Least and greatest sizes of a shard that are chosen.
const SHARD_BYTES: [u64; 2] = [4 << 20, 64 << 20];
/// Most cells of a shard, whoever chooses it: it is made in memory.
const MAX_SHARD_CELLS: u64 = 1 << 32;

/// Shapes of shards and chunks on x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Shards {
    /// Cells of a shard; multiples of those of a chunk.
    pub shard: [u32; 3],
    /// Cells of a chunk.
    pub chunk: [u32; 3],
}

impl Shards {
    /// Chooses the shapes that the job leaves out, for a mesh of so many cells on x, y, z.
    ///
    /// # Errors
    /// `job-value` where a shape has no cells, a shard is no multiple of its chunks, or has more than 2^32 cells.
    pub fn new(dims: [u32; 3], asked: &ZarrJob) -> Result<Shards> {
        let n_cells = dims.iter().fold(1u64, |n, &of| n.saturating_mul(of.into()));
        let [least, most] = SHARD_BYTES;
        let by_size = (n_cells / N_SHARDS).clamp(least, most).next_power_of_two();
        let max_bytes = asked.shard_bytes.map_or(by_size, |size| size.0);
        let within = |shape: [u32; 3]| [0, 1, 2].map(|axis| shape[axis].min(dims[axis]));
        let chunk = within(asked.chunks.unwrap_or_else(|| chunk(dims, max_bytes)));
        let shard = asked.shards.map_or_else(|| slab(dims, chunk, max_bytes), |shard| fitted(dims, chunk, shard));
        let wrong =
            (0..3).find(|&axis| chunk[axis] == 0 || shard[axis] == 0 || !shard[axis].is_multiple_of(chunk[axis]));
        if let Some(axis) = wrong {
            let (name, cells, of_chunk) = (["x", "y", "z"][axis], shard[axis], chunk[axis]);
            let message =
                format!("zarr: shards of {cells} cells along {name} are not a multiple of the chunks, {of_chunk}");
            return Err(Error::new("job-value", message, "give shards that are multiples of the chunks on every axis"));
        }
        let cells = shard.iter().fold(1u64, |n, &of| n.saturating_mul(of.into()));
        if cells > MAX_SHARD_CELLS {
            let message = format!("zarr: shards of {cells} cells, which are made in memory; at most 2^32 are allowed");
            return Err(Error::new("job-value", message, "give smaller shards (zarr.shards, --zarr-shards)"));
        }
        Ok(Shards { shard, chunk })
    }

    /// Number of shards on x, y, z for so many cells.
    pub fn grid(&self, dims: [u32; 3]) -> [u32; 3] {
        [0, 1, 2].map(|axis| dims[axis].div_ceil(self.shard[axis]))
    }

    /// Cells of a shard.
    pub fn n_cells(&self) -> u64 {
        self.shard.iter().map(|&n| u64::from(n)).product()
    }
}

fn padded(n: u32, chunk: u32) -> u64 {
    u64::from(n.div_ceil(chunk.max(1))) * u64::from(chunk)
}

/// Cells of a row of chunks along x.
fn row_of([nx, ..]: [u32; 3], [cx, cy, cz]: [u32; 3]) -> u64 {
    (u64::from(cz) * u64::from(cy)).saturating_mul(padded(nx, cx))
}

/// The thickest chunks of which a row along x fits.
fn chunk(dims: [u32; 3], max_bytes: u64) -> [u32; 3] {
    let [nx, ny, nz] = dims;
    let chunk_of = |edge: u32| [(CHUNK_CELLS / (edge * edge)).min(nx), edge.min(ny), edge.min(nz)];
    let chunks = [64, 32, 16, 8, 4].map(chunk_of);
    chunks.into_iter().find(|&chunk| row_of(dims, chunk) <= max_bytes).unwrap_or(chunks[4])
}

/// As many rows of chunks as fit; larger than allowed only where a single row already is.
fn slab(dims: [u32; 3], chunk: [u32; 3], max_bytes: u64) -> [u32; 3] {
    let ([nx, ny, nz], [cx, cy, cz]) = (dims, chunk);
    if chunk.contains(&0) {
        return chunk;
    }
    let row = row_of(dims, chunk);
    let rows = (max_bytes / row).clamp(1, ny.div_ceil(cy).into()) as u32;
    let planes = if rows < ny.div_ceil(cy) { 1 } else { max_bytes / row / u64::from(rows) };
    let planes = planes.clamp(1, nz.div_ceil(cz).into()) as u32;
    fitted(
        dims,
        chunk,
        [padded(nx, cx).min(u32::MAX.into()) as u32, rows.saturating_mul(cy), planes.saturating_mul(cz)],
    )
}

/// A shard no larger than the chunks that hold all cells.
fn fitted(dims: [u32; 3], chunk: [u32; 3], shard: [u32; 3]) -> [u32; 3] {
    [0, 1, 2].map(|axis| u64::from(shard[axis]).min(padded(dims[axis], chunk[axis])) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hexcast_core::input::job::ByteSize;
    use hexcast_core::set;

    #[test]
    fn shards_are_slabs_of_whole_chunks() {
        let all = [[70, 9, 67], [1000; 3], [10_000; 3], [200_000, 10, 10], [262_142; 3], [1, 1, 1], [3, 2, 1]];
        for dims in all {
            for bytes in [1, 5_000, 1 << 20, 32 << 20] {
                let asked = set!(ZarrJob { shard_bytes: Some(ByteSize(bytes)), ..ZarrJob::default() });
                let shards = Shards::new(dims, &asked).unwrap();
                let Shards { shard, chunk } = shards;
                assert!((0..3).all(|axis| shard[axis].is_multiple_of(chunk[axis])), "{dims:?}: {shard:?} of {chunk:?}");
                assert!(shard[0] >= dims[0], "{dims:?}: {shard:?}");
                assert!(shards.n_cells() <= bytes.max(row_of(dims, chunk)), "{dims:?}: {shard:?}, {bytes}");
            }
        }
        let of = |dims| Shards::new(dims, &ZarrJob::default()).unwrap();
        assert_eq!(of([3, 2, 1]), Shards { shard: [3, 2, 1], chunk: [3, 2, 1] });
        assert_eq!(of([1000; 3]), Shards { shard: [1024, 64, 64], chunk: [64; 3] });
        assert_eq!(of([10_000; 3]).n_cells(), 10_048 * 64 * 64);
        assert_eq!(of([10_000; 3]).grid([10_000; 3]), [1, 157, 157]);
    }

    #[test]
    fn shapes_are_those_asked_for_or_refused() {
        let of = |chunks, shards| {
            let asked = set!(ZarrJob { chunks, shards, ..ZarrJob::default() });
            Shards::new([100, 90, 80], &asked).map(|found| (found.shard, found.chunk))
        };
        assert_eq!(of(Some([32; 3]), Some([64, 32, 96])), Ok(([64, 32, 96], [32; 3])));
        // no larger than the mesh
        assert_eq!(of(Some([32; 3]), Some([640; 3])), Ok(([128, 96, 96], [32; 3])));
        assert_eq!(of(Some([500, 30, 8]), None), Ok(([100, 90, 80], [100, 30, 8])));
        assert_eq!(of(Some([32; 3]), Some([48, 32, 32])).unwrap_err().code(), "job-value");
        assert_eq!(of(Some([0, 1, 1]), None).unwrap_err().code(), "job-value");
        assert_eq!(of(None, Some([64, 64, 0])).unwrap_err().code(), "job-value");
        let all = set!(ZarrJob { shards: Some([u32::MAX; 3]), ..ZarrJob::default() });
        assert_eq!(Shards::new([262_142; 3], &all).unwrap_err().code(), "job-value");
    }
}
