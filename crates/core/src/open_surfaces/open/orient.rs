//! Orientation: facets that share an edge are turned to agree, what facets are missing between them, and what edges are open then.
//!
//! Snapped facets -> the same, turned, the missing ones, those that close small holes, and the loops of the edges that are open beside these;
//! with rests. An edge with two facets joins them: they agree if they
//! use it in opposite directions. Of each group of joined facets the side that has more of them as they are in the file stays.
//! An edge is open as often as its facets use it more one way than the other; since every facet is a triangle, as many
//! open edges begin at a corner as end there, so that they form loops.
//!
//! Degenerate cases: edges with three or more facets join nothing; a group that cannot be oriented (a Moebius strip) keeps open
//! edges where it was cut. Cost: O(n log n) for n facets, in an order that does not depend on the machine.

use glam::DVec3;

use super::holes::{holes, normal, patch};
use crate::base::control::{Control, Paced};
use crate::base::error::Result;
use crate::base::parallel::*;
use crate::base::sort::par_sort;
use crate::grid::frame::SnappedFacet;

/// Facets, edges or uses of edges that are looked at between two rests.
const OF_STEP: usize = if cfg!(target_arch = "wasm32") { 1 << 14 } else { 1 << 17 };
/// The same, of a list that is sorted.
const OF_SORT: usize = 8 * OF_STEP;

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
///
/// # Errors
/// `cancelled`.
pub(super) async fn orient(facets: &[SnappedFacet], sizes: [f64; 3], control: &Control) -> Result<Oriented> {
    let mut corners: Vec<[i32; 3]> = facets.iter().flatten().copied().collect();
    sort_in_steps(&mut corners, control).await?;
    corners.dedup();
    let number = |corner: &[i32; 3]| corners.partition_point(|other| other < corner) as u32;
    let mut numbers: Vec<[u32; 3]> = Vec::with_capacity(facets.len());
    for some in facets.chunks(OF_STEP) {
        numbers.par_extend(some.par_iter().map(|facet| facet.each_ref().map(number)));
        control.rest().await?;
    }
    let mut uses = uses(&numbers);
    sort_in_steps(&mut uses, control).await?;
    let is_turned = turned(&uses, facets.len(), control).await?;
    let (mut open, beside) = open_edges(&uses, &is_turned, control).await?;
    drop(uses);
    let holes = holes(&mut open, &numbers, control).await?;
    let place = |at: u32| DVec3::from(corners[at as usize].map(f64::from)) * DVec3::from(sizes);
    let normal_beside = |edge: (u32, u32)| {
        let at = beside.partition_point(|other| other.0 < edge);
        let facet = beside[at].1 as usize;
        let upwards = normal(numbers[facet].map(place));
        if is_turned[facet] { -upwards } else { upwards }
    };
    let (mut missing, mut patches, mut paced) = (Vec::new(), Vec::new(), Paced::new(control, OF_STEP));
    for hole in &holes {
        match hole[..] {
            [a, b, c] => missing.push([c, b, a]),
            _ => patches.append(&mut patch(hole, place, normal_beside)),
        }
        paced.done(8).await?;
    }
    let loops = loops(open, &corners, control).await?;
    control.rest().await?;
    let in_place =
        |facets: Vec<[u32; 3]>| facets.into_iter().map(|facet| facet.map(|at| corners[at as usize])).collect();
    let turn = |(facet, &is_turned): (&SnappedFacet, &bool)| {
        let [a, b, c] = *facet;
        if is_turned { [a, c, b] } else { [a, b, c] }
    };
    Ok(Oriented {
        facets: facets.iter().zip(&is_turned).map(turn).collect(),
        missing: in_place(missing),
        patches: in_place(patches),
        n_closed: holes.len() as u64,
        n_turned: is_turned.iter().filter(|&&is_turned| is_turned).count() as u64,
        loops: loops.into_iter().map(|found| found.iter().map(|&at| corners[at as usize]).collect()).collect(),
        open_edges: beside.iter().map(|&((from, to), _)| [from, to].map(|at| corners[at as usize])).collect(),
    })
}

/// Sorts a list, a part at a time.
async fn sort_in_steps<T: Ord + Send>(list: &mut [T], control: &Control) -> Result<()> {
    let mut left = vec![list];
    while let Some(part) = left.pop() {
        if part.len() <= OF_SORT {
            par_sort(part);
        } else {
            let middle = part.len() / 2;
            part.select_nth_unstable(middle);
            let (lower, upper) = part.split_at_mut(middle);
            left.extend([upper, lower]);
        }
        control.rest().await?;
    }
    Ok(())
}

/// The edges of facets whose corners have these numbers.
fn uses(numbers: &[[u32; 3]]) -> Vec<Use> {
    let mut uses = Vec::with_capacity(3 * numbers.len());
    for (facet, numbers) in numbers.iter().enumerate() {
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(from, to)| (numbers[from], numbers[to])) {
            if from != to {
                uses.push(Use { low: from.min(to), high: from.max(to), facet: facet as u32, is_forward: from < to });
            }
        }
    }
    uses
}

