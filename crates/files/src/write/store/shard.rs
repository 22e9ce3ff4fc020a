//! The bytes of a shard: its chunks, then their places in it, and a checksum of these.
//!
//! A chunk without any flag is left out; one of a single flag is compressed once for all shards. Source: the sharding codec of Zarr v3, ZEP 2.

use std::io::Read;
use std::sync::OnceLock;

use flate2::Compression;
use flate2::read::GzEncoder;

use crate::write::Compress;
use hexcast_core::base::error::{Error, Result};

/// The polynomial of CRC-32C, its lowest power in the highest bit.
const CRC_32C: u32 = 0x82f6_3b78;
/// The place of a chunk that is left out.
pub(crate) const NOWHERE: [u8; 16] = [0xff; 16];

/// What one chunk or a row of them is made of.
pub(super) struct Row<'a> {
    /// All numbers of its cells, x fastest.
    pub(super) bytes: &'a [u8],
    /// Cells on x, y, z, which may be fewer than those of its chunks.
    pub(super) dims: [usize; 3],
}

/// How the chunks of a store are stored.
pub(super) struct Chunks {
    /// Cells of a chunk on x, y, z.
    shape: [usize; 3],
    /// Bytes of a number.
    n_bytes: usize,
    compress: Compress,
    /// The chunk of each flag alone, once there was one.
    of_one_flag: Vec<OnceLock<Vec<u8>>>,
}

/// A shard while it is made, chunk after chunk.
#[derive(Default)]
pub(super) struct Shard {
    /// Bytes so far.
    at: u64,
    places: Vec<u8>,
}

impl Shard {
    /// The bytes of the next chunks; None is one that is left out.
    pub(super) fn put<C: AsRef<[u8]>>(&mut self, chunks: &[Option<C>]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for chunk in chunks {
            let Some(chunk) = chunk.as_ref().map(AsRef::as_ref) else {
                self.places.extend(NOWHERE);
                continue;
            };
            self.places.extend([self.at, chunk.len() as u64].into_iter().flat_map(u64::to_le_bytes));
            self.at += chunk.len() as u64;
            bytes.extend(chunk);
        }
        bytes
    }

    /// The last bytes.
    pub(super) fn end(mut self) -> Vec<u8> {
        let checksum = checksum(&self.places);
        self.places.extend(checksum);
        self.places
    }
}

impl Chunks {
    pub(super) fn new(shape: [u32; 3], n_bytes: usize, compress: Compress) -> Chunks {
        let of_one_flag = vec![OnceLock::new(); 256];
        Chunks { shape: shape.map(|n| n as usize), n_bytes, compress, of_one_flag }
    }

    /// A whole chunk of cells of one flag; None for background.
    pub(super) fn of_one_flag(&self, flag: u8) -> Result<Option<&[u8]>> {
        if flag == 0 {
            return Ok(None);
        }
        let known = &self.of_one_flag[usize::from(flag)];
        if let Some(chunk) = known.get() {
            return Ok(Some(chunk));
        }
        let chunk = self.compressed(vec![flag; self.shape.iter().product()])?;
        Ok(Some(known.get_or_init(|| chunk)))
    }

    /// A chunk of a row; None where all its numbers are 0.
    pub(super) fn encoded(&self, row: &Row, number: usize) -> Result<Option<Vec<u8>>> {
        let ([cx, cy, cz], [nx, ny, nz], n_bytes) = (self.shape, row.dims, self.n_bytes);
        let first = number * cx;
        if first >= nx {
            return Ok(None);
        }
        let length = cx.min(nx - first) * n_bytes;
        let mut chunk = vec![0; cx * cy * cz * n_bytes];
        for (index, from) in row.bytes.chunks_exact(nx * n_bytes).take(ny * nz).enumerate() {
            let to = (index / ny * cy + index % ny) * cx * n_bytes;
            chunk[to..to + length].copy_from_slice(&from[first * n_bytes..first * n_bytes + length]);
        }
        if chunk.iter().all(|byte| *byte == 0) {
            return Ok(None);
        }
        self.compressed(chunk).map(Some)
    }

    fn compressed(&self, chunk: Vec<u8>) -> Result<Vec<u8>> {
        match self.compress {
            Compress::None => Ok(chunk),
            Compress::Zlib(level) => gzip(level, &chunk),
        }
    }
}

/// The checksum of places, CRC-32C, little-endian; bit by bit, as they are few.
pub(crate) fn checksum(places: &[u8]) -> [u8; 4] {
    let shifted = |crc: u32, _| (crc >> 1) ^ (CRC_32C * (crc & 1));
    let crc = places.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), shifted));
    (!crc).to_le_bytes()
}

/// Compresses by gzip at a level of 1 to 9.
///
/// # Errors
/// `io`.
pub(crate) fn gzip(level: u8, bytes: &[u8]) -> Result<Vec<u8>> {
    let mut out = Vec::with_capacity(bytes.len() / 64);
    let read = GzEncoder::new(bytes, Compression::new(level.into())).read_to_end(&mut out);
    read.map_err(|error| Error::io("compressing a chunk", error))?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::checksum;

    /// Source: RFC 3720, B.4, and the check value of the catalogue of CRCs. Stores that `zarrs` encodes have whole shards.
    #[test]
    fn checksums_are_those_of_the_standard() {
        let rising: Vec<u8> = (0..32).collect();
        let cases: [(&[u8], u32); 5] = [
            (b"", 0),
            (b"123456789", 0xe306_9283),
            (&[0; 32], 0x8a91_36aa),
            (&[0xff; 32], 0x62a8_ab43),
            (&rising, 0x46dd_794e),
        ];
        for (bytes, expected) in cases {
            assert_eq!(checksum(bytes), expected.to_le_bytes(), "{bytes:?}");
        }
    }
}
