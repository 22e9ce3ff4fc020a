//! Chunk: facets that follow each other in the list of a surface, with vertices of their own.
//!
//! Facets that are near in the list are mostly near in space, so that a chunk has all facets around most of its vertices. Its table of
//! corners, and the edges of its facets, nearly fit the cache of a core. Only the vertices that other chunks have, too, are compared with these
//! ([`super::shared`]); an edge is used by this chunk alone unless both its ends are such vertices.
//!
//! Cost: 8 bytes a facet and 12 a vertex, later 8; and lists of at most 4 MB for each core.

use std::ops::Range;

use super::tally::Tally;
use crate::base::sort::sort;
use crate::input::edges::{Groups, Use, corner_key, first_places, vertex_hash};
use crate::input::geometry::Facet;

/// Facets of a chunk, unless it is the last.
pub(super) const FACETS: usize = 1 << 15;
/// Parts that vertices are put in by their hashes, so that those of one part fit the cache for all chunks.
pub(super) const PARTS: usize = 1024;
/// In place of the number of a vertex that no other chunk has.
pub(super) const OWN: usize = usize::MAX;
/// A place of the table that is free.
const FREE: u32 = u32::MAX;
/// Bits of a vertex of a chunk; three fit a word.
const VERTEX_BITS: u32 = (3 * FACETS).next_power_of_two().trailing_zeros();

/// The vertices of a facet, as indices in those of the chunk.
#[derive(Clone, Copy)]
struct Packed(u64);

impl Packed {
    fn new([a, b, c]: [u32; 3]) -> Packed {
        Packed(u64::from(a) | u64::from(b) << VERTEX_BITS | u64::from(c) << (2 * VERTEX_BITS))
    }

    /// None where two are equal: the facet is collapsed, and has no edges.
    fn unless_collapsed(self) -> Option<[usize; 3]> {
        let [a, b, c] = self.vertices();
        (a != b && b != c && c != a).then_some([a, b, c])
    }

    fn vertices(self) -> [usize; 3] {
        let vertex = |corner: u32| (self.0 >> (corner * VERTEX_BITS)) as usize & ((1 << VERTEX_BITS) - 1);
        [vertex(0), vertex(1), vertex(2)]
    }
}

/// A vertex: the key of its corners until it is compared with those of other chunks, then its number among those of its part that are
/// shared. The number takes the place of the key, so that no second list is held.
#[derive(Clone, Copy)]
pub(super) struct Vertex([u32; 3]);

impl Vertex {
    /// The key, before the comparison.
    pub(super) fn key(self) -> [u32; 3] {
        self.0
    }

    /// Puts the number or [`OWN`] in the place of the key.
    pub(super) fn set_number(&mut self, number: usize) {
        let word = number as u64;
        self.0 = [word as u32, (word >> 32) as u32, u32::from(number != OWN)];
    }

    fn number(self) -> Option<usize> {
        let [low, high, is_shared] = self.0;
        (is_shared == 1).then_some((u64::from(high) << 32 | u64::from(low)) as usize)
    }
}

/// Facets and their vertices.
pub(super) struct Chunk {
    facets: Vec<Packed>,
    /// Part by part, until all have numbers.
    vertices: Vec<Vertex>,
    /// Where each part begins, and the end.
    starts: Vec<u32>,
    /// Of each vertex, among all that several chunks have, or [`OWN`].
    numbers: Vec<usize>,
    /// Uses of edges whose ends both have numbers, once it is known.
    n_shared_uses: usize,
}

/// What a chunk says of its edges.
pub(super) struct OwnEdges {
    pub(super) tally: Tally,
    /// Its facets, those joined that share an edge.
    pub(super) groups: Groups,
    pub(super) n_collapsed: u64,
}

/// Lists that are used for one chunk after the other: to touch new memory for the first time takes as long as what is done in it.
#[derive(Default)]
pub(super) struct Scratch {
    table: Vec<u32>,
    keys: Vec<[u32; 3]>,
    places: Vec<u32>,
    uses: Vec<OwnUse>,
}

impl Scratch {
    /// Most bytes that it takes for chunks of so many facets.
    pub(super) fn most_bytes(n_facets: usize) -> u64 {
        // the old table is there, too, while a longer one is made
        let tables = first_places(n_facets).max((4 * n_facets).next_power_of_two() / 2 * 3);
        let of_facet = 3 * (size_of::<[u32; 3]>() + size_of::<u32>() + size_of::<OwnUse>());
        (size_of::<u32>() * (tables + PARTS + 1) + of_facet * n_facets) as u64
    }
}

/// Makes a list of so many equal items, with no room for more.
fn set_length<T: Clone>(list: &mut Vec<T>, n: usize, item: T) {
    list.clear();
    list.reserve_exact(n);
    list.resize(n, item);
}

