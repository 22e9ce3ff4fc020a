//! Leaks: whether a path leads from one point of a mesh to another, the shortest one, and its narrowest place.
//!
//! Mesh, two points, the flags that are open -> [`Leak`]. A path goes from cell to cell over faces. The cells are never
//! expanded: all work is done on open runs, see `passage`.
//!
//! 1. `rooms` decides whether there is a path: it unites runs that touch.
//! 2. `shortest` finds one with the fewest steps. The number of steps does not depend on the ray axis; which of several
//!    shortest paths is found may.
//! 3. `widest` finds the largest cube of cells that passes and the place that stops a larger one. That place need not be on
//!    the shortest path: where two holes lead out, the shortest path takes the nearer one, and the cube the wider one.
//!
//! Cost: the rooms take two passes over the runs, and rooms and runs together 12 bytes an open run and 4 a ray. Where there
//! is a path, up to 11 passes for the widest cube, and two searches, at worst over all runs of the room.

use serde::Serialize;

use crate::mesh::Mesh;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::beside;
use hexcast_core::base::sort::sort;
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::geometry::Geometry;

mod facets;
pub(crate) mod passage;
pub(crate) mod rooms;
mod shortest;
mod widest;

pub use facets::{NearFacet, facets_near};
use passage::{Passage, Place};
use rooms::Rooms;
use shortest::{Steps, shortest};
pub use widest::MAX_WIDTH;
use widest::{Cubes, Widest, widest};

/// Which leak is looked for.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Question {
    /// Where a path may begin, in world coordinates.
    pub from: [f64; 3],
    /// Where it may end.
    pub to: [f64; 3],
    /// The flags of cells that a path may use; empty for the flag of the cell at `from`.
    pub flags: Vec<u8>,
    /// Most bytes of memory, besides what the mesh takes.
    pub max_bytes: u64,
}

impl Question {
    /// Asks whether a path leads from one point to another, in world coordinates, by cells of the flag at the first.
    pub fn new(from: [f64; 3], to: [f64; 3]) -> Question {
        Question { from, to, flags: Vec::new(), max_bytes: u64::MAX }
    }

    /// Names the flags of cells that a path may use.
    pub fn with_flags(self, flags: Vec<u8>) -> Question {
        Question { flags, ..self }
    }

    /// Limits the memory, besides what the mesh takes.
    pub fn with_max_bytes(self, max_bytes: u64) -> Question {
        Question { max_bytes, ..self }
    }
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Leak {
    /// The flags of cells that a path may use.
    pub flags: Vec<u8>,
    /// Where paths begin.
    pub from: End,
    /// Where they end.
    pub to: End,
    /// A shortest path; none where the mesh is tight.
    pub path: Option<Path>,
    /// The narrowest place; none where there is no path, or a cube of [`MAX_WIDTH`] cells passes.
    pub narrowest: Option<Narrowest>,
}

/// An end of the paths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct End {
    /// The point, in world coordinates.
    pub point: [f64; 3],
    /// The cell that holds it.
    pub cell: [u32; 3],
    /// Flag of the cell.
    pub flag: u8,
    /// Number of cells that paths from it reach.
    pub n_cells: u64,
}

/// A path over faces of cells.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Path {
    /// Number of steps from cell to cell.
    pub steps: u64,
    /// Length from the centre of the first cell to that of the last, in the unit of the mesh.
    pub length: f64,
    /// The cells x, y, z at which it begins, turns and ends; neighbours in the list differ on one axis.
    pub cells: Vec<[u32; 3]>,
    /// The centres of these cells, in world coordinates.
    pub points: Vec<[f64; 3]>,
}

/// The place that stops a larger cube.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Narrowest {
    /// Edge in cells of the largest cube of open cells that passes.
    pub width: u32,
    /// First cell of the cube in the middle of the narrowest place, and the cell after its last, on each axis.
    pub cells: [[u32; 3]; 2],
    /// The corners of these cells, in world coordinates.
    pub bounds: [[f64; 3]; 2],
    /// Their centre.
    pub centre: [f64; 3],
    /// The way of the cube, as its centres where it begins, turns and ends, in world coordinates.
    pub way: Vec<[f64; 3]>,
}

/// Cells around the narrowest place in which facets are named.
const CELLS_AROUND: u32 = 1;

/// A leak with the unit of its mesh and the facets around its narrowest place.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Answer {
    /// What was found.
    #[serde(flatten)]
    pub leak: Leak,
    /// Whether there is no path.
    pub is_tight: bool,
    /// Unit of lengths, if the mesh has one.
    pub unit: Option<String>,
    /// Facets within a cell of the narrowest place; none where no surfaces were given.
    pub facets: Option<Vec<NearFacet>>,
}

