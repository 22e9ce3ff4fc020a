//! What is in a store that was written: its shards, and whether one can be read.

use std::io::{Read, copy, sink};

use flate2::bufread::GzDecoder;
use serde_json::{Value, json};

use crate::shards::Shards;
use crate::write::Compress;
use crate::write::store::{NOWHERE, checksum, sharded};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::flags::n_cells;
use hexcast_core::input::job::{Levels, ZarrJob};
use hexcast_core::set;

/// The array of the flags of a store, or of a coarser level of it, from its metadata.
pub struct Stored {
    /// The path of its group, with a slash at its end; empty for the flags of the mesh.
    group: String,
    /// Whether shards without flags have no file.
    is_sparse: bool,
    shapes: Shards,
    /// Number of shards on z, y, x.
    grid: [u64; 3],
    compress: Compress,
}

impl Stored {
    /// Where the metadata of the flags is.
    pub const METADATA: &str = "flag/zarr.json";
    /// The folder of the shards.
    pub const SHARDS: &str = "flag/c/";
    /// The folder of the groups of coarser levels.
    pub const LEVELS: &str = "levels/";

    /// Whether a key is one of a shard, of any level of any store.
    pub fn is_of_shard(key: &str) -> bool {
        let of_level = || key.strip_prefix(Stored::LEVELS).and_then(|rest| rest.split_once('/'));
        key.starts_with(Stored::SHARDS) || of_level().is_some_and(|(_, rest)| rest.starts_with(Stored::SHARDS))
    }

    /// The groups of the coarser levels of a store, with a slash at the end of each, and what decides the flags of these, from the metadata of its group.
    ///
    /// # Errors
    /// `io` where the metadata is not that of a group that hexcast wrote.
    pub fn levels(group: &[u8]) -> Result<(Vec<String>, Option<Levels>)> {
        let wrong = |why: String| {
            let message = format!("zarr.json is not that of a store that hexcast wrote: {why}");
            Error::new("io", message, "name a Zarr folder that hexcast wrote, or write it again")
        };
        let value: Value = serde_json::from_slice(group).map_err(|error| wrong(error.to_string()))?;
        let image = &value["attributes"]["ome"]["multiscales"][0];
        // stores of versions that had no levels say nothing of them
        let Some(datasets) = image["datasets"].as_array() else { return Ok((Vec::new(), None)) };
        let group_of = |dataset: &Value| {
            let path = dataset["path"].as_str().unwrap_or_default();
            path.strip_suffix("flag").map(str::to_string).ok_or_else(|| wrong(format!("it has a level {path:?}")))
        };
        let groups = datasets.iter().skip(1).map(group_of).collect::<Result<Vec<String>>>()?;
        let rule = serde_json::from_value(image["type"].clone()).unwrap_or_default();
        Ok((groups, rule))
    }

    /// Reads the metadata of the flags of a group: that of the store, which is empty, or one of [`Stored::levels`].
    ///
    /// # Errors
    /// `io` where it is not that of an array of flags that hexcast wrote.
    pub fn new(group: &str, metadata: &[u8]) -> Result<Stored> {
        let wrong = |why: &str| {
            let message = format!("{group}{} is not that of flags that hexcast wrote: {why}", Stored::METADATA);
            Error::new("io", message, "name a Zarr folder that hexcast wrote, or write it again")
        };
        let value: Value = serde_json::from_slice(metadata).map_err(|error| wrong(&error.to_string()))?;
        let on_xyz = |list: &Value| {
            let list: Option<[u32; 3]> = serde_json::from_value(list.clone()).ok();
            list.map(|[z, y, x]| [x, y, z]).filter(|list| !list.contains(&0))
        };
        let dims = on_xyz(&value["shape"]).ok_or_else(|| wrong("its shape is not three numbers of cells"))?;
        let sharding = &value["codecs"][0]["configuration"];
        let shard = on_xyz(&value["chunk_grid"]["configuration"]["chunk_shape"]);
        let (shards, chunks) = (shard, on_xyz(&sharding["chunk_shape"]));
        if shards.is_none() || chunks.is_none() {
            return Err(wrong("its chunks are not in shards"));
        }
        let given = set!(ZarrJob { chunks, shards, ..ZarrJob::default() });
        let shapes = Shards::new(dims, &given).map_err(|error| wrong(&error.to_string()))?;
        let level = sharding["codecs"][1]["configuration"]["level"].as_u64().and_then(|level| u8::try_from(level).ok());
        let compress = level.map_or(Compress::None, Compress::Zlib);
        // what decides how a shard is read
        let read = [
            ("zarr_format", json!(3)),
            ("node_type", json!("array")),
            ("data_type", json!("uint8")),
            ("fill_value", json!(0)),
            ("codecs", sharded(&shapes, compress)),
            ("chunk_key_encoding", json!({ "name": "default", "configuration": { "separator": "/" } })),
        ];
        if let Some((key, expected)) = read.iter().find(|(key, expected)| value[key] != *expected) {
            return Err(wrong(&format!("{key} is {}, not {expected}", value[key])));
        }
        let [nx, ny, nz] = [0, 1, 2].map(|axis| u64::from(dims[axis].div_ceil(shapes.shard[axis])));
        let is_sparse = value["attributes"]["sparse"] == json!(true);
        Ok(Stored { group: group.into(), is_sparse, shapes, grid: [nz, ny, nx], compress })
    }

