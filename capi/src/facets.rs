//! Surfaces in memory of the caller's: corners of facets, or vertices and the triangles that choose from them.

use std::ffi::c_char;

use hexcast::control::Control;
use hexcast::files::read_geometry;
use hexcast::geometry::Facet;
use hexcast::job::{GeometryJob, Job};
use hexcast::sources::Source;
use hexcast::{Error, Result};

use crate::border::{array, text};

/// Facets in memory, which a job uses in place of a file: `corners`, or `vertices` and one of `triangles` and `triangles64`; the others
/// are NULL. hexcast_mesh copies them: they may be freed or changed when it returns. Lengths are in the unit of the job. Normals point
/// outwards where corners are counter-clockwise seen from outside.
#[repr(C)]
pub struct HexcastFacets {
    /// The name of the file in the job.
    pub file: *const c_char,
    /// x, y and z of the three corners of each facet: 9 * n_facets numbers. NULL where there are vertices.
    pub corners: *const f32,
    /// Number of facets.
    pub n_facets: usize,
    /// x, y and z of each vertex: 3 * n_vertices numbers, each rounded to the nearest float, as all that hexcast meshes. Where coordinates are
    /// large against the cells, as those of maps, subtract an origin before.
    pub vertices: *const f64,
    /// Number of vertices.
    pub n_vertices: usize,
    /// The three vertices of each facet, counted from 0: 3 * n_facets numbers.
    pub triangles: *const u32,
    /// The same in 64 bits.
    pub triangles64: *const u64,
}

impl HexcastFacets {
    /// Copies the facets.
    ///
    /// # Safety
    /// `corners`, `vertices`, `triangles` and `triangles64` are NULL or have as many numbers as they say.
    unsafe fn facets(&self, file: &str) -> Result<Vec<Facet>> {
        let n_numbers = self.n_facets.saturating_mul(3);
        if self.vertices.is_null() && self.triangles.is_null() && self.triangles64.is_null() {
            // SAFETY: the caller of this function vouches for it
            let corners = unsafe { array(self.corners, n_numbers.saturating_mul(3), "the corners of facets") }?;
            return Ok(corners.as_chunks::<3>().0.as_chunks::<3>().0.to_vec());
        }
        let n_lists = [self.triangles.is_null(), self.triangles64.is_null()].iter().filter(|is_null| !*is_null).count();
        if !self.corners.is_null() || n_lists != 1 {
            let message = format!("facets \"{file}\" have {}", self.given());
            let hint = "give corners alone, or vertices and one of triangles and triangles64, and NULL for the others";
            return Err(Error::new("job-conflict", message, hint));
        }
        // SAFETY: the caller of this function vouches for it
        let vertices = unsafe { array(self.vertices, self.n_vertices.saturating_mul(3), "the vertices of facets") }?;
        let vertices = Vertices { file, of: vertices.as_chunks::<3>().0 };
        if self.triangles64.is_null() {
            // SAFETY: as above
            let triangles = unsafe { array(self.triangles, n_numbers, "the triangles of facets") }?;
            return vertices.chosen(triangles, |&index| index as usize);
        }
        // SAFETY: as above
        let triangles = unsafe { array(self.triangles64, n_numbers, "the triangles of facets") }?;
        vertices.chosen(triangles, |&index| usize::try_from(index).unwrap_or(usize::MAX))
    }

    /// Which of its arrays are given.
    fn given(&self) -> String {
        let arrays = [
            ("corners", self.corners.is_null()),
            ("vertices", self.vertices.is_null()),
            ("triangles", self.triangles.is_null()),
            ("triangles64", self.triangles64.is_null()),
        ];
        let given: Vec<&str> = arrays.iter().filter(|(_, is_null)| !is_null).map(|(name, _)| *name).collect();
        given.join(" and ")
    }
}

/// The vertices of named facets.
struct Vertices<'a> {
    file: &'a str,
    of: &'a [[f64; 3]],
}

impl Vertices<'_> {
    /// The facets that triples of indices choose.
    fn chosen<T>(&self, triangles: &[T], index: impl Fn(&T) -> usize) -> Result<Vec<Facet>> {
        let corner = |number: usize, index: usize| {
            let Some(vertex) = self.of.get(index) else {
                let message = format!("{}: facet {number} has vertex {index} of {}", self.file, self.of.len());
                return Err(Error::new(
                    "job-value",
                    message,
                    "give indices from 0 to the number of vertices, exclusive",
                ));
            };
            self.rounded(index, vertex)
        };
        let facet = |(number, triangle): (usize, &[T; 3])| {
            let [a, b, c] = triangle.each_ref().map(|of| corner(number, index(of)));
            Ok([a?, b?, c?])
        };
        triangles.as_chunks::<3>().0.iter().enumerate().map(facet).collect()
    }

    /// A vertex in the numbers of facets.
    fn rounded(&self, index: usize, vertex: &[f64; 3]) -> Result<[f32; 3]> {
        let rounded = vertex.map(|of| of as f32);
        if vertex.iter().zip(rounded).any(|(of, rounded)| of.is_finite() && !rounded.is_finite()) {
            let message = format!("{}: vertex {index} is {vertex:?}, and a float ends at {:e}", self.file, f32::MAX);
            return Err(Error::new("stl-not-finite", message, "choose a larger unit of length"));
        }
        Ok(rounded)
    }
}

/// Reads a job, which is JSON, with its surfaces.
///
/// # Safety
/// `job` is NULL or a text; `facets` is NULL or points to so many facets, for which [`sources`] says what must be so.
pub(crate) unsafe fn job_with_sources(
    job: *const c_char,
    (facets, n_facets): (*const HexcastFacets, usize),
    known: &[Source],
) -> Result<(Job, Vec<Source>)> {
    // SAFETY: the caller of this function vouches for both
    let (job, facets) = unsafe { (text(job, "the job")?, array(facets, n_facets, "facets")?) };
    let job = Job::from_plain_json(job)?;
    // SAFETY: the caller of this function vouches for what the facets point to
    let sources = unsafe { sources(&job, facets, known) }?;
    Ok((job, sources))
}

/// The surfaces of a job, by their names: those in memory, else known ones, else from disk.
///
/// # Safety
/// Every `file` is a text, and the arrays of every surface are as it says.
unsafe fn sources(job: &Job, facets: &[HexcastFacets], known: &[Source]) -> Result<Vec<Source>> {
    let mut in_memory = Vec::new();
    for some in facets {
        // SAFETY: the caller of this function vouches for it
        let file = unsafe { text(some.file, "the name of facets") }?;
        if !job.geometries.iter().any(|geometry| geometry.file == file) {
            let message = format!("there are facets named \"{file}\", but the job has no such file");
            return Err(Error::new("job-value", message, "give them the name of a file of the job"));
        }
        // SAFETY: the caller of this function vouches for it
        in_memory.push(Source::from_facets(file, unsafe { some.facets(file) }?)?);
    }
    let source = |(index, entry): (usize, &GeometryJob)| match in_memory
        .iter()
        .chain(known)
        .find(|source| source.file == entry.file)
    {
        Some(source) => Ok(source.clone()),
        None => read_geometry(job, index, &Control::default()),
    };
    job.geometries.iter().enumerate().map(source).collect()
}
