//! Edges: how the facets of a surface use them, and which are not shared by two facets that agree.
//!
//! Facets -> the uses of their edges, edge by edge. Corners are one vertex where they are equal, by a key of theirs. A facet with two
//! equal corners is collapsed: it has no edges. An edge is an unordered pair of vertices; a facet uses each of its three edges once, in
//! one of two directions. With f uses one way and b the other: open is f + b = 1, non-manifold f + b > 2, flipped f + b = 2 without
//! f = b = 1. All others are proper.
//!
//! Numbers the vertices in the order in which they come, by a table of corners, then sorts the edges of some vertices at a time. So
//! the order of the edges depends on that of the facets, and what is found of them must not. Takes O(n log n) time in pieces, after any
//! of which the caller may stop; holds at most 36 bytes a facet beside the input in wasm, where a number of a vertex has 4 bytes, and
//! twice that elsewhere.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::base::error::Result;
use crate::base::memory::Held;
use crate::base::parallel::*;

/// What is not proper of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum BadEdge {
    /// One facet has it.
    Open,
    /// Two facets have it and use it in the same direction: one of them is inside-out.
    Flipped,
    /// More than two facets have it.
    Nonmanifold,
}

/// One use of an edge: by the numbers of its vertices, then by the facet and the direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Use {
    low: usize,
    high: usize,
    facet_and_direction: usize,
}

impl Use {
    pub(crate) fn new(from: usize, to: usize, facet: usize) -> Use {
        Use { low: from.min(to), high: from.max(to), facet_and_direction: facet << 1 | usize::from(from > to) }
    }

    /// Its vertices, the lower first.
    pub(crate) fn pair(self) -> [usize; 2] {
        [self.low, self.high]
    }

    pub(crate) fn facet(self) -> usize {
        self.facet_and_direction >> 1
    }

    fn is_backward(self) -> bool {
        self.facet_and_direction & 1 == 1
    }
}

/// A place of the table that is free.
const FREE: usize = usize::MAX;
/// Uses that are sorted at a time, about.
const USES_AT_ONCE: usize = 1 << 21;
/// Facets that are numbered before the limit of memory is looked at.
const NUMBERED_AT_ONCE: usize = 1 << 16;
/// What errors of memory call them.
pub(crate) const EDGES: &str = "the edges of a surface that is not closed";

/// The vertices of facets, by number.
pub(crate) struct Vertices {
    of_facets: Vec<[usize; 3]>,
    /// Number of vertices.
    n: usize,
    /// The first corner of each vertex, as 3 times its facet and its place there, where its hash says or in the next place that is free.
    table: Vec<usize>,
    /// Of each block of vertices the facets from the first that has one of them to the last.
    of_blocks: Vec<Range<usize>>,
}

/// Vertices of a block, of which only the facets around them are asked for their edges.
const BLOCK: usize = 1 << 14;

impl Vertices {
    /// None yet, of so many facets.
    pub(crate) fn new(n_facets: usize) -> Vertices {
        let table = vec![FREE; first_places(n_facets)];
        Vertices { of_facets: Vec::with_capacity(n_facets), n: 0, table, of_blocks: Vec::new() }
    }

    /// Bytes that it takes before a corner has its number.
    pub(crate) fn bytes_at_first(n_facets: usize) -> u64 {
        (size_of::<[usize; 3]>() * n_facets + size_of::<usize>() * first_places(n_facets)) as u64
    }

    /// The same within a limit of memory, which `held` has of it.
    ///
    /// # Errors
    /// `memory`.
    pub(crate) fn within(n_facets: usize, key: &dyn Fn(usize, usize) -> [u32; 3], held: &mut Held) -> Result<Vertices> {
        held.set(Vertices::bytes_at_first(n_facets), EDGES)?;
        let mut vertices = Vertices::new(n_facets);
        while vertices.n_facets() < n_facets {
            let n_left = n_facets - vertices.n_facets();
            let n_more = NUMBERED_AT_ONCE.min(n_left);
            let unwritten = (size_of::<[usize; 3]>() * n_left) as u64;
            held.set_unwritten(vertices.most_bytes(n_more), unwritten, EDGES)?;
            vertices.number(vertices.n_facets() + n_more, key);
        }
        vertices.finish();
        held.set(vertices.most_bytes(0), EDGES)?;
        Ok(vertices)
    }

    /// The vertices of so many facets; `key` has the key of a corner of a facet.
    pub(crate) fn of(n_facets: usize, key: &dyn Fn(usize, usize) -> [u32; 3]) -> Vertices {
        let mut vertices = Vertices::new(n_facets);
        vertices.number(n_facets, key);
        vertices.finish();
        vertices
    }

