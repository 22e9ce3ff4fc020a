//! Facets of polygons with shared corners, as OBJ, OFF and PLY have them.
//!
//! A polygon of more than three corners becomes a fan of facets around its first corner. Parity and winding number are those of the
//! polygon, even where it is concave: where the fan covers a place twice, it does so an even number of times more, or once each way round.
//! Where the corners do not lie in a plane, a polygon has no one surface; the fan is one of those that fit, and a warning counts them.

use super::contents::{Contents, FACETS, Format, SOLID_BYTES, SOLIDS, Solid, Tally, Warnings, empty};
use crate::base::error::{Error, Result};
use crate::base::memory::{Held, List, Memory};
use crate::input::geometry::{Facet, SharedFacets};

/// How far off a plane, as a part of its size, a corner lies before its polygon is called not planar: more than f32 rounds.
const FLAT: f64 = 1e-5;
/// Most corners and facets that objects may stand for, copies of others among them.
const MAX_COPIED: u64 = 1 << 29;

/// What errors of memory call the corners of one polygon.
pub(super) const CORNERS: &str = "the corners of a polygon";

/// Collects corners and polygons.
#[derive(Debug)]
pub(super) struct Polygons {
    pub(super) corners: List<[f32; 3]>,
    /// Names of solids, and the index of the first facet of each.
    solids: List<(String, usize)>,
    /// The bytes of these names.
    names: Held,
    facets: List<Facet>,
    tally: Tally,
    n_bent: u64,
    n_degenerate: u64,
    first_bent: String,
    n_copied: u64,
    pub(super) warnings: Warnings,
}

impl Polygons {
    /// None yet.
    pub(super) fn within(memory: &Memory) -> Polygons {
        Polygons {
            corners: List::new(memory, "its corners"),
            solids: List::new(memory, SOLIDS),
            names: Held::of(memory),
            facets: List::new(memory, FACETS),
            tally: Tally::default(),
            n_bent: 0,
            n_degenerate: 0,
            first_bent: String::new(),
            n_copied: 0,
            warnings: Warnings::default(),
        }
    }

    /// Adds a corner of three numbers; `place` says where it stands.
    pub(super) fn corner(&mut self, corner: [f32; 3], place: impl Fn() -> String) -> Result<()> {
        if let Some(number) = corner.iter().find(|number| !number.is_finite()) {
            let message = format!("{}: a coordinate is {number}, or too large for an f32", place());
            return Err(Error::new("stl-not-finite", message, "export the model again"));
        }
        self.corners.push(corner)
    }

    /// Begins a solid: what follows belongs to it. One of the same name goes on.
    pub(super) fn solid(&mut self, name: &str) -> Result<()> {
        if self.solids.last().is_none_or(|(last, _)| last != name) { self.new_solid(name) } else { Ok(()) }
    }

    /// Begins a solid, whatever the name of the last one; one without facets is left out at the end.
    pub(super) fn new_solid(&mut self, name: &str) -> Result<()> {
        // one without facets is gone
        let n_facets = self.facets.len();
        if let Some((name, _)) = self.solids.pop_if(|(_, start)| *start == n_facets) {
            self.names.shrink(SOLID_BYTES + name.len() as u64);
        }
        self.names.grow(SOLID_BYTES + name.len() as u64, SOLIDS)?;
        self.solids.push((name.into(), n_facets))
    }

    /// Counts corners and facets that are about to be added: a small file may place copies of copies.
    pub(super) fn count_copied(&mut self, n: usize) -> Result<()> {
        self.n_copied += n as u64;
        if self.n_copied > MAX_COPIED {
            let message = format!(
                "the objects that it places have more than {MAX_COPIED} corners and facets in all, copies among them"
            );
            return Err(Error::new("too-many-facets", message, "export fewer copies"));
        }
        Ok(())
    }

    /// Adds a polygon by the indices of its corners, which must be there.
    pub(super) fn polygon(&mut self, corners: &[usize], place: impl Fn() -> String) -> Result<()> {
        if corners.len() < 3 {
            self.n_degenerate += 1;
            return Ok(());
        }
        if self.facets.len() + corners.len() - 2 > u32::MAX as usize {
            let message = format!("{}: more facets than a 32-bit index counts", place());
            return Err(Error::new("too-many-facets", message, "simplify the model"));
        }
        let at = |index: usize| self.corners[index];
        for pair in corners[1..].windows(2) {
            let facet = [at(corners[0]), at(pair[0]), at(pair[1])];
            // there is no normal to compare with
            self.tally.count([f32::NAN; 3], &facet);
            self.facets.push(facet)?;
        }
        if corners.len() > 3 && is_bent(corners.iter().map(|&index| at(index).map(f64::from))) {
            if self.n_bent == 0 {
                self.first_bent = place();
            }
            self.n_bent += 1;
        }
        Ok(())
    }

