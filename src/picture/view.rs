//! Views: the stair-step surface of a mesh from a direction, in parallel projection.
//!
//! Rectangles of the skin -> for every pixel the nearest one, by its depth. A rectangle is a parallelogram on the picture: a pixel lies in it
//! where its two coordinates along the sides are within 0 and 1. Each pixel is the mean of [`FINE`] x [`FINE`]; sides are
//! brighter the more they face the light, and darker at the edges of flags and of what stands before something else. Bands of rows are
//! drawn one after another, some at a time on several cores.
//! Cost: O(rectangles) a band of rows, and O(pixels) a rectangle that is seen; memory for rectangles, pixels, and the points of some bands.

use std::ops::Range;

use glam::DVec3;

use super::canvas::{LINE, Picture, WHITE, check_sides, legend_height};
use super::{Look, MARGIN, check_memory, coordinate};
use crate::control::{Control, at_once};
use crate::error::{Error, Result};
use crate::flags::CellBox;
use crate::mesh::Mesh;
use crate::parallel::*;
use crate::skin::{Skin, SkinPart, skin_with_rests};

/// Pixels of the longer side where nobody says.
const SIZE: u32 = 1000;
/// Points of a pixel on each side.
const FINE: u32 = 2;
/// Rows of points that a thread draws at a time: those of whole pixels.
const ROWS: usize = 32 * FINE as usize;
/// Most rectangles; a mesh of more is drawn with coarser cells.
const MAX_QUADS: usize = 4_000_000;
/// Most bytes of a rectangle: in the skin, and as it is seen.
const QUAD_BYTES: u64 = 176;
/// Rectangles that are looked at between two rests.
const QUADS_AT_ONCE: usize = 1 << 17;
/// How far outside a rectangle a point still counts, in its sides: more than rounding, less than a gap.
const ROUNDING: f64 = 1e-9;

/// From where, and what of it is seen.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// Direction to the eye, in degrees: around z from x, and up from the plane of x and y.
    pub from: [f64; 2],
    /// Cells that are shown; all if None.
    pub cells: Option<CellBox>,
    /// Size, flags and colours.
    pub look: Look,
}

impl Default for View {
    fn default() -> View {
        View { from: [-60.0, 25.0], cells: None, look: Look::default() }
    }
}

impl View {
    /// Looks from a direction: degrees around z from x, and up from the plane of x and y.
    pub fn with_from(mut self, from: [f64; 2]) -> View {
        self.from = from;
        self
    }

    /// Shows a box of cells only.
    pub fn with_cells(mut self, cells: CellBox) -> View {
        self.cells = Some(cells);
        self
    }