/// A directed edge, and a facet that uses it so.
type Beside = ((u32, u32), u32);

/// Open edges as often as they are open, and each once with a facet at it; both sorted.
async fn open_edges(uses: &[Use], is_turned: &[bool], control: &Control) -> Result<(Vec<(u32, u32)>, Vec<Beside>)> {
    let (mut open, mut beside, mut paced) = (Vec::new(), Vec::new(), Paced::new(control, OF_STEP));
    for edge in uses.chunk_by(|one, next| (one.low, one.high) == (next.low, next.high)) {
        let goes_up = |entry: &Use| entry.is_forward != is_turned[entry.facet as usize];
        let forward = edge.iter().filter(|&entry| goes_up(entry)).count();
        let surplus = 2 * forward as i64 - edge.len() as i64;
        let directed = if surplus > 0 { (edge[0].low, edge[0].high) } else { (edge[0].high, edge[0].low) };
        open.extend(std::iter::repeat_n(directed, surplus.unsigned_abs() as usize));
        let first = edge.iter().find(|&entry| surplus != 0 && goes_up(entry) == (surplus > 0));
        beside.extend(first.map(|entry| (directed, entry.facet)));
        paced.done(edge.len()).await?;
    }
    sort_in_steps(&mut open, control).await?;
    sort_in_steps(&mut beside, control).await?;
    Ok((open, beside))
}

/// Which facets have to be turned.
async fn turned(uses: &[Use], n_facets: usize, control: &Control) -> Result<Vec<bool>> {
    let (mut groups, mut paced) = (Groups::new(n_facets), Paced::new(control, OF_STEP));
    for edge in uses.chunk_by(|one, next| (one.low, one.high) == (next.low, next.high)) {
        if let [one, other] = edge {
            groups.join(one.facet, other.facet, one.is_forward == other.is_forward);
        }
        paced.done(edge.len()).await?;
    }
    let mut sides: Vec<(u32, bool)> = Vec::with_capacity(n_facets);
    // facets of each group, by its root, that are on the other side than the root
    let mut counts = vec![[0u32; 2]; n_facets];
    for facet in 0..n_facets as u32 {
        let (root, is_other) = groups.find(facet);
        sides.push((root, is_other));
        counts[root as usize][usize::from(is_other)] += 1;
        paced.done(1).await?;
    }
    let is_turned = |&(root, is_other): &(u32, bool)| {
        let [like, unlike] = counts[root as usize];
        is_other == (like >= unlike)
    };
    Ok(sides.iter().map(is_turned).collect())
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

/// Most edges that leave a corner and are compared.
const MAX_LEAVING: usize = 256;
/// Corners on the way to which the next is near.
const RECENT: usize = 4;

/// Takes sorted directed edges, of which as many begin at a corner as end there, apart into loops that pass no corner twice. Where several
/// edges lead on, a loop takes the one that stays nearest to where it was last: so loops are short, and the triangles in them small.
async fn loops(mut edges: Vec<(u32, u32)>, corners: &[[i32; 3]], control: &Control) -> Result<Vec<Vec<u32>>> {
    let mut starts: Vec<u32> = edges.iter().map(|&(from, _)| from).collect();
    starts.dedup();
    let place = |corner: u32| starts.partition_point(|&other| other < corner);
    // the unused edges of each corner, and where on the way it is
    let first_edge = |&from: &u32| edges.partition_point(|edge| edge.0 < from);
    let ends: Vec<usize> = starts.iter().skip(1).map(first_edge).chain([edges.len()]).collect();
    let mut next: Vec<usize> = starts.iter().map(first_edge).collect();
    let mut on_way: Vec<Option<usize>> = vec![None; starts.len()];
    let (mut found, mut paced) = (Vec::new(), Paced::new(control, OF_STEP));
    for first in 0..starts.len() {
        let mut way: Vec<usize> = vec![first];
        on_way[first] = Some(0);
        while let Some(&at) = way.last() {
            paced.done(1 + (ends[at] - next[at]).min(MAX_LEAVING)).await?;
            if next[at] == ends[at] {
                // all edges of the first corner are used, and the way is back at it
                on_way[at] = None;
                way.pop();
                continue;
            }
            let recent = way.iter().rev().skip(1).take(RECENT).map(|&at| starts[at]);
            let spread = |to: u32| recent.clone().map(|other| distance(corners, to, other)).sum::<i128>();
            let leaving = next[at]..ends[at].min(next[at] + MAX_LEAVING);
            let best = if leaving.len() > 1 { leaving.min_by_key(|&edge| spread(edges[edge].1)) } else { None };
            edges.swap(next[at], best.unwrap_or(next[at]));
            let to = place(edges[next[at]].1);
            next[at] += 1;
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
    Ok(found)
}

/// The square of the distance of two corners, in units of the snap.
fn distance(corners: &[[i32; 3]], one: u32, other: u32) -> i128 {
    let [one, other] = [one, other].map(|at| corners[at as usize].map(i128::from));
    (0..3).map(|axis| (one[axis] - other[axis]).pow(2)).sum()
}
