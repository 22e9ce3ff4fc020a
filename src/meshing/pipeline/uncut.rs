//! The facets of a job as they were snapped, for what is measured at them.

use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::closed::Closed;
use hexcast_core::grid::frame::Frame;
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_core::input::job::Job;
use hexcast_core::stages::inside::Kind;

/// A frame from which nothing was taken, and how the cells of each rank are decided.
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
        if job.links.is_none() && job.fractions.is_none() && !job.staggered {
            return Ok(None);
        }
        // those that share a rank are all cast
        let mut kinds = vec![Kind::Cast; frame.ranks.flag_of_rank.len()];
        for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
            let (geometry, is_closed) = (&geometries[index], closed[position].by(job.rule));
            let kind = &mut kinds[usize::from(frame.ranks.rank_at[position])];
            if geometry.fill != Fill::Centre || geometry.shell || !is_closed {
                if job.fractions.is_some() {
                    return Err(no_volume(geometry, is_closed));
                }
                *kind = Kind::Apart;
            } else if geometry.invert {
                *kind = Kind::Inverted;
            }
        }
        Ok(Some(Uncut { frame: frame.clone(), closed: closed.to_vec(), kinds }))
    }
}

/// The error of a geometry whose cells are not those of a volume.
fn no_volume(geometry: &Geometry, is_closed: bool) -> Error {
    let Geometry { name, .. } = geometry;
    if is_closed {
        let message =
            format!("geometry \"{name}\" has cells along its surface, but fractions are measured from volumes alone");
        return Error::new("job-conflict", message, "leave out fill and shell, or fractions");
    }
    let message = format!("geometry \"{name}\" is not closed: it has no volume to measure fractions of");
    Error::new("surface-open", message, "close it, or leave out fractions")
}
