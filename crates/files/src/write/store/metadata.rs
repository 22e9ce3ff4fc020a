//! What a store says of its arrays: the files `zarr.json`.

use serde_json::{Map, Value, json};

use crate::shards::Shards;
use crate::write::Compress;
use crate::write::sidecar::lines;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Named;
use hexcast_core::grid::lines::Lines;

/// An array as its metadata has it.
pub(super) struct Described<'a> {
    /// Lengths of its axes, z first.
    pub(super) shape: Vec<u64>,
    /// Type of its numbers, and the number that is not stored.
    pub(super) numbers: (&'static str, Value),
    /// Numbers of a file, on each axis.
    pub(super) file: Vec<u64>,
    pub(super) codecs: Value,
    pub(super) attributes: Map<String, Value>,
    pub(super) axes: &'a [&'static str],
}

impl Described<'_> {
    pub(super) fn json(self) -> Value {
        let (data_type, fill_value) = self.numbers;
        let mut facts = json!({
            "zarr_format": 3,
            "node_type": "array",
            "shape": self.shape,
            "data_type": data_type,
            "chunk_grid": { "name": "regular", "configuration": { "chunk_shape": self.file } },
            "chunk_key_encoding": { "name": "default", "configuration": { "separator": "/" } },
            "fill_value": fill_value,
            "codecs": self.codecs,
        });
        if !self.attributes.is_empty() {
            facts["attributes"] = self.attributes.into();
        }
        facts["dimension_names"] = json!(self.axes);
        facts
    }
}

/// Numbers as they are in memory.
pub(super) fn plain() -> Value {
    json!({ "name": "bytes", "configuration": { "endian": "little" } })
}

/// Chunks in shards.
pub(crate) fn sharded(shards: &Shards, compress: Compress) -> Value {
    let [x, y, z] = shards.chunk;
    let mut codecs = vec![plain()];
    if let Compress::Zlib(level) = compress {
        codecs.push(json!({ "name": "gzip", "configuration": { "level": level } }));
    }
    json!([{
        "name": "sharding_indexed",
        "configuration": {
            "chunk_shape": [z, y, x],
            "codecs": codecs,
            "index_codecs": [plain(), { "name": "crc32c" }],
            "index_location": "end",
        },
    }])
}

/// What a store says of its cells: where they lie, and with flags which these are.
pub(super) fn attributes(
    (names, unit): (&[Named], Option<&str>),
    whole: &Lines,
    with_flags: bool,
) -> Map<String, Value> {
    // without numbers of cells, which no part knows
    let mut names: Vec<&Named> = names.iter().collect();
    names.sort_by_key(|named| named.flag);
    let told = |named: &&Named| match named.material.is_empty() {
        true => json!({ "flag": named.flag, "name": named.name }),
        false => json!({ "flag": named.flag, "name": named.name, "material": named.material }),
    };
    let names: Vec<Value> = names.iter().map(told).collect();
    let entries = [
        ("generator", json!(concat!("hexcast ", env!("CARGO_PKG_VERSION")))),
        ("unit", json!(unit)),
        ("origin", json!(whole.origin())),
        ("spacing", json!(whole.spacing())),
        ("flags", json!(names)),
        ("lines", json!({"x": lines(whole, 0), "y": lines(whole, 1), "z": lines(whole, 2)})),
    ];
    let entries = entries.into_iter().filter(|(key, _)| with_flags || *key != "flags");
    entries.map(|(key, value)| (key.to_string(), value)).collect()
}

/// The group, with what its arrays are: readers then need not look for them, which xarray warns about.
pub(super) fn group(attributes: &Value, arrays: Map<String, Value>) -> Value {
    json!({
        "attributes": attributes,
        "consolidated_metadata": { "kind": "inline", "must_understand": false, "metadata": arrays },
        "node_type": "group",
        "zarr_format": 3,
    })
}

/// The text of a file.
///
/// # Errors
/// None but for a defect: all numbers are finite.
pub(super) fn text(value: &Value) -> Result<Vec<u8>> {
    serde_json::to_vec_pretty(value).map_err(|error| Error::new("io", format!("writing Zarr: {error}"), ""))
}