impl Chunk {
    /// Finds the vertices of at most [`FACETS`] facets.
    pub(super) fn new(facets: &[Facet], scratch: &mut Scratch) -> Chunk {
        let Scratch { table, keys, places, .. } = scratch;
        let facets = with_vertices(facets, table, keys);
        // a counting sort by parts
        let mut starts = vec![0; PARTS + 1];
        for &key in &*keys {
            starts[part(key) + 1] += 1;
        }
        for part in 0..PARTS {
            starts[part + 1] += starts[part];
        }
        places.clone_from(&starts);
        let mut vertices = vec![Vertex([0; 3]); keys.len()];
        for &key in &*keys {
            let place = &mut places[part(key)];
            vertices[*place as usize] = Vertex(key);
            *place += 1;
        }
        Chunk { facets, vertices, starts, numbers: Vec::new(), n_shared_uses: 0 }
    }

    /// Most bytes that one of so many facets takes.
    pub(super) fn most_bytes(n_facets: usize) -> u64 {
        let of_facet = size_of::<Packed>() + 3 * size_of::<Vertex>();
        (size_of::<u32>() * (PARTS + 1) + of_facet * n_facets) as u64
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> u64 {
        let lists = size_of_val(&self.facets[..]) + size_of_val(&self.vertices[..]) + size_of_val(&self.numbers[..]);
        (lists + size_of_val(&self.starts[..])) as u64
    }

    pub(super) fn n_vertices(&self) -> usize {
        self.vertices.len()
    }

    /// Number of vertices of a part.
    pub(super) fn n_of_part(&self, part: usize) -> usize {
        (self.starts[part + 1] - self.starts[part]) as usize
    }

    /// The vertices of each of some parts.
    pub(super) fn of_parts(&mut self, parts: Range<usize>) -> impl Iterator<Item = &mut [Vertex]> {
        let starts = &self.starts[parts.start..=parts.end];
        let mut rest = &mut self.vertices[starts[0] as usize..];
        starts.windows(2).map(move |ends| rest.split_off_mut(..(ends[1] - ends[0]) as usize).unwrap_or_default())
    }

    /// Numbers its vertices among all shared ones, given the first number of each part, or none where it is the only chunk. `facets` are
    /// those that it was made of.
    pub(super) fn number(&mut self, facets: &[Facet], first_numbers: Option<&[usize]>) {
        let vertices = std::mem::take(&mut self.vertices);
        let mut next = std::mem::take(&mut self.starts);
        let Some(first_numbers) = first_numbers else {
            self.numbers = vec![OWN; vertices.len()];
            return;
        };
        self.numbers.reserve_exact(vertices.len());
        for (packed, facet) in self.facets.iter().zip(facets) {
            for (vertex, corner) in packed.vertices().into_iter().zip(facet) {
                // it comes for the first time, in the order in which the parts were filled
                if vertex == self.numbers.len() {
                    let part = part(corner_key(*corner));
                    let number = vertices[next[part] as usize].number();
                    next[part] += 1;
                    self.numbers.push(number.map_or(OWN, |number| first_numbers[part] + number));
                }
            }
        }
    }

    /// Looks at the edges that no other chunk uses. Its vertices have their numbers, and `facets` are those that it was made of.
    pub(super) fn own_edges(&mut self, facets: &[Facet], scratch: &mut Scratch) -> OwnEdges {
        let mut found = OwnEdges { tally: Tally::new(), groups: Groups::new(facets.len()), n_collapsed: 0 };
        let Scratch { places: ends, uses, .. } = scratch;
        found.n_collapsed = self.sort_own_uses(uses, ends);
        let mut start = 0;
        for (low, &end) in ends.iter().enumerate() {
            let around = &mut uses[start as usize..end as usize];
            start = end;
            sort(around);
            for uses in around.chunk_by(|one, next| one.high() == next.high()) {
                let n_backward = uses.iter().filter(|entry| entry.is_backward()).count();
                found.tally.count([uses.len() - n_backward, n_backward]);
                for two in uses.windows(2) {
                    found.groups.join(two[0].facet() as u32, two[1].facet() as u32);
                }
                if let [open] = uses {
                    let corners = self.facets[open.facet()].vertices();
                    let corner = |vertex| corners.iter().position(|corner| *corner == vertex).unwrap_or(0);
                    let ends = [low, open.high()].map(|vertex| facets[open.facet()][corner(vertex)]);
                    found.tally.list(ends);
                }
            }
        }
        found
    }

    /// The uses of those edges by their lower vertices, a counting sort, and where the uses of each vertex end; returns how many facets are
    /// collapsed.
    fn sort_own_uses(&mut self, uses: &mut Vec<OwnUse>, places: &mut Vec<u32>) -> u64 {
        let mut n_collapsed = 0;
        // where the uses of each vertex begin; when all are there, where they end
        set_length(places, self.numbers.len() + 1, 0);
        for facet in &self.facets {
            let Some(corners) = facet.unless_collapsed() else {
                n_collapsed += 1;
                continue;
            };
            for (from, to) in edges(corners) {
                if self.is_shared(from, to) {
                    self.n_shared_uses += 1;
                } else {
                    places[from.min(to) + 1] += 1;
                }
            }
        }
        for vertex in 0..self.numbers.len() {
            places[vertex + 1] += places[vertex];
        }
        let n_uses = places.pop().unwrap_or(0);
        set_length(uses, n_uses as usize, OwnUse(0));
        for (facet, corners) in self.facets.iter().enumerate() {
            for (from, to) in corners.unless_collapsed().into_iter().flat_map(edges) {
                if !self.is_shared(from, to) {
                    let place = &mut places[from.min(to)];
                    uses[*place as usize] = OwnUse::new(from, to, facet);
                    *place += 1;
                }
            }
        }
        n_collapsed
    }

    /// Most bytes that numbers and groups of so many facets take.
    pub(super) fn most_bytes_of_own_edges(n_facets: usize) -> u64 {
        ((3 * size_of::<usize>() + size_of::<u32>()) * n_facets) as u64
    }

    fn is_shared(&self, one: usize, other: usize) -> bool {
        self.numbers[one] != OWN && self.numbers[other] != OWN
    }

    pub(super) fn n_shared_uses(&self) -> usize {
        self.n_shared_uses
    }

    /// The uses of edges that other chunks may use, by the numbers of their vertices, of those that `is_wanted`. Its first facet has the given
    /// index in the surface.
    pub(super) fn shared_uses(&self, first_facet: usize, is_wanted: impl Fn(usize, usize) -> bool) -> Vec<Use> {
        let mut uses = Vec::new();
        if self.n_shared_uses == 0 {
            return uses;
        }
        for (facet, packed) in self.facets.iter().enumerate() {
            let Some([a, b, c]) = packed.unless_collapsed() else { continue };
            for (from, to) in edges([self.numbers[a], self.numbers[b], self.numbers[c]]) {
                if from != OWN && to != OWN && is_wanted(from.min(to), from.max(to)) {
                    uses.push(Use::new(from, to, first_facet + facet));
                }
            }
        }
        uses
    }

    /// The corner of a facet that has a vertex with this number.
    pub(super) fn corner(&self, facet: usize, number: usize) -> usize {
        let corners = self.facets[facet].vertices();
        corners.iter().position(|vertex| self.numbers[*vertex] == number).unwrap_or(0)
    }
}

/// A use of an edge within the uses of its lower vertex: by the higher one, the facet and the direction.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct OwnUse(u64);

impl OwnUse {
    fn new(from: usize, to: usize, facet: usize) -> OwnUse {
        OwnUse((from.max(to) as u64) << 32 | (facet as u64) << 1 | u64::from(from > to))
    }

