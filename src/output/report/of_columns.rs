//! The report of a mesh that was read back: what a column file says.

use serde::Serialize;

use crate::cells::volumes::Volumes;
use crate::derived::mesh::Mesh;
use crate::grid::lines::Grading;

/// A report of what the file holds; null where [`super::Report`] has what only the meshing knew.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct ColumnsReport<'a> {
    /// Version of hexcast that reads it.
    pub version: &'a str,
    backend: (),
    adapter: (),
    driver: (),
    fallback: (),
    device_check: (),
    /// Unit of lengths, if the file names one.
    pub unit: Option<&'a str>,
    /// Number of cells on x, y and z.
    pub dims: [u32; 3],
    window: (),
    /// First mesh line on each axis.
    pub origin: [f64; 3],
    /// Cell size on each axis; null where cells differ in size.
    pub spacing: Option<[f64; 3]>,
    /// The lines and how their distances change; null where all cells are equal.
    pub grading: Option<Grading>,
    rule: (),
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
    open: (),
    filled: (),
    gaps: (),
    links: (),
    fractions: (),
    staggered: (),
    /// Number of cells.
    pub cells: u64,
    /// Every flag in use.
    pub flags: Vec<ColumnsFlag<'a>>,
    certificate: (),
    doubtful: (),
    flags_hash: (),
    flags_sha256: (),
    job: (),
    findings: [(); 0],
    warnings: [(); 0],
    cells_per_second: (),
    seconds: NoSeconds,
}

#[derive(Debug, Serialize)]
struct NoSeconds {}

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
    mesh_volume: (),
    volume_bound: (),
}

impl ColumnsReport<'_> {
    /// Describes a mesh.
    pub fn new(mesh: &Mesh) -> ColumnsReport<'_> {
        let lines = &mesh.lines;
        let columns = &mesh.columns;
        ColumnsReport {
            version: env!("CARGO_PKG_VERSION"),
            backend: (),
            adapter: (),
            driver: (),
            fallback: (),
            device_check: (),
            unit: mesh.unit.as_deref(),
            dims: lines.dims(),
            window: (),
            origin: lines.origin(),
            spacing: lines.spacing(),
            grading: Grading::of(lines, mesh.unit.as_deref()),
            rule: (),
            ray_axis: ["x", "y", "z"][columns.rays.axis],
            rays: columns.rays.n_rays(),
            crossings: columns.n_crossings(),
            runs: columns.n_runs(),
            open: (),
            filled: (),
            gaps: (),
            links: (),
            fractions: (),
            staggered: (),
            odd_rays: columns.odd_rays(),
            cells: mesh.lines.n_cells(),
            flags: flags_of_columns(mesh),
            certificate: (),
            doubtful: (),
            flags_hash: (),
            flags_sha256: (),
            job: (),
            findings: [],
            warnings: [],
            cells_per_second: (),
            seconds: NoSeconds {},
        }
    }
}

fn flags_of_columns(mesh: &Mesh) -> Vec<ColumnsFlag<'_>> {
    let all_cells = mesh.columns.cells_per_flag();
    let volumes = Volumes::new(&mesh.columns, &mesh.lines, &mesh.lines).ok().map(|volumes| volumes.of_flags);
    let fact = |flag: u8| {
        let cells = all_cells[usize::from(flag)];
        let named = mesh.names.iter().find(|named| named.flag == flag);
        let volume = volumes.map(|volumes| volumes[usize::from(flag)]);
        let name = named.map_or("", |named| named.name.as_str());
        (cells > 0 || named.is_some()).then_some(ColumnsFlag {
            flag,
            name,
            cells,
            volume,
            mesh_volume: (),
            volume_bound: (),
        })
    };
    (1..=255).filter_map(fact).collect()
}
