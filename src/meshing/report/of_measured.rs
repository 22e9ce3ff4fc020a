//! What the report says of what a job asks for beside the cells: links from cells to surfaces, cells that surfaces cut, staggered grids.

use serde::{Deserialize, Serialize};

use hexcast_core::base::error::Result;
use hexcast_core::base::length::Length;
use hexcast_core::base::parallel::*;
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::job::Stencil;
use hexcast_derived::cut_cells::conformal::{Conformal, Counts};
use hexcast_derived::cut_cells::tensors::{TensorCounts, Tensors};
use hexcast_derived::distance::Distance;
use hexcast_derived::fractions::Fractions;
use hexcast_derived::links::{Link, Links};
use hexcast_derived::staggered::{COMPONENTS, Points, SheetFace, Staggered};

/// Links from cells of the fluid to surfaces, counted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LinksReport {
    /// The directions.
    pub stencil: Stencil,
    /// Flags of the fluid.
    pub fluid: Vec<u8>,
    /// Number of links.
    pub links: u64,
    /// Cells of the fluid with at least one of them.
    pub cells: u64,
    /// Links whose other end is in the fluid, too: the wall between is thinner than the link.
    pub through_walls: u64,
    /// Links that no facet crosses, as the flag at their other end is not decided by rays: q is 1/2.
    pub without_facet: u64,
}

impl LinksReport {
    /// Counts links.
    pub fn new(links: &Links) -> LinksReport {
        let mut is_fluid = [false; 256];
        links.fluid.iter().for_each(|&flag| is_fluid[usize::from(flag)] = true);
        let of_plane = |all: &Vec<Link>| {
            [
                all.chunk_by(|one, other| one.cell == other.cell).count(),
                all.iter().filter(|link| is_fluid[usize::from(link.flag)]).count(),
                all.iter().filter(|link| link.facet < 0).count(),
            ]
        };
        let counts: Vec<[usize; 3]> = links.planes.par_iter().map(of_plane).collect();
        let [cells, through_walls, without_facet] = [0, 1, 2].map(|of| counts.iter().map(|some| some[of] as u64).sum());
        LinksReport {
            stencil: links.stencil,
            fluid: links.fluid.clone(),
            links: links.len() as u64,
            cells,
            through_walls,
            without_facet,
        }
    }
}

/// Cells that surfaces cut, counted, and the volumes of flags that follow.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FractionsReport {
    /// m: a cell has m x m rays; 0 where cells are measured exactly.
    pub rays: u32,
    /// Cells that are cut: those with more than one flag, and those that a surface passes through where no ray meets it.
    pub cut_cells: u64,
    /// Cells that 16 x 16 rays measure where the others are exact, as a surface passes through itself there.
    pub sampled_cells: u64,
    /// Volume of each flag that has any, ascending; 0 is the background.
    pub volumes: Vec<VolumeReport>,
    /// Area of the surface of each geometry in the box, in the order of the job; null unless surfaces are asked for.
    pub areas: Option<Vec<f64>>,
}

/// Volume of a flag, with its fractions of cells that are cut.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct VolumeReport {
    /// The flag.
    pub flag: u8,
    /// The volume.
    pub volume: f64,
}

impl FractionsReport {
    /// Counts cells.
    pub fn new(fractions: &Fractions) -> FractionsReport {
        let volumes = (0..=u8::MAX).zip(&fractions.volumes).filter(|(_, volume)| **volume > 0.0);
        FractionsReport {
            rays: fractions.rays,
            cut_cells: fractions.n_cells(),
            sampled_cells: fractions.sampled_cells,
            volumes: volumes.map(|(flag, &volume)| VolumeReport { flag, volume }).collect(),
            areas: fractions.areas.clone(),
        }
    }
}

/// The points of a staggered grid, counted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StaggeredReport {
    /// The components, Ex, Ey, Ez, Hx, Hy and Hz.
    pub components: Vec<ComponentReport>,
    /// Number of faces that are sheets.
    pub sheet_faces: u64,
}

/// The points of a component.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ComponentReport {
    /// Such as "Ex".
    pub name: String,
    /// Number of points on x, y and z.
    pub dims: [u32; 3],
    /// Every flag that a point has, ascending; 0 is the background.
    pub flags: Vec<PointsReport>,
}

/// The points of a flag.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PointsReport {
    /// The flag.
    pub flag: u8,
    /// Number of points.
    pub points: u64,
}

impl StaggeredReport {
    /// Counts points.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails.
    pub fn new(staggered: &Staggered) -> Result<StaggeredReport> {
        StaggeredReport::without_last(staggered, [false; 3])
    }

