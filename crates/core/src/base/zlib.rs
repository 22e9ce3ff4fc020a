//! zlib, and zlib in blocks on all cores.
//!
//! By flate2 with zlib-rs, which is pure Rust and gives the same bytes for the same input and level on every target: its vector
//! instructions only compare and copy.

use std::io::{self, Read};

use flate2::Compression;
use flate2::bufread::{ZlibDecoder, ZlibEncoder};

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

#[cfg(test)]
mod tests {
    use super::*;

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
