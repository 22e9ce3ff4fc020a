//! Holes of few edges, and the triangles that close them.
//!
//! Directed open edges, facets -> holes, the shortest first: open edges that follow each other around, from 3 to 8 of them, and pass no
//! corner twice. An edge of two holes of the same length belongs to neither: they stay open. Where three edges go around a triangle
//! that is not a facet itself, nothing else can have been there. So a facet that is lost costs no cell, however long it is, and where
//! one long edge lies beside two short ones (a T-junction) the triangle between them has no area. Holes of more edges are closed as
//! the surface around them goes on, with triangles that bend it little ([`patch`]).
//!
//! Cost: O(m sqrt(m)) for m open edges and triangles, at most: every triangle is looked for from its corner of the fewest open edges. Longer
//! holes pass no corner from which edges lead to more than [`MAX_BRANCHES`] others.

use glam::DVec3;

use crate::base::control::{Control, Paced};
use crate::base::error::Result;
use crate::base::sort::sort;

/// Facets, edges and corners that are looked at between two rests.
const OF_STEP: usize = if cfg!(target_arch = "wasm32") { 1 << 13 } else { 1 << 16 };

/// Most edges of a hole that is found.
const MAX_EDGES: usize = 8;
/// Most ways on from a corner of a hole of more than three edges: 3^6 ways to follow from every edge at worst.
const MAX_BRANCHES: usize = 3;

/// Takes holes out of sorted directed open edges: their corners by number, from the lowest, in the direction of the edges.
///
/// # Errors
/// `cancelled`.
pub(super) async fn holes(open: &mut Vec<(u32, u32)>, facets: &[[u32; 3]], control: &Control) -> Result<Vec<Vec<u32>>> {
    let mut holes = Vec::new();
    for n_edges in 3..=MAX_EDGES {
        let mut found =
            if n_edges == 3 { missing(open, facets, control).await? } else { cycles(open, n_edges, control).await? };
        control.rest().await?;
        let mut used: Vec<(u32, u32)> = found.iter().flat_map(|hole| edges(hole)).collect();
        sort(&mut used);
        let is_alone = |edge: (u32, u32)| {
            let at = used.partition_point(|other| *other < edge);
            used.get(at + 1) != Some(&edge)
        };
        found.retain(|hole| edges(hole).all(is_alone));
        sort(&mut found);
        let mut closed: Vec<(u32, u32)> = found.iter().flat_map(|hole| edges(hole)).collect();
        sort(&mut closed);
        let mut next = closed.iter().peekable();
        open.retain(|edge| next.next_if(|closed| *closed == edge).is_none());
        holes.append(&mut found);
        control.rest().await?;
    }
    Ok(holes)
}

/// Triangles around which open edges go and that are no facets.
async fn missing(open: &[(u32, u32)], facets: &[[u32; 3]], control: &Control) -> Result<Vec<Vec<u32>>> {
    let mut found = triangles(open, control).await?;
    let mut there: Vec<[u32; 3]> = found.iter().copied().map(sorted).collect();
    sort(&mut there);
    there.dedup();
    let mut is_there = vec![false; there.len()];
    let mut paced = Paced::new(control, OF_STEP);
    for facet in facets {
        paced.done(1).await?;
        if let Ok(at) = there.binary_search(&sorted(*facet)) {
            is_there[at] = true;
        }
    }
    found.retain(|&triangle| there.binary_search(&sorted(triangle)).is_ok_and(|at| !is_there[at]));
    Ok(found.into_iter().map(Vec::from).collect())
}

/// Ways of some open edges that come back to their first corner, the lowest, and pass no other twice.
async fn cycles(open: &[(u32, u32)], n_edges: usize, control: &Control) -> Result<Vec<Vec<u32>>> {
    let mut leaving = open.to_vec();
    leaving.dedup();
    let after = |corner: u32| {
        let all = leaving.partition_point(|edge| edge.0 < corner)..leaving.partition_point(|edge| edge.0 <= corner);
        if all.len() > MAX_BRANCHES { &[] } else { &leaving[all] }
    };
    let (mut found, mut paced) = (Vec::new(), Paced::new(control, OF_STEP));
    for first in leaving.chunk_by(|one, next| one.0 == next.0).map(|edges| edges[0].0) {
        // the edges that were not followed yet, of each corner on the way
        let mut way = vec![(first, after(first))];
        while let Some((_, left)) = way.last_mut() {
            paced.done(1).await?;
            let Some((&(_, next), rest)) = left.split_first() else {
                way.pop();
                continue;
            };
            *left = rest;
            if way.len() == n_edges {
                if next == first {
                    found.push(way.iter().map(|&(corner, _)| corner).collect());
                }
            } else if next > first && way.iter().all(|&(corner, _)| corner != next) {
                way.push((next, after(next)));
            }
        }
    }
    Ok(found)
}

