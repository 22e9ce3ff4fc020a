//! How a Zarr store is divided.

use serde::{Deserialize, Serialize};

use super::{ByteSize, numbers};

/// Shapes of the chunks and shards of a Zarr store; a shape that is not given follows from the number of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct ZarrJob {
    /// Cells of a chunk, which is compressed by itself, on x, y, z.
    #[serde(deserialize_with = "numbers::list", skip_serializing_if = "Option::is_none")]
    pub chunks: Option<[u32; 3]>,
    /// Cells of a shard, which is a file, on x, y, z: multiples of those of a chunk.
    #[serde(deserialize_with = "numbers::list", skip_serializing_if = "Option::is_none")]
    pub shards: Option<[u32; 3]>,
    /// Most cells of a shard, as a size: it has a byte a cell before it is compressed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shard_bytes: Option<ByteSize>,
}
