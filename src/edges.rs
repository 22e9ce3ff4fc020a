//! Edges: how the facets of a surface use them, and which are not shared by two facets that agree.
//!
//! Facets -> the uses of their edges, sorted. Corners are one vertex where they are equal, by a key of theirs. A facet with two equal
//! corners is collapsed: it has no edges. An edge is an unordered pair of vertices; a facet uses each of its three edges once, in one of
//! two directions. With f uses one way and b the other: open is f + b = 1, non-manifold f + b > 2, flipped f + b = 2 without f = b = 1.
//! All others are proper.
//!
//! Numbers the vertices by a sort of the corners, then sorts the edges: O(n log n) time, no hashing, so that the result is the same on
//! every machine and for every order of the facets. Holds at most 72 bytes a facet beside the input.

use serde::{Deserialize, Serialize};

use crate::parallel::*;

/// What is not proper of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum BadEdge {
    /// One facet has it.
    Open,
    /// Two facets have it and use it in the same direction: one of them is inside-out.
    Flipped,
    /// More than two facets have it.
    Nonmanifold,
}

/// One use of an edge, as it sorts: low vertex (34 bits), high vertex (34 bits), facet (32 bits), direction (1 bit).
#[derive(Clone, Copy)]
pub(crate) struct Use(u128);

impl Use {
    /// Sorts after every use; for the edges that collapsed facets do not have.
    const NONE: u128 = u128::MAX;

    fn bits(from: u64, to: u64, facet: usize) -> u128 {
        let (low, high) = (from.min(to), from.max(to));
        u128::from(low) << 67 | u128::from(high) << 33 | (facet as u128) << 1 | u128::from(from > to)
    }

    /// Its vertices, the lower first.
    pub(crate) fn pair(self) -> (u64, u64) {
        (((self.0 >> 67) as u64), ((self.0 >> 33) as u64) & ((1 << 34) - 1))
    }

    pub(crate) fn facet(self) -> u32 {
        (self.0 >> 1) as u32
    }

    fn is_backward(self) -> bool {
        self.0 & 1 == 1
    }
}

/// The uses of all edges.
pub(crate) struct Edges {
    uses: Vec<Use>,
    /// Number of facets with two or three equal corners.
    pub(crate) n_collapsed: u64,
}

impl Edges {
    /// Sorts the edges of facets with the given vertices. Facets carry a 32-bit index, so that there may be at most 2^32 of them.
    pub(crate) fn new(vertices: &[[u64; 3]]) -> Edges {
        let mut uses = vec![Use::NONE; 3 * vertices.len()];
        uses.par_chunks_mut(3).zip(vertices).enumerate().for_each(|(facet, (uses, &[a, b, c]))| {
            if a != b && b != c && c != a {
                uses.copy_from_slice(&[Use::bits(a, b, facet), Use::bits(b, c, facet), Use::bits(c, a, facet)]);
            }
        });
        uses.par_sort_unstable();
        let n_uses = uses.partition_point(|entry| *entry != Use::NONE);
        let n_collapsed = ((uses.len() - n_uses) / 3) as u64;
        uses.truncate(n_uses);
        Edges { uses: uses.into_iter().map(Use).collect(), n_collapsed }
    }

    /// The uses of each edge, in the order of its vertices.
    pub(crate) fn each(&self) -> impl Iterator<Item = &[Use]> {
        self.uses.chunk_by(|one, next| one.pair() == next.pair())
    }
}

/// Number of uses of an edge in the direction of its vertices, and against it.
pub(crate) fn directions(uses: &[Use]) -> [usize; 2] {
    let n_backward = uses.iter().filter(|entry| entry.is_backward()).count();
    [uses.len() - n_backward, n_backward]
}

/// What is not proper of an edge with these uses, if anything.
pub(crate) fn bad_edge(uses: &[Use]) -> Option<BadEdge> {
    match uses.len() {
        1 => Some(BadEdge::Open),
        2 => (directions(uses) != [1, 1]).then_some(BadEdge::Flipped),
        _ => Some(BadEdge::Nonmanifold),
    }
}

/// Numbers the distinct vertices of facets in the order of the keys of their corners, of 96 bits: three numbers a facet.
pub(crate) fn number_vertices<C: Copy + Sync>(facets: &[[C; 3]], key: impl Fn(C) -> u128 + Sync) -> Vec<[u64; 3]> {
    let mut corners = vec![0u128; 3 * facets.len()];
    corners.par_chunks_mut(3).zip(facets).enumerate().for_each(|(index, (entries, facet))| {
        for (entry, corner) in entries.iter_mut().zip(facet) {
            *entry = key(*corner) << 32 | index as u128;
        }
    });
    corners.par_sort_unstable();
    let mut vertices = vec![[0u64; 3]; facets.len()];
    for (vertex, same) in corners.chunk_by(|one, next| one >> 32 == next >> 32).enumerate() {
        let of_vertex = same[0] >> 32;
        for entry in same {
            let index = *entry as u32 as usize;
            for (number, corner) in vertices[index].iter_mut().zip(facets[index]) {
                if key(corner) == of_vertex {
                    *number = vertex as u64;
                }
            }
        }
    }
    vertices
}

/// Things joined in groups: a forest in which each tree is a group (union by index, path halving).
pub(crate) struct Groups {
    parent: Vec<u32>,
    /// Number of joins that made two groups one.
    pub(crate) n_joined: u64,
}

impl Groups {
    /// So many things, each alone.
    pub(crate) fn new(n: usize) -> Groups {
        Groups { parent: (0..n).map(|thing| thing as u32).collect(), n_joined: 0 }
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

    /// Makes the groups of two things one.
    pub(crate) fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.root(one), self.root(other));
        if one != other {
            self.parent[one.max(other) as usize] = one.min(other);
            self.n_joined += 1;
        }
    }
}