    /// Number of shards on z, y, x.
    pub fn grid(&self) -> [u64; 3] {
        self.grid
    }

    /// Whether a shard may be missing: it has no flag then.
    pub fn is_sparse(&self) -> bool {
        self.is_sparse
    }

    /// The folder of its shards.
    pub fn shards(&self) -> String {
        format!("{}{}", self.group, Stored::SHARDS)
    }

    /// Keys of all shards, z slowest.
    pub fn keys(&self) -> impl Iterator<Item = String> + use<> {
        let [nz, ny, nx] = self.grid;
        let folder = self.shards();
        let rows = (0..nz).flat_map(move |k| (0..ny).map(move |j| (k, j)));
        rows.flat_map(move |(k, j)| {
            let folder = folder.clone();
            (0..nx).map(move |i| format!("{folder}{k}/{j}/{i}"))
        })
    }

    /// Whether a key is that of a shard.
    pub fn has(&self, key: &str) -> bool {
        let Some(rest) = key.strip_prefix(&self.shards()) else { return false };
        // a number has one text: 01 is none
        let number = |text: &str| text.parse::<u64>().ok().filter(|number| number.to_string() == text);
        let index: Option<Vec<u64>> = rest.split('/').map(number).collect();
        index.is_some_and(|index| index.len() == 3 && (0..3).all(|axis| index[axis] < self.grid[axis]))
    }

    /// Reads all cells of a shard: its index has a checksum, its chunks lie within it and have their number of cells, and a checksum each
    /// where they are compressed.
    ///
    /// # Errors
    /// `io` with what is wrong.
    pub fn check(&self, shard: &[u8]) -> Result<()> {
        let wrong = |why: String| Error::new("io", format!("it cannot be read: {why}"), "");
        let Shards { shard: [sx, sy, sz], chunk: [cx, cy, cz] } = self.shapes;
        let n_places = 16 * (sx / cx) as usize * (sy / cy) as usize * (sz / cz) as usize;
        let Some(n_of_chunks) = shard.len().checked_sub(n_places + 4) else {
            return Err(wrong(format!("its {} bytes are fewer than the {} of its index", shard.len(), n_places + 4)));
        };
        let (chunks, index) = shard.split_at(n_of_chunks);
        let (places, stored) = index.split_at(n_places);
        if checksum(places) != stored {
            return Err(wrong("the checksum of its index is not that of the index".into()));
        }
        let expected = n_cells(&self.shapes.chunk.map(|n| 0..n)) as u64;
        for (number, place) in places.chunks_exact(16).enumerate().filter(|(_, place)| *place != NOWHERE) {
            let of_chunk =
                self.n_cells_of(chunks, place, expected + 1).map_err(|why| wrong(format!("chunk {number} {why}")))?;
            if of_chunk != expected {
                return Err(wrong(format!("chunk {number} has {of_chunk} cells or more, not {expected}")));
            }
        }
        Ok(())
    }

    /// Cells of the chunk at a place; of one that is compressed at most so many are counted.
    fn n_cells_of(&self, chunks: &[u8], place: &[u8], most: u64) -> std::result::Result<u64, String> {
        let number = |at: usize| place[at..at + 8].iter().rev().fold(0u64, |n, &byte| n << 8 | u64::from(byte));
        let (start, length) = (number(0), number(8));
        let end = start.checked_add(length).filter(|&end| end <= chunks.len() as u64);
        let end =
            end.ok_or_else(|| format!("of {length} bytes at {start} ends beyond the {} bytes of all", chunks.len()))?;
        let chunk = &chunks[start as usize..end as usize];
        if self.compress == Compress::None {
            return Ok(length);
        }
        let mut decoder = GzDecoder::new(chunk);
        let n = copy(&mut decoder.by_ref().take(most), &mut sink());
        let n = n.map_err(|error| format!("cannot be decompressed: {error}"))?;
        match decoder.into_inner() {
            [] => Ok(n),
            rest if n < most => Err(format!("has {} bytes after its end", rest.len())),
            _ => Ok(n),
        }
    }

    /// How the store was written: shapes and compression, which make the same bytes again.
    pub fn options(&self) -> (ZarrJob, Compress) {
        let Shards { shard, chunk } = self.shapes;
        let sparse = self.is_sparse;
        let shapes = set!(ZarrJob { chunks: Some(chunk), shards: Some(shard), sparse, ..ZarrJob::default() });
        (shapes, self.compress)
    }
}
