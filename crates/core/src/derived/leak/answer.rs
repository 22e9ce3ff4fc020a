//! What was found of a leak as data: what the command prints as JSON and the package returns.

use serde::Serialize;

use super::{Leak, NearFacet, facets_near};
use crate::derived::mesh::Mesh;
use crate::input::geometry::Geometry;

/// Cells around the narrowest place in which facets are named.
const CELLS_AROUND: u32 = 1;

/// A leak with the unit of its mesh and the facets around its narrowest place.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Answer {
    /// What was found.
    #[serde(flatten)]
    pub leak: Leak,
    /// Whether there is no path.
    pub is_tight: bool,
    /// Unit of lengths, if the mesh has one.
    pub unit: Option<String>,
    /// Facets within a cell of the narrowest place; none where no surfaces were given.
    pub facets: Option<Vec<NearFacet>>,
}

impl Answer {
    /// Names the facets of `surfaces`, if any are given.
    pub fn new(leak: Leak, mesh: &Mesh, surfaces: Option<&[Geometry]>) -> Answer {
        let around = leak.narrowest.as_ref().map(|place| place.bounds_with(&mesh.lines, CELLS_AROUND));
        let near = |surfaces: &[Geometry]| around.map_or_else(Vec::new, |around| facets_near(surfaces, around));
        Answer { is_tight: leak.path.is_none(), unit: mesh.unit.clone(), facets: surfaces.map(near), leak }
    }
}