/// Closes a hole with the fan, around one of its corners, that bends the surface least: the sum over all edges of its triangles, of
/// their length times the distance of the unit normals on both sides. `beside` is the unit normal of the facet at an edge of the hole.
pub(super) fn patch(hole: &[u32], place: impl Fn(u32) -> DVec3, beside: impl Fn((u32, u32)) -> DVec3) -> Vec<[u32; 3]> {
    // rounded, so that equal bends are equal however they are summed
    let mut best: Option<(f32, Vec<[u32; 3]>)> = None;
    for at in 0..hole.len() {
        // against the direction of the facets
        let ring: Vec<u32> = (0..hole.len()).map(|k| hole[(at + hole.len() - k) % hole.len()]).collect();
        let fan: Vec<[u32; 3]> = ring[1..].windows(2).map(|edge| [ring[0], edge[0], edge[1]]).collect();
        let [first, last] = [(ring[1], ring[0]), (ring[0], ring[ring.len() - 1])];
        let (mut bend, mut before, mut shared) = (0.0, beside(first), ring[1]);
        let bent =
            |(from, to): (u32, u32), one: DVec3, other: DVec3| place(from).distance(place(to)) * one.distance(other);
        for &[centre, from, to] in &fan {
            let normal = normal([centre, from, to].map(&place));
            bend += bent((centre, shared), before, normal) + bent((from, to), normal, beside((to, from)));
            (before, shared) = (normal, to);
        }
        bend += bent(last, before, beside(last));
        if best.as_ref().is_none_or(|(least, _)| (bend as f32) < *least) {
            best = Some((bend as f32, fan));
        }
    }
    best.map(|(_, fan)| fan).unwrap_or_default()
}

/// The unit normal of a triangle; zero where it has no area.
pub(super) fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Triangles of open edges that follow each other, each once, from their lowest corner.
async fn triangles(open: &[(u32, u32)], control: &Control) -> Result<Vec<[u32; 3]>> {
    let mut leaving = open.to_vec();
    leaving.dedup();
    let mut entering: Vec<(u32, u32)> = leaving.iter().map(|&(from, to)| (to, from)).collect();
    sort(&mut entering);
    let of = |edges: &'_ [(u32, u32)], corner: u32| {
        edges.partition_point(|edge| edge.0 < corner)..edges.partition_point(|edge| edge.0 <= corner)
    };
    let order = |corner: u32| (of(&leaving, corner).len() + of(&entering, corner).len(), corner);
    let (mut found, mut paced) = (Vec::new(), Paced::new(control, OF_STEP));
    for at in leaving.chunk_by(|one, next| one.0 == next.0).map(|edges| edges[0].0) {
        let after = |edges: &[(u32, u32)]| -> Vec<u32> {
            edges[of(edges, at)].iter().map(|edge| edge.1).filter(|&other| order(other) > order(at)).collect()
        };
        let (to, from) = (after(&leaving), after(&entering));
        for &next in &to {
            paced.done(1 + from.len()).await?;
            let closing = from.iter().filter(|&&last| leaving.binary_search(&(next, last)).is_ok());
            found.extend(closing.map(|&last| from_lowest([at, next, last])));
        }
        paced.done(1).await?;
    }
    Ok(found)
}

fn edges(hole: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    hole.iter().copied().zip(hole.iter().copied().cycle().skip(1))
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    sort(&mut corners);
    corners
}

fn from_lowest(corners: [u32; 3]) -> [u32; 3] {
    let lowest = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
    [0, 1, 2].map(|k| corners[(lowest + k) % 3])
}
