//! What the rays are expected to meet: areas of projections, cell by cell.
//!
//! Geometries, lines, rays -> [`Sums`]. Over all offsets of the rays a facet is crossed as many times as its projection has cells across.
//! Cost: one pass over the corners.

use crate::base::control::Control;
use crate::base::error::Result;
use crate::base::parallel::*;
use crate::grid::frame::{Frame, SnappedFacet};
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::input::geometry::{Facet, Geometry};
use crate::stages::cast::sizes::BIN;
use crate::stages::{cpu, facet};

/// Facets between two rests: some tens of milliseconds. A multiple of the facets that are summed first.
const FACETS_AT_ONCE: usize = 32 * SUMMED_AT_ONCE;
/// Facets that are summed first, so that the number of threads does not change the last bits.
const SUMMED_AT_ONCE: usize = 4096;

/// Sums over facets.
#[derive(Default)]
pub struct Sums {
    /// Crossings of rays and facets.
    pub crossings: f64,
    /// Those of them before the last centre of their ray, each of which begins a run.
    pub runs: f64,
    /// (facet, strip) pairs of the CPU backend.
    pub strip_facets: f64,
    /// (facet, bin) pairs of the GPU backend, at most: bins under the boxes of the facets.
    pub bin_facets: f64,
    /// Facets with a ray under their boxes.
    pub facets: f64,
}

/// What the rays are expected to meet, with a rest after some facets.
///
/// # Errors
/// `cancelled`; `io` where facets stay in their file, and that cannot be read again.
pub async fn expected(geometries: &[Geometry], lines: &Lines, rays: &Rays, control: &Control) -> Result<Sums> {
    let mut sums = Sums::default();
    for geometry in geometries {
        let mut chunks = geometry.facets.chunks(FACETS_AT_ONCE);
        while let Some(facets) = chunks.next_some()? {
            sums.add_facets(geometry, facets, lines, rays);
            control.rest().await?;
        }
    }
    Ok(sums)
}

/// The same of snapped facets in equal cells, where those that no ray may hit are gone: each is crossed by that share of the rays under its box
/// which it has of the area of the box.
pub fn expected_of_frame(frame: &Frame, rays: &Rays) -> Sums {
    let (cell, rows) = (f64::from(1u32 << frame.fraction_bits), cpu::rows_of_strip(rays));
    let last = frame.centre(rays.axis, rays.depth - 1);
    let bins = |[first, last]: [u32; 2], of: u32| f64::from(last / of - first / of + 1);
    let of_block = |block: &[SnappedFacet]| {
        let mut sums = Sums::default();
        for facet in block {
            let Some([across, down]) = facet::rays_under(facet, frame, rays) else { continue };
            let [a, b, c] = [rays.project(facet[0]), rays.project(facet[1]), rays.project(facet[2])];
            let [u, v] = [difference(b, a), difference(c, a)];
            let area = 0.5 * (u[0] * v[1] - u[1] * v[0]).abs() / (cell * cell);
            let extent = |axis: usize| f64::from(a[axis].max(b[axis]).max(c[axis]) - a[axis].min(b[axis]).min(c[axis]));
            let of_box = extent(0) * extent(1) / (cell * cell);
            if area > 0.0 {
                let n_rays = f64::from(across[1] - across[0] + 1) * f64::from(down[1] - down[0] + 1);
                let crossings = n_rays * area / of_box;
                sums.crossings += crossings;
                sums.runs += if a[2].min(b[2]).min(c[2]) > last { 0.0 } else { crossings };
                sums.strip_facets += bins(down, rows);
                sums.bin_facets += bins(across, BIN) * bins(down, BIN);
                sums.facets += 1.0;
            }
        }
        sums
    };
    let blocks: Vec<Sums> = on_all_cores(|| frame.facets.par_chunks(SUMMED_AT_ONCE).map(of_block).collect());
    let mut sums = Sums::default();
    blocks.iter().for_each(|block| sums.add(block));
    sums
}

#[inline(always)]
fn difference(a: [i32; 3], b: [i32; 3]) -> [f64; 2] {
    [f64::from(a[0]) - f64::from(b[0]), f64::from(a[1]) - f64::from(b[1])]
}

