//! The certificate by the names of geometries.

use serde::Serialize;

use super::of_geometries::GeometryReport;
use crate::certificate::{Certificate, Overlap, ThinWall};
use crate::lines::Lines;

/// What a mesh may have lost, or decided between geometries.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertificateReport {
    /// Walls of fewer cells are listed.
    pub thin_cells: u32,
    /// Walls that are thin, a geometry and an axis each.
    pub thin_walls: Vec<ThinWallReport>,
    /// Pairs of geometries with common cells.
    pub overlaps: Vec<OverlapReport>,
}

/// Walls of a geometry that are thin along an axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThinWallReport {
    /// Its name.
    pub geometry: String,
    /// "x", "y" or "z".
    pub axis: &'static str,
    /// Thin stretches of rays along this axis.
    pub rays: u64,
    /// Those that hold no centre of a cell: the wall is not in the mesh there, unless it is filled.
    pub lost: u64,
    /// Fewest centres across the wall.
    pub cells: u32,
    /// A place with so few, in world coordinates.
    pub place: [f64; 3],
}

/// Two geometries with common cells.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OverlapReport {
    /// The geometry that wins.
    pub winner: String,
    /// The other.
    pub loser: String,
    /// Cells inside of both.
    pub cells: u64,
    /// Their volume.
    pub volume: f64,
    /// A place inside of both, in world coordinates.
    pub place: [f64; 3],
}

impl CertificateReport {
    /// Names what was found.
    pub fn new(found: &Certificate, geometries: &[GeometryReport], lines: &Lines) -> CertificateReport {
        let name = |geometry: usize| geometries[geometry].name.clone();
        let thin_wall = |&ThinWall { geometry, axis, rays, lost, cells, place }: &ThinWall| ThinWallReport {
            geometry: name(geometry),
            axis: ["x", "y", "z"][axis],
            rays,
            lost,
            cells,
            place,
        };
        let overlap = |&Overlap { geometries: [winner, loser], cells, place }: &Overlap| OverlapReport {
            winner: name(winner),
            loser: name(loser),
            cells,
            volume: cells as f64 * lines.cell_volume(),
            place,
        };
        CertificateReport {
            thin_cells: found.thin_cells,
            thin_walls: found.thin_walls.iter().map(thin_wall).collect(),
            overlaps: found.overlaps.iter().map(overlap).collect(),
        }
    }

    /// A sentence for every thin wall.
    pub fn warnings(&self, lines: &Lines) -> Vec<String> {
        let sentence = |wall: &ThinWallReport| {
            let ThinWallReport { geometry, axis, rays, lost, cells, place } = wall;
            format!(
                "geometry \"{geometry}\" has walls of fewer than {} cells along {axis}: {rays} stretches of rays, {lost} of them without a \
                 cell, the thinnest, of {cells} cells, at {}; use smaller cells, or keep them with fill = \"separating\" or \"conservative\"",
                self.thin_cells,
                lines.text_of(*place)
            )
        };
        self.thin_walls.iter().map(sentence).collect()
    }
}
