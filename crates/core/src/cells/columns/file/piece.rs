//! A piece of a column file: some consecutive rays.

use super::{u32_at, u64_at};
use crate::base::checksum::crc32;
use crate::base::error::Result;
use crate::base::zlib;
use crate::cells::columns::codec::{self, PIECE_RAYS, PIECE_RUNS, PieceEncoder};
use crate::cells::columns::run::Band;

/// Bytes of the head of a piece.
pub const PIECE_HEAD: usize = 44;
const PIECE_TAG: [u8; 4] = *b"PIEC";
const BAND_TAG: [u8; 4] = *b"BAND";

/// The head of a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PieceHead {
    pub(crate) n_rays: u32,
    pub(crate) n_runs: u32,
    pub(crate) n_content: u32,
    pub(crate) n_stored: u32,
    /// Of the stored bytes.
    pub(crate) crc: [u8; 4],
    /// Odd rays and crossings.
    pub(crate) counts: [u64; 2],
    pub(crate) ends_band: bool,
}

impl PieceHead {
    pub(crate) fn to_bytes(self) -> Vec<u8> {
        let mut head = if self.ends_band { BAND_TAG } else { PIECE_TAG }.to_vec();
        let numbers = [self.n_rays, self.n_runs, self.n_content, self.n_stored];
        numbers.iter().for_each(|number| head.extend(number.to_le_bytes()));
        head.extend(self.crc);
        self.counts.iter().for_each(|count| head.extend(count.to_le_bytes()));
        head.extend(crc32(&head));
        head
    }

    /// Decodes the bytes before the checksum; None where their tag is not that of a piece.
    pub(crate) fn from_bytes(head: &[u8]) -> Option<PieceHead> {
        let [n_rays, n_runs, n_content, n_stored] = [4, 8, 12, 16].map(|at| u32_at(head, at));
        let crc = u32_at(head, 20).to_le_bytes();
        let counts = [24, 32].map(|at| u64_at(head, at));
        let ends_band = head[..4] == BAND_TAG;
        let is_piece = ends_band || head[..4] == PIECE_TAG;
        is_piece.then_some(PieceHead { n_rays, n_runs, n_content, n_stored, crc, counts, ends_band })
    }

    /// Decodes a head with its checksum; None where the tag or the checksum is wrong.
    pub(crate) fn from_checked_bytes(head: &[u8; PIECE_HEAD]) -> Option<PieceHead> {
        let (head, crc) = head.split_at(PIECE_HEAD - 4);
        PieceHead::from_bytes(head).filter(|_| crc == crc32(head))
    }

    /// Whether a piece of rays of `depth` cells may have these numbers where `rays_left` rays are missing.
    pub(crate) fn is_sound(&self, rays_left: u64, depth: u32) -> bool {
        (1..=PIECE_RAYS).contains(&self.n_rays)
            && u64::from(self.n_rays) <= rays_left
            && (self.n_runs <= PIECE_RUNS || self.n_rays == 1)
            && u64::from(self.n_runs) <= u64::from(self.n_rays) * u64::from(depth)
    }

    /// Most bytes that its rays and runs can need: five a number and one a flag.
    pub(crate) fn most_content(&self) -> u64 {
        5 * u64::from(self.n_rays) + 6 * u64::from(self.n_runs)
    }

    /// Whether the stored bytes can be as many as they are said to be; zlib adds five bytes to 16 kB that it cannot shrink.
    pub(crate) fn stores_no_more_than_needed(&self) -> bool {
        u64::from(self.n_stored) <= self.most_content() + self.most_content() / 1000 + 64
    }

    /// Decodes stored bytes whose checksum was right; says what is wrong with them otherwise.
    pub(crate) fn decode(&self, stored: &[u8], zlib: bool, depth: u32) -> std::result::Result<Band, String> {
        let inflated;
        let content = if zlib {
            let limit = self.most_content().min(u64::from(self.n_content)) + 1;
            inflated = zlib::inflate(stored, limit).map_err(|error| error.to_string())?;
            &inflated
        } else {
            stored
        };
        if content.len() != self.n_content as usize {
            return Err(format!("its content has {} bytes, its head says {}", content.len(), self.n_content));
        }
        let [odd_rays, n_crossings] = self.counts;
        let band = codec::decode(content, self.n_rays, self.n_runs, depth)?;
        Ok(Band { odd_rays, n_crossings, ..band })
    }
}