    fn high(self) -> usize {
        (self.0 >> 32) as usize
    }

    fn facet(self) -> usize {
        (self.0 as u32 >> 1) as usize
    }

    fn is_backward(self) -> bool {
        self.0 & 1 == 1
    }
}

#[inline(always)]
fn edges([a, b, c]: [usize; 3]) -> [(usize, usize); 3] {
    [(a, b), (b, c), (c, a)]
}

/// The part of a vertex with this key.
fn part(key: [u32; 3]) -> usize {
    (vertex_hash(key) >> (u64::BITS - PARTS.trailing_zeros())) as usize
}

/// The vertices of facets, and their keys, in the order in which they come.
fn with_vertices(facets: &[Facet], table: &mut Vec<u32>, keys: &mut Vec<[u32; 3]>) -> Vec<Packed> {
    keys.clear();
    keys.reserve_exact(3 * facets.len());
    set_length(table, first_places(facets.len()), FREE);
    let mut vertex_of = |corner: [f32; 3]| {
        if 4 * keys.len() > 3 * table.len() {
            grow(table, keys);
        }
        let key = corner_key(corner);
        let mut place = vertex_hash(key) as usize & (table.len() - 1);
        loop {
            let vertex = table[place];
            if vertex == FREE {
                table[place] = keys.len() as u32;
                keys.push(key);
                return keys.len() as u32 - 1;
            }
            if keys[vertex as usize] == key {
                return vertex;
            }
            place = (place + 1) & (table.len() - 1);
        }
    };
    // written out: a map of an array is a call, which takes twice as long
    facets.iter().map(|[a, b, c]| Packed::new([vertex_of(*a), vertex_of(*b), vertex_of(*c)])).collect()
}

/// Makes a table twice as long.
fn grow(table: &mut Vec<u32>, keys: &[[u32; 3]]) {
    let n = 2 * table.len();
    set_length(table, n, FREE);
    for (vertex, &key) in (0..).zip(keys) {
        let mut place = vertex_hash(key) as usize & (n - 1);
        while table[place] != FREE {
            place = (place + 1) & (n - 1);
        }
        table[place] = vertex;
    }
}
