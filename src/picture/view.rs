//! Views: the stair-step surface of a mesh from a direction, in parallel projection.
//!
//! Rectangles of the skin -> for every pixel the nearest one, by its depth. A rectangle is a parallelogram on the picture: a pixel lies in it
//! where its two coordinates along the sides are within 0 and 1. Each pixel is the mean of [`FINE`] x [`FINE`]; sides are
//! brighter the more they face the light, and darker at the edges of flags and of what stands before something else.
//! Cost: O(rectangles) a band of rows, and O(pixels) a rectangle that is seen.

use glam::DVec3;

use super::canvas::{LINE, Picture, WHITE, colour, legend_height};
use super::{MARGIN, coordinate, legend};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::flags::CellBox;
use crate::mesh::Mesh;
use crate::parallel::*;
use crate::skin::{Skin, SkinPart, skin};

/// Points of a pixel on each side.
const FINE: u32 = 2;
/// Rows of points that a thread draws at a time.
const ROWS: usize = 64;
/// Most rectangles; a mesh of more is drawn with coarser cells.
const MAX_QUADS: usize = 4_000_000;
/// How far outside a rectangle a point still counts, in its sides: more than rounding, less than a gap.
const ROUNDING: f64 = 1e-9;

/// From where, and what of it is seen.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// Direction to the eye, in degrees: around z from x, and up from the plane of x and y.
    pub from: [f64; 2],
    /// Pixels of the longer side.
    pub size: u32,
    /// Flags that are shown; all if there is none.
    pub flags: Vec<u8>,
    /// Cells that are shown; all if None.
    pub cells: Option<CellBox>,
}

impl Default for View {
    fn default() -> View {
        View { from: [-60.0, 25.0], size: 1000, flags: Vec::new(), cells: None }
    }
}

/// Right, up and towards the eye.
struct Eye {
    axes: [DVec3; 3],
}

impl Eye {
    fn new([around, up]: [f64; 2]) -> Eye {
        let ((s, c), (t, d)) = (libm::sincos(around.to_radians()), libm::sincos(up.to_radians()));
        Eye { axes: [DVec3::new(-s, c, 0.0), DVec3::new(-t * c, -t * s, d), DVec3::new(d * c, d * s, t)] }
    }

    /// A point as seen: right, up, and how near.
    fn seen(&self, point: DVec3) -> DVec3 {
        DVec3::from(self.axes.map(|axis| axis.dot(point)))
    }
}

/// A rectangle as seen: a corner and two sides.
struct Seen {
    corner: DVec3,
    sides: [DVec3; 2],
    flag: u8,
    direction: u8,
}

impl Seen {
    fn corners(&self) -> [DVec3; 4] {
        let [u, v] = self.sides;
        [DVec3::ZERO, u, v, u + v].map(|side| self.corner + side)
    }
}

/// The nearest rectangle at a point: how near, its flag, and the direction that it faces.
#[derive(Clone, Copy)]
struct Nearest {
    depth: f64,
    flag: u8,
    direction: u8,
}

const NOTHING: Nearest = Nearest { depth: f64::NEG_INFINITY, flag: 0, direction: 0 };

