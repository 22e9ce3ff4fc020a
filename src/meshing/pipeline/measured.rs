//! What is measured at surfaces once the flags are known: links from cells to surfaces, and the fractions of cells.

use super::borders::{Left, Whole};
use super::prepare::Prepared;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Columns;
use hexcast_core::derived::fractions::{Fractions, fractions};
use hexcast_core::derived::links::{Field, Links};
use hexcast_core::grid::closed::Closed;
use hexcast_core::grid::frame::Frame;
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_core::input::job::Job;
use hexcast_core::stages::inside::Kind;

/// A frame from which nothing was taken, and how the cells of each rank are decided.
pub(super) struct Uncut {
    pub(super) frame: Frame,
    pub(super) closed: Vec<Closed>,
    kinds: Vec<Kind>,
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

    /// The links that a job asks for, of at most so many bytes with what finding them takes. Where rays do not decide all flags, and the
    /// columns are those of a window alone, the window is meshed once more with its neighbours.
    pub(super) async fn links(
        &self,
        job: &Job,
        (prepared, columns, whole): (&Prepared, &Columns, &Whole<'_>),
        (max_bytes, (engine, budget, control)): Left<'_>,
    ) -> Result<Option<Links>> {
        let Some(links) = job.links.as_ref() else { return Ok(None) };
        let (window, dims) = (prepared.cell_window(), prepared.whole.dims());
        // this frame, one that is sheared, and that of a window, with indices
        let periodic = job.periodic_axes();
        let n_frames = 3 + u64::from(periodic.contains(&true));
        let max_bytes = max_bytes.saturating_sub((n_frames * 38 + 4) * self.frame.facets.len() as u64);
        let is_plain = job.close_gaps.is_none() && !self.kinds.contains(&Kind::Apart);
        let [first, end] = prepared.window.unwrap_or([[0; 3], dims]);
        let near = window.with_neighbours(dims);
        let lacks_some = (0..3).any(|axis| near[0][axis] < first[axis] || near[1][axis] > end[axis]);
        let meshed = match !is_plain && lacks_some {
            true => Some(whole.columns((near, columns.rays().axis), max_bytes, (engine, budget, control)).await?),
            false => None,
        };
        let max_bytes = max_bytes.saturating_sub(meshed.as_ref().map_or(0, Columns::n_bytes));
        let (columns, first) = meshed.as_ref().map_or((columns, first), |meshed| (meshed, near[0]));
        let (frame, kinds) = (&self.frame, &self.kinds);
        let field = Field { frame, rule: job.rule, kinds, columns, first, window, is_plain, periodic };
        field.links(links, max_bytes, control).await.map(Some)
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
        // this frame, one of finer cells and what it is made of, those of faces, and the facets by rows
        let frames = 3 + 3 * u64::from(asked.faces) + u64::from(asked.surfaces);
        let max_bytes = max_bytes.saturating_sub(frames * 38 * self.frame.facets.len() as u64);
        let (of_box, window) = ((&self.frame, &prepared.whole), prepared.cell_window());
        fractions(of_box, window, (job.rule, &self.kinds), asked, max_bytes, control).await.map(Some)
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
