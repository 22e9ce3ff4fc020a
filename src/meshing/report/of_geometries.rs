//! What the report says of geometries: their surfaces, how cells were decided that rays alone do not decide, and the cells of each flag.

use serde::{Deserialize, Serialize};

use hexcast_core::base::finding::Finding;
use hexcast_core::grid::closed::{BadEdges, MAX_FACETS};
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::edges::BadEdge;
use hexcast_core::input::geometry::{Fill, Geometry, Open, joined_names};
use hexcast_core::open_surfaces::overlay::{Along, Found};

use super::of_shells::{MAX_OFF, ShellCheck, Subject};

/// One geometry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
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
    /// The most by which the volume of its cells can differ from that, unless shells of it overlap; null where its cells are not those
    /// within its surface: that is open, or its facets do not agree, or it is filled, a shell, inverted or cut by the domain.
    pub volume_bound: Option<f64>,
    /// Whether its facets enclose a volume that its cells should have, filled or not: closed, in agreement, neither a shell nor inverted.
    #[serde(default)]
    pub has_volume: bool,
    /// What its shells have in cells; null where all cells along its surface are its own (fill `conservative`), and with `quick`.
    #[serde(default)]
    pub shells: Option<ShellCheck>,
    /// Whether its cells are those outside of it.
    pub invert: bool,
    /// Edges that are not shared by two facets that agree, after the snap.
    pub bad_edges: BadEdges,
}

impl GeometryReport {
    /// Describes a geometry that has facets.
    pub fn new(geometry: &Geometry, bad_edges: BadEdges) -> GeometryReport {
        GeometryReport {
            name: geometry.name.clone(),
            flag: geometry.flag,
            priority: geometry.priority,
            facets: geometry.facets.len() as u64,
            bounding_box: geometry.bounding_box().unwrap_or_default(),
            mesh_volume: geometry.signed_volume(),
            volume_bound: None,
            has_volume: false,
            shells: None,
            invert: geometry.invert,
            bad_edges,
        }
    }

    /// What is to be said of its shells; it is the geometry of the report with this index.
    pub fn shell_findings(&self, index: usize, lines: &Lines) -> Vec<Finding> {
        let subject = Subject { index, name: &self.name, flag: self.flag, mesh_volume: self.mesh_volume.abs() };
        self.shells.as_ref().map_or(Vec::new(), |shells| shells.findings(&subject, lines))
    }

    /// Adds the box around its worst edges of a kind.
    pub fn within_worst_edges(&self, finding: Finding, kind: BadEdge) -> Finding {
        match self.bad_edges.worst.iter().find(|group| group.kind == kind) {
            Some(group) => finding.within(group.bounds),
            None => finding,
        }
    }

    /// Where its worst edges of a kind are, in words.
    pub fn worst_edges(&self, kind: BadEdge, lines: &Lines) -> String {
        let Some(group) = self.bad_edges.worst.iter().find(|group| group.kind == kind) else { return String::new() };
        let [low, high] = group.bounds.map(|corner| lines.text_of(corner));
        let facets: Vec<String> = group.facets.iter().map(u64::to_string).collect();
        let more = if group.facets.len() == MAX_FACETS { " and maybe others" } else { "" };
        format!(
            "{} of them between {low} and {high}, of facets {}{more}, counted from 0 in the file",
            group.edges,
            facets.join(", ")
        )
    }
}

/// Whether centres of cells would lie in a geometry of this bounding box beyond the domain.
pub fn is_cut([low, high]: [[f64; 3]; 2], lines: &Lines) -> bool {
    (0..3).any(|axis| {
        let n = lines.dims()[axis];
        let [first, last] = [0, n - 1].map(|cell| 0.5 * lines.cell_size(axis, cell));
        low[axis] < lines.line(axis, 0) - first || high[axis] > lines.line(axis, n) + last
    })
}

