//! Orientation: facets that share an edge are turned to agree, what facets are missing between them, and what edges are open then.
//!
//! Snapped facets -> the same, turned, the missing ones, those that close small holes, and the loops of the edges that are open beside these. An edge with two facets joins them: they agree if they
//! use it in opposite directions. Of each group of joined facets the side that has more of them as they are in the file stays.
//! An edge is open as often as its facets use it more one way than the other; since every facet is a triangle, as many
//! open edges begin at a corner as end there, so that they form loops.
//!
//! Degenerate cases: edges with three or more facets join nothing; a group that cannot be oriented (a Moebius strip) keeps open
//! edges where it was cut. Cost: O(n log n) for n facets, in an order that does not depend on the machine.

use glam::DVec3;

use super::holes::{holes, normal, patch};
use crate::frame::SnappedFacet;
use crate::parallel::*;
use crate::sort::{par_sort, sort};

/// A surface whose facets agree as far as they can.
pub(super) struct Oriented {
    pub(super) facets: Vec<SnappedFacet>,
    /// Facets that were missing.
    pub(super) missing: Vec<SnappedFacet>,
    /// Triangles that close holes of a few more edges.
    pub(super) patches: Vec<SnappedFacet>,
    pub(super) n_turned: u64,
    /// Holes of few edges.
    pub(super) n_closed: u64,
    /// Corners of each loop of the other open edges, in the direction in which the facets use them.
    pub(super) loops: Vec<Vec<[i32; 3]>>,
    /// Edges that are open, each once, with those of small holes.
    pub(super) open_edges: Vec<[[i32; 3]; 2]>,
}

/// One use of an edge by a facet: the numbers of its corners, the lower first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Use {
    low: u32,
    high: u32,
    facet: u32,
    is_forward: bool,
}

/// Turns facets to agree with their neighbours and finds holes and the loops of the other open edges. `sizes` are the lengths of the
/// snap's unit along the axes.
pub(super) fn orient(facets: &[SnappedFacet], sizes: [f64; 3]) -> Oriented {
    let mut corners: Vec<[i32; 3]> = facets.iter().flatten().copied().collect();
    par_sort(&mut corners);
    corners.dedup();
    let number = |corner: &[i32; 3]| corners.partition_point(|other| other < corner) as u32;
    let numbers: Vec<[u32; 3]> = facets.par_iter().map(|facet| facet.each_ref().map(number)).collect();
    let mut uses = Vec::with_capacity(3 * facets.len());
    for (facet, numbers) in numbers.iter().enumerate() {
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(from, to)| (numbers[from], numbers[to])) {
            if from != to {
                uses.push(Use { low: from.min(to), high: from.max(to), facet: facet as u32, is_forward: from < to });
            }
        }
    }
    par_sort(&mut uses);
    let is_turned = turned(&uses, facets.len());
    let (mut open, mut beside) = (Vec::new(), Vec::new());
    for edge in uses.chunk_by(|one, next| (one.low, one.high) == (next.low, next.high)) {
        let goes_up = |entry: &Use| entry.is_forward != is_turned[entry.facet as usize];
        let forward = edge.iter().filter(|&entry| goes_up(entry)).count();
        let surplus = 2 * forward as i64 - edge.len() as i64;
        let directed = if surplus > 0 { (edge[0].low, edge[0].high) } else { (edge[0].high, edge[0].low) };
        open.extend(std::iter::repeat_n(directed, surplus.unsigned_abs() as usize));
        let first = edge.iter().find(|&entry| surplus != 0 && goes_up(entry) == (surplus > 0));
        beside.extend(first.map(|entry| (directed, entry.facet)));
    }
    sort(&mut open);
    sort(&mut beside);
    let holes = holes(&mut open, &numbers);
    let place = |at: u32| DVec3::from(corners[at as usize].map(f64::from)) * DVec3::from(sizes);
    let normal_beside = |edge: (u32, u32)| {
        let at = beside.partition_point(|other| other.0 < edge);
        let facet = beside[at].1 as usize;
        let upwards = normal(numbers[facet].map(place));
        if is_turned[facet] { -upwards } else { upwards }
    };
    let (mut missing, mut patches) = (Vec::new(), Vec::new());
    for hole in &holes {
        match hole[..] {
            [a, b, c] => missing.push([c, b, a]),
            _ => patches.append(&mut patch(hole, place, normal_beside)),
        }
    }
    let in_place =
        |facets: Vec<[u32; 3]>| facets.into_iter().map(|facet| facet.map(|at| corners[at as usize])).collect();
    let turn = |(facet, &is_turned): (&SnappedFacet, &bool)| {
        let [a, b, c] = *facet;
        if is_turned { [a, c, b] } else { [a, b, c] }
    };
    Oriented {
        facets: facets.iter().zip(&is_turned).map(turn).collect(),
        missing: in_place(missing),
        patches: in_place(patches),
        n_closed: holes.len() as u64,
        n_turned: is_turned.iter().filter(|&&is_turned| is_turned).count() as u64,
        loops: loops(&open).into_iter().map(|found| found.iter().map(|&at| corners[at as usize]).collect()).collect(),
        open_edges: beside.iter().map(|&((from, to), _)| [from, to].map(|at| corners[at as usize])).collect(),
    }
}