    /// Most bytes that it takes while so many more facets are numbered.
    pub(crate) fn most_bytes(&self, n_more: usize) -> u64 {
        let (mut table, mut most) = (self.table.len(), self.table.len());
        while n_more > 0 && 4 * (self.n + 3 * n_more) > 3 * table {
            // the old one is there until all is in the new one
            most = 3 * table;
            table *= 2;
        }
        (size_of::<[usize; 3]>() * self.of_facets.capacity() + size_of::<usize>() * most) as u64
    }

    /// Bytes of the uses that are sorted at a time, in a list that grows.
    pub(crate) fn bytes_of_uses(&self) -> u64 {
        (2 * size_of::<Use>() * USES_AT_ONCE.min(3 * self.n_facets())) as u64
    }

    /// Number of facets that have their vertices.
    pub(crate) fn n_facets(&self) -> usize {
        self.of_facets.len()
    }

    /// Numbers the corners of the next facets, up to `end`. The function is a pointer: code for each kind of corner would be large.
    pub(crate) fn number(&mut self, end: usize, key: &dyn Fn(usize, usize) -> [u32; 3]) {
        for facet in self.n_facets()..end {
            let mut numbers = [0; 3];
            self.of_facets.push(numbers);
            for corner in 0..3 {
                if 4 * self.n > 3 * self.table.len() {
                    self.grow(key);
                }
                numbers[corner] = self.number_of(facet, corner, key);
                self.of_facets[facet] = numbers;
                // numbers come in order
                match self.of_blocks.get_mut(numbers[corner] / BLOCK) {
                    Some(block) => block.end = facet + 1,
                    None => self.of_blocks.push(facet..facet + 1),
                }
            }
        }
    }

    fn number_of(&mut self, facet: usize, corner: usize, key: &dyn Fn(usize, usize) -> [u32; 3]) -> usize {
        let wanted = key(facet, corner);
        let mut place = self.place(wanted);
        loop {
            let first = self.table[place];
            if first == FREE {
                self.table[place] = 3 * facet + corner;
                self.n += 1;
                return self.n - 1;
            }
            if key(first / 3, first % 3) == wanted {
                return self.of_facets[first / 3][first % 3];
            }
            place = (place + 1) & (self.table.len() - 1);
        }
    }

    fn place(&self, key: [u32; 3]) -> usize {
        vertex_hash(key) as usize & (self.table.len() - 1)
    }

    fn grow(&mut self, key: &dyn Fn(usize, usize) -> [u32; 3]) {
        let table = vec![FREE; 2 * self.table.len()];
        for first in std::mem::replace(&mut self.table, table).into_iter().filter(|first| *first != FREE) {
            let mut place = self.place(key(first / 3, first % 3));
            while self.table[place] != FREE {
                place = (place + 1) & (self.table.len() - 1);
            }
            self.table[place] = first;
        }
    }

    /// Frees what is needed for more facets only.
    pub(crate) fn finish(&mut self) {
        self.table = Vec::new();
    }

    /// Numbers of the vertices of a facet, from 0 in the order in which they come.
    pub(crate) fn of_facet(&self, facet: usize) -> [usize; 3] {
        self.of_facets[facet]
    }

    /// Which of the corners of a facet is a vertex of its.
    pub(crate) fn corner(&self, facet: usize, vertex: usize) -> usize {
        self.of_facets[facet].iter().position(|number| *number == vertex).unwrap_or(0)
    }

    /// Ranges of vertices whose edges have about so many uses that they are sorted at a time.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let (n, n_uses) = (self.n, 3 * self.n_facets());
        let n_ranges = n_uses.div_ceil(USES_AT_ONCE).max(1);
        let size = n.div_ceil(n_ranges).max(1);
        (0..n).step_by(size).map(move |first| first..n.min(first + size))
    }

    /// The uses of the edges whose lower vertex is within a range, edge by edge.
    pub(crate) fn uses(&self, lower: Range<usize>) -> Vec<Use> {
        let mut uses = Vec::new();
        let blocks = &self.of_blocks[lower.start / BLOCK..lower.end.div_ceil(BLOCK)];
        let first = blocks.first().map_or(0, |block| block.start);
        let end = blocks.iter().map(|block| block.end).max().unwrap_or(0);
        let facets = (first..end).zip(&self.of_facets[first..end]);
        for (facet, &[a, b, c]) in facets.filter(|(_, facet)| !is_collapsed(facet)) {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                if lower.contains(&from.min(to)) {
                    uses.push(Use::new(from, to, facet));
                }
            }
        }
        uses.par_sort_unstable();
        uses
    }
}

