//! The estimate: what a mesh would cost, before a ray is cast.
//!
//! Geometries, lines, rays -> [`Estimate`]. A ray crosses a facet where it passes through the facet's projection. Over all
//! offsets of the rays the expected number of crossings of a facet is the area of its projection, in cells across, so the
//! sum over all facets, clipped to the rectangle of the rays, is the expected number of crossings of the mesh. Crossings
//! below and beyond the domain along the rays count, as they do in the mesh.
//!
//! Bytes follow from rays, runs and cells. A run is taken to begin at every crossing before the end of its ray: too many where
//! geometries overlap, lie beside the domain, or have parts thinner than a cell.
//! Weakness: the sizes of compressed files are rules of thumb, right within a factor of three for curved surfaces; flat ones
//! compress better. Sizes marked exact are exact.
//! Cost: one pass over the corners.

mod costs;
mod device;
mod memory_limits;
mod plan;
mod work;

pub use costs::{Estimate, FileBytes, HostBytes};
pub use memory_limits::{Allowed, Device};
#[doc(hidden)]
pub use plan::BandLimit;
pub(crate) use plan::MemoryBudget;
pub use plan::{block_cache_bytes, slab_bytes};