impl Sums {
    fn add_facets(&mut self, geometry: &Geometry, facets: &[Facet], lines: &Lines, rays: &Rays) {
        // products, as a division takes as long as all else of a facet
        let strip = [1.0 / f64::from(rays.counts[0]), 1.0 / f64::from(cpu::rows_of_strip(rays))];
        let (origin, per_length) = (lines.origin(), lines.spacing().map(|spacing| spacing.map(|length| 1.0 / length)));
        let (counts, depth) = (rays.counts.map(f64::from), f64::from(rays.depth));
        let placing = geometry.placing();
        let project = |corner: [f32; 3]| {
            let world = placing(corner);
            let cells = |axis: usize| match per_length {
                Some(per_length) => (world[axis] - origin[axis]) * per_length[axis],
                None => lines.position(axis, world[axis]),
            };
            [cells(rays.across[0]), cells(rays.across[1]), cells(rays.axis)]
        };
        // arrays item by item: with `map` they are calls, a fifth of the time of many facets
        let of_block = |block: &[Facet]| {
            let mut sums = Sums::default();
            for &[a, b, c] in block {
                let corners = [project(a), project(b), project(c)];
                let ends = ends(&corners);
                let [crossings, runs] = covered_areas(corners, ends, counts, depth);
                sums.crossings += crossings;
                sums.runs += runs;
                if crossings > 0.0
                    && let Some(under) = rays_under(ends, counts)
                {
                    sums.strip_facets += n_bins(under, strip);
                    sums.bin_facets += n_bins(under, [1.0 / f64::from(BIN); 2]);
                    sums.facets += 1.0;
                }
            }
            sums
        };
        let blocks: Vec<Sums> = on_all_cores(|| facets.par_chunks(SUMMED_AT_ONCE).map(of_block).collect());
        blocks.iter().for_each(|block| self.add(block));
    }

    fn add(&mut self, other: &Sums) {
        self.crossings += other.crossings;
        self.runs += other.runs;
        self.strip_facets += other.strip_facets;
        self.bin_facets += other.bin_facets;
        self.facets += other.facets;
    }
}

/// Least and greatest coordinates.
#[inline(always)]
fn ends([a, b, c]: &[Point; 3]) -> [Point; 2] {
    let mut ends = [*a; 2];
    for corner in [b, c] {
        for axis in 0..3 {
            ends[0][axis] = if corner[axis] < ends[0][axis] { corner[axis] } else { ends[0][axis] };
            ends[1][axis] = if corner[axis] > ends[1][axis] { corner[axis] } else { ends[1][axis] };
        }
    }
    ends
}

/// The first and the last ray along each side under the box of a facet; none where there is no ray.
#[inline(always)]
fn rays_under([low, high]: [Point; 2], counts: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let mut rays = [[0.0; 2]; 2];
    for side in 0..2 {
        // ray k is at k + 1/2
        let first = -floor(0.5 - low[side]);
        let last = floor(high[side] - 0.5);
        rays[side] = [first.max(0.0), last.min(counts[side] - 1.0)];
        if rays[side][0] > rays[side][1] {
            return None;
        }
    }
    Some(rays)
}

/// Number of bins that these rays are in, of which there are so many a ray.
#[inline(always)]
fn n_bins(rays: [[f64; 2]; 2], per_ray: [f64; 2]) -> f64 {
    let along = |side: usize| floor(rays[side][1] * per_ray[side]) - floor(rays[side][0] * per_ray[side]) + 1.0;
    along(0) * along(1)
}

/// The largest whole number that is not larger: the library's is a call where the processor may lack the instruction.
#[inline(always)]
fn floor(number: f64) -> f64 {
    // callers clamp what is beyond 2^63
    let whole = number as i64 as f64;
    if whole > number { whole - 1.0 } else { whole }
}

/// A point in cells: the two axes across, then along the rays.
type Point = [f64; 3];

/// Areas seen along the rays of the part of a triangle inside the rectangle of the rays, from 0, 0 to `counts`, and of
/// that part of it which lies before the last centre of the rays of `depth` cells.
#[inline(always)]
fn covered_areas(triangle: [Point; 3], [low, high]: [Point; 2], counts: [f64; 2], depth: f64) -> [f64; 2] {
    let is_inside = low[0] >= 0.0 && low[1] >= 0.0 && high[0] <= counts[0] && high[1] <= counts[1];
    if is_inside && high[2] <= depth - 0.5 {
        return [polygon_area(&triangle); 2];
    }
    clipped_areas(triangle, counts, depth)
}

#[inline(never)]
fn clipped_areas(triangle: [Point; 3], counts: [f64; 2], depth: f64) -> [f64; 2] {
    let end = depth - 0.5;
    let is_before = triangle.iter().all(|point| point[2] <= end);
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
        let covered_areas = |corners: [Point; 3], counts, depth| covered_areas(corners, ends(&corners), counts, depth);
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
