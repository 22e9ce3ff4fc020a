//! The certificate by the names of geometries.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use super::of_geometries::GeometryReport;
pub use hexcast_core::base::finding::AxisName;
use hexcast_core::base::finding::Finding;
use hexcast_core::cells::columns::Named;
use hexcast_core::grid::lines::Lines;
use hexcast_derived::certificate::{Certificate, FlagGap, Overlap, ThinWall};

/// What a mesh may have lost, or decided between geometries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CertificateReport {
    /// Walls of fewer cells are listed.
    pub thin_cells: u32,
    /// Walls that are thin, a geometry and an axis each.
    pub thin_walls: Vec<ThinWallReport>,
    /// Pairs of geometries with common cells.
    pub overlaps: Vec<OverlapReport>,
    /// Gaps of one cell between flags, a pair and an axis each.
    pub gaps: Vec<GapReport>,
}

/// Walls of a geometry that are thin along an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ThinWallReport {
    /// Its name.
    pub geometry: String,
    /// "x", "y" or "z".
    #[serde(deserialize_with = "axis_name")]
    pub axis: AxisName,
    /// Thin ray segments along this axis.
    pub rays: u64,
    /// Those that hold no centre of a cell: the wall is not in the mesh there, unless it is filled.
    pub lost: u64,
    /// Fewest centres across the wall.
    pub cells: u32,
    /// A place with so few, in world coordinates.
    pub place: [f64; 3],
    /// Index of the geometry in `geometries`, from 0.
    pub index: usize,
}

/// Two geometries with common cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OverlapReport {
    /// The geometry that wins.
    pub winner: String,
    /// The other.
    pub loser: String,
    /// Cells inside of both.
    pub cells: u64,
    /// Their volume.
    pub volume: f64,
    /// A place inside of both, in world coordinates: the middle of the longest stretch of a ray.
    pub place: [f64; 3],
    /// Cells of the longest stretch of a ray inside of both; 0 in a window in which none begins.
    pub longest: u32,
    /// Indices of winner and loser in `geometries`, from 0.
    pub indices: [usize; 2],
}

/// Background cells with one flag before them and another behind, along an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GapReport {
    /// The two flags, ascending.
    pub flags: [u8; 2],
    /// Their names.
    pub names: [String; 2],
    /// "x", "y" or "z".
    #[serde(deserialize_with = "axis_name")]
    pub axis: AxisName,
    /// Number of cells.
    pub cells: u64,
    /// Centre of one of them, in world coordinates: of the least z, of these of the least y, of these of the least x.
    pub place: [f64; 3],
    /// Corners of the box around all of them, in world coordinates.
    pub bounds: [[f64; 3]; 2],
}

const AXES: [&str; 3] = ["x", "y", "z"];

fn axis_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<AxisName, D::Error> {
    let name = String::deserialize(deserializer)?;
    AXES.into_iter().find(|axis| *axis == name).ok_or_else(|| D::Error::custom(format!("\"{name}\" is not x, y or z")))
}

impl CertificateReport {
    /// Names what was found.
    pub fn new(
        found: &Certificate,
        geometries: &[GeometryReport],
        names: &[Named],
        lines: &Lines,
    ) -> CertificateReport {
        let name_of_flag =
            |flag: u8| names.iter().find(|named| named.flag == flag).map_or(String::new(), |named| named.name.clone());
        let gap = |&FlagGap { flags, axis, cells, first, bounds }: &FlagGap| GapReport {
            flags,
            names: flags.map(name_of_flag),
            axis: AXES[axis],
            cells,
            place: [0, 1, 2].map(|axis| lines.centre(axis, first[axis])),
            bounds: lines.corners(bounds),
        };
        let name = |geometry: usize| geometries[geometry].name.clone();
        let thin_wall = |&ThinWall { geometry, axis, rays, lost, cells, place }: &ThinWall| ThinWallReport {
            geometry: name(geometry),
            axis: AXES[axis],
            rays,
            lost,
            cells,
            place,
            index: geometry,
        };
        let overlap =
            |&Overlap { geometries: [winner, loser], cells, volume, longest, place, .. }: &Overlap| OverlapReport {
                winner: name(winner),
                loser: name(loser),
                cells,
                volume,
                place,
                longest,
                indices: [winner, loser],
            };
        CertificateReport {
            thin_cells: found.thin_cells,
            thin_walls: found.thin_walls.iter().map(thin_wall).collect(),
            overlaps: found.overlaps.iter().map(overlap).collect(),
            gaps: found.gaps.iter().map(gap).collect(),
        }
    }

    /// A finding for every thin wall and every gap.
    pub fn findings(&self, lines: &Lines) -> Vec<Finding> {
        let of_wall = |wall: &ThinWallReport| {
            let &ThinWallReport { ref geometry, axis, rays, lost, cells, place, index } = wall;
            let sentence = format!(
                "geometry \"{geometry}\" has walls of fewer than {} cells along {axis}: {rays} ray segments, {lost} of them without a \
                 cell, the thinnest of {cells} cells at {}; use smaller cells, or keep them with fill = \"separating\" or \"conservative\"",
                self.thin_cells,
                lines.text_of(place)
            );
            let found = Finding::new("wall-thin", sentence).of_geometry(index, geometry).along_named(axis).at(place);
            let found = found.with_count("rays", rays).with_count("lost", lost);
            found.with_count("cells", cells.into()).with_count("thin_cells", self.thin_cells.into())
        };
        let of_gap = |gap: &GapReport| {
            let ([one, other], [name, other_name]) = (gap.flags, &gap.names);
            let sentence = format!(
                "{} single background cells lie between \"{name}\" (flag {one}) and \"{other_name}\" (flag {other}) along {}, such as \
                 the one at {}; if the two should touch, move one, or use smaller cells",
                gap.cells,
                gap.axis,
                lines.text_of(gap.place)
            );
            let found = Finding::new("gap-narrow", sentence).of_flag(one).with_count("other_flag", other.into());
            found.along_named(gap.axis).at(gap.place).within(gap.bounds).with_count("cells", gap.cells)
        };
        self.thin_walls.iter().map(of_wall).chain(self.gaps.iter().map(of_gap)).collect()
    }
}
