//! What is measured at surfaces once the flags are known: links from cells to surfaces, and the fractions of cells.

use crate::closed::Closed;
use crate::columns::Columns;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::fractions::{Fractions, fractions};
use crate::frame::{Frame, MAX_RANKS};
use crate::geometry::{Fill, Geometry};
use crate::inside::Kind;
use crate::job::Job;
use crate::lines::Lines;
use crate::links::{Field, Links};

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
        let n = geometries.len();
        if n > MAX_RANKS {
            let message = format!(
                "there are {n} geometries, and links, fractions and staggered grids tell at most {MAX_RANKS} apart"
            );
            return Err(Error::new(
                "too-many-geometries",
                message,
                "join geometries of the same substance in one file, or leave these out",
            ));
        }
        let kind = |(rank, &index): (usize, &usize)| {
            let geometry = &geometries[index];
            if geometry.fill != Fill::Centre || geometry.shell || !closed[rank].by(job.rule) {
                Kind::Apart
            } else if geometry.invert {
                Kind::Inverted
            } else {
                Kind::Cast
            }
        };
        let kinds: Vec<Kind> = frame.ranks.geometry_at.iter().enumerate().map(kind).collect();
        let apart = kinds.iter().position(|kind| *kind == Kind::Apart);
        if let Some(rank) = apart.filter(|_| job.fractions.is_some()) {
            return Err(no_volume(&geometries[frame.ranks.geometry_at[rank]], closed[rank].by(job.rule)));
        }
        Ok(Some(Uncut { frame: frame.clone(), closed: closed.to_vec(), kinds }))
    }

    /// The links that a job asks for, of at most so many bytes with what finding them takes.
    pub(super) async fn links(
        &self,
        job: &Job,
        columns: &Columns,
        max_bytes: u64,
        control: &Control,
    ) -> Result<Option<Links>> {
        let Some(links) = job.links.as_ref() else { return Ok(None) };
        // this frame, and one that is sheared
        let max_bytes = max_bytes.saturating_sub(2 * 38 * self.frame.facets.len() as u64);
        let is_plain = job.close_gaps.is_none() && !self.kinds.contains(&Kind::Apart);
        let field = Field { frame: &self.frame, rule: job.rule, kinds: &self.kinds, columns, is_plain };
        field.links(links, max_bytes, control).await.map(Some)
    }

    /// The fractions of cells that a job asks for, of at most so many bytes.
    pub(super) async fn fractions(
        &self,
        job: &Job,
        lines: &Lines,
        max_bytes: u64,
        control: &Control,
    ) -> Result<Option<Fractions>> {
        let Some(asked) = job.fractions else { return Ok(None) };
        // this frame, one of finer cells, those of faces, and the facets by rows
        let frames = 2 + 3 * u64::from(asked.faces) + u64::from(asked.surfaces);
        let max_bytes = max_bytes.saturating_sub(frames * 38 * self.frame.facets.len() as u64);
        fractions((&self.frame, lines), (job.rule, &self.kinds), asked, max_bytes, control).await.map(Some)
    }
}

/// The error of a geometry whose cells are not those of a volume.
fn no_volume(geometry: &Geometry, is_closed: bool) -> Error {
    let Geometry { name, .. } = geometry;
    if is_closed {
        let message = format!("geometry \"{name}\" has cells along its surface, and fractions are those of volumes");
        return Error::new("job-conflict", message, "leave out fill and shell, or fractions");
    }
    let message = format!("geometry \"{name}\" is not closed, and fractions are those of volumes");
    Error::new("surface-open", message, "close it, or leave out fractions")
}
