//! Ends and volume of placed facets, found in steps, and kept beside the facets: estimates, meshes and reports ask for them again and again.
//!
//! Cost: two passes over the corners, on all cores.

use glam::DVec3;

use super::placing::Placing;
use crate::base::parallel::*;

/// Facets of a step: some tens of milliseconds.
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

/// What is known of placed facets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// Least and greatest world coordinates; None without facets.
    pub(crate) ends: Option<[[f64; 3]; 2]>,
    /// The volume by the divergence theorem, relative to the centre of the box, with the sign of its facets in the file.
    pub(crate) signed_volume: f64,
}

/// Measures facets in steps, each of which gets them and where they are placed.
#[doc(hidden)]
pub struct Measuring {
    ends: [[f64; 3]; 2],
    six_volumes: f64,
    /// Facets that are done, of the pass for the ends and of that for the volume.
    done: [usize; 2],
}

impl Default for Measuring {
    fn default() -> Self {
        Self::new()
    }
}

impl Measuring {
    #[doc(hidden)]
    pub fn new() -> Measuring {
        Measuring { ends: NO_ENDS, six_volumes: 0.0, done: [0; 2] }
    }

    /// Does a part of the work; false once all is done.
    #[doc(hidden)]
    pub fn step(&mut self, facets: &[[[f32; 3]; 3]], placing: Placing) -> bool {
        let n = facets.len();
        let pass = usize::from(self.done[0] == n);
        let some = &facets[self.done[pass]..n.min(self.done[pass] + FACETS_AT_ONCE)];
        let placing = placing.of_corners();
        if pass == 0 {
            let ends = some.par_chunks(BLOCK).map(|block| {
                block.as_flattened().iter().fold(NO_ENDS, |ends, corner| joined(ends, [placing(*corner); 2]))
            });
            self.ends = ends.collect::<Vec<_>>().into_iter().fold(self.ends, joined);
        } else {
            let [low, high] = self.ends;
            let centre = (DVec3::from(low) + DVec3::from(high)) * 0.5;
            let corner = |c: [f32; 3]| DVec3::from(placing(c)) - centre;
            let volumes = some.par_chunks(BLOCK).map(|block| {
                block.iter().map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c)))).collect::<Vec<f64>>()
            });
            // one after the other, so that the number of threads does not change the last bits
            for volume in volumes.collect::<Vec<_>>().into_iter().flatten() {
                self.six_volumes += volume;
            }
        }
        self.done[pass] += some.len();
        self.done != [n; 2]
    }

    /// What was found, once all is done.
    pub(crate) fn finish(self, placing: Placing) -> Measures {
        // a mirrored surface has its normals inwards by the order of its corners alone
        let signed = (self.six_volumes / 6.0).copysign(self.six_volumes * placing.determinant());
        match self.done {
            [0, _] => Measures { ends: None, signed_volume: 0.0 },
            _ => Measures { ends: Some(self.ends), signed_volume: signed },
        }
    }
}
