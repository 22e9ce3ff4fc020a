//! Meshes the cells beside a window that its report needs: slabs of the box, two or three cells thick, meshed by themselves.
//!
//! A gap at the border of a window has its neighbours on both sides, one of them beyond it; and a run begins at the first cell of a window
//! only if the cell before it has another flag. The rays of a slab lie in it, whatever the axis of the mesh, so that it has few.
//!
//! Cost: a slab takes two or three rows of rays.

use std::collections::BTreeSet;

use super::engine::{Engine, Used};
use crate::meshing::estimate::MemoryBudget;
use crate::meshing::report::MAX_BOXES;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::{Columns, ColumnsBuilder, spans};
use hexcast_core::derived::certificate::FlagGaps;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Rule;
use hexcast_core::open_surfaces::doubt::Doubt;
use hexcast_core::open_surfaces::overlay::{Overlay, Part};
use hexcast_core::stages::cast::Cast;

/// A backend, and what it may take.
pub(super) type Backend<'a> = (&'a mut Engine, &'a MemoryBudget, &'a Control);

/// What is left of the memory that columns may take, and the backend.
pub(super) type Left<'a> = (u64, Backend<'a>);

/// The whole box before it was cut to a window.
pub(super) struct Whole<'a> {
    /// The facets whose rays decide.
    pub(super) frame: &'a Frame,
    /// What is decided apart.
    pub(super) parts: &'a [Part],
    /// Flag of each rank.
    pub(super) flags: &'a [u8],
    pub(super) lines: &'a Lines,
    pub(super) rule: Rule,
}

impl Whole<'_> {
    /// The gaps in some cells of the box, whose columns are given.
    ///
    /// # Errors
    /// Those of [`Engine::columns`], and of reading spilled columns.
    pub(super) async fn gaps(
        &self,
        columns: &Columns,
        [first, end]: [[u32; 3]; 2],
        (engine, budget, control): Backend<'_>,
    ) -> Result<FlagGaps> {
        let mut gaps = FlagGaps::default();
        gaps.add(columns, first, &[0, 1, 2])?;
        for axis in 0..3 {
            for cell in BTreeSet::from([first[axis], end[axis] - 1]) {
                let is_between = cell > 0 && cell + 1 < self.lines.dims()[axis];
                let is_inside = cell > first[axis] && cell + 1 < end[axis];
                if is_between && !is_inside {
                    let slab = [with(first, axis, cell - 1), with(end, axis, cell + 2)];
                    let columns = self.slab(slab, axis, (engine, budget, control)).await?;
                    gaps.add(&columns, slab[0], &[axis])?;
                }
            }
        }
        Ok(gaps)
    }

    /// How many runs of the box begin in some cells of it, whose columns are given.
    ///
    /// # Errors
    /// Those of [`Engine::columns`].
    pub(super) async fn runs(
        &self,
        columns: &Columns,
        [first, end]: [[u32; 3]; 2],
        backend: Backend<'_>,
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
    async fn slab(&self, cells: [[u32; 3]; 2], axis: usize, backend: Backend<'_>) -> Result<Columns> {
        let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
        let n_cells = |axis: usize| cells[1][axis] - cells[0][axis];
        let (along, max_bytes) = (if n_cells(one) >= n_cells(other) { one } else { other }, backend.1.columns);
        self.columns((cells, along), max_bytes, backend).await
    }

    /// The columns of some cells with rays along an axis, of at most so many bytes.
    ///
    /// # Errors
    /// Those of [`Engine::columns`].
    pub(super) async fn columns(
        &self,
        (cells, along): ([[u32; 3]; 2], usize),
        max_bytes: u64,
        (engine, budget, control): Backend<'_>,
    ) -> Result<Columns> {
        let (frame, control) = (self.frame.window(cells), control.without_progress());
        let rays = Rays::new(along, frame.dims);
        let cast = Cast { frame: &frame, rays: &rays, rule: self.rule };
        let parts = self.parts.iter().map(|part| part.window(cells, self.frame)).collect();
        let doubt = Doubt::new(rays, MAX_BOXES, None);
        let lines = self.lines.window(cells);
        let (mut overlay, _) = overlay(parts, &cast, (self.flags, &lines, doubt), (engine, budget, &control)).await?;
        let mut builder = ColumnsBuilder::new(rays, max_bytes, None);
        engine.build(&cast, budget, &mut builder, &mut overlay, &control).await?;
        builder.finish()
    }
}

/// Casts the rays that decide parts, and puts these over what follows, if there are any.
///
/// # Errors
/// Those of [`Engine::columns`].
pub(super) async fn overlay(
    parts: Vec<Part>,
    cast: &Cast<'_>,
    (flags, lines, doubt): (&[u8], &Lines, Doubt),
    (engine, budget, control): Backend<'_>,
) -> Result<(Option<Overlay>, Used)> {
    let (mut decided, mut used) = (Vec::with_capacity(parts.len()), Used::default());
    for part in parts {
        let (crossings, more) = engine.axis_crossings(&part.casts(cast), cast.rays, budget.bands, control).await?;
        let shifts = part.shifts(cast.frame, lines, control).await?;
        decided.push((part, crossings, shifts));
        used = used.and(more);
    }
    Ok((Overlay::new(decided, cast, flags, doubt), used))
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
