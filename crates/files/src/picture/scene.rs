//! Scenes: the rectangles of a skin as seen from a direction, and the pixels that they give.
//!
//! Rectangles -> for every pixel the nearest one, by its depth. A rectangle is a parallelogram on the picture: a pixel lies in it
//! where its two coordinates along the sides are within 0 and 1. Each pixel is the mean of [`FINE`] x [`FINE`] points; sides are
//! brighter the more they face the light, and darker at the edges of flags and of what stands before something else.

use std::ops::Range;

use glam::DVec3;

use super::Look;
use super::canvas::WHITE;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;
use hexcast_derived::skin::{Skin, SkinPart};

/// Points of a pixel on each side.
pub(super) const FINE: u32 = 2;
/// Rows of points that a thread draws at a time: those of whole pixels.
pub(super) const ROWS: usize = 32 * FINE as usize;
/// Rectangles that are looked at between two rests.
const QUADS_AT_ONCE: usize = 1 << 17;
/// How far outside a rectangle a point still counts, in its sides: more than rounding, less than a gap.
const ROUNDING: f64 = 1e-9;

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
pub(super) struct Nearest {
    depth: f64,
    flag: u8,
    direction: u8,
}

const NOTHING: Nearest = Nearest { depth: f64::NEG_INFINITY, flag: 0, direction: 0 };

/// What faces the eye.
pub(super) struct Scene {
    eye: Eye,
    quads: Vec<Seen>,
    /// The first row of points that each may meet, and the one after the last; rows are counted from the top.
    rows: Vec<[u32; 2]>,
    /// Around all flags, whichever are shown, so that views of each have one scale.
    low: DVec3,
    high: DVec3,
    /// Points on both sides.
    pub(super) fine: [usize; 2],
    /// Points a length.
    points: f64,
}

impl Scene {
    /// What faces an eye in a direction.
    ///
    /// # Errors
    /// `job-value` where there is nothing to see; `cancelled`.
    pub(super) async fn new(mesh: &Mesh, skin: &Skin, from: [f64; 2], control: &Control) -> Result<Scene> {
        let eye = Eye::new(from);
        let mut quads = Vec::new();
        for part in &skin.parts {
            for start in (0..part.n_quads()).step_by(QUADS_AT_ONCE) {
                quads.extend(seen(part, start..(start + QUADS_AT_ONCE).min(part.n_quads()), mesh, &eye));
                control.rest().await?;
            }
        }
        if quads.is_empty() {
            let hint = "show other cells, or mesh surfaces that hold centres of cells";
            return Err(Error::new("job-value", "no cell has a flag: there is nothing to see", hint));
        }
        let ends = quads.iter().flat_map(Seen::corners);
        let (low, high) = ends.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), at| (l.min(at), h.max(at)));
        Ok(Scene { eye, quads, rows: Vec::new(), low, high, fine: [0; 2], points: 0.0 })
    }

    /// Right, up and towards the eye.
    pub(super) fn extent(&self) -> DVec3 {
        self.high - self.low
    }

    /// Bytes of the points of a band of rows and of what becomes of them.
    pub(super) fn band_bytes(&self) -> u64 {
        (ROWS as u64 + 1) * self.fine[0] as u64 * (size_of::<Nearest>() as u64 + 1)
    }

    pub(super) fn n_quads(&self) -> usize {
        self.quads.len()
    }

    /// Leaves the flags that are shown, and finds the rows of points of each rectangle.
    ///
    /// # Errors
    /// `job-value` where no flag is left.
    pub(super) fn show(&mut self, look: &Look, size: [u32; 2], pixels: f64) -> Result<()> {
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
    pub(super) fn between(&self, rows: Range<usize>) -> Vec<u32> {
        let meets = |[first, end]: &[u32; 2]| (*first as usize) < rows.end && (*end as usize) > rows.start;
        (0..).zip(&self.rows).filter(|(_, of_quad)| meets(of_quad)).map(|(quad, _)| quad).collect()
    }

    /// What is right and up of a point.
    fn place(&self, column: usize, row: usize) -> [f64; 2] {
        let [x, y] = [column, row].map(|at| (at as f64 + 0.5) / self.points);
        [self.low.x + x, self.high.y - y]
    }

    /// Draws rows of points that are whole pixels: the pixels, and which flags are seen. `deep` is how deep a cell is, and `nearest` the
    /// points of other rows, whose memory these take.
    pub(super) fn pixels(
        &self,
        quads: &[u32],
        (rows, nearest): (&Range<usize>, &mut Vec<Nearest>),
        deep: f64,
        colours: &[[u8; 3]; 256],
    ) -> (Vec<[u8; 3]>, [bool; 256]) {
        let width = self.fine[0];
        // edges are seen from the point below, too
        self.find_nearest(quads, rows.start..(rows.end + 1).min(self.fine[1]), nearest);
        let own = &nearest[..rows.len() * width];
        let mut has = [false; 256];
        own.iter().for_each(|point| has[usize::from(point.flag)] |= point.flag != 0);
        // from above and the left of the eye, so that no two sides that are seen are equally bright
        let light = (self.eye.axes[2] + 0.8 * DVec3::Z - 0.35 * self.eye.axes[0]).normalize();
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

    /// Finds the nearest of some rectangles at every point of some rows, one after the other.
    fn find_nearest(&self, quads: &[u32], rows: Range<usize>, points: &mut Vec<Nearest>) {
        let width = self.fine[0];
        points.clear();
        points.resize(width * rows.len(), NOTHING);
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
    }
}

/// Those of some rectangles of a flag that face the eye.
fn seen<'a>(part: &'a SkinPart, quads: Range<usize>, mesh: &'a Mesh, eye: &'a Eye) -> impl Iterator<Item = Seen> + 'a {
    let place = |corner: &[f32]| {
        let lines = [0, 1, 2].map(|axis| mesh.lines().line(axis, corner[axis] as u32));
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
