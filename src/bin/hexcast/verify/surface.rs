//! Surfaces with holes: whether one is closed, its facets turned to agree, and its winding number at a point.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::f64::consts::PI;

use hexcast::job::Rule;
use rayon::prelude::*;

use super::ray::{Facet, normal};

type Corner = [i32; 3];

/// The corners of an edge in their order, the facet that uses it, and whether it does so in this order.
type Use = (Corner, Corner, u32, bool);

/// Turns the facets of a body to agree with their neighbours, and adds those that are missing; None if it is closed.
///
/// Facets that share an edge with one other agree if they use it in opposite directions. Such edges join them to groups, in the order
/// of their corners; one that contradicts those before is left out. Of each group most stay as they are, of two halves
/// the one with the first facet.
pub(super) fn turned(facets: &[Facet], rule: Rule) -> Option<Vec<Facet>> {
    let uses_of = |(index, facet): (usize, &Facet)| {
        let edges = edges_of(facet).into_iter().filter(|(from, to)| from != to);
        edges.map(move |(from, to)| (from.min(to), from.max(to), index as u32, from < to))
    };
    // those of an edge together; one between equal corners is none
    let mut uses: Vec<Use> = facets.par_iter().enumerate().flat_map_iter(uses_of).collect();
    uses.par_sort_unstable();
    let edges = || uses.chunk_by(|one, next| (one.0, one.1) == (next.0, next.1));
    let is_closed = |edge: &[Use]| match rule {
        Rule::Parity => edge.len().is_multiple_of(2),
        Rule::Nonzero => edge.iter().filter(|one| one.3).count() * 2 == edge.len(),
    };
    if edges().all(is_closed) {
        return None;
    }
    // of each facet: its group, named after one of them, and whether it differs from that one; the smaller group joins the larger
    let mut group: Vec<(usize, bool)> = (0..facets.len()).map(|facet| (facet, false)).collect();
    let mut members: Vec<Vec<usize>> = (0..facets.len()).map(|facet| vec![facet]).collect();
    for edge in edges() {
        let [(.., one, one_way), (.., other, other_way)] = *edge else { continue };
        let (mut to, mut from) = (group[one as usize], group[other as usize]);
        if members[to.0].len() < members[from.0].len() {
            (to, from) = (from, to);
        }
        if to.0 != from.0 {
            let differs = to.1 ^ from.1 ^ (one_way == other_way);
            for facet in std::mem::take(&mut members[from.0]) {
                group[facet] = (to.0, group[facet].1 ^ differs);
                members[to.0].push(facet);
            }
        }
    }
    let mut turned = facets.to_vec();
    for members in members.iter().filter(|members| !members.is_empty()) {
        let n_differ = members.iter().filter(|&&facet| group[facet].1).count();
        let first = members.iter().min().is_some_and(|&facet| group[facet].1);
        let stays = if 2 * n_differ == members.len() { first } else { 2 * n_differ > members.len() };
        members.iter().filter(|&&facet| group[facet].1 != stays).for_each(|&facet| turned[facet].swap(1, 2));
    }
    turned.extend(missing(&turned));
    Some(turned)
}

/// The facets that are missing: where three edges that are used once more one way than the other follow each other around a triangle
/// that is no facet. An edge of two such triangles belongs to neither.
fn missing(facets: &[Facet]) -> Vec<Facet> {
    let mut surplus: BTreeMap<(Corner, Corner), i32> = BTreeMap::new();
    for (from, to) in facets.iter().flat_map(edges_of) {
        *surplus.entry((from, to)).or_default() += 1;
        *surplus.entry((to, from)).or_default() -= 1;
    }
    surplus.retain(|_, surplus| *surplus > 0);
    let known: HashSet<BTreeSet<Corner>> = facets.iter().map(|facet| BTreeSet::from(*facet)).collect();
    let is_missing = |facet: &Facet| surplus.contains_key(&(facet[0], facet[2])) && !known.contains(&(*facet).into());
    let mut found: Vec<Facet> = Vec::new();
    for &(a, b) in surplus.keys().filter(|(a, b)| a < b) {
        let ends = surplus.range((b, a)..).map(|(next, _)| next).take_while(|next| next.0 == b);
        found.extend(ends.map(|&(_, c)| [c, b, a]).filter(is_missing));
    }
    found.iter().flat_map(edges_of).for_each(|edge| *surplus.entry(edge).or_default() += 1);
    found.retain(|facet| edges_of(facet).iter().all(|edge| surplus[edge] == 1));
    found
}

fn edges_of(&[a, b, c]: &Facet) -> [(Corner, Corner); 3] {
    [(a, b), (b, c), (c, a)]
}

/// The winding number of a surface at the centre of a cell, the solid angles of all facets over 4 pi; and how far it may be off.
///
/// A facet's side of the centre is exact. Its angle is that at a point before the centre, as the tie rule has it, by finite lengths.
/// Where that point is on the other side, the angle is turned round, and what this may miss is doubt. Nothing is known at edges.
pub(super) fn winding(facets: &[Facet], cell: [u32; 3], bits: u32, spacing: [f64; 3]) -> (f64, f64) {
    const BEFORE: [f64; 3] = [0.25, 0.25 / 512.0, 0.25 / 512.0 / 512.0];
    let centre = cell.map(|index| i64::from(index) << bits);
    let (mut sum, mut doubt) = (0.0, 1e-6);
    for facet in facets {
        let corners = facet.map(|corner| [0, 1, 2].map(|axis| i64::from(corner[axis]) - centre[axis]));
        let normal = normal(&corners);
        let height: i128 = (0..3).map(|axis| i128::from(normal[axis]) * i128::from(corners[0][axis])).sum();
        let heights = [height, normal[0].into(), normal[1].into(), normal[2].into()];
        let Some(height) = heights.into_iter().find(|&height| height != 0) else { continue };
        let place = |corner: [i64; 3], axis: usize| (corner[axis] as f64 + BEFORE[axis]) * spacing[axis] / spacing[0];
        let [a, b, c] = corners.map(|corner| [0, 1, 2].map(|axis| place(corner, axis)));
        let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let [la, lb, lc] = [a, b, c].map(|v| dot(v, v).sqrt());
        let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        let angle = dot(a, cross).atan2(below) / (2.0 * PI);
        let is_before = (angle > 0.0) == (height > 0);
        sum += if is_before { angle } else { -angle };
        doubt += match is_before {
            _ if [(0, 1), (1, 2), (2, 0)].iter().any(|&(from, to)| is_at_edge(corners[from], corners[to])) => 1.0,
            true => 0.0,
            false => angle.abs().min(0.5 - angle.abs()),
        };
    }
    (sum, doubt)
}

/// Whether the origin is less than two units from an edge.
fn is_at_edge(p: [i64; 3], q: [i64; 3]) -> bool {
    let is_near = (0..3).all(|axis| p[axis].min(q[axis]) <= 2 && p[axis].max(q[axis]) >= -2);
    let squared = |v: [i64; 3]| v.iter().map(|&length| (length as f64).powi(2)).sum::<f64>();
    is_near && squared(normal(&[[0; 3], p, q])) <= 4.0 * squared([0, 1, 2].map(|axis| q[axis] - p[axis]))
}