impl Answer {
    /// Names the facets of `surfaces`, if any are given.
    ///
    /// # Errors
    /// `io` where facets stay in their file, and that cannot be read again.
    pub fn new(leak: Leak, mesh: &Mesh, surfaces: Option<&[Geometry]>) -> Result<Answer> {
        let around = leak.narrowest.as_ref().map(|place| place.bounds_with(&mesh.lines, CELLS_AROUND));
        let near =
            |surfaces: &[Geometry]| around.map_or_else(|| Ok(Vec::new()), |around| facets_near(surfaces, around));
        let facets = surfaces.map(near).transpose()?;
        Ok(Answer { is_tight: leak.path.is_none(), unit: mesh.unit.clone(), facets, leak })
    }
}

/// Looks for a path from one point of a mesh to another.
///
/// # Errors
/// - `job-value` where a point lies outside of the mesh, or in a cell whose flag is not open;
/// - `job-conflict` where no flags are given and the points are in cells of different flags;
/// - `memory` where the runs, or the search, take more than is allowed;
/// - `io` where the columns are in a store that fails;
/// - `cancelled`.
pub fn leak(mesh: &Mesh, question: &Question, control: &Control) -> Result<Leak> {
    let [mut from, mut to] = [end(mesh, question.from, "start")?, end(mesh, question.to, "end")?];
    let flags = open_flags(question, &from, &to)?;
    let max_bytes = question.max_bytes.saturating_sub(check_memory(&mesh.columns, question.max_bytes)?);
    let mut is_open = [false; 256];
    flags.iter().for_each(|&flag| is_open[usize::from(flag)] = true);
    let passage = Passage::new(&mesh.columns, &is_open, control)?;
    let rooms = Rooms::new(&passage);
    let rays = mesh.columns.rays();
    let ends = [place_of(rays, from.cell), place_of(rays, to.cell)];
    let room_of_end = ends.map(|place| rooms.at(&passage, place));
    for (end, room) in [&mut from, &mut to].into_iter().zip(room_of_end) {
        end.n_cells = room.map_or(0, |room| rooms.n_cells(&passage, room));
    }
    if room_of_end[0] != room_of_end[1] {
        return Ok(Leak { flags, from, to, path: None, narrowest: None });
    }
    let cells = Cubes { passage, rooms };
    let rank = |place| rays.cell(place);
    // both searches at the same time share what memory is left
    let mut found = Ok(None);
    let steps = beside(
        || found = widest(&cells, ends, &rank, max_bytes / 2, control),
        || shortest(&cells.passage, ends[0], ends[1], max_bytes / 2, control),
    )?;
    let path = steps.map(|steps| Path::new(&mesh.lines, rays, &steps));
    let narrowest = found?.map(|widest| Narrowest::new(mesh, &widest));
    Ok(Leak { flags, from, to, path, narrowest })
}

impl Path {
    fn new(lines: &Lines, rays: &Rays, steps: &Steps) -> Path {
        let cells: Vec<[u32; 3]> = steps.corners.iter().map(|&place| rays.cell(place)).collect();
        let points = cells.iter().map(|&cell| middle(lines.corners([cell, cell.map(|at| at + 1)]))).collect();
        let length = (0..3).map(|axis| length_along(lines, &cells, axis)).sum();
        Path { steps: steps.n, length, cells, points }
    }
}

/// Length along an axis of the way through the centres of some cells.
fn length_along(lines: &Lines, cells: &[[u32; 3]], axis: usize) -> f64 {
    let steps = cells.windows(2).map(|pair| [pair[0][axis], pair[1][axis]]);
    match lines.spacing() {
        Some(spacing) => steps.map(|[from, to]| u64::from(from.abs_diff(to))).sum::<u64>() as f64 * spacing[axis],
        None => steps.map(|step| step.map(|cell| lines.centre(axis, cell))).map(|[from, to]| (to - from).abs()).sum(),
    }
}

impl Narrowest {
    fn new(mesh: &Mesh, widest: &Widest) -> Narrowest {
        let (lines, rays) = (&mesh.lines, mesh.columns.rays());
        // a place stands for the cells up to it; the cube may hang over the mesh
        let cells_of = |place: Place| {
            let last = rays.cell(place);
            let low = last.map(|at| at.saturating_sub(widest.width - 1));
            [low, [0, 1, 2].map(|axis| (last[axis] + 1).min(lines.dims()[axis]))]
        };
        let way = widest.way.iter().map(|&place| middle(lines.corners(cells_of(place)))).collect();
        let cells = cells_of(widest.narrowest);
        let bounds = lines.corners(cells);
        Narrowest { width: widest.width, cells, bounds, centre: middle(bounds), way }
    }

