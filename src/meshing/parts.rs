//! Parts: a box of cells divided into windows that take about as long as each other, for processes that mesh one each.
//!
//! Geometries, lines, rays, numbers of parts along x, y and z, places where they may be cut -> windows, x fastest. Each axis is
//! divided by itself. The cost of a plane of cells is its share of the rays, plus a constant for each crossing expected in it.
//! The expected crossings of a facet are its area seen along the rays, in cells, spread evenly over the planes of its box.
//!
//! Costs are whole numbers, summed exactly, so that every process finds the same parts.
//! Cost: one pass over the corners.

use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::geometry::{Facet, Geometry};

/// What a crossing costs, in rays; measured with 64 spheres on the CPU backend.
const RAYS_OF_CROSSING: f64 = 4.0;
/// Units of cost of a ray.
const UNITS: f64 = 65_536.0;

/// Cells of a box: the first, and the end, exclusive.
pub type Window = [[u32; 3]; 2];

/// Divides the box, at multiples of `step` cells on each axis: 1 for any cell, those of a shard for processes that fill a Zarr store.
///
/// # Errors
/// `job-value` where an axis has fewer such steps than it shall have parts; `io` where facets stay in their file, and that cannot be read again.
pub fn parts(geometries: &[Geometry], lines: &Lines, rays: &Rays, of: [u32; 3], step: [u32; 3]) -> Result<Vec<Window>> {
    for axis in 0..3 {
        let (cells, step) = (lines.dims()[axis], step[axis].max(1));
        let n = cells.div_ceil(step);
        if of[axis] == 0 || of[axis] > n {
            let of_shards = if step > 1 { format!(", {n} shards of {step}") } else { String::new() };
            let message =
                format!("{} parts along {}, which has {cells} cells{of_shards}", of[axis], ["x", "y", "z"][axis]);
            let hint = if step > 1 {
                "ask for at most one part per shard, divide other axes (part, --part K/NXxNYxNZ), or make shards smaller \
                 (zarr.shards, --zarr-shards)"
            } else {
                "ask for at most one part per cell, or divide other axes (part, --part K/NXxNYxNZ)"
            };
            return Err(Error::new("job-value", message, hint));
        }
    }
    let costs = costs(geometries, lines, rays)?;
    let ends = [0, 1, 2].map(|axis| {
        let step = step[axis].max(1);
        let of_steps: Vec<i128> = costs[axis].chunks(step as usize).map(|planes| planes.iter().sum()).collect();
        let ends = ends(&of_steps, of[axis] as usize);
        ends.into_iter().map(|end| end.saturating_mul(step).min(lines.dims()[axis])).collect::<Vec<u32>>()
    });
    let mut windows = Vec::new();
    for z in ends[2].windows(2) {
        for y in ends[1].windows(2) {
            windows.extend(ends[0].windows(2).map(|x| [0, 1].map(|end| [x[end], y[end], z[end]])));
        }
    }
    Ok(windows)
}

/// Cost of each plane of cells across each axis.
fn costs(geometries: &[Geometry], lines: &Lines, rays: &Rays) -> Result<[Vec<i128>; 3]> {
    // how the cost changes from plane to plane
    let mut changes = lines.dims().map(|n| vec![0i128; n as usize + 1]);
    for axis in 0..3 {
        changes[axis][0] = (UNITS * rays.n_rays() as f64 / f64::from(lines.dims()[axis])) as i128;
    }
    for geometry in geometries {
        let placing = geometry.placing();
        geometry.facets.for_each(|facet| add(facet, &placing, lines, rays, &mut changes))?;
    }
    for changes in &mut changes {
        let mut cost = 0;
        for change in changes.iter_mut() {
            cost += *change;
            *change = cost;
        }
        changes.pop();
    }
    Ok(changes)
}

/// Adds what a facet costs in each plane.
fn add(
    facet: &Facet,
    placing: impl Fn([f32; 3]) -> [f64; 3],
    lines: &Lines,
    rays: &Rays,
    changes: &mut [Vec<i128>; 3],
) {
    let [a, b, c] = facet.map(|corner| {
        let world = placing(corner);
        [0, 1, 2].map(|axis| lines.position(axis, world[axis]))
    });
    let [i, j] = rays.across;
    let area = 0.5 * ((b[i] - a[i]) * (c[j] - a[j]) - (c[i] - a[i]) * (b[j] - a[j])).abs();
    // what a file could say at worst: so no sum ends
    let cost = (RAYS_OF_CROSSING * UNITS * area).min(2f64.powi(80)) as i128;
    for (axis, changes) in changes.iter_mut().enumerate() {
        let n = changes.len() as i64 - 1;
        let [low, high] = [a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis])];
        let (first, last) = (low.floor() as i64, high.floor() as i64);
        // planes beyond the box are no part's
        let share = cost / (i128::from(last) - i128::from(first) + 1);
        let (first, end) = (first.max(0), last.saturating_add(1).min(n));
        if first < end {
            changes[first as usize] += share;
            changes[end as usize] -= share;
        }
    }
}

