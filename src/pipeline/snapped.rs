//! Snaps the facets of a job in steps, between which a mesh can be cancelled, and keeps those that are needed.

use super::prepare::Prepared;
use crate::control::Control;
use crate::error::Result;
use crate::geometry::{Fill, Geometry};
use crate::job::Job;
use crate::rays::Rays;
use crate::snapping::{Snapped, Snapping};

/// Facets of which those that no ray meets are worth their room.
const MANY_FACETS: usize = 1 << 20;

/// Snaps all facets. Of many those that no ray of the mesh meets stay only where they are asked for later: by other rays, by cells along surfaces, by
/// edges that are not proper, by windows and by certificates.
///
/// # Errors
/// Those of [`crate::frame::Frame::new`]; `cancelled`.
pub(super) async fn snapped(job: &Job, prepared: &Prepared, control: &Control) -> Result<Snapped> {
    let n_facets: usize = prepared.geometries.iter().map(|geometry| geometry.facets.len()).sum();
    let is_plain = |geometry: &Geometry| geometry.fill == Fill::Centre && !geometry.shell && !geometry.invert;
    let is_measured = job.certify || job.links.is_some() || job.fractions.is_some() || job.staggered;
    let is_plain = !is_measured && prepared.geometries.iter().all(is_plain);
    if n_facets >= MANY_FACETS && prepared.window.is_none() && is_plain {
        let few = in_steps((job, prepared), Some(&prepared.rays), control).await?;
        if few.closed.iter().all(|closed| closed.is_proper) {
            return Ok(few);
        }
    }
    in_steps((job, prepared), None, control).await
}

async fn in_steps((job, prepared): (&Job, &Prepared), rays: Option<&Rays>, control: &Control) -> Result<Snapped> {
    let mut snapping = Snapping::new(&prepared.geometries, &prepared.whole, rays)?;
    while snapping.step() {
        control.rest().await?;
    }
    snapping.finish(job.rule)
}
