//! Closedness of a snapped surface, in one pass.
//!
//! Snapped facets, a rule -> whether no edge is open: what decides if rays alone decide the cells.

use std::cmp::Ordering;

use crate::frame::SnappedFacet;
use crate::job::Rule;
use crate::parallel::*;

/// Whether every edge of some snapped facets has an even number of them, or for `nonzero` as many one way as the other.
///
/// The sum of a hash of 128 bits over all edges, signed by their direction, is 0 if so; if not it is 0 by chance, once in 2^128
/// surfaces. Cost: some 30 ns a facet.
pub fn is_closed(facets: &[SnappedFacet], rule: Rule) -> bool {
    let add = |sum: [u64; 2], part: [u64; 2], is_forward: bool| {
        [0, 1].map(|word: usize| match (rule, is_forward) {
            (Rule::Parity, _) => sum[word] ^ part[word],
            (Rule::Nonzero, true) => sum[word].wrapping_add(part[word]),
            (Rule::Nonzero, false) => sum[word].wrapping_sub(part[word]),
        })
    };
    let sum_of = |facets: &[SnappedFacet]| {
        let mut sum = [0; 2];
        for facet in facets {
            let hashes = facet.map(corner_hash);
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                // an edge between equal corners is none
                let is_forward = match facet[from].cmp(&facet[to]) {
                    Ordering::Equal => continue,
                    order => order == Ordering::Less,
                };
                let (low, high) = if is_forward { (from, to) } else { (to, from) };
                let hash =
                    [0, 1].map(|word: usize| mixed(hashes[low][word] ^ mixed(hashes[high][word].rotate_left(23))));
                sum = add(sum, hash, is_forward);
            }
        }
        sum
    };
    let sums: Vec<[u64; 2]> = facets.par_chunks(1 << 14).map(sum_of).collect();
    sums.into_iter().fold([0; 2], |sum, part| add(sum, part, true)) == [0; 2]
}

fn corner_hash([x, y, z]: [i32; 3]) -> [u64; 2] {
    let words = [x, y, z].map(|c| u64::from(c as u32));
    let first = mixed(words[0] << 32 | words[1]);
    [mixed(first ^ words[2]), mixed(first.rotate_left(31) ^ words[2] << 32)]
}

/// A bijection of 64 bits in which every bit depends on all: the finalizer of SplitMix64 (Steele, Lea and Flood 2014).
fn mixed(word: u64) -> u64 {
    let word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let word = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ word >> 31
}
