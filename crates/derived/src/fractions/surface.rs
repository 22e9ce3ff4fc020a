//! The surface within cells: facets, clipped.
//!
//! Facets of a geometry -> for each cell area, centre and normal of what of them lies in it ([`Polygon`]), rounded to f32.
//!
//! Cost: a cut for each plane that a facet crosses; 40 bytes a cell and geometry.

use std::ops::Range;

use super::fraction::CutSurface;
use super::polygon::{FacetRows, Point, Polygon};
use super::refined::InUnits;
use hexcast_core::base::sort::sort_nearly_by_key;
use hexcast_core::grid::frame::normal;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::totals::{Ruler, Total};
use hexcast_core::grid::window::CellWindow;

/// What the surfaces of all geometries are measured with.
pub(super) struct Surfaces<'a> {
    rows: &'a FacetRows<'a>,
    /// Size of a unit along each axis.
    sizes: [f64; 3],
    /// Of each position 1, or -1 where its facets face inwards, by their order in the file or because it is mirrored.
    turns: Vec<f64>,
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
    /// Finds the sides of all geometries.
    pub(super) fn new<'a>(rows: &'a FacetRows<'a>, lines: &Lines) -> Surfaces<'a> {
        let (frame, window) = (rows.frame, rows.window);
        let sizes = InUnits::new(frame, lines, [window.first, window.end]).sizes();
        let mut volumes = vec![0i128; frame.ranks.geometry_at.len()];
        for (index, &[a, b, c]) in frame.facets.iter().enumerate() {
            let across = normal(&[[0; 3], b, c]);
            volumes[usize::from(frame.position_of_facet[index])] +=
                (0..3).map(|axis| i128::from(a[axis]) * across[axis]).sum::<i128>();
        }
        let turns = volumes.iter().map(|&volume| if volume < 0 { -1.0 } else { 1.0 }).collect();
        Surfaces { rows, sizes, turns }
    }

    /// The surfaces in the cells of some planes of the window across z, which are those of a row, in the order of cells, then of geometries; and the area of each
    /// position.
    pub(super) fn of_row(&self, row: u32, planes: Range<u32>, ruler: &Ruler) -> (Vec<CutSurface>, Vec<Total>) {
        let FacetRows { frame, window, lines, .. } = self.rows;
        let CellWindow { first, end, .. } = *window;
        let planes = first[2] + planes.start..first[2] + planes.end;
        let mut sums: Vec<Sum> = Vec::new();
        for &facet in self.rows.of_row(row) {
            let whole = Polygon::new(&frame.facets[facet as usize]);
            let position = frame.position_of_facet[facet as usize];
            whole.slices(2, &lines[2], planes.clone(), |z, polygon| {
                polygon.slices(1, &lines[1], first[1]..end[1], |y, polygon| {
                    polygon.slices(0, &lines[0], first[0]..end[0], |x, polygon| {
                        let cell = window.index([x, y, z]);
                        let (area, moments, normal) = self.measure(polygon);
                        let order = sums.len();
                        sums.push(Sum { cell, position, order, area, moments, normal });
                    });
                });
            });
        }
        sort_nearly_by_key(&mut sums, |sum| (sum.cell, sum.position, sum.order));
        let mut areas = vec![Total::default(); frame.ranks.geometry_at.len()];
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
        let FacetRows { frame, window, lines, .. } = self.rows;
        let of_window = window.cell(cell);
        let total = |of: fn(&Sum) -> &Point| [0, 1, 2].map(|axis| sums.iter().map(|sum| of(sum)[axis]).sum::<f64>());
        let (moments, normal) = (total(|sum| &sum.moments), total(|sum| &sum.normal));
        let normal = normal.map(|component| self.turns[usize::from(position)] * component);
        let norm = length(normal);
        let point = [0, 1, 2].map(|axis| {
            let [low, high] = [0, 1].map(|by| lines[axis][(window.first[axis] + of_window[axis] + by) as usize]);
            ((moments[axis] / area - low) / (high - low)).clamp(0.0, 1.0) as f32
        });
        CutSurface {
            cell,
            geometry: frame.ranks.geometry_at[usize::from(position)] as i16,
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
