//! The skin: the stair-step surface of a mesh, for a view in three dimensions.
//!
//! Mesh, a box of its cells -> [`Skin`], the rectangles of each flag. A face lies between two cells of different flags, or between a
//! flagged cell and the outside of the box, and belongs to the flagged cell; between two flags it is there for both. So
//! the faces of every flag are a closed surface by themselves, whatever else is hidden.
//!
//! The cells are never expanded. Runs of neighbouring rays give spans of faces; spans of consecutive rows that begin and
//! end alike become one rectangle: see `faces`. Where that still gives more rectangles than the caller wants, the mesh is
//! coarsened by two on every axis: see `level`. Rectangles meet in T-junctions, but their corners are on mesh lines, so
//! that there are no gaps. Which rectangles cover a surface depends on the ray axis; the surface does not.
//!
//! Cost: O(runs + rectangles) time; 72 bytes a rectangle for the result and 24 to 48 more while it grows, the spans of
//! some rows, and when coarsened a set of coarse runs of about a quarter of the columns.

use std::ops::Range;

use hexcast_core::base::parallel::*;

use crate::mesh::Mesh;
use crate::mesh::level::{Level, Levels, ROWS, by_rarity};
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::flags::CellBox;

mod faces;
mod slice;

use faces::{Quad, Sweep, row_faces};

pub use slice::{Slice, slice};

/// Most rectangles of a skin: their corners must fit a 32-bit index.
pub const MAX_QUADS: usize = 1 << 30;

/// The stair-step surface of a box of cells.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Skin {
    /// Edge of the cells whose surface this is, in cells of the mesh: a power of 2; 1 is the mesh itself.
    pub step: u32,
    /// Number of cell faces before they were joined to rectangles, of the cells of that edge.
    pub n_faces: u64,
    /// The surface of every flag that the box holds, ascending by flag.
    pub parts: Vec<SkinPart>,
}

impl Skin {
    /// Number of rectangles of all parts.
    pub fn n_quads(&self) -> usize {
        self.parts.iter().map(SkinPart::n_quads).sum()
    }
}

/// The closed surface of one flag.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct SkinPart {
    /// The flag, 1 to 255.
    pub flag: u8,
    /// Corners, x, y, z, four of a rectangle in a row; length `12 * n_quads`. Counted in mesh lines from the first line of
    /// the mesh (not of the box), so exact in f32: the world coordinate is `origin + position * spacing`.
    pub positions: Vec<f32>,
    /// Corners of the triangles, two of a rectangle in a row, counter-clockwise seen from outside; length `6 * n_quads`.
    pub indices: Vec<u32>,
    /// End in rectangles (exclusive) of those that face -x, +x, -y, +y, -z and +z, which follow each other in this order.
    pub ends: [u32; 6],
}

impl SkinPart {
    /// Number of rectangles.
    pub fn n_quads(&self) -> usize {
        self.indices.len() / 6
    }

    /// Direction of a rectangle: 0 to 5 for -x, +x, -y, +y, -z, +z.
    pub fn direction(&self, quad: usize) -> usize {
        self.ends.partition_point(|&end| end as usize <= quad)
    }
}

/// Builds the surface of a mesh, or of a box of its cells, from at most `max_quads` rectangles.
///
/// Where one rectangle more were needed, the mesh is coarsened by two on every axis until it fits; a single coarse cell is
/// taken however many rectangles it has. A coarse cell is flagged if any cell in it is, so that thin parts stay, and of
/// several flags takes the one with the fewest cells in the mesh. The coarse surface is thus never inside the exact one,
/// and outside it by less than a coarse cell; gaps narrower than that may close. Coarse cells are counted from the first
/// line of the mesh and end where the box ends. The result does not depend on the number of threads.
///
/// # Errors
/// - `job-value` where the box reaches past the mesh or ends before it starts;
/// - `io` where the columns are in a store that fails;
/// - `cancelled`, looked at every few rows of rays.
pub fn skin(mesh: &Mesh, max_quads: usize, cells: Option<CellBox>, control: &Control) -> Result<Skin> {
    at_once(skin_with_rests(mesh, max_quads, cells, &control.without_pauses()))
}

/// Like [`skin()`], with a rest every few rows of rays ([`Control::rest`]).
///
/// # Errors
/// Those of [`skin()`].
#[doc(hidden)]
pub async fn skin_with_rests(mesh: &Mesh, max_quads: usize, cells: Option<CellBox>, control: &Control) -> Result<Skin> {
    let dims = mesh.dims();
    let cells = cells.unwrap_or(dims.map(|n| 0..n));
    check_box(&cells, dims)?;
    control.check()?;
    if cells.iter().any(|range| range.is_empty()) {
        return Ok(Skin { step: 1, n_faces: 0, parts: Vec::new() });
    }
    let mut level = Level::fine(&mesh.columns, &cells)?;
    let mut order = None;
    loop {
        let max_quads = if level.is_single() { MAX_QUADS } else { max_quads.min(MAX_QUADS) };
        if let Some((n_faces, quads)) = level_quads(&level, max_quads, control).await? {
            return Ok(Skin { step: level.step, n_faces, parts: parts(mesh, &cells, level.step, &quads) });
        }
        let order = order.get_or_insert_with(|| by_rarity(&mesh.columns));
        level = level.coarser(order, Levels::Any, control).await?;
    }
}

/// Number of faces of the surfaces of all flags of a mesh, from its runs.
///
/// # Errors
/// `io` where the columns are in a store that fails.
#[doc(hidden)]
pub fn n_faces(mesh: &Mesh) -> Result<u64> {
    let level = Level::fine(&mesh.columns, &mesh.dims().map(|n| 0..n))?;
    let rows = level.across[1].start..level.across[1].end + 1;
    Ok(rows.into_par_iter().map(|row| row_faces(&level, row).n_faces).sum())
}

