//! The job: what a caller asks for, as plain data, from a TOML or JSON file, the command line or JavaScript.
//!
//! ```
//! # use hexcast_job as hexcast;
//! let job = hexcast::job::Job::from_toml(r#"
//!     unit = "mm"
//!     cells = 256                      # or dims, cell_size, max_cell_size
//!     padding = { cells = 2 }
//!
//!     [[geometries]]
//!     file = "coil.stl"
//!     name = "copper"
//!     flag = 7
//!     priority = 2
//!     rotate = [0, 0, 90]
//! "#)?;
//! assert_eq!(job.geometries[0].flag, Some(7));
//! # Ok::<(), hexcast::Error>(())
//! ```

use std::marker::PhantomData;

use serde::{Deserialize, Serialize};

use crate::base::error::Result;
pub use crate::input::choices::material::Material;
pub use crate::input::choices::{Fill, Open};

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod arguments;
mod byte_size;
mod geometry_job;
#[cfg(not(target_arch = "wasm32"))]
mod job_file;
mod lines_job;
mod measured_job;
mod numbers;
#[cfg(not(target_arch = "wasm32"))]
mod one_or_many;
mod part_job;
mod patch;
#[cfg(not(target_arch = "wasm32"))]
mod picture_job;
mod quoted;
#[cfg(not(target_arch = "wasm32"))]
mod serde_messages;
mod settings;
mod text;
mod validate;
mod validate_lines;

#[cfg(feature = "cli")]
use arguments::{CELLS, MEMORY, METHOD, OUTPUT, at_least_one, list, number, per_axis};
pub use byte_size::ByteSize;
pub use geometry_job::{BackgroundJob, GeometryJob};
#[cfg(not(target_arch = "wasm32"))]
pub use job_file::{JobFile, Level, Names, RunJob};
pub use lines_job::{DEFAULT_GROWTH, GradedJob, LinesJob};
pub use measured_job::{
    AnisotropicJob, Band, ConformalJob, CutCellsJob, DistanceJob, Everywhere, FractionsJob, FractionsMethod, LinksJob,
    Points, Stencil, TensorsJob,
};
pub use numbers::PerAxis;
#[cfg(not(target_arch = "wasm32"))]
pub use one_or_many::Several;
pub use part_job::{PartJob, numbers_of_parts};
#[cfg(not(target_arch = "wasm32"))]
pub use picture_job::{PlaceJob, SliceJob, ViewJob};
#[doc(hidden)]
pub use quoted::short_number;
use text::{check_json, json_value, of_json, of_json_text, of_toml, toml_table};

/// Cells along the longest axis where the job does not say.
pub const DEFAULT_CELLS: u32 = 128;
/// Distance, in cells, within which `max_cell_size` counts an end point as lying on a mesh line.
///
/// A stair-step surface is off by up to half a cell anyway; a twentieth of that does not show in a solver's result, and real
/// intervals, which rarely have a common divisor, find a size not far below the largest allowed.
pub const DEFAULT_TOLERANCE: f64 = 0.05;

/// What is inside a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Rule {
    /// Inside is where a ray has crossed the surface an odd number of times. Facet orientation does not matter.
    #[default]
    Parity,
    /// Inside is where the winding number is not zero. Overlapping shells unite; orientation matters.
    Nonzero,
}

/// Which backend meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum BackendChoice {
    /// The GPU where there is an adapter, else the CPU.
    #[default]
    Auto,
    /// The GPU; an error where there is none.
    Gpu,
    /// The CPU.
    Cpu,
}

/// Along which axis the rays run. The result does not depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum AxisChoice {
    /// The axis with most cells; those with less than an eighth fewer count as equal, and of equals the first is taken.
    #[default]
    Auto,
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
}

/// An axis of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// Space around the domain or the geometries on both sides of every axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
#[non_exhaustive]
pub enum Padding {
    /// Whole cells, added after the cell size is chosen: mesh lines of the unpadded box stay mesh lines.
    Cells(PerAxis<u32>),
    /// A length in the unit of the files, added before the cell size is chosen.
    Length(PerAxis<f64>),
}

/// What a halo has beyond the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum HaloEdge {
    /// Background.
    #[default]
    Background,
    /// The flag of the nearest cell of the box.
    Clamp,
}

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
    /// Also writes coarser levels of the flags, each of cells twice as large, until no axis has more than 64: viewers then read no more than they show.
    /// Of whole meshes alone, not of parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<Levels>,
    /// Leaves out the files of shards without any flag.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub sparse: bool,
}

/// Which flag of eight cells a cell of twice their size has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Levels {
    /// A flag if any cell has one, of several the rarest of the mesh: thin parts stay, and become thicker.
    Any,
    /// The flag that most cells have, background too: volumes stay, and thin parts go.
    Majority,
}

