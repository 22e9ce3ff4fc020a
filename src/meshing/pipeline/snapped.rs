//! Snaps the facets of a job, and keeps those that are needed.

use super::options::MeshOptions;
use super::prepare::Prepared;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::memory::Memory;
use hexcast_core::input::geometry::Geometry;
use hexcast_core::input::job::Job;
use hexcast_core::stages::snapping::{self, Snapped};

/// Facets of which those that no ray meets are worth their room.
const MANY_FACETS: usize = 1 << 20;

/// Snaps all facets. Of many those that no ray of the mesh meets stay only where they are asked for later: by other rays, by cells along surfaces, by
/// edges that are not proper, by windows and by certificates.
///
/// # Errors
/// Those of [`Frame::new`](hexcast_core::grid::frame::Frame::new); `memory`; `cancelled`.
pub(super) async fn snapped(
    (job, options): (&Job, &MeshOptions),
    prepared: &Prepared,
    memory: &Memory,
    control: &Control,
) -> Result<Snapped> {
    let Prepared { geometries, whole, .. } = prepared;
    let n_facets: usize = geometries.iter().map(|geometry| geometry.facets.len()).sum();
    let is_measured = options.walls || job.certify || job.links.is_some() || job.fractions.is_some() || job.staggered;
    let is_plain = !is_measured && geometries.iter().all(Geometry::is_plain);
    if n_facets >= MANY_FACETS && prepared.window.is_none() && is_plain {
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
