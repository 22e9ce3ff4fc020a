//! A geometry: named facets with a property flag, a priority and a position in the world.
//!
//! Input: the facets of one or several solids of a file -> output: [`Geometry`], the first noun of the line.
//! The corners stay the f32 numbers of the file; the transform is applied in f64 where they are used, so that equal
//! f32 corners stay equal and a closed surface stays closed.

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};

mod facets;

pub use facets::{Facet, SharedFacets};

/// How the cells of a geometry are decided whose surface is not closed. One that is closed is not affected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Open {
    /// By the rays of three axes where they agree, elsewhere by the generalised winding number.
    #[default]
    Winding,
    /// By most of the three axes whose rays cross it an even number of times: for surfaces that cannot be oriented.
    Vote,
    /// Not at all: an error.
    Error,
    /// By the rays of one axis, up to the last matched pair of crossings of each.
    Parity,
}

/// Which cells a geometry has besides those whose centres lie inside of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Fill {
    /// None.
    #[default]
    Centre,
    /// Every cell whose box the surface touches.
    Conservative,
    /// The cells that separate the two sides of the surface: no path from face neighbour to face neighbour leads through it.
    Separating,
}

impl Fill {
    /// Its name in jobs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Fill::Centre => "centre",
            Fill::Conservative => "conservative",
            Fill::Separating => "separating",
        }
    }
}

/// A surface that bounds one substance.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// Name in reports and outputs.
    pub name: String,
    /// Property flag of its cells, 1 to 255 (0 is the background).
    pub flag: u8,
    /// Whether nobody chose the flag: it is the position in the job.
    pub has_default_flag: bool,
    /// Where geometries overlap the higher priority wins; at equal priority the later geometry.
    pub priority: i32,
    /// How cells are decided where the surface is not closed.
    pub open: Open,
    /// Which cells along the surface it has as well.
    pub fill: Fill,
    /// Whether it has those along the surface only, and none for being inside.
    pub shell: bool,
    /// Whether its cells are those outside of it in place of those inside.
    pub invert: bool,
    /// Facets in file coordinates, shared with the file that they came from.
    pub facets: SharedFacets,
    /// Where facets are in their file, if not all of its facets are these: a first index in `facets` and the index of that facet in
    /// the file, from 0, for each stretch of the file.
    pub pieces_in_file: Vec<[u64; 2]>,
    /// Places file coordinates in the world: `world = world_from_file * file`.
    pub world_from_file: DAffine3,
}

impl Geometry {
    /// Builds a geometry of priority 0, not transformed.
    pub fn new(name: impl Into<String>, flag: u8, facets: impl Into<SharedFacets>) -> Geometry {
        Geometry {
            name: name.into(),
            flag,
            has_default_flag: false,
            priority: 0,
            open: Open::default(),
            fill: Fill::default(),
            shell: false,
            invert: false,
            facets: facets.into(),
            pieces_in_file: Vec::new(),
            world_from_file: DAffine3::IDENTITY,
        }
    }

    /// Index in its file, from 0, of a facet.
    pub fn facet_in_file(&self, facet: usize) -> u64 {
        let facet = facet as u64;
        let after = self.pieces_in_file.partition_point(|[first, _]| *first <= facet);
        after
            .checked_sub(1)
            .map_or(facet, |piece| facet - self.pieces_in_file[piece][0] + self.pieces_in_file[piece][1])
    }

    /// Returns the function from a corner to its world coordinates, in the unit of the file. The identity transform returns the
    /// file's number exactly.
    pub(crate) fn placing(&self) -> impl Fn([f32; 3]) -> [f64; 3] + Sync {
        let (place, stays) = (self.world_from_file, self.world_from_file == DAffine3::IDENTITY);
        move |corner| {
            let file = [f64::from(corner[0]), f64::from(corner[1]), f64::from(corner[2])];
            if stays { file } else { place.transform_point3(file.into()).to_array() }
        }
    }

    /// Least and greatest world coordinates, or None without facets.
    pub fn bounding_box(&self) -> Option<[[f64; 3]; 2]> {
        if self.facets.is_empty() {
            return None;
        }
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        let placing = self.placing();
        for corner in self.facets.as_flattened() {
            let world = placing(*corner);
            for axis in 0..3 {
                low[axis] = low[axis].min(world[axis]);
                high[axis] = high[axis].max(world[axis]);
            }
        }
        Some([low, high])
    }

    /// Signed volume by the divergence theorem, relative to the centre of the bounding box, in cubed file units.
    ///
    /// Exact up to f64 rounding for closed surfaces; positive where normals (right-hand rule, in the file) point outwards; for
    /// surfaces that are not closed the number depends on the reference point.
    pub fn signed_volume(&self) -> f64 {
        let Some([low, high]) = self.bounding_box() else { return 0.0 };
        let centre = (DVec3::from(low) + DVec3::from(high)) * 0.5;
        let placing = self.placing();
        let corner = |c: [f32; 3]| DVec3::from(placing(c)) - centre;
        let six_volumes: f64 =
            self.facets.iter().map(|facet| corner(facet[0]).dot(corner(facet[1]).cross(corner(facet[2])))).sum();
        // a mirrored surface has its normals inwards by the order of its corners alone
        (six_volumes / 6.0).copysign(six_volumes * self.world_from_file.matrix3.determinant())
    }
}

