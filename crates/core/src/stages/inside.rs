//! Follows a ray from crossing to crossing, and knows which geometries it is inside of.

use crate::input::job::Rule;

/// How the cells of a geometry are decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// By rays.
    Cast,
    /// By rays, and those outside belong to it.
    Inverted,
    /// Otherwise.
    Apart,
}

/// Whether a place with a winding number is inside.
#[inline(always)]
pub fn is_inside(rule: Rule, winding: i32) -> bool {
    match rule {
        Rule::Parity => winding & 1 != 0,
        Rule::Nonzero => winding != 0,
    }
}

/// A counter for each rank, and a bit for those that hold the place.
pub struct Inside {
    counters: Vec<i32>,
    bits: [u64; 4],
    rule: Rule,
}

impl Clone for Inside {
    fn clone(&self) -> Inside {
        Inside { counters: self.counters.clone(), ..*self }
    }

    /// Allocates nothing.
    fn clone_from(&mut self, other: &Inside) {
        self.counters.clone_from(&other.counters);
        (self.bits, self.rule) = (other.bits, other.rule);
    }
}

impl Inside {
    /// Before the first crossing of a ray.
    pub fn new(kinds: &[Kind], rule: Rule) -> Inside {
        let mut inside = Inside { counters: vec![0; kinds.len()], bits: [0; 4], rule };
        inside.begin(kinds);
        inside
    }

    /// Goes back to before the first crossing.
    pub fn begin(&mut self, kinds: &[Kind]) {
        self.counters.fill(0);
        self.bits = [0; 4];
        for (rank, kind) in kinds.iter().enumerate() {
            if *kind == Kind::Inverted {
                self.flip(rank);
            }
        }
    }

    /// Passes a crossing, forwards or backwards along the ray.
    pub fn pass(&mut self, event: u32, is_backward: bool) {
        let rank = (event >> 1 & 0xff) as usize;
        let was_zero = self.counters[rank] == 0;
        match self.rule {
            Rule::Parity => self.counters[rank] ^= 1,
            Rule::Nonzero => self.counters[rank] += if (event & 1 == 1) == is_backward { 1 } else { -1 },
        }
        if was_zero != (self.counters[rank] == 0) {
            self.flip(rank);
        }
    }

    /// Takes a rank in, or out.
    pub fn flip(&mut self, rank: usize) {
        self.bits[rank / 64] ^= 1 << (rank % 64);
    }

    /// The highest rank that holds the place.
    pub fn winner(&self) -> Option<u8> {
        let word = (0..4).rev().find(|&word| self.bits[word] != 0)?;
        Some((64 * word + 63 - self.bits[word].leading_zeros() as usize) as u8)
    }

    /// The flag of the place.
    pub fn flag(&self, flag_of_rank: &[u8]) -> u8 {
        self.winner().map_or(0, |rank| flag_of_rank[usize::from(rank)])
    }
}