/// A geometry whose surface is not closed, and how its cells were decided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OpenReport {
    /// Its name.
    pub geometry: String,
    /// How its cells were decided.
    pub policy: Open,
    /// Edges that facets use an odd number of times, or for the rule `nonzero` more often one way than the other.
    pub open_edges: u64,
    /// Loops of these edges.
    pub holes: u64,
    /// Holes of three edges: the facet that was missing there was added.
    #[serde(default)]
    pub added_facets: u64,
    /// Middle of the longest of them.
    pub longest_at: [f64; 3],
    /// Facets that were turned to agree with their neighbours.
    pub turned: u64,
    /// Rays along x, y and z that cross it an odd number of times, or for `nonzero` do not leave as often as they enter.
    pub odd_rays: [u64; 3],
    /// Cells whose three rays are not all even, or do not agree.
    pub doubtful_cells: u64,
    /// Index of the geometry in `geometries`, from 0.
    pub index: usize,
}

impl OpenReport {
    /// Describes what was found of an open geometry.
    pub fn new(found: &Found, geometries: &[GeometryReport]) -> OpenReport {
        OpenReport {
            geometry: geometries[found.geometry].name.clone(),
            policy: found.policy,
            open_edges: found.surface.open_edges,
            holes: found.surface.holes,
            added_facets: found.surface.added,
            longest_at: found.surface.longest_at,
            turned: found.surface.turned,
            odd_rays: found.odd_rays,
            doubtful_cells: found.doubtful_cells,
            index: found.geometry,
        }
    }

    /// Says it; `geometry` is what is known of it.
    pub fn finding(&self, geometry: &GeometryReport, lines: &Lines) -> Finding {
        let decided = match self.policy {
            Open::Vote => "by most of their even rays",
            _ => "by the winding number",
        };
        let ([of_x, of_y, of_z], at, n_cells) = (self.odd_rays, lines.text_of(self.longest_at), lines.n_cells());
        let kind = if geometry.bad_edges.open == 0 && geometry.bad_edges.flipped > 0 {
            BadEdge::Flipped
        } else {
            BadEdge::Open
        };
        let edges = match kind {
            BadEdge::Flipped => {
                let n = geometry.bad_edges.flipped;
                format!("edges between facets that face opposite ways {n}, facets turned {}", self.turned)
            }
            _ => format!("open edges {}, loops {}, the longest edge at {at}", self.open_edges, self.holes),
        };
        let added = match self.added_facets {
            0 => String::new(),
            n => format!("; facets added where one was missing between three open edges: {n}"),
        };
        let worst = geometry.worst_edges(kind, lines);
        let worst = if worst.is_empty() { worst } else { format!("; {worst}") };
        let sentence = format!(
            "geometry \"{}\" is not closed: {edges}{worst}{added}; rays that do not leave it as often as they enter: {of_x} along x, {of_y} \
             along y, {of_z} along z; {} of {n_cells} cells were doubtful and were decided {decided}",
            self.geometry, self.doubtful_cells,
        );
        let counts = [
            ("open_edges", self.open_edges),
            ("holes", self.holes),
            ("added_facets", self.added_facets),
            ("turned", self.turned),
            ("doubtful_cells", self.doubtful_cells),
            ("cells", n_cells),
            ("odd_rays_x", of_x),
            ("odd_rays_y", of_y),
            ("odd_rays_z", of_z),
        ];
        let found =
            Finding::new("surface-open", sentence).of_geometry(self.index, &self.geometry).of_flag(geometry.flag);
        let found = geometry.within_worst_edges(found.at(self.longest_at), kind);
        counts.into_iter().fold(found, |found, (name, n)| found.with_count(name, n))
    }
}

/// A geometry that has the cells along its surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FillReport {
    /// Its name.
    pub geometry: String,
    /// Its index in `geometries`, from 0.
    #[serde(default)]
    pub index: usize,
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
        FillReport { geometry: geometries[geometry].name.clone(), index: geometry, fill, shell, added_cells }
    }
}

/// The cells of one flag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
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
    /// Null where one of them encloses no such volume (`has_volume`), or is cut by the domain.
    pub mesh_volume: Option<f64>,
    /// Sum of the bounds of its geometries: the most by which `volume` can differ from `mesh_volume` where neither geometries nor shells
    /// of one overlap. Null where one of them has none.
    pub volume_bound: Option<f64>,
}

