//! The cut: which facets the rays of the mesh decide, which are decided apart, and of a window those near it.

use super::backend::Whole;
use super::prepare::Task;
use super::surfaces::Surfaces;
use super::warnings;
use crate::meshing::report::ShellsReport;
use hexcast_core::base::error::Result;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::open_surfaces::overlay::{self, Part};
use hexcast_core::stages::cast::Cast;

/// The facets of a job, as they are cast.
pub(super) struct Cut {
    /// Those whose rays decide, of the whole box, or near its window.
    pub(super) frame: Frame,
    /// What is decided apart, in the cells that are meshed.
    pub(super) parts: Vec<Part>,
    /// What a window was cut from, where the cells beside it are looked at, too.
    pub(super) uncut: Option<(Vec<Part>, Frame)>,
    /// Flag of each rank.
    pub(super) flags: Vec<u8>,
    /// Shells that overlap in a window.
    shells: Option<Vec<ShellsReport>>,
    /// How far volumes can be off, by geometry.
    pub(super) bounds: Vec<Option<f64>>,
    /// The same in the whole box, of a part, whose report is merged with others.
    pub(super) bounds_of_whole: Option<Vec<Option<f64>>>,
}

impl Cut {
    /// Takes from a frame what is not decided by the rays of the mesh.
    ///
    /// # Errors
    /// Those of [`overlay::split`]; `cancelled`.
    pub(super) async fn new(task: &Task<'_>, frame: Frame, surfaces: &mut Surfaces) -> Result<Cut> {
        let &Task { job, prepared, control, .. } = task;
        let (whole, geometries, is_for_window) = (&prepared.whole, &prepared.geometries[..], prepared.window.is_some());
        let flags = frame.ranks.flag_of_rank.clone();
        let how = (job.rule, is_for_window);
        let (frame, parts) = overlay::split(frame, &surfaces.closed, how, (whole, geometries), control).await?;
        if !parts.is_empty() {
            let apart = (0..surfaces.ends.len()).filter(|&position| frame.range_at(position).is_empty());
            apart.for_each(|position| surfaces.ends[position] = None);
        }
        let bounds = surfaces.volume_bounds(&frame, geometries, &prepared.lines);
        let bounds_of_whole = job.part.map(|_| surfaces.volume_bounds(&frame, geometries, whole));
        let cut = Cut { frame, parts, uncut: None, flags, shells: None, bounds, bounds_of_whole };
        if is_for_window { cut.near_window(task, surfaces).await } else { Ok(cut) }
    }

    /// Takes what is far from the window.
    async fn near_window(mut self, task: &Task<'_>, surfaces: &Surfaces) -> Result<Cut> {
        let &Task { job, prepared, control, .. } = task;
        self.shells = Some(self.shells(task, surfaces));
        control.rest().await?;
        let cells = prepared.cast_cells();
        let near = self.parts.iter().map(|part| part.window(cells, &self.frame)).collect();
        let near_frame = self.frame.window(cells);
        let uncut = (std::mem::replace(&mut self.parts, near), std::mem::replace(&mut self.frame, near_frame));
        let is_asked = job.certify || job.part.is_some() || job.links.is_some() || !job.conductors.is_empty();
        self.uncut = (is_asked || surfaces.plates.is_some()).then_some(uncut);
        Ok(self)
    }

    /// Bytes of what is decided apart.
    pub(super) fn parts_bytes(&self, task: &Task<'_>) -> u64 {
        self.parts.iter().map(|part| part.n_bytes(&task.prepared.rays, &self.frame)).sum()
    }

    /// The frame of the whole box where it was kept; else that which is cast.
    pub(super) fn frame_of_whole(&self) -> &Frame {
        self.uncut.as_ref().map_or(&self.frame, |(_, frame)| frame)
    }

    /// What the cells beside a window are meshed from.
    pub(super) fn whole<'a>(&'a self, task: &'a Task<'_>) -> Whole<'a> {
        let parts = self.uncut.as_ref().map_or(&[][..], |(parts, _)| parts);
        let (frame, lines) = (self.frame_of_whole(), &task.prepared.whole);
        Whole { frame, parts, flags: &self.flags, lines, rule: task.job.rule }
    }

    /// Shells that overlap in the cells that are meshed.
    pub(super) fn shells(&self, task: &Task<'_>, surfaces: &Surfaces) -> Vec<ShellsReport> {
        self.shells.clone().unwrap_or_else(|| {
            let prepared = task.prepared;
            let rays = Rays::new(prepared.rays.axis, prepared.whole.dims());
            let cast = Cast { frame: &self.frame, rays: &rays, rule: task.job.rule };
            let agrees = |position: usize| surfaces.closed[position].nonzero;
            warnings::shells(&cast, &agrees, prepared.cast_cells())
        })
    }
}