    /// Sets how it looks.
    pub fn with_look(mut self, look: Look) -> View {
        self.look = look;
        self
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
/// `job-value` where the picture would have no pixel or more than 32,768 on a side, the cells are not those of the mesh, or none of them has
/// a flag that is shown; `memory` where it takes more than is allowed; `io` where the columns are in a store that fails; `cancelled`.
pub fn view(mesh: &Mesh, view: &View, control: &Control) -> Result<Picture> {
    at_once(view_with_rests(mesh, view, &control.without_pauses()))
}

/// Like [`view()`], with a rest every some rows of the mesh and of pixels ([`Control::rest`]).
///
/// # Errors
/// Those of [`view()`].
pub(crate) async fn view_with_rests(mesh: &Mesh, view: &View, control: &Control) -> Result<Picture> {
    let look = &view.look;
    let size = look.size.unwrap_or(SIZE);
    if !view.from.iter().all(|angle| angle.is_finite()) {
        let message = format!("a view from {:?} degrees", view.from);
        return Err(Error::new("job-value", message, "give two finite angles"));
    }
    check_sides([size; 2])?;
    let skin = skin_within(mesh, view, control).await?;
    let eye = Eye::new(view.from);
    let mut scene = Scene::new(mesh, &skin, &eye, control).await?;
    let (texts, step) = (descriptions(mesh, view, &skin), skin.step);
    drop(skin);
    let extent = scene.high - scene.low;
    let pixels = f64::from(size) / extent.x.max(extent.y);
    let [width, height] = [extent.x, extent.y].map(|length| (length * pixels).round().max(1.0) as u32);
    scene.show(look, [width, height], pixels)?;
    let deep = (scene.high.z - scene.low.z) / f64::from(mesh.dims().into_iter().max().unwrap_or(1)) * f64::from(step);
    let quads_bytes = QUAD_BYTES * scene.quads.len() as u64;
    let whole = width.max(320) + 2 * MARGIN;
    let below = MARGIN + height + MARGIN;
    // without the texts, whose height follows from what is seen
    let mut picture = Picture::new(whole, below, look.max_bytes.saturating_sub(quads_bytes))?;
    let mut has = [false; 256];
    let colours = look.colours();
    let bands: Vec<Range<usize>> =
        (0..scene.fine[1]).step_by(ROWS).map(|start| start..(start + ROWS).min(scene.fine[1])).collect();
    for bands in bands.chunks(current_num_threads()) {
        let seen = scene.between(bands[0].start..bands[bands.len() - 1].end + 1);
        let drawn: Vec<(Vec<[u8; 3]>, [bool; 256])> =
            bands.par_iter().map(|rows| scene.pixels(&seen, rows, &eye, deep, &colours)).collect();
        for (rows, (pixels, of_band)) in bands.iter().zip(drawn) {
            for (at, rgb) in (0..).zip(pixels) {
                picture.set(MARGIN + at % width, MARGIN + rows.start as u32 / FINE + at / width, rgb);
            }
            (0..256).for_each(|flag| has[flag] |= of_band[flag]);
        }
        control.rest().await?;
    }
    let legend = look.legend(mesh, &has);
    picture.grow(2 * LINE + legend_height(whole, &legend) + MARGIN)?;
    for (index, text) in (0..).zip(&texts) {
        picture.text([MARGIN, below + index * LINE], text, whole - 2 * MARGIN);
    }
    picture.legend(below + 2 * LINE, &legend);
    Ok(picture)
}

/// The surface, within the memory that is allowed.
async fn skin_within(mesh: &Mesh, view: &View, control: &Control) -> Result<Skin> {
    let max_bytes = view.look.max_bytes;
    let max_quads = MAX_QUADS.min(usize::try_from(max_bytes / QUAD_BYTES).unwrap_or(MAX_QUADS));
    let skin = skin_with_rests(mesh, max_quads, view.cells.clone(), control).await?;
    // coarser because of the memory, or would be
    if max_quads < MAX_QUADS && skin.step > 1 {
        check_memory("the surface", QUAD_BYTES * MAX_QUADS as u64, max_bytes)?;
    }
    Ok(skin)
}

/// What faces the eye.
struct Scene {
    quads: Vec<Seen>,
    /// The first row of points that each may meet, and the one after the last; rows are counted from the top.
    rows: Vec<[u32; 2]>,
    /// Around all flags, whichever are shown, so that views of each have one scale.
    low: DVec3,
    high: DVec3,
    /// Points on both sides.
    fine: [usize; 2],
    /// Points a length.
    points: f64,
}

impl Scene {
    /// # Errors
    /// `job-value` where there is nothing to see; `cancelled`.
    async fn new(mesh: &Mesh, skin: &Skin, eye: &Eye, control: &Control) -> Result<Scene> {
        let mut quads = Vec::new();
        for part in &skin.parts {
            for start in (0..part.n_quads()).step_by(QUADS_AT_ONCE) {
                quads.extend(seen(part, start..(start + QUADS_AT_ONCE).min(part.n_quads()), mesh, eye));
                control.rest().await?;
            }
        }
        if quads.is_empty() {
            let hint = "show other cells, or mesh surfaces that hold centres of cells";
            return Err(Error::new("job-value", "no cell has a flag: there is nothing to see", hint));
        }
        let ends = quads.iter().flat_map(Seen::corners);
        let (low, high) = ends.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), at| (l.min(at), h.max(at)));
        Ok(Scene { quads, rows: Vec::new(), low, high, fine: [0; 2], points: 0.0 })
    }

    /// Leaves the flags that are shown, and finds the rows of points of each rectangle.
    ///
    /// # Errors
    /// `job-value` where no flag is left.
    fn show(&mut self, look: &Look, size: [u32; 2], pixels: f64) -> Result<()> {
        self.quads.retain(|quad| look.shows(quad.flag));
        if self.quads.is_empty() {
            let message = format!("no cell has one of the flags {:?}: there is nothing to see", look.flags);
            return Err(Error::new("job-value", message, "show flags of the mesh"));
        }
        self.fine = size.map(|n| (n * FINE) as usize);
        self.points = pixels * f64::from(FINE);
        let rows_of = |quad: &Seen| {
            let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
            quad.corners().iter().for_each(|end| (low, high) = (low.min(end.y), high.max(end.y)));
            let [first, last] = [(self.high.y - high) * self.points - 0.5, (self.high.y - low) * self.points - 0.5];
            [first.floor().max(0.0), (last.ceil() + 1.0).min(self.fine[1] as f64)].map(|row| row as u32)
        };
        self.rows = self.quads.iter().map(rows_of).collect();
        Ok(())
    }

    /// The rectangles that meet some rows of points.
    fn between(&self, rows: Range<usize>) -> Vec<u32> {
        let meets = |[first, end]: &[u32; 2]| (*first as usize) < rows.end && (*end as usize) > rows.start;
        (0..).zip(&self.rows).filter(|(_, of_quad)| meets(of_quad)).map(|(quad, _)| quad).collect()
    }

    /// What is right and up of a point.
    fn place(&self, column: usize, row: usize) -> [f64; 2] {
        let [x, y] = [column, row].map(|at| (at as f64 + 0.5) / self.points);
        [self.low.x + x, self.high.y - y]
    }

