//! Casts the points of a staggered grid: six boxes in the frame of the mesh, on its backend.

use super::backend::Backend;
use super::cut::Cut;
use super::meshed::Meshed;
use super::prepare::Task;
use super::surfaces::Uncut;
use crate::meshing::report::MAX_BOXES;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_core::open_surfaces::doubt::Doubt;
use hexcast_core::open_surfaces::overlay::split;
use hexcast_core::stages::cast::Cast;
use hexcast_derived::staggered::{COMPONENTS, Conductors, Staggered, check_dims};

impl Uncut {
    /// The flags of the staggered grid of a job.
    ///
    /// # Errors
    /// Those of [`check_dims`], [`split`] and [`crate::meshing::pipeline::Engine::columns`]; `memory` where columns would take more than there is.
    pub(super) async fn staggered(
        &self,
        task: &Task<'_>,
        (cut, meshed): (&Cut, &Meshed),
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Option<Staggered>> {
        let &Task { job, prepared, .. } = task;
        if !job.staggered {
            return Ok(None);
        }
        check_dims(self.frame.dims)?;
        let mut frame = self.frame.clone();
        let flags = std::mem::take(&mut frame.ranks.flag_of_rank);
        // codes, so that ranks are known where sheets meet insides
        frame.ranks.flag_of_rank = (1..=flags.len() as u8).collect();
        let geometry_at = |position: usize| &prepared.geometries[frame.ranks.geometry_at[position]];
        // inverted, a plane holds all points
        let is_flat = |position: usize| is_flat(&frame, position) && !geometry_at(position).invert;
        let is_flat: Vec<bool> = (0..prepared.geometries.len()).map(is_flat).collect();
        let sheets = frame.with_some(|position| geometry_at(position).fill != Fill::Centre || is_flat[position]);
        let frame = frame.with_some(|position| !geometry_at(position).shell && !is_flat[position]);
        // of these nothing but the inside counts; the others have no facets left
        let mut insides: Vec<Geometry> = prepared.geometries.to_vec();
        for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
            let is_gone = insides[index].shell || is_flat[position];
            (insides[index].fill, insides[index].shell) = (Fill::Centre, is_gone);
        }
        let (window, dims) = (prepared.cell_window(), self.frame.dims);
        // a face beside the window may have an edge in it
        let near = window.with_neighbours(dims);
        // this frame, its copy, the two made of that, and one that is cast
        let frames = 5 * 38 * self.frame.facets.len() as u64;
        let (mut codes, mut n_bytes) = (Vec::with_capacity(COMPONENTS.len()), frames);
        let control = &backend.control.without_progress();
        let mut backend = backend.with_control(control);
        for (_, is_moved) in COMPONENTS {
            let around = (frame.clone().around_faces(is_moved), points_of(near, is_moved));
            let left = max_bytes.saturating_sub(n_bytes);
            let columns = self.points(around, (task, &insides), left, &mut backend).await?;
            n_bytes += columns.n_bytes();
            codes.push(columns);
        }
        let left = max_bytes.saturating_sub(n_bytes);
        let mut staggered = Staggered::new(codes, &flags, (&sheets, near), (left, control))?;
        if !job.conductors.is_empty() {
            let cells = match near == prepared.cast_cells() {
                true => meshed.columns.clone(),
                false => cut.whole(task).columns((near, prepared.rays.axis), left, &mut backend).await?,
            };
            staggered = staggered.with_conductors(&Conductors::new(cells, &job.conductors, &flags));
        }
        if near == [window.first, window.end] {
            return Ok(Some(staggered));
        }
        // of each component that of the neighbours and its own are held at once
        staggered.within([window.first, window.end], near[0], (left, control)).map(Some)
    }

    /// The codes at the points of a component.
    async fn points(
        &self,
        (mut frame, cells): (Frame, [[u32; 3]; 2]),
        (task, insides): (&Task<'_>, &[Geometry]),
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Columns> {
        let &Task { job, prepared, .. } = task;
        let codes = frame.ranks.flag_of_rank.clone();
        let is_for_window = prepared.window.is_some();
        let mut parts;
        (frame, parts) =
            split(frame, &self.closed, (job.rule, is_for_window), (&prepared.whole, insides), backend.control).await?;
        if is_for_window {
            parts = parts.iter().map(|part| part.window(cells, &frame)).collect();
            frame = frame.window(cells);
        }
        let rays = Rays::new(prepared.rays.axis, frame.dims);
        let cast = Cast { frame: &frame, rays: &rays, rule: job.rule };
        let decided = (&codes[..], &prepared.whole, Doubt::new(rays, MAX_BOXES, None));
        backend.columns(&cast, parts, decided, max_bytes).await
    }
}

/// The points of a component around some cells.
fn points_of([first, end]: [[u32; 3]; 2], is_moved: [bool; 3]) -> [[u32; 3]; 2] {
    [first, [0, 1, 2].map(|axis| end[axis] + u32::from(is_moved[axis]))]
}

/// Whether all facets at a position lie in one plane across an axis.
fn is_flat(frame: &Frame, position: usize) -> bool {
    let corners = frame.facets_at(position).as_flattened();
    let first = corners.first();
    first.is_some_and(|first| (0..3).any(|axis| corners.iter().all(|corner| corner[axis] == first[axis])))
}
