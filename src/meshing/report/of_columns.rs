//! The report of a mesh that was read back: what a column file says.

use serde::{Serialize, Serializer};

use hexcast_core::cells::volumes::Volumes;
use hexcast_core::grid::lines::Grading;
use hexcast_derived::mesh::Mesh;

/// Keys of a report that only the meshing fills in.
const OF_MESHING: [&str; 22] = [
    "backend",
    "adapter",
    "driver",
    "fallback",
    "device_check",
    "window",
    "rule",
    "open",
    "filled",
    "gaps",
    "links",
    "fractions",
    "staggered",
    "conformal",
    "distance",
    "tensors",
    "certificate",
    "doubtful",
    "flags_hash",
    "flags_sha256",
    "job",
    "cells_per_second",
];

/// A report of what the file holds; null where [`super::Report`] has what only the meshing knew.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct ColumnsReport<'a> {
    /// Version of hexcast that reads it.
    pub version: &'a str,
    /// Unit of lengths, if the file names one.
    pub unit: Option<&'a str>,
    /// Number of cells on x, y and z.
    pub dims: [u32; 3],
    /// First mesh line on each axis.
    pub origin: [f64; 3],
    /// Cell size on each axis; null where cells differ in size.
    pub spacing: Option<[f64; 3]>,
    /// The lines and how their distances change; null where all cells are equal.
    pub grading: Option<Grading>,
    /// Axis of the rays: x, y or z.
    pub ray_axis: &'a str,
    /// Number of rays.
    pub rays: u64,
    /// Number of their crossings.
    pub crossings: u64,
    /// Number of their runs.
    pub runs: u64,
    /// Rays that do not leave every geometry they enter.
    pub odd_rays: u64,
    /// Number of cells.
    pub cells: u64,
    /// Every flag in use.
    pub flags: Vec<ColumnsFlag<'a>>,
    findings: [(); 0],
    warnings: [(); 0],
    seconds: Unknown,
    #[serde(flatten)]
    unknown: Unknown,
}

/// Keys whose values are null.
#[derive(Debug)]
struct Unknown(&'static [&'static str]);

impl Serialize for Unknown {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|key| (key, ())))
    }
}

/// A flag of columns.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct ColumnsFlag<'a> {
    /// The flag, 1 to 255.
    pub flag: u8,
    /// Its name, empty where the file has none.
    pub name: &'a str,
    /// Number of its cells.
    pub cells: u64,
    /// Their volume; null where cells differ in size and the columns cannot be read.
    pub volume: Option<f64>,
    #[serde(flatten)]
    unknown: Unknown,
}

impl ColumnsReport<'_> {
    /// Describes a mesh.
    pub fn new(mesh: &Mesh) -> ColumnsReport<'_> {
        let (lines, columns) = (mesh.lines(), mesh.columns());
        ColumnsReport {
            version: env!("CARGO_PKG_VERSION"),
            unit: mesh.unit(),
            dims: lines.dims(),
            origin: lines.origin(),
            spacing: lines.spacing(),
            grading: Grading::of(lines, mesh.unit()),
            ray_axis: ["x", "y", "z"][columns.rays().axis],
            rays: columns.rays().n_rays(),
            crossings: columns.n_crossings(),
            runs: columns.n_runs(),
            odd_rays: columns.odd_rays(),
            cells: lines.n_cells(),
            flags: flags_of_columns(mesh),
            findings: [],
            warnings: [],
            seconds: Unknown(&[]),
            unknown: Unknown(&OF_MESHING),
        }
    }
}

fn flags_of_columns(mesh: &Mesh) -> Vec<ColumnsFlag<'_>> {
    let all_cells = mesh.columns().cells_per_flag();
    let volumes = Volumes::new(mesh.columns(), mesh.lines(), mesh.lines()).ok().map(|volumes| volumes.of_flags);
    let fact = |flag: u8| {
        let cells = all_cells[usize::from(flag)];
        let named = mesh.names().iter().find(|named| named.flag == flag);
        let volume = volumes.map(|volumes| volumes[usize::from(flag)]);
        let name = named.map_or("", |named| named.name.as_str());
        (cells > 0 || named.is_some()).then_some(ColumnsFlag {
            flag,
            name,
            cells,
            volume,
            unknown: Unknown(&["mesh_volume", "volume_bound"]),
        })
    };
    (1..=255).filter_map(fact).collect()
}
