//! zlib in blocks, on all cores.
//!
//! The compressor is our own: small enough for a page to load, the same bytes natively and in the browser, and made for flags.

use crate::parallel::*;

mod deflate;
mod huffman;
#[cfg(any(target_arch = "wasm32", test))]
mod inflate;
mod matches;

/// Compresses bytes to one zlib stream, the same for the same input and level, 1 to 9.
pub(crate) fn compress(bytes: &[u8], level: u8) -> Vec<u8> {
    deflate::deflate(bytes, level)
}

/// Expands a zlib stream to at most `most` bytes; returns them and the length of the stream, another where it goes on.
#[cfg(target_arch = "wasm32")]
pub(crate) fn expand(stream: &[u8], most: u64) -> Result<(Vec<u8>, u64), String> {
    let (bytes, used) = inflate::inflate(stream, most as usize)?;
    Ok((bytes, used as u64))
}

/// Expands a zlib stream to at most `most` bytes; returns them and the length of the stream, another where it goes on.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn expand(stream: &[u8], most: u64) -> Result<(Vec<u8>, u64), String> {
    use std::io::Read;

    let mut bytes = Vec::new();
    let mut decoder = flate2::read::ZlibDecoder::new(stream);
    decoder.by_ref().take(most).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    Ok((bytes, decoder.total_in()))
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
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
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
        let done = blocks.into_par_iter().map(|block| compress(block, self.level)).collect();
        if full {
            self.pending.clear();
        }
        self.pending.extend_from_slice(remainder);
        done
    }

    /// Compresses what is left, if anything.
    pub(crate) fn finish(self) -> Option<Vec<u8>> {
        (!self.pending.is_empty()).then(|| compress(&self.pending, self.level))
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
            let mut done: Vec<Vec<u8>> = bytes[..950].chunks(step).flat_map(|part| blocks.push(part)).collect();
            done.extend(blocks.finish());
            assert_eq!(done.len(), 10, "parts of {step}");
            for (block, expected) in done.iter().zip(bytes[..950].chunks(100)) {
                let (plain, used) = expand(block, u64::MAX).unwrap();
                assert_eq!((plain.as_slice(), used), (expected, block.len() as u64), "parts of {step}");
            }
        }
    }
}
