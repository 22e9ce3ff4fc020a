//! Ends and volume of placed facets, and kept beside the facets: estimates, meshes and reports ask for them again and again.
//!
//! Cost: two passes over the corners, on all cores; one where the reader of a file knows the ends.

use glam::DVec3;

use super::facets::{Measures, SharedFacets};
use crate::base::control::{Control, Paced};
use crate::base::error::Result;
use crate::base::parallel::*;
use hexcast_job::input::choices::placing::Placing;

/// Facets between two rests: some tens of milliseconds.
const FACETS_AT_ONCE: usize = 1 << 19;

/// Facets that one core takes at a time.
const BLOCK: usize = 1 << 13;
/// The ends of no corner.
const NO_ENDS: [[f64; 3]; 2] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

/// The ends of two boxes together.
#[inline(always)]
fn joined([low, high]: [[f64; 3]; 2], [other_low, other_high]: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    let [mut both_low, mut both_high] = [low, high];
    for axis in 0..3 {
        both_low[axis] = low[axis].min(other_low[axis]);
        both_high[axis] = high[axis].max(other_high[axis]);
    }
    [both_low, both_high]
}

/// Measures facets where they are placed.
///
/// # Errors
/// `cancelled`; `io` where they stay in their file, and that cannot be read again.
pub(super) async fn measures(facets: &SharedFacets, placing: Placing, control: &Control) -> Result<Measures> {
    if facets.is_empty() {
        return Ok(Measures::default());
    }
    let place = placing.of_corners();
    let mut pace = Paced::new(control, FACETS_AT_ONCE);
    let known = facets.ends().filter(|_| placing == Placing::default());
    let ends = match known {
        // without a sign of zero, which would depend on the order of facets
        Some(ends) => ends.map(|corner| corner.map(|at| f64::from(at) + 0.0)),
        None => {
            let mut ends = NO_ENDS;
            let mut chunks = facets.chunks(FACETS_AT_ONCE);
            while let Some(some) = chunks.next_some()? {
                let of_blocks = some.par_chunks(BLOCK).map(|block| {
                    block.as_flattened().iter().fold(NO_ENDS, |ends, corner| joined(ends, [place(*corner); 2]))
                });
                ends = on_all_cores(|| of_blocks.collect::<Vec<_>>()).into_iter().fold(ends, joined);
                pace.done(some.len()).await?;
            }
            ends.map(|corner| corner.map(|at| at + 0.0))
        }
    };
    let [low, high] = ends;
    let centre = (DVec3::from(low) + DVec3::from(high)) * 0.5;
    let mut six_volumes = 0.0;
    let mut chunks = facets.chunks(FACETS_AT_ONCE);
    while let Some(some) = chunks.next_some()? {
        let corner = |c: [f32; 3]| DVec3::from(place(c)) - centre;
        let volumes = some.par_chunks(BLOCK).map(|block| {
            block.iter().map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c)))).collect::<Vec<f64>>()
        });
        // one after the other, so that the number of threads does not change the last bits
        for volume in on_all_cores(|| volumes.collect::<Vec<_>>()).into_iter().flatten() {
            six_volumes += volume;
        }
        pace.done(some.len()).await?;
    }
    // a mirrored surface has its normals inwards by the order of its corners alone
    let signed_volume = (six_volumes / 6.0).copysign(six_volumes * placing.determinant());
    Ok(Measures { ends: Some(ends), signed_volume })
}