    /// The contents of the file.
    pub(super) fn finish(mut self, format: Format, n_bytes: u64) -> Result<Contents> {
        if self.facets.is_empty() {
            return Err(empty(&format!("no facet among {} corners of {}", self.corners.len(), format.name())));
        }
        if self.n_bent > 0 {
            let (n, first) = (self.n_bent, &self.first_bent);
            let text = format!(
                "{n} polygons of more than three corners are not planar, the first at {first}: each is a fan of facets"
            );
            self.warnings.push(text);
        }
        if self.n_degenerate > 0 {
            self.warnings.push(format!("{} polygons of fewer than three corners are left out", self.n_degenerate));
        }
        let n_facets = self.facets.len() as u64;
        self.names.keep();
        let (mut names, mut starts): (Vec<String>, Vec<usize>) = self.solids.keep().into_iter().unzip();
        // what stands before the first name, and all where there is none
        names.insert(0, String::new());
        starts.insert(0, 0);
        let parts = SharedFacets::cut(self.facets.keep(), &starts);
        let solids = names.into_iter().zip(parts).map(|(name, facets)| Solid { name, facets: facets.known_finite() });
        let solids = solids.filter(|solid| !solid.facets.is_empty()).collect();
        Ok(Contents {
            format,
            solids,
            n_facets,
            n_bytes,
            unit: None,
            wrong_normals: 0,
            zero_normals: 0,
            zero_area: self.tally.zero_area,
            has_colours: false,
            conversion: None,
            warnings: self.warnings.finish(),
        })
    }
}

/// Whether corners lie off the plane of the polygon: that of its area vector through its middle.
fn is_bent(corners: impl Iterator<Item = [f64; 3]> + Clone) -> bool {
    let n = corners.clone().count() as f64;
    let mut middle = [0.0; 3];
    corners.clone().for_each(|corner| (0..3).for_each(|axis| middle[axis] += corner[axis] / n));
    let from_middle = corners.map(|corner| [0, 1, 2].map(|axis| corner[axis] - middle[axis]));
    let mut area = [0.0; 3];
    let next = from_middle.clone().skip(1).chain(from_middle.clone().take(1));
    for (a, b) in from_middle.clone().zip(next) {
        area[0] += a[1] * b[2] - a[2] * b[1];
        area[1] += a[2] * b[0] - a[0] * b[2];
        area[2] += a[0] * b[1] - a[1] * b[0];
    }
    let length = |of: [f64; 3]| of.iter().map(|number| number * number).sum::<f64>().sqrt();
    let size = from_middle.clone().map(length).fold(0.0, f64::max);
    let off = from_middle.map(|corner| (0..3).map(|axis| corner[axis] * area[axis]).sum::<f64>().abs());
    off.fold(0.0, f64::max) > FLAT * size * length(area)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_are_counted_up_to_the_limit() {
        let mut polygons = Polygons::within(&Memory::default());
        assert!(polygons.count_copied(MAX_COPIED as usize - 5).is_ok() && polygons.count_copied(5).is_ok());
        assert_eq!(polygons.count_copied(1).map_err(|error| error.code()), Err("too-many-facets"));
    }

    #[test]
    fn a_polygon_is_bent_where_a_corner_leaves_its_plane() {
        // outlines in a plane, also ones that are not convex, with whole numbers
        let outlines: [&[[f64; 2]]; 4] = [
            &[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]],
            &[[0.0, 0.0], [5.0, -1.0], [7.0, 3.0], [2.0, 6.0], [-3.0, 2.0]],
            &[[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [3.0, 1.0], [0.0, 6.0]],
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0]],
        ];
        // two directions of each plane; their cross product is normal to it
        let planes = [
            ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
            ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
            ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ([1.0, 2.0, -1.0], [3.0, 0.0, 2.0], [4.0, -5.0, -6.0]),
            ([-2.0, 1.0, 3.0], [1.0, 4.0, -1.0], [-13.0, 1.0, -9.0]),
        ];
        // neither corners on a line nor in one place leave a plane
        assert!(!is_bent([0.0, 1.0, 2.0, 3.0].map(|at| [at, at, 2.0 * at]).into_iter()));
        assert!(!is_bent([[7.0; 3]; 4].into_iter()));
        for ((a, b, normal), outline) in planes.iter().flat_map(|plane| outlines.iter().map(move |of| (plane, of))) {
            for (offset, scale) in [(0.0, 1.0), (1000.0, 1.0), (-7.0, 1e-6), (3e4, 1e3)] {
                let corners: Vec<[f64; 3]> = outline
                    .iter()
                    .map(|[u, v]| [0, 1, 2].map(|axis| offset + scale * (u * a[axis] + v * b[axis])))
                    .collect();
                assert!(!is_bent(corners.iter().copied()), "{corners:?}");
                for lifted in 0..corners.len() {
                    let mut corners = corners.clone();
                    (0..3).for_each(|axis| corners[lifted][axis] += 0.1 * scale * normal[axis]);
                    assert!(is_bent(corners.iter().copied()), "corner {lifted} of {corners:?}");
                }
            }
        }
    }
}