/// Where each part of some planes begins, then the end: parts of equal cost, nearly, of a plane at least.
fn ends(costs: &[i128], n_parts: usize) -> Vec<u32> {
    let total: i128 = costs.iter().sum();
    let (mut ends, mut before, mut plane) = (vec![0], 0i128, 0);
    for part in 1..n_parts {
        let wanted = total * part as i128 / n_parts as i128;
        let least = ends[part - 1] as usize + 1;
        let most = costs.len() - (n_parts - part);
        while plane < least || plane < most && before + costs[plane] / 2 < wanted {
            before += costs[plane];
            plane += 1;
        }
        ends.push(plane as u32);
    }
    ends.push(costs.len() as u32);
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cost_about_the_same_and_have_a_plane_at_least() {
        assert_eq!(ends(&[1; 12], 4), [0, 3, 6, 9, 12]);
        assert_eq!(ends(&[100, 1, 1, 1], 4), [0, 1, 2, 3, 4]);
        assert_eq!(ends(&[1, 1, 1, 100], 4), [0, 1, 2, 3, 4]);
        assert_eq!(ends(&[1, 1, 1, 1, 8, 8, 1, 1, 1, 1], 2), [0, 5, 10]);
        assert_eq!(ends(&[0; 5], 1), [0, 5]);
        for n_parts in 1..=40 {
            let costs: Vec<i128> = (0..40).map(|plane| 100 + plane * plane % 17).collect();
            let ends = ends(&costs, n_parts);
            assert!(ends.len() == n_parts + 1 && ends.is_sorted_by(|one, other| one < other), "{ends:?}");
            let of_part = |two: &[u32]| costs[two[0] as usize..two[1] as usize].iter().sum::<i128>();
            let (fair, most) =
                (costs.iter().sum::<i128>() / n_parts as i128, ends.windows(2).map(of_part).max().unwrap());
            assert!(most <= fair + 117, "{n_parts} parts: {most} of {fair}");
        }
    }

    #[test]
    fn planes_cost_their_rays_and_crossings_wherever_facets_lie() {
        let lines = Lines::new([0.0; 3], [1.0; 3], [4, 4, 8]).unwrap();
        // a quarter of a side of the box, across z, and one that is far away
        let side = [[0.0, 0.0, 2.5], [2.0, 0.0, 2.5], [0.0, 4.0, 2.5]];
        let far = side.map(|[x, y, _]: [f32; 3]| [x, y, 3e38]);
        let rays = Rays::new(2, lines.dims());
        let planes = costs(&[Geometry::new("side", 1, vec![side, far]).unwrap()], &lines, &rays).unwrap();
        let of_rays = (UNITS as i128) * 16 / 8;
        assert_eq!(planes[2], [0, 1, 2, 3, 4, 5, 6, 7].map(|z| of_rays + if z == 2 { 16 * UNITS as i128 } else { 0 }));
        assert_eq!(planes[0].len(), 4);
        let windows = parts(&[], &lines, &rays, [2, 1, 4], [1; 3]).unwrap();
        assert_eq!(windows.len(), 8);
        assert_eq!(windows[1], [[2, 0, 0], [4, 4, 2]]);
        let cells: u32 =
            windows.iter().map(|[first, end]| (0..3).map(|axis| end[axis] - first[axis]).product::<u32>()).sum();
        assert_eq!(cells, 128);
        assert_eq!(parts(&[], &lines, &rays, [5, 1, 1], [1; 3]).unwrap_err().code(), "job-value");
        let of_shards = parts(&[], &lines, &rays, [1, 2, 2], [4, 2, 3]).unwrap();
        assert_eq!(of_shards[..2], [[[0, 0, 0], [4, 2, 3]], [[0, 2, 0], [4, 4, 3]]]);
        assert_eq!(of_shards[2..], [[[0, 0, 3], [4, 2, 8]], [[0, 2, 3], [4, 4, 8]]]);
        let error = parts(&[], &lines, &rays, [1, 1, 4], [4, 2, 3]).unwrap_err();
        assert_eq!(error.to_string(), "4 parts along z, which has 8 cells, 3 shards of 3");
    }
}