/// Joins the geometries of each flag and counts its cells, which are those of some lines.
pub fn flag_reports(
    geometries: &[GeometryReport],
    cells: &[u64; 256],
    volumes: &[f64; 256],
    lines: &Lines,
) -> Vec<FlagReport> {
    let report = |flag: u8| {
        let members: Vec<&GeometryReport> = geometries.iter().filter(|geometry| geometry.flag == flag).collect();
        // cells of the background are no one's
        let has_volume = |of: &GeometryReport| flag != 0 && of.has_volume && !is_cut(of.bounding_box, lines);
        let mesh_volume = |of: &&GeometryReport| has_volume(of).then_some(of.mesh_volume.abs());
        FlagReport {
            flag,
            name: joined_names(members.iter().map(|geometry| &geometry.name[..])),
            cells: cells[usize::from(flag)],
            volume: volumes[usize::from(flag)],
            mesh_volume: members.iter().map(mesh_volume).sum(),
            volume_bound: members.iter().map(|geometry| geometry.volume_bound).sum(),
        }
    };
    let is_used = |flag: &u8| geometries.iter().any(|geometry| geometry.flag == *flag);
    (0..=255).filter(is_used).map(report).collect()
}

/// Findings about flags whose filled geometries have far more cells than their surfaces enclose.
pub fn thick_flags(flags: &[FlagReport], filled: &[FillReport], geometries: &[GeometryReport]) -> Vec<Finding> {
    let thick = |flag: &FlagReport| {
        let mesh_volume = flag.mesh_volume.filter(|surface| flag.volume > (1.0 + MAX_OFF) * surface)?;
        let is_member = |index: usize| geometries.get(index).is_some_and(|of| of.flag == flag.flag);
        let fill = filled.iter().find(|of| is_member(of.index) && of.added_cells > 0)?;
        let (name, times) = (&flag.name, flag.volume / mesh_volume);
        let sentence = format!(
            "the cells of \"{name}\" (flag {}) have {times:.2} times the volume of its surface: fill = \"{}\" keeps thin walls at the \
             thickness of a cell or more; use smaller cells",
            flag.flag,
            fill.fill.name()
        );
        let found = Finding::new("volume-filled", sentence).of_geometry(fill.index, &fill.geometry).of_flag(flag.flag);
        Some(found.with_value("volume", flag.volume).with_value("mesh_volume", mesh_volume))
    };
    flags.iter().filter_map(thick).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geometries_of_one_flag_are_joined_and_volumes_that_cannot_be_compared_are_left_out() {
        let geometry = |name: &str, flag: u8, volume: f64, volume_bound: Option<f64>| {
            let facets = vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
            let report = GeometryReport::new(&Geometry::new(name, flag, facets).unwrap(), BadEdges::default());
            GeometryReport { mesh_volume: volume, volume_bound, has_volume: true, ..report }
        };
        let lines = Lines::new([0.0; 3], [0.5; 3], [2; 3]).unwrap();
        let mut cells = [0; 256];
        (cells[3], cells[1]) = (10, 5);
        let volumes = cells.map(|n: u64| n as f64 * 0.125);
        // b is turned inside out
        let all =
            [geometry("a", 3, 2.0, Some(0.5)), geometry("b", 1, -2.0, Some(0.25)), geometry("c", 3, 2.0, Some(1.0))];
        let facts = |flags: Vec<FlagReport>| -> Vec<_> {
            flags.into_iter().map(|f| (f.flag, f.name, f.cells, f.volume, f.mesh_volume, f.volume_bound)).collect()
        };
        let joined =
            [(1, "b".into(), 5, 0.625, Some(2.0), Some(0.25)), (3, "a + c".into(), 10, 1.25, Some(4.0), Some(1.5))];
        assert_eq!(facts(flag_reports(&all, &cells, &volumes, &lines)), joined);
        let more = |has_volume| {
            let filled = GeometryReport { has_volume, ..geometry("d", 3, 9.0, None) };
            facts(flag_reports(&[&all[..], &[filled]].concat(), &cells, &volumes, &lines))[1].clone()
        };
        assert_eq!(more(true), (3, "a + c + d".into(), 10, 1.25, Some(13.0), None));
        assert_eq!(more(false), (3, "a + c + d".into(), 10, 1.25, None, None));
        // cells of the background may be those of a geometry
        let air = GeometryReport { flag: 0, ..geometry("air", 1, 1.0, None) };
        cells[0] = 7;
        assert_eq!(facts(flag_reports(&[air], &cells, &volumes, &lines))[0], (0, "air".into(), 7, 0.0, None, None));
    }
}