    /// The bounds with some more cells on every side, for what lies around the place.
    pub fn bounds_with(&self, lines: &Lines, more: u32) -> [[f64; 3]; 2] {
        let [low, high] = self.cells;
        let high = [0, 1, 2].map(|axis| high[axis].saturating_add(more).min(lines.dims()[axis]));
        lines.corners([low.map(|at| at.saturating_sub(more)), high])
    }
}

fn middle([low, high]: [[f64; 3]; 2]) -> [f64; 3] {
    [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis]))
}

fn place_of(rays: &Rays, cell: [u32; 3]) -> Place {
    [cell[rays.across[0]], cell[rays.across[1]], cell[rays.axis]]
}

/// Finds the cell that holds a point. A point on a line belongs to the cell above, on the last line to the cell below.
fn end(mesh: &Mesh, point: [f64; 3], name: &str) -> Result<End> {
    let lines = &mesh.lines;
    let cell_on = |axis: usize| {
        let n = lines.dims()[axis];
        let (low, high) = (lines.line(axis, 0), lines.line(axis, n));
        // false for NaN, too
        if !(low <= point[axis] && point[axis] <= high) {
            return None;
        }
        let guess = lines.position(axis, point[axis]) as u32;
        // rounding may be off by a cell
        let near = guess.saturating_sub(1)..guess.saturating_add(2).min(n);
        near.rev().find(|&index| lines.line(axis, index) <= point[axis])
    };
    let [Some(x), Some(y), Some(z)] = [cell_on(0), cell_on(1), cell_on(2)] else {
        let [low, high] = lines.corners([[0; 3], lines.dims()]);
        let message = format!(
            "the {name} {} lies outside of the mesh, which reaches from {} to {}",
            tuple(point),
            tuple(low),
            tuple(high)
        );
        let hint = "name a point inside, in the unit of the mesh; or mesh again with padding (--padding-cells)";
        return Err(Error::new("job-value", message, hint));
    };
    let cell = [x, y, z];
    Ok(End { point, cell, flag: mesh.flag(cell)?, n_cells: 0 })
}

/// The flags that a path may use, ascending, of which both ends must have one.
fn open_flags(question: &Question, from: &End, to: &End) -> Result<Vec<u8>> {
    if question.flags.is_empty() {
        if from.flag != to.flag {
            let message = format!("{}, but {}", of_end("start", from), of_end("end", to));
            let hint = "name two points of one flag, or say which flags a path may use (flags, --flags 0,1)";
            return Err(Error::new("job-conflict", message, hint));
        }
        return Ok(vec![from.flag]);
    }
    let mut flags = question.flags.clone();
    sort(&mut flags);
    flags.dedup();
    for (name, end) in [("start", from), ("end", to)] {
        if !flags.contains(&end.flag) {
            let message = format!("{}, and a path may only use {}", of_end(name, end), list(&flags));
            let hint = format!("name another point, or add {} to the flags (flags, --flags)", end.flag);
            return Err(Error::new("job-value", message, hint));
        }
    }
    Ok(flags)
}

fn of_end(name: &str, end: &End) -> String {
    let cell = end.cell.map(f64::from);
    format!("the {name} {} is in cell {} of flag {}", tuple(end.point), tuple(cell), end.flag)
}

fn tuple([x, y, z]: [f64; 3]) -> String {
    format!("({x}, {y}, {z})")
}

fn list(flags: &[u8]) -> String {
    let numbers: Vec<String> = flags.iter().map(u8::to_string).collect();
    format!("flag{} {}", if flags.len() == 1 { "" } else { "s" }, numbers.join(", "))
}

/// Passages in memory at once: two trials of the widest cube, with the one that is made from them counted twice.
const N_PASSAGES: u64 = 4;

/// Bytes that rays and open runs take at most.
fn check_memory(columns: &Columns, max_bytes: u64) -> Result<u64> {
    let [n, m] = columns.rays().counts.map(|n| u64::from(n) + u64::from(MAX_WIDTH));
    // open and closed runs take turns on a ray
    let n_runs = columns.n_runs() / 2 + n * m;
    let needed = N_PASSAGES * (4 * n * m + 12 * n_runs);
    if needed > max_bytes || n * m > u64::from(u32::MAX) {
        let message = format!("the open cells of {} rays take {needed} bytes; {max_bytes} are allowed", n * m);
        return Err(Error::new("memory", message, "allow more (max_memory, --max-memory), or use larger cells"));
    }
    Ok(needed)
}
