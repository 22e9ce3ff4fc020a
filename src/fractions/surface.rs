//! The surface within cells: facets, clipped.
//!
//! Facets of a geometry -> for each cell area, centre and normal of what of them lies in it. A facet is cut by the planes of the lines across z,
//! then y, then x. What lies in such a plane belongs to the cell below it. All is exact but for the rounding of f64, and that of results to f32. Each cell is cut
//! out by itself, so that the other cells do not change its last bits.
//!
//! Cost: a cut for each plane that a facet crosses; 40 bytes a cell and geometry.

use std::ops::Range;

use super::fraction::CutSurface;
use super::refined::InUnits;
use crate::crossings::by_ray;
use crate::frame::{Frame, normal};
use crate::lines::Lines;
use crate::sort::sort_nearly_by_key;
use crate::totals::{Ruler, Total};
use crate::window::CellWindow;

/// The facets, by rows of cells of a window.
pub(super) struct Surfaces<'a> {
    frame: &'a Frame,
    window: CellWindow,
    /// Lines of each axis of the box in units.
    lines: [Vec<f64>; 3],
    /// Size of a unit along each axis.
    sizes: [f64; 3],
    /// Of each position 1, or -1 where its facets face inwards, by their order in the file or because it is mirrored.
    turns: Vec<f64>,
    /// First facet of each row, then the end.
    offsets: Vec<u32>,
    facets: Vec<u32>,
}

type Point = [f64; 3];

/// A convex polygon: what of a triangle lies between six planes.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [Point; 9],
    n: usize,
}

impl Polygon {
    const EMPTY: Polygon = Polygon { corners: [[0.0; 3]; 9], n: 0 };

    fn push(&mut self, corner: Point) {
        self.corners[self.n] = corner;
        self.n += 1;
    }

    fn corners(&self) -> &[Point] {
        &self.corners[..self.n]
    }

    /// What lies below a plane across an axis, or in it, and what lies above.
    fn split(&self, axis: usize, at: f64) -> [Polygon; 2] {
        let height = |corner: &Point| corner[axis] - at;
        if self.corners().iter().all(|corner| height(corner) <= 0.0) {
            return [*self, Polygon::EMPTY];
        }
        if self.corners().iter().all(|corner| height(corner) >= 0.0) {
            return [Polygon::EMPTY, *self];
        }
        let mut sides = [Polygon::EMPTY; 2];
        for index in 0..self.n {
            let (from, to) = (self.corners[index], self.corners[(index + 1) % self.n]);
            let [start, end] = [height(&from), height(&to)];
            if start <= 0.0 {
                sides[0].push(from);
            }
            if start >= 0.0 {
                sides[1].push(from);
            }
            if start * end < 0.0 {
                let share = start / (start - end);
                let mut cut = [0, 1, 2].map(|of| from[of] + share * (to[of] - from[of]));
                cut[axis] = at;
                sides.iter_mut().for_each(|side| side.push(cut));
            }
        }
        sides
    }

    /// Calls `each` with the cells of an axis that the polygon reaches, of some, and with what lies in each: the same whichever these are.
    fn slices(self, axis: usize, lines: &[f64], cells: Range<u32>, mut each: impl FnMut(u32, Polygon)) {
        let places = || self.corners().iter().map(|corner| corner[axis]);
        let [low, high] = [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)];
        let first = lines.partition_point(|&line| line < low).saturating_sub(1) as u32;
        for cell in first.max(cells.start)..cells.end {
            let [begin, end] = [0, 1].map(|by| lines[cell as usize + by]);
            if begin >= high && begin > low {
                return;
            }
            // what lies in the first line has no cell below, and belongs to the first
            let above = if low > begin || cell == 0 && low == begin { self } else { self.split(axis, begin)[1] };
            let within = above.split(axis, end)[0];
            if within.n >= 3 {
                each(cell, within);
            }
        }
    }
}

/// What of a geometry lies in a cell: area, moments and normal, times the area.
struct Sum {
    cell: u64,
    position: u16,
    /// Those of a cell stay in the order of facets, so that their sums are always the same.
    order: usize,
    area: f64,
    moments: Point,
    normal: Point,
}

