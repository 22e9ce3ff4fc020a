//! `hexcast verify`: whether a column file holds the cells that its job defines.
//!
//! A second program in this one: it shares the job and the reader of column files with the mesher, and nothing else. It reads the
//! STL files, snaps them and casts its own rays, across those of the mesh, through every cell.

use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::OnceLock;

use hexcast::control::{CancelToken, Control};
use hexcast::job::{Fill, GeometryJob, Job};
use hexcast::mesh::Mesh;
use hexcast::{Error, Result};
use indicatif::HumanCount;

use super::arguments::{JobArguments, at_least_one, number};
use super::{reading, terminal};

mod ray;
mod scene;
mod slabs;
mod stl;
mod surface;

use scene::Scene;
use slabs::{Check, Tally};

const EXAMPLES: &str = "\
Examples:
    hexcast verify part.hxc part.stl --cells 256
    hexcast verify part.hxc --job job.toml
    hexcast verify large.hxc --job job.toml --sample 1e9 --seed 7";

/// Exit code where the mesh is not that of the job.
const DIFFERS: u8 = 9;
/// Cells of a slab, where its planes are not larger, and bytes that each takes.
const SLAB: u64 = 1 << 24;
const CELL_BYTES: u64 = 3;

/// Check a column file (.hxc) cell by cell, by a second method, against its job: --job, or the same arguments as for `mesh`
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Column file
    #[arg(value_name = "MESH.hxc")]
    mesh: PathBuf,
    #[command(flatten)]
    job: JobArguments,
    /// Check only some evenly spaced planes of cells, with about CELLS cells in all, such as 1e9 [default: all cells]
    #[arg(long, value_name = "CELLS", value_parser = at_least_one::<u64>, help_heading = "Check")]
    sample: Option<u64>,
    /// Seed that chooses the planes of --sample, and the doubtful cells to check if there are too many
    #[arg(long, value_name = "N", default_value = "1", value_parser = number::<u64>, help_heading = "Check")]
    seed: u64,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<ExitCode> {
    let job = arguments.job.job()?;
    check_is_known(&job)?;
    arguments.job.set_threads()?;
    let mut control = Control::default();
    control.cancel = token.clone();
    let max_bytes = job.max_memory.map_or(u64::MAX, |size| size.0);
    let mesh = reading::open_columns(&arguments.mesh, max_bytes / 2, &control)?;
    if mesh.lines.is_graded() {
        let message = "cells differ in size, and hexcast verify knows equal ones only";
        return Err(Error::new("lines-graded", message, "verify a mesh of equal cells"));
    }
    let slabs = slabs(&mesh, arguments.sample, arguments.seed, max_bytes)?;
    let n_cells = slabs.iter().map(|slab| slab.len() as u64).sum::<u64>() * cells_of_plane(&mesh);
    let scene = Scene::new(&job, &mesh)?;
    let (rays, seed) = (mesh.columns.rays, arguments.seed);
    let axes = [rays.axis, rays.across[0], rays.across[1]];
    let through = scene.bodies.iter().map(|_| OnceLock::new()).collect();
    let check = Check { scene: &scene, mesh: &mesh, axes, through, seed, control: &control };
    let tally = check.all(&slabs)?;
    let first =
        format!("{}: {} of {} cells", arguments.mesh.display(), HumanCount(n_cells), HumanCount(mesh.n_cells()));
    terminal::print(&format!("{first} {}", sentences(&scene, &mesh, &tally)))?;
    let is_right = tally.n_wrong == 0 && scene.wrong_lines.is_empty();
    Ok(if is_right { ExitCode::SUCCESS } else { ExitCode::from(DIFFERS) })
}

/// Refuses what the second method does not define.
fn check_is_known(job: &Job) -> Result<()> {
    let has = |is_so: fn(&GeometryJob) -> bool| job.geometries.iter().any(is_so);
    let unknown = [
        ("fill", job.fill != Fill::Centre || has(|of| of.fill.is_some_and(|fill| fill != Fill::Centre))),
        ("shell", has(|of| of.shell)),
        ("invert", has(|of| of.invert)),
        ("close_gaps", job.close_gaps.is_some()),
        ("window", job.window.is_some()),
        ("part", job.part.is_some()),
        ("lines", job.lines.is_some()),
        ("graded", job.graded.is_some()),
    ];
    match unknown.iter().find(|(_, is_so)| *is_so) {
        None => Ok(()),
        Some((key, _)) => {
            let message = format!("the job has {key}, and hexcast verify knows only cells whose centres lie inside");
            Err(Error::new("job-value", message, "verify a mesh that was made without it"))
        }
    }
}

fn cells_of_plane(mesh: &Mesh) -> u64 {
    mesh.n_cells() / u64::from(mesh.columns.rays.counts[1])
}

/// Planes that hold about so many cells, evenly spaced; without a number all, as many to a slab as the memory holds.
fn slabs(mesh: &Mesh, sample: Option<u64>, seed: u64, max_bytes: u64) -> Result<Vec<Range<u32>>> {
    let (n_planes, cells) = (mesh.columns.rays.counts[1], cells_of_plane(mesh));
    let held = max_bytes / CELL_BYTES / rayon::current_num_threads() as u64;
    if cells > held {
        let message =
            format!("a plane of the mesh has {cells} cells; each thread can hold {held} in {max_bytes} bytes");
        return Err(Error::new("memory", message, "use fewer --threads, or allow more with --max-memory"));
    }
    let wanted = sample.map_or(u64::from(n_planes), |sample| sample.div_ceil(cells));
    let step = (u64::from(n_planes) / wanted).max(1) as u32;
    if step > 1 {
        let first = (seed % u64::from(step)) as u32;
        return Ok((first..n_planes).step_by(step as usize).map(|plane| plane..plane + 1).collect());
    }
    let thick = (SLAB.min(held) / cells).clamp(1, n_planes.div_ceil(16).into()) as u32;
    Ok((0..n_planes).step_by(thick as usize).map(|start| start..(start + thick).min(n_planes)).collect())
}

fn sentences(scene: &Scene, mesh: &Mesh, tally: &Tally) -> String {
    let [nx, ny, nz] = mesh.dims();
    let across = ["x", "y", "z"][mesh.columns.rays.across[0]];
    let facets = HumanCount(scene.facets.len() as u64);
    let mut text = format!("({nx} x {ny} x {nz}) checked against {facets} facets, by rays along {across}.\n");
    for body in scene.bodies.iter().filter(|body| body.open.is_some()) {
        text += &format!("{} is not closed.\n", body.file);
    }
    if tally.n_doubtful[0] > 0 {
        let [doubtful, wound, undecided] = tally.n_doubtful.map(HumanCount);
        text += &format!("Doubtful cells: {doubtful}; the solid angles of all facets were summed at {wound}, ");
        text += &format!("of which {undecided} are too close to call.\n");
    }
    scene.wrong_lines.iter().for_each(|sentence| text += &format!("Wrong lines: {sentence}.\n"));
    for &(cell, found, expected) in &tally.first {
        let [x, y, z] = [0, 1, 2].map(|axis| mesh.lines.centre(axis, cell[axis]));
        text += &format!("Wrong cell: {cell:?} at ({x}, {y}, {z}) has flag {found}, expected {expected}.\n");
    }
    if tally.n_wrong == 0 && scene.wrong_lines.is_empty() {
        return text + "All cells that were checked are as the job defines them.\n";
    }
    let n_wrong = HumanCount(tally.n_wrong);
    text + &format!("The mesh is not that of the job. Wrong cells: {n_wrong}. Mesh again, or give its own job.\n")
}
