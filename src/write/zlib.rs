//! zlib in blocks, on all cores.

use std::io::Read;

use crate::parallel::*;
use flate2::Compression;
use flate2::read::ZlibEncoder;

use crate::error::{Error, Result};

/// Compresses bytes to one zlib stream, the same for the same input and level.
///
/// # Errors
/// `io` if the compressor fails, which memory alone can bring about.
pub(crate) fn compress(bytes: &[u8], level: u8) -> Result<Vec<u8>> {
    let mut out = Vec::with_capacity(bytes.len() / 64);
    let mut encoder = ZlibEncoder::new(bytes, Compression::new(level.into()));
    encoder.read_to_end(&mut out).map_err(|error| Error::io("compressing", error))?;
    Ok(out)
}

/// Cuts a stream of bytes in blocks of one size, the last may be shorter, and compresses each by itself.
pub(crate) struct Blocks {
    size: usize,
    level: u8,
    /// The beginning of a block whose end has not come yet.
    pending: Vec<u8>,
}

impl Blocks {
    pub(crate) fn new(size: usize, level: u8) -> Blocks {
        Blocks { size, level, pending: Vec::new() }
    }

    /// Adds bytes and returns the blocks that are full now, compressed, in order.
    ///
    /// # Errors
    /// `io` if the compressor fails.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Result<Vec<Vec<u8>>> {
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
        let done = blocks.into_par_iter().map(|block| compress(block, self.level)).collect::<Result<Vec<_>>>()?;
        if full {
            self.pending.clear();
        }
        self.pending.extend_from_slice(remainder);
        Ok(done)
    }

    /// Compresses what is left, if anything.
    ///
    /// # Errors
    /// `io` if the compressor fails.
    pub(crate) fn finish(self) -> Result<Option<Vec<u8>>> {
        if self.pending.is_empty() { Ok(None) } else { compress(&self.pending, self.level).map(Some) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::ZlibDecoder;

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
                let mut plain = Vec::new();
                ZlibDecoder::new(block.as_slice()).read_to_end(&mut plain).unwrap();
                assert_eq!(plain, expected, "parts of {step}");
            }
        }
    }
}