/// Draws the surface of a mesh, with a legend of the flags on it.
///
/// # Errors
/// `job-value` where the picture would have no pixel or more than 32,768 on a side, or the cells are not those of the mesh; `io` where the
/// columns are in a store that fails; `cancelled`.
pub fn view(mesh: &Mesh, view: &View, control: &Control) -> Result<Picture> {
    if !view.from.iter().all(|angle| angle.is_finite()) || view.size == 0 {
        let message = format!("a view from {:?} degrees in {} pixels", view.from, view.size);
        return Err(Error::new("job-value", message, "give two finite angles, and at least one pixel"));
    }
    let skin = skin(mesh, MAX_QUADS, view.cells.clone(), control)?;
    let eye = Eye::new(view.from);
    let mut quads: Vec<Seen> = skin.parts.iter().flat_map(|part| seen(part, mesh, &eye)).collect();
    if quads.is_empty() {
        let hint = "show other cells, or mesh surfaces that hold centres of cells";
        return Err(Error::new("job-value", "no cell has a flag: there is nothing to see", hint));
    }
    // around all flags, whichever are shown, so that views of each have one scale
    let ends = quads.iter().flat_map(Seen::corners);
    let (low, high) = ends.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), at| (l.min(at), h.max(at)));
    quads.retain(|quad| view.flags.is_empty() || view.flags.contains(&quad.flag));
    let extent = high - low;
    let pixels = f64::from(view.size) / extent.x.max(extent.y);
    let [width, height] = [extent.x, extent.y].map(|length| (length * pixels).round().max(1.0) as u32);
    let step = (high.z - low.z) / f64::from(mesh.dims().into_iter().max().unwrap_or(1));
    let fine = [width * FINE, height * FINE];
    let nearest = nearest(&quads, fine, |[column, row]| {
        let [x, y] = [f64::from(column) + 0.5, f64::from(row) + 0.5].map(|at| at / f64::from(FINE) / pixels);
        [low.x + x, high.y - y]
    });
    control.check()?;
    let mut flags: Vec<u8> = nearest.iter().map(|at| at.flag).filter(|&flag| flag != 0).collect();
    flags.dedup();
    let legend = legend(mesh, flags);
    let texts = descriptions(mesh, view, &skin);
    let whole = width.max(320) + 2 * MARGIN;
    let below = MARGIN + height + MARGIN;
    let mut picture = Picture::new(whole, below + 2 * LINE + legend_height(whole, &legend) + MARGIN)?;
    let shades = shades(&nearest, fine, &eye, step * f64::from(skin.step));
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let points = (0..FINE * FINE).map(|at| [x * FINE + at % FINE, y * FINE + at / FINE]);
        let sum = points.fold([0u32; 3], |sum, [x, y]| {
            let rgb = shades[y as usize * fine[0] as usize + x as usize];
            [0, 1, 2].map(|channel| sum[channel] + u32::from(rgb[channel]))
        });
        picture.set(MARGIN + x, MARGIN + y, sum.map(|channel| (channel / (FINE * FINE)) as u8));
    }
    for (index, text) in (0..).zip(&texts) {
        picture.text([MARGIN, below + index * LINE], text, whole - 2 * MARGIN);
    }
    picture.legend(below + 2 * LINE, &legend);
    Ok(picture)
}

/// The rectangles of a flag that face the eye.
fn seen<'a>(part: &'a SkinPart, mesh: &'a Mesh, eye: &'a Eye) -> impl Iterator<Item = Seen> + 'a {
    let place = |corner: &[f32]| {
        let lines = [0, 1, 2].map(|axis| mesh.lines.line(axis, corner[axis] as u32));
        eye.seen(lines.into())
    };
    let quads = part.positions.chunks_exact(12).enumerate();
    quads.filter_map(move |(quad, corners)| {
        let direction = part.direction(quad);
        let towards = eye.axes[2][direction / 2] * if direction % 2 == 1 { 1.0 } else { -1.0 };
        let [corner, one, other] = [&corners[..3], &corners[3..6], &corners[9..]].map(place);
        let sides = [one - corner, other - corner];
        (towards > 0.0).then_some(Seen { corner, sides, flag: part.flag, direction: direction as u8 })
    })
}

