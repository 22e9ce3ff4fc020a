//! A geometry: named facets with a property flag, a priority and a position in the world.
//!
//! Input: the facets of one or several solids of a file -> output: [`Geometry`], the first value of the pipeline.
//! The corners stay the f32 numbers of the file; the transform is applied in f64 where they are used, so that equal
//! f32 corners stay equal and a closed surface stays closed.

use crate::base::control::{Control, at_once};
use crate::base::error::{Error, Result};

mod facets;
mod measures;

use facets::Measures;
pub use facets::{Chunks, Facet, SharedFacets};
pub(crate) use facets::{InFile, READ_AT_ONCE};
pub use hexcast_job::input::choices::material::Material;
pub use hexcast_job::input::choices::placing::Placing;
pub use hexcast_job::input::choices::{Fill, MAX_GEOMETRIES, Open, Sizing};
use measures::measures;

/// Most names that are joined.
const MAX_NAMES: usize = 64;

/// The name of a flag: those of its geometries, joined by " + "; of very many the first, and the number of the others.
#[doc(hidden)]
pub fn joined_names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut names = names.fuse();
    let first: Vec<&str> = names.by_ref().take(MAX_NAMES).collect();
    match names.count() {
        0 => first.join(" + "),
        n_more => format!("{} + {n_more} more", first.join(" + ")),
    }
}

/// A surface that bounds one substance.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Geometry {
    /// Name in reports and outputs.
    pub name: String,
    /// Property flag of its cells, 1 to 255 (0 is the background).
    pub flag: u8,
    /// Whether nobody chose the flag: it is the position in the job.
    pub has_default_flag: bool,
    /// Where geometries overlap the higher priority wins; at equal priority a geometry that is closed or flat over one that is not, else the later.
    pub priority: i32,
    /// How cells are decided where the surface is not closed.
    pub open: Open,
    /// Which cells along the surface it has as well.
    pub fill: Fill,
    /// Whether it has those along the surface only, and none for being inside.
    pub shell: bool,
    /// Whether its cells are those outside of it in place of those inside.
    pub invert: bool,
    /// How lines are generated around it.
    pub sizing: Sizing,
    /// What it is made of, for outputs.
    pub material: Material,
    /// Facets in file coordinates, shared with the file that they came from.
    pub facets: SharedFacets,
    /// Where facets are in their file, if not all of its facets are these: a first index in `facets` and the index of that facet in
    /// the file, from 0, for each stretch of the file.
    pub pieces_in_file: Vec<[u64; 2]>,
    /// The solids that it is made of, in their order: the first facet of each, and its name. Empty where its file has one, or it is one of several.
    pub solids: Vec<(u64, String)>,
    /// Places file coordinates in the world: `world = world_from_file * file`.
    pub world_from_file: Placing,
    /// Index of the job's entry that it is of: one entry may name several geometries.
    pub entry: usize,
}

impl Geometry {
    /// Builds a geometry of priority 0, not transformed.
    ///
    /// # Errors
    /// `job-value` for flag 0, which is the background; `stl-not-finite` where a coordinate is NaN or infinite.
    pub fn new(name: impl Into<String>, flag: u8, facets: impl Into<SharedFacets>) -> Result<Geometry> {
        let (name, facets) = (name.into(), facets.into());
        if flag == 0 {
            let message = format!("geometry \"{name}\" has flag 0, which is that of the background");
            return Err(Error::new("job-value", message, "give it a flag from 1 to 255"));
        }
        facets.check_finite(&name)?;
        Ok(Geometry {
            name,
            flag,
            has_default_flag: false,
            priority: 0,
            open: Open::default(),
            fill: Fill::default(),
            shell: false,
            invert: false,
            sizing: Sizing::default(),
            material: Material::default(),
            facets,
            pieces_in_file: Vec::new(),
            solids: Vec::new(),
            world_from_file: Placing::default(),
            entry: 0,
        })
    }

    /// Whether it has the cells whose centres its surface encloses.
    #[doc(hidden)]
    pub fn is_plain(&self) -> bool {
        self.fill == Fill::Centre && !self.shell && !self.invert
    }

