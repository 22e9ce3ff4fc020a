//! `hexcast verify`: whether a column file holds the cells that its job defines.
//!
//! A second program in this one: it decides cells with nothing of the mesher's code. It shares the job and the reader of column files with it, and
//! two things that it says when it uses them: the readers of files that are not STL, which have tests of their own, and the generator
//! of lines, where a window or part of generated lines is to be placed among all of them. It
//! reads STL files, snaps corners and casts its own rays, across those of the mesh, through every cell.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;

use hexcast::control::{CancelToken, Control};
use hexcast::job::Job;
use hexcast::mesh::Mesh;
use hexcast::{Error, Result};
use indicatif::HumanCount;

use crate::files::reading;
use crate::options::arguments::{JobArguments, at_least_one, number};
use crate::screen::terminal;

mod lines;
mod ray;
mod scene;
mod slabs;
mod stl;
mod surface;
mod touched;

use scene::Scene;
use slabs::{Check, Tally};
use stl::{Solid, solids};

const EXAMPLES: &str = "\
Examples:
    hexcast verify part.hxc part.stl --cells 256
    hexcast verify part.hxc --job job.toml
    hexcast verify large.hxc --job job.toml --sample 1e9 --seed 7";

/// Exit code where the mesh is not that of the job.
const DIFFERS: u8 = 9;
/// Cells of a slab, where its planes are not larger, and bytes that each takes.
const SLAB: u64 = 1 << 24;
const CELL_BYTES: u64 = 5;

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
    arguments.job.set_threads(job.max_memory)?;
    let mut control = Control::default();
    control.cancel = token.clone();
    let max_bytes = job.max_memory.map_or(u64::MAX, |size| size.0);
    let mesh = reading::open_columns(&arguments.mesh, max_bytes / 2)?;
    let slabs = slabs(&mesh, &job, (arguments.sample, arguments.seed), max_bytes)?;
    let n_cells = slabs.iter().map(|slab| slab.len() as u64).sum::<u64>() * cells_of_plane(&mesh);
    let (files, shared) = files(&job, token)?;
    let is_cut = job.window.is_some() || job.part.is_some();
    let generated = match job.graded {
        Some(_) if is_cut => Some(reading::lines_of_box(&job, token)?),
        _ => None,
    };
    let scene = Scene::new(&job, &mesh, &files, generated.as_ref())?;
    drop(files);
    let edge = (job.halo_edge.unwrap_or_default(), arguments.seed);
    // cells of other lines are other cells
    let is_placed = scene.grid.wrong.is_empty();
    let tally = if is_placed { Check::new(&scene, &mesh, edge, &control).all(&slabs)? } else { Tally::default() };
    let first =
        format!("{}: {} of {} cells", arguments.mesh.display(), HumanCount(n_cells), HumanCount(mesh.n_cells()));
    let mut text = format!("{first} {}", about_facets(&scene, &mesh));
    shared.iter().for_each(|(file, format)| {
        text += &format!(
            "The facets of {file} ({format}) are as the mesher reads them: only STL is read by a second reader.\n"
        );
    });
    if generated.is_some() {
        text += "The lines of the whole box are as the mesher generates them; they were held to what is promised of them.\n";
    }
    terminal::print(&(text + &sentences(&scene, &mesh, &tally)))?;
    let is_right = tally.n_wrong == 0 && is_placed;
    Ok(if is_right { ExitCode::SUCCESS } else { ExitCode::from(DIFFERS) })
}

/// Files that the common readers read, and their formats.
type Formats = BTreeMap<String, &'static str>;

/// The solids of each entry of a job; and which files are not STL, with their format.
fn files(job: &Job, token: &CancelToken) -> Result<(Vec<Vec<Solid>>, Formats)> {
    let (mut files, mut shared) = (Vec::new(), BTreeMap::new());
    for (index, entry) in job.geometries.iter().enumerate() {
        let solids = match solids(&entry.file) {
            Err(error) if error.code() == "stl-not-stl" => match reading::solids_beside_stl(job, index, token) {
                Ok(Some((format, solids))) => {
                    shared.insert(entry.file.clone(), format);
                    solids
                }
                Err(other) if other.code() != error.code() => return Err(other),
                _ => return Err(error),
            },
            solids => solids?,
        };
        files.push(solids);
    }
    Ok((files, shared))
}

fn cells_of_plane(mesh: &Mesh) -> u64 {
    mesh.n_cells() / u64::from(mesh.columns().rays().counts[1])
}

/// Planes that hold about so many cells, evenly spaced; without a number all, as many to a slab as the memory holds.
fn slabs(mesh: &Mesh, job: &Job, (sample, seed): (Option<u64>, u64), max_bytes: u64) -> Result<Vec<Range<u32>>> {
    let (n_planes, cells) = (mesh.columns().rays().counts[1], cells_of_plane(mesh));
    let held = max_bytes / CELL_BYTES / rayon::current_num_threads() as u64;
    // gaps need planes beside those of a slab
    let more = u64::from(job.close_gaps.unwrap_or(0).min(n_planes)) * 2 * cells;
    let held = held.saturating_sub(more);
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

fn about_facets(scene: &Scene, mesh: &Mesh) -> String {
    let [nx, ny, nz] = mesh.dims();
    let across = ["x", "y", "z"][mesh.columns().rays().across[0]];
    let facets = HumanCount(scene.facets.len() as u64);
    format!("({nx} x {ny} x {nz}) checked against {facets} facets, by rays along {across}.\n")
}

fn sentences(scene: &Scene, mesh: &Mesh, tally: &Tally) -> String {
    let mut text = String::new();
    for body in scene.bodies.iter().filter(|body| body.open.is_some()) {
        text += &format!("{} is not closed.\n", body.file);
    }
    if tally.n_doubtful[0] > 0 {
        let [doubtful, wound, undecided] = tally.n_doubtful.map(HumanCount);
        text += &format!("Doubtful cells: {doubtful}; the solid angles of all facets were summed at {wound}, ");
        text += &format!("of which {undecided} are too close to call.\n");
    }
    scene.grid.wrong.iter().for_each(|sentence| text += &format!("Wrong lines: {sentence}.\n"));
    for &(cell, found, expected) in &tally.first {
        let [x, y, z] = [0, 1, 2].map(|axis| mesh.lines().centre(axis, cell[axis]));
        text += &format!("Wrong cell: {cell:?} at ({x}, {y}, {z}) has flag {found}, expected {expected}.\n");
    }
    if !scene.grid.wrong.is_empty() {
        return text
            + "The mesh is not that of the job; its cells were not checked. Mesh again, or give its own job.\n";
    }
    if tally.n_wrong == 0 {
        return text + "All cells that were checked are as the job defines them.\n";
    }
    let n_wrong = HumanCount(tally.n_wrong);
    text + &format!("The mesh is not that of the job. Wrong cells: {n_wrong}. Mesh again, or give its own job.\n")
}
