//! Closedness of a snapped surface: whether rays alone decide its cells, and where its edges are not proper.
//!
//! Snapped facets -> [`Closed`], in one pass over the facets and one over half of their edges; for what is not proper -> [`BadEdges`].
//!
//! # Theory
//! The sum of a hash of 128 bits over all edges, signed by their direction, is 0 if every edge is used as often one way as the other; with
//! an exclusive or in place of the sum, if it is used an even number of times. By chance both are so once in 2^128 surfaces.
//! Where both are 0, every edge is used k times each way, and all edges are proper if no edge comes twice in one direction. Each
//! sets a bit of a table at a place that its hash says. One that finds its bit set is a suspect: it, or what came before it and has the same
//! bit. If no other edge has the hash of a suspect, none came twice.
//!
//! Cost: some 35 ns a facet on one core; 20 bytes a facet for a moment.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::edges::mixed;
use crate::frame::{Frame, SnappedFacet};
use crate::job::Rule;
use crate::parallel::*;

mod bad;

pub use bad::{BadEdges, EdgeGroup, MAX_FACETS};

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
    /// Checks the facets of each rank of a frame.
    pub fn of_ranks(frame: &Frame) -> Vec<Closed> {
        (0..frame.ranks.geometry_of_rank.len()).map(|rank| Closed::new(frame.facets_of_rank(rank))).collect()
    }

    /// Checks facets.
    pub fn new(facets: &[SnappedFacet]) -> Closed {
        let parts: Vec<Hashes> = facets.par_chunks(CHUNK).map(Hashes::new).collect();
        let (odd, surplus) = parts.iter().fold(([0; 2], [0; 2]), |(odd, surplus), part| {
            ([0, 1].map(|word: usize| odd[word] ^ part.odd[word]), add(surplus, part.surplus))
        });
        let (parity, nonzero) = (odd == [0; 2], surplus == [0u64; 2]);
        Closed { parity, nonzero, is_proper: parity && nonzero && !has_twice(&parts) }
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

/// Whether an edge comes twice in its direction, or another has the same hash.
fn has_twice(parts: &[Hashes]) -> bool {
    let n: usize = parts.iter().map(|part| part.forward.len()).sum();
    // 16 bits an edge or more: one in 32 is a suspect
    let log = n.max(4).next_power_of_two().trailing_zeros() - 2;
    let table: Vec<AtomicU64> = (0..1usize << log).map(|_| AtomicU64::new(0)).collect();
    let word_of = |hash: u64| (hash >> 32 & ((1 << log) - 1)) as usize;
    let is_set = |hash: &u64| {
        let bit = 1 << (hash & 63);
        table[word_of(*hash)].fetch_or(bit, Relaxed) & bit != 0
    };
    let suspects = |part: &Hashes| part.forward.iter().copied().filter(is_set).collect::<Vec<u64>>();
    let mut suspects: Vec<u64> = parts.par_iter().map(suspects).collect::<Vec<Vec<u64>>>().concat();
    if suspects.is_empty() {
        return false;
    }
    suspects.sort_unstable();
    if suspects.windows(2).any(|two| two[0] == two[1]) {
        return true;
    }
    table.iter().for_each(|word| word.store(0, Relaxed));
    for hash in &suspects {
        table[word_of(*hash)].fetch_or(1 << (hash & 63), Relaxed);
    }
    let is_suspect = |hash: &&u64| {
        table[word_of(**hash)].load(Relaxed) & 1 << (**hash & 63) != 0 && suspects.binary_search(hash).is_ok()
    };
    // each is one of them itself
    let found: usize = parts
        .par_iter()
        .map(|part| part.forward.iter().filter(is_suspect).count())
        .collect::<Vec<usize>>()
        .into_iter()
        .sum();
    found > suspects.len()
}

fn corner_hash([x, y, z]: [i32; 3]) -> [u64; 2] {
    let words = [x, y, z].map(|c| u64::from(c as u32));
    let first = mixed(words[0] << 32 | words[1]);
    [mixed(first ^ words[2]), mixed(first.rotate_left(31) ^ words[2] << 32)]
}

#[cfg(test)]
mod tests;
