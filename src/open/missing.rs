//! Missing facets: holes that one triangle closes.
//!
//! Directed open edges, facets -> the facets that are missing. Where three open edges follow each other around a triangle that is
//! not a facet itself, nothing else can have been there: the facet is added, and what was open is closed as it was. So a facet
//! that is lost costs no cell, however long it is, and where one long edge lies beside two short ones (a T-junction) the
//! triangle between them has no area. An edge of two such triangles belongs to neither: they stay holes.
//!
//! Cost: O(m sqrt(m)) for m open edges, at most: every triangle is looked for from its corner of the fewest open edges.

use crate::sort::sort;

/// Takes triangles out of sorted directed open edges: those that are missing, in the direction of facets, by the numbers of corners.
pub(super) fn missing(open: &mut Vec<(u32, u32)>, facets: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut found = triangles(open);
    let mut there: Vec<[u32; 3]> = found.iter().copied().map(sorted).collect();
    sort(&mut there);
    there.dedup();
    let mut is_there = vec![false; there.len()];
    for facet in facets {
        if let Ok(at) = there.binary_search(&sorted(*facet)) {
            is_there[at] = true;
        }
    }
    found.retain(|&triangle| there.binary_search(&sorted(triangle)).is_ok_and(|at| !is_there[at]));
    let mut used: Vec<(u32, u32)> = found.iter().flat_map(edges).collect();
    sort(&mut used);
    let is_alone = |edge: (u32, u32)| {
        let at = used.partition_point(|other| *other < edge);
        used.get(at + 1) != Some(&edge)
    };
    found.retain(|triangle| edges(triangle).into_iter().all(is_alone));
    sort(&mut found);
    let mut closed: Vec<(u32, u32)> = found.iter().flat_map(edges).collect();
    sort(&mut closed);
    let mut next = closed.iter().peekable();
    open.retain(|edge| next.next_if(|closed| *closed == edge).is_none());
    found.into_iter().map(|[a, b, c]| [c, b, a]).collect()
}

/// Triangles of open edges that follow each other, each once, from their lowest corner.
fn triangles(open: &[(u32, u32)]) -> Vec<[u32; 3]> {
    let mut leaving = open.to_vec();
    leaving.dedup();
    let mut entering: Vec<(u32, u32)> = leaving.iter().map(|&(from, to)| (to, from)).collect();
    sort(&mut entering);
    let of = |edges: &'_ [(u32, u32)], corner: u32| {
        edges.partition_point(|edge| edge.0 < corner)..edges.partition_point(|edge| edge.0 <= corner)
    };
    let order = |corner: u32| (of(&leaving, corner).len() + of(&entering, corner).len(), corner);
    let mut found = Vec::new();
    for at in leaving.chunk_by(|one, next| one.0 == next.0).map(|edges| edges[0].0) {
        let after = |edges: &[(u32, u32)]| -> Vec<u32> {
            edges[of(edges, at)].iter().map(|edge| edge.1).filter(|&other| order(other) > order(at)).collect()
        };
        let (to, from) = (after(&leaving), after(&entering));
        for &next in &to {
            let closing = from.iter().filter(|&&last| leaving.binary_search(&(next, last)).is_ok());
            found.extend(closing.map(|&last| from_lowest([at, next, last])));
        }
    }
    found
}

fn edges(&[a, b, c]: &[u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    sort(&mut corners);
    corners
}

fn from_lowest(corners: [u32; 3]) -> [u32; 3] {
    let lowest = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
    [0, 1, 2].map(|k| corners[(lowest + k) % 3])
}
