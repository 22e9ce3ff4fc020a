//! DEFLATE, the way out.
//!
//! A zlib stream -> bytes. Nothing is believed: whatever does not fit, a checksum too, is an error, and no more bytes are made
//! than the caller allows. A table of all bit patterns finds a symbol at once.
//!
//! Source: RFC 1950 and 1951. Natively flate2 reads, faster; its code would be a twentieth of what a browser loads.

use crate::checksum::adler32;

use super::deflate::{END, N_DISTANCES, N_LENGTHS, N_SYMBOLS, ORDER};
use super::huffman::{MAX_LENGTH, codes};

/// What is wrong with a stream, in the words of flate2.
pub(super) const CORRUPT: &str = "corrupt deflate stream";

type Step<T> = Option<T>;

/// Expands a zlib stream to at most `most` bytes; returns them and the length of the stream, 0 where it goes on.
pub(super) fn inflate(bytes: &[u8], most: usize) -> Result<(Vec<u8>, usize), &'static str> {
    let mut stream = Stream { bytes, at: 2, word: 0, n_bits: 0, out: Vec::new(), most };
    if bytes.len() < 2 || bytes[0] & 15 != 8 || bytes[0] >> 4 > 7 || bytes[1] & 0x20 != 0 || !head_fits(bytes) {
        return Err(CORRUPT);
    }
    stream.blocks().ok_or(CORRUPT)?;
    if stream.out.len() > most {
        stream.out.truncate(most);
        return Ok((stream.out, 0));
    }
    // whole bytes that were looked at too early
    let end = stream.at - stream.n_bits as usize / 8;
    match bytes.get(end..end + 4) {
        Some(sum) if *sum == adler32(&stream.out).to_be_bytes() => Ok((stream.out, end + 4)),
        _ => Err(CORRUPT),
    }
}

fn head_fits(bytes: &[u8]) -> bool {
    (u32::from(bytes[0]) << 8 | u32::from(bytes[1])).is_multiple_of(31)
}

struct Stream<'a> {
    bytes: &'a [u8],
    at: usize,
    word: u64,
    n_bits: u32,
    out: Vec<u8>,
    most: usize,
}

