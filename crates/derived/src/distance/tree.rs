//! Boxes around facets, and around boxes: finds the nearest facet, and all within a distance.
//!
//! Facets -> [`Tree`]. Each box is halved across its longest side, at the median of the facets' middles. Cost: 176 bytes a facet, and up to 64 for boxes of several.

use std::ops::Range;

use super::facet::{Corners, Facet};
use hexcast_core::base::parallel::*;

/// Most facets of a box that is not halved.
const MAX_OF_LEAF: usize = 4;

/// Bounds are larger than what they bound by this part, so that rounding leaves nothing out.
pub(super) const ROUNDING: f64 = 1e-9;

/// Facets in boxes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tree {
    facets: Vec<Facet>,
    /// Of each facet.
    bounds: Vec<Bounds>,
    nodes: Vec<Node>,
}

/// A box, before all boxes in it.
#[derive(Debug, Clone, PartialEq)]
struct Node {
    bounds: Bounds,
    /// The first of its facets.
    first: u32,
    /// Facets of one that is not halved; else 0.
    n: u32,
    /// The second half; the first is the next.
    second: u32,
}

impl Node {
    fn facets(&self) -> Range<usize> {
        self.first as usize..(self.first + self.n) as usize
    }
}

/// Least and greatest coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl Bounds {
    pub(super) fn of(corners: &[[f64; 3]]) -> Bounds {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in corners {
            for axis in 0..3 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
            }
        }
        Bounds { low, high }
    }

    /// Larger on both sides of each axis.
    pub(super) fn widened(self, by: [f64; 3]) -> Bounds {
        let moved = |end: [f64; 3], sign: f64| [0, 1, 2].map(|axis| end[axis] + sign * by[axis]);
        Bounds { low: moved(self.low, -1.0), high: moved(self.high, 1.0) }
    }

    /// Ends along an axis.
    pub(super) fn along(&self, axis: usize) -> [f64; 2] {
        [self.low[axis], self.high[axis]]
    }

    fn touches(&self, other: &Bounds) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    /// The square of the least distance of what is within.
    #[inline]
    pub(super) fn square(&self, point: &[f64; 3]) -> f64 {
        let outside = |axis: usize| (self.low[axis] - point[axis]).max(point[axis] - self.high[axis]).max(0.0);
        let [x, y, z] = [0, 1, 2].map(outside);
        x * x + y * y + z * z
    }
}

/// Memory that is used again.
#[derive(Default)]
pub(super) struct Stack(Vec<(f64, u32)>);

impl Tree {
    /// Bytes that the tree of so many facets takes, while it is made.
    pub(super) fn n_bytes(n_facets: u64) -> u64 {
        n_facets * (size_of::<Corners>() + size_of::<Facet>() + size_of::<Bounds>() + size_of::<Node>()) as u64
    }

    /// Puts facets into boxes.
    pub(super) fn new(mut facets: Vec<Corners>) -> Tree {
        let mut nodes = Vec::with_capacity(facets.len());
        if !facets.is_empty() {
            halve(&mut facets, 0, &mut nodes);
        }
        nodes.shrink_to_fit();
        let bounds = facets.par_iter().map(|corners| Bounds::of(corners)).collect();
        let facets = facets.par_iter().map(Facet::new).collect();
        Tree { facets, bounds, nodes }
    }

    pub(super) fn facets(&self) -> &[Facet] {
        &self.facets
    }

    #[inline]
    pub(super) fn facet(&self, index: usize) -> &Facet {
        &self.facets[index]
    }

    /// Hands over the facets whose bounds touch others.
    pub(super) fn touching(&self, bounds: &Bounds, mut found: impl FnMut(usize)) {
        let mut left: Vec<u32> = self.nodes.first().map(|_| 0).into_iter().collect();
        while let Some(at) = left.pop() {
            let node = &self.nodes[at as usize];
            if !node.bounds.touches(bounds) {
                continue;
            }
            node.facets().filter(|facet| self.bounds[*facet].touches(bounds)).for_each(&mut found);
            if node.n == 0 {
                left.extend([node.second, at + 1]);
            }
        }
    }

    pub(super) fn n_facets(&self) -> u64 {
        self.facets.len() as u64
    }

    /// The nearest facet and the square of its distance, where that is less than a limit.
    pub(super) fn nearest(&self, point: &[f64; 3], limit: f64, Stack(stack): &mut Stack) -> Option<(f64, &Facet)> {
        let (mut least, mut nearest) = (limit, None);
        stack.clear();
        stack.extend(self.nodes.first().map(|node| (node.bounds.square(point), 0)));
        while let Some((square, at)) = stack.pop() {
            // facets in a box may be as near as it is, by rounding a bit nearer
            if square * (1.0 - ROUNDING) >= least {
                continue;
            }
            let node = &self.nodes[at as usize];
            for at in node.facets() {
                if self.bounds[at].square(point) * (1.0 - ROUNDING) < least {
                    let of_facet = self.facets[at].square(point);
                    if of_facet < least {
                        (least, nearest) = (of_facet, Some(&self.facets[at]));
                    }
                }
            }
            if node.n == 0 {
                let [one, other] = [at + 1, node.second].map(|at| (self.nodes[at as usize].bounds.square(point), at));
                // the nearer is looked at first
                stack.extend(if one.0 <= other.0 { [other, one] } else { [one, other] });
            }
        }
        nearest.map(|facet| (least, facet))
    }

    /// Hands over the facets that may be as near as the root of a square, until one is refused; returns whether none was.
    pub(super) fn within<'a>(
        &'a self,
        point: &[f64; 3],
        square: f64,
        Stack(stack): &mut Stack,
        mut found: impl FnMut(&'a Facet, &'a Bounds) -> bool,
    ) -> bool {
        stack.clear();
        stack.extend(self.nodes.first().map(|node| (node.bounds.square(point), 0)));
        while let Some((least, at)) = stack.pop() {
            if least > square {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.n > 0 {
                let mut near = node.facets().filter(|at| self.bounds[*at].square(point) <= square);
                if !near.all(|at| found(&self.facets[at], &self.bounds[at])) {
                    return false;
                }
                continue;
            }
            stack.extend([at + 1, node.second].map(|at| (self.nodes[at as usize].bounds.square(point), at)));
        }
        true
    }
}

/// Puts some facets into a box, in an order of their own; `first` is the number of the first of them.
fn halve(facets: &mut [Corners], first: usize, nodes: &mut Vec<Node>) {
    let bounds = Bounds::of(facets.as_flattened());
    let (at, n) = (nodes.len(), facets.len());
    let n_of_leaf = if n <= MAX_OF_LEAF { n as u32 } else { 0 };
    nodes.push(Node { bounds, first: first as u32, n: n_of_leaf, second: 0 });
    if n_of_leaf > 0 {
        return;
    }
    let side = |axis: usize| bounds.high[axis] - bounds.low[axis];
    let longest = (1..3).fold(0, |longest, axis| if side(axis) > side(longest) { axis } else { longest });
    let middle = |[a, b, c]: &Corners| a[longest] + b[longest] + c[longest];
    facets.select_nth_unstable_by(n / 2, |one, other| middle(one).total_cmp(&middle(other)));
    let (front, back) = facets.split_at_mut(n / 2);
    halve(front, first, nodes);
    nodes[at].second = nodes.len() as u32;
    halve(back, first + n / 2, nodes);
}
