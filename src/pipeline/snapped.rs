//! Snaps the facets of a job in steps, between which a mesh can be cancelled, and keeps those that are needed.

use super::prepare::Prepared;
use crate::control::Control;
use crate::error::Result;
use crate::geometry::{Fill, Geometry};
use crate::job::Job;
use crate::rays::Rays;
use crate::snapping::{Snapped, Snapping};

/// Snaps all facets. Those that no ray of the mesh meets stay only where they are asked for later: by other rays, by cells along surfaces, by
/// edges that are not proper, by windows and by certificates.
///
/// # Errors
/// Those of [`crate::frame::Frame::new`]; `cancelled`.
pub(super) async fn snapped(job: &Job, prepared: &Prepared, control: &Control) -> Result<Snapped> {
    let is_plain = |geometry: &Geometry| geometry.fill == Fill::Centre && !geometry.shell && !geometry.invert;
    if prepared.window.is_none() && !job.certify && prepared.geometries.iter().all(is_plain) {
        let few = in_steps(prepared, Some(&prepared.rays), control).await?;
        if few.closed.iter().all(|closed| closed.is_proper) {
            return Ok(few);
        }
    }
    in_steps(prepared, None, control).await
}

async fn in_steps(prepared: &Prepared, rays: Option<&Rays>, control: &Control) -> Result<Snapped> {
    let mut snapping = Snapping::new(&prepared.geometries, &prepared.whole, rays)?;
    while snapping.step() {
        control.rest().await?;
    }
    Ok(snapping.finish())
}
