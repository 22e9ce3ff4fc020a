//! zlib, and zlib and deflate in blocks on all cores.
//!
//! By flate2 with zlib-rs, which is pure Rust and gives the same bytes for the same input and level on every target: its vector
//! instructions only compare and copy.

use std::io::{self, Read, Write};

use flate2::bufread::{ZlibDecoder, ZlibEncoder};
use flate2::{Compress, Compression, Crc, FlushCompress};

use crate::base::error::{Error, Result};
use crate::base::parallel::*;

/// Compresses bytes to one zlib stream, the same for the same input and level, 1 to 9.
///
/// # Errors
/// `io` where zlib fails.
pub fn compress(bytes: &[u8], level: u8) -> Result<Vec<u8>> {
    let mut stream = Vec::new();
    let mut encoder = ZlibEncoder::new(bytes, Compression::new(level.into()));
    encoder.read_to_end(&mut stream).map_err(|error| Error::io("compressing", error))?;
    Ok(stream)
}

/// Expands a zlib stream to at most `most` bytes; a longer one is cut there.
///
/// # Errors
/// What is not a zlib stream, ends early, or has a wrong checksum; bytes after the stream.
pub(crate) fn inflate(stream: &[u8], most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut decoder = ZlibDecoder::new(stream);
    decoder.by_ref().take(most).read_to_end(&mut bytes)?;
    if (bytes.len() as u64) < most && decoder.total_in() < stream.len() as u64 {
        return Err(io::Error::other("there are bytes after its zlib stream"));
    }
    Ok(bytes)
}

/// Splits a stream of bytes into blocks of one size, the last may be shorter, and compresses each by itself.
pub struct Blocks {
    size: usize,
    level: u8,
    /// The beginning of the block that is not full yet.
    pending: Vec<u8>,
}

impl Blocks {
    pub fn new(size: usize, level: u8) -> Blocks {
        Blocks { size, level, pending: Vec::new() }
    }

    /// Adds bytes and returns the blocks that are full now, compressed, in order.
    ///
    /// # Errors
    /// `io` where zlib fails.
    pub fn push(&mut self, bytes: &[u8]) -> Result<Vec<Vec<u8>>> {
        let mut rest = bytes;
        if !self.pending.is_empty() {
            let (head, tail) = bytes.split_at(bytes.len().min(self.size - self.pending.len()));
            self.pending.extend_from_slice(head);
            rest = tail;
        }
        let whole = rest.chunks_exact(self.size);
        let remainder = whole.remainder();
        let full = self.pending.len() == self.size;
        let blocks: Vec<&[u8]> = full.then_some(self.pending.as_slice()).into_iter().chain(whole).collect();
        let level = self.level;
        let done: Result<_> = on_all_cores(|| blocks.into_par_iter().map(|block| compress(block, level)).collect());
        let done = done?;
        if full {
            self.pending.clear();
        }
        self.pending.extend_from_slice(remainder);
        Ok(done)
    }

    /// Compresses what is left, if anything.
    ///
    /// # Errors
    /// `io` where zlib fails.
    pub fn finish(self) -> Result<Option<Vec<u8>>> {
        (!self.pending.is_empty()).then(|| compress(&self.pending, self.level)).transpose()
    }
}

/// Bytes that are deflated by themselves. 433 MB of fractions took 1e-5 more than in one piece.
const BLOCK: usize = 1 << 18;
/// Such blocks that a core gets at a time.
const OF_CORE: usize = 4;
/// Ends a stream: an empty block, the last one.
const LAST: [u8; 2] = [3, 0];

/// Deflates what is written, in blocks on all cores, to one stream without a head, as archives and gzip have it. Its bytes do not depend on how they arrive, nor on
/// the number of cores.
pub struct Deflate<W> {
    out: W,
    level: u8,
    /// What is not deflated yet.
    waiting: Vec<u8>,
    most: usize,
    crc: Crc,
    n_bytes: u64,
}

impl<W: Write> Deflate<W> {
    /// Begins a stream at a level of 1 to 9.
    pub fn new(out: W, level: u8) -> Deflate<W> {
        let most = BLOCK * if HAS_THREADS { OF_CORE * current_num_threads() } else { 1 };
        Deflate { out, level, waiting: Vec::new(), most, crc: Crc::new(), n_bytes: 0 }
    }

    fn pack(&mut self) -> io::Result<()> {
        let Deflate { waiting, level, .. } = self;
        let deflated: Vec<_> = on_all_cores(|| waiting.par_chunks(BLOCK).map(|block| deflate(block, *level)).collect());
        for block in deflated {
            let (bytes, crc) = block?;
            self.out.write_all(&bytes)?;
            self.crc.combine(&crc);
        }
        self.n_bytes += self.waiting.len() as u64;
        self.waiting.clear();
        Ok(())
    }

