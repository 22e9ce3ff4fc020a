//! Snaps the facets of a job in steps, between which a mesh can be cancelled, and keeps those that are needed.

use super::options::MeshOptions;
use super::prepare::Prepared;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::memory::{Held, Memory};
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::geometry::Geometry;
use hexcast_core::input::job::Job;
use hexcast_core::stages::snapping::{FACETS_AT_ONCE, Snapped, Snapping};

/// Bytes of a snapped facet, and of one while the edges of its geometry are compared.
const SNAPPED_BYTES: u64 = 38;
const EDGE_BYTES: u64 = 20;
/// What errors of memory call them.
const SNAPPED: &str = "the snapped facets and their edges";
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
    let n_facets: usize = prepared.geometries.iter().map(|geometry| geometry.facets.len()).sum();
    let is_measured = options.walls || job.certify || job.links.is_some() || job.fractions.is_some() || job.staggered;
    let is_plain = !is_measured && prepared.geometries.iter().all(Geometry::is_plain);
    if n_facets >= MANY_FACETS && prepared.window.is_none() && is_plain {
        let (few, room) = in_steps((job, prepared), Some(&prepared.rays), memory, control).await?;
        if few.closed.iter().all(|closed| closed.is_proper) {
            room.keep();
            return Ok(few);
        }
    }
    let (all, room) = in_steps((job, prepared), None, memory, control).await?;
    room.keep();
    Ok(all)
}

async fn in_steps(
    (job, prepared): (&Job, &Prepared),
    rays: Option<&Rays>,
    memory: &Memory,
    control: &Control,
) -> Result<(Snapped, Held)> {
    let n_facets = prepared.geometries.iter().map(|geometry| geometry.facets.len());
    let (n_all, n_most) = (n_facets.clone().sum::<usize>(), n_facets.max().unwrap_or(0));
    // those that were snapped last are there twice, and three times where some are left out
    let again = if rays.is_none() { 1 } else { 2 };
    let edges = EDGE_BYTES * n_most as u64 + again * SNAPPED_BYTES * n_most.min(FACETS_AT_ONCE) as u64;
    let mut room = memory.take(edges, SNAPPED)?;
    // where no ray is asked for, all stay
    let all = if rays.is_none() { SNAPPED_BYTES * n_all as u64 } else { 0 };
    let mut snapping = Snapping::new(&prepared.geometries, &prepared.whole, rays)?;
    room.set(edges + all, SNAPPED)?;
    while snapping.step() {
        room.set(edges + all.max(SNAPPED_BYTES * snapping.n_stay() as u64), SNAPPED)?;
        control.rest().await?;
    }
    let snapped = snapping.finish(job.rule)?;
    room.set(SNAPPED_BYTES * snapped.frame.facets.capacity() as u64, SNAPPED)?;
    Ok((snapped, room))
}
