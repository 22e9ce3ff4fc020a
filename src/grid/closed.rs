//! Closedness of a snapped surface: whether rays alone decide its cells, and where its edges are not proper.
//!
//! Snapped facets -> [`Closed`], in one pass over the facets and one over half of their edges; if some are not proper, also
//! [`BadEdges`].
//!
//! # Theory
//! Each edge has a hash of 128 bits. The sum of the hashes over all uses, signed by their direction, is 0 if every edge is used
//! as often one way as the other. The exclusive or of the hashes is 0 if every edge is used an even number of times. By accident
//! this happens for one other surface in 2^128.
//! If both are 0, every edge is used k times each way, and all edges are proper if no edge comes twice in one direction. To
//! find that out, each edge sets a bit in a table, at a place that its hash gives. An edge whose bit is set already is a
//! suspect. If no other edge has the hash of a suspect, none came twice.
//!
//! Cost: some 35 ns a facet on one core; 20 bytes a facet for a moment.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::base::parallel::*;
use crate::grid::frame::SnappedFacet;
use crate::input::edges::mixed;
use crate::input::job::Rule;

mod bad_edges;

pub use bad_edges::{BadEdges, EdgeGroup, MAX_FACETS};

/// Facets that one core takes at a time.
const CHUNK: usize = 1 << 14;

/// What the edges of a snapped surface say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Closed {
    /// Every edge is used an even number of times.
    pub parity: bool,
    /// Every edge is used as often one way as the other.
    pub nonzero: bool,
    /// Every edge is used exactly once each way.
    pub is_proper: bool,
}

impl Closed {
    /// Checks facets.
    pub fn new(facets: &[SnappedFacet]) -> Closed {
        let mut edges = EdgeHashes::default();
        edges.add(facets);
        loop {
            if let Some(closed) = edges.step() {
                return closed;
            }
        }
    }

    /// Of a surface whose edges are used as often one way as the other.
    fn proper_unless(has_twice: bool) -> Closed {
        Closed { parity: true, nonzero: true, is_proper: !has_twice }
    }

    /// Whether rays decide its cells.
    pub fn by(self, rule: Rule) -> bool {
        match rule {
            Rule::Parity => self.parity,
            Rule::Nonzero => self.nonzero,
        }
    }
}

/// Hashes of the edges of some facets.
struct Hashes {
    odd: [u64; 2],
    surplus: [u64; 2],
    /// Of the edges in the direction of their corners.
    forward: Vec<u64>,
}

impl Hashes {
    fn new(facets: &[SnappedFacet]) -> Hashes {
        let (mut odd, mut surplus) = ([0; 2], [0; 2]);
        let mut forward = Vec::with_capacity(2 * facets.len());
        for facet in facets {
            let [a, b, c] = facet;
            // it is collapsed, and has no edges
            if a == b || b == c || c == a {
                continue;
            }
            let hashes = facet.map(corner_hash);
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let is_forward = facet[from] < facet[to];
                let (low, high) = if is_forward { (from, to) } else { (to, from) };
                let hash =
                    [0, 1].map(|word: usize| mixed(hashes[low][word] ^ mixed(hashes[high][word].rotate_left(23))));
                odd = [0, 1].map(|word: usize| odd[word] ^ hash[word]);
                if is_forward {
                    forward.push(hash[0]);
                    surplus = add(surplus, hash);
                } else {
                    surplus = add(surplus, hash.map(u64::wrapping_neg));
                }
            }
        }
        Hashes { odd, surplus, forward }
    }
}

fn add(one: [u64; 2], other: [u64; 2]) -> [u64; 2] {
    [0, 1].map(|word: usize| one[word].wrapping_add(other[word]))
}

/// The edges of a surface, whose facets come in portions; then they are compared in steps.
#[derive(Default)]
pub(crate) struct EdgeHashes {
    parts: Vec<Hashes>,
    compared: Option<Compared>,
}

impl EdgeHashes {
    /// Adds facets.
    pub(crate) fn add(&mut self, facets: &[SnappedFacet]) {
        self.parts.par_extend(facets.par_chunks(CHUNK).map(Hashes::new));
    }

