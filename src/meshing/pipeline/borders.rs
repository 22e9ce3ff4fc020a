//! Meshes the cells beside a window that its report needs: slabs of the box, two or three cells thick, meshed by themselves.
//!
//! A gap at the border of a window has its neighbours on both sides, one of them beyond it; and a run begins at the first cell of a window
//! only if the cell before it has another flag. The rays of a slab lie in it, whatever the axis of the mesh, so that it has few.
//!
//! Cost: a slab takes two or three rows of rays.

use std::collections::BTreeSet;

use super::backend::{Backend, Whole};
use super::cut::Cut;
use super::halo::Beyond;
use super::meshed::Meshed;
use super::prepare::Task;
use super::surfaces::Surfaces;
use hexcast_core::base::error::Result;
use hexcast_core::base::finding::Finding;
use hexcast_core::cells::columns::{Columns, spans};
use hexcast_derived::certificate::FlagGaps;
use hexcast_derived::staggered::SheetFace;
use hexcast_derived::walls::Walls;

/// What is known of the cells beside those that were cast, and of faces.
#[derive(Default)]
pub(super) struct Borders {
    /// Runs of the box that begin in the cells, where a merged report needs them.
    pub(super) runs: Option<u64>,
    /// Thin walls and gaps, if the job asks for a certificate.
    pub(super) gaps: Option<FlagGaps>,
    /// Faces of geometries without thickness.
    pub(super) plates: Vec<SheetFace>,
    /// What covers some of these.
    pub(super) covered: Vec<Finding>,
    /// Faces that have the names of solids, if they shall.
    pub(super) walls: Option<Walls>,
}

impl Borders {
    /// Meshes what is needed beside the cells; what the snap found of plates and walls is taken.
    ///
    /// # Errors
    /// Those of [`Whole::columns`] and of reading spilled columns.
    pub(super) async fn new(
        task: &Task<'_>,
        surfaces: &mut Surfaces,
        (cut, meshed): (&Cut, &Meshed),
        backend: &mut Backend<'_>,
    ) -> Result<Borders> {
        let &Task { job, prepared, .. } = task;
        let (whole, cells, columns, beyond) =
            (cut.whole(task), prepared.cast_cells(), &meshed.columns, Beyond::new(prepared));
        let mut borders = Borders::default();
        if prepared.halo == 0 && (job.part.is_some() || cells[0][columns.rays().axis] == 0) {
            borders.runs = Some(whole.runs(columns, cells, backend).await?);
        }
        if job.certify {
            borders.gaps = Some(whole.gaps(columns, cells, backend).await?);
        }
        if let Some(plates) = surfaces.plates.take() {
            let near = [
                cells[0].map(|cell| cell.saturating_sub(1)),
                [0, 1, 2].map(|axis| (cells[1][axis] + 1).min(whole.lines.dims()[axis])),
            ];
            let with_neighbours = match near == cells {
                true => None,
                false => Some(whole.columns((near, columns.rays().axis), meshed.bytes_left, backend).await?),
            };
            let around = (with_neighbours.as_ref().unwrap_or(columns), near[0]);
            (borders.plates, borders.covered) = plates.uncovered(around, prepared, &beyond)?;
        }
        let walls = surfaces.walls.take();
        borders.walls = walls.map(|walls| walls.walls(columns, |face| beyond.moved(face))).transpose()?;
        Ok(borders)
    }
}

impl Whole<'_> {
    /// The gaps in some cells of the box, whose columns are given.
    ///
    /// # Errors
    /// Those of [`Whole::columns`], and of reading spilled columns.
    pub(super) async fn gaps(
        &self,
        columns: &Columns,
        [first, end]: [[u32; 3]; 2],
        backend: &mut Backend<'_>,
    ) -> Result<FlagGaps> {
        let mut gaps = FlagGaps::default();
        gaps.add(columns, first, &[0, 1, 2])?;
        for axis in 0..3 {
            for cell in BTreeSet::from([first[axis], end[axis] - 1]) {
                let is_between = cell > 0 && cell + 1 < self.lines.dims()[axis];
                let is_inside = cell > first[axis] && cell + 1 < end[axis];
                if is_between && !is_inside {
                    let slab = [with(first, axis, cell - 1), with(end, axis, cell + 2)];
                    let columns = self.slab(slab, axis, backend).await?;
                    gaps.add(&columns, slab[0], &[axis])?;
                }
            }
        }
        Ok(gaps)
    }

    /// How many runs of the box begin in some cells of it, whose columns are given.
    ///
    /// # Errors
    /// Those of [`Whole::columns`].
    pub(super) async fn runs(
        &self,
        columns: &Columns,
        [first, end]: [[u32; 3]; 2],
        backend: &mut Backend<'_>,
    ) -> Result<u64> {
        let axis = columns.rays().axis;
        let border = first[axis];
        if border == 0 {
            return Ok(columns.n_runs());
        }
        let cells = [with(first, axis, border - 1), with(end, axis, border + 1)];
        let [differing, flagged] = compared(&self.slab(cells, axis, backend).await?, axis)?;
        // the columns have a run at every flagged cell of their first plane
        Ok(columns.n_runs() + differing - flagged)
    }

    /// The columns of a slab across an axis.
    async fn slab(&self, cells: [[u32; 3]; 2], axis: usize, backend: &mut Backend<'_>) -> Result<Columns> {
        let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
        let n_cells = |axis: usize| cells[1][axis] - cells[0][axis];
        let (along, max_bytes) = (if n_cells(one) >= n_cells(other) { one } else { other }, backend.budget.columns);
        self.columns((cells, along), max_bytes, backend).await
    }
}

/// A cell with another index along an axis.
fn with(mut cell: [u32; 3], axis: usize, index: u32) -> [u32; 3] {
    cell[axis] = index;
    cell
}

/// Of two planes of cells: how many cells of the second differ from those of the first, and how many of the second are flagged.
fn compared(slab: &Columns, axis: usize) -> Result<[u64; 2]> {
    let rays = slab.rays();
    let (mut all, n_across) = (Vec::new(), rays.counts[0] as usize);
    slab.for_rays(0..rays.n_rays(), |runs| all.push(runs.to_vec()))?;
    let (step, distance) = if rays.across[0] == axis { (2, 1) } else { (1, n_across) };
    let (mut differing, mut flagged) = (0, 0);
    for (before, behind) in all.iter().step_by(step).zip(all[distance..].iter().step_by(step)) {
        spans(behind, &(0..rays.depth), |start, end, flag| {
            flagged += if flag == 0 { 0 } else { u64::from(end - start) };
            spans(before, &(start..end), |start, end, other| {
                differing += if flag == other { 0 } else { u64::from(end - start) };
            });
        });
    }
    Ok([differing, flagged])
}
