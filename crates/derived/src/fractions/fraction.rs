//! The fractions of a mesh.

use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::totals::Total;

/// The fraction of a cell that a flag has.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Fraction {
    /// Index of the cell in the mesh: x + nx (y + ny z).
    pub cell: u64,
    /// The fraction, 0 to 1: 1 where no ray meets what cuts the cell or a face alone has another flag, 0 where the flag has a part of a face alone.
    pub fraction: f32,
    /// The flag.
    pub flag: u8,
}

/// The surface of a geometry within a cell: its facets, clipped to the cell. What lies in a plane between cells belongs to the cell below.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct CutSurface {
    /// Index of the cell in the mesh: x + nx (y + ny z).
    pub cell: u64,
    /// The geometry, counted from 0 in the job.
    pub geometry: i16,
    /// Area: that of all facets within the cell, also of those within another geometry.
    pub area: f32,
    /// Centre of the area, in cells from the low corner of the cell: 0 to 1 along each axis.
    pub point: [f32; 3],
    /// Mean of the normals of the facets by area, which point out of the body, of length 1; 0 where they cancel.
    pub normal: [f32; 3],
}

/// The fractions of flags in all cells that are cut, of a box or of a window: in those with more than one flag, and in those that a surface passes through
/// where no ray meets it. With faces also in those that have a face with another flag.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fractions {
    /// m: a cell has m x m rays; 0 where cells were measured exactly.
    pub rays: u32,
    /// Number of cells of the mesh on x, y, z.
    pub dims: [u32; 3],
    /// The first cell of the mesh, counted in the box: 0 but for windows, less where a halo begins beyond the box.
    pub origin: [i32; 3],
    /// Cells of the mesh before and behind those that are measured, along each axis.
    pub halo: u32,
    /// Cells by rows of so many planes each, but the last.
    #[doc(hidden)]
    pub parts: Vec<Part>,
    pub(crate) planes_of_part: u32,
    /// Volume of each flag, 0 to 255, in the box or window: that of whole cells and of fractions.
    pub volumes: Vec<f64>,
    /// Area of the surface of each geometry in the box or window; None where surfaces were not asked for.
    pub areas: Option<Vec<f64>>,
    /// Both before they were rounded.
    #[doc(hidden)]
    pub totals: Totals,
    /// Whether faces were asked for.
    pub has_faces: bool,
    /// Whether edges were.
    pub has_edges: bool,
    /// Whether centroids were.
    pub has_centroids: bool,
    /// Number of cells that 16 x 16 rays measured where the others are exact, as a surface passes through itself there.
    pub sampled_cells: u64,
}

/// Volumes of flags and areas of geometries in the units of the box.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Totals {
    /// Of every flag.
    pub volumes: Vec<Total>,
    /// Of every geometry; empty where surfaces were not asked for.
    pub areas: Vec<Total>,
}

/// A part of a cell, less than all of it, as 32 bits: rounded, it may be that of a whole cell.
#[inline]
pub(crate) fn rounded_part(of: f64) -> f32 {
    (of as f32).min(1.0 - f32::EPSILON / 2.0)
}

/// What was found in some rows of cells.
#[derive(Debug, Clone, PartialEq, Default)]
#[doc(hidden)]
pub struct Part {
    #[doc(hidden)]
    pub fractions: Vec<Fraction>,
    /// For each fraction; empty unless asked for.
    #[doc(hidden)]
    pub faces: Vec<[f32; 6]>,
    #[doc(hidden)]
    pub edges: Vec<[f32; 12]>,
    #[doc(hidden)]
    pub centroids: Vec<[f32; 3]>,
    #[doc(hidden)]
    pub face_centroids: Vec<[[f32; 2]; 6]>,
    #[doc(hidden)]
    pub surfaces: Vec<CutSurface>,
    /// Number of cells that are cut.
    pub(crate) n_cut: u64,
}

impl Part {
    pub(crate) fn n_bytes(&self) -> usize {
        let Part { fractions, faces, edges, centroids, face_centroids, surfaces, .. } = self;
        size_of_val(&fractions[..])
            + size_of_val(&faces[..])
            + size_of_val(&edges[..])
            + size_of_val(&centroids[..])
            + size_of_val(&face_centroids[..])
            + size_of_val(&surfaces[..])
    }
}