/// Everything that decides a mesh.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Job {
    /// The geometries, in order: where two of equal priority overlap, one that is closed or flat wins over one that is not, else the later.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub geometries: Vec<GeometryJob>,
    /// Two corners of the box, x0 y0 z0 x1 y1 z1; by default the box around all geometries. Padding comes on top.
    #[serde(deserialize_with = "numbers::list", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = list::<f64, 6>, allow_hyphen_values = true, help_heading = CELLS))]
    pub domain: Option<[f64; 6]>,
    /// Space added on both sides of every axis, to `domain` or to the box around the geometries: whole cells, or a length.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub padding: Option<Padding>,
    /// Cubic cells, so many along the longest axis; 128 where no size is given. At most one of `cells`, `dims`, `cell_size`, `max_cell_size`,
    /// `lines` and `graded` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", group = "way", value_parser = number::<u32>, help_heading = CELLS))]
    pub cells: Option<u32>,
    /// Exactly so many cells on x, y and z, over the domain; padding by cells comes on top.
    #[serde(deserialize_with = "numbers::list", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "NX,NY,NZ", group = "way", value_parser = list::<u32, 3>, help_heading = CELLS))]
    pub dims: Option<[u32; 3]>,
    /// Cell size on all axes or each.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "S|SX,SY,SZ", group = "way", value_parser = per_axis::<f64>, help_heading = CELLS))]
    pub cell_size: Option<PerAxis<f64>>,
    /// Upper limit of the cell size: the largest size per axis, at most this, that puts every end point of every bounding box on a mesh line.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "S", group = "way", value_parser = number::<f64>, help_heading = CELLS))]
    pub max_cell_size: Option<f64>,
    /// Largest distance of an end point from its mesh line, in cells, with `max_cell_size`: 0 to 0.5, by default 0.05.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "CELLS", value_parser = number::<f64>, help_heading = CELLS))]
    pub tolerance: Option<f64>,
    /// All lines of each axis, ascending, in the unit of the files: cells + 1 numbers each, at most 262,143. The first and the last are the
    /// domain.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub lines: Option<LinesJob>,
    /// Generates lines of cells that differ in size: one on every end of every geometry's box, close where geometries are small, far
    /// elsewhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub graded: Option<GradedJob>,
    /// Most cells, however they are chosen; without it only those of an axis are limited. A mesh of more is refused before it starts.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", value_parser = at_least_one::<u64>, help_heading = CELLS))]
    pub max_cells: Option<u64>,
    /// Meshes only some cells of the box, i0 j0 k0 i1 j1 k1: the first on each axis, and the end, exclusive. Lines, flags and all else
    /// are those of the whole box.
    #[serde(deserialize_with = "numbers::list", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "I0,J0,K0,I1,J1,K1", value_parser = list::<u32, 6>, help_heading = CELLS))]
    pub window: Option<[u32; 6]>,
    /// Meshes only one of the windows that the box is divided into: `index` from 1 on, x fastest, `of` so many along x, y and z.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "K/N|K/NXxNYxNZ", conflicts_with = "window", help_heading = CELLS))]
    pub part: Option<PartJob>,
    /// Cells around the window or the part that are also meshed, on both sides of every axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", value_parser = number::<u32>, help_heading = CELLS))]
    pub halo: Option<u32>,
    /// What the halo has beyond the box: background, the default, or the flag of the nearest cell of the box.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "EDGE", help_heading = CELLS))]
    pub halo_edge: Option<HaloEdge>,
    /// Shapes of the chunks and shards of a Zarr store, as cells on x, y, z, or most bytes of a shard. Where it is given, parts are cut along
    /// the borders of shards.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub zarr: Option<ZarrJob>,
    /// What is inside a surface.
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "RULE", default_value_t, help_heading = METHOD))]
    pub rule: Rule,
    /// How cells are decided where a surface is not closed; a geometry may say otherwise.
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "HOW", default_value_t, help_heading = METHOD))]
    pub open: Open,
    /// Which cells geometries have besides those whose centres lie inside; a geometry may say otherwise.
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "CELLS", default_value_t, help_heading = METHOD))]
    pub fill: Fill,
    /// Makes every solid (part, node, item) of every file a geometry of its own.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(feature = "cli", arg(long))]
    pub split: bool,
    /// Gives every geometry the cells outside of it in place of those inside, such as the fluid around a body.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(feature = "cli", arg(long))]
    pub invert: bool,
    /// Closes openings narrower than this number of cells along x, y or z, at least 2, and no wider ones: background cells get `gap_flag` if
    /// fewer than that many in a row lie between flagged cells. Dents and slits as narrow as that are filled, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "K", value_parser = number::<u32>, help_heading = METHOD))]
    pub close_gaps: Option<u32>,
    /// Flag of the cells that `close_gaps` adds, 1 to 255; by default one more than the greatest flag of a geometry.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "F", value_parser = at_least_one::<u8>, help_heading = METHOD))]
    pub gap_flag: Option<u8>,
    /// Looks for thin walls and for cells that two geometries claim; takes several times as long as a mesh on the CPU.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(feature = "cli", arg(long, help_heading = METHOD))]
    pub certify: bool,
    /// Leaves out the checks that are made of every mesh: whether shells have no cell, or another volume than their surface.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(feature = "cli", arg(long, help_heading = METHOD))]
    pub quick: bool,
    /// With `certify`: walls of fewer cells are thin, at least 1; by default 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "K", requires = "certify", value_parser = number::<u32>, help_heading = METHOD))]
    pub thin_cells: Option<u32>,
    /// Measures the links from cells of a fluid to surfaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub links: Option<LinksJob>,
    /// Axes along which the box continues with itself, so that links lead through its sides.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub periodic: Vec<Axis>,
    /// Measures the fraction of each flag in the cells that surfaces cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub fractions: Option<FractionsJob>,
    /// Finds the flags at the points of a staggered (Yee) grid.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub staggered: bool,
    /// Flags of perfect conductors on a staggered grid: all edges of their cells conduct, not only those within the surface.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub conductors: Vec<u8>,
    /// Measures the fractions of edges and faces that lie outside metal.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub conformal: Option<ConformalJob>,
    /// Measures the signed distance of centres or nodes to the nearest surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub distance: Option<DistanceJob>,
    /// Averages the permittivity in the cell around each point of E, as tensors.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub tensors: Option<TensorsJob>,
    /// Cuts the cells of one flag at its surface, for files that hold cut cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub cut_cells: Option<CutCellsJob>,
    /// What meshes: the GPU or the CPU; the cells do not depend on it.
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "BACKEND", default_value_t, help_heading = METHOD))]
    pub backend: BackendChoice,
    /// Along which axis the rays run; the cells do not depend on it.
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "AXIS", default_value_t, help_heading = METHOD))]
    pub axis: AxisChoice,
    /// Most bytes of memory to take, as a number or as text such as "2GB"; what does not fit is refused before it starts, unless its columns may
    /// spill to disk.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "SIZE", help_heading = MEMORY))]
    pub max_memory: Option<ByteSize>,
    /// Unit of the files' lengths, such as "mm"; repeated in every output.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "UNIT"))]
    pub unit: Option<String>,
    /// Largest distance of the triangles of STEP and IGES files from their surfaces, in the unit of the job; by default a tenth of the smallest cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "D", value_parser = number::<f64>))]
    pub deviation: Option<f64>,
    /// Name and substance of the cells of no geometry, flag 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "KEY=VALUE,...", help_heading = OUTPUT))]
    pub background: Option<BackgroundJob>,
}

