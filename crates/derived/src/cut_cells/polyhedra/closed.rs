//! A closed mesh of polyhedra: its faces, volumes, and whether each cell is closed.

use super::planar;
use hexcast_core::base::error::{Error, Result};

/// What is behind a face, seen from the cell that it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Behind {
    /// Another cell, of a higher number.
    Cell(u32),
    /// A side of the box, below and above along x, then y, then z; and the cell there.
    Side(u8, [u32; 3]),
    /// The surface: the flag behind it, and whose facet it is, as in [`Outline::walls`](crate::mesh::outline::Outline::walls).
    Surface(u8, u32),
}

/// A face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    pub(super) start: u32,
    pub(super) n: u32,
    /// The cell that it points out of.
    pub owner: u32,
    /// What it points into.
    pub behind: Behind,
}

/// How many of what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Bodies joined with others.
    pub joined: u32,
    /// Bodies of no volume, which are left out.
    pub empty: u32,
    /// Cells of a wrong shape.
    pub wrong: u32,
}

/// A closed mesh of polyhedra.
#[derive(Debug, Clone, PartialEq)]
pub struct Polyhedra {
    /// In the unit of the lines.
    pub points: Vec<[f64; 3]>,
    /// Those between cells first, by owner, then by what is behind; then all others, by owner.
    pub faces: Vec<Face>,
    pub(super) corners: Vec<u32>,
    /// Number of cells.
    pub n_cells: u32,
    /// What was done to them.
    pub counts: Counts,
}

impl Polyhedra {
    /// The corners of a face, against the clock as seen from outside of its owner: indices of points.
    pub fn corners(&self, face: &Face) -> &[u32] {
        &self.corners[face.start as usize..][..face.n as usize]
    }

    /// Of each cell its volume, and the sum of its outward area vectors.
    pub fn volumes(&self) -> Vec<(f64, [f64; 3])> {
        let mut sums = vec![(0.0, [0.0; 3]); self.n_cells as usize];
        let mut anchors = vec![None; sums.len()];
        for face in &self.faces {
            let corners = self.corners(face);
            let mut add = |cell: u32, sign: f64| {
                // from a corner of the cell: far from the origin differences would be lost
                let anchor: [f64; 3] = *anchors[cell as usize].get_or_insert(self.points[corners[0] as usize]);
                let (of_face, area) = planar::cone(corners.iter().map(|&at| self.points[at as usize]), anchor);
                let (volume, vector) = &mut sums[cell as usize];
                *volume += sign * of_face;
                (0..3).for_each(|axis| vector[axis] += sign * area[axis]);
            };
            add(face.owner, 1.0);
            if let Behind::Cell(other) = face.behind {
                add(other, -1.0);
            }
        }
        sums
    }

    pub(super) fn check_closed(&self) -> Result<()> {
        let mut areas = vec![0.0; self.n_cells as usize];
        for face in &self.faces {
            let corners = self.corners(face).iter().map(|&at| self.points[at as usize]);
            let (_, area) = planar::cone(corners, [0.0; 3]);
            let length = planar::dot(area, area).sqrt();
            areas[face.owner as usize] += length;
            if let Behind::Cell(other) = face.behind {
                areas[other as usize] += length;
            }
        }
        for (cell, ((volume, vector), area)) in self.volumes().into_iter().zip(areas).enumerate() {
            let off = planar::dot(vector, vector).sqrt();
            let is_closed = off <= 1e-9 * area;
            if !is_closed {
                let message = format!("cut cell {cell} of volume {volume:e} is open by an area of {off:e}");
                return Err(Error::new(
                    "cut-open",
                    message,
                    "this is an error of hexcast: please report it; leave out cut",
                ));
            }
        }
        Ok(())
    }
}
