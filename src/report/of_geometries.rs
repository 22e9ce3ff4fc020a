//! What the report says of geometries: their surfaces, how cells were decided that rays alone do not decide, and the cells of each flag.

use serde::Serialize;

use crate::geometry::{Fill, Geometry, Open};
use crate::lines::Lines;
use crate::overlay::{Along, Found};

/// One geometry.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GeometryReport {
    /// Its name.
    pub name: String,
    /// Its property flag.
    pub flag: u8,
    /// Its priority.
    pub priority: i32,
    /// Number of facets.
    pub facets: u64,
    /// Least and greatest coordinates.
    pub bounding_box: [[f64; 3]; 2],
    /// Signed volume enclosed by the facets: positive where normals point outwards.
    pub mesh_volume: f64,
    /// Whether its cells are those outside of it.
    pub invert: bool,
}

impl GeometryReport {
    /// Describes a geometry that has facets.
    pub fn new(geometry: &Geometry) -> GeometryReport {
        GeometryReport {
            name: geometry.name.clone(),
            flag: geometry.flag,
            priority: geometry.priority,
            facets: geometry.facets.len() as u64,
            bounding_box: geometry.bounding_box().unwrap_or_default(),
            mesh_volume: geometry.signed_volume(),
            invert: geometry.invert,
        }
    }
}

/// A geometry whose surface is not closed, and how its cells were decided.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OpenReport {
    /// Its name.
    pub geometry: String,
    /// How its cells were decided.
    pub policy: Open,
    /// Edges that facets use an odd number of times, or for the rule `nonzero` more often one way than the other.
    pub open_edges: u64,
    /// Loops of these edges.
    pub holes: u64,
    /// Middle of the longest of them.
    pub longest_at: [f64; 3],
    /// Facets that were turned to agree with their neighbours.
    pub turned: u64,
    /// Rays along x, y and z that cross it an odd number of times, or for `nonzero` do not leave as often as they enter.
    pub odd_rays: [u64; 3],
    /// Cells whose three rays are not all even, or do not agree.
    pub doubtful_cells: u64,
}

impl OpenReport {
    /// Describes what was found of an open geometry.
    pub fn new(found: &Found, geometries: &[GeometryReport]) -> OpenReport {
        OpenReport {
            geometry: geometries[found.geometry].name.clone(),
            policy: found.policy,
            open_edges: found.surface.open_edges,
            holes: found.surface.holes,
            longest_at: found.surface.longest_at,
            turned: found.surface.turned,
            odd_rays: found.odd_rays,
            doubtful_cells: found.doubtful_cells,
        }
    }

    /// Says it in a sentence.
    pub fn warning(&self, lines: &Lines) -> String {
        let decided = match self.policy {
            Open::Vote => "by most of their even rays",
            _ => "by the winding number",
        };
        let ([of_x, of_y, of_z], at, n_cells) = (self.odd_rays, lines.text_of(self.longest_at), lines.n_cells());
        format!(
            "geometry \"{}\" is not closed: open edges {}, loops {}, the longest edge at {at}; rays that do not leave it \
             as often as they enter: {of_x} along x, {of_y} along y, {of_z} along z; {} of {n_cells} cells were doubtful and were \
             decided {decided}",
            self.geometry, self.open_edges, self.holes, self.doubtful_cells,
        )
    }
}

/// A geometry that has the cells along its surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FillReport {
    /// Its name.
    pub geometry: String,
    /// Which cells.
    pub fill: Fill,
    /// Whether it has no others.
    pub shell: bool,
    /// Cells that it has for no other reason.
    pub added_cells: u64,
}

impl FillReport {
    /// Describes what was added to a geometry.
    pub fn new(found: &Along, geometries: &[GeometryReport]) -> FillReport {
        let &Along { geometry, fill, shell, added_cells } = found;
        FillReport { geometry: geometries[geometry].name.clone(), fill, shell, added_cells }
    }
}

