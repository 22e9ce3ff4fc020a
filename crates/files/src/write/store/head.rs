//! What a store says of itself and of its levels: the names and bytes of all files but shards.

use serde_json::{Map, Value, json};

use super::levels::{group_of, levels, new_groups, zarr_of_levels};
use super::metadata::{Described, attributes, group, plain, sharded, text};
use super::numbers::{FLAG, OfCells};
use super::ome::{OmeLevel, ome};
use crate::shards::Shards;
use crate::write::Compress;
use hexcast_core::base::error::Result;
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_core::input::job::ZarrJob;
use hexcast_derived::mesh::Named;

/// What a store says of itself; nothing that only the whole mesh knows.
pub(crate) struct Head<'a> {
    pub(crate) whole: &'a Lines,
    pub(crate) cells: &'a OfCells<'a>,
    pub(crate) zarr: ZarrJob,
    pub(crate) compress: Compress,
    pub(crate) names: &'a [Named],
    pub(crate) unit: Option<&'a str>,
}

impl Head<'_> {
    /// The file by which others know that there is a store: it has what is said of all arrays, too.
    ///
    /// # Errors
    /// Those of [`Shards::new`].
    pub(crate) fn group(&self) -> Result<Vec<u8>> {
        let levels = levels(self.whole, &self.zarr)?;
        let mut arrays = Map::new();
        for (level, lines) in levels.iter().enumerate() {
            let (group, of) = (group_of(level), self.of_level(lines)?);
            arrays.extend(new_groups(level).into_iter().map(|group| (group, bare_group())));
            arrays.extend(of.arrays()?.into_iter().map(|(name, of)| (format!("{group}{name}"), of)));
        }
        let of_level = |(level, lines)| OmeLevel {
            path: format!("{}{}", group_of(level), self.cells.name),
            lines,
            step: 2f64.powi(level as i32),
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
    pub(crate) fn files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let mut files = vec![("zarr.json".to_string(), self.group()?)];
        for (level, whole) in levels(self.whole, &self.zarr)?.iter().enumerate() {
            let (group, of) = (group_of(level), self.of_level(whole)?);
            for group in new_groups(level) {
                files.push((format!("{group}/zarr.json"), text(&bare_group())?));
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

/// A group that says nothing.
fn bare_group() -> Value {
    json!({ "attributes": {}, "node_type": "group", "zarr_format": 3 })
}