    /// Does a part of the work that is left once all facets are there; what was found, once all is done.
    pub(crate) fn step(&mut self) -> Option<Closed> {
        if let Some(compared) = &mut self.compared {
            return compared.step(&self.parts).map(Closed::proper_unless);
        }
        let (odd, surplus) = self.parts.iter().fold(([0; 2], [0; 2]), |(odd, surplus), part| {
            ([0, 1].map(|word: usize| odd[word] ^ part.odd[word]), add(surplus, part.surplus))
        });
        let (parity, nonzero) = (odd == [0; 2], surplus == [0u64; 2]);
        if parity && nonzero {
            self.compared = Some(Compared::new(&self.parts));
            return None;
        }
        Some(Closed { parity, nonzero, is_proper: false })
    }
}

/// Looks whether an edge comes twice in its direction, or another has the same hash: once through the hashes for suspects, and once more
/// for those that have the hash of one.
struct Compared {
    /// 16 bits an edge or more: one in 32 is a suspect.
    table: Vec<AtomicU64>,
    next: usize,
    suspects: Vec<u64>,
    /// Edges with the hash of a suspect, once all suspects are known.
    n_found: Option<usize>,
}

/// Parts of hashes that are looked at in a step: some tens of milliseconds.
const PARTS_AT_ONCE: usize = 16;

impl Compared {
    fn new(parts: &[Hashes]) -> Compared {
        let n: usize = parts.iter().map(|part| part.forward.len()).sum();
        let log = n.max(4).next_power_of_two().trailing_zeros() - 2;
        let table = (0..1usize << log).map(|_| AtomicU64::new(0)).collect();
        Compared { table, next: 0, suspects: Vec::new(), n_found: None }
    }

    /// Looks at the next parts; whether there is such an edge, once that is known.
    fn step(&mut self, parts: &[Hashes]) -> Option<bool> {
        let some = &parts[self.next..parts.len().min(self.next + PARTS_AT_ONCE)];
        self.next += some.len();
        match &mut self.n_found {
            None => {
                let table = &self.table;
                let is_set = |hash: &u64| word_of(table, *hash).fetch_or(bit_of(*hash), Relaxed) & bit_of(*hash) != 0;
                let suspects = |part: &Hashes| part.forward.iter().copied().filter(is_set).collect::<Vec<u64>>();
                self.suspects.extend(some.par_iter().map(suspects).collect::<Vec<Vec<u64>>>().concat());
                if self.next < parts.len() {
                    return None;
                }
                self.sort_suspects()
            }
            Some(n_found) => {
                let (table, suspects) = (&self.table, &self.suspects);
                let is_suspect = |hash: &&u64| {
                    word_of(table, **hash).load(Relaxed) & bit_of(**hash) != 0 && suspects.binary_search(hash).is_ok()
                };
                let found = |part: &Hashes| part.forward.iter().filter(is_suspect).count();
                *n_found += some.par_iter().map(found).collect::<Vec<usize>>().into_iter().sum::<usize>();
                // each is one of them itself
                (self.next == parts.len()).then_some(*n_found > suspects.len())
            }
        }
    }

    /// Leaves the suspects alone in the table; whether there is such an edge, if that is known now.
    fn sort_suspects(&mut self) -> Option<bool> {
        self.suspects.sort_unstable();
        if self.suspects.is_empty() || self.suspects.windows(2).any(|two| two[0] == two[1]) {
            return Some(!self.suspects.is_empty());
        }
        self.table.iter().for_each(|word| word.store(0, Relaxed));
        for &hash in &self.suspects {
            word_of(&self.table, hash).fetch_or(bit_of(hash), Relaxed);
        }
        (self.next, self.n_found) = (0, Some(0));
        None
    }
}

/// Where a hash is in the table, whose length is a power of two.
fn word_of(table: &[AtomicU64], hash: u64) -> &AtomicU64 {
    &table[(hash >> 32) as usize & (table.len() - 1)]
}

fn bit_of(hash: u64) -> u64 {
    1 << (hash & 63)
}

fn corner_hash([x, y, z]: [i32; 3]) -> [u64; 2] {
    let words = [x, y, z].map(|c| u64::from(c as u32));
    let first = mixed(words[0] << 32 | words[1]);
    [mixed(first ^ words[2]), mixed(first.rotate_left(31) ^ words[2] << 32)]
}

#[cfg(test)]
mod tests;
