//! The report: what a mesh was made of, by whom, what came out, and what the reader should know about it.
//!
//! Facts of the mesh, facts of the caller -> [`Report`], built once, when all is done. Its JSON form is stable: keys are added,
//! never renamed. Lengths are in the unit of the files, times in seconds.

use serde::{Deserialize, Serialize};

use hexcast_core::base::finding::Finding;
use hexcast_core::grid::lines::{Grading, Lines, Residual};
use hexcast_core::input::job::{Job, Rule};
use hexcast_core::input::sources::Source;
use hexcast_core::open_surfaces::doubt::{Corners, Doubtful};
use hexcast_derived::cut_cells::conformal::Conformal;
use hexcast_derived::cut_cells::tensors::Tensors;
use hexcast_derived::distance::Distance;
use hexcast_derived::fractions::Fractions;
use hexcast_derived::gaps::Gaps;
use hexcast_derived::links::Links;
use hexcast_derived::mesh::Mesh;
use hexcast_derived::staggered::Staggered;

mod of_certificate;
mod of_columns;
mod of_geometries;
mod of_measured;
mod of_shells;
mod of_window;

pub use hexcast_core::grid::closed::BadEdges;
pub use hexcast_core::input::edges::BadEdge;
pub use of_certificate::{AxisName, CertificateReport, GapReport, OverlapReport, ThinWallReport};
pub use of_columns::{ColumnsFlag, ColumnsReport};
pub use of_geometries::{FillReport, FlagReport, GeometryReport, OpenReport, flag_reports, is_cut, thick_flags};
pub use of_measured::{
    ComponentReport, ConformalReport, DistanceReport, FractionsReport, LinksReport, PointsReport, StaggeredReport,
    TensorsReport, VolumeReport,
};
pub use of_shells::{MAX_OFF, MAX_SHELLS, MAX_SHELLS_OF_PART, ShellCheck, ShellReport, off};
pub use of_window::{FlagSum, ShellsReport, WindowReport, WindowSums, WithoutCells};

/// Seconds of each stage.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Seconds {
    /// From the first byte read to the columns, or to the flags where the caller expands them; without opening a device,
    /// hashing flags and writing files.
    pub total: f64,
    /// Reading the files.
    pub read: f64,
    /// Domain and mesh lines.
    pub lines: f64,
    /// Snapping the corners.
    pub snap: f64,
    /// Lattice, intersection and mapping, with all transfers.
    pub columns: f64,
    /// Measuring links from cells to surfaces and fractions of cells, and staggered grids, where asked for.
    pub measured: Option<f64>,
    /// Expanding all flags in memory, where asked for.
    pub flags: Option<f64>,
    /// Opening the device and compiling its kernels.
    pub device: f64,
    /// Counting cells and checking geometries for this report.
    pub report: f64,
    /// Hashing the flags.
    pub hash: Option<f64>,
    /// Writing the file.
    pub write: Option<f64>,
}

/// Most bytes held at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PeakBytes {
    /// By the whole process, where the system says.
    pub host: Option<u64>,
    /// In facets, lattice and columns while meshing, as the library counts them.
    pub meshing: u64,
    /// In buffers on the device.
    pub device: u64,
    /// Outside memory: columns that spilled.
    pub spilled: u64,
}

/// One input: a file, or facets that were in memory.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct InputReport {
    /// Its name as the job has it.
    pub file: String,
    /// BLAKE3 of its bytes, as `b3sum` prints it; null for facets that were in memory.
    pub blake3: Option<String>,
    /// Its length.
    pub bytes: u64,
    /// How it was written.
    pub format: &'static str,
    /// The unit of its coordinates; null where it does not say.
    pub unit: Option<&'static str>,
    /// Of STEP and IGES: largest distance of its triangles from its surfaces, in that unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
    /// Of STEP and IGES: the program that made the triangles, and its release.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub converted_by: Option<String>,
    /// Number of facets.
    pub facets: u64,
    /// Facets whose file normal points against their corners; the corners count.
    pub wrong_normals: u64,
    /// Facets without area.
    pub zero_area: u64,
    /// What was accepted although it is not as it should be.
    pub warnings: Vec<String>,
}

impl InputReport {
    /// Describes a file.
    pub fn new(source: &Source) -> InputReport {
        let contents = &source.contents;
        InputReport {
            file: source.file.clone(),
            blake3: source.blake3.clone(),
            bytes: contents.n_bytes,
            format: contents.format.name(),
            unit: contents.unit,
            deviation: contents.conversion.as_ref().map(|of| of.deviation),
            converted_by: contents.conversion.as_ref().map(|of| of.program.clone()),
            facets: contents.n_facets,
            wrong_normals: contents.wrong_normals,
            zero_area: contents.zero_area,
            warnings: contents.warnings.clone(),
        }
    }
}