    /// Draws rows of points that are whole pixels: the pixels, and which flags are seen.
    fn pixels(
        &self,
        quads: &[u32],
        rows: &Range<usize>,
        eye: &Eye,
        deep: f64,
        colours: &[[u8; 3]; 256],
    ) -> (Vec<[u8; 3]>, [bool; 256]) {
        let width = self.fine[0];
        // edges are seen from the point below, too
        let nearest = self.nearest(quads, rows.start..(rows.end + 1).min(self.fine[1]));
        let own = &nearest[..rows.len() * width];
        let mut has = [false; 256];
        own.iter().for_each(|point| has[usize::from(point.flag)] |= point.flag != 0);
        // from above and the left of the eye, so that no two sides that are seen are equally bright
        let light = (eye.axes[2] + 0.8 * DVec3::Z - 0.35 * eye.axes[0]).normalize();
        let shade = |at: usize| {
            let point = own[at];
            if point.flag == 0 {
                return WHITE;
            }
            let sign = if point.direction % 2 == 1 { 1.0 } else { -1.0 };
            let facing = (light[usize::from(point.direction / 2)] * sign).max(0.0);
            let right = if at % width + 1 < width { own[at + 1] } else { point };
            let lower = nearest.get(at + width).copied();
            let stands_before = |other: Nearest| other.flag != point.flag || point.depth - other.depth > 6.0 * deep;
            let is_edge = stands_before(right) || stands_before(lower.unwrap_or(point));
            let bright = (0.5 + 0.6 * facing).min(1.0) * if is_edge { 0.6 } else { 1.0 };
            colours[usize::from(point.flag)].map(|channel| (f64::from(channel) * bright) as u8)
        };
        let n = FINE as usize;
        let pixel = |(x, y): (usize, usize)| {
            let points = (0..n * n).map(|at| shade((y * n + at / n) * width + x * n + at % n));
            let sum =
                points.fold([0u32; 3], |sum, rgb| [0, 1, 2].map(|channel| sum[channel] + u32::from(rgb[channel])));
            sum.map(|channel| (channel / (FINE * FINE)) as u8)
        };
        let places = (0..rows.len() / n).flat_map(|y| (0..width / n).map(move |x| (x, y)));
        (places.map(pixel).collect(), has)
    }

    /// The nearest of some rectangles at every point of some rows, one after the other.
    fn nearest(&self, quads: &[u32], rows: Range<usize>) -> Vec<Nearest> {
        let width = self.fine[0];
        let mut points = vec![NOTHING; width * rows.len()];
        for &quad in quads {
            let [first, end] = self.rows[quad as usize].map(|row| row as usize);
            let quad = &self.quads[quad as usize];
            let [u, v] = quad.sides;
            let turn = u.x * v.y - u.y * v.x;
            if turn == 0.0 {
                continue;
            }
            let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
            quad.corners().iter().for_each(|end| (low, high) = (low.min(end.x), high.max(end.x)));
            let columns = [low, high].map(|x| (x - self.low.x) * self.points - 0.5);
            let [left, right] = [columns[0].floor().max(0.0), (columns[1].ceil() + 1.0).min(width as f64)];
            for row in first.max(rows.start)..end.min(rows.end) {
                for column in left as usize..right as usize {
                    let [x, y] = self.place(column, row);
                    let (dx, dy) = (x - quad.corner.x, y - quad.corner.y);
                    let at = [(dx * v.y - dy * v.x) / turn, (dy * u.x - dx * u.y) / turn];
                    let depth = quad.corner.z + at[0] * u.z + at[1] * v.z;
                    let point = &mut points[(row - rows.start) * width + column];
                    if at.iter().all(|at| (-ROUNDING..=1.0 + ROUNDING).contains(at)) && depth > point.depth {
                        *point = Nearest { depth, flag: quad.flag, direction: quad.direction };
                    }
                }
            }
        }
        points
    }
}

/// Those of some rectangles of a flag that face the eye.
fn seen<'a>(part: &'a SkinPart, quads: Range<usize>, mesh: &'a Mesh, eye: &'a Eye) -> impl Iterator<Item = Seen> + 'a {
    let place = |corner: &[f32]| {
        let lines = [0, 1, 2].map(|axis| mesh.lines.line(axis, corner[axis] as u32));
        eye.seen(lines.into())
    };
    quads.filter_map(move |quad| {
        let corners = &part.positions[12 * quad..12 * quad + 12];
        let direction = part.direction(quad);
        let towards = eye.axes[2][direction / 2] * if direction % 2 == 1 { 1.0 } else { -1.0 };
        if towards <= 0.0 {
            return None;
        }
        let [corner, one, other] = [&corners[..3], &corners[3..6], &corners[9..]].map(place);
        let sides = [one - corner, other - corner];
        Some(Seen { corner, sides, flag: part.flag, direction: direction as u8 })
    })
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
