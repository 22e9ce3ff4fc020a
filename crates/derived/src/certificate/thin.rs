//! Thin walls: where a geometry has fewer cells across than a solver needs, or none.
//!
//! # Theory
//! A wall is thin along an axis if a ray enters through a facet whose normal lies nearest to that axis and leaves through another
//! such, within fewer than k centres of cells. Facets that lie along the ray do not count: at the silhouette of a ball rays are
//! short without a wall. So a wall at any angle is found along the axis nearest to its normal, where it is at most 1.7 times as
//! thick as across.
//!
//! A stretch belongs to the cell in which it begins, so that those of the windows of a box are those of the box: each window casts whole
//! rays of the box, those through its cells.
//!
//! Degenerate cases: where a geometry reaches beyond the domain along an axis, what touches the domain's ends is left out.
//! Cost: a cast of the rays of each axis that pass the box of a geometry.

use std::ops::Range;

use hexcast_core::grid::frame::{Frame, Ranks, SnappedFacet, normal};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu::{Window, over_windows, rays_through};
use hexcast_core::stages::crossings::Crossings;

/// Rows of rays that are cast together.
const ROWS: usize = 1 << 10;

/// Walls of a geometry that are thin along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThinWall {
    /// Index in the job.
    pub geometry: usize,
    /// 0, 1 or 2.
    pub axis: usize,
    /// Thin stretches of rays.
    pub rays: u64,
    /// Those that hold no centre: the wall is not in the mesh there.
    pub lost: u64,
    /// Fewest centres.
    pub cells: u32,
    /// A place with so few, in world coordinates.
    pub place: [f64; 3],
}

/// A stretch of a ray: number of centres, the ray's indices across, first centre.
type Thin = (u32, [u32; 2], u32);

/// Finds the walls of fewer than `k` cells, those that begin in some cells of the box, of the geometries that are wanted.
pub(super) fn thin_walls(
    cast: &Cast,
    lines: &Lines,
    cells: [[u32; 3]; 2],
    k: u32,
    is_wanted: impl Fn(usize) -> bool,
) -> Vec<ThinWall> {
    let mut found = Vec::new();
    for (position, &geometry) in cast.frame.ranks.geometry_at.iter().enumerate() {
        let facets = cast.frame.facets_at(position);
        if facets.is_empty() || !is_wanted(geometry) {
            continue;
        }
        for axis in 0..3 {
            let rays = Rays::new(axis, cast.frame.dims);
            let frame = aligned_or_not(facets, axis, cast.frame);
            let thin = thin_of(&Cast { frame: &frame, rays: &rays, rule: cast.rule }, cells, k);
            let Some(&(cells, across, first)) = thin.iter().min() else { continue };
            let mut place = [0.0; 3];
            for (across_axis, index) in rays.across.into_iter().zip(across) {
                place[across_axis] = f64::from(index) + 0.5;
            }
            place[axis] = f64::from(first) + 0.5 * f64::from(cells);
            found.push(ThinWall {
                geometry,
                axis,
                rays: thin.len() as u64,
                lost: thin.iter().filter(|thin| thin.0 == 0).count() as u64,
                cells,
                place: [0, 1, 2].map(|axis| lines.at(axis, place[axis])),
            });
        }
    }
    found
}

/// A frame of some facets: rank 0 where the normal lies nearest to an axis, 1 elsewhere.
fn aligned_or_not(facets: &[SnappedFacet], axis: usize, frame: &Frame) -> Frame {
    let is_aligned = |facet: &SnappedFacet| {
        let n = normal(facet).map(i128::abs);
        n[axis] >= n[0].max(n[1]).max(n[2])
    };
    // facets are stored in the order of positions
    let (aligned, others): (Vec<SnappedFacet>, Vec<SnappedFacet>) = facets.iter().copied().partition(is_aligned);
    let mut both = frame.with_facets([&aligned[..], &others[..]].concat());
    both.position_of_facet[aligned.len()..].fill(1);
    both.ranks = Ranks { geometry_at: vec![0; 2], rank_at: vec![0, 1], flag_of_rank: vec![1; 2] };
    both
}

fn thin_of(cast: &Cast, cells: [[u32; 3]; 2], k: u32) -> Vec<Thin> {
    let (rays, corners) = (cast.rays, cast.frame.facets.as_flattened());
    let span = |axis: usize| {
        let along = corners.iter().map(|corner| corner[axis]);
        [along.clone().min(), along.max()].map(Option::unwrap_or_default)
    };
    let through = rays_through(rays, cells);
    let within = |axis: usize, rays: &Range<u32>| {
        let [low, high] = span(axis);
        let [first, end] = [cast.frame.n_below(axis, low, false), cast.frame.n_below(axis, high, true)];
        first.clamp(rays.start, rays.end)..end.clamp(rays.start, rays.end)
    };
    let ([low, high], frame) = (span(rays.axis), cast.frame);
    // beyond half a cell outside, what is at the ends may reach further
    let outside = |centre: u32, face: u32| 2 * frame.face(rays.axis, face) - frame.centre(rays.axis, centre);
    let is_cut = low < outside(0, 0) || high >= outside(rays.depth - 1, rays.depth);
    let [across, down] = [0, 1].map(|index| within(rays.across[index], &through[index]));
    let [begin, end] = cells.map(|cell| cell[rays.axis]);
    // what begins behind the last centre is the last cell's
    let is_here = |first: u32| first >= begin && (first < end || end == rays.depth);
    let windows: Vec<Window> = down.map(|row| [across.clone(), row..row + 1]).collect();
    let of_row = |crossings: &Crossings| {
        let mut found = Vec::new();
        crossings.for_each_ray(|ray, events| {
            let n_across = u64::from(rays.counts[0]);
            let place = [(ray % n_across) as u32, (ray / n_across) as u32];
            for [start, end] in stretches(events, cast.rule) {
                let [(first, is_first), (last, is_last)] =
                    [start, end].map(|event| (event >> 9, event >> 1 & 0xff == 0));
                let touches_end = first == 0 || last == rays.depth;
                if is_first && is_last && last - first < k && is_here(first) && !(is_cut && touches_end) {
                    found.push((last - first, place, first));
                }
            }
        });
        found
    };
    let rows = windows.chunks(ROWS).flat_map(|rows| over_windows(cast, rows, false, of_row));
    rows.flatten().collect()
}

/// Where a ray enters and leaves a geometry, from its crossings in order.
fn stretches(events: &[u32], rule: Rule) -> Vec<[u32; 2]> {
    if rule == Rule::Parity {
        return events.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
    }
    let (mut winding, mut start, mut found) = (0, 0, Vec::new());
    for &event in events {
        let was_inside = winding != 0;
        winding += 1 - 2 * (event & 1) as i32;
        match (was_inside, winding != 0) {
            (false, true) => start = event,
            (true, false) => found.push([start, event]),
            _ => {}
        }
    }
    found
}
