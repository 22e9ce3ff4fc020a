//! AMReX: the embedded boundary of one fluid, as the folder that `EB2::BuildFromChkptFile` reads.
//!
//! `Header` has the box, and its grids of at most [`MAX_GRID`] cells: those that the surface passes through, and those without fluid. `Level_0` has 15 arrays on the former:
//! volume fractions and centres of cells, area, centre and normal of the surface in them, area fractions and centres of faces, centres of what edges have of the fluid, and the level set
//! at nodes. Each is a file of text, `NAME_H`, and one of numbers, `NAME_D_00000`. `inputs` has the lines by which a solver gets the same box.
//!
//! What AMReX checks as it reads has its defaults: grids reach [`GROW`] cells past the sides of the box, which are not periodic and continue what is at them, and
//! arrays have [`grid::GHOSTS`] more cells around each grid. AMReX makes coarser levels itself.
//!
//! Source: AMReX, `Src/EB` and `VisMF`. Cost: two bytes for each cell of the box, and the numbers of one grid.

mod boundary;
mod grid;
mod numbers;
mod parts;

use crate::export::{
    format::Format,
    limits::{equal_cells, fluid},
    options::ExportOptions,
    output::{Export, Files, Out},
};
use boundary::Boundary;
use grid::Grid;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;
use hexcast_derived::mesh::outline::Outline;
use numbers::Array;

/// Most cells of a grid along an axis, before it grows: AMReX's `eb2.max_grid_size`.
const MAX_GRID: i32 = 64;
/// Cells by which grids reach past the sides of the box, or as many as the box has.
const GROW: i32 = 16;
/// Cells on an axis that AMReX can number with all that is around them.
const MAX_CELLS: u32 = 1 << 30;

pub(in crate::export) static FORMAT: Format = Format {
    program: "AMReX",
    about: "exact cut cells for incflo, PeleC, MFIX-Exa",
    on_disk: "a folder of that name",
    cuts: true,
    is_boundary: true,
    held: ("cut cells", |mesh| 2 * mesh.n_cells()),
    file_names,
    check_lines: |lines| {
        equal_cells(lines, "AMReX")?;
        match lines.dims().iter().max() {
            Some(&most) if most > MAX_CELLS => {
                let message = format!("{most} cells on an axis: AMReX numbers up to {MAX_CELLS}");
                Err(Error::new("export-too-large", message, "mesh with larger cells"))
            }
            _ => Ok(()),
        }
    },
    check_mesh,
    ..Format::new(&[".eb"], |job, name, files| Box::pin(write(job, name, files)))
};

fn file_names(name: &str) -> Vec<String> {
    let arrays = Array::ALL.iter().flat_map(|array| [array.data_of(name), array.head_of(name)]);
    arrays.chain(["Header", "inputs"].map(|file| format!("{name}/{file}"))).collect()
}

fn check_mesh(mesh: &Mesh, _: &ExportOptions, keeps: &[bool; 256]) -> Result<()> {
    parts(mesh, keeps).map(|_| ())
}

/// The outline of the one flag that is kept, with its parts.
///
/// # Errors
/// `job-conflict` where there is none.
fn parts<'a>(mesh: &'a Mesh, keeps: &[bool; 256]) -> Result<&'a Outline> {
    let outline = fluid(mesh, keeps)?;
    if outline.parts.len() < outline.cells.len() {
        let message = "an embedded boundary is asked for, and the mesh does not know what the fluid has of faces";
        return Err(Error::new("job-conflict", message, "mesh with cut_cells.boundary = true, as hexcast mesh does for this output"));
    }
    Ok(outline)
}

/// The grids of a box.
#[derive(Default)]
struct Grids {
    cut: Vec<Grid>,
    covered: Vec<Grid>,
}

impl Grids {
    fn new(boundary: &Boundary) -> Grids {
        let (mut grids, dims) = (Grids::default(), boundary.dims);
        let starts = dims.map(|n| (0..n).step_by(MAX_GRID as usize));
        for z in starts[2].clone() {
            for y in starts[1].clone() {
                for x in starts[0].clone() {
                    let low = [x, y, z];
                    let high = [0, 1, 2].map(|axis| (low[axis] + MAX_GRID).min(dims[axis]) - 1);
                    let grid = Grid { low, high };
                    let of_grid = match boundary.is_all_fluid(grid.grown(1)) {
                        Some(true) => continue,
                        Some(false) => &mut grids.covered,
                        None => &mut grids.cut,
                    };
                    let grow = dims.map(|n| GROW.min(n));
                    let low = [0, 1, 2].map(|axis| if low[axis] == 0 { -grow[axis] } else { low[axis] });
                    let end = |axis: usize| if high[axis] == dims[axis] - 1 { grow[axis] } else { 0 };
                    of_grid.push(Grid { low, high: [0, 1, 2].map(|axis| high[axis] + end(axis)) });
                }
            }
        }
        grids
    }
}

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let outline = parts(job.mesh, &job.options.selection(job.mesh, false)?)?;
    let boundary = Boundary::new(job.mesh, outline, &job.control.without_pauses())?;
    job.say(boundary.lacks());
    let grids = Grids::new(&boundary);
    if grids.cut.is_empty() {
        let message = "no surface passes through the box, or no cell is left to the fluid: there is no embedded boundary";
        return Err(Error::new("job-conflict", message, "use smaller cells, or a box that the surface passes through"));
    }
    for array in Array::ALL {
        numbers::write(&boundary, &grids.cut, (array, name), files, job.control).await?;
    }
    let lines = job.mesh.lines();
    let ends = [0, 1].map(|end| [0, 1, 2].map(|axis| lines.line(axis, end * lines.dims()[axis])));
    let [low, high] = ends.map(|place| place.map(|of| format!("{of:?}")).join(" "));
    let mut out = Out::create(files, &format!("{name}/Header"))?;
    let grow = boundary.dims.map(|n| GROW.min(n).to_string()).join(" ");
    out.text(format_args!("Checkpoint version: 1\n1\n{low} \n{high} \n{grow} \n1\n{MAX_GRID}\n"))?;
    for list in [&grids.cut, &grids.covered] {
        if !list.is_empty() {
            numbers::list(&mut out, list, [false; 3])?;
        }
    }
    out.finish()?;
    let [nx, ny, nz] = boundary.dims;
    let mut out = Out::create(files, &format!("{name}/inputs"))?;
    out.text(format_args!(
        "geometry.coord_sys = 0\ngeometry.prob_lo = {low}\ngeometry.prob_hi = {high}\ngeometry.is_periodic = 0 0 0\namr.n_cell = {nx} {ny} {nz}\n"
    ))?;
    out.finish()
}