/// Rays of a GPU's that the CPU cast again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DeviceCheck {
    /// Their number.
    pub rays: u64,
    /// Those of them whose cells differed; the CPU then meshed again what was not right.
    pub differing: u64,
}

/// Most boxes of doubtful cells that are listed.
pub const MAX_BOXES: usize = 1000;

/// Cells of open geometries that rays do not decide.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DoubtReport {
    /// Number of cells.
    pub cells: u64,
    /// Boxes of them, at most 1,000, the largest first: the first cell x, y, z and the end, exclusive. No cell is in two.
    pub boxes: Vec<Corners>,
    /// Number of cells in these boxes.
    pub cells_in_boxes: u64,
    /// Whether these are all.
    pub are_all: bool,
}

impl DoubtReport {
    /// Lists cells.
    pub fn new(doubtful: &Doubtful) -> DoubtReport {
        let boxes = doubtful.boxes.clone();
        let n_of = |[low, high]: &Corners| -> u64 { (0..3).map(|axis| u64::from(high[axis] - low[axis])).product() };
        let (cells, cells_in_boxes) = (doubtful.n_cells, boxes.iter().map(n_of).sum());
        DoubtReport { cells, boxes, cells_in_boxes, are_all: cells_in_boxes == cells }
    }
}

/// What is known of a mesh once its columns are made.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MeshFacts {
    /// Version of hexcast.
    pub version: &'static str,
    /// "gpu" or "cpu".
    pub backend: &'static str,
    /// Name of the GPU adapter; null on the CPU.
    pub adapter: Option<String>,
    /// Driver of the adapter.
    pub driver: Option<String>,
    /// Why the CPU meshed although a GPU was looked for: there is none, it is one in software, or it failed; null otherwise.
    pub fallback: Option<String>,
    /// What came of casting a sample of the GPU's rays again; None if no GPU meshed.
    pub device_check: Option<DeviceCheck>,
    /// Unit of lengths, if the caller named one.
    pub unit: Option<String>,
    /// The files.
    pub inputs: Vec<InputReport>,
    /// The geometries, in meshing order.
    pub geometries: Vec<GeometryReport>,
    /// Number of cells on x, y, z.
    pub dims: [u32; 3],
    /// The mesh lines of the whole box.
    #[serde(skip)]
    pub whole: Lines,
    /// Which cells of a larger box these are; null where they are all.
    pub window: Option<WindowReport>,
    /// First corner of the box.
    pub origin: [f64; 3],
    /// Cell size on x, y, z; null where cells differ in size.
    pub spacing: Option<[f64; 3]>,
    /// The lines and how their distances change; null where all cells are equal.
    pub grading: Option<Grading>,
    /// End points of the geometries' boxes and their distances from mesh lines.
    pub end_points: [Vec<Residual>; 3],
    /// Largest distance, in cells, that a corner was moved to the exact grid.
    pub snap_in_cells: f64,
    /// What is inside.
    pub rule: Rule,
    /// Axis of the rays: "x", "y" or "z".
    pub ray_axis: &'static str,
    /// Number of rays.
    pub rays: u64,
    /// Rays whose columns an interrupted run had left; they were not cast again.
    pub rays_kept: u64,
    /// Number of crossings of rays and facets.
    pub crossings: u64,
    /// Number of runs.
    pub runs: u64,
    /// Rays that do not leave every geometry they enter: the surface is open there.
    pub odd_rays: u64,
    /// Geometries that are not closed, unless the rays of one axis decided them as they are.
    pub open: Vec<OpenReport>,
    /// Geometries that have the cells along their surfaces.
    pub filled: Vec<FillReport>,
    /// Openings that were closed; null where none were to be.
    pub gaps: Option<Gaps>,
    /// Number of cells.
    pub cells: u64,
    /// Cells of every flag of the job, ascending.
    pub flags: Vec<FlagReport>,
    /// Thin walls and overlaps; null where the job did not ask for them.
    pub certificate: Option<CertificateReport>,
    /// Links from cells of the fluid to surfaces; null where the job did not ask for them.
    #[serde(rename = "links")]
    pub links_report: Option<LinksReport>,
    /// These links; None unless asked for.
    #[serde(skip)]
    pub links: Option<Links>,
    /// Cells that surfaces cut, and the volumes that follow; null where the job did not ask for them.
    #[serde(rename = "fractions")]
    pub fractions_report: Option<FractionsReport>,
    /// The fractions of flags in these cells; None unless asked for.
    #[serde(skip)]
    pub fractions: Option<Fractions>,
    /// Points of the staggered grid; null where the job did not ask for them.
    #[serde(rename = "staggered")]
    pub staggered_report: Option<StaggeredReport>,
    /// The flags at these points; None unless asked for.
    #[serde(skip)]
    pub staggered: Option<Staggered>,
    /// Edges and faces outside metal; null where the job did not ask for them.
    #[serde(rename = "conformal")]
    pub conformal_report: Option<ConformalReport>,
    /// The fractions of these; None unless asked for.
    #[serde(skip)]
    pub conformal: Option<Conformal>,
    /// Signed distances; null where the job did not ask for them.
    #[serde(rename = "distance")]
    pub distance_report: Option<DistanceReport>,
    /// These; None unless asked for.
    #[serde(skip)]
    pub distance: Option<Distance>,
    /// Points around which permittivity was smoothed; null where the job did not ask for them.
    #[serde(rename = "tensors")]
    pub tensors_report: Option<TensorsReport>,
    /// The permittivity at these; None unless asked for.
    #[serde(skip)]
    pub tensors: Option<Tensors>,
    /// Cells that the winding number or a vote decided, as their rays are not all even or do not agree.
    pub doubtful: DoubtReport,
    /// These cells as a mesh with the flag 1 there; None unless asked for.
    #[serde(skip)]
    pub doubt: Option<Mesh>,
    /// Hash of the flags, see `docs/flags_hash.md`; None where the columns have spilled.
    pub flags_hash: Option<String>,
    /// The job with all that it left open filled in: `--job` takes it, from the folder that this mesh was made in. Without `max_memory`,
    /// which changes no cell.
    pub job: Job,
    /// What the reader should know, as data.
    pub findings: Vec<Finding>,
    /// The sentences of `findings`.
    pub warnings: Vec<String>,
    /// Memory, without that of the whole process.
    #[serde(skip)]
    pub peak_bytes: PeakBytes,
    /// Times of the stages; those of the caller are 0 or null.
    #[serde(skip)]
    pub seconds: Seconds,
}