/// Builds the placing of a geometry: first scale, then rotate by degrees about x, y and z in this order, then translate.
///
/// Sines and cosines do not come from the platform, so that every machine snaps to the same bits; multiples of 90 degrees are
/// exact.
pub fn world_from_file(scale: [f64; 3], rotate_degrees: [f64; 3], translate: [f64; 3]) -> DAffine3 {
    let [x, y, z] = rotate_degrees.map(sine_cosine_of_degrees);
    let about_x = DMat3::from_cols_array_2d(&[[1.0, 0.0, 0.0], [0.0, x.1, x.0], [0.0, -x.0, x.1]]);
    let about_y = DMat3::from_cols_array_2d(&[[y.1, 0.0, -y.0], [0.0, 1.0, 0.0], [y.0, 0.0, y.1]]);
    let about_z = DMat3::from_cols_array_2d(&[[z.1, z.0, 0.0], [-z.0, z.1, 0.0], [0.0, 0.0, 1.0]]);
    let rotation = about_z * about_y * about_x;
    DAffine3::from_mat3_translation(rotation * DMat3::from_diagonal(DVec3::from(scale)), DVec3::from(translate))
}

/// Sine and cosine. What is left of whole quarter turns, at most 45 degrees, is exact, and `libm` does the rest: FDLIBM in Rust,
/// which has the same bits on every target. Off by less than an ulp or so.
fn sine_cosine_of_degrees(degrees: f64) -> (f64, f64) {
    // exact for any angle
    let degrees = degrees % 360.0;
    let quarter_turns = libm::rint(degrees / 90.0);
    let (sine, cosine) = libm::sincos((degrees - 90.0 * quarter_turns).to_radians());
    match quarter_turns.rem_euclid(4.0) as u8 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_cosines_are_those_of_libm() {
        for step in -9000..9000 {
            let degrees = f64::from(step) * 0.123;
            let (sine, cosine) = sine_cosine_of_degrees(degrees);
            let expected = libm::sincos((degrees % 360.0).to_radians());
            // radians of several turns are off by more than ours
            assert!((sine - expected.0).abs() < 1e-15 && (cosine - expected.1).abs() < 1e-15, "{degrees}");
            assert!((sine * sine + cosine * cosine - 1.0).abs() < 4e-16, "{degrees}");
        }
        assert_eq!(sine_cosine_of_degrees(720.0), (0.0, 1.0));
        // of -280 degrees, from a table
        let (sine, cosine) = sine_cosine_of_degrees(-1e9);
        assert!((sine - 0.984_807_753_012_208_1).abs() < 2e-16 && (cosine - 0.173_648_177_666_930_35).abs() < 5e-17);
        assert!(sine_cosine_of_degrees(f64::INFINITY).0.is_nan());
    }

    #[test]
    fn quarter_turns_are_exact_and_follow_the_right_hand_rule() {
        let turn = world_from_file([1.0; 3], [0.0, 0.0, 90.0], [0.0; 3]);
        assert_eq!(turn.transform_point3(DVec3::new(1.0, 0.0, 0.0)).to_array(), [0.0, 1.0, 0.0]);
        let turn = world_from_file([1.0; 3], [-270.0, 0.0, 0.0], [0.0; 3]);
        assert_eq!(turn.transform_point3(DVec3::new(0.0, 1.0, 0.0)).to_array(), [0.0, 0.0, 1.0]);
        let turn = world_from_file([1.0; 3], [0.0, 450.0, 0.0], [0.0; 3]);
        assert_eq!(turn.transform_point3(DVec3::new(0.0, 0.0, 1.0)).to_array(), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn scale_then_rotate_then_translate() {
        let place = world_from_file([2.0, 1.0, 1.0], [0.0, 0.0, 90.0], [10.0, 0.0, 0.0]);
        assert_eq!(place.transform_point3(DVec3::new(1.0, 0.0, 0.0)).to_array(), [10.0, 2.0, 0.0]);
    }

    #[test]
    fn a_tetrahedron_has_a_sixth_of_a_cube() {
        let [o, x, y, z] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let facets = vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]];
        let geometry = Geometry::new("tetrahedron", 1, facets);
        assert!((geometry.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
        assert_eq!(geometry.bounding_box(), Some([[0.0; 3], [1.0; 3]]));
        let mut mirrored = geometry.clone();
        mirrored.world_from_file = world_from_file([-2.0, 1.0, 1.0], [0.0; 3], [0.0; 3]);
        assert!((mirrored.signed_volume() - 2.0 / 6.0).abs() < 1e-15);
    }
}
