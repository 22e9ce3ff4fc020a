//! Faces of a cell that lead to the same are one, where they show much the same side.
//!
//! Polygons -> fewer. Two with a chain of edges in common become one, if their normals are within an angle and what is around both is one loop that passes each point once. A point within the chain
//! is of no other face of the cell. The sum of area vectors stays.

use super::planar::{Point, cone, dot};

/// A polygon and its area vector.
struct Polygon {
    ring: Vec<u32>,
    area: Point,
}

/// Merges polygons, given the cosine of the angle between those that may be merged.
pub(super) fn merged(polygons: impl Iterator<Item = Vec<u32>>, points: &[Point], least: f64) -> Vec<Vec<u32>> {
    let area = |ring: &[u32]| cone(ring.iter().map(|&at| points[at as usize]), [0.0; 3]).1;
    let mut all: Vec<Polygon> = polygons.map(|ring| Polygon { area: area(&ring), ring }).collect();
    let mut first = 0;
    while first < all.len() {
        let fits = |other: &usize| {
            let (one, other) = (&all[first], &all[*other]);
            let lengths = (dot(one.area, one.area) * dot(other.area, other.area)).sqrt();
            (dot(one.area, other.area) >= least * lengths).then(|| around(&one.ring, &other.ring)).flatten()
        };
        let found = (first + 1..all.len()).find_map(|other| fits(&other).map(|ring| (other, ring)));
        let Some((other, ring)) = found else {
            first += 1;
            continue;
        };
        all.swap_remove(other);
        all[first] = Polygon { area: area(&ring), ring };
        // those before may fit it now
        first = 0;
    }
    all.into_iter().map(|polygon| polygon.ring).collect()
}

/// The loop around two polygons with edges in common; None where there are none, or it is not one that passes each point once.
fn around(one: &[u32], other: &[u32]) -> Option<Vec<u32>> {
    let edges = |ring: &[u32]| -> Vec<(u32, u32)> {
        (0..ring.len()).map(|at| (ring[at], ring[(at + 1) % ring.len()])).collect()
    };
    let (of_one, of_other) = (edges(one), edges(other));
    let is_free = |others: &[(u32, u32)], (from, to): (u32, u32)| !others.contains(&(to, from));
    let mut left: Vec<(u32, u32)> = of_one.iter().copied().filter(|&edge| is_free(&of_other, edge)).collect();
    if left.len() == of_one.len() {
        return None;
    }
    left.extend(of_other.iter().copied().filter(|&edge| is_free(&of_one, edge)));
    let (start, mut at) = *left.first()?;
    let mut ring = vec![start];
    while at != start {
        ring.push(at);
        at = left.iter().find(|(from, _)| *from == at)?.1;
        if ring.len() > left.len() {
            return None;
        }
    }
    (ring.len() == left.len() && ring.len() > 2).then_some(ring)
}