impl Stream<'_> {
    /// Makes sure of `n` bits, at most 32; zeros stand behind the end.
    fn fill(&mut self, n: u32) {
        while self.n_bits < n {
            self.word |= u64::from(self.bytes.get(self.at).copied().unwrap_or(0)) << self.n_bits;
            self.at += 1;
            self.n_bits += 8;
        }
    }

    fn bits(&mut self, n: u32) -> Step<u32> {
        self.fill(n);
        self.drop(n)
    }

    /// Takes bits that are there; None if they were behind the end.
    fn drop(&mut self, n: u32) -> Step<u32> {
        let bits = self.word as u32 & ((1u64 << n) - 1) as u32;
        self.word >>= n;
        self.n_bits -= n;
        (self.at - self.n_bits as usize / 8 <= self.bytes.len()).then_some(bits)
    }

    fn blocks(&mut self) -> Step<()> {
        loop {
            let is_last = self.bits(1)? == 1;
            match self.bits(2)? {
                0 => self.stored()?,
                1 => {
                    let lengths: Vec<u8> = (0..288)
                        .map(|n| 7 + u8::from(n < 256) + u8::from((144..256).contains(&n)) + u8::from(n >= 280))
                        .collect();
                    self.coded(&Table::new(&lengths)?, &Table::new(&[5; 32])?)?;
                }
                2 => {
                    let (symbols, distances) = self.tables()?;
                    self.coded(&symbols, &distances)?;
                }
                _ => return None,
            }
            if is_last || self.out.len() > self.most {
                return Some(());
            }
        }
    }

    fn stored(&mut self) -> Step<()> {
        self.drop(self.n_bits % 8)?;
        let (n, check) = (self.bits(16)?, self.bits(16)?);
        if n != !check & 0xffff {
            return None;
        }
        for _ in 0..n {
            let byte = self.bits(8)? as u8;
            self.out.push(byte);
        }
        Some(())
    }

    /// Reads the codes of a block: for bytes, end and lengths, and for distances.
    fn tables(&mut self) -> Step<(Table, Table)> {
        let [n_symbols, n_distances, n_lengths] =
            [257 + self.bits(5)?, 1 + self.bits(5)?, 4 + self.bits(4)?].map(|n| n as usize);
        if n_symbols > N_SYMBOLS || n_distances > N_DISTANCES {
            return None;
        }
        let mut own = [0; N_LENGTHS];
        for &symbol in &ORDER[..n_lengths] {
            own[symbol] = self.bits(3)? as u8;
        }
        let table = Table::new(&own)?;
        let mut lengths: Vec<u8> = Vec::new();
        while lengths.len() < n_symbols + n_distances {
            let (length, n) = match self.symbol(&table)? {
                16 => (*lengths.last()?, 3 + self.bits(2)?),
                17 => (0, 3 + self.bits(3)?),
                18 => (0, 11 + self.bits(7)?),
                length => (length as u8, 1),
            };
            lengths.resize(lengths.len() + n as usize, length);
        }
        if lengths.len() > n_symbols + n_distances || lengths[END] == 0 {
            return None;
        }
        Some((Table::new(&lengths[..n_symbols])?, Table::new(&lengths[n_symbols..])?))
    }

    fn symbol(&mut self, table: &Table) -> Step<usize> {
        self.fill(MAX_LENGTH as u32);
        let entry = table.entries[self.word as usize & (table.entries.len() - 1)];
        self.drop(u32::from(entry & 15))?;
        (entry > 0).then_some(usize::from(entry >> 4))
    }

    /// Length or distance, less the smallest, of a symbol; `steps` as for the way in.
    fn value(&mut self, symbol: u32, steps: u32) -> Step<usize> {
        let n_bits = (symbol >> steps).saturating_sub(1);
        let high = symbol - (n_bits << steps);
        Some(((high << n_bits) + self.bits(n_bits)?) as usize)
    }

    fn coded(&mut self, symbols: &Table, distances: &Table) -> Step<()> {
        while self.out.len() <= self.most {
            let symbol = self.symbol(symbols)?;
            if symbol < END {
                self.out.push(symbol as u8);
                continue;
            }
            if symbol == END {
                return Some(());
            }
            let length = match symbol - END - 1 {
                28 => 258,
                symbol @ ..28 => 3 + self.value(symbol as u32, 2)?,
                _ => return None,
            };
            let symbol = self.symbol(distances)?;
            let distance = if symbol < N_DISTANCES { 1 + self.value(symbol as u32, 1)? } else { return None };
            let start = self.out.len().checked_sub(distance)?;
            if distance >= length {
                self.out.extend_from_within(start..start + length);
            } else if distance == 1 {
                self.out.resize(start + 1 + length, self.out[start]);
            } else {
                (start..start + length).for_each(|at| self.out.push(self.out[at]));
            }
        }
        Some(())
    }
}

/// The symbol of every bit pattern, `symbol << 4 | length of its code`; 0 for none.
struct Table {
    entries: Vec<u16>,
}

impl Table {
    /// None where codes of these lengths cannot exist, or do not use all patterns: a single one of one bit may.
    fn new(lengths: &[u8]) -> Step<Table> {
        let longest = usize::from(lengths.iter().copied().max()?);
        let taken: usize =
            lengths.iter().filter(|&&length| length > 0).map(|&length| 1 << (longest - usize::from(length))).sum();
        if taken != 1 << longest && longest > 1 || taken > 1 << longest {
            return None;
        }
        let mut entries = vec![0; 1 << longest];
        for (symbol, (&length, code)) in lengths.iter().zip(codes(lengths)).enumerate() {
            if length > 0 {
                let entry = (symbol as u16) << 4 | u16::from(length);
                entries.iter_mut().skip(code.into()).step_by(1 << length).for_each(|slot| *slot = entry);
            }
        }
        Some(Table { entries })
    }
}