/// Which facets have to be turned.
fn turned(uses: &[Use], n_facets: usize) -> Vec<bool> {
    let mut groups = Groups::new(n_facets);
    for edge in uses.chunk_by(|one, next| (one.low, one.high) == (next.low, next.high)) {
        if let [one, other] = edge {
            groups.join(one.facet, other.facet, one.is_forward == other.is_forward);
        }
    }
    let sides: Vec<(u32, bool)> = (0..n_facets as u32).map(|facet| groups.find(facet)).collect();
    // facets of each group, by its root, that are on the other side than the root
    let mut counts = vec![[0u32; 2]; n_facets];
    for &(root, is_other) in &sides {
        counts[root as usize][usize::from(is_other)] += 1;
    }
    let is_turned = |&(root, is_other): &(u32, bool)| {
        let [like, unlike] = counts[root as usize];
        is_other == (like >= unlike)
    };
    sides.iter().map(is_turned).collect()
}

/// Facets in groups, each with its side: whether it agrees with the root of its group. Union by index, path halving.
struct Groups {
    parent: Vec<u32>,
    differs: Vec<bool>,
}

impl Groups {
    fn new(n: usize) -> Groups {
        Groups { parent: (0..n as u32).collect(), differs: vec![false; n] }
    }

    /// The root of a facet's group, and whether the facet differs from it.
    fn find(&mut self, mut facet: u32) -> (u32, bool) {
        let mut differs = false;
        while self.parent[facet as usize] != facet {
            let at = facet as usize;
            let above = self.parent[at];
            self.differs[at] ^= self.differs[above as usize];
            self.parent[at] = self.parent[above as usize];
            differs ^= self.differs[at];
            facet = self.parent[at];
        }
        (facet, differs)
    }

    fn join(&mut self, one: u32, other: u32, differ: bool) {
        let ((one, one_differs), (other, other_differs)) = (self.find(one), self.find(other));
        if one != other {
            let (low, high) = (one.min(other), one.max(other));
            self.parent[high as usize] = low;
            self.differs[high as usize] = differ ^ one_differs ^ other_differs;
        }
    }
}

/// Takes sorted directed edges, of which as many begin at a corner as end there, apart into loops that pass no corner twice.
fn loops(edges: &[(u32, u32)]) -> Vec<Vec<u32>> {
    let mut starts: Vec<u32> = edges.iter().map(|&(from, _)| from).collect();
    starts.dedup();
    let place = |corner: u32| starts.partition_point(|&other| other < corner);
    // the next unused edge of each corner, and where on the way it is
    let mut next: Vec<usize> = starts.iter().map(|&from| edges.partition_point(|edge| edge.0 < from)).collect();
    let mut on_way: Vec<Option<usize>> = vec![None; starts.len()];
    let mut found = Vec::new();
    for first in 0..starts.len() {
        let mut way: Vec<usize> = vec![first];
        on_way[first] = Some(0);
        while let Some(&at) = way.last() {
            let Some(&(_, to)) = edges.get(next[at]).filter(|edge| edge.0 == starts[at]) else {
                // all edges of the first corner are used, and the way is back at it
                on_way[at] = None;
                way.pop();
                continue;
            };
            next[at] += 1;
            let to = place(to);
            match on_way[to] {
                Some(begin) => {
                    found.push(way[begin..].iter().map(|&at| starts[at]).collect());
                    for at in way.drain(begin + 1..) {
                        on_way[at] = None;
                    }
                }
                None => {
                    on_way[to] = Some(way.len());
                    way.push(to);
                }
            }
        }
    }
    found
}