/// What only the caller of a mesh knows: what it did before and after.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct CallerFacts {
    /// Seconds that reading the files took.
    pub read: f64,
    /// Seconds that expanding all flags took, where asked for.
    pub flags: Option<f64>,
    /// Seconds that hashing the flags took.
    pub hash: Option<f64>,
    /// Seconds that writing the files took.
    pub write: Option<f64>,
    /// SHA-256 of the flags.
    pub flags_sha256: Option<String>,
    /// Most bytes that the process has held.
    pub host_bytes: Option<u64>,
}

impl CallerFacts {
    /// Says how many seconds reading the files took.
    pub fn with_read(self, read: f64) -> CallerFacts {
        CallerFacts { read, ..self }
    }

    /// Says how many seconds expanding all flags took.
    pub fn with_flags(self, flags: Option<f64>) -> CallerFacts {
        CallerFacts { flags, ..self }
    }

    /// Says how many seconds hashing the flags took.
    pub fn with_hash(self, hash: Option<f64>) -> CallerFacts {
        CallerFacts { hash, ..self }
    }

    /// Says how many seconds writing the files took.
    pub fn with_write(self, write: Option<f64>) -> CallerFacts {
        CallerFacts { write, ..self }
    }

    /// Hands over the SHA-256 of the flags.
    pub fn with_flags_sha256(self, flags_sha256: Option<String>) -> CallerFacts {
        CallerFacts { flags_sha256, ..self }
    }

    /// Says how many bytes the process has held at most.
    pub fn with_host_bytes(self, host_bytes: Option<u64>) -> CallerFacts {
        CallerFacts { host_bytes, ..self }
    }
}

/// Everything about a mesh but its cells. Lengths are in the unit of the files, volumes in its cube, times in seconds, sizes in bytes; what
/// has three numbers has them for x, y and z.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Report {
    /// What was known once the columns were made.
    #[serde(flatten)]
    pub mesh: MeshFacts,
    /// SHA-256 of the flags of all cells, x fastest, one byte each; null where it was not asked for (`--hash sha256`).
    pub flags_sha256: Option<String>,
    /// Cells per second of `seconds.total`.
    pub cells_per_second: f64,
    /// Memory.
    pub peak_bytes: PeakBytes,
    /// Times.
    pub seconds: Seconds,
}

impl Report {
    /// Joins what is known of a mesh and of what its caller did.
    pub fn new(mesh: MeshFacts, caller: CallerFacts) -> Report {
        let CallerFacts { read, flags, hash, write, flags_sha256, host_bytes } = caller;
        let Seconds { lines, snap, columns, .. } = mesh.seconds;
        let total = read + lines + snap + columns + flags.unwrap_or(0.0);
        Report {
            flags_sha256,
            cells_per_second: mesh.cells as f64 / total.max(1e-9),
            peak_bytes: PeakBytes { host: host_bytes, ..mesh.peak_bytes },
            seconds: Seconds { total, read, flags, hash, write, ..mesh.seconds },
            mesh,
        }
    }

    /// Writes the report as JSON.
    pub fn to_json(&self) -> String {
        // a struct of numbers, strings and lists always has a JSON form
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests;
