//! The facets around a place: those that meet a box.
//!
//! Geometries, a box in world coordinates -> [`NearFacet`]s. A facet and a box are apart if one of 13 axes separates them:
//! the three of the box, the normal of the facet, and the cross products of the box's axes with the facet's edges.
//! In f64, for people who look for the place in a file: nothing is decided by it.
//! Source: Akenine-Möller (2001), *Fast 3D triangle-box overlap testing*. Cost: one pass over the facets.

use glam::DVec3;
use serde::Serialize;

use hexcast_core::base::error::Result;
use hexcast_core::base::parallel::*;
use hexcast_core::input::geometry::Geometry;

/// A facet of a geometry.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct NearFacet {
    /// Name of the geometry.
    pub geometry: String,
    /// Index of the facet in the geometry, from 0, in the order of its file.
    pub facet: usize,
}

/// Facets that are looked at between two reads, where they stay in their file.
const FACETS_AT_ONCE: usize = 1 << 17;

/// Finds the facets that meet the box from `low` to `high`, in the order of the geometries.
///
/// # Errors
/// `io` where facets stay in their file, and that cannot be read again.
pub fn facets_near(geometries: &[Geometry], [low, high]: [[f64; 3]; 2]) -> Result<Vec<NearFacet>> {
    let (low, high) = (DVec3::from(low), DVec3::from(high));
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let of_geometry = |geometry: &Geometry| {
        let placing = geometry.placing();
        let is_near = |facet: &[[f32; 3]; 3]| meets(half, facet.map(|corner| DVec3::from(placing(corner)) - centre));
        let (mut found, mut first) = (Vec::new(), 0);
        let mut chunks = geometry.facets.chunks(FACETS_AT_ONCE);
        while let Some(some) = chunks.next_some()? {
            let near = some.par_iter().enumerate().filter(|(_, facet)| is_near(facet));
            let near = near.map(|(facet, _)| NearFacet { geometry: geometry.name.clone(), facet: first + facet });
            found.extend(near.collect::<Vec<NearFacet>>());
            first += some.len();
        }
        Ok(found)
    };
    let of_geometries: Result<Vec<Vec<NearFacet>>> = geometries.iter().map(of_geometry).collect();
    Ok(of_geometries?.concat())
}

/// Whether a facet meets the box around 0 with the given half edges.
fn meets(half: DVec3, corners: [DVec3; 3]) -> bool {
    let edges = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]];
    let separates = |axis: DVec3| {
        let at = corners.map(|corner| corner.dot(axis));
        let reach = half.dot(axis.abs());
        at[0].min(at[1]).min(at[2]) > reach || at[0].max(at[1]).max(at[2]) < -reach
    };
    let of_box = DVec3::AXES;
    let crossed = of_box.iter().flat_map(|axis| edges.iter().map(move |edge| axis.cross(*edge)));
    let mut axes = of_box.into_iter().chain([edges[0].cross(edges[1])]).chain(crossed);
    !axes.any(separates)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_are_near_if_they_meet_the_box() {
        let table = [
            // a corner inside
            ([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [9.0, 9.0, 0.0]], true),
            // around the box, through it
            ([[-9.0, -9.0, 0.5], [9.0, -9.0, 0.5], [0.0, 9.0, 0.5]], true),
            // above it
            ([[-9.0, -9.0, 1.5], [9.0, -9.0, 1.5], [0.0, 9.0, 1.5]], false),
            // past an edge: no axis of the box separates them
            ([[2.5, 0.0, 0.0], [0.0, 2.5, 0.0], [2.5, 2.5, 3.0]], false),
            ([[1.9, 0.0, 0.0], [0.0, 1.9, 0.0], [2.5, 2.5, 3.0]], true),
            // a facet without area
            ([[0.5, 0.5, 0.5]; 3], true),
            ([[1.5, 0.5, 0.5]; 3], false),
        ];
        for (facet, is_near) in table {
            let geometry = Geometry::new("g", 1, vec![[[50.0; 3]; 3], facet]).unwrap();
            let found = facets_near(&[geometry], [[-1.0; 3], [1.0; 3]]).unwrap();
            let expected = NearFacet { geometry: "g".into(), facet: 1 };
            assert_eq!(found, if is_near { vec![expected] } else { vec![] }, "{facet:?}");
        }
    }
}
