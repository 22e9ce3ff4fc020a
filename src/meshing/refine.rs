//! Refinement: a job meshed with its cells, with cells of half their edge, of a quarter, ... -> an octree, whose leaves are fine where surfaces are.
//!
//! Each level is a mesh of its own, so a leaf has the flag of the cell of the uniform mesh of its size. Cost: that of the finest mesh and a third more, and its columns in memory.

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::finding::Finding;
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_core::input::job::{AxisChoice, ByteSize, Job};
use hexcast_core::input::sources::Source;
use hexcast_core::set;
use hexcast_derived::mesh::octree::{MAX_LEVELS, Octree, Wanted};
use hexcast_derived::mesh::{Mesh, Named};

use crate::meshing::pipeline::{self, DEFAULT_MAX_BYTES, Engine, MeshOptions};

/// How fine cells become, and where.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Refinement {
    /// How often cells are halved along each axis at surfaces: 0 to 16.
    pub levels: u8,
    /// Flags at whose surfaces cells are halved less often: 0 for not at all. A surface between two flags has the finer cells.
    pub level_of_flags: Vec<(u8, u8)>,
    /// Boxes, x0, y0, z0, x1, y1, z1 in the unit of the files, in which cells are halved so often at least, wherever surfaces are.
    pub boxes: Vec<([f64; 6], u8)>,
}

impl Refinement {
    /// Cells that are halved so often at all surfaces.
    pub fn new(levels: u8) -> Refinement {
        Refinement { levels, ..Refinement::default() }
    }
}

/// A job whose cells are halved where surfaces are.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Refined {
    /// The cells.
    pub octree: Octree,
    /// The lines of level 0.
    pub lines: Lines,
    /// Names of the flags, in the order of the job.
    pub names: Vec<Named>,
    /// Unit of every length, if the job or its files name one.
    pub unit: Option<String>,
    /// Findings about the finest mesh.
    pub findings: Vec<Finding>,
}

/// Meshes the levels of a job, and finds which of their cells are leaves. The cells of the job are those of level 0.
///
/// # Errors
/// `job-conflict` where the job asks for a window, a part, closed gaps or for something that is measured; `job-value` where a level is none, or a box lies outside; `memory`; those of [`pipeline::mesh`].
pub async fn refine(
    job: &Job,
    sources: &[Source],
    how: &Refinement,
    engine: &mut Engine,
    control: &Control,
) -> Result<Refined> {
    check(job, how)?;
    let max_bytes = job.max_memory.map_or(DEFAULT_MAX_BYTES, |size| size.0);
    let (mut meshes, mut findings): (Vec<Mesh>, _) = (Vec::new(), Vec::new());
    for level in (0..=u32::from(how.levels)).rev() {
        let is_finest = level == u32::from(how.levels);
        let max_memory = job.max_memory.map(|_| ByteSize(left(max_bytes, &meshes)));
        // what a warning says of the finest cells is not said of others
        let job = set!(Job { axis: AxisChoice::X, quick: job.quick || !is_finest, max_memory, ..job.clone() });
        let options = MeshOptions { halved: level, ..MeshOptions::default() };
        let (mesh, facts) = pipeline::mesh(&job, sources.to_vec(), &options, engine, control).await?;
        if is_finest {
            findings = facts.findings;
        }
        meshes.push(mesh);
    }
    meshes.reverse();
    let (lines, finest) = (meshes[0].lines().clone(), &meshes[meshes.len() - 1]);
    let (names, unit) = (finest.names().to_vec(), finest.unit().map(String::from));
    let wanted = wanted(how, &lines)?;
    let left = left(max_bytes, &meshes);
    let columns = meshes.iter().map(|mesh| mesh.columns().clone()).collect();
    let octree = Octree::new(columns, &wanted, left, control).await?;
    Ok(Refined { octree, lines, names, unit, findings })
}

/// What is left of memory beside meshes.
fn left(max_bytes: u64, meshes: &[Mesh]) -> u64 {
    max_bytes.saturating_sub(meshes.iter().map(|mesh| mesh.columns().n_bytes()).sum())
}

fn check(job: &Job, how: &Refinement) -> Result<()> {
    let asked = [
        ("window", job.window.is_some()),
        ("part", job.part.is_some()),
        ("close_gaps", job.close_gaps.is_some()),
        ("links, fractions or what else is measured", job.is_measured()),
    ];
    if let Some((key, _)) = asked.iter().find(|(_, is_given)| *is_given) {
        let message = format!("{key} is given with refinement, which has cells of several sizes in the whole box");
        return Err(Error::new("job-conflict", message, format!("leave out {key}, or mesh without refinement")));
    }
    if u32::from(how.levels) > MAX_LEVELS {
        let message = format!("cells are halved {} times; allowed: 0 to {MAX_LEVELS}", how.levels);
        return Err(Error::new("job-value", message, "halve them less often, and begin with smaller cells"));
    }
    let asked = how.level_of_flags.iter().map(|(_, level)| level).chain(how.boxes.iter().map(|(_, level)| level));
    if let Some(level) = asked.max().filter(|level| **level > how.levels) {
        let message = format!("level {level} is asked for, and {} is the finest", how.levels);
        return Err(Error::new("job-value", message, "ask for more levels (--levels)"));
    }
    match how.level_of_flags.iter().find(|(flag, _)| *flag == 0) {
        Some(_) => {
            let hint = "name the flags of geometries: their surfaces are those of the background, too";
            Err(Error::new("job-value", "a level is asked for at the surfaces of flag 0, the background", hint))
        }
        None => Ok(()),
    }
}

/// The same in cells of level 0.
fn wanted(how: &Refinement, lines: &Lines) -> Result<Wanted> {
    let mut wanted = Wanted::surfaces(how.levels);
    how.level_of_flags.iter().for_each(|&(flag, level)| wanted.level_of_flag[usize::from(flag)] = level);
    for &([x0, y0, z0, x1, y1, z1], level) in &how.boxes {
        let [low, high] = [[x0, y0, z0], [x1, y1, z1]];
        let mut cells = [const { 0..0 }; 3];
        for (axis, cells) in cells.iter_mut().enumerate() {
            let list = lines.list(axis);
            // cells of which more than a side lies in the box
            let first = list[1..].partition_point(|line| *line <= low[axis]) as u32;
            let end = list[..list.len() - 1].partition_point(|line| *line < high[axis]) as u32;
            if first >= end {
                let (name, ends) = (AXES[axis], [list[0], list[list.len() - 1]]);
                let message = format!(
                    "a box to refine goes from {} to {} along {name}, and cells from {} to {}",
                    low[axis], high[axis], ends[0], ends[1]
                );
                return Err(Error::new(
                    "job-value",
                    message,
                    "give a box that has some of the cells: x0, y0, z0, x1, y1, z1",
                ));
            }
            *cells = first..end;
        }
        wanted.boxes.push((cells, level));
    }
    Ok(wanted)
}
