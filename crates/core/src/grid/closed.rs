//! Closedness of a snapped surface: whether rays alone decide its cells, and where its edges are not proper.
//!
//! Snapped facets -> [`Closed`], in one pass over the facets and one over half of their edges, in parts that fit the cache; if some are not
//! proper, also [`BadEdges`].
//!
//! # Theory
//! Each edge has a hash of 128 bits. The sum of the hashes over all uses, signed by their direction, is 0 if every edge is used
//! as often one way as the other. The exclusive or of the hashes is 0 if every edge is used an even number of times. By accident
//! this happens for one other surface in 2^128.
//! If both are 0, every edge is used k times each way, and all edges are proper if no edge comes twice in one direction. To
//! find that out, edges are put in order by the first bits of their hashes, and those that begin alike are compared: each edge sets a
//! bit in a table, at a place that its hash gives. An edge whose bit is set already is a suspect. If no other edge has the hash of a
//! suspect, none came twice.
//!
//! Cost: 12 bytes a facet for a moment, and a table in the cache of each core.

use std::ops::Range;

use crate::base::control::Control;
use crate::base::error::Result;
use crate::base::parallel::*;
use crate::grid::frame::SnappedFacet;
use crate::input::edges::product;
use crate::input::job::Rule;

mod bad_edges;

pub use bad_edges::{BadEdges, EdgeGroup, MAX_FACETS};

/// Facets that one core takes at a time.
pub(crate) const CHUNK: usize = 1 << 14;
/// Parts that hashes are put in, by their first bits.
const PARTS: usize = 256;
/// Hashes that are compared at once, about, in some milliseconds; at least a sixteenth of them all, so that many cores have work.
const AT_ONCE: usize = 1 << 18;
/// Least hashes that are compared with each other, unless there are fewer: the cache holds them and their table.
const LEAST_COMPARED: usize = 1 << 16;

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
    /// Checks a surface by the hashes of all its edges, with a rest before each portion of them that is compared.
    ///
    /// # Errors
    /// `cancelled`.
    pub(crate) async fn new(chunks: &[Hashes], control: &Control) -> Result<Closed> {
        let (odd, surplus) = chunks.iter().fold(([0; 2], [0; 2]), |(odd, surplus), chunk| {
            ([odd[0] ^ chunk.odd[0], odd[1] ^ chunk.odd[1]], add(surplus, chunk.surplus))
        });
        let (parity, nonzero) = (odd == [0; 2], surplus == [0; 2]);
        let n: usize = chunks.iter().map(|chunk| chunk.forward.len()).sum();
        // powers of two, which divide the number of all parts
        let parts_of = |n_hashes: usize| (PARTS * n_hashes / n.max(1)).clamp(1, PARTS).next_power_of_two();
        let (at_once, in_group) = (parts_of(AT_ONCE).max(PARTS / 16), parts_of(LEAST_COMPARED));
        let mut is_proper = parity && nonzero;
        let mut portions = (0..PARTS).step_by(at_once);
        while is_proper && let Some(first) = portions.next() {
            control.rest().await?;
            let groups: Vec<usize> = (first..first + at_once).step_by(in_group).collect();
            let of_group = |first| has_twice(chunks, &(first..first + in_group));
            let has_twice: Vec<bool> = on_all_cores(|| groups.into_par_iter().map(of_group).collect());
            is_proper = !has_twice.contains(&true);
        }
        Ok(Closed { parity, nonzero, is_proper })
    }

    #[cfg(any(test, feature = "testing"))]
    pub fn of(facets: &[SnappedFacet]) -> Closed {
        let chunks: Vec<Hashes> = facets.par_chunks(CHUNK).map(Hashes::new).collect();
        crate::base::control::at_once(Closed::new(&chunks, &Control::default())).unwrap()
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
pub(crate) struct Hashes {
    odd: [u64; 2],
    surplus: [u64; 2],
    /// Of the edges in the direction of their corners, part after part.
    forward: Vec<u64>,
    /// Where each part begins in `forward`, and the end.
    starts: [u32; PARTS + 1],
}

impl Hashes {
    /// Those of facets that the cache holds.
    pub(crate) fn new(facets: &[SnappedFacet]) -> Hashes {
        let (mut odd, mut surplus) = ([0; 2], [0; 2]);
        let mut forward = Vec::with_capacity(2 * facets.len());
        for facet in facets {
            let [a, b, c] = facet;
            // it is collapsed, and has no edges
            if a == b || b == c || c == a {
                continue;
            }
            let hashes = [corner_hash(a), corner_hash(b), corner_hash(c)];
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let is_forward = facet[from] < facet[to];
                let (low, high) = if is_forward { (hashes[from], hashes[to]) } else { (hashes[to], hashes[from]) };
                let hash = edge_hash(low, high);
                odd = [odd[0] ^ hash[0], odd[1] ^ hash[1]];
                if is_forward {
                    forward.push(hash[0]);
                    surplus = add(surplus, hash);
                } else {
                    surplus = add(surplus, [hash[0].wrapping_neg(), hash[1].wrapping_neg()]);
                }
            }
        }
        let (forward, starts) = in_parts(&forward);
        Hashes { odd, surplus, forward, starts }
    }

    /// Bytes that they take.
    pub(crate) fn bytes(&self) -> u64 {
        (size_of::<Hashes>() + size_of_val(&self.forward[..])) as u64
    }

    /// Those of some parts.
    fn of_parts(&self, parts: &Range<usize>) -> &[u64] {
        &self.forward[self.starts[parts.start] as usize..self.starts[parts.end] as usize]
    }
}

