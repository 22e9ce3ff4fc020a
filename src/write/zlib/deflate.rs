//! DEFLATE, the way in: tokens in blocks, each with codes of its own.
//!
//! Bytes, a level -> a zlib stream. Every block of [`BLOCK_TOKENS`] tokens counts its symbols, stores the lengths of their codes
//! and then the tokens. The bytes depend on input and level alone, so that a file is the same on every machine.
//! Flags are long runs and rows like those before them: blocks that are stored as they are, or with fixed codes, would
//! never be smaller.
//!
//! Source: RFC 1950 and 1951.

use crate::checksum::adler32;

use super::huffman::{MAX_LENGTH, codes, lengths};
use super::matches::{Matches, Token};

/// Tokens of a block.
const BLOCK_TOKENS: usize = 1 << 15;
/// Symbols: bytes, the end, lengths; distances; lengths of codes.
pub(super) const N_SYMBOLS: usize = 286;
pub(super) const N_DISTANCES: usize = 30;
pub(super) const N_LENGTHS: usize = 19;
/// The symbol that ends a block, and that of the first length.
pub(super) const END: usize = 256;
/// In which order the lengths of the codes for lengths of codes are stored.
pub(super) const ORDER: [usize; N_LENGTHS] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

/// Compresses to one zlib stream.
pub(super) fn deflate(bytes: &[u8], level: u8) -> Vec<u8> {
    let mut out = Bits { bytes: vec![0x78, 0x01], word: 0, n_bits: 0 };
    let mut matches = Matches::new(bytes, level);
    loop {
        let tokens: Vec<u32> = matches.by_ref().take(BLOCK_TOKENS).map(Token::pack).collect();
        let is_last = tokens.len() < BLOCK_TOKENS;
        out.put(u32::from(is_last) | 2 << 1, 3);
        put_block(&tokens, &mut out);
        if is_last {
            break;
        }
    }
    out.put(0, 7);
    let mut bytes_out = out.bytes;
    bytes_out.extend(adler32(bytes).to_be_bytes());
    bytes_out
}

/// Bits on their way to bytes, the first lowest.
struct Bits {
    bytes: Vec<u8>,
    word: u64,
    n_bits: u32,
}

impl Bits {
    fn put(&mut self, value: u32, n_bits: u32) {
        self.word |= u64::from(value) << self.n_bits;
        self.n_bits += n_bits;
        while self.n_bits >= 8 {
            self.bytes.push(self.word as u8);
            self.word >>= 8;
            self.n_bits -= 8;
        }
    }
}

/// A code: the bits of every symbol, and how many.
struct Code {
    bits: Vec<u16>,
    lengths: Vec<u8>,
}

impl Code {
    /// The best code for symbols that occur so often.
    fn new(counts: &mut [u32], most: usize) -> Code {
        let lengths = lengths(counts, most);
        Code { bits: codes(&lengths), lengths }
    }

    fn put(&self, symbol: usize, out: &mut Bits) {
        out.put(self.bits[symbol].into(), self.lengths[symbol].into());
    }
}

/// Symbol of a length - 3 or a distance - 1, and the number of low bits that follow it; `steps` symbols are 2^steps to an octave.
fn symbol(value: u32, steps: u32) -> (usize, u32) {
    let n_bits = (value | 1).ilog2().saturating_sub(steps);
    (((n_bits << steps) + (value >> n_bits)) as usize, n_bits)
}

fn length_symbol(length: u32) -> (usize, u32) {
    // the longest has a symbol of its own
    let (symbol, n_bits) = if length == 258 { (28, 0) } else { symbol(length - 3, 2) };
    (END + 1 + symbol, n_bits)
}

fn put_block(tokens: &[u32], out: &mut Bits) {
    let (mut counts, mut distance_counts) = ([0; N_SYMBOLS], [0; N_DISTANCES]);
    counts[END] = 1;
    for &token in tokens {
        match Token::unpack(token) {
            Token::Byte(byte) => counts[usize::from(byte)] += 1,
            Token::Repeat(length, distance) => {
                counts[length_symbol(length).0] += 1;
                distance_counts[symbol(distance - 1, 1).0] += 1;
            }
        }
    }
    let (symbols, distances) = (Code::new(&mut counts, MAX_LENGTH), Code::new(&mut distance_counts, MAX_LENGTH));
    put_lengths(&[symbols.lengths.as_slice(), &distances.lengths].concat(), out);
    for &token in tokens {
        match Token::unpack(token) {
            Token::Byte(byte) => symbols.put(byte.into(), out),
            Token::Repeat(length, distance) => {
                let (symbol_of_length, n_bits) = length_symbol(length);
                symbols.put(symbol_of_length, out);
                out.put((length - 3) & ((1 << n_bits) - 1), n_bits);
                let (symbol_of_distance, n_bits) = symbol(distance - 1, 1);
                distances.put(symbol_of_distance, out);
                out.put((distance - 1) & ((1 << n_bits) - 1), n_bits);
            }
        }
    }
    symbols.put(END, out);
}

/// Stores the lengths of all codes, in a code of their own.
fn put_lengths(all: &[u8], out: &mut Bits) {
    let packed = packed_lengths(all);
    let mut counts = [0; N_LENGTHS];
    packed.iter().for_each(|&(symbol, ..)| counts[symbol] += 1);
    let code = Code::new(&mut counts, 7);
    out.put((N_SYMBOLS - 257) as u32 | ((N_DISTANCES - 1) as u32) << 5 | ((N_LENGTHS - 4) as u32) << 10, 14);
    ORDER.iter().for_each(|&symbol| out.put(code.lengths[symbol].into(), 3));
    for (symbol, more, n_bits) in packed {
        code.put(symbol, out);
        out.put(more, n_bits);
    }
}

/// Lengths as symbols with the value and number of the bits that follow: the length itself, or 16 for 3 to 6 more of the one
/// before, 17 for 3 to 10 zeros, 18 for 11 to 138 zeros.
fn packed_lengths(all: &[u8]) -> Vec<(usize, u32, u32)> {
    let mut packed = Vec::new();
    for same in all.chunk_by(|one, next| one == next) {
        let mut n = same.len();
        if same[0] > 0 {
            packed.push((usize::from(same[0]), 0, 0));
            n -= 1;
        }
        while n > 0 {
            let (symbol, least, most, n_bits) = match (same[0], n) {
                (0, 11..) => (18, 11, 138, 7),
                (0, 3..) => (17, 3, 10, 3),
                (1.., 3..) => (16, 3, 6, 2),
                _ => (usize::from(same[0]), 1, 1, 0),
            };
            let taken = n.min(most);
            packed.push((symbol, (taken - least) as u32, n_bits));
            n -= taken;
        }
    }
    packed
}
