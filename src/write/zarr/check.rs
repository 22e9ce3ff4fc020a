//! What is in a store that was written: its shards, and whether one can be read.

use std::num::NonZeroU64;
use std::sync::{Arc, Once};

use serde_json::Value;
use zarrs::array::{Array, ArrayMetadata, CodecOptions};
use zarrs::storage::store::MemoryStore;
use zarrs_codec::{ArrayToBytesCodecTraits, Codec, CodecRuntimePluginV3, register_codec_v3};

use super::gzip::Gzip;
use crate::error::{Error, Result};
use crate::job::ZarrJob;
use crate::write::Compress;

/// The array of the flags of a store, from its metadata.
pub struct Stored {
    array: Array<MemoryStore>,
    shape: Vec<NonZeroU64>,
    grid: [u64; 3],
    metadata: Value,
}

impl Stored {
    /// Where the metadata of the flags is.
    pub const METADATA: &str = "flag/zarr.json";
    /// The folder of the shards.
    pub const SHARDS: &str = "flag/c/";

    /// Reads the metadata of the flags.
    ///
    /// # Errors
    /// `io` where it is not that of an array of flags in shards.
    pub fn new(metadata: &[u8]) -> Result<Stored> {
        static GZIP: Once = Once::new();
        // the level matters to writers only
        let gzip = || CodecRuntimePluginV3::new(|name| name == "gzip", |_| Ok(Codec::BytesToBytes(Arc::new(Gzip(6)))));
        GZIP.call_once(|| {
            register_codec_v3(gzip());
        });
        let wrong = |why: String| {
            let message = format!("{} is not that of flags that hexcast wrote: {why}", Stored::METADATA);
            Error::new("io", message, "name a Zarr folder that hexcast wrote, or write it again")
        };
        let value: Value = serde_json::from_slice(metadata).map_err(|error| wrong(error.to_string()))?;
        let read: ArrayMetadata = serde_json::from_slice(metadata).map_err(|error| wrong(error.to_string()))?;
        let array = Array::new_with_metadata(Arc::new(MemoryStore::new()), "/flag", read);
        let array = array.map_err(|error| wrong(error.to_string()))?;
        let shape = array.chunk_shape(&[0, 0, 0]).map_err(|error| wrong(error.to_string()))?;
        let grid = <[u64; 3]>::try_from(array.chunk_grid_shape());
        let grid = grid.map_err(|_| wrong("it does not have three axes".into()))?;
        let is_sharded = value["codecs"][0]["name"] == "sharding_indexed" && value["data_type"] == "uint8";
        if !is_sharded {
            return Err(wrong("its chunks are not in shards, or its cells are not uint8".into()));
        }
        Ok(Stored { array, shape: shape.to_vec(), grid, metadata: value })
    }

    /// Number of shards on z, y, x.
    pub fn grid(&self) -> [u64; 3] {
        self.grid
    }

    /// Keys of all shards, z slowest.
    pub fn keys(&self) -> impl Iterator<Item = String> + use<> {
        let [nz, ny, nx] = self.grid;
        let rows = (0..nz).flat_map(move |k| (0..ny).map(move |j| (k, j)));
        rows.flat_map(move |(k, j)| (0..nx).map(move |i| format!("{}{k}/{j}/{i}", Stored::SHARDS)))
    }

    /// Whether a key is that of a shard.
    pub fn has(&self, key: &str) -> bool {
        let Some(rest) = key.strip_prefix(Stored::SHARDS) else { return false };
        // a number has one text: 01 is none
        let number = |text: &str| text.parse::<u64>().ok().filter(|number| number.to_string() == text);
        let index: Option<Vec<u64>> = rest.split('/').map(number).collect();
        index.is_some_and(|index| index.len() == 3 && (0..3).all(|axis| index[axis] < self.grid[axis]))
    }

    /// Reads all cells of a shard: its index and its chunks have checksums and known sizes.
    ///
    /// # Errors
    /// `io` with what is wrong.
    pub fn check(&self, shard: &[u8]) -> Result<()> {
        let serial = CodecOptions::default().with_concurrent_target(1);
        let codecs = self.array.codecs();
        let decoded =
            codecs.decode(shard.into(), &self.shape, self.array.data_type(), self.array.fill_value(), &serial);
        decoded.map(|_| ()).map_err(|error| Error::new("io", format!("it cannot be read: {error}"), ""))
    }

    /// How the store was written: shapes and compression, which make the same bytes again.
    pub fn options(&self) -> (ZarrJob, Compress) {
        let sharding = &self.metadata["codecs"][0]["configuration"];
        let shape = |list: &Value| {
            let list: Option<Vec<u32>> = serde_json::from_value(list.clone()).ok();
            list.and_then(|list| <[u32; 3]>::try_from(list).ok()).map(|[z, y, x]| [x, y, z])
        };
        let codecs = sharding["codecs"].as_array();
        let level = codecs.into_iter().flatten().find_map(|codec| codec["configuration"]["level"].as_u64());
        let compress = level.and_then(|level| u8::try_from(level).ok()).map_or(Compress::None, Compress::Zlib);
        let shards = shape(&self.metadata["chunk_grid"]["configuration"]["chunk_shape"]);
        (ZarrJob { chunks: shape(&sharding["chunk_shape"]), shards, shard_bytes: None }, compress)
    }
}