    /// Ends the stream; returns what it was written to, the checksum CRC-32 of the bytes as they were, and their number.
    ///
    /// # Errors
    /// Those of what it writes to.
    pub fn finish(mut self) -> io::Result<(W, u32, u64)> {
        self.pack()?;
        self.out.write_all(&LAST)?;
        Ok((self.out, self.crc.sum(), self.n_bytes))
    }
}

impl<W: Write> Write for Deflate<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = bytes.len().min(self.most - self.waiting.len());
        self.waiting.extend_from_slice(&bytes[..n]);
        if self.waiting.len() == self.most {
            self.pack()?;
        }
        Ok(n)
    }

    /// Hands nothing over: blocks have their length.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A block of a stream up to a whole byte, which others may follow, and its checksum.
fn deflate(block: &[u8], level: u8) -> io::Result<(Vec<u8>, Crc)> {
    let mut crc = Crc::new();
    crc.update(block);
    let mut stream = Compress::new(Compression::new(level.into()), false);
    let mut bytes = Vec::with_capacity(block.len() / 2);
    loop {
        stream.compress_vec(&block[stream.total_in() as usize..], &mut bytes, FlushCompress::Sync)?;
        if stream.total_in() == block.len() as u64 && bytes.len() < bytes.capacity() {
            return Ok((bytes, crc));
        }
        bytes.reserve(block.len() / 2 + 64);
    }
}

#[cfg(test)]
mod tests {
    use flate2::read::DeflateDecoder;

    use super::*;

    #[test]
    fn deflated_bytes_do_not_depend_on_how_they_arrive_nor_on_the_cores() {
        let mut state = 1_u32;
        let mut bytes: Vec<u8> = (0..9 * BLOCK + 1000).map(|at| (at / 700) as u8).collect();
        // a block that does not shrink
        for byte in &mut bytes[..BLOCK] {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *byte = (state >> 24) as u8;
        }
        for n in [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, bytes.len()] {
            for level in 1..=9 {
                let stream = |step: usize| {
                    let mut deflate = Deflate::new(Vec::new(), level);
                    bytes[..n].chunks(step).for_each(|some| deflate.write_all(some).unwrap());
                    deflate.finish().unwrap()
                };
                let (whole, crc, n_bytes) = stream(usize::MAX);
                let mut expected = Crc::new();
                expected.update(&bytes[..n]);
                assert_eq!((crc, n_bytes), (expected.sum(), n as u64));
                let mut found = Vec::new();
                let mut decoder = DeflateDecoder::new(&whole[..]);
                decoder.read_to_end(&mut found).unwrap();
                assert!(found == bytes[..n], "{n} bytes at level {level}");
                assert_eq!(decoder.total_in(), whole.len() as u64);
                for n_threads in [1, 3] {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
                    assert!(pool.install(|| stream(1000 + BLOCK / 3)).0 == whole, "{n} bytes at level {level}");
                }
            }
        }
    }

    #[test]
    fn blocks_do_not_depend_on_how_the_bytes_arrive() {
        let bytes: Vec<u8> = (0..1000u32).map(|i| (i * i / 7) as u8).collect();
        for step in [1, 3, 99, 100, 101, 250, 1000] {
            let mut blocks = Blocks::new(100, 1);
            let mut done: Vec<Vec<u8>> =
                bytes[..950].chunks(step).flat_map(|part| blocks.push(part).unwrap()).collect();
            done.extend(blocks.finish().unwrap());
            assert_eq!(done.len(), 10, "parts of {step}");
            for (block, expected) in done.iter().zip(bytes[..950].chunks(100)) {
                assert_eq!(inflate(block, u64::MAX).unwrap(), expected, "parts of {step}");
            }
        }
    }

    #[test]
    fn a_stream_is_expanded_as_far_as_allowed() {
        let bytes: Vec<u8> = (0..200_000u32).map(|i| (i / 700) as u8).collect();
        for level in 1..=9 {
            let stream = compress(&bytes, level).unwrap();
            assert!(stream.len() < 10_000, "level {level}: {} bytes", stream.len());
            for most in [0, 1, 199_999, 200_000, 200_001, u64::MAX] {
                let n_expected = bytes.len().min(most as usize);
                assert_eq!(inflate(&stream, most).unwrap(), bytes[..n_expected], "level {level}, at most {most}");
            }
        }
    }

    #[test]
    fn what_is_not_one_whole_stream_is_refused() {
        let stream = compress(b"flags, flags, flags", 6).unwrap();
        let mut damaged = stream.clone();
        damaged[stream.len() - 1] ^= 1;
        let cases = [&stream[..stream.len() - 1], &stream[..7], &[], &damaged, &[&stream[..], b"x"].concat()];
        for (index, case) in cases.into_iter().enumerate() {
            assert!(inflate(case, 100).is_err(), "case {index}");
        }
    }
}