#[cfg(test)]
mod tests {
    use super::super::deflate::deflate;
    use super::*;
    use flate2::Compression;
    use flate2::read::{ZlibDecoder, ZlibEncoder};
    use proptest::prelude::*;
    use std::io::Read;

    /// Bytes like flags: runs, and rows like those before.
    fn rows(n: usize, width: usize) -> Vec<u8> {
        (0..n).map(|i| ((i % width + i / width / 3) / 40 % 4 * (i / 5000 % 3)) as u8).collect()
    }

    fn by_flate2(stream: &[u8]) -> Vec<u8> {
        let mut plain = Vec::new();
        ZlibDecoder::new(stream).read_to_end(&mut plain).unwrap();
        plain
    }

    fn streams(bytes: &[u8]) -> Vec<Vec<u8>> {
        let ours = (1..=9).map(|level| deflate(bytes, level));
        let theirs = (0..=9).map(|level| {
            let mut stream = Vec::new();
            ZlibEncoder::new(bytes, Compression::new(level)).read_to_end(&mut stream).unwrap();
            stream
        });
        ours.chain(theirs).collect()
    }

    #[track_caller]
    fn expect_all_agree(bytes: &[u8]) {
        for stream in streams(bytes) {
            assert!(by_flate2(&stream) == bytes);
            let (plain, used) = inflate(&stream, usize::MAX).unwrap();
            assert!(plain == bytes && used == stream.len());
        }
    }

    #[test]
    fn what_one_side_writes_both_sides_read() {
        expect_all_agree(&[]);
        expect_all_agree(b"a");
        expect_all_agree(&rows(1 << 20, 301));
        expect_all_agree(&vec![7; 1 << 20]);
        // no two alike: more tokens than a block holds
        let noise: Vec<u8> = (0..200_000u32).map(|i| (i.wrapping_mul(0x9e37_79b1) >> 13 ^ i >> 3) as u8).collect();
        expect_all_agree(&noise);
    }

    #[test]
    fn flags_shrink_as_much_as_by_zlib() {
        let bytes = rows(1 << 20, 301);
        let sizes: Vec<usize> = streams(&bytes).iter().map(Vec::len).collect();
        assert!(sizes[0] <= sizes[10] && sizes[5] <= sizes[15] + sizes[15] / 10, "{sizes:?}");
    }

    #[test]
    fn a_limit_holds_and_damage_shows() {
        let bytes = rows(20_000, 77);
        for stream in streams(&bytes) {
            assert_eq!(inflate(&stream, 19_999).unwrap(), (bytes[..19_999].to_vec(), 0));
            for cut in (0..stream.len()).step_by(1 + stream.len() / 200) {
                assert_eq!(inflate(&stream[..cut], usize::MAX), Err(CORRUPT), "cut at {cut}");
                let mut damaged = stream.clone();
                damaged[cut] ^= 1 << (cut % 8);
                // some bits change nothing: padding, or how far back in a run
                let found = inflate(&damaged, 1 << 20);
                assert!(found.is_err() || found.is_ok_and(|(plain, _)| plain == bytes), "{cut}");
            }
            let longer = [&stream[..], b"x"].concat();
            assert_eq!(inflate(&longer, usize::MAX).unwrap().1, stream.len());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

        #[test]
        fn any_bytes_come_back(bytes in prop::collection::vec(0u8..4, 0..3000), noise: Vec<u8>) {
            expect_all_agree(&bytes);
            expect_all_agree(&noise);
        }

        #[test]
        fn any_bytes_are_read_without_a_panic(mut noise: Vec<u8>) {
            let _ = inflate(&noise, 1 << 16);
            noise.splice(0..0, [0x78, 0x01]);
            let _ = inflate(&noise, 1 << 16);
        }
    }
}
