//! The cut cells of a mesh.

use crate::fractions::Totals;

/// What a flag has of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct CutFlag {
    /// Index of the cell in the mesh: x + nx (y + ny z).
    pub cell: u64,
    /// The fraction of its volume, 0 to 1.
    pub fraction: f64,
    /// The flag.
    pub flag: u8,
    /// Whether 16 x 16 rays measured the volumes of this cell, as a surface passes through itself there.
    pub is_sampled: bool,
}

/// The surface of a geometry within a cell: its facets, clipped to the cell. What lies in a plane between cells belongs to the cell above.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct CellSurface {
    /// Index of the cell in the mesh: x + nx (y + ny z).
    pub cell: u64,
    /// The geometry, counted from 0 in the job.
    pub geometry: i16,
    /// Area: that of all facets within the cell, also of those within another geometry.
    pub area: f64,
    /// Centre of the area, in cells from the low corner of the cell: 0 to 1 along each axis.
    pub centre: [f64; 3],
    /// Sum of the normals of the facets, which point out of the body, each as long as its area.
    pub area_vector: [f64; 3],
}

impl CellSurface {
    /// The mean of the normals, of length 1; 0 where they cancel.
    pub fn normal(&self) -> [f64; 3] {
        let length = self.area_vector.iter().map(|of| of * of).sum::<f64>().sqrt();
        self.area_vector.map(|of| if length > 1e-9 * self.area { of / length } else { 0.0 })
    }
}

/// What of cut cells is measured besides volumes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CutWanted {
    /// The centre of what each flag has of a cell.
    pub centroids: bool,
    /// Areas of flags on the faces of cut cells.
    pub faces: bool,
    /// The centre of each of these areas.
    pub face_centroids: bool,
    /// Lengths of flags on the edges of cut cells.
    pub edges: bool,
    /// Area, centre and normal of the surface of each geometry in each cell.
    pub surfaces: bool,
}

impl CutWanted {
    /// What of each cell that takes.
    pub(super) fn asked(self) -> Asked {
        let CutWanted { centroids, faces, face_centroids, edges, .. } = self;
        Asked { faces: faces || face_centroids, edges, centroids }
    }
}

/// What of a cell is measured besides its volumes.
#[derive(Clone, Copy)]
pub(super) struct Asked {
    pub(super) faces: bool,
    pub(super) edges: bool,
    /// Else only the first of the integrals over a cell is right.
    pub(super) centroids: bool,
}

/// What each flag has of the cells of a box or window that a surface passes through.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct CutCells {
    /// Number of cells of the mesh on x, y, z.
    pub dims: [u32; 3],
    /// The first cell of the mesh, counted in the box: 0 but for windows, less where a halo begins beyond the box.
    pub origin: [i32; 3],
    /// Cells by planes, so many together.
    #[doc(hidden)]
    pub parts: Vec<CutPart>,
    /// Volume of each flag, 0 to 255, in the box or window: that of whole cells and of fractions.
    pub volumes: Vec<f64>,
    /// Area of the surface of each geometry in the box or window; None where surfaces were not asked for.
    pub areas: Option<Vec<f64>>,
    /// Both before they were rounded.
    #[doc(hidden)]
    pub totals: Totals,
    /// Number of cells that are cut.
    pub n_cells: u64,
    /// Number of these that rays had to measure.
    pub n_sampled: u64,
}

/// What was found in some planes of cells.
#[derive(Debug, Clone, PartialEq, Default)]
#[doc(hidden)]
pub struct CutPart {
    pub flags: Vec<CutFlag>,
    /// For each of these; empty unless asked for, like all that follow.
    pub centroids: Vec<[f64; 3]>,
    pub faces: Vec<[f64; 6]>,
    pub face_centroids: Vec<[[f64; 2]; 6]>,
    pub edges: Vec<[f64; 12]>,
    pub surfaces: Vec<CellSurface>,
    pub(super) n_cells: u64,
}

impl CutPart {
    pub(super) fn n_bytes(&self) -> usize {
        size_of_val(&self.flags[..])
            + size_of_val(&self.centroids[..])
            + size_of_val(&self.faces[..])
            + size_of_val(&self.face_centroids[..])
            + size_of_val(&self.edges[..])
            + size_of_val(&self.surfaces[..])
    }
}

impl CutCells {
    /// What flags have, in the order of cells, then of flags. The fractions of a cell add up to 1, but for rounding. A flag that has a part of a face or an edge alone has 0, where these were
    /// asked for.
    pub fn flags(&self) -> impl Iterator<Item = &CutFlag> + Clone {
        self.parts.iter().flat_map(|part| &part.flags)
    }

    /// For each of [`CutCells::flags`] the centre of what it has, in cells from the low corner: 0.5 where that is nothing.
    pub fn centroids(&self) -> impl Iterator<Item = &[f64; 3]> + Clone {
        self.parts.iter().flat_map(|part| &part.centroids)
    }

    /// For each of [`CutCells::flags`] which fraction of each face of the cell it has: of those below and above along x, then y, then z. A face stands for
    /// what is infinitesimally below it, as a centre does that lies on a surface.
    pub fn faces(&self) -> impl Iterator<Item = &[f64; 6]> + Clone {
        self.parts.iter().flat_map(|part| &part.faces)
    }

    /// For each of [`CutCells::flags`] the centre of what it has of each face, in faces along its two axes, ascending: 0.5 where that is nothing.
    pub fn face_centroids(&self) -> impl Iterator<Item = &[[f64; 2]; 6]> + Clone {
        self.parts.iter().flat_map(|part| &part.face_centroids)
    }

    /// For each of [`CutCells::flags`] which fraction of each edge of the cell it has: 4 along x, then y, then z, each at the low ends of the two other axes, at
    /// the high end of the first of them, at that of the second, and at both.
    pub fn edges(&self) -> impl Iterator<Item = &[f64; 12]> + Clone {
        self.parts.iter().flat_map(|part| &part.edges)
    }

    /// Surfaces within cells, in the order of cells, then of geometries by rank.
    pub fn surfaces(&self) -> impl Iterator<Item = &CellSurface> + Clone {
        self.parts.iter().flat_map(|part| &part.surfaces)
    }

    #[doc(hidden)]
    pub fn n_bytes(&self) -> u64 {
        self.parts.iter().map(|part| part.n_bytes() as u64).sum()
    }
}