impl Fractions {
    /// Fractions that were kept as cells, flags and numbers, to write them: without faces, surfaces, volumes and areas.
    ///
    /// # Errors
    /// `job-value` where a cell is not in the mesh, or comes after one with a higher index.
    pub fn of_cells(
        rays: u32,
        (dims, halo): ([u32; 3], u32),
        cells: impl Iterator<Item = (u64, u8, f32)>,
    ) -> Result<Fractions> {
        let n_cells = dims.iter().map(|&n| u64::from(n)).product();
        let fractions: Vec<Fraction> = cells.map(|(cell, flag, fraction)| Fraction { cell, fraction, flag }).collect();
        if !fractions.is_sorted_by_key(|one| one.cell) || fractions.last().is_some_and(|last| last.cell >= n_cells) {
            let message = format!("the cells of fractions are not in order, or not below the {n_cells} of the mesh");
            return Err(Error::new("job-value", message, "hand over those of the mesh"));
        }
        let part = Part { fractions, ..Part::default() };
        Ok(Fractions {
            rays,
            dims,
            origin: [0; 3],
            halo,
            parts: vec![part],
            planes_of_part: u32::MAX,
            volumes: Vec::new(),
            areas: None,
            totals: Totals::default(),
            has_faces: false,
            has_edges: false,
            has_centroids: false,
            sampled_cells: 0,
        })
    }

    /// The fractions, in the order of cells, then of flags. Those of a cell add up to 1, but for rounding.
    pub fn iter(&self) -> impl Iterator<Item = &Fraction> + Clone {
        self.parts.iter().flat_map(|part| &part.fractions)
    }

    /// The fractions of a cell and of those after it.
    pub fn from_cell(&self, cell: u64) -> impl Iterator<Item = &Fraction> + Clone {
        let [nx, ny, _] = self.dims.map(u64::from);
        let plane = (cell / (nx * ny).max(1)).saturating_sub(self.halo.into());
        let part = plane / u64::from(self.planes_of_part);
        let mut parts = self.parts[self.parts.len().min(part as usize)..].iter();
        let first = parts
            .next()
            .map_or(&[][..], |part| &part.fractions[part.fractions.partition_point(|fraction| fraction.cell < cell)..]);
        first.iter().chain(parts.flat_map(|part| &part.fractions))
    }

    /// For each of [`Fractions::iter`] which fraction of each face of the cell its flag has, 0 to 1: of the faces below and above along x, then y, then
    /// z. None where faces were not asked for.
    pub fn faces(&self) -> impl Iterator<Item = &[f32; 6]> + Clone {
        self.parts.iter().flat_map(|part| &part.faces)
    }

    /// For each of [`Fractions::iter`] which fraction of each edge of the cell its flag has, 0 to 1: of the four along x, then y, then z; of an axis those
    /// at the low and low, high and low, low and high, high and high end of the two other axes. None where edges were not asked for.
    pub fn edges(&self) -> impl Iterator<Item = &[f32; 12]> + Clone {
        self.parts.iter().flat_map(|part| &part.edges)
    }

    /// For each of [`Fractions::iter`] the centre of what its flag has of the cell, in cells from the low corner: 0 to 1 along each axis; the middle where
    /// it has none. None where centroids were not asked for.
    pub fn centroids(&self) -> impl Iterator<Item = &[f32; 3]> + Clone {
        self.parts.iter().flat_map(|part| &part.centroids)
    }

    /// The same of each face, along its two axes in their order. None where faces or centroids were not asked for.
    pub fn face_centroids(&self) -> impl Iterator<Item = &[[f32; 2]; 6]> + Clone {
        self.parts.iter().flat_map(|part| &part.face_centroids)
    }

    /// Surfaces within cells, in the order of cells, then of geometries by rank; none where they were not asked for.
    pub fn surfaces(&self) -> impl Iterator<Item = &CutSurface> + Clone {
        self.parts.iter().flat_map(|part| &part.surfaces)
    }

    /// Number of fractions.
    pub fn len(&self) -> usize {
        self.parts.iter().map(|part| part.fractions.len()).sum()
    }

    #[doc(hidden)]
    pub fn n_bytes(&self) -> u64 {
        self.parts.iter().map(|part| part.n_bytes() as u64).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of cells that are cut.
    #[doc(hidden)]
    pub fn n_cells(&self) -> u64 {
        self.parts.iter().map(|part| part.n_cut).sum()
    }
}