/// Refuses a box of cells that is not one of a mesh of so many.
///
/// # Errors
/// `job-value`.
#[doc(hidden)]
pub fn check_box(cells: &CellBox, dims: [u32; 3]) -> Result<()> {
    if (0..3).any(|axis| cells[axis].end > dims[axis] || cells[axis].start > cells[axis].end) {
        let [nx, ny, nz] = dims;
        let corner = |end: fn(&Range<u32>) -> u32| cells.each_ref().map(|range| end(range).to_string()).join(",");
        let (first, end) = (corner(|range| range.start), corner(|range| range.end));
        let message = format!("the box from cell {first} to {end} is not inside the mesh of {nx} x {ny} x {nz} cells");
        return Err(Error::new("job-value", message, "give the first cell on x, y and z, and the end, exclusive"));
    }
    Ok(())
}

/// Rectangles by the axes they lie on: across the rays' axis, across the first and across the second axis across the rays;
/// of each those that face down, then those that face up.
type Quads = [[Vec<Quad>; 2]; 3];

/// Number of faces and rectangles of a level; none where there would be more than `max_quads`.
async fn level_quads(level: &Level<'_>, max_quads: usize, control: &Control) -> Result<Option<(u64, Quads)>> {
    let mut sweeps: [Sweep; 4] = Default::default();
    let mut between: [Vec<Quad>; 2] = Default::default();
    let mut n_faces = 0;
    // one more row than there are rays: the faces after the last ray
    let rows = level.across[1].start..level.across[1].end + 1;
    for start in rows.clone().step_by(ROWS) {
        control.rest().await?;
        let end = start.saturating_add(ROWS as u32).min(rows.end);
        let mut found: Vec<_> = (start..end).into_par_iter().map(|row| row_faces(level, row)).collect();
        sweeps.par_iter_mut().enumerate().for_each(|(index, sweep)| {
            for (row, faces) in (start..end).zip(&found) {
                sweep.push(row, &faces.spans[index / 2][index % 2]);
            }
        });
        for faces in &mut found {
            n_faces += faces.n_faces;
            for side in 0..2 {
                between[side].append(&mut faces.between[side]);
            }
        }
        let n_quads = sweeps.iter().map(|sweep| sweep.quads.len()).chain(between.iter().map(Vec::len));
        if n_quads.sum::<usize>() > max_quads {
            return Ok(None);
        }
    }
    // the row after the last ray has no spans and so has closed every rectangle
    let [ends_down, ends_up, sides_down, sides_up] = sweeps.map(|sweep| sweep.quads);
    Ok(Some((n_faces, [[ends_down, ends_up], [sides_down, sides_up], between])))
}

/// Sorts rectangles by flag and direction, and gives them corners.
fn parts(mesh: &Mesh, cells: &CellBox, step: u32, quads: &Quads) -> Vec<SkinPart> {
    let rays = mesh.columns.rays();
    let [first, second] = rays.across;
    // axes of the plane, of the spans and of the rows
    let axes = [[rays.axis, first, second], [first, rays.axis, second], [second, rays.axis, first]];
    let mut n_quads = [0usize; 256];
    quads.iter().flatten().flatten().for_each(|quad| n_quads[usize::from(quad.span.flag)] += 1);
    let mut parts: Vec<SkinPart> = Vec::new();
    let mut index = [0usize; 256];
    for flag in (0..=255u8).filter(|&flag| n_quads[usize::from(flag)] > 0) {
        let n = n_quads[usize::from(flag)];
        let (positions, indices) = (Vec::with_capacity(12 * n), Vec::with_capacity(6 * n));
        index[usize::from(flag)] = parts.len();
        parts.push(SkinPart { flag, positions, indices, ends: [0; 6] });
    }
    for direction in 0..6 {
        // every axis is that of the plane in exactly one of the three
        let kind = (0..3).find(|&kind| axes[kind][0] == direction / 2).unwrap_or(0);
        for quad in &quads[kind][direction % 2] {
            let part = &mut parts[index[usize::from(quad.span.flag)]];
            push_quad(
                part,
                corners(quad, axes[kind], direction % 2 == 1, |axis, line| {
                    let Some(line) = line.checked_mul(step) else { return cells[axis].end as f32 };
                    line.clamp(cells[axis].start, cells[axis].end) as f32
                }),
            );
        }
        parts.iter_mut().for_each(|part| part.ends[direction] = part.n_quads() as u32);
    }
    parts
}

/// Corners of a rectangle, counter-clockwise seen from where it faces: up, or down its plane's axis.
fn corners(quad: &Quad, axes: [usize; 3], up: bool, line: impl Fn(usize, u32) -> f32) -> [[f32; 3]; 4] {
    let [plane, along, across] = axes;
    let height = line(plane, quad.span.plane);
    let ends = [line(along, quad.span.start), line(along, quad.span.end)];
    let rows = [line(across, quad.rows[0]), line(across, quad.rows[1])];
    let corner = |end: usize, row: usize| {
        let mut corner = [0.0; 3];
        corner[plane] = height;
        corner[along] = ends[end];
        corner[across] = rows[row];
        corner
    };
    // spans x rows points up the plane's axis where the three axes are in cyclic order
    if up == ((plane + 1) % 3 == along) {
        [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]
    } else {
        [corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)]
    }
}

fn push_quad(part: &mut SkinPart, corners: [[f32; 3]; 4]) {
    let first = (part.positions.len() / 3) as u32;
    part.positions.extend(corners.as_flattened());
    part.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
}

#[cfg(test)]
mod tests;
