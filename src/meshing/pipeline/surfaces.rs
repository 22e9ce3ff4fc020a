//! Surfaces: what the snap of all facets says of the geometries of a job, before some are taken from the rays.

use super::memory_budget::check_copies;
use super::plates::Plates;
use super::prepare::{Prepared, Task};
use crate::meshing::report::is_cut;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::closed::{BadEdges, Closed};
use hexcast_core::grid::frame::{Ends, Frame};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::volume_bound::BoundSums;
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_core::input::job::Job;
use hexcast_core::stages::inside::Kind;
use hexcast_core::stages::snapping::{self, Snapped};
use hexcast_derived::walls::Candidates;

/// Facets of which those that no ray meets are worth their room.
const MANY_FACETS: usize = 1 << 20;

/// What is known of the snapped facets, besides these.
pub(super) struct Surfaces {
    /// What the edges say, by position.
    pub(super) closed: Vec<Closed>,
    /// Least and greatest coordinates, by position.
    pub(super) ends: Vec<Ends>,
    /// By position.
    pub(super) bound_sums: Vec<BoundSums>,
    /// By geometry.
    pub(super) bad_edges: Vec<BadEdges>,
    /// The faces of geometries without thickness.
    pub(super) plates: Option<Plates>,
    /// Faces that solids may name, if they shall.
    pub(super) walls: Option<Candidates>,
    /// The facets as they are, if the job asks for what is measured at them.
    pub(super) uncut: Option<Uncut>,
}

impl Surfaces {
    /// Snaps the facets of a job, in a frame of its whole box.
    ///
    /// # Errors
    /// Those of [`Frame::new`]; `memory`; `cancelled`; `surface-open` and `job-conflict` where something is measured that a geometry does not have.
    pub(super) async fn new(task: &Task<'_>) -> Result<(Frame, Surfaces)> {
        let &Task { job, options, prepared, memory, control, .. } = task;
        let Snapped { frame, closed, ends, bound_sums } = snapped(task).await?;
        let (whole, geometries) = (&prepared.whole, &prepared.geometries);
        let bad_edges = BadEdges::of_geometries(&frame, &closed, whole, geometries, (memory, control))?;
        check_copies(job, (&frame, &closed), prepared, memory)?;
        control.rest().await?;
        let plates = Plates::new(&frame, &ends, prepared, (memory.left(), control))?;
        let walls = match options.walls {
            true => Some(Candidates::new(&frame, geometries, prepared.cast_cells(), (memory.left(), control))?),
            false => None,
        };
        let uncut = Uncut::new(job, &frame, &closed, geometries)?.filter(|_| task.is_measured);
        Ok((frame, Surfaces { closed, ends, bound_sums, bad_edges, plates, walls, uncut }))
    }

    /// For each geometry how far the volume of its cells can be from that of its surface, where both are of the same body.
    pub(super) fn volume_bounds(&self, frame: &Frame, geometries: &[Geometry], lines: &Lines) -> Vec<Option<f64>> {
        let mut bounds = vec![None; geometries.len()];
        for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
            let geometry = &geometries[index];
            let is_within = geometry.fill == Fill::Centre && !geometry.invert && self.closed[position].nonzero;
            let ends = geometry.bounding_box().unwrap_or_default();
            if is_within && !is_cut(ends, lines) {
                let volume = geometry.signed_volume().abs();
                let bound = |cell| self.bound_sums[position].bound(frame.fraction_bits, cell, volume);
                bounds[index] = lines.cell_volume().map(bound);
            }
        }
        bounds
    }
}

