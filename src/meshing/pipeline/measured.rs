//! What is measured at surfaces once the flags are known: links from cells to surfaces, the fractions of cells, points of a staggered grid, edges and faces outside metal, smoothed permittivity, distances, and cells cut at a surface.

use super::backend::Backend;
use super::cut::Cut;
use super::meshed::Meshed;
use super::prepare::{Prepared, Task};
use super::surfaces::Uncut;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Columns;
use hexcast_core::input::job::Job;
use hexcast_core::stages::inside::Kind;
use hexcast_derived::cut_cells::conformal::Conformal;
use hexcast_derived::cut_cells::tensors::Tensors;
use hexcast_derived::cut_cells::{CutBy, exact_fractions};
use hexcast_derived::distance::Distance;
use hexcast_derived::fractions::{Fractions, fractions};
use hexcast_derived::links::{Field, Links};
use hexcast_derived::mesh::outline::Outline;
use hexcast_derived::staggered::Staggered;

/// What a job asks for beside the cells.
#[derive(Default)]
pub(super) struct Measured {
    pub(super) links: Option<Links>,
    pub(super) fractions: Option<Fractions>,
    pub(super) staggered: Option<Staggered>,
    pub(super) conformal: Option<Conformal>,
    pub(super) distance: Option<Distance>,
    pub(super) tensors: Option<Tensors>,
    pub(super) outline: Option<Outline>,
}

impl Measured {
    /// Measures all that a job asks for, at facets from which nothing was taken: each is held with those before it.
    ///
    /// # Errors
    /// Those of [`Uncut::links`], [`Uncut::fractions`], [`Uncut::staggered`], [`Uncut::conformal`], [`Uncut::tensors`] and [`Uncut::distance`].
    pub(super) async fn new(
        task: &Task<'_>,
        uncut: Option<&Uncut>,
        (cut, meshed): (&Cut, &Meshed),
        backend: &mut Backend<'_>,
    ) -> Result<Measured> {
        let Some(uncut) = uncut else { return Ok(Measured::default()) };
        let mut bytes_left = meshed.bytes_left;
        let links = uncut.links(task, (cut, meshed), bytes_left, backend).await?;
        bytes_left = bytes_left.saturating_sub(links.as_ref().map_or(0, Links::n_bytes));
        let fractions = uncut.fractions(task.job, task.prepared, bytes_left, task.control).await?;
        bytes_left = bytes_left.saturating_sub(fractions.as_ref().map_or(0, Fractions::n_bytes));
        let staggered = uncut.staggered(task, (cut, meshed), bytes_left, backend).await?;
        let conformal = uncut.conformal(task, bytes_left, backend).await?;
        let tensors = uncut.tensors(task, bytes_left, backend).await?;
        // those before it are counted by no number of their own
        let distance = uncut.distance(task, bytes_left, backend).await?;
        let outline = uncut.outline(task, bytes_left).await?;
        Ok(Measured { links, fractions, staggered, conformal, tensors, distance, outline })
    }
}

impl Uncut {
    /// The links that a job asks for, of at most so many bytes with what finding them takes. Where rays do not decide all flags, and the
    /// columns are those of a window alone, the window is meshed once more with its neighbours.
    pub(super) async fn links(
        &self,
        task: &Task<'_>,
        (cut, meshed): (&Cut, &Meshed),
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Option<Links>> {
        let &Task { job, prepared, control, .. } = task;
        let Some(links) = job.links.as_ref() else { return Ok(None) };
        let (window, dims) = (prepared.cell_window(), prepared.whole.dims());
        // this frame, one that is sheared, and that of a window, with indices
        let periodic = job.periodic_axes();
        let n_frames = 3 + u64::from(periodic.contains(&true));
        let max_bytes = max_bytes.saturating_sub((n_frames * 38 + 4) * self.frame.facets.len() as u64);
        let is_plain = job.close_gaps.is_none() && !self.kinds.contains(&Kind::Apart);
        let ([first, end], columns) = (prepared.cast_cells(), &meshed.columns);
        let near = window.with_neighbours(dims);
        let lacks_some = (0..3).any(|axis| near[0][axis] < first[axis] || near[1][axis] > end[axis]);
        let with_neighbours = match !is_plain && lacks_some {
            true => Some(cut.whole(task).columns((near, columns.rays().axis), max_bytes, backend).await?),
            false => None,
        };
        let max_bytes = max_bytes.saturating_sub(with_neighbours.as_ref().map_or(0, Columns::n_bytes));
        let (columns, first) = with_neighbours.as_ref().map_or((columns, first), |columns| (columns, near[0]));
        let (frame, kinds) = (&self.frame, &self.kinds);
        let field = Field { frame, rule: job.rule, kinds, columns, first, window, is_plain, periodic };
        field.links(links, max_bytes, control).await.map(Some)
    }

    /// What cuts the cells of the whole box.
    pub(super) fn cut_by<'a>(&'a self, job: &Job, prepared: &'a Prepared, is_oriented: &'a [bool]) -> CutBy<'a> {
        CutBy { frame: &self.frame, lines: &prepared.whole, rule: job.rule, kinds: &self.kinds, is_oriented }
    }

    /// The fractions of cells that a job asks for, of at most so many bytes.
    pub(super) async fn fractions(
        &self,
        job: &Job,
        prepared: &Prepared,
        max_bytes: u64,
        control: &Control,
    ) -> Result<Option<Fractions>> {
        let Some(asked) = job.fractions else { return Ok(None) };
        let Some(rays) = asked.by_rays() else {
            // this frame, and the facets by planes
            let max_bytes = max_bytes.saturating_sub(2 * 38 * self.frame.facets.len() as u64);
            let is_oriented = self.are_oriented();
            let by = self.cut_by(job, prepared, &is_oriented);
            return exact_fractions(by, prepared.cell_window(), asked, max_bytes, control).await.map(Some);
        };
        // this frame, one of finer cells and what it is made of, those of faces, and the facets by rows
        let frames = 3 + 3 * u64::from(asked.faces) + u64::from(asked.surfaces);
        let max_bytes = max_bytes.saturating_sub(frames * 38 * self.frame.facets.len() as u64);
        let (of_box, window) = ((&self.frame, &prepared.whole), prepared.cell_window());
        fractions(of_box, window, (job.rule, &self.kinds), (asked, rays), max_bytes, control).await.map(Some)
    }
}