/// The nearest rectangle at every point, row after row from the top; `place` has what is right and up of a point.
fn nearest(quads: &[Seen], [width, height]: [u32; 2], place: impl Fn([u32; 2]) -> [f64; 2] + Sync) -> Vec<Nearest> {
    let mut points = vec![NOTHING; width as usize * height as usize];
    let [left, top] = place([0, 0]);
    let [next, below] = place([1, 1]);
    let (along, down) = (next - left, top - below);
    points.par_chunks_mut(ROWS * width as usize).enumerate().for_each(|(band, points)| {
        let first_row = (band * ROWS) as f64;
        let n_rows = (points.len() / width as usize) as f64;
        for quad in quads {
            let [u, v] = quad.sides;
            let turn = u.x * v.y - u.y * v.x;
            let ends = quad.corners();
            let (low, high) = ends.iter().fold((ends[0], ends[0]), |(low, high), &end| (low.min(end), high.max(end)));
            let rows = [(top - high.y) / down, (top - low.y) / down].map(|row| row - first_row);
            let columns = [(low.x - left) / along, (high.x - left) / along];
            if turn == 0.0 || rows[1] < 0.0 || rows[0] >= n_rows {
                continue;
            }
            let [from, to] = [rows[0].floor().max(0.0), (rows[1].ceil() + 1.0).min(n_rows)].map(|row| row as usize);
            let [start, end] =
                [columns[0].floor().max(0.0), (columns[1].ceil() + 1.0).min(width.into())].map(|at| at as usize);
            for row in from..to {
                for column in start..end {
                    let [x, y] = place([column as u32, row as u32 + first_row as u32]);
                    let (dx, dy) = (x - quad.corner.x, y - quad.corner.y);
                    let at = [(dx * v.y - dy * v.x) / turn, (dy * u.x - dx * u.y) / turn];
                    let depth = quad.corner.z + at[0] * u.z + at[1] * v.z;
                    let point = &mut points[row * width as usize + column];
                    if at.iter().all(|at| (-ROUNDING..=1.0 + ROUNDING).contains(at)) && depth > point.depth {
                        *point = Nearest { depth, flag: quad.flag, direction: quad.direction };
                    }
                }
            }
        }
    });
    points
}

/// The colour of every point; `step` is how deep a cell is.
fn shades(points: &[Nearest], [width, height]: [u32; 2], eye: &Eye, step: f64) -> Vec<[u8; 3]> {
    // from above and the left of the eye, so that no two sides that are seen are equally bright
    let light = (eye.axes[2] + 0.8 * DVec3::Z - 0.35 * eye.axes[0]).normalize();
    let at = |x: u32, y: u32| &points[y as usize * width as usize + x as usize];
    let mut shades = vec![WHITE; points.len()];
    shades.par_chunks_mut(width as usize).enumerate().for_each(|(y, out)| {
        for (x, rgb) in out.iter_mut().enumerate() {
            let (x, y) = (x as u32, y as u32);
            let point = at(x, y);
            if point.flag == 0 {
                continue;
            }
            let sign = if point.direction % 2 == 1 { 1.0 } else { -1.0 };
            let facing = (light[usize::from(point.direction / 2)] * sign).max(0.0);
            let beside = [at((x + 1).min(width - 1), y), at(x, (y + 1).min(height - 1))];
            let is_edge = beside.iter().any(|other| other.flag != point.flag || point.depth - other.depth > 6.0 * step);
            let bright = (0.5 + 0.6 * facing).min(1.0) * if is_edge { 0.6 } else { 1.0 };
            *rgb = colour(point.flag).map(|channel| (f64::from(channel) * bright) as u8);
        }
    });
    shades
}

/// What is written below the picture.
fn descriptions(mesh: &Mesh, view: &View, skin: &Skin) -> [String; 2] {
    let [nx, ny, nz] = mesh.dims();
    let [around, up] = view.from;
    let length = |axis: usize| {
        let [low, high] = [0, mesh.dims()[axis]].map(|index| mesh.lines.line(axis, index));
        coordinate(mesh, high - low)
    };
    let coarse = if skin.step == 1 { String::new() } else { format!(", drawn in cells of {}", skin.step) };
    let size = format!("{} x {} x {}", length(0), length(1), length(2));
    [format!("{nx} x {ny} x {nz} cells, {size}"), format!("seen from {around}, {up} degrees{coarse}")]
}
