//! Random changes of bytes: those that fuzzers make.

/// Random numbers by splitmix64, the same for the same seed.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d))
    }

    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    /// A number below `n`; 0 where there is none.
    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    /// A number below `n`, rather a small one.
    fn small(&mut self, n: usize) -> usize {
        let most = 1 << self.below(12);
        self.below(n.min(most).max(1))
    }
}

/// An input of the pool after one to six changes, rather few.
pub(super) fn mutated(pool: &[Vec<u8>], dictionary: &[&str], max_bytes: usize, random: &mut Random) -> Vec<u8> {
    let mut bytes = pool[random.below(pool.len())].clone();
    let n_more = random.below(6);
    for _ in 0..1 + random.below(1 + n_more) {
        change(&mut bytes, pool, dictionary, random);
    }
    bytes.truncate(max_bytes);
    bytes
}

fn change(bytes: &mut Vec<u8>, pool: &[Vec<u8>], dictionary: &[&str], random: &mut Random) {
    let at = random.below(bytes.len());
    let n = random.small(bytes.len() - at + 1);
    match random.below(12) {
        0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
        1 if !bytes.is_empty() => bytes[at] = random.next() as u8,
        2 if !bytes.is_empty() => bytes[at] = bytes[at].wrapping_add(random.below(5) as u8).wrapping_sub(2),
        3 => number(bytes, at, random),
        4 => drop(bytes.drain(at..at + n)),
        5 => {
            let copied = bytes[at..at + n].to_vec();
            let to = random.below(bytes.len() + 1);
            bytes.splice(to..to, copied);
        }
        6 if random.below(4) == 0 => bytes.truncate(at),
        // twice as likely: words lead deeper than bytes
        6..=8 if !dictionary.is_empty() => {
            let word = dictionary[random.below(dictionary.len())].bytes();
            let end = if random.below(2) == 0 { at } else { at + n };
            bytes.splice(at..end, word);
        }
        9 => {
            let other = &pool[random.below(pool.len())];
            let from = random.below(other.len());
            let part = &other[from..from + random.below(other.len() - from + 1)];
            let end = if random.below(2) == 0 { at } else { bytes.len() };
            bytes.splice(at..end, part.iter().copied());
        }
        10 => {
            let repeated = bytes[at..at + n].repeat(random.small(40));
            bytes.splice(at..at, repeated);
        }
        _ => {
            let new: Vec<u8> = (0..n).map(|_| random.next() as u8).collect();
            bytes.splice(at..at + n, new);
        }
    }
}

/// Overwrites a number of 4 or 8 bytes with one at the end of some range.
fn number(bytes: &mut [u8], at: usize, random: &mut Random) {
    let near = (1u64 << random.below(64)).wrapping_add(random.below(3) as u64).wrapping_sub(1);
    let value = match random.below(5) {
        0 => u64::MAX,
        1 => random.below(4) as u64,
        2 => f64::to_bits([f64::NAN, f64::INFINITY, -0.0, 5e-324, f64::MAX, -1.0][random.below(6)]),
        3 => u64::from(f32::to_bits([f32::NAN, f32::INFINITY, -0.0, 1e-45, f32::MAX, -1.0][random.below(6)])),
        _ => near,
    };
    let n = [4, 8][random.below(2)].min(bytes.len() - at);
    bytes[at..at + n].copy_from_slice(&value.to_le_bytes()[..n]);
}
