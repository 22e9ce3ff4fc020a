//! The effective job: the job with all that it left open filled in.

use super::prepare::Prepared;
use hexcast_core::derived::certificate::DEFAULT_THIN_CELLS;
use hexcast_core::derived::gaps::Gaps;
use hexcast_core::input::job::{AxisChoice, DEFAULT_CELLS, DEFAULT_GROWTH, DEFAULT_TOLERANCE, HaloEdge, Job};
use hexcast_core::set;

/// Fills in what a job left to defaults; `n_solids` has the number of solids of each file.
///
/// What chooses the cells stays as it is: the numbers of the lines would be rounded again.
pub(super) fn effective(job: &Job, prepared: &Prepared, n_solids: &[usize], gaps: Option<&Gaps>) -> Job {
    let mut job = set!(Job { max_memory: None, unit: prepared.unit.clone(), ..job.clone() });
    let is_sized = job.dims.is_some() || job.cell_size.is_some() || job.max_cell_size.is_some();
    if job.cells.is_none() && !is_sized && job.lines.is_none() && job.graded.is_none() {
        job.cells = Some(DEFAULT_CELLS);
    }
    if job.max_cell_size.is_some() {
        job.tolerance = job.tolerance.or(Some(DEFAULT_TOLERANCE));
    }
    if let Some(graded) = &mut job.graded {
        graded.growth = graded.growth.or(Some(DEFAULT_GROWTH));
    }
    if job.certify {
        job.thin_cells = job.thin_cells.or(Some(DEFAULT_THIN_CELLS));
    }
    if job.halo.is_some() {
        job.halo_edge = job.halo_edge.or(Some(HaloEdge::default()));
    }
    job.gap_flag = gaps.map(|gaps| gaps.flag);
    job.axis = [AxisChoice::X, AxisChoice::Y, AxisChoice::Z][prepared.rays.axis];
    let (split, invert) = (std::mem::take(&mut job.split), std::mem::take(&mut job.invert));
    let mut first = 0;
    for (entry, n_solids) in job.geometries.iter_mut().zip(n_solids) {
        if let Some(geometry) = prepared.geometries.get(first) {
            entry.flag = Some(geometry.flag);
            (entry.open, entry.fill) = (Some(geometry.open), Some(geometry.fill));
            (entry.split, entry.invert) = (entry.split || split, entry.invert || invert);
            entry.name = (!entry.split).then(|| geometry.name.clone());
        }
        first += if entry.split { *n_solids } else { 1 };
    }
    job
}
