//! The cells: all rays are cast, and become columns.

use super::backend::{Backend, overlay};
use super::cut::Cut;
use super::engine::Used;
use super::memory_budget::columns_builder;
use super::prepare::{Prepared, Task};
use crate::meshing::report::MAX_BOXES;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Columns;
use hexcast_core::input::job::Job;
use hexcast_core::open_surfaces::doubt::Doubt;
use hexcast_core::open_surfaces::overlay::Overlay;
use hexcast_core::stages::cast::Cast;
use hexcast_derived::gaps::{self, Gaps};

/// The columns of the cells that are cast, and what they took.
pub(super) struct Meshed {
    pub(super) columns: Columns,
    /// What was closed in them.
    pub(super) gaps: Option<Gaps>,
    /// What was decided apart, where something was.
    pub(super) overlay: Option<Overlay>,
    /// Cells that no rays decided, where nothing was decided apart.
    pub(super) no_doubt: Doubt,
    pub(super) used: Used,
    /// Rays that an interrupted run left.
    pub(super) rays_kept: u64,
    /// Bytes of what was decided apart.
    pub(super) overlay_bytes: u64,
    /// Most bytes of the columns.
    pub(super) columns_peak: u64,
    /// What is left of the memory for columns.
    pub(super) bytes_left: u64,
}

impl Meshed {
    /// Casts all rays; what is decided apart is put over the columns.
    ///
    /// # Errors
    /// Those of [`Engine::columns`](super::Engine::columns), [`ColumnsBuilder::resume`](hexcast_core::cells::columns::ColumnsBuilder::resume) and
    /// [`gaps::close`].
    pub(super) async fn new(task: &Task<'_>, cut: &mut Cut, backend: &mut Backend<'_>) -> Result<Meshed> {
        let &Task { job, options, prepared, inputs, control, .. } = task;
        let budget = backend.budget;
        // half of it for the mask
        let columns_bytes = if options.doubt_mask { budget.columns / 2 } else { budget.columns };
        let mut builder = columns_builder(job, &options.spill, columns_bytes, prepared, (&prepared.names, inputs))?;
        let rays_kept = builder.n_rays();
        let cast = Cast { frame: &cut.frame, rays: &prepared.rays, rule: job.rule };
        let doubt = || Doubt::new(prepared.rays, MAX_BOXES, options.doubt_mask.then_some(columns_bytes));
        let decided = (&cut.flags[..], &prepared.lines, doubt());
        let (mut overlay, used) = overlay(std::mem::take(&mut cut.parts), &cast, decided, backend).await?;
        overlay.iter_mut().try_for_each(|overlay| overlay.pass(rays_kept))?;
        let overlay_bytes = overlay.as_ref().map_or(0, Overlay::n_bytes);
        let used = used.and(backend.engine.build(&cast, budget, &mut builder, &mut overlay, control).await?);
        let columns_peak = builder.peak_bytes;
        let mut columns = builder.finish()?;
        let gaps = close_gaps(job, prepared, &mut columns, budget.columns, control)?;
        let bytes_left = budget.columns.saturating_sub(columns_peak);
        let no_doubt = doubt();
        Ok(Meshed { columns, gaps, overlay, no_doubt, used, rays_kept, overlay_bytes, columns_peak, bytes_left })
    }
}

/// Closes gaps in columns, if the job asks for it.
fn close_gaps(
    job: &Job,
    prepared: &Prepared,
    columns: &mut Columns,
    max_bytes: u64,
    control: &Control,
) -> Result<Option<Gaps>> {
    let Some(width) = job.close_gaps else { return Ok(None) };
    let greatest = prepared.geometries.iter().map(|geometry| geometry.flag).max().unwrap_or(0);
    let Some(flag) = job.gap_flag.or_else(|| greatest.checked_add(1)) else {
        let message = "a geometry has flag 255, so that none follows for the closed gaps";
        return Err(Error::new("job-value", message, "give gap_flag (--gap-flag), which may be that of a geometry"));
    };
    let (closed, gaps) = gaps::close(columns, &prepared.lines, (width, flag), max_bytes, control)?;
    *columns = closed;
    Ok(Some(gaps))
}
