//! What is measured beside the cells, one after the other; casts the points of a staggered grid: six boxes in the frame of the mesh, on its backend.

use super::borders::{Backend, overlay};
use super::measured::Uncut;
use super::prepare::Prepared;
use crate::cast::Cast;
use crate::columns::{Columns, ColumnsBuilder};
use crate::doubt::Doubt;
use crate::error::Result;
use crate::fractions::Fractions;
use crate::frame::Frame;
use crate::geometry::{Fill, Geometry};
use crate::job::Job;
use crate::links::Links;
use crate::overlay::split;
use crate::rays::Rays;
use crate::report::MAX_BOXES;
use crate::staggered::{COMPONENTS, Staggered, check_dims};

/// What is left of the memory that columns may take, and the backend.
pub(super) type Left<'a> = (u64, Backend<'a>);

impl Uncut {
    /// All that a job asks for: each is held with those before it.
    ///
    /// # Errors
    /// Those of [`Uncut::links`], [`Uncut::fractions`] and [`Uncut::staggered`].
    pub(super) async fn all(
        &self,
        job: &Job,
        (prepared, columns): (&Prepared, &Columns),
        (mut bytes_left, (engine, budget, control)): Left<'_>,
    ) -> Result<(Option<Links>, Option<Fractions>, Option<Staggered>)> {
        let links = self.links(job, columns, bytes_left, control).await?;
        bytes_left = bytes_left.saturating_sub(links.as_ref().map_or(0, Links::n_bytes));
        let fractions = self.fractions(job, &prepared.whole, bytes_left, control).await?;
        bytes_left = bytes_left.saturating_sub(fractions.as_ref().map_or(0, Fractions::n_bytes));
        let staggered = self.staggered(job, prepared, (bytes_left, (engine, budget, control))).await?;
        Ok((links, fractions, staggered))
    }

    /// The flags of the staggered grid of a job.
    ///
    /// # Errors
    /// Those of [`check_dims`], [`split`] and [`crate::pipeline::Engine::columns`]; `memory` where columns would take more than there is.
    pub(super) async fn staggered(&self, job: &Job, prepared: &Prepared, left: Left<'_>) -> Result<Option<Staggered>> {
        let (max_bytes, (engine, budget, control)) = left;
        if !job.staggered {
            return Ok(None);
        }
        check_dims(self.frame.dims)?;
        let mut frame = self.frame.clone();
        let flags = std::mem::take(&mut frame.ranks.flag_of_rank);
        // codes, so that ranks are known where sheets meet insides
        frame.ranks.flag_of_rank = (1..=flags.len() as u8).collect();
        let of_rank = |rank: usize| &prepared.geometries[frame.ranks.geometry_at[rank]];
        // inverted, a plane holds all points
        let is_flat = |rank: usize| is_flat(&frame, rank) && !of_rank(rank).invert;
        let is_flat: Vec<bool> = (0..flags.len()).map(is_flat).collect();
        let sheets = with_some(&frame, |rank| of_rank(rank).fill != Fill::Centre || is_flat[rank]);
        let frame = with_some(&frame, |rank| !of_rank(rank).shell && !is_flat[rank]);
        // of these nothing but the inside counts; the others have no facets left
        let mut insides: Vec<Geometry> = prepared.geometries.to_vec();
        for (rank, &index) in frame.ranks.geometry_at.iter().enumerate() {
            let is_gone = insides[index].shell || is_flat[rank];
            (insides[index].fill, insides[index].shell) = (Fill::Centre, is_gone);
        }
        // this frame, its copy, the two made of that, and one that is cast
        let frames = 5 * 38 * self.frame.facets.len() as u64;
        let (mut codes, mut n_bytes) = (Vec::with_capacity(COMPONENTS.len()), frames);
        let control = &control.without_progress();
        for (_, is_moved) in COMPONENTS {
            let around = frame.clone().around_faces(is_moved);
            let left = max_bytes.saturating_sub(n_bytes);
            let columns =
                self.points(around, (job, prepared, &insides), (left, (&mut *engine, budget, control))).await?;
            n_bytes += columns.n_bytes();
            codes.push(columns);
        }
        Staggered::new(codes, &flags, &sheets, (max_bytes.saturating_sub(n_bytes), control)).map(Some)
    }

    /// The codes at the points of a component.
    async fn points(
        &self,
        frame: Frame,
        (job, prepared, insides): (&Job, &Prepared, &[Geometry]),
        (max_bytes, backend): Left<'_>,
    ) -> Result<Columns> {
        let (engine, budget, control) = backend;
        let codes = frame.ranks.flag_of_rank.clone();
        let (frame, parts) = split(frame, &self.closed, job.rule, &prepared.whole, insides, false)?;
        let rays = Rays::new(prepared.rays.axis, frame.dims);
        let cast = Cast { frame: &frame, rays: &rays, rule: job.rule };
        let decided = (&codes[..], &prepared.whole, Doubt::new(rays, MAX_BOXES, None));
        let (mut overlay, _) = overlay(parts, &cast, decided, (&mut *engine, budget, control)).await?;
        let mut builder = ColumnsBuilder::new(rays, max_bytes, None);
        engine.build(&cast, budget, &mut builder, &mut overlay, control).await?;
        builder.finish()
    }
}

/// A frame with the facets of some ranks.
fn with_some(frame: &Frame, stays: impl Fn(usize) -> bool) -> Frame {
    let both = frame.facets.iter().zip(&frame.position_of_facet).filter(|(_, position)| stays(usize::from(**position)));
    let (facets, position_of_facet) = both.unzip();
    Frame { facets, position_of_facet, ranks: frame.ranks.clone(), centres: frame.centres.clone(), ..*frame }
}

/// Whether all facets of a rank lie in one plane across an axis.
fn is_flat(frame: &Frame, rank: usize) -> bool {
    let corners = frame.facets_at(rank).as_flattened();
    let first = corners.first();
    first.is_some_and(|first| (0..3).any(|axis| corners.iter().all(|corner| corner[axis] == first[axis])))
}