impl Surfaces<'_> {
    /// Sorts facets by rows of planes of cells across z.
    pub(super) fn new<'a>((frame, lines): (&'a Frame, &Lines), window: CellWindow, planes_of_row: u32) -> Surfaces<'a> {
        let sizes = InUnits::new(frame, lines, [window.first, window.end]).sizes();
        // as exact as the corners: what lies in a plane between cells must be found there
        let lists =
            [0, 1, 2].map(|axis| (0..=lines.dims()[axis]).map(|line| f64::from(frame.face(axis, line))).collect());
        let lists: [Vec<f64>; 3] = lists;
        let mut volumes = vec![0i128; frame.ranks.geometry_at.len()];
        for (index, &[a, b, c]) in frame.facets.iter().enumerate() {
            let across = normal(&[[0; 3], b, c]);
            volumes[usize::from(frame.position_of_facet[index])] +=
                (0..3).map(|axis| i128::from(a[axis]) * across[axis]).sum::<i128>();
        }
        let turns = volumes.iter().map(|&volume| if volume < 0 { -1.0 } else { 1.0 }).collect();
        let [first, end] = [window.first[2], window.end[2]];
        let n_rows = (end - first).div_ceil(planes_of_row) as usize;
        let mut pairs = Vec::new();
        for (index, facet) in (0u32..).zip(&frame.facets) {
            let ends = facet.map(|corner| f64::from(corner[2]));
            let [low, high] = [f64::min, f64::max].map(|of| ends.into_iter().reduce(of).unwrap_or(0.0));
            let plane = |at: f64| lists[2].partition_point(|&line| line < at).saturating_sub(1) as u32;
            let planes = plane(low).max(first)..(plane(high) + 1).min(end);
            if !planes.is_empty() {
                let row = |plane: u32| (plane - first) / planes_of_row;
                pairs.extend((row(planes.start)..=row(planes.end - 1)).map(|row| (row, index)));
            }
        }
        let (offsets, facets) = by_ray(&pairs, n_rows);
        Surfaces { frame, window, lines: lists, sizes, turns, offsets, facets }
    }

    /// The surfaces in the cells of some planes of the window across z, which are those of a row, in the order of cells, then of geometries; and the area of each
    /// position.
    pub(super) fn of_row(&self, row: u32, planes: Range<u32>, ruler: &Ruler) -> (Vec<CutSurface>, Vec<Total>) {
        let CellWindow { first, end, .. } = self.window;
        let planes = first[2] + planes.start..first[2] + planes.end;
        let mut sums: Vec<Sum> = Vec::new();
        let of_row = self.offsets[row as usize] as usize..self.offsets[row as usize + 1] as usize;
        for &facet in &self.facets[of_row] {
            let mut whole = Polygon::EMPTY;
            self.frame.facets[facet as usize].iter().for_each(|corner| whole.push(corner.map(f64::from)));
            let position = self.frame.position_of_facet[facet as usize];
            whole.slices(2, &self.lines[2], planes.clone(), |z, polygon| {
                polygon.slices(1, &self.lines[1], first[1]..end[1], |y, polygon| {
                    polygon.slices(0, &self.lines[0], first[0]..end[0], |x, polygon| {
                        let cell = self.window.index([x, y, z]);
                        let (area, moments, normal) = self.measure(&polygon);
                        let order = sums.len();
                        sums.push(Sum { cell, position, order, area, moments, normal });
                    });
                });
            });
        }
        sort_nearly_by_key(&mut sums, |sum| (sum.cell, sum.position, sum.order));
        let mut areas = vec![Total::default(); self.frame.ranks.geometry_at.len()];
        let mut found = Vec::new();
        for of_cell in sums.chunk_by(|one, other| (one.cell, one.position) == (other.cell, other.position)) {
            let area: f64 = of_cell.iter().map(|sum| sum.area).sum();
            areas[usize::from(of_cell[0].position)].add(ruler.of_area(area));
            if area > 0.0 {
                found.push(self.surface(of_cell, area));
            }
        }
        (found, areas)
    }

    /// Area, moments and normal of a polygon, times its area.
    fn measure(&self, polygon: &Polygon) -> (f64, Point, Point) {
        let (mut area, mut moments, mut normal) = (0.0, [0.0; 3], [0.0; 3]);
        let [a, rest @ ..] = polygon.corners() else { return (area, moments, normal) };
        for two in rest.windows(2) {
            let side = |to: &Point| [0, 1, 2].map(|axis| (to[axis] - a[axis]) * self.sizes[axis]);
            let (u, v) = (side(&two[0]), side(&two[1]));
            let cross = [0, 1, 2].map(|i| 0.5 * (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]));
            let of_triangle = length(cross);
            area += of_triangle;
            for axis in 0..3 {
                normal[axis] += cross[axis];
                moments[axis] += of_triangle * (a[axis] + two[0][axis] + two[1][axis]) / 3.0;
            }
        }
        (area, moments, normal)
    }

    /// The surface of a geometry in a cell.
    fn surface(&self, sums: &[Sum], area: f64) -> CutSurface {
        let Sum { cell, position, .. } = sums[0];
        let of_window = self.window.cell(cell);
        let total = |of: fn(&Sum) -> &Point| [0, 1, 2].map(|axis| sums.iter().map(|sum| of(sum)[axis]).sum::<f64>());
        let (moments, normal) = (total(|sum| &sum.moments), total(|sum| &sum.normal));
        let normal = normal.map(|component| self.turns[usize::from(position)] * component);
        let norm = length(normal);
        let point = [0, 1, 2].map(|axis| {
            let [low, high] =
                [0, 1].map(|by| self.lines[axis][(self.window.first[axis] + of_window[axis] + by) as usize]);
            ((moments[axis] / area - low) / (high - low)).clamp(0.0, 1.0) as f32
        });
        CutSurface {
            cell,
            geometry: self.frame.ranks.geometry_at[usize::from(position)] as i16,
            area: area as f32,
            point,
            // walls that face each other may cancel
            normal: normal.map(|of| if norm > 1e-9 * area { (of / norm) as f32 } else { 0.0 }),
        }
    }
}

fn length(of: Point) -> f64 {
    of.iter().map(|x| x * x).sum::<f64>().sqrt()
}
