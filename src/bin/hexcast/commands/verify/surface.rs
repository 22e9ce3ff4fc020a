//! Surfaces with holes: whether one is closed, its facets turned to agree, and its winding number at a point.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use glam::DVec3;
use hexcast::job::Rule;
use rayon::prelude::*;

use super::ray::{Facet, normal};

type Corner = [i32; 3];

/// Where an edge starts and ends.
type Edge = (Corner, Corner);

/// The corners of an edge in their order, the facet that uses it, and whether it does so in this order.
type Use = (Corner, Corner, u32, bool);

/// Turns the facets of a body to agree with their neighbours, and adds those that are missing; beside these the triangles that close its
/// other small holes. None if it is closed. `sizes` are those of the cells, in any unit.
///
/// Facets that share an edge with one other agree if they use it in opposite directions. Such edges join them to groups, in the order
/// of their corners; one that contradicts those before is left out. Of each group most stay as they are, of two halves
/// the one with the first facet.
pub(super) fn turned(facets: &[Facet], sizes: [f64; 3], rule: Rule) -> Option<[Vec<Facet>; 2]> {
    let uses_of = |(index, facet): (usize, &Facet)| {
        let edges = edges_of(facet).filter(|(from, to)| from != to);
        edges.map(|(from, to)| (from.min(to), from.max(to), index as u32, from < to)).collect::<Vec<Use>>()
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
    let [missing, patches] = closing(&turned, sizes);
    turned.extend(missing);
    Some([turned, patches])
}

/// The facets that are missing, and the triangles that close other holes: the shortest first, of 3 to 8 edges that are used once more
/// one way than the other and follow each other around, without an edge of another such hole. Of three edges it is a missing facet
/// unless there is one; of more, none of its corners has more than three ways on.
fn closing(facets: &[Facet], sizes: [f64; 3]) -> [Vec<Facet>; 2] {
    let (mut surplus, mut beside) = (BTreeMap::<Edge, i32>::new(), HashMap::new());
    for (facet, (from, to)) in facets.iter().flat_map(|facet| edges_of(facet).map(move |edge| (facet, edge))) {
        *surplus.entry((from, to)).or_default() += 1;
        *surplus.entry((to, from)).or_default() -= 1;
        beside.entry((from, to)).or_insert(*facet);
    }
    let known: HashSet<BTreeSet<Corner>> = facets.iter().map(|facet| BTreeSet::from(*facet)).collect();
    let mut closing = [Vec::new(), Vec::new()];
    for n in 3..=8 {
        surplus.retain(|_, surplus| *surplus > 0);
        let mut next = BTreeMap::<Corner, Vec<Corner>>::new();
        surplus.keys().for_each(|edge| next.entry(edge.0).or_default().push(edge.1));
        next.retain(|_, ends| n == 3 || ends.len() <= 3);
        let after = |way: &Vec<Corner>| next.get(&way[way.len() - 1]).into_iter().flatten();
        let mut ways: Vec<Vec<Corner>> = next.keys().map(|&first| vec![first]).collect();
        for _ in 1..n {
            let goes_on = |way: &Vec<Corner>, to: &Corner| *to > way[0] && !way.contains(to);
            let longer = |way| after(way).filter(|to| goes_on(way, to)).map(|&to| [&way[..], &[to]].concat());
            ways = ways.iter().flat_map(longer).collect();
        }
        let is_facet = |way: &[Corner]| n == 3 && known.contains(&way.iter().copied().collect());
        ways.retain(|way| after(way).any(|to| *to == way[0]) && !is_facet(way));
        let mut uses = HashMap::<Edge, u32>::new();
        ways.iter().flat_map(|way| edges_of(way)).for_each(|edge| *uses.entry(edge).or_default() += 1);
        for way in ways.iter().filter(|way| edges_of(way).all(|edge| uses[&edge] == 1)) {
            edges_of(way).for_each(|edge| *surplus.entry(edge).or_default() -= 1);
            closing[usize::from(n > 3)].extend(least_bent(way, &beside, sizes));
        }
    }
    closing
}

/// The fan of triangles over a hole that bends the surface least: the sum over edges of length times the distance of unit normals.
fn least_bent(way: &[Corner], beside: &HashMap<Edge, Facet>, sizes: [f64; 3]) -> Vec<Facet> {
    let n = way.len();
    let place = |corner: Corner| DVec3::from(corner.map(f64::from)) * DVec3::from(sizes);
    let unit = |[p, q, r]: Facet| (place(q) - place(p)).cross(place(r) - place(p)).normalize_or_zero();
    let fan = |at: usize| (1..n - 1).map(|k| [0, k, k + 1].map(|k| way[(at + n - k) % n])).collect::<Vec<Facet>>();
    let bend = |fan: &Vec<Facet>| {
        let of_edge = |one: &Facet, (from, to): Edge| {
            let other = fan.iter().find(|other| edges_of(*other).any(|edge| edge == (to, from)));
            // an edge within the fan is met twice
            let (other, share) = other.map_or_else(|| (beside[&(to, from)], 1.0), |other| (*other, 0.5));
            share * place(from).distance(place(to)) * unit(*one).distance(unit(other))
        };
        fan.iter().flat_map(|one| edges_of(one).map(|edge| of_edge(one, edge))).sum::<f64>() as f32
    };
    (0..n).map(fan).min_by(|one, other| bend(one).total_cmp(&bend(other))).unwrap_or_default()
}

fn edges_of(way: &[Corner]) -> impl Iterator<Item = Edge> {
    way.iter().copied().zip(way.iter().copied().cycle().skip(1))
}

/// The winding number of a surface at the centre of a cell, the solid angles of all its facets and patches over 4 pi; and how far it may be off.
///
/// A facet's side of the centre is exact. Its angle is that at a point before the centre, as the tie rule has it, by finite lengths.
/// Where that point is on the other side, the angle is turned round, and what this may miss is doubt. Nothing is known at edges.
pub(super) fn winding(facets: [&[Facet]; 2], centre: [i64; 3], sizes: [f64; 3]) -> (f64, f64) {
    const BEFORE: DVec3 = DVec3::new(0.25, 0.25 / 512.0, 0.25 / 512.0 / 512.0);
    let (mut sum, mut doubt) = (0.0, 1e-6);
    for facet in facets.into_iter().flatten() {
        let corners = facet.map(|corner| [0, 1, 2].map(|axis| i64::from(corner[axis]) - centre[axis]));
        let normal = normal(&corners);
        let height: i128 = (0..3).map(|axis| i128::from(normal[axis]) * i128::from(corners[0][axis])).sum();
        let heights = [height, normal[0].into(), normal[1].into(), normal[2].into()];
        let Some(height) = heights.into_iter().find(|&height| height != 0) else { continue };
        let [a, b, c] = corners.map(|at| (DVec3::from(at.map(|c| c as f64)) + BEFORE) * DVec3::from(sizes));
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        let angle = a.dot(b.cross(c)).atan2(below) / std::f64::consts::TAU;
        let is_before = (angle > 0.0) == (height > 0);
        sum += if is_before { angle } else { -angle };
        let is_at_edge = [(0, 1), (1, 2), (2, 0)].iter().any(|&(from, to)| is_at_edge(corners[from], corners[to]));
        let missed = if is_before { 0.0 } else { angle.abs().min(0.5 - angle.abs()) };
        doubt += if is_at_edge { 1.0 } else { missed };
    }
    (sum, doubt)
}

/// Whether the origin is less than two units from an edge.
fn is_at_edge(p: [i64; 3], q: [i64; 3]) -> bool {
    let is_near = (0..3).all(|axis| p[axis].min(q[axis]) <= 2 && p[axis].max(q[axis]) >= -2);
    let squared = |v: [i64; 3]| v.iter().map(|&length| (length as f64).powi(2)).sum::<f64>();
    is_near && squared(normal(&[[0; 3], p, q])) <= 4.0 * squared([0, 1, 2].map(|axis| q[axis] - p[axis]))
}