    /// Index in `solids` of that of a facet; 0 where there are none.
    pub fn solid_of(&self, facet: u64) -> usize {
        self.solids.partition_point(|(first, _)| *first <= facet).saturating_sub(1)
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
    #[doc(hidden)]
    pub fn placing(&self) -> impl Fn([f32; 3]) -> [f64; 3] + Sync + use<> {
        self.world_from_file.of_corners()
    }

    /// Least and greatest world coordinates, or None without facets.
    pub fn bounding_box(&self) -> Option<[[f64; 3]; 2]> {
        self.measures().ends
    }

    /// Signed volume by the divergence theorem, relative to the centre of the bounding box, in cubed file units.
    ///
    /// Exact up to f64 rounding for closed surfaces; positive where normals (right-hand rule, in the file) point outwards; for
    /// surfaces that are not closed the number depends on the reference point.
    pub fn signed_volume(&self) -> f64 {
        self.measures().signed_volume
    }

    fn measures(&self) -> Measures {
        // nothing cancels it, and what stays in its file was measured before
        let measured = || at_once(self.measured(&Control::default())).unwrap_or_default();
        self.facets.kept(self.world_from_file).unwrap_or_else(measured)
    }

    /// Measures it, and keeps what was found, for whoever asks next.
    ///
    /// # Errors
    /// `cancelled`; `io` where its facets stay in their file, and that cannot be read again.
    #[doc(hidden)]
    pub async fn measured(&self, control: &Control) -> Result<Measures> {
        let measures = measures(&self.facets, self.world_from_file, control).await?;
        self.facets.keep(self.world_from_file, measures);
        Ok(measures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_has_a_sixth_of_a_cube() {
        let [o, x, y, z] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let facets = vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]];
        let geometry = Geometry::new("tetrahedron", 1, facets).unwrap();
        assert!((geometry.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
        assert_eq!(geometry.bounding_box(), Some([[0.0; 3], [1.0; 3]]));
        let mut mirrored = geometry.clone();
        mirrored.world_from_file = Placing::of_numbers([-2.0, 1.0, 1.0], [0.0; 3], [0.0; 3]);
        assert!((mirrored.signed_volume() - 2.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn flag_0_and_corners_that_are_not_finite_are_errors() {
        let facet = |z: f32| vec![[[0.0, 0.0, z], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
        assert!(Geometry::new("body", 255, facet(1.0)).is_ok());
        assert_eq!(Geometry::new("body", 0, facet(1.0)).unwrap_err().code(), "job-value");
        for z in [f32::NAN, f32::INFINITY] {
            assert_eq!(Geometry::new("body", 1, facet(z)).unwrap_err().code(), "stl-not-finite");
        }
    }

    #[test]
    fn what_was_measured_of_facets_is_that_of_their_placing_and_their_part() {
        let facets: Vec<Facet> =
            (0..7u8).map(|n| [[0.0; 3], [f32::from(n), 0.0, 1.0], [0.0, 2.0, f32::from(n)]]).collect();
        let parts = SharedFacets::cut(facets.clone(), &[0, 3]);
        let placings = [Placing::default(), Placing::of_numbers([2.0; 3], [0.0, 0.0, 30.0], [1.0; 3])];
        for _ in 0..2 {
            for part in [&parts[0], &parts[1], &SharedFacets::join(&parts)] {
                for placing in placings {
                    let of = |facets: SharedFacets| {
                        let geometry = Geometry { world_from_file: placing, ..Geometry::new("g", 1, facets).unwrap() };
                        (geometry.bounding_box(), geometry.signed_volume())
                    };
                    assert_eq!(of(part.clone()), of(part.slice().to_vec().into()));
                }
            }
        }
        let other = Geometry { world_from_file: placings[1], ..Geometry::new("g", 1, parts[1].clone()).unwrap() };
        assert_eq!(other.facets.kept(placings[1]).unwrap().ends, other.bounding_box());
        assert_eq!(Geometry::new("g", 1, SharedFacets::default()).unwrap().bounding_box(), None);
    }
}
