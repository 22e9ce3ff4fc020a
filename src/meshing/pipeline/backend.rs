//! The backend with its limits: casts the facets of a frame, and puts what is decided apart over their columns.

use super::engine::{Engine, Used};
use crate::meshing::estimate::MemoryBudget;
use crate::meshing::report::MAX_BOXES;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::{Columns, ColumnsBuilder};
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Rule;
use hexcast_core::open_surfaces::doubt::Doubt;
use hexcast_core::open_surfaces::overlay::{Overlay, Part};
use hexcast_core::stages::cast::Cast;

/// What casts, and what it may take.
pub(super) struct Backend<'a> {
    pub(super) engine: &'a mut Engine,
    pub(super) budget: &'a MemoryBudget,
    pub(super) control: &'a Control,
}

impl Backend<'_> {
    /// The same with another control.
    pub(super) fn with_control<'b>(&'b mut self, control: &'b Control) -> Backend<'b> {
        Backend { engine: self.engine, budget: self.budget, control }
    }

    /// The columns of a frame and of what is decided apart from it, of at most so many bytes.
    ///
    /// # Errors
    /// Those of [`Engine::columns`].
    pub(super) async fn columns(
        &mut self,
        cast: &Cast<'_>,
        parts: Vec<Part>,
        decided: (&[u8], &Lines, Doubt),
        max_bytes: u64,
    ) -> Result<Columns> {
        let (mut overlay, _) = overlay(parts, cast, decided, self).await?;
        let mut builder = ColumnsBuilder::new(*cast.rays, max_bytes, None);
        self.engine.build(cast, self.budget, &mut builder, &mut overlay, self.control).await?;
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
    backend: &mut Backend<'_>,
) -> Result<(Option<Overlay>, Used)> {
    let Backend { engine, budget, control } = backend;
    let (mut decided, mut used) = (Vec::with_capacity(parts.len()), Used::default());
    for part in parts {
        let (crossings, more) = engine.axis_crossings(&part.casts(cast), cast.rays, budget.bands, control).await?;
        let shifts = part.shifts(cast.frame, lines, control).await?;
        decided.push((part, crossings, shifts));
        used = used.and(more);
    }
    Ok((Overlay::new(decided, cast, flags, doubt), used))
}

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
    /// The columns of some cells with rays along an axis, of at most so many bytes.
    ///
    /// # Errors
    /// Those of [`Engine::columns`].
    pub(super) async fn columns(
        &self,
        (cells, along): ([[u32; 3]; 2], usize),
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Columns> {
        let (frame, control) = (self.frame.window(cells), backend.control.without_progress());
        let mut backend = backend.with_control(&control);
        let rays = Rays::new(along, frame.dims);
        let cast = Cast { frame: &frame, rays: &rays, rule: self.rule };
        let parts = self.parts.iter().map(|part| part.window(cells, self.frame)).collect();
        let doubt = Doubt::new(rays, MAX_BOXES, None);
        let lines = self.lines.window(cells);
        backend.columns(&cast, parts, (self.flags, &lines, doubt), max_bytes).await
    }
}
