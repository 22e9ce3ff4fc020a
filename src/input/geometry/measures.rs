//! Ends and volume of placed facets, found in steps, and kept beside the facets: estimates, meshes and reports ask for them again and again.
//!
//! Cost: two passes over the corners.

use glam::DVec3;

use super::placing::Placing;

/// Facets of a step: some tens of milliseconds.
const FACETS_AT_ONCE: usize = 1 << 19;

/// What is known of placed facets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measures {
    /// Least and greatest world coordinates; None without facets.
    pub(crate) ends: Option<[[f64; 3]; 2]>,
    /// The volume by the divergence theorem, relative to the centre of the box, with the sign of its facets in the file.
    pub(crate) signed_volume: f64,
}

/// Measures facets in steps, each of which gets them and where they are placed.
pub(crate) struct Measuring {
    ends: [[f64; 3]; 2],
    six_volumes: f64,
    /// Facets that are done, of the pass for the ends and of that for the volume.
    done: [usize; 2],
}

impl Measuring {
    pub(crate) fn new() -> Measuring {
        Measuring { ends: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], six_volumes: 0.0, done: [0; 2] }
    }

    /// Does a part of the work; false once all is done.
    pub(crate) fn step(&mut self, facets: &[[[f32; 3]; 3]], placing: Placing) -> bool {
        let n = facets.len();
        let pass = usize::from(self.done[0] == n);
        let some = &facets[self.done[pass]..n.min(self.done[pass] + FACETS_AT_ONCE)];
        let placing = placing.of_corners();
        if pass == 0 {
            let [low, high] = &mut self.ends;
            for corner in some.as_flattened() {
                let world = placing(*corner);
                for axis in 0..3 {
                    low[axis] = low[axis].min(world[axis]);
                    high[axis] = high[axis].max(world[axis]);
                }
            }
        } else {
            let [low, high] = self.ends;
            let centre = (DVec3::from(low) + DVec3::from(high)) * 0.5;
            let corner = |c: [f32; 3]| DVec3::from(placing(c)) - centre;
            for [a, b, c] in some {
                self.six_volumes += corner(*a).dot(corner(*b).cross(corner(*c)));
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