/// Hashes by their first bits, a counting sort, and where each part begins.
fn in_parts(hashes: &[u64]) -> (Vec<u64>, [u32; PARTS + 1]) {
    let part = |hash: u64| (hash >> (u64::BITS - PARTS.trailing_zeros())) as usize;
    let mut starts = [0; PARTS + 1];
    for &hash in hashes {
        starts[part(hash) + 1] += 1;
    }
    for part in 0..PARTS {
        starts[part + 1] += starts[part];
    }
    let (mut next, mut sorted) = (starts, vec![0; hashes.len()]);
    for &hash in hashes {
        let place = &mut next[part(hash)];
        sorted[*place as usize] = hash;
        *place += 1;
    }
    (sorted, starts)
}

fn add(one: [u64; 2], other: [u64; 2]) -> [u64; 2] {
    [one[0].wrapping_add(other[0]), one[1].wrapping_add(other[1])]
}

/// Whether an edge comes twice in its direction, or another has the same hash, in some parts: once through the hashes for suspects, and once
/// more for those that have the hash of one.
fn has_twice(chunks: &[Hashes], parts: &Range<usize>) -> bool {
    let n: usize = chunks.iter().map(|chunk| chunk.of_parts(parts).len()).sum();
    // 16 bits an edge or more: one in 32 is a suspect
    let mut table = vec![0u64; n.max(4).next_power_of_two() / 4];
    let mut suspects = Vec::new();
    for chunk in chunks {
        for &hash in chunk.of_parts(parts) {
            let (word, bit) = place(&table, hash);
            if table[word] & bit != 0 {
                suspects.push(hash);
            }
            table[word] |= bit;
        }
    }
    suspects.sort_unstable();
    if suspects.is_empty() || suspects.windows(2).any(|two| two[0] == two[1]) {
        return !suspects.is_empty();
    }
    // suspects alone
    table.fill(0);
    for &hash in &suspects {
        let (word, bit) = place(&table, hash);
        table[word] |= bit;
    }
    let is_suspect = |hash: &&u64| {
        let (word, bit) = place(&table, **hash);
        table[word] & bit != 0 && suspects.binary_search(hash).is_ok()
    };
    let n_found: usize = chunks.iter().map(|chunk| chunk.of_parts(parts).iter().filter(is_suspect).count()).sum();
    // each is one of them itself
    n_found > suspects.len()
}

/// Word and bit of a hash in the table, whose length is a power of two.
#[inline(always)]
fn place(table: &[u64], hash: u64) -> (usize, u64) {
    ((hash >> 24) as usize & (table.len() - 1), 1 << (hash & 63))
}

/// Constants without a pattern: digits of the fractions of the square roots of 2, 3, 5, 7, 11 and 13.
const SALTS: [u64; 6] = [
    0x6a09_e667_f3bc_c908,
    0xbb67_ae85_84ca_a73b,
    0x3c6e_f372_fe94_f82b,
    0xa54f_f53a_5f1d_36f1,
    0x510e_527f_ade6_82d1,
    0x9b05_688c_2b3e_6c1f,
];

/// 128 bits of a corner.
#[inline(always)]
fn corner_hash(&[x, y, z]: &[i32; 3]) -> [u64; 2] {
    let word = |c: i32| u64::from(c as u32);
    let [low, high] = product((word(x) << 32 | word(y)) ^ SALTS[0], (word(z) << 32 | word(z)) ^ SALTS[1]);
    [low ^ high.rotate_left(32), high ^ low.rotate_left(17)]
}

/// 128 bits of an edge by those of its lower and its higher corner: the two words of a product come together, as in wyhash (Wang Yi 2019).
#[inline(always)]
fn edge_hash(low: [u64; 2], high: [u64; 2]) -> [u64; 2] {
    let folded = |[low, high]: [u64; 2]| low ^ high;
    [
        folded(product(low[0] ^ SALTS[2], high[1].wrapping_add(low[1]) ^ SALTS[3])),
        folded(product(low[1] ^ SALTS[4], high[0].wrapping_add(low[0]) ^ SALTS[5])),
    ]
}

#[cfg(test)]
mod tests;