/// The cells of one flag.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FlagReport {
    /// The flag.
    pub flag: u8,
    /// Names of its geometries, joined by " + ".
    pub name: String,
    /// Number of cells.
    pub cells: u64,
    /// Their volume.
    pub volume: f64,
    /// Sum of the volumes that its geometries' surfaces enclose, to be compared with `volume`; that differs where geometries overlap.
    /// None where a geometry is open, filled, inverted, or cut by the domain.
    pub mesh_volume: Option<f64>,
}

/// Joins the geometries of each flag and counts its cells.
pub fn flag_reports(
    geometries: &[GeometryReport],
    open: &[OpenReport],
    filled: &[FillReport],
    cells: &[u64; 256],
    lines: &Lines,
) -> Vec<FlagReport> {
    let volume = |geometry: &&GeometryReport| {
        let is_itself = |name: &String| *name == geometry.name;
        let has_others = open.iter().any(|open| is_itself(&open.geometry))
            || filled.iter().any(|filled| is_itself(&filled.geometry))
            || geometry.invert
            || is_cut(geometry, lines);
        (!has_others).then_some(geometry.mesh_volume.abs())
    };
    let report = |flag: u8| {
        let members: Vec<&GeometryReport> = geometries.iter().filter(|geometry| geometry.flag == flag).collect();
        let names: Vec<&str> = members.iter().map(|geometry| geometry.name.as_str()).collect();
        FlagReport {
            flag,
            name: names.join(" + "),
            cells: cells[usize::from(flag)],
            volume: cells[usize::from(flag)] as f64 * lines.cell_volume(),
            mesh_volume: members.iter().map(volume).sum(),
        }
    };
    let is_used = |flag: &u8| geometries.iter().any(|geometry| geometry.flag == *flag);
    (0..=255).filter(is_used).map(report).collect()
}

/// Whether centres of cells would lie in it beyond the domain.
fn is_cut(geometry: &GeometryReport, lines: &Lines) -> bool {
    let [low, high] = geometry.bounding_box;
    (0..3).any(|axis| {
        let half = 0.5 * lines.spacing[axis];
        low[axis] < lines.line(axis, 0) - half || high[axis] > lines.line(axis, lines.dims[axis]) + half
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geometries_of_one_flag_are_joined_and_volumes_that_cannot_be_compared_are_left_out() {
        let lines = Lines::new([0.0; 3], [0.5; 3], [4; 3]).unwrap();
        let geometry = |name: &str, flag: u8, volume: f64| {
            let facets = vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
            GeometryReport { mesh_volume: volume, ..GeometryReport::new(&Geometry::new(name, flag, facets)) }
        };
        let mut cells = [0; 256];
        (cells[3], cells[1]) = (10, 5);
        let inverted = GeometryReport { invert: true, ..geometry("d", 4, 2.0) };
        let mut beyond = geometry("e", 5, 2.0);
        beyond.bounding_box[1][0] = 2.3;
        // b is turned inside out
        let all = [geometry("a", 3, 2.0), geometry("b", 1, -2.0), geometry("c", 3, 2.0), inverted, beyond];
        let flags = flag_reports(&all, &[], &[], &cells, &lines);
        let facts: Vec<_> = flags.iter().map(|f| (f.flag, f.name.as_str(), f.cells, f.volume, f.mesh_volume)).collect();
        let joined = [(1, "b", 5, 0.625, Some(2.0)), (3, "a + c", 10, 1.25, Some(4.0))];
        assert_eq!(facts[..2], joined);
        assert_eq!(facts[2..], [(4, "d", 0, 0.0, None), (5, "e", 0, 0.0, None)]);
        let filled = FillReport { geometry: "c".into(), fill: Fill::Separating, shell: false, added_cells: 1 };
        assert_eq!(flag_reports(&all, &[], &[filled], &cells, &lines)[1].mesh_volume, None);
    }
}
