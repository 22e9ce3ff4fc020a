//! The backends under test: one function meshes a case on any of them.

use hexcast::columns::Columns;
use hexcast::control::Control;
use hexcast_core::cells::flags::flags_of_box;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::crossings::crossings;
use hexcast_core::stages::lattice::{Lattice, lattice};
use hexcast_core::stages::map::{Mapping, Rule, map};

use super::cases::Case;

/// A way to mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Backend {
    /// The definition, strips of its own choice.
    Cpu,
    /// The definition in strips of so many ray rows.
    CpuInStrips(u32),
    /// The definition's stages over bins of so many rays, one bin row after another.
    CpuInBins([u32; 2]),
}

impl Backend {
    /// How many facets it projects, where a facet counts for each bin row.
    pub(crate) fn n_projected(self, case: &Case, axis: usize) -> u64 {
        let n_rows = match self {
            Backend::CpuInBins(bin) => Lattice::n_rows(&Rays::new(axis, case.lines.dims()), bin),
            _ => 1,
        };
        u64::from(n_rows) * case.n_facets() as u64
    }
}

/// Every backend that must give the same bytes.
pub(crate) const BACKENDS: &[Backend] = &[
    Backend::Cpu,
    Backend::CpuInStrips(1),
    Backend::CpuInStrips(3),
    Backend::CpuInBins([1, 1]),
    Backend::CpuInBins([4, 3]),
    Backend::CpuInBins([16, 16]),
];

/// Meshes a case with rays along an axis.
pub(crate) fn mesh(backend: Backend, case: &Case, axis: usize) -> Columns {
    let frame = Frame::new(&case.geometries, &case.lines).unwrap_or_else(|error| panic!("{}: {error}", case.name));
    let rays = Rays::new(axis, case.lines.dims());
    let control = Control::default();
    let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
    let columns = match backend {
        Backend::Cpu => cpu::columns(&cast, &control),
        Backend::CpuInStrips(rows) => cpu::columns_in_strips(&cast, rows, &control),
        Backend::CpuInBins(bin) => Ok(columns_in_bins(&frame, &rays, case.rule, bin)),
    };
    columns.unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

/// Builds a lattice of its own for every bin row, as a device does with a band.
fn columns_in_bins(frame: &Frame, rays: &Rays, rule: Rule, bin: [u32; 2]) -> Columns {
    let mapping = Mapping { rule, flag_of_rank: &frame.ranks.flag_of_rank, depth: rays.depth };
    let band = |row| map(&crossings(frame, rays, &lattice(frame, rays, bin, row..row + 1), row, false), &mapping);
    Columns::new(*rays, (0..Lattice::n_rows(rays, bin)).map(band).collect()).unwrap()
}

/// Flags of all cells, x fastest.
pub(crate) fn flags(columns: &Columns) -> Vec<u8> {
    flags_of_box(columns, &columns.dims().map(|n| 0..n)).expect("columns in memory")
}

/// Flags of a case from the CPU with rays along an axis.
pub(crate) fn cpu_flags(case: &Case, axis: usize) -> Vec<u8> {
    flags(&mesh(Backend::Cpu, case, axis))
}