/// The bytes of a piece of `n_rays` rays; `counts` are those of the band that it ends.
///
/// # Errors
/// `io` where zlib fails.
pub fn encode(n_rays: u32, encoder: PieceEncoder, level: Option<u8>, counts: Option<[u64; 2]>) -> Result<Vec<u8>> {
    let (n_runs, content) = encoder.finish();
    let n_content = content.len() as u32;
    let stored = match level {
        None => content,
        Some(level) => zlib::compress(&content, level)?,
    };
    let (n_stored, crc) = (stored.len() as u32, crc32(&stored));
    let (ends_band, counts) = (counts.is_some(), counts.unwrap_or_default());
    let head = PieceHead { n_rays, n_runs, n_content, n_stored, crc, counts, ends_band };
    Ok([head.to_bytes(), stored].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::columns::run;

    #[test]
    fn numbers_that_no_piece_has_are_refused() {
        let head = |n_rays, n_runs, n_stored| {
            let (n_content, crc, counts) = (0, [0; 4], [0; 2]);
            PieceHead { n_rays, n_runs, n_content, n_stored, crc, counts, ends_band: false }
        };
        let is_sound = |n_rays, n_runs, left, depth| head(n_rays, n_runs, 0).is_sound(left, depth);
        assert!(is_sound(1, 0, 1, 1) && is_sound(3, 30, 3, 10) && is_sound(PIECE_RAYS, PIECE_RUNS, u64::MAX, 4));
        // no ray, more rays than are left or than a piece has, more runs than cells
        assert!(!is_sound(0, 0, 9, 9) && !is_sound(4, 1, 3, 9) && !is_sound(PIECE_RAYS + 1, 1, u64::MAX, 9));
        assert!(!is_sound(3, 31, 3, 10));
        // more runs than a piece of several rays has; one ray may have them
        assert!(!is_sound(2, PIECE_RUNS + 1, 2, PIECE_RUNS) && is_sound(1, PIECE_RUNS + 1, 2, PIECE_RUNS + 1));
        // 3 rays and 200 runs: at most 1215 bytes, and what zlib may add
        let fits = |n_stored| head(3, 200, n_stored).stores_no_more_than_needed();
        assert!(fits(1215 + 1 + 64) && !fits(1215 + 1 + 65));
        // one ray and 10^7 runs: a thousandth more
        let fits = |n_stored| head(1, 10_000_000, n_stored).stores_no_more_than_needed();
        assert!(fits(60_000_005 + 60_000 + 64) && !fits(60_000_005 + 60_000 + 65));
    }

    #[test]
    fn contents_of_another_length_than_the_head_says_are_refused() {
        for level in [None, Some(6)] {
            let mut encoder = PieceEncoder::default();
            encoder.push(&[run(1, 7), run(4, 0)]);
            encoder.push(&[]);
            let bytes = encode(2, encoder, level, None).unwrap();
            let head = PieceHead::from_bytes(&bytes).unwrap();
            // two numbers of runs, two cells, two flags
            assert_eq!((head.n_content, head.ends_band, head.counts), (6, false, [0, 0]));
            let decoded = |n_content| PieceHead { n_content, ..head }.decode(&bytes[PIECE_HEAD..], level.is_some(), 10);
            assert_eq!(decoded(6).map(|band| band.runs), Ok(vec![run(1, 7), run(4, 0)]));
            for n_content in [5, 7] {
                let sentence = format!("its content has 6 bytes, its head says {n_content}");
                assert_eq!(decoded(n_content), Err(sentence));
            }
        }
    }

    #[test]
    fn heads_read_back_and_damage_shows() {
        for ends_band in [false, true] {
            let (n_rays, n_runs, crc, counts) = (3, 9, [1, 2, 3, 4], [1, 1 << 33]);
            let piece = PieceHead { n_rays, n_runs, n_content: 77, n_stored: 70, crc, counts, ends_band };
            let head: [u8; PIECE_HEAD] = piece.to_bytes().try_into().unwrap();
            assert_eq!(PieceHead::from_checked_bytes(&head), Some(piece));
            for byte in 0..PIECE_HEAD {
                let mut head = head;
                head[byte] ^= 4;
                assert!(PieceHead::from_checked_bytes(&head).is_none(), "byte {byte}");
            }
        }
    }
}