    /// Counts the points of a window that no window behind it has, too: not those on its last line along an axis, unless that is the last of the box. It
    /// ends at the cell `end` of a box of so many cells.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails.
    #[doc(hidden)]
    pub fn of_window(staggered: &Staggered, end: [u32; 3], of: [u32; 3]) -> Result<StaggeredReport> {
        StaggeredReport::without_last(staggered, [0, 1, 2].map(|axis| end[axis] < of[axis]))
    }

    /// Counts points, but those on the last line along some axes.
    fn without_last(staggered: &Staggered, leaves: [bool; 3]) -> Result<StaggeredReport> {
        let component = |(points, (_, is_on_line)): (&Points, (&str, [bool; 3]))| {
            let end = [0, 1, 2].map(|axis| points.dims()[axis] - u32::from(leaves[axis] && is_on_line[axis]));
            let flags = (0..=u8::MAX).zip(points.n_before(end)?).filter(|(_, n)| *n > 0);
            let flags = flags.map(|(flag, points)| PointsReport { flag, points }).collect();
            Ok(ComponentReport { name: points.name.into(), dims: end, flags })
        };
        let components = staggered.points.iter().zip(COMPONENTS).map(component).collect::<Result<_>>()?;
        // components of H across an axis have a point on each of its lines
        let [of_x, of_y, of_z] = [3, 4, 5].map(|of: usize| staggered.points[of].dims());
        let last = [of_x[0] - 1, of_y[1] - 1, of_z[2] - 1];
        let is_left = |sheet: &&SheetFace| {
            let axis = usize::from(sheet.axis);
            leaves[axis] && sheet.face[axis] == last[axis]
        };
        let n_left = staggered.sheets.iter().filter(is_left).count();
        Ok(StaggeredReport { components, sheet_faces: (staggered.sheets.len() - n_left) as u64 })
    }
}

/// Edges and faces outside metal, counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ConformalReport {
    /// Edges of which a part lies in metal. Those on the last line of a window or part are counted by the one behind it.
    pub cut_edges: u64,
    /// Faces of which a part lies in metal.
    pub cut_faces: u64,
    /// Faces that are larger than what lies outside metal, so that the step stays long.
    pub enlarged_faces: u64,
    /// Those of which the faces beside them did not have all that they lacked.
    pub unbalanced_faces: u64,
    /// Cells whose faces rays measure, as a surface passes through itself there.
    pub sampled_cells: u64,
    /// The longest stable step, as a part of `dx / (c sqrt(3))` or what that is for the smallest cells.
    pub dt_factor: f64,
    /// This step in seconds, in vacuum; null where no unit of length is known.
    pub dt: Option<f64>,
}

/// Metres a second.
const SPEED_OF_LIGHT: f64 = 299_792_458.0;

impl ConformalReport {
    /// Counts edges and faces; `unit` is that of the lines.
    pub fn new(conformal: &Conformal, lines: &Lines, unit: Option<&str>) -> ConformalReport {
        let Counts { cut_edges, cut_faces, enlarged_faces, unbalanced_faces, sampled_cells, .. } = conformal.counts;
        let dt_factor = conformal.dt_factor;
        let dt = unit.and_then(Length::of_name).map(|unit| {
            let of_axes = lines.smallest().iter().map(|&size| unit.metres(size).powi(-2)).sum::<f64>();
            dt_factor / (SPEED_OF_LIGHT * of_axes.sqrt())
        });
        ConformalReport { cut_edges, cut_faces, enlarged_faces, unbalanced_faces, sampled_cells, dt_factor, dt }
    }
}

/// Signed distances.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DistanceReport {
    /// Facets whose distances count.
    pub facets: u64,
    /// Largest distance that is known, in the unit of the files; null where all are.
    pub width: Option<f64>,
}

impl DistanceReport {
    /// Says what there is.
    pub fn new(distance: &Distance) -> DistanceReport {
        let width = Some(distance.width).filter(|width| width.is_finite());
        DistanceReport { facets: distance.n_facets(), width }
    }
}

/// Points at which permittivity was smoothed, counted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TensorsReport {
    /// Points of Ex, Ey and Ez around which lies more than one permittivity. Those on the last line of a window or part are counted by the one behind it.
    pub cut_points: u64,
    /// Those at which surfaces cancel, so that no normal is known: they have the mean.
    pub without_normal: u64,
    /// Points around which rays measure, as a surface passes through itself there.
    pub sampled_points: u64,
}

impl TensorsReport {
    /// Counts points.
    pub fn new(tensors: &Tensors) -> TensorsReport {
        let TensorCounts { cut_points, without_normal, sampled_points, .. } = tensors.counts;
        TensorsReport { cut_points, without_normal, sampled_points }
    }
}
