//! 64 cells of a row at a time, a bit each: what rays say of them, and what follows.

/// What the rays of one axis say of 64 cells.
#[derive(Clone, Copy)]
pub(super) struct Vote {
    pub(super) inside: u64,
    pub(super) odd: u64,
}

/// Which cells have three even rays that agree, and what these say.
pub(super) fn unanimous([a, b, c]: [Vote; 3]) -> (u64, u64) {
    let differ = (a.inside ^ b.inside) | (b.inside ^ c.inside);
    (!(differ | a.odd | b.odd | c.odd), a.inside)
}

/// Which cells are inside by most of their even rays.
pub(super) fn majority(votes: [Vote; 3]) -> u64 {
    let [a, b, c] = votes.map(|vote| vote.inside & !vote.odd);
    let outside = votes.iter().fold(0, |any, vote| any | !vote.inside & !vote.odd);
    a & b | b & c | a & c | (a | b | c) & !outside
}

pub(super) fn flip(bits: &mut [u64], place: u32) {
    bits[place as usize / 64] ^= 1 << (place % 64);
}

pub(super) fn set(bits: &mut [u64], place: usize, to: bool) {
    let bit = 1 << (place % 64);
    if to { bits[place / 64] |= bit } else { bits[place / 64] &= !bit }
}

/// Sets every bit to the sum modulo 2 of the bits up to it.
pub(super) fn fill_between(bits: &mut [u64]) {
    let mut carry = 0u64;
    for word in bits {
        for shift in [1, 2, 4, 8, 16, 32] {
            *word ^= *word << shift;
        }
        *word ^= carry;
        carry = 0u64.wrapping_sub(*word >> 63);
    }
}
