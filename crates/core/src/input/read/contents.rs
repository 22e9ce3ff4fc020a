//! What a file held: solids, counts, warnings; and what both parsers need to count.

use crate::base::error::Error;
use crate::input::geometry::{Facet, SharedFacets};
use crate::input::surface::doubled_area_vector;

/// One `solid` block of an ASCII file, or the whole of a binary one.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Solid {
    /// The name that the file gives, without surrounding spaces; empty where it gives none, as in every binary file.
    pub name: String,
    /// Facets in the order of the file; at least one. The solids of a file are consecutive parts of one list.
    pub facets: SharedFacets,
}

/// Where facets come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// 80 bytes of header, a 32-bit count, 50 bytes a facet, little-endian.
    StlBinary,
    /// Lines of keywords and decimal numbers.
    StlAscii,
    /// Wavefront OBJ: polygons of numbered corners, in groups.
    Obj,
    /// OFF of Geomview: corners, polygons of their indices.
    Off,
    /// PLY with its values as text.
    PlyAscii,
    /// PLY with its values as bytes.
    PlyBinary,
    /// 3MF: an archive of objects that its build places, with a unit.
    ThreeMf,
    /// GLB, the binary form of glTF 2.0: meshes that nodes place.
    Glb,
    /// STEP, a file of CAD: its bodies were converted to triangles.
    Step,
    /// IGES, a file of CAD: its bodies were converted to triangles.
    Iges,
    /// Packed by gzip: the contents have the format of what is packed.
    Gzip,
    /// No file: the caller had the facets in memory.
    Facets,
}

impl Format {
    /// Names the format in reports.
    pub fn name(self) -> &'static str {
        match self {
            Format::StlBinary => "STL, binary",
            Format::StlAscii => "STL, ASCII",
            Format::Obj => "OBJ",
            Format::Off => "OFF",
            Format::PlyAscii => "PLY, ASCII",
            Format::PlyBinary => "PLY, binary",
            Format::ThreeMf => "3MF",
            Format::Glb => "GLB",
            Format::Step => "STEP",
            Format::Iges => "IGES",
            Format::Gzip => "gzip",
            Format::Facets => "facets",
        }
    }
}

/// How a file of CAD became triangles.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Conversion {
    /// Largest distance of the triangles from the surfaces of the file.
    pub deviation: f64,
    /// The program that made them, and its release.
    pub program: String,
}

impl Conversion {
    /// What a program made.
    #[doc(hidden)]
    pub fn new(deviation: f64, program: String) -> Conversion {
        Conversion { deviation, program }
    }
}

/// Everything that a file held.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Contents {
    /// How the file was written.
    pub format: Format,
    /// Its solids in the order of the file; at least one.
    pub solids: Vec<Solid>,
    /// Number of facets of all solids; at least 1.
    pub n_facets: u64,
    /// Length of the file in bytes.
    pub n_bytes: u64,
    /// The unit of its coordinates where the file says it (3MF) or its format does (GLB: "m").
    pub unit: Option<&'static str>,
    /// Number of facets whose normal in the file is non-zero, finite and points against the corners' normal.
    pub wrong_normals: u64,
    /// Number of facets whose normal in the file is zero.
    pub zero_normals: u64,
    /// Number of facets whose corners span no area in f64. They are kept.
    pub zero_area: u64,
    /// Whether a binary file has colours: a `COLOR=` in its header or an attribute word other than 0.
    pub has_colours: bool,
    /// How its triangles were made, of a file of CAD.
    pub conversion: Option<Conversion>,
    /// Sentences about what was accepted although it is not as it should be; at most 16 and one about the rest.
    pub warnings: Vec<String>,
}

/// Counts of what the facets of a file say about its writer.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub(super) wrong_normals: u64,
    pub(super) zero_normals: u64,
    pub(super) zero_area: u64,
}

impl Tally {
    #[inline]
    pub(super) fn count(&mut self, normal: [f32; 3], facet: &Facet) {
        let area = doubled_area_vector(facet);
        let cosine: f64 = (0..3).map(|axis| f64::from(normal[axis]) * area[axis]).sum();
        self.zero_area += u64::from(area == [0.0; 3]);
        self.zero_normals += u64::from(normal == [0.0; 3]);
        // a NaN fails the comparison; an infinite normal is meaningless too
        self.wrong_normals += u64::from(cosine < 0.0 && cosine.is_finite());
    }

    /// Adds that of other facets.
    pub(super) fn add(&mut self, other: &Tally) {
        self.wrong_normals += other.wrong_normals;
        self.zero_normals += other.zero_normals;
        self.zero_area += other.zero_area;
    }
}

/// Warnings, bounded however odd the file is.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    sentences: Vec<String>,
    n_left_out: u64,
}

impl Warnings {
    const MAX: usize = 16;

    pub(super) fn push(&mut self, sentence: String) {
        if self.sentences.len() < Warnings::MAX {
            self.sentences.push(sentence);
        } else {
            self.n_left_out += 1;
        }
    }

    pub(super) fn finish(mut self) -> Vec<String> {
        if self.n_left_out > 0 {
            self.sentences.push(format!("{} more warnings of these kinds", self.n_left_out));
        }
        self.sentences
    }
}

/// What errors of memory call facets, and solids.
pub(super) const FACETS: &str = "its facets";
/// Bytes of a solid without its name and facets, in lists that are made of one another when a file ends.
pub(super) const SOLID_BYTES: u64 = 240;
pub(super) const SOLIDS: &str = "its solids";

/// The error of a file without facets.
pub(super) fn empty(message: &str) -> Error {
    Error::new("stl-empty", message, "export the model again; a mesh needs at least one facet")
}