fn is_collapsed(&[a, b, c]: &[usize; 3]) -> bool {
    a == b || b == c || c == a
}

/// The uses of each edge.
pub(crate) fn each(uses: &[Use]) -> impl Iterator<Item = &[Use]> {
    uses.chunk_by(|one, next| one.pair() == next.pair())
}

/// Places of a table of the vertices of so many facets at first: a closed surface has half as many.
pub(crate) fn first_places(n_facets: usize) -> usize {
    (n_facets / 3 * 2 + 16).next_power_of_two()
}

/// The bits of a corner's coordinates in a file; equal exactly where the coordinates are.
#[inline(always)]
pub fn corner_key([x, y, z]: [f32; 3]) -> [u32; 3] {
    // adding +0 turns -0 into +0 and leaves all else
    [(x + 0.0).to_bits(), (y + 0.0).to_bits(), (z + 0.0).to_bits()]
}

/// A hash of a vertex with this key.
#[inline(always)]
pub(crate) fn vertex_hash([x, y, z]: [u32; 3]) -> u64 {
    mixed((u64::from(x) << 32 | u64::from(y)) ^ u64::from(z).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Both words of a product, the lower first: together they depend on all bits of the factors, as in wyhash (Wang Yi 2019).
#[inline(always)]
pub fn product(one: u64, other: u64) -> [u64; 2] {
    let product = u128::from(one) * u128::from(other);
    [product as u64, (product >> 64) as u64]
}

/// A bijection of 64 bits in which every bit depends on all: the finalizer of SplitMix64 (Steele, Lea and Flood 2014).
#[inline(always)]
pub fn mixed(word: u64) -> u64 {
    let word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let word = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ word >> 31
}

/// Number of uses of an edge in the direction of its vertices, and against it.
pub(crate) fn directions(uses: &[Use]) -> [usize; 2] {
    let n_backward = uses.iter().filter(|entry| entry.is_backward()).count();
    [uses.len() - n_backward, n_backward]
}

/// What is not proper of an edge with so many uses in either direction, if anything.
pub(crate) fn bad_edge(directions: [usize; 2]) -> Option<BadEdge> {
    match directions {
        [1, 0] | [0, 1] => Some(BadEdge::Open),
        [1, 1] => None,
        [2, 0] | [0, 2] => Some(BadEdge::Flipped),
        _ => Some(BadEdge::Nonmanifold),
    }
}

/// Things joined in groups: a forest in which each tree is a group (union by index, path halving).
pub struct Groups {
    parent: Vec<u32>,
    /// Number of joins that made two groups one.
    pub(crate) n_joined: u64,
}

impl Groups {
    /// So many things, each alone.
    pub fn new(n: usize) -> Groups {
        Groups { parent: (0..n).map(|thing| thing as u32).collect(), n_joined: 0 }
    }

    /// Makes room for so many more things.
    pub(crate) fn reserve(&mut self, n_more: usize) {
        self.parent.reserve_exact(n_more);
    }

    /// Adds a thing behind these, alone.
    pub fn add(&mut self) {
        self.parent.push(self.parent.len() as u32);
    }

    /// Adds things behind these, in their groups.
    pub(crate) fn append(&mut self, other: Groups) {
        let n = self.parent.len() as u32;
        self.parent.extend(other.parent.iter().map(|above| n + above));
        self.n_joined += other.n_joined;
    }

    /// The first thing of the group of a thing.
    pub(crate) fn root(&mut self, mut thing: u32) -> u32 {
        while self.parent[thing as usize] != thing {
            let above = self.parent[self.parent[thing as usize] as usize];
            self.parent[thing as usize] = above;
            thing = above;
        }
        thing
    }

    /// Numbers the groups in the order of their first things: the number of each thing, and the first thing of each group.
    pub fn numbers(&mut self) -> (Vec<u32>, Vec<u32>) {
        let (mut numbers, mut firsts): (Vec<u32>, Vec<u32>) = (Vec::with_capacity(self.parent.len()), Vec::new());
        for thing in 0..self.parent.len() as u32 {
            let root = self.root(thing);
            numbers.push(if root == thing { firsts.len() as u32 } else { numbers[root as usize] });
            if root == thing {
                firsts.push(thing);
            }
        }
        (numbers, firsts)
    }

    /// Makes the groups of two things one.
    pub fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.root(one), self.root(other));
        if one != other {
            self.parent[one.max(other) as usize] = one.min(other);
            self.n_joined += 1;
        }
    }
}