/// Snaps all facets. Of many those that no ray of the mesh meets stay only where they are asked for later: by other rays, by cells along surfaces, by
/// edges that are not proper, by windows and by certificates.
///
/// # Errors
/// Those of [`Frame::new`]; `memory`; `cancelled`.
pub(super) async fn snapped(task: &Task<'_>) -> Result<Snapped> {
    let &Task { job, options, prepared, memory, control, .. } = task;
    let Prepared { geometries, whole, .. } = prepared;
    let n_facets: usize = geometries.iter().map(|geometry| geometry.facets.len()).sum();
    let is_measured = options.walls || job.certify || job.is_measured();
    let is_plain = !is_measured && geometries.iter().all(Geometry::is_plain);
    let are_many = n_facets >= MANY_FACETS || geometries.iter().any(|geometry| geometry.facets.stay_in_file());
    if are_many && prepared.window.is_none() && is_plain {
        let (few, room) =
            snapping::snapped(geometries, whole, (Some(&prepared.rays), job.rule), memory, control).await?;
        if few.closed.iter().all(|closed| closed.is_proper) {
            room.keep();
            return Ok(few);
        }
    }
    let (all, room) = snapping::snapped(geometries, whole, (None, job.rule), memory, control).await?;
    room.keep();
    Ok(all)
}

/// The facets of a job as they were snapped, for what is measured at them: a frame from which nothing was taken, and how the cells of each rank are
/// decided.
pub(super) struct Uncut {
    pub(super) frame: Frame,
    pub(super) closed: Vec<Closed>,
    pub(super) kinds: Vec<Kind>,
}

impl Uncut {
    /// Keeps the frame, if the job asks for what is measured with it.
    ///
    /// # Errors
    /// `surface-open`, `job-conflict` where the fractions of cells are asked for, and a geometry has cells that rays do not decide.
    pub(super) fn new(job: &Job, frame: &Frame, closed: &[Closed], geometries: &[Geometry]) -> Result<Option<Uncut>> {
        if !job.is_measured() {
            return Ok(None);
        }
        // those that share a rank are all cast
        let mut kinds = vec![Kind::Cast; frame.ranks.flag_of_rank.len()];
        for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
            let (geometry, is_closed) = (&geometries[index], closed[position].by(job.rule));
            let kind = &mut kinds[usize::from(frame.ranks.rank_at[position])];
            if geometry.fill != Fill::Centre || geometry.shell || !is_closed {
                if job.cut_cells.is_some() {
                    return Err(no_volume(geometry, is_closed, "cut cells"));
                }
                if job.fractions.is_some() {
                    return Err(no_volume(geometry, is_closed, "fractions"));
                }
                let has_no_inside = !is_closed && !geometry.shell && !is_flat(frame, position);
                if job.conformal.is_some() && has_no_inside {
                    let message =
                        format!("geometry \"{}\" is not closed: it has no inside that could be metal", geometry.name);
                    let hint = "close it, make it a sheet without an inside (FILE:shell=true), or leave out conformal";
                    return Err(Error::new("surface-open", message, hint));
                }
                if job.tensors.is_some() && has_no_inside {
                    let message =
                        format!("geometry \"{}\" is not closed: it has no inside with a permittivity", geometry.name);
                    return Err(Error::new("surface-open", message, "close it, or leave out tensors"));
                }
                *kind = Kind::Apart;
            } else if geometry.invert {
                *kind = Kind::Inverted;
            }
        }
        Ok(Some(Uncut { frame: frame.clone(), closed: closed.to_vec(), kinds }))
    }
}

/// Whether all facets at a position lie in one plane across an axis.
pub(super) fn is_flat(frame: &Frame, position: usize) -> bool {
    let corners = frame.facets_at(position).as_flattened();
    let first = corners.first();
    first.is_some_and(|first| (0..3).any(|axis| corners.iter().all(|corner| corner[axis] == first[axis])))
}

/// The error of a geometry whose cells are not those of a volume.
fn no_volume(geometry: &Geometry, is_closed: bool, what: &str) -> Error {
    let Geometry { name, .. } = geometry;
    if is_closed {
        let message =
            format!("geometry \"{name}\" has cells along its surface, but {what} are measured from volumes alone");
        return Error::new("job-conflict", message, format!("leave out fill and shell, or {what}"));
    }
    let message = format!("geometry \"{name}\" is not closed: it has no volume to measure {what} of");
    Error::new("surface-open", message, format!("close it, or leave out {what}"))
}
