//! What the rays are expected to meet: areas of projections, cell by cell.
//!
//! Geometries, lines, rays -> [`Expected`]. See the top of the module above for why an area is a number of crossings.
//! Cost: one pass over the corners.

use crate::base::parallel::*;
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::input::geometry::{Facet, Geometry};
use crate::stages::cast::sizes::BIN;
use crate::stages::cpu;

/// Facets of a step: some tens of milliseconds. A multiple of the facets that are summed first.
const FACETS_AT_ONCE: usize = 32 * SUMMED_AT_ONCE;
/// Facets that are summed first, so that the number of threads does not change the last bits.
const SUMMED_AT_ONCE: usize = 4096;

/// What the rays meet.
#[derive(Default)]
pub(super) struct Expected {
    /// The geometry and the facet of it that come next.
    next: [usize; 2],
    /// Crossings of rays and facets.
    pub(super) crossings: f64,
    /// Those of them before the last centre of their ray, each of which begins a run.
    pub(super) runs: f64,
    /// (facet, strip) pairs of the CPU backend.
    pub(super) strip_facets: f64,
    /// (facet, bin) pairs of the GPU backend, at most: bins under the boxes of the facets.
    pub(super) bin_facets: f64,
    /// Facets with a ray under their boxes.
    pub(super) facets: f64,
}

impl Expected {
    /// Adds the next facets; false once all are added.
    pub(super) fn step(&mut self, geometries: &[Geometry], lines: &Lines, rays: &Rays) -> bool {
        let [index, first] = self.next;
        let Some(geometry) = geometries.get(index) else { return false };
        let end = geometry.facets.len().min(first + FACETS_AT_ONCE);
        self.add(geometry, &geometry.facets[first..end], lines, rays);
        self.next = if end == geometry.facets.len() { [index + 1, 0] } else { [index, end] };
        self.next[0] < geometries.len()
    }

    fn add(&mut self, geometry: &Geometry, facets: &[Facet], lines: &Lines, rays: &Rays) {
        let strip = [f64::from(rays.counts[0]), f64::from(cpu::rows_of_strip(rays))];
        let add = |a: [f64; 5], b: [f64; 5]| [0, 1, 2, 3, 4].map(|k| a[k] + b[k]);
        let placing = geometry.placing();
        let project = |corner: [f32; 3]| {
            let world = placing(corner);
            let cells = |axis: usize| lines.position(axis, world[axis]);
            [cells(rays.across[0]), cells(rays.across[1]), cells(rays.axis)]
        };
        let of_facet = |facet: &Facet| {
            let corners = facet.map(project);
            let [crossings, runs] = covered_areas(corners, rays.counts.map(f64::from), f64::from(rays.depth));
            let pairs = if crossings > 0.0 {
                [strip, [f64::from(BIN); 2]].map(|bin| bins(&corners, bin, rays.counts))
            } else {
                [0.0; 2]
            };
            [crossings, runs, pairs[0], pairs[1], f64::from(u8::from(pairs[1] > 0.0))]
        };
        let of_block = |block: &[Facet]| block.iter().map(of_facet).fold([0.0; 5], add);
        let blocks: Vec<[f64; 5]> = facets.par_chunks(SUMMED_AT_ONCE).map(of_block).collect();
        let before = [self.crossings, self.runs, self.strip_facets, self.bin_facets, self.facets];
        [self.crossings, self.runs, self.strip_facets, self.bin_facets, self.facets] =
            blocks.into_iter().fold(before, add);
    }
}

/// Number of bins of so many rays that hold a ray under the box of a facet; none where the box holds no ray.
fn bins(corners: &[Point; 3], bin: [f64; 2], counts: [u32; 2]) -> f64 {
    let mut n_bins = 1.0;
    for side in 0..2 {
        let [a, b, c] = corners.map(|corner| corner[side]);
        // ray k is at k + 1/2
        let low = (a.min(b).min(c) - 0.5).ceil().max(0.0);
        let high = (a.max(b).max(c) - 0.5).floor().min(f64::from(counts[side]) - 1.0);
        if low > high {
            return 0.0;
        }
        n_bins *= (high / bin[side]).floor() - (low / bin[side]).floor() + 1.0;
    }
    n_bins
}

/// A point in cells: the two axes across, then along the rays.
type Point = [f64; 3];

/// Areas seen along the rays of the part of a triangle inside the rectangle of the rays, from 0, 0 to `counts`, and of
/// that part of it which lies before the last centre of the rays of `depth` cells.
fn covered_areas(triangle: [Point; 3], counts: [f64; 2], depth: f64) -> [f64; 2] {
    let inside = |point: &Point| (0..2).all(|axis| (0.0..=counts[axis]).contains(&point[axis]));
    let end = depth - 0.5;
    let (is_inside, is_before) = (triangle.iter().all(inside), triangle.iter().all(|point| point[2] <= end));
    if is_inside && is_before {
        return [polygon_area(&triangle); 2];
    }
    let mut polygon = triangle.to_vec();
    for axis in 0..2 {
        polygon = clip(&polygon, |point| point[axis]);
        polygon = clip(&polygon, |point| counts[axis] - point[axis]);
    }
    let before = if is_before { polygon.clone() } else { clip(&polygon, |point| end - point[2]) };
    [polygon_area(&polygon), polygon_area(&before)]
}

/// The part of a convex polygon where a linear function is not negative (Sutherland and Hodgman 1974).
fn clip(polygon: &[Point], height: impl Fn(&Point) -> f64) -> Vec<Point> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, point) in polygon.iter().enumerate() {
        let next = &polygon[(index + 1) % polygon.len()];
        let (here, there) = (height(point), height(next));
        if here >= 0.0 {
            kept.push(*point);
        }
        if (here < 0.0) != (there < 0.0) {
            let t = here / (here - there);
            kept.push([0, 1, 2].map(|axis| point[axis] + t * (next[axis] - point[axis])));
        }
    }
    kept
}

/// Area of a polygon seen along the rays.
fn polygon_area(polygon: &[Point]) -> f64 {
    let Some(first) = polygon.first() else { return 0.0 };
    let from_first = |point: &Point| [point[0] - first[0], point[1] - first[1]];
    let doubled: f64 = polygon
        .windows(2)
        .map(|two| (from_first(&two[0]), from_first(&two[1])))
        .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
        .sum();
    0.5 * doubled.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_clipped_to_the_rectangle() {
        let at = |corners: [[f64; 2]; 3]| corners.map(|[x, y]| [x, y, x]);
        let areas = |corners, side| covered_areas(at(corners), [side; 2], 1e9);
        let triangle = [[-2.0, -2.0], [6.0, -2.0], [-2.0, 6.0]];
        assert_eq!(areas(triangle, 2.0), [4.0; 2]);
        assert_eq!(areas(triangle, 10.0), [8.0; 2]);
        assert_eq!(areas([[3.0, 0.0], [4.0, 0.0], [3.0, 1.0]], 2.0), [0.0; 2]);
        assert_eq!(areas([[0.0, 0.0], [0.0, 2.0], [2.0, 0.0]], 2.0), [2.0; 2]);
        // it rises with x, and the last centre is at 1
        assert_eq!(covered_areas(at([[0.0, 0.0], [0.0, 2.0], [2.0, 0.0]]), [2.0; 2], 1.5), [2.0, 1.5]);
    }
}