impl Job {
    /// A job of geometries, without settings.
    pub fn new(geometries: Vec<GeometryJob>) -> Job {
        Job { geometries, ..Job::default() }
    }

    /// Reads a job from TOML and validates it.
    ///
    /// # Errors
    /// - `job-syntax`: the text is not TOML, with line and column.
    /// - `job-value`: an unknown key or a value of a wrong type, with the key, and line and column.
    /// - Those of [`Job::validate`].
    pub fn from_toml(text: &str) -> Result<Job> {
        let job: Job = of_toml(toml_table(text)?, text)?;
        job.validate()?;
        Ok(job)
    }

    /// Reads a job from JSON and validates it.
    ///
    /// # Errors
    /// Those of [`Job::from_toml`].
    pub fn from_json(text: &str) -> Result<Job> {
        check_json(text)?;
        let job: Job = of_json_text(text, PhantomData)?;
        job.validate()?;
        Ok(job)
    }

    /// Reads a job from JSON that a program wrote, and validates it: errors name the key, but no line and column.
    ///
    /// # Errors
    /// Those of [`Job::from_toml`].
    pub fn from_plain_json(text: &str) -> Result<Job> {
        // a value has no lines and columns
        let job: Job = of_json(json_value(text)?)?;
        job.validate()?;
        Ok(job)
    }

    /// Whether every solid of a geometry's file is one of its own.
    #[doc(hidden)]
    pub fn splits(&self, geometry: &GeometryJob) -> bool {
        self.split || geometry.split
    }

    /// Along which axes the box continues with itself.
    #[doc(hidden)]
    pub fn periodic_axes(&self) -> [bool; 3] {
        [Axis::X, Axis::Y, Axis::Z].map(|axis| self.periodic.contains(&axis))
    }

    /// Whether something is asked for that is measured at the surfaces.
    #[doc(hidden)]
    pub fn is_measured(&self) -> bool {
        let has_cut = self.fractions.is_some() || self.conformal.is_some() || self.tensors.is_some();
        self.links.is_some() || self.staggered || has_cut || self.distance.is_some() || self.cut_cells.is_some()
    }

    /// Writes the job as JSON; reading it back gives the same job.
    pub fn to_json(&self) -> String {
        // a struct of numbers, strings and lists always has a JSON form
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests;
